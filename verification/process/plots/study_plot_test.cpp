// Figures of studies: curves and maps of a sweep with the values, intervals and units of a hand-made
// database, histograms of an ensemble, columns of a bifurcation and a basin; and figures of a paper
// by their numbers.
#include <regex>

#include "plots/drawing/heat_map.hpp"
#include "plots/figures/experiment.hpp"
#include "plots/studies/study_plot.hpp"
#include "verification/support/ball_study.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"
#include "verification/support/study_results.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// A ball that falls from 0.5 m: after an impact at restitution e it rises to e² h.
constexpr const char* measures =
    "formulations = [\"nonsmooth\"]\n[measure.highest]\ncolumn = \"ball.y\"\nreduce = \"max\"\n"
    "[measure.touches]\ncolumn = \"ball.y\"\nreduce = \"count\"\n"
    "[derived]\nshare = \"(highest - 0.05)/0.5\"\n[units]\nshare = \"of h\"\n";

plots::AxisTitle plain(const std::string& text) { return plots::AxisTitle::plain(text, ""); }

/// A map of the given panels over x and y, and the rows of its data.
struct DrawnMap {
  plots::HeatMap map{.x = plain("x"), .y = plain("y"), .grid = true, .heading = "x, y, value", .panels = {}};
  std::string script;
  test::TemporaryFolder folder;

  plots::HeatPanel& panel(const std::string& quantity) {
    return map.panels.emplace_back(plots::HeatPanel{"", quantity, plain(quantity), {}});
  }
  std::vector<std::vector<double>> rows() {
    plots::Figure f{.name = "map", .source = "sweep.json"};
    plots::add_heat_map(f, map, plots::Style{});
    script = f.script.text();
    write_file(folder.path() / "map.dat", f.blocks[0].text());
    return test::data_blocks(folder.path() / "map.dat")[0];
  }
};

/// The document of a study with the columns phase and approach.
void put_document(const std::filesystem::path& folder, const std::string& kind, nlohmann::json axes) {
  for (auto& axis : axes) axis = {{"name", axis}, {"key", "k"}, {"unit", "mm"}, {"scale", 1e3}};
  axes["columns"] = {{{"name", "phase"}, {"unit", ""}}, {{"name", "approach"}, {"unit", "m/s"}}};
  write_file(folder / (kind + ".json"),
             nlohmann::json{{"provenance", test::study_origin()}, {kind, axes}}.dump());
}

/// Adds the starts 1 and 2 of each run to a sweep's database, and replaces a measure by
/// e + start/10, so that its mean over the starts and the interval are known.
void plant_starts(const std::filesystem::path& database) {
  std::string columns;
  for (const auto& row : test::query(database, "SELECT name FROM pragma_table_info('runs')"))
    if (const auto& name = row[0];
        name != "run" && name != "variant" && name != "formulation" && name != "start")
      columns += ", " + (name == "run id" ? std::string("NULL") : '"' + name + '"');
  for (const int start : {1, 2})
    test::execute(database, fmt::format("INSERT INTO runs SELECT run || '{0}', variant, formulation, {0}{1} "
                                        "FROM runs WHERE start = 0",
                                        start, columns));
  test::execute(database, "UPDATE runs SET highest = e + start/10.0");
}

}  // namespace

TEST_CASE("curves of a sweep have the mean, Student's interval and the units", "[figures][study]") {
  const test::BallStudy ball("values = [0.2, 0.4, 0.8]\nunit = \"%\"\nscale = 100", measures);
  const auto made = test::freeplay(fmt::format("sweep {} -o {}", ball.study.string(), ball.out.string()));
  CAPTURE(made.out, made.err);
  REQUIRE(made.status == 0);
  plant_starts(ball.out / "sweep.db");

  const auto plot = [&](const std::string& rest) {
    return test::freeplay(fmt::format("plot {} {}", ball.out.string(), rest));
  };
  const auto drawn = plot("--y highest -o rise");
  CAPTURE(drawn.out, drawn.err);
  REQUIRE(drawn.status == 0);
  const auto blocks = test::data_blocks(ball.out / "figures/rise.dat");
  REQUIRE(blocks.size() == 1);
  REQUIRE(blocks[0].size() == 3);
  // Of x, x + 0.1, x + 0.2 the mean is x + 0.1 and s = 0.1; t of 2 degrees of freedom is 4.302653.
  const double half = 4.302653 * 0.1 / std::sqrt(3.0);
  const double e[] = {0.2, 0.4, 0.8};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& row = blocks[0][i];
    REQUIRE(row.size() == 5);
    CHECK_THAT(row[0], WithinRel(100 * e[i], 1e-12));
    CHECK_THAT(row[1], WithinRel(e[i] + 0.1, 1e-12));
    CHECK_THAT(row[2], WithinAbs(e[i] + 0.1 - half, 1e-6));
    CHECK_THAT(row[3], WithinAbs(e[i] + 0.1 + half, 1e-6));
    CHECK(row[4] == 3);
  }
  const auto script = test::file_text(ball.out / "figures/rise.gp");
  CHECK_THAT(script, Contains("set xlabel \"e\".' '.\"(\\045)\""));
  CHECK_THAT(script, Contains("set ylabel \"highest\".' '.\"(m)\""));
  CHECK_THAT(script, Contains("yerrorbars"));

  // A count has no unit, and a derived quantity that of the study.
  REQUIRE(plot("--y share,touches -o two").status == 0);
  const auto two = test::file_text(ball.out / "figures/two.gp");
  CHECK_THAT(two, Contains("set ylabel \"share\".' '.\"(of h)\"") && Contains("set ylabel \"touches\""));
  // The table is headed by the study's title, else by its scene, not by its restitution.
  CHECK_THAT(made.out, !Contains("as given"));
  // The database stands for the folder, and the figure has a name of its own.
  test::succeeded(fmt::format("plot {} --y highest", (ball.out / "sweep.db").string()));
  CHECK(std::filesystem::exists(ball.out / "figures/sweep_highest_e.pdf"));

  // Options of runs, and unknown measures and axes, are answered with what there is.
  const auto says = [&](const std::string& rest, const auto& message) {
    return test::refused(fmt::format("plot {} {}", ball.out.string(), rest), message);
  };
  says("--y highest --unit mm", Contains("--unit is for runs") && Contains("[units] speed_mm = \"mm/s\""));
  says("--y highest --fold", Contains("--fold are for runs"));
  says("--y highest --from 1", Contains("--from"));
  says("--y higest", Contains("unknown measure higest; did you mean highest?") &&
                         Contains("measures: highest touches") && Contains("derived: share") &&
                         !Contains("ratio_95"));  // without a drive no run has a ratio to the ideal mechanism
  says("--y highest --x speed", Contains("unknown axis speed") && Contains("axes: e"));
  std::filesystem::remove(ball.out / "sweep.json");
  says("--y highest", Contains("sweep.json") && Contains("freeplay sweep"));
}

TEST_CASE("a unit of something that is no measure is refused with its line", "[study]") {
  // The study has four lines, then [units] as line 5.
  const test::BallStudy ball("values = [0.2]", "[units]\nrise = \"m\"\n");
  test::refused(fmt::format("sweep {} -o {}", ball.study.string(), ball.out.string()),
                Contains("study.toml:6") && Contains("units.rise") && Contains("neither a measure nor"));
}

TEST_CASE("a map over two axes has each cell once, with edges midway", "[figures][study]") {
  DrawnMap drawn;
  auto& cells = drawn.panel("v").cells;
  for (const double x : {0.1, 0.25, 0.5, 1.0})
    for (const double y : {100.0, 200.0})
      if (x < 1 || y < 200) cells.push_back({x, y, x * y});
  const auto rows = drawn.rows();
  REQUIRE(rows.size() == 7);
  CHECK(rows[2] == std::vector<double>{0.25, 100, 25, rows[2][3], rows[2][4], 50, 150});
  // 0.1 to 1 in ratios that differ less than the steps: the axis is logarithmic.
  CHECK_THAT(rows[2][3], WithinRel(std::sqrt(0.1 * 0.25), 1e-12));
  CHECK_THAT(rows[2][4], WithinRel(std::sqrt(0.25 * 0.5), 1e-12));
  CHECK_THAT(drawn.script, Contains("\nset logscale x") && !Contains("\nset logscale y") &&
                               Contains("set cbrange [10:100]"));
  CHECK_FALSE(plots::is_logarithmic({1, 2, 3, 4}));
  CHECK_FALSE(plots::is_logarithmic({0, 1, 10, 100}));
  CHECK(plots::is_logarithmic({100, 10, 1}));
}

TEST_CASE("cells of unequal steps are equal, and one scale has one colour bar", "[figures][study]") {
  DrawnMap drawn;
  for (const char* quantity : {"v", "v"}) {
    auto& cells = drawn.panel(quantity).cells;
    for (const double x : {0.05, 0.1, 0.2, 0.4})
      for (const double y : {1.0, 2.0, 3.0}) cells.push_back({x, y, x * y});
  }
  const auto rows = drawn.rows();
  REQUIRE(rows.size() == 12);
  // 0.2 is the third of four values; the steps of y are equal.
  CHECK(rows[7] == std::vector<double>{0.2, 2, 0.2 * 2, 1.5, 2.5, 1.5, 2.5});
  CHECK_THAT(drawn.script, Contains("set xtics (\"0.05\" 0, \"0.1\" 1, \"0.2\" 2, \"0.4\" 3)") &&
                               Contains("set xrange [-0.5:3.5]") && Contains("set yrange [0.5:3.5]"));
  const auto without = drawn.script.find("unset colorbox"), with = drawn.script.find("\nset colorbox");
  CHECK(without < with);
  CHECK(with != drawn.script.npos);
  // Scales of their own have bars of their own.
  drawn.map.panels[1].quantity = plain("w");
  drawn.rows();
  CHECK_THAT(drawn.script, !Contains("unset colorbox"));
}

TEST_CASE("statistics of an ensemble are drawn as histograms over the starts", "[figures][study]") {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "ensemble.json", nlohmann::json{{"provenance", test::study_origin()}}.dump());
  write_file(folder.path() / "bands.csv",
             "column,t,q05,q25,q50,q75,q95\npin.gap,0,1,2,3,4,5\npin.gap,1,1,2,3,4,5\n");
  std::string starts = "start,finished,pin.impacts,energy\n";
  for (int k = 0; k < 8; ++k) starts += fmt::format("{},1,{},{}\n", k, k, k == 3 ? "" : "2");
  write_file(folder.path() / "starts.csv", starts);
  plots::StudyPlot plot{.folder = folder.path(), .y = {"pin.impacts"}, .x = {}, .name = "histogram"};
  plots::draw_study(plot);
  const auto blocks = test::data_blocks(folder.path() / "figures/histogram.dat");
  REQUIRE(blocks.size() == 2);
  // ⌈2·8^⅓⌉ = 4 classes of 7/4 over 0 … 7: two starts each
  REQUIRE(blocks[0].size() == 4);
  for (std::size_t k = 0; k < 4; ++k)
    CHECK(blocks[0][k] == std::vector<double>{1.75 * (static_cast<double>(k) + 0.5), 2, 1.75});
  CHECK(blocks[1][0][0] == 3.5);
  plot.y = {"pin.gap"};
  plot.name = "band";
  plots::draw_study(plot);
  CHECK(test::data_blocks(folder.path() / "figures/band.dat")[0][1] == std::vector<double>{1, 1, 2, 3, 4, 5});
  plot.y = {"pin.gap", "energy"};
  CHECK_THROWS_WITH(plots::draw_study(plot), Contains("two figures"));
  plot.y = {"pin.impact"};
  CHECK_THROWS_WITH(plots::draw_study(plot), Contains("did you mean pin.impacts?") &&
                                                 Contains("bands: pin.gap") &&
                                                 Contains("statistics: pin.impacts energy"));
}

TEST_CASE("any column of a bifurcation is drawn", "[figures][study]") {
  const test::TemporaryFolder folder;
  put_document(folder.path(), "bifurcation", {{"axis", "c"}});
  write_file(folder.path() / "bifurcation.csv",
             "branch,value,attractor,period,t,phase,approach\nup,1,0,1,0,0.1,3\nup,2,0,1,0,0.2,4\n");
  plots::draw_study({.folder = folder.path(), .y = {"approach"}, .x = {}});
  CHECK(test::data_blocks(folder.path() / "figures/bifurcation_approach.dat")[0] ==
        std::vector<std::vector<double>>{{1, 3}, {2, 4}});
  CHECK_THAT(test::file_text(folder.path() / "figures/bifurcation_approach.gp"),
             Contains("set ylabel 'approach speed |v_N|'.' '.\"(m/s)\""));
  CHECK_THROWS_WITH(plots::draw_study({.folder = folder.path(), .y = {"speed"}, .x = {}}),
                    Contains("columns: phase approach period"));
  CHECK_THROWS_WITH(plots::draw_study({.folder = folder.path(), .y = {"approach/phase"}, .x = {}}),
                    Contains("by names, not by expressions"));
}

TEST_CASE("any column of a basin is drawn", "[figures][study]") {
  const test::TemporaryFolder folder;
  put_document(folder.path(), "basin", {{"x", "a"}, {"y", "b"}});
  write_file(folder.path() / "basin.csv",
             "x,y,attractor,period,phase,approach\n1,1,0,1,0.1,3\n2,1,0,1,0.2,4\n1,2,0,1,0.1,5\n"
             "2,2,-1,0,nan,nan\n");
  plots::draw_study({.folder = folder.path(), .y = {"approach"}, .x = {}});
  CHECK(test::data_blocks(folder.path() / "figures/basin_approach.dat")[0] ==
        std::vector<std::vector<double>>{
            {1, 1, 3, 0.5, 1.5, 0.5, 1.5}, {2, 1, 4, 1.5, 2.5, 0.5, 1.5}, {1, 2, 5, 0.5, 1.5, 1.5, 2.5}});
}

TEST_CASE("figures of the paper have its numbers, panels and units", "[figures][study]") {
  const test::TemporaryFolder folder;
  test::put_paper_result(folder.path(), 1);
  const auto made = plots::draw_flores2011(folder.path(), "paper.json");
  REQUIRE(made.size() == 9);
  for (std::size_t i = 0; i < made.size(); ++i) {
    CHECK(made[i].filename() == fmt::format("figure_{:02}.pdf", i + 5));
    for (const char* end : {".dat", ".gp", ".png"})
      CHECK(std::filesystem::exists(folder.path() / "figures" / fmt::format("figure_{:02}{}", i + 5, end)));
  }
  // Figure 5: ideal position, both formulations' position, the same for the acceleration, at 0.25 mm.
  const auto five = test::data_blocks(folder.path() / "figures/figure_05.dat");
  REQUIRE(five.size() == 6);
  CHECK_THAT(five[4][3][1], WithinRel(200 * 0.25e-3 * std::sqrt(0.75), 1e-12));
  // Figure 11: velocity and acceleration of three curves for each clearance.
  const auto eleven = test::data_blocks(folder.path() / "figures/figure_11.dat");
  REQUIRE(eleven.size() == 24);
  for (const auto& row : eleven[0]) CHECK_THAT(row[1], WithinRel(0.1 * 200 / 60, 1e-9));
  CHECK_THAT(eleven[23][0][1], WithinRel(200 * 1e-3, 1e-12));
  const auto script = test::file_text(folder.path() / "figures/figure_11.gp");
  CHECK_THAT(script,
             Contains("CAPTION = \"Flores et al. (2011), figure 11. Velocity v and acceleration a of the "
                      "slider in the last turn at 200 rpm"));
  const auto twelve = test::file_text(folder.path() / "figures/figure_12.gp");
  // A long caption is several literals.
  CHECK_THAT(std::regex_replace(twelve, std::regex(R"("\."|"\.\s*")"), ""),
             Contains("Measured: the values that"));
  CHECK_THAT(script, Contains("(h) 1.00 mm") && Contains("set ylabel 'v'.' '.\"(m/s)\""));
}
