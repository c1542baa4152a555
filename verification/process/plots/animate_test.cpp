// Animations of runs: the instants of the frames, positions in a frame, texts as data, and
// refusals.
#include <regex>

#include "plots/film/film.hpp"
#include "plots/film/film_drawing.hpp"
#include "plots/tables/table.hpp"
#include "study/comparison/compare.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/run_files.hpp"

using namespace freeplay;
using namespace freeplay::report;
using Catch::Matchers::Contains;
using test::comparison;

namespace {

/// Centres of the circles of a radius and a colour in a frame, by its text.
std::vector<Vec2> circles(const std::string& svg, const std::string& radius, const std::string& colour) {
  static const std::string number = "([-0-9.]+)";
  const std::regex one("<circle cx=\"" + number + "\" cy=\"" + number + "\" r=\"" + radius + "\" fill=\"" +
                       colour + "\"");
  std::vector<Vec2> list;
  for (std::sregex_iterator it(svg.begin(), svg.end(), one), end; it != end; ++it)
    list.push_back({std::stod((*it)[1]), std::stod((*it)[2])});
  return list;
}

Film film_of(const std::filesystem::path& folder, const std::filesystem::path& place, FilmOptions options) {
  return make_film(folder, place, options, StopToken(), [](double) {});
}

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

}  // namespace

TEST_CASE("frames of an animation are equally spaced in time, both ends included", "[animate]") {
  const test::TemporaryFolder out;
  // 0.25 revolutions at 200 rpm: 0.075 s.
  FilmOptions options{.svg = true, .fps = 20, .speed = 0.01};
  auto film = film_of(comparison(), out.path(), options);
  CHECK(film.frames == 151);  // 7.5 s of film, both ends
  CHECK(files_in(out.path()) == 151);
  CHECK_THAT(test::file_text(out.path() / "frame_000001.svg"), Contains("t = 0.0000 s"));
  CHECK_THAT(test::file_text(out.path() / "frame_000041.svg"),
             Contains("t = 0.0200 s") && Contains("crank 24°"));
  CHECK_THAT(test::file_text(out.path() / "frame_000151.svg"),
             Contains("t = 0.0750 s") && Contains("crank 90°"));
  SECTION("a part of the run, replacing an older animation") {
    options.from = 0.01, options.until = 0.0149, options.speed = 0.02;
    film = film_of(comparison(), out.path(), options);
    CHECK(film.frames == 5);  // 10, 11, 12, 13, 14 ms
    CHECK(files_in(out.path()) == 5);
    CHECK_THAT(test::file_text(out.path() / "frame_000005.svg"), Contains("t = 0.0140 s"));
  }
  SECTION("the default duration is 8 to 20 s") {
    options.speed.reset();
    film = film_of(comparison(), out.path(), options);
    const double length = static_cast<double>(film.frames - 1) / options.fps;
    CHECK(length <= 20);
    CHECK(length >= 7.5);
  }
}

TEST_CASE("a journal's marker in its clearance circle follows the trajectory, linear between rows",
          "[animate]") {
  std::vector<FilmRun> runs;
  for (const auto& run : plots::runs_in(comparison()))
    if (run.title != "ideal joint") runs.push_back(film_run(run, 100'000));
  REQUIRE(runs.size() == 2);
  const bool over = GENERATE(false, true);
  const FilmDrawing drawing(runs, {.title = "t", .width = 960, .over = over});
  CHECK(drawing.height() % 2 == 0);
  const std::vector<std::string> colours{"#0072b2", "#d55e00"};
  for (std::size_t r = 0; r < 2; ++r) {
    plots::Rows rows(comparison() / runs[r].title / "trajectory.csv");
    const auto t = rows.place("t"), ex = rows.place("gudgeon.ex"), ey = rows.place("gudgeon.ey");
    double t_before = 0, x_before = 0, y_before = 0;
    for (int row = 0; rows.next(); ++row) {
      const double now = rows.number(t), x = rows.number(ex) / 0.25e-3, y = rows.number(ey) / 0.25e-3;
      if (row % 61 == 60) {
        CAPTURE(runs[r].title, now);
        for (const bool half : {false, true}) {
          const double at = half ? 0.5 * (t_before + now) : now;
          const auto svg = drawing.frame(at, 0);
          // In a panel of 190 px, of which the circle takes 148: the circle's centre is read from
          // the circle itself.
          const auto ring = circles(svg, "74.00", "none");
          const auto dots = circles(svg, "5.00", colours[r]);
          REQUIRE(ring.size() == 1);
          REQUIRE(dots.size() == 2);  // and the one in the legend
          const double wx = half ? 0.5 * (x_before + x) : x, wy = half ? 0.5 * (y_before + y) : y;
          CHECK(dots[0].x() - ring[0].x() ==
                Approx(74 * wx).margin(0.02));  // 0.005 each from two decimals, and 7 digits
          CHECK(ring[0].y() - dots[0].y() == Approx(74 * wy).margin(0.02));
        }
      }
      t_before = now, x_before = x, y_before = y;
    }
  }
}

TEST_CASE("bodies are drawn at their recorded poses: the rod from the crank pin to the slider", "[animate]") {
  std::vector<FilmRun> runs{film_run(plots::runs_in(comparison() / "nonsmooth").front(), 100'000)};
  const FilmDrawing drawing(runs, {.title = "t"});
  const double t = 0.03, phi = t * 200 * 2 * M_PI / 60;
  const auto pin = drawing.place(0, {0.05 * std::cos(phi), 0.05 * std::sin(phi)}),
             origin = drawing.place(0, {0, 0});
  const auto svg = drawing.frame(t, 0);
  // A polyline of the crank's colour from the main bearing to the crank pin.
  const auto near = [&](const Vec2& p, double x, double y) {
    return std::hypot(p.x() - x, p.y() - y) < 0.05;
  };
  const std::regex link(
      "<polyline points=\"([-0-9.]+),([-0-9.]+) ([-0-9.]+),([-0-9.]+)\" fill=\"none\" "
      "stroke=\"#0072b2\" stroke-width=\"5\"");
  std::smatch found;
  REQUIRE(std::regex_search(svg, found, link));
  const Vec2 corner{origin.x() - 0, origin.y() - 34};  // the panel's corner is (0, 34)
  CHECK(near(corner, std::stod(found[1]), std::stod(found[2])));
  CHECK(near({pin.x(), pin.y() - 34}, std::stod(found[3]), std::stod(found[4])));
}

TEST_CASE("texts of a run are escaped in a frame", "[animate][security]") {
  FilmRun run;
  run.title = "a<b>&\"'\x1b[31m";
  run.t = {0, 1};
  run.bodies = {"</svg><script>alert(1)</script>"};
  run.poses = {{0, 1}, {0, 0}, {0, 0}};
  run.shapes = {{"mass", run.bodies[0], 0, -1, {{0, 0}}, {0, 0}}};
  run.crank = {-1, -1};
  const std::vector<FilmRun> runs{run};
  const auto svg = FilmDrawing(runs, {.title = "<image href=\"http://x/\"/>"}).frame(0.5, 0.1);
  CHECK_THAT(svg,
             !Contains("<script") && !Contains("<image") && !Contains("\x1b") && Contains("&lt;b&gt;&amp;"));
  CHECK(test::count(svg, "<svg") == test::count(svg, "</svg>"));
}

TEST_CASE("a run that cannot be animated is refused, and an older animation is kept", "[animate]") {
  const test::TemporaryFolder out;
  const FilmOptions options{.svg = true, .speed = 0.1};
  REQUIRE(film_of(comparison(), out.path(), options).frames > 0);
  const auto before = test::file_text(out.path() / "frame_000001.svg");
  const test::TemporaryFolder none;
  const auto folder = comparison().string();
  for (const auto& [words, why] :
       {std::pair(std::string("nowhere"), "is not a folder"),
        {none.path().string(), "contains no run"},
        {folder + " --svg --from 1", "--from 1: is outside the run, from 0 to 0.075 s"},
        {folder + " --svg --until 0.076", "--until 0.076: is outside the run, from 0 to 0.075 s"},
        {folder + " --svg --from 0.05 --until 0.02", "must be later than --from"},
        {folder + " --svg --speed 1e-6", "frames, more than 20000"},
        {folder + " --svg --speed 0", "greater than 0"},
        {folder + " --svg --fps 1000", "from 1 to 120"},
        {folder + " --svg --width 100", "480"}}) {
    test::refused(fmt::format("animate {} -o {}", words, out.path().string()), Contains(why));
    CHECK(test::file_text(out.path() / "frame_000001.svg") == before);
  }
}
