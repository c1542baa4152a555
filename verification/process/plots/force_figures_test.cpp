// Force figures from folders with known forces: the plotted quantities, their abscissa and their
// range.
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

nlohmann::json provenance_of(const std::filesystem::path& scene) {
  return {{"version", "0"},
          {"commit", "none"},
          {"scene_file", "scene.toml"},
          {"scene", test::file_text(scene)},
          {"overrides", nlohmann::json::array()},
          {"options", {{"run", {{"duration", 1.0}, {"discard", 0.0}}}}}};
}

/// One run: `value` gives a column at a time; NaN leaves the field empty.
void write_run(const std::filesystem::path& folder, const std::filesystem::path& scene,
               const std::string& formulation, const std::vector<std::string>& columns, double duration,
               int rows, const std::function<double(const std::string&, double)>& value) {
  make_folder(folder);
  std::string forces = "t";
  for (const auto& c : columns) forces += "," + c;
  forces += "\n";
  for (int i = 0; i <= rows; ++i) {
    const double t = duration * i / rows;
    forces += fmt::format("{}", t);
    for (const auto& c : columns) {
      const double x = value(c, t);
      forces += std::isnan(x) || (i == 0 && c.ends_with("_mean")) ? "," : fmt::format(",{}", x);
    }
    forces += "\n";
  }
  write_file(folder / "forces.csv", forces);
  write_file(folder / "trajectory.csv", "t\n0\n1\n");
  write_file(folder / "run.json",
             nlohmann::json{{"formulation", formulation}, {"provenance", provenance_of(scene)}}.dump());
}

void write_comparison(const std::filesystem::path& folder, const std::filesystem::path& scene) {
  write_file(folder / "comparison.json", nlohmann::json{{"provenance", provenance_of(scene)},
                                                        {"penalty", {{"revolutions_counted", 0}}},
                                                        {"pairing", {{"pairs", nlohmann::json::array()}}}}
                                             .dump());
}

std::vector<std::string> force_columns(const std::string& name, bool contact) {
  std::vector<std::string> list{name + ".fx", name + ".fy"};
  if (contact) list.insert(list.end(), {name + ".fn", name + ".ft"});
  for (const char* suffix : {".m", ".fx_mean", ".fy_mean", ".m_mean"}) list.push_back(name + suffix);
  return list;
}

/// Drawn, and not an empty page.
void check_drawn(const std::filesystem::path& folder, const std::vector<std::string>& names) {
  for (const auto& name : names)
    for (const auto& [suffix, least] :
         {std::pair{".pdf", 4000}, {".png", 15000}, {".dat", 1000}, {".gp", 1000}}) {
      const auto file = folder / "figures" / (name + suffix);
      CAPTURE(file.string());
      REQUIRE(std::filesystem::exists(file));
      CHECK(static_cast<int>(std::filesystem::file_size(file)) > least);
    }
}

constexpr double turn_s = 0.3;  // of the crank at 200 rpm

}  // namespace

TEST_CASE("force figures: reactions, bearing loads and torque over the last revolution", "[figures]") {
  test::TemporaryFolder folder;
  const auto& out = folder.path();
  write_comparison(out, test::flores());
  // 2.5 revolutions of 200 rows. At one instant of the second revolution the nonsmooth run has an
  // impact.
  const auto value = [](double scale, bool impact) {
    return [=](const std::string& column, double t) {
      const double angle = 2 * std::numbers::pi * t / turn_s;
      if (impact && column == "gudgeon.fx_mean" && std::abs(t - 1.5 * turn_s) < 1e-9) return 1e5;
      if (column.starts_with("guide.fx") || column.find(".m") != column.npos) return 1e-12;
      if (column.find(".fx") != column.npos) return scale * std::cos(angle);
      return scale * std::sin(angle);
    };
  };
  for (const char* run : {"penalty", "nonsmooth", "ideal"}) {
    std::vector<std::string> columns;
    for (const char* joint : {"main", "big_end", "gudgeon", "guide"}) {
      const auto list = force_columns(joint, joint == std::string("gudgeon") && run != std::string("ideal"));
      columns.insert(columns.end(), list.begin(), list.end());
    }
    // A load is not a joint, a torque load not a drive.
    columns.insert(columns.end(), {"push.fx", "push.fy", "push.fx_mean", "push.fy_mean", "twist.torque",
                                   "twist.power", "twist.torque_mean"});
    columns.insert(columns.end(), {"motor.torque", "motor.power", "motor.torque_mean", "crank.ax", "crank.ay",
                                   "crank.alpha"});
    write_run(out / run, test::flores(), run == std::string("nonsmooth") ? "nonsmooth" : "penalty", columns,
              2.5 * turn_s, 500, value(10, run == std::string("nonsmooth")));
  }
  const auto o = test::succeeded("figures " + out.string());
  CHECK(o.err.empty());
  check_drawn(out, {"reaction_main", "reaction_big_end", "reaction_gudgeon", "reaction_guide",
                    "bearing_load_main", "bearing_load_big_end", "bearing_load_gudgeon", "drive_torque"});
  for (const char* name : {"bearing_load_guide", "reaction_push", "reaction_twist"})
    CHECK_FALSE(std::filesystem::exists(out / "figures" / (std::string(name) + ".gp")));

  // The last revolution that begins at a multiple of 360°, each mean in the middle of its interval.
  std::istringstream data(test::file_text(out / "figures/reaction_gudgeon.dat"));
  std::string line;
  std::getline(data, line);
  CHECK(line == "# penalty: angle (degrees), |F| (N), F_x (N), F_y (N)");
  std::vector<std::array<double, 4>> rows;
  while (std::getline(data, line) && !line.empty()) {
    auto& r = rows.emplace_back();
    std::istringstream(line) >> r[0] >> r[1] >> r[2] >> r[3];
  }
  REQUIRE(rows.size() == 200);
  CHECK(rows.front()[0] == Approx(0.9));
  CHECK(rows.back()[0] == Approx(359.1));
  CHECK(rows[99][1] == Approx(10));
  CHECK(rows[99][2] == Approx(-10));

  const auto script = test::file_text(out / "figures/reaction_gudgeon.gp");
  CHECK_THAT(script, Contains("gudgeon: force on slider") && Contains("last turn, means over 1.5 ms") &&
                         Contains("nonsmooth 1 of 200") && !Contains("penalty 1 of") &&
                         Contains("title \"ideal joint\""));
  CHECK_THAT(test::file_text(out / "figures/bearing_load_gudgeon.gp"),
             Contains("Outside the ranges (arrows): nonsmooth 1 of 200") && Contains("with vectors"));
  // One triangle at the edge for the one peak of the nonsmooth run.
  const auto blocks = test::data_blocks(out / "figures/reaction_gudgeon.dat");
  REQUIRE(blocks.size() > 3);
  for (std::size_t b = 3; b < blocks.size(); ++b) CHECK(blocks[b].size() == 1);
  CHECK_THAT(script, Contains("with points pt 9 ps 0.7 lc rgb C2") && !Contains("ps 0.7 lc rgb C1"));
  CHECK_THAT(test::file_text(out / "figures/reaction_guide.gp"), !Contains("F_x") && Contains("F_y"));
  CHECK_THAT(test::file_text(out / "figures/drive_torque.gp"), Contains("motor") && !Contains("twist"));
}

TEST_CASE("force figures: one run, no drive, four corners, empty columns", "[figures]") {
  test::TemporaryFolder folder;
  const auto& out = folder.path();
  const auto scene = test::source_folder() / "cases/flores2010-translational/scene.toml";
  std::vector<std::string> columns;
  for (const char* name : {"main", "big_end", "pin"})
    for (const auto& c : force_columns(name, false)) columns.push_back(c);
  for (const char* name : {"guide.rear_lower", "guide.rear_upper", "guide.front_lower", "guide.front_upper"})
    for (const auto& c : force_columns(name, true)) columns.push_back(c);
  columns.push_back("slider.ax");
  write_run(out, scene, "nonsmooth", columns, 0.2, 5000, [](const std::string& column, double t) {
    if (column.starts_with("pin.") || column == "slider.ax") return std::nan("");
    if (column.starts_with("guide") && std::fmod(t, 0.02) > 0.01) return 0.0;
    return column.find(".fy") != column.npos ? 5 + std::sin(300 * t) : std::cos(300 * t);
  });
  const auto o = test::succeeded("figures " + out.string());
  CHECK(o.err.empty());
  check_drawn(out, {"reaction_main", "reaction_guide", "bearing_load_main"});
  for (const char* name : {"reaction_pin", "bearing_load_pin", "bearing_load_guide", "drive_torque"})
    CHECK_FALSE(std::filesystem::exists(out / "figures" / (std::string(name) + ".gp")));
  const auto script = test::file_text(out / "figures/reaction_guide.gp");
  CHECK_THAT(script, Contains("whole run, means over 120 \\302\\265s, nonsmooth.") && Contains("'time t'") &&
                         Contains("all corners") && Contains("front upper") && !Contains("\"penalty\""));
  CHECK_THAT(test::file_text(out / "figures/reaction_guide.dat"), Contains("rear lower |F| (N)"));
  // Three rows merged into one keep their mean: 5 + (sin 0.012 + sin 0.024 + sin 0.036)/3.
  std::istringstream data(test::file_text(out / "figures/reaction_main.dat"));
  std::string header;
  std::getline(data, header);
  double t = 0, size = 0, fx = 0, fy = 0;
  data >> t >> size >> fx >> fy;
  CHECK(t == Approx(60e-6));
  CHECK(fy == Approx(5.024).epsilon(1e-5));

  // Without a readable scene the figures lack the crank angle and facts about joints, but are
  // drawn.
  auto document = nlohmann::json::parse(test::file_text(out / "run.json"));
  document["provenance"]["scene"] = "no scene [";
  write_file(out / "run.json", document.dump());
  std::filesystem::remove_all(out / "figures");
  test::succeeded("figures " + out.string());
  check_drawn(out, {"reaction_main", "reaction_guide"});
}

TEST_CASE("force figures: broken files are refused, empty ones draw nothing", "[figures]") {
  test::TemporaryFolder folder;
  const auto& out = folder.path();
  write_run(out, test::flores(), "penalty", force_columns("main", false), 0.1, 1,
            [](const std::string&, double) { return 1.0; });
  CHECK_THAT(test::freeplay("figures " + out.string()).err, Contains("no result files to draw"));
  write_file(out / "forces.csv", "");
  test::refused("figures " + out.string(), Contains("forces.csv: is empty"));
  write_file(out / "forces.csv", "t,main.fx_mean,main.fy_mean,main.m_mean\n0,1,2,3\n1,2\n");
  test::refused("figures " + out.string(), Contains("forces.csv:3: has 2 fields, the header has 4"));
}

TEST_CASE("force figures: constant reactions that are statically indeterminate", "[figures]") {
  test::TemporaryFolder folder;
  const auto out = folder.path() / "out";
  const auto run =
      test::succeeded("run " + test::scene_file("twin_guides").string() +
                      " --formulation penalty --forces --set run.duration=0.01 -o " + out.string());
  CHECK_THAT(run.out, Contains("the reactions of guide, second-guide are statically"));
  CHECK(nlohmann::json::parse(test::file_text(out / "run.json"))["undetermined_reactions"].size() == 2);
  const auto drawn = test::succeeded("figures " + out.string());
  CHECK_THAT(drawn.out, Contains("reaction_guide.pdf"));
  CHECK(std::filesystem::file_size(out / "figures/reaction_guide.png") > 1000);
  CHECK_THAT(test::file_text(out / "figures/reaction_guide.gp"), Contains("statically indeterminate"));
}
