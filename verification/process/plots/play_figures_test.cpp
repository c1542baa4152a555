// Figures of output play from known ranges: the magnification about the ideal curve, the deviations, the parts
// of the joints, and the gap at a refused position.
#include "plots/drawing/figure.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

json provenance() { return {{"version", "0"}, {"commit", "none"}, {"scene_file", "scene.toml"}}; }

json output(const char* name, const char* column, const char* unit) {
  return {{"quantity", name}, {"column", column}, {"unit", unit}};
}

/// Rows of a data file as numbers; an empty row is a gap.
std::vector<std::vector<double>> rows_of(const std::filesystem::path& file) {
  std::vector<std::vector<double>> rows;
  std::istringstream text(test::file_text(file));
  std::string line;
  std::getline(text, line);  // the heading
  while (std::getline(text, line)) {
    std::istringstream numbers(line);
    rows.emplace_back();
    for (std::string x; numbers >> x;) rows.back().push_back(std::stod(x));
  }
  while (!rows.empty() && rows.back().empty()) rows.pop_back();
  return rows;
}

void check_row(const std::vector<double>& row, const std::vector<double>& expected) {
  CAPTURE(row);
  REQUIRE(row.size() == expected.size());
  for (std::size_t k = 0; k < row.size(); ++k) {
    CAPTURE(k);
    CHECK(row[k] == Approx(expected[k]).margin(1e-9));
  }
}

/// The rocker turns by 4 rad and has ±2 mrad, a point of the crank has no play, and a distance of 0.25 m has
/// 20 µm and a bound that is 10 µm higher. The third position is refused.
void write_play(const std::filesystem::path& folder) {
  make_folder(folder);
  write_file(folder / "play.json",
             json{{"joint", "A"},
                  {"unit", "rad"},
                  {"quantities",
                   {output("rocker.theta", "rocker.theta", "rad"), output("crank.tip.x", "crank.tip.x", "m"),
                    output("distance(P, Q)", "distance:P:Q", "m")}},
                  {"provenance", provenance()}}
                 .dump());
  std::string ranges = "A", parts = "A";
  for (const std::string column : {"rocker.theta", "crank.tip.x", "distance:P:Q"}) {
    for (const char* part : {"ideal", "least", "greatest", "bound_least", "bound_greatest", "linear"})
      ranges += "," + column + "." + part;
    for (const char* joint : {"B", "C"}) parts += "," + column + "." + joint;
  }
  for (int i = 0; i < 5; ++i) {
    const double at = std::numbers::pi / 2 * i;
    ranges += fmt::format("\n{}", at);
    parts += fmt::format("\n{}", at);
    if (i == 2) {
      ranges += std::string(18, ','), parts += std::string(6, ',');
      continue;
    }
    ranges += fmt::format(",{0},{1},{2},{1},{2},0.002", i, i - 0.002, i + 0.002);
    ranges += fmt::format(",{0},{0},{0},{0},{0},0", 0.1);
    ranges += ",0.25,0.24999,0.25001,0.24999,0.25002,1e-5";
    parts += ",0.003,0.001,0,0,5e-6,15e-6";
  }
  write_file(folder / "play.csv", ranges + "\n");
  write_file(folder / "play_parts.csv", parts + "\n");
}

}  // namespace

TEST_CASE("the range about the ideal curve is magnified by a round factor", "[figures][play]") {
  const test::TemporaryFolder folder;
  write_play(folder.path());
  const auto made = plots::all(folder.path());
  const auto figures = folder.path() / "figures";
  REQUIRE(made.size() == 4);  // none of the point without play
  CHECK(made[0] == figures / "play_band_rocker.theta.pdf");
  CHECK(made[1] == figures / "play_parts_rocker.theta.pdf");

  // The axis of 0 to 4 rad ends at 4.2 rad with its margin. A tenth of it is 105 times 4 mrad, nearest to 100.
  auto rows = rows_of(figures / "play_band_rocker.theta.dat");
  REQUIRE(rows.size() == 5);
  check_row(rows[0], {0, 0, -0.2, 0.2, -2, 2, -2, 2, -2, 2});
  check_row(rows[1], {90, 1, 0.8, 1.2, -2, 2, -2, 2, -2, 2});
  CHECK(rows[2].empty());
  check_row(rows[4], {360, 4, 3.8, 4.2, -2, 2, -2, 2, -2, 2});
  auto script = test::file_text(figures / "play_band_rocker.theta.gp");
  CHECK_THAT(script, Contains("magnified 100 times") && Contains("No range at 1 of 5 positions") &&
                         Contains("range \\303\\227 100") && Contains("\"linear\"") &&
                         !Contains("\"bounds\""));

  // The distance is constant: its range is drawn to scale.
  script = test::file_text(made[2].parent_path() / made[2].filename().replace_extension(".gp"));
  CHECK_THAT(script, Contains("title \"range\"") && Contains("\"bounds\"") && !Contains("magnified"));
}

TEST_CASE("the parts of the joints in a range are stacked", "[figures][play]") {
  const test::TemporaryFolder folder;
  write_play(folder.path());
  plots::all(folder.path());
  const auto rows = rows_of(folder.path() / "figures/play_parts_rocker.theta.dat");
  REQUIRE(rows.size() == 5);
  check_row(rows[0], {0, 0, 3, 4});  // mrad
  CHECK(rows[2].empty());
  check_row(rows[4], {360, 0, 3, 4});
  CHECK_THAT(test::file_text(folder.path() / "figures/play_parts_rocker.theta.gp"),
             Contains("title \"B\"") && Contains("title \"C\"") && Contains("1:3:4 with filledcurves"));
}

TEST_CASE("the region of a point is magnified about its ideal place", "[figures][play]") {
  // An arm of 0.5 m at 0° and 90°, whose tip has a disc of 1 mm there and one of 0.8 mm. The picture of the poses and
  // their margin is 0.6 m wide, a tenth of it 30 times 2 mm, nearest to 20.
  const test::TemporaryFolder folder;
  make_folder(folder.path());
  const auto write = [&](const char* name, const std::string& text) {
    write_file(folder.path() / name, text);
  };
  write("play.json",
        json{{"joint", "A"}, {"unit", "rad"}, {"quantities", json::array()}, {"provenance", provenance()}}
            .dump());
  write("play.csv", "A,arm.tip.x.ideal,arm.tip.y.ideal\n0,0.5,0\n0.8,,\n1.6,0,0.5\n");
  write("play_pose.csv",
        "at,shape,name,x,y,a,b\n0,link,arm,0,0,0,0\n0,link,arm,0.5,0,0,0\n0,support,A,0,0,0,0\n"
        "1.6,link,arm,0,0,0,0\n1.6,link,arm,0,0.5,0,0\n1.6,support,A,0,0,0,0\n");
  std::string regions = "at,point,ideal_x,ideal_y,phi,x,y,bound\n";
  for (const double at : {0.0, 1.6})
    for (int d = 0; d < 8; ++d) {
      const double phi = std::numbers::pi / 4 * d, radius = at == 0 ? 1e-3 : 0.8e-3;
      const double x = at == 0 ? 0.5 : 0, y = at == 0 ? 0 : 0.5;
      // Only the first region has bounds that differ from it.
      regions += fmt::format("{},arm.tip,{},{},{},{},{},{}\n", at, x, y, phi, x + radius * std::cos(phi),
                             y + radius * std::sin(phi), at == 0 ? 1.1e-3 : 0.8e-3);
    }
  write("play_region.csv", regions);
  const auto made = plots::all(folder.path());
  const auto figures = folder.path() / "figures";
  REQUIRE(made == std::vector{figures / "play_region_arm.tip.pdf"});
  const auto script = test::file_text(figures / "play_region_arm.tip.gp");
  CHECK_THAT(script, Contains("magnified 20 times") && Contains("region \\303\\227 20") &&
                         Contains("\"ideal path\"") && Contains("\"bound\"") && Contains("91.67\\302\\260"));
  // The blocks of the regions and of the first one's bound, whose polygon has its first corner at 22.5° and the
  // distance of 1.1 mm/cos 22.5°.
  const auto data = test::file_text(figures / "play_region_arm.tip.dat");
  const auto first_row = [&](std::size_t from, const char* heading) {
    std::istringstream text(data.substr(data.find(heading, from) + std::strlen(heading)));
    double x = NAN, y = NAN;
    text >> x >> y;
    return std::vector{x, y};
  };
  check_row(first_row(0, "# region\n"), {0.5 + 20 * 1e-3, 0});
  check_row(first_row(data.find("# region") + 1, "# region\n"), {20 * 0.8e-3, 0.5});
  check_row(first_row(0, "# bound\n"), {0.5 + 20 * 1.1e-3, 20 * 1.1e-3 * std::tan(std::numbers::pi / 8)});
}

TEST_CASE("play draws its figures in a style, over positions only", "[figures][play]") {
  const test::TemporaryFolder folder;
  const auto play = [&](const std::string& more) {
    return test::succeeded(fmt::format("play {} --of slider.x -o {} {}", test::flores().string(),
                                       (folder.path() / "play").string(), more));
  };
  const auto band = folder.path() / "play/figures/play_band_slider.x.gp";
  CHECK_THAT(play("--over main --from 0 --to '360 deg' --points 13 --style journal-single").out,
             Contains("play_band_slider.x.pdf") && Contains("play_parts_slider.x.pdf"));
  CHECK_THAT(test::file_text(band), Contains("WIDTH = 8.4;"));
  play("--of slider.y");
  CHECK_FALSE(std::filesystem::exists(band));
  // A point without --over, in the position of the start.
  CHECK(std::filesystem::exists(folder.path() / "play/figures/play_region_slider.pdf"));
}
