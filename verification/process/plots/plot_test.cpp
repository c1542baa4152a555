// Columns of result folders as figures: rows, names, units; and the figures of joints with
// clearance.
#include "dynamics/planar.hpp"
#include "io/files/child.hpp"
#include "io/files/csv.hpp"
#include "plots/drawing/column_plot.hpp"
#include "plots/drawing/column_title.hpp"
#include "plots/figures/signals.hpp"
#include "plots/tables/clearance_joints.hpp"
#include "simulation/table_rows.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

void write_run(const std::filesystem::path& folder, const std::string& scene, double duration) {
  make_folder(folder);
  write_file(folder / "run.json",
             nlohmann::json{{"formulation", "penalty"},
                            {"provenance",
                             {{"version", "0"},
                              {"commit", "none"},
                              {"scene_file", "scene.toml"},
                              {"scene", scene},
                              {"overrides", nlohmann::json::array()},
                              {"options", {{"run", {{"duration", duration}, {"discard", 0.0}}}}}}}}
                 .dump());
}

const std::string crank_scene = test::body("b", 1.0, 1.0) + test::pin("p", "ground", "b") +
                                test::motor("m", "p", 3.14159265358979) + test::run_for(4.0);

/// b.x = t, b.y = t² at every quarter of a second, forces b.ax = 10 t at every half.
void write_known(const std::filesystem::path& folder) {
  write_run(folder, crank_scene, 4);
  std::string trajectory = "t,b.x,b.y,b.theta,b.vx,b.vy,b.omega\n", forces = "t,p.fx,p.fx_mean,b.ax\n";
  for (int i = 0; i <= 16; ++i) {
    const double t = 0.25 * i;
    trajectory += fmt::format("{},{},{},0,0,0,0\n", t, t, t * t);
    if (i % 2 == 0) forces += fmt::format("{},1,{},{}\n", t, i == 0 ? "" : "2", 10 * t);
  }
  write_file(folder / "trajectory.csv", trajectory);
  write_file(folder / "forces.csv", forces);
  write_file(folder / "events.csv",
             "t,joint,kind,crank_angle,v_n_minus,v_n_plus,v_t_minus,v_t_plus,impulse_n,impulse_t,duration,"
             "t_uncertainty\n"
             "0.1,p,impact,0.3,-1,0.5,0,0,3,0,0,0\n0.1,q,impact,0.3,-2,0.5,0,0,4,0,0,0\n"
             "0.7,p,impact,2.2,-1,0,0,0,5,0,0,0\n");
}

}  // namespace

TEST_CASE("columns are selected by name, joined by time, and cut", "[figures][plot]") {
  test::TemporaryFolder folder;
  const auto& place = folder.path();
  write_known(place);
  const plots::RunColumns columns(place);
  const auto read = [&](const char* x, const char* y, double from, double to,
                        std::optional<plots::Crossing> section = {}) {
    REQUIRE(columns.find(x));
    REQUIRE(columns.find(y));
    return columns.read(*columns.find(x), *columns.find(y), from, to, section);
  };
  const auto parabola = read("b.x", "b.y", 0.5, 2);
  REQUIRE(parabola.x == std::vector{0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0});
  for (std::size_t i = 0; i < parabola.x.size(); ++i) CHECK(parabola.y[i] == parabola.x[i] * parabola.x[i]);
  // From two files the rows at the same time: every half second.
  const auto both = read("b.y", "b.ax", -INFINITY, INFINITY);
  REQUIRE(both.x.size() == 9);
  CHECK(both.x[3] == 2.25);
  CHECK(both.y[3] == 15);
  // the first row's mean is over no time
  CHECK(read("t", "p.fx_mean", -INFINITY, INFINITY).x.size() == 8);
  // Two simultaneous events, neither lost nor mixed up.
  const auto events = read("v_n_minus", "impulse_n", -INFINITY, INFINITY);
  CHECK(events.x == std::vector{-1.0, -2.0, -1.0});
  CHECK(events.y == std::vector{3.0, 4.0, 5.0});
  CHECK(read("crank_angle", "impulse_n", -INFINITY, INFINITY).x[2] == Approx(0.7 * std::numbers::pi));
  // x passes 1.1 between 1 and 1.25: on the straight line between 1 and 1.5625 at 0.4 of it.
  const auto section = read("b.x", "b.y", -INFINITY, INFINITY, plots::crossing_of("b.x=1.1:up"));
  REQUIRE(section.x.size() == 1);
  CHECK(section.x[0] == Approx(1.1));
  CHECK(section.y[0] == Approx(1 + 0.4 * 0.5625));
  CHECK(read("b.x", "b.y", -INFINITY, INFINITY, plots::crossing_of("b.x=1.1:down")).x.empty());
  // Half a revolution a second: at 90° after half a second, and then every two.
  const auto crank = read("t", "b.y", -INFINITY, INFINITY, plots::crossing_of("crank=90"));
  REQUIRE(crank.x.size() == 2);
  CHECK(crank.x[0] == Approx(0.5).epsilon(1e-9));
  CHECK(crank.x[1] == Approx(2.5).epsilon(1e-9));

  CHECK_THROWS_WITH(read("v_n_minus", "b.x", -INFINITY, INFINITY), Contains("no rows in common"));
  CHECK_THROWS_WITH(plots::crossing_of("b.x"), Contains("must be COLUMN=VALUE"));
  CHECK_THROWS_WITH(plots::crossing_of("b.x=nan"), Contains("must be COLUMN=VALUE"));
  CHECK_THROWS_WITH(read("t", "b.y", 0, 1, plots::crossing_of("b.z=1")), Contains("unknown column b.z"));
}

TEST_CASE("axes of several columns or an expression are titled by their quantity", "[figures][plot]") {
  const auto title = [](const std::vector<std::string>& names, const char* unit) {
    std::vector<plots::Column> all;
    for (const char* name : {"p.fx", "p.fn", "p.fy", "b.x", "b.ex", "b.ey"})
      all.push_back(
          {name, "", "", std::string(plots::unit_of_column(name)), plots::quantity_of_column(name)});
    std::vector<plots::ColumnFormula> formulas;
    for (const auto& name : names) formulas.push_back(plots::formula_of(name, all));
    return plots::title_of(formulas, unit).label(60).text();
  };
  CHECK(title({"p.fx", "p.fn"}, "N") == "'force'.' '.\"(N)\"");
  CHECK_THAT(title({"b.x", "b.ex"}, "µm"), Contains("'length'"));
  CHECK_THAT(title({"hypot(p.fx, p.fy)"}, "N"), Contains("\"p:\"") && Contains("'force |F|'"));
  // The components of two elements are no vector.
  CHECK_THAT(title({"hypot(b.ex, b.x)"}, "m"), Contains("hypot(b.ex, b.x)"));
  CHECK_THAT(title({"p.fx*b.x"}, "N m"), Contains("p.fx \\302\\267 b.x"));
  CHECK_THAT(plots::title_of_column("C.ex_c", "").label(60).text(), Contains("'eccentricity e_x/c'"));
  CHECK_THAT(plots::title_of_column("approach", "m/s").label(60).text(), Contains("approach speed"));
}

TEST_CASE("freeplay plot draws the requested columns and lists the available ones", "[figures][plot]") {
  test::TemporaryFolder folder;
  const auto one = folder.path() / "one", two = folder.path() / "two";
  write_known(one);
  write_known(two);
  const auto run = [](const std::string& words) { return test::freeplay("plot " + words); };
  const auto o = run(
      fmt::format("{} {} --x b.x --y b.y,b.ax --y p.fx --from 1 --to 3 -o mine", one.string(), two.string()));
  INFO(o.err);
  REQUIRE(o.status == 0);
  CHECK_THAT(o.out, Contains("one/figures/mine.pdf"));
  // b.y (m) and b.ax (m/s²) separately, p.fx alone: three panels of two runs.
  const auto script = test::file_text(one / "figures/mine.gp");
  CHECK(test::count(script, "\nplot ") == 3);
  CHECK_THAT(script, Contains("set xlabel \"b:\".' '.'position x'.' '.\"(m)\"") &&
                         Contains("set ylabel \"b:\".' '.'position y'") &&
                         Contains("set ylabel \"p:\".' '.'force F_x'") && Contains("title \"one\"") &&
                         Contains("title \"two\""));
  // The three panels show the same runs: one key names them.
  CHECK(test::count(script, "title \"one\"") == 1);
  const auto data = test::data_blocks(one / "figures/mine.dat");
  REQUIRE(data.size() == 6);
  REQUIRE(data[0].size() == 9);
  CHECK(data[0][1] == std::vector{1.25, 1.5625});
  CHECK(data[0] == data[1]);
  REQUIRE(data[4].size() == 5);
  CHECK(data[4][0] == std::vector{1.0, 1.0});
  CHECK_FALSE(std::filesystem::exists(two / "figures"));

  const auto refused = [&](const std::string& words, const std::string& what) {
    const auto end = test::refused("plot " + one.string() + " " + words, Contains(what));
    for (const auto& line : test::lines_of(end.err)) CHECK(line.size() <= 80 + folder.path().string().size());
  };
  for (const auto& [words, what] :
       {std::pair("--y b.z", "unknown column b.z; did you mean b.x?"),
        {"--y b.z", "events.csv: v_n_minus v_n_plus"},
        {"--x ta --y b.x", "unknown column ta; did you mean t?"},
        {"--y b.x --from 3 --to 1", "--from 3 must be less than --to 1"},
        {"--y b.x --from 100", "no row within that time"},
        {"--y b.x --format jpg", "\"jpg\" is not a format"},
        {"--y b.x -o ../mine", "must be a file name of"},
        {"--y b.x --section b.x=9", "no row crosses the section"},
        {"--y b.x --y b.y --y p.fx --y b.theta --y b.vx --y b.omega --y b.ax", "at most 6"}})
    refused(words, what);
  CHECK(run(folder.path().string() + " --y b.x").status == 2);

  // A file with a header alone, as events.csv of a run without contacts, and an empty one.
  for (const char* file : {"events.csv", "trajectory.csv"}) {
    const auto whole = test::file_text(one / file);
    write_file(one / file, whole.substr(0, whole.find('\n') + 1));
    refused(file == std::string("events.csv") ? "--y impulse_n" : "--y b.x",
            file + std::string(": has no rows"));
  }
  write_file(one / "trajectory.csv", "");
  refused("--y b.x", "trajectory.csv: is empty");
}

// A column of 84 mm has room for (84 mm − 4·1.2 mm)/1.57 mm = 50 letters of 7 pt. A line of the title takes
// 3.6 mm, and the gap below it 1 mm. The height of a page is printed with six digits.
TEST_CASE("a title stands above the panels, broken to the width of the figure", "[figures][plot]") {
  const test::TemporaryFolder folder;
  write_known(folder.path());
  write_file(folder.path() / "style.toml", "width = 84\n");
  const auto script = [&](const std::string& more) {
    test::succeeded(fmt::format("plot {} --y b.y,b.ax -o mine --style {} {}", folder.path().string(),
                                (folder.path() / "style.toml").string(), more));
    return test::file_text(folder.path() / "figures/mine.gp");
  };
  const auto height = [](const std::string& text) {
    return std::stod(text.substr(text.find("HEIGHT = ") + 9));
  };
  const auto plain = script("");
  CHECK_THAT(plain, !Contains("set label 91"));
  CHECK(script("--title ''") == plain);
  const std::string first = "Motion of the body b over the time of the whole", second = "run, $_{hostile}";
  const auto titled = script("--title '" + first + " " + second + "'");
  CHECK_THAT(titled, Contains("set label 91 \"" + first + "\" at screen 0.5, ") &&
                         Contains("set label 92 \"") && !Contains("set label 93"));
  CHECK(test::count(titled, "unset label 91\nunset label 92\n") == 1);
  CHECK(height(titled) - height(plain) == Approx(2 * 0.36 + 0.1).margin(2e-4));
  CHECK(height(script("--title Motion")) - height(plain) == Approx(0.36 + 0.1).margin(2e-4));
  const auto facts =
      run_child({.command = {"pdfinfo", (folder.path() / "figures/mine.pdf").string()}, .listen = true});
  CHECK_THAT(facts.output, Contains("Motion\n"));
  std::string words;
  for (int i = 0; i < 60; ++i) words += "word ";
  CHECK_THAT(script("--title '" + words + "'"), Contains("set label 93 \"word") && !Contains("set label 94"));
}

TEST_CASE("every column of a run has a unit", "[figures][plot]") {
  const auto units = [](const std::string& name) {
    CAPTURE(name);
    CHECK_FALSE(plots::unit_of_column(name).empty());
  };
  for (const auto& list : {planar::names, planar::rate_names, planar::acceleration_names})
    for (const char* name : list) units("body." + std::string(name));
  using Kind = ForceElement::Kind;
  for (const auto kind :
       {Kind::joint, Kind::contact, Kind::force, Kind::push, Kind::drive, Kind::torque, Kind::section}) {
    const auto columns = force_parts(kind);
    for (const auto& [name, member] : columns.now) units("e." + std::string(name));
    for (const auto& [name, member] : columns.mean) units(fmt::format("e.{}_mean", name));
  }
  for (const char* name :
       {"c.ex", "c.ey", "c.gap", "t", "crank_angle", "v_n_minus", "impulse_t", "duration", "t_uncertainty"})
    units(name);
  CHECK(plots::unit_of_column("accelerometer").empty());
  CHECK(plots::unit_of_column("pin.m_mean") == "N m");
}

TEST_CASE("a thinned curve keeps its extremes", "[figures][plot]") {
  plots::Points p;
  for (int i = 0; i < 100'000; ++i) {
    p.x.push_back(i);
    p.y.push_back(i == 31'416 ? 50 : i == 77'777 ? -70 : std::sin(0.1 * i));
  }
  const auto few = plots::thinned(p, 1000);
  CHECK(few.x.size() <= 1000);
  CHECK(std::ranges::max(few.y) == 50);
  CHECK(std::ranges::min(few.y) == -70);
  CHECK(few.x.front() == 0);
  CHECK(few.x.back() == 99'999);
  CHECK(std::ranges::is_sorted(few.x));
  CHECK(plots::thinned(few, 1000).x == few.x);
}

TEST_CASE("the spectrum of a sine has its amplitude at its frequency", "[figures][plot]") {
  // 3 sin + 0.5 cos at the 40th and the 300th of 1000 multiples of 2 Hz, over a mean.
  std::vector<double> s;
  for (int i = 0; i < 1000; ++i)
    s.push_back(7 + 3 * std::sin(2 * std::numbers::pi * 40 * i / 1000) +
                0.5 * std::cos(2 * std::numbers::pi * 300 * i / 1000));
  const auto spectrum = plots::spectrum_of(s, 2000);
  REQUIRE(spectrum.amplitude.size() == 501);
  CHECK(spectrum.frequency[40] == Approx(80));
  CHECK(spectrum.frequency.back() == Approx(1000));
  for (std::size_t k = 0; k < spectrum.amplitude.size(); ++k) {
    const double expected = k == 40                ? 3
                            : k == 39 || k == 41   ? 1.5
                            : k == 300             ? 0.5
                            : k == 299 || k == 301 ? 0.25
                                                   : 0;
    CAPTURE(k);
    CHECK(std::abs(spectrum.amplitude[k] - expected) < 1e-12);
  }
  s.resize(997);  // a prime: 972 = 4 · 243 of them are used
  CHECK(plots::spectrum_of(s, 2000).amplitude.size() == 487);
  s.resize(15);
  CHECK(plots::spectrum_of(s, 2000).amplitude.empty());
}

TEST_CASE("figures of joint clearances show each journal within its circle, several to a page",
          "[figures][orbits]") {
  test::TemporaryFolder folder;
  const auto& place = folder.path();
  // A guide along (3, 4)/5 and eleven journals, identified from the scene.
  std::string scene =
      test::body("b", 1, 1) + test::surface("s", 0.5, "young = 2e11\npoisson = 0.3\n") +
      test::guide("g", "ground", "b", {0.6, 0.8}, {}, {},
                  "clearance = 1e-3\nslider_length = 0.1\nslider_height = 0.05\nsurface = \"s\"\n");
  std::string header = "t,b.x,b.y,b.theta,b.vx,b.vy,b.omega";
  for (const char* corner : {"rear_lower", "rear_upper", "front_lower", "front_upper"})
    header += fmt::format(",g.{0}.ex,g.{0}.ey,g.{0}.gap", corner);
  for (int j = 0; j < 11; ++j) {
    scene += test::pin(fmt::format("j{}", j), "ground", "b", {}, {}, test::loose(2e-4, 0.01));
    header += fmt::format(",j{0}.ex,j{0}.ey,j{0}.gap", j);
  }
  scene += test::run_for(1);
  std::string rows = header + "\n";
  for (int i = 0; i <= 100; ++i) {
    const double t = 0.01 * i, s = 0.2 * t, rear = 0.5e-3 * t, front = -0.25e-3;
    rows += fmt::format("{},0,0,0,0,0,0", t);
    for (const double gap : {1e-3 + rear, 1e-3 - rear, 1e-3 + front, 1e-3 - front})
      rows += fmt::format(",{},{},{}", 0.6 * s, 0.8 * s, gap);
    for (int j = 0; j < 11; ++j)
      rows += fmt::format(",{},{},{}", 1e-4 * std::cos(t), 1e-4 * std::sin(t), 1e-4);
    rows += "\n";
  }
  write_run(place, scene, 1);
  write_file(place / "trajectory.csv", rows);
  test::succeeded("figures " + place.string());

  const auto known = plots::clearance_joints(place, plots::scene_of_run(place).get());
  REQUIRE(known.size() == 12);
  CHECK(known[0].kind == plots::ClearanceJoint::Kind::guide);
  CHECK(known[0].frame_name == "the ground");
  const auto paths = plots::play_paths(place, known, {{0, 0.505, "half"}});
  CHECK(paths[0][0].clearance == Approx(1e-3));
  CHECK(paths[1][0].clearance == Approx(2e-4));
  CHECK(paths[0][0].high == Approx(100));  // mm: 0.2 m/s for 0.5 s

  std::size_t panels = 0, pages = 0;
  for (int page = 1; page < 10; ++page) {
    const auto name = page == 1 ? std::string("journal_orbit") : fmt::format("journal_orbit_{}", page);
    const auto file = place / "figures" / (name + ".gp");
    if (!std::filesystem::exists(file)) break;
    ++pages;
    panels += test::count(test::file_text(file), "\nplot ");
    const auto png = test::file_text(place / "figures" / (name + ".png"));
    const auto height = 256 * static_cast<unsigned char>(png[22]) + static_cast<unsigned char>(png[23]);
    CHECK(height <= 2300);  // 23 cm at 100 dots each
    CHECK(height > 400);
  }
  CHECK(panels == 24);  // first and last tenth of each
  CHECK(pages == 3);    // four rows of (9 − 1.95)/2 + 2 cm on each
  // The guide's rear end moves from the middle to a twentieth of the distance to the upper wall,
  // its front end stays a quarter below.
  const auto data = test::data_blocks(place / "figures/journal_orbit.dat");
  REQUIRE(data.size() > 4);
  REQUIRE(data[0].size() == 11);
  CHECK(data[0].back()[0] == Approx(20));
  CHECK(data[0].back()[1] == Approx(0.05));
  CHECK(data[1].back()[1] == Approx(-0.25));
  CHECK(data[4][0][0] == Approx(0.5));  // the first journal, half way to its bearing
  CHECK(data[4][0][1] == 0);
}

TEST_CASE("a run draws its figures without changing its results", "[figures][plot]") {
  test::TemporaryFolder folder;
  const auto out = (folder.path() / "out").string();
  const auto line = "run " + test::flores().string() +
                    " --formulation nonsmooth --set run.revolutions=0.05 --set run.discard=0 -o " + out;
  const std::filesystem::path figures = out + "/figures";
  test::succeeded(line + " --no-figures");
  CHECK_FALSE(std::filesystem::exists(figures));
  const auto bytes = [&](const char* file) { return test::file_text(std::filesystem::path(out) / file); };
  const std::string before[] = {bytes("trajectory.csv"), bytes("events.csv"), bytes("signals.csv")};

  const auto drawn = test::freeplay(line + " --plot gudgeon.gap,slider.vx");
  INFO(drawn.err);
  REQUIRE(drawn.status == 0);
  for (const char* name :
       {"motion", "phase_portrait", "signals", "journal_orbit", "plot_gudgeon.gap-slider.vx"}) {
    CAPTURE(name);
    CHECK_THAT(drawn.out, Contains(name));
    for (const char* suffix : {".pdf", ".png", ".gp", ".dat"})
      CHECK(std::filesystem::exists(figures / (std::string(name) + suffix)));
  }
  // A twentieth of a revolution: its first and last part are the same, and are drawn once.
  const auto orbit = test::file_text(figures / "journal_orbit.gp");
  CHECK(test::count(orbit, "\nplot ") == 1);
  CHECK_THAT(orbit, Contains("whole run") && !Contains("first turn"));
  CHECK(bytes("trajectory.csv") == before[0]);
  CHECK(bytes("events.csv") == before[1]);
  CHECK(bytes("signals.csv") == before[2]);

  // Refused before anything is made: the older run and its figures remain.
  test::refused(line + " --plot gudgeon.gaps",
                Contains("unknown column gudgeon.gaps; did you mean gudgeon.gap?"));
  CHECK(test::freeplay(line + " --plot gudgeon.fx").status == 2);
  write_file(figures / "style.toml", "fnt = 1\n");
  CHECK(test::freeplay(line).status == 2);
  CHECK(std::filesystem::exists(figures / "motion.png"));
  // Without figures those of the run before are removed; the user's remain.
  test::succeeded(line + " --no-figures");
  CHECK_FALSE(std::filesystem::exists(figures / "motion.png"));
  CHECK_FALSE(std::filesystem::exists(figures / "journal_orbit.gp"));
  CHECK(std::filesystem::exists(figures / "plot_gudgeon.gap-slider.vx.pdf"));
  CHECK(bytes("figures/style.toml") == "fnt = 1\n");
}
