// Classes of refusals: a misspelt key in every possible place, and studies that cannot be
// calibrated.
#include "io/scene/schema.hpp"
#include "study/calibration/calibrate.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += line + "\n";
  return text;
}

const std::string study_head = "scene = \"" +
                               (test::source_folder() / "cases/flores2011-experiment/guide.toml").string() +
                               R"("
joint = "gudgeon"
accelerometer = "accelerometer"
position = "lvdt"
revolutions = 1
discard = 0.5
starts = 1
)";

}  // namespace

TEST_CASE("unknown keys are refused in every table of every kind", "[scene][refused]") {
  // One scene contains every kind of element; a drive by torque is in it, and one at a prescribed
  // speed in another.
  const auto lines = test::lines_of(test::file_text(test::scene_file("every_key")));
  int tables = 0, keys = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    auto changed = lines;
    const auto equals = lines[i].find(" =");
    if (lines[i].starts_with("[")) {
      changed.insert(changed.begin() + static_cast<long>(i) + 1, "qqq = 1");
      const auto said = test::refusal(joined(changed));
      CAPTURE(lines[i], said);
      CHECK_THAT(said, Contains(fmt::format("s.toml:{}:", i + 2)) && Contains("qqq: is not a key of"));
      ++tables;
    } else if (!lines[i].starts_with("#") && equals != std::string::npos) {
      // One letter too many: the message names it, or the key missing or misplaced as a
      // consequence.
      changed[i].insert(equals, "q");
      const auto said = test::refusal(joined(changed));
      CAPTURE(lines[i], said);
      CHECK_THAT(said, Contains("s.toml:"));
      ++keys;
    }
  }
  CHECK(tables > 30);
  CHECK(keys > 120);
}

TEST_CASE("studies that cannot be calibrated are refused with the reason", "[study][refused]") {
  test::TemporaryFolder folder;
  const auto says = [&](const std::string& unknowns, const std::string& targets,
                        const std::string& options = "") {
    write_file(folder.path() / "study.toml",
               study_head + "[calibrate]\n" + options + "\n" + unknowns + targets);
    return test::refusal_of([&] { plan_calibration(read_study(folder.path() / "study.toml"), Conduct{}); });
  };
  const std::string unknown = "[calibrate.unknowns.a]\nkey = \"loads.bearing.force\"\nlow = 1\nhigh = 2\n",
                    target = "[calibrate.targets.t]\nstatistic = \"rms\"\n", good = target + "value = 3.0\n";
  CHECK_THAT(says("", good), Contains("unknowns: must name at least one unknown"));
  CHECK_THAT(says(unknown, ""), Contains("targets: must name at least one target"));
  CHECK_THAT(says(unknown, target), Contains("targets.t: needs exactly one of value and data"));
  CHECK_THAT(says(unknown, good + "data = \"x.csv\"\n"), Contains("needs exactly one of value and data"));
  CHECK_THAT(says(unknown, good + "tolerance = 0\n"), Contains("tolerance: must be greater than 0"));
  CHECK_THAT(says(unknown, target + "value = 0\n"), Contains("targets.t.value must be greater than 0"));
  CHECK_THAT(says(unknown, target + "value = -2.0\n"), Contains("targets.t.value must be greater than 0"));
  CHECK_THAT(says("[calibrate.unknowns.a]\nkey = \"x\"\nlow = 2\nhigh = 2\n", good),
             Contains("high: must be greater than low"));
  CHECK_THAT(says("[calibrate.unknowns.a]\nkey = \"x\"\nlow = 0\nhigh = 2\nscale = \"log\"\n", good),
             Contains("low: must be greater than 0 on a log scale"));
  CHECK_THAT(says("[calibrate.unknowns.a]\nkey = \"x\"\nlow = 1\nhigh = 2\nscale = \"lag\"\n", good),
             Contains("\"lag\" is unknown"));
  // A quadratic in one unknown has three coefficients, in two six; two points more are needed to
  // know its error.
  CHECK_THAT(says(unknown, good, "points = 4"), Contains("points must be at least 5 for 1 unknowns, is 4"));
  CHECK_THAT(says(unknown + "[calibrate.unknowns.b]\nkey = \"x\"\nlow = 1\nhigh = 2\n", good, "points = 7"),
             Contains("points must be at least 8 for 2 unknowns, is 7"));
  for (const auto* options : {"points = 1.5", "points = 0", "starts = 0", "revolutions = 0",
                              "formulation = \"magic\"", "point = 20"}) {
    const auto said = says(unknown, good, options);
    CAPTURE(options, said);
    CHECK_THAT(said, Contains("study.toml:9:") && Contains(std::string(options).substr(0, 5)));
  }
  CHECK_THAT(says(unknown + "unitt = \"N\"\n", good),
             Contains("unitt: is not a key of an unknown; did you mean unit?"));
  CHECK_THAT(says(unknown, good + "tolerence = 1\n"),
             Contains("tolerence: is not a key of a target; did you mean tolerance?"));
  write_file(folder.path() / "plain.toml", study_head);
  CHECK_THROWS_WITH(plan_calibration(read_study(folder.path() / "plain.toml"), Conduct{}),
                    Contains("has no [calibrate]"));
}

TEST_CASE("a fit on noise-free surfaces equals the fit of f(ξ)", "[study]") {
  // y = c + b ξ exactly, so with w = 0.1 and s the tolerance f = (c + bξ − m)²/s² + wξ² is least at
  // ξ = b(m − c)/(b² + w s²), and half its second derivative is b²/s² + w.
  const double c = 0.3, b = 0.8, s = 0.25, w = 0.1;
  const auto points = space_filling(1, 20);
  Eigen::VectorXd y(20);
  for (int i = 0; i < 20; ++i) y[i] = c + b * points(i, 0);
  const auto misfit = [&](double m) {
    return Misfit({{ResponseSurface(points, y), m, s, {}, 0, 0, 0}}, {{}});
  };
  const Unknown linear{"a", "x", "", 10, 30, false}, logarithmic{"a", "x", "", 10, 1000, true};
  for (const double m : {0.3, 0.5, -0.1}) {
    const auto f = fit(misfit(m), {true}, {linear});
    const double xi = b * (m - c) / (b * b + w * s * s), sigma = 1 / std::sqrt(b * b / (s * s) + w);
    CAPTURE(m, xi, sigma);
    CHECK(f.xi[0] == Approx(xi).margin(1e-6));
    CHECK(f.unknowns[0].value == Approx(20 + 10 * xi).margin(1e-5));
    CHECK(f.unknowns[0].low == Approx(std::max(10.0, 20 + 10 * (xi - 1.96 * sigma))).margin(1e-4));
    CHECK(f.unknowns[0].high == Approx(std::min(30.0, 20 + 10 * (xi + 1.96 * sigma))).margin(1e-4));
    CHECK(f.objective == Approx(std::pow((c + b * xi - m) / s, 2) + w * xi * xi).margin(1e-8));
    CHECK(f.on_surface[0].value == Approx(std::exp(c + b * xi)).epsilon(1e-5));
    CHECK(f.on_surface[0].high == Approx(std::exp(c + b * xi + 1.96 * b * sigma)).epsilon(1e-4));
    CHECK_FALSE(f.at_bound(0));
  }
  // On a logarithmic scale equal steps of ξ are equal ratios; values beyond the range end at its
  // bound.
  CHECK(unscaled(logarithmic, 0) == Approx(100));
  CHECK(unscaled(linear, -0.5) == Approx(15));
  const auto beyond = fit(misfit(c + 3 * b), {true}, {logarithmic});
  CHECK(beyond.at_bound(0));
  CHECK(beyond.unknowns[0].value == Approx(1000).epsilon(1e-3));
  // Without a target only the pull acts: ξ is 0 ± √10, beyond the range and so open at both ends.
  const auto open = fit(misfit(c + 3 * b), {false}, {linear});
  CHECK(open.unknowns[0].value == Approx(20).margin(1e-6));
  CHECK(open.unknowns[0].low == 10);
  CHECK(open.unknowns[0].high == 30);
  CHECK(open.unknowns[0].open_low);
  CHECK(open.unknowns[0].open_high);
}
