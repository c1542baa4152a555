// Output play: ranges in closed form or by one-dimensional searches, refusals.
//
// verification/scenes/play/values.csv has the ranges with their sources. They were computed with 30 digits from
// the geometry of each mechanism: a link with loose pins is one of length l ± Σ c, a slider within its guide has
// the offset and tilt that its corners permit, teeth move their wheels by half the backlash along the line of
// action.
#include "analysis/play/play.hpp"

#include "analysis/play/play_allocation.hpp"
#include "analysis/play/play_documents.hpp"
#include "analysis/play/play_loads.hpp"
#include "io/scene/points_file.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// One line of values.csv.
struct KnownRange {
  std::string scene, joint, at, quantity;
  double ideal, least, greatest;
};

std::vector<KnownRange> known_ranges() {
  std::ifstream file(test::source_folder() / "verification/scenes/play/values.csv");
  TextRows rows(std::string(std::istreambuf_iterator<char>(file), {}));
  std::vector<KnownRange> list;
  REQUIRE(rows.next());
  while (rows.next()) {
    const auto& x = rows.fields();
    REQUIRE(x.size() >= 7);
    list.push_back({x[0], x[1], x[2], x[3], std::stod(x[4]), std::stod(x[5]), std::stod(x[6])});
  }
  return list;
}

/// The parts of a text between semicolons.
std::vector<std::string> divided(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ';');) parts.push_back(part);
  return parts;
}

Scene scene_named(const std::string& name) {
  return read_scene(test::source_folder() / "verification/scenes/play" / (name + ".toml"));
}

/// The range of a quantity at a position of a driven joint, or of two, "A;B", at theirs.
PlayRange range_at(Scene scene, const std::string& joint, const std::string& at,
                   const std::string& quantity) {
  PlayOptions options{.quantities = {quantity}};
  if (joint.find(';') == joint.npos) {
    options.over = joint;
    options.from = options.to = std::stod(at);
    options.points = 1;
  } else {
    const auto joints = divided(joint), places = divided(at);
    for (std::size_t k = 0; k < joints.size(); ++k)
      for (auto& drive : scene.mechanism.drives)
        if (auto& d = std::get<SpeedDrive>(drive);
            name_of(scene.mechanism.joints[static_cast<std::size_t>(d.joint)]) == joints[k])
          d.initial_angle = std::stod(places[k]);
  }
  const auto play = find_play(scene, options);
  REQUIRE(play.positions.front().refusal.empty());
  return play.positions.front().ranges.front();
}

std::string refusal_of(const Scene& scene, const PlayOptions& options) {
  try {
    find_play(scene, options);
  } catch (const ModelError& e) {
    return e.what();
  }
  return "";
}

/// A four-bar like four_bar.toml with the clearance c at the crank pin and the pin of the rocker.
Scene four_bar(double c) {
  auto scene = scene_named("four_bar");
  for (auto& joint : scene.mechanism.joints)
    if (auto& pin = std::get<RevoluteJoint>(joint); pin.clearance) pin.clearance->radial = c;
  return scene;
}

}  // namespace

TEST_CASE("ranges of outputs agree with closed forms", "[play]") {
  for (const auto& known : known_ranges()) {
    CAPTURE(known.scene, known.at, known.quantity);
    const auto found = range_at(scene_named(known.scene), known.joint, known.at, known.quantity);
    // Rounding of coordinates of 0.3 m is 4e-13 of a play of 0.1 mm.
    const double play = known.greatest - known.least, rounding = 2e-12 * play;
    CHECK(std::abs(found.ideal - known.ideal) <= rounding);
    CHECK(std::abs(found.least - known.least) <= rounding);
    CHECK(std::abs(found.greatest - known.greatest) <= rounding);
    CHECK(found.bound_least <= found.least);
    CHECK(found.bound_greatest >= found.greatest);
  }
}

TEST_CASE("the bound is the value found", "[play]") {
  // Some joints have no influence at first order: a pin of the parallelogram across its links, the corner R of a
  // slider. The pin of a planet has none on the planet's own angle, at any position.
  for (const auto& known : known_ranges()) {
    CAPTURE(known.scene, known.at, known.quantity);
    const double limit = known.quantity == "planet.theta" ? 1e-4 : 1e-9;
    CHECK(range_at(scene_named(known.scene), known.joint, known.at, known.quantity).gap() < limit);
  }
}

TEST_CASE("bounds contain closed forms where rounding exceeds their gap", "[play]") {
  // Coordinates of 512 m have errors of 6e-14 m. Angles and x do not depend on the height of the ground.
  for (const auto& known : known_ranges()) {
    if (known.scene != "four_bar" || known.quantity == "coupler.y") continue;
    CAPTURE(known.at, known.quantity);
    auto scene = scene_named("four_bar");
    for (auto& joint : scene.mechanism.joints)
      if (auto& pin = std::get<RevoluteJoint>(joint); pin.between[0] == ground)
        pin.at[0] = {pin.at[0].x(), pin.at[0].y() + 512};
    const auto found = range_at(std::move(scene), known.joint, known.at, known.quantity);
    CHECK(found.bound_least <= known.least);
    CHECK(found.bound_greatest >= known.greatest);
    CHECK(found.gap() < 1e-8);
  }
}

TEST_CASE("positions at which rounding keeps Newton's method from converging are refused", "[play]") {
  // With the links almost in line, rounding moves the coupler by 1e-12 m.
  for (const double clearance : {1e-12, 1e-14}) {
    auto scene = scene_named("parallelogram");
    for (auto& joint : scene.mechanism.joints) std::get<RevoluteJoint>(joint).clearance->radial = clearance;
    const auto message = refusal_of(scene, {.quantities = {"rocker.theta", "coupler.x", "coupler.y"},
                                            .over = "A",
                                            .from = 1e-4,
                                            .to = 1.01e-4,
                                            .points = 4});
    CAPTURE(clearance, message);
    CHECK((message.empty() || message.find("no bound") != message.npos));
  }
}

TEST_CASE("the width of a four-bar's rocker has the published digits", "[play]") {
  // The coupler acts as one of length l ± Σ c. Crank angles count from the line of the ground.
  const std::vector<std::pair<double, double>> widths{
      {0, 2.000000224e-3}, {60, 1.719778598e-3}, {90, 1.614414836e-3}, {180, 1.697056820e-3}};
  for (const auto& [degrees, width] : widths) {
    CAPTURE(degrees);
    const auto at = fmt::format("{}", degrees * std::numbers::pi / 180);
    // half of the last digit
    CHECK(std::abs(range_at(scene_named("four_bar"), "A", at, "rocker.theta").width() - width) < 5.01e-13);
  }
}

TEST_CASE("parts of the joints sum to the range, and the linear range is first order", "[play]") {
  // The error of the linear range is of the third order in the clearance: that of the width, whose even orders
  // cancel.
  double last = 0;
  for (const double c : {2e-3, 1e-3, 5e-4}) {
    const auto r = range_at(four_bar(c), "A", "1.0", "coupler.x");
    CHECK(r.parts[0] + r.parts[1] == Approx(r.width()).epsilon(1e-12));
    CHECK(r.variance[0] + r.variance[1] == Approx(1).epsilon(1e-12));
    const double error = std::abs(r.width() - 2 * r.linear);
    if (last > 0) CHECK(std::log2(last / error) == Approx(3).margin(0.1));
    last = error;
  }
}

TEST_CASE("quantiles of one loose pin are those of a point on a disc or a circle", "[play]") {
  // With the crank at 0 the slider moves by c u_x, but for c²/(2 l): the semicircle law, or the arcsine law.
  const double c = 1e-3, pi = std::numbers::pi;
  for (const auto place : {PlayPlace::within, PlayPlace::rim}) {
    PlayOptions options{.quantities = {"slider.x"}, .over = "main", .points = 1};
    options.sampling = {4000, place};
    const auto range = find_play(scene_named("slider_crank"), options).positions.front().ranges.front();
    REQUIRE(range.quantiles);
    for (std::size_t s = 0; s < play_shares.size(); ++s) {
      const double x = (range.quantiles->value[s] - range.ideal) / c,
                   law = place == PlayPlace::rim ? std::asin(x) : x * std::sqrt(1 - x * x) + std::asin(x);
      // Four standard errors of the share, from 80,000 linear samples, and the second order.
      const double share = play_shares[s], error = 4 * std::sqrt(share * (1 - share) / 80000);
      const double density =
          place == PlayPlace::rim ? 1 / (pi * std::sqrt(1 - x * x)) : 2 / pi * std::sqrt(1 - x * x);
      CAPTURE(share, x, range.quantiles->error[s]);
      CHECK(std::abs(0.5 + law / pi - share) <= error + 2e-3 * density);
      CHECK(range.quantiles->error[s] < 0.02 * c);
      CHECK(range.quantiles->value[s] >= range.least);
      CHECK(range.quantiles->value[s] <= range.greatest);
    }
    CHECK(range.quantiles->failed == 0);
  }
}

namespace {

/// The slider-crank with a tolerance and the gudgeon's clearance, in m.
Scene toleranced(const std::string& key, const std::string& more, double clearance) {
  std::vector<std::string> set{fmt::format("tolerances.part.key=\"{}\"", key),
                               fmt::format("joints.gudgeon.clearance={}", clearance)};
  for (const auto& one : divided(more)) set.push_back("tolerances.part." + one);
  return read_scene(test::source_folder() / "verification/scenes/play/slider_crank.toml", set);
}

PlayRange sampled(const Scene& scene, PlayPlace place = PlayPlace::within) {
  PlayOptions options{.quantities = {"slider.x"}, .over = "main", .points = 1};
  options.sampling = {4000, place};
  return find_play(scene, options).positions.front().ranges.front();
}

/// Checks quantiles against the distribution function of (y − ideal)/unit.
void check_law(const PlayRange& range, double unit, const std::function<double(double)>& law) {
  REQUIRE(range.quantiles);
  CHECK(range.quantiles->failed == 0);
  for (std::size_t s = 0; s < play_shares.size(); ++s) {
    const double x = (range.quantiles->value[s] - range.ideal) / unit, share = play_shares[s];
    CAPTURE(share, x);
    // Four standard errors of the share, from 80,000 linear samples, and the second order.
    CHECK(std::abs(law(x) - share) <= 4 * std::sqrt(share * (1 - share) / 80000) + 2e-3);
  }
}

double normal_law(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

}  // namespace

TEST_CASE("a tolerance of a length has its distribution in the output", "[play]") {
  // With the crank at 0 the slider moves by the deviation of the rod's length. The clearance is negligible.
  const std::string rod = "joints.gudgeon.at[0][0]";
  const double half = 2e-5, c = 1e-10;
  check_law(sampled(toleranced(rod, "upper=\"0.02 mm\"", c)), half, [](double x) { return 0.5 + 0.5 * x; });
  check_law(sampled(toleranced(rod, "upper=\"0.02 mm\";distribution=\"normal\"", c)), half / 3, normal_law);
  check_law(sampled(toleranced(rod, "upper=2e-5;distribution=\"truncated\";sigmas=1", c)), half,
            [](double x) { return (normal_law(x) - normal_law(-1)) / (1 - 2 * normal_law(-1)); });
  // +0.03 mm, −0.01 mm: about 0.01 mm
  check_law(sampled(toleranced(rod, "upper=3e-5;lower=-1e-5", c)), half,
            [](double x) { return 0.25 + 0.5 * x; });
  // Limits on one side of the stated value
  check_law(sampled(toleranced(rod, "upper=\"0.04 mm\";lower=0", c)), half, [](double x) { return 0.5 * x; });
}

TEST_CASE("a tolerance of a clearance widens the distribution of the journal's places", "[play]") {
  // A journal on the rim at an angle φ, with a clearance uniform between 0.5 and 1.5 c: the mean of the arcsine laws.
  const double c = 1e-3;
  const auto range =
      sampled(toleranced("joints.gudgeon.clearance", fmt::format("upper={}", 0.5 * c), c), PlayPlace::rim);
  check_law(range, c, [](double x) {
    double sum = 0;
    constexpr int count = 20000;
    for (int i = 0; i < count; ++i) {
      const double y = x / (0.5 + (i + 0.5) / count);
      sum += 0.5 + std::asin(std::clamp(y, -1.0, 1.0)) / std::numbers::pi;
    }
    return sum / count;
  });
  // Extremes are those of the stated clearance.
  CHECK(range.width() == Approx(2 * c).epsilon(1e-5));
  CHECK(range.quantiles->value.back() > range.greatest);
}

TEST_CASE("shares in the variance contain tolerances", "[play]") {
  // A journal on its disc has the variance c²/4, a uniform deviation that of half²/3, a normal one (half/3)²; a
  // normal one cut at one standard deviation 0.29112509 σ², the integral of x² e^(−x²/2) from −1 to 1 over that
  // of e^(−x²/2).
  const std::string rod = "joints.gudgeon.at[0][0]";
  const double c = 1e-3, half = 1e-3;
  const std::vector<std::pair<std::string, double>> cases{
      {"distribution=\"uniform\"", half * half / 3},
      {"distribution=\"normal\"", half * half / 9},
      {"distribution=\"truncated\";sigmas=1", 0.29112509 * half * half}};
  for (const auto& [more, variance] : cases) {
    CAPTURE(more);
    const auto range = sampled(toleranced(rod, fmt::format("upper={};{}", half, more), c));
    REQUIRE(range.variance.size() == 2);
    CHECK(range.variance[1] == Approx(variance / (variance + c * c / 4)).epsilon(1e-6));
  }
}

TEST_CASE("tolerances are checked", "[play]") {
  const auto with = [](const std::string& key, const std::string& more) {
    try {
      sampled(toleranced(key, more, 1e-3));
    } catch (const ModelError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const std::string rod = "joints.gudgeon.at[0][0]";
  CHECK_THAT(with("joints.gudgeon.gap", "upper=1e-5"), Contains("joints.gudgeon.gap"));
  CHECK_THAT(with(rod, "upper=1e-5;lower=2e-5"), Contains("tolerances.part.upper") && Contains("greater"));
  CHECK_THAT(with(rod, "upper=\"1e-5 kg\""), Contains("tolerances.part.upper") && Contains("kg"));
  CHECK_THAT(with(rod, "upper=1e-5;distribution=\"gauss\""), Contains("truncated"));
  CHECK_THAT(with("joints.gudgeon.clearance", "upper=2e-3"), Contains("clearance"));
}

TEST_CASE("a loaded journal rests where its weight presses it", "[play]") {
  // At the crank angle 0 the weight of rod and slider is vertical: the rod lies on the slider's pin, c below it,
  // and the slider is nearer by c²/(2 l). Half of the rod's weight is the reaction.
  auto scene = scene_named("slider_crank");
  scene.mechanism.gravity = {0, -9.81};
  const auto play =
      find_play(scene, {.quantities = {"slider.x"}, .over = "main", .points = 1, .loads = true});
  const auto& p = play.positions.front();
  REQUIRE(p.up.failure.empty());
  const double l = 0.3, c = 1e-3;
  CHECK(p.up.values[0] - 0.35 == Approx(std::sqrt(l * l - c * c) - l).epsilon(1e-6));
  const auto gudgeon =
      static_cast<std::size_t>(std::ranges::find(play.reactions, "gudgeon") - play.reactions.begin());
  const double mass = scene.mechanism.bodies[1].mass;
  CHECK(std::abs(p.up.reactions[3 * gudgeon + 1]) == Approx(0.5 * mass * 9.81).epsilon(1e-4));
  CHECK(lost_motion(play, 0) == 0);
  CHECK(p.up.values[0] >= p.ranges[0].bound_least);
  CHECK(p.up.values[0] <= p.ranges[0].bound_greatest);
}

TEST_CASE("allocated clearances are those of the closed form", "[play]") {
  // Both pins of the coupler have the same influence, and the sum of their clearances alone determines the width: it
  // is 0.2 mm for that of the scene. Costs b_k/c_k are least with c_k in the ratio of √b_k; limits cut them.
  const auto scene = scene_named("four_bar");
  const PlayOptions options{
      .quantities = {"rocker.theta"}, .over = "A", .to = 2 * std::numbers::pi, .points = 37};
  const double width = range_at(scene, "A", "0", "rocker.theta").width();
  using Limit = AllocatedClearance::Limit;
  const auto found =
      allocate_clearances(scene, options, width, {{"B", 4, 1, 1e-6, 1e-3}, {"C", 1, 1, 1e-6, 1e-3}});
  CHECK(found.clearances[0].after == Approx(0.4e-3 / 3).epsilon(1e-7));
  CHECK(found.clearances[1].after == Approx(0.2e-3 / 3).epsilon(1e-7));
  CHECK(found.cost == Approx(4 * 0.75 + 1.5).epsilon(1e-7));
  CHECK(found.clearances[0].limit == Limit::none);
  const auto cut =
      allocate_clearances(scene, options, width, {{"B", 4, 1, 1e-6, 0.11e-3}, {"C", 1, 1, 1e-6, 1e-3}});
  CHECK(cut.clearances[0].after == Approx(0.11e-3).epsilon(1e-7));
  CHECK(cut.clearances[1].after == Approx(0.09e-3).epsilon(1e-7));
  CHECK(cut.clearances[0].limit == Limit::greatest);
  CHECK_THROWS_WITH(allocate_clearances(scene, options, 0.1 * width, {{"B", 1, 1, 1e-6, 1e-3}}),
                    Contains("cannot be met"));
  CHECK_THROWS_WITH(allocate_clearances(scene, options, width, {{"A", 1, 1, 1e-6, 1e-3}}),
                    Contains("no joint with"));
}

TEST_CASE("gears far from the mass centre of their body have a range", "[play]") {
  // A forearm that backlash b turns by b/(2 r_b): its mass centre, 0.3 m from the wheel's axis, moves on a circle.
  const std::string text =
      test::body("pinion", 1, 1) + test::body("arm", 1, 1, "position = [0.36, 0.0]\nangle = 0.0\n") +
      test::pin("input", "ground", "pinion") + test::pin("axis", "ground", "arm", {0.06, 0}, {-0.3, 0}) +
      "[joints.mesh]\ntype = \"gear\"\nbetween = [\"pinion\", \"arm\"]\nat = [[0, 0], [-0.3, 0]]\n"
      "teeth = [20, 40]\nmodule = 2e-3\nphase = 0.0\nbacklash = 1e-4\nsurface = \"s\"\n" +
      test::surface("s", 0.5) + test::motor("motor", "input", 1) + test::run_for(1);
  const auto play = find_play(parse_scene(text, "arm"), {.quantities = {"arm.theta", "arm.y"}});
  const double turn = 0.5e-4 / (0.04 * std::cos(std::numbers::pi / 9));
  const auto& ranges = play.positions.front().ranges;
  CHECK(ranges[0].width() == Approx(2 * turn).epsilon(1e-9));
  CHECK(ranges[1].width() == Approx(2 * 0.3 * std::sin(turn)).epsilon(1e-9));
  CHECK(ranges[1].gap() < 1e-9);
}

TEST_CASE("an output at its extreme has the range of second order", "[play]") {
  // The tip of a vertical arm: backlash lowers it by l (1 − cos φ) and does not raise it.
  const std::string text =
      test::body("pinion", 1, 1) + test::body("arm", 1, 1, "position = [0.06, 0.0]\nangle = 0.0\n") +
      test::pin("input", "ground", "pinion") + test::pin("axis", "ground", "arm", {0.06, 0}) +
      "[joints.mesh]\ntype = \"gear\"\nbetween = [\"pinion\", \"arm\"]\nat = [[0, 0], [0, 0]]\n"
      "teeth = [20, 40]\nmodule = 2e-3\nphase = 0.0\nbacklash = 1e-4\nsurface = \"s\"\n" +
      test::surface("s", 0.5) + test::motor("motor", "input", 1) + test::run_for(1);
  auto scene = parse_scene(text, "arm");
  scene.mechanism.bodies[1].points = {{"tip", {0.3, 0}}};
  const auto play = find_play(scene, {.quantities = {"arm.tip.x"}});
  const auto& r = play.positions.front().ranges.front();
  const double turn = 0.5e-4 / (0.04 * std::cos(std::numbers::pi / 9));
  CHECK(r.ideal - r.least == Approx(0.3 * (1 - std::cos(turn))).epsilon(1e-6));
  CHECK(r.greatest - r.ideal < 1e-15);
}

TEST_CASE("a parallelogram is not followed through the position in line", "[play]") {
  CHECK_THAT(refusal_of(scene_named("parallelogram"),
                        {.quantities = {"rocker.theta"}, .over = "A", .from = 1, .to = -1, .points = 2}),
             Contains("cannot be moved"));
}

TEST_CASE("positions without a range are refused with the reason", "[play]") {
  const auto scene = scene_named("four_bar");
  const PlayOptions at_start{.quantities = {"rocker.theta"}};
  CHECK_THAT(refusal_of(scene, {.quantities = {"rocker.tip"}}),
             Contains("no quantity") && Contains("coupler"));
  CHECK_THAT(refusal_of(scene, {.quantities = {"rocker.theta"}, .over = "B", .to = 1}),
             Contains("no drive prescribes") && Contains("A"));
  auto undriven = scene;
  undriven.mechanism.drives.clear();
  CHECK_THAT(refusal_of(undriven, at_start), Contains("needs a drive") && Contains("rotation at"));
  CHECK_THAT(refusal_of(four_bar(0.04), at_start), Contains("dead centre"));
  auto ideal = scene;
  ideal.mechanism = idealised(ideal.mechanism);
  CHECK_THAT(refusal_of(ideal, at_start), Contains("no joint has clearance"));
  CHECK_THAT(refusal_of(scene_named("dead_point"),
                        {.quantities = {"output.theta"}, .over = "A", .from = 0, .to = 6, .points = 3}),
             Contains("cannot be moved") && Contains("dead centre"));
  CHECK_THAT(refusal_of(scene_named("gear_loose"), {.quantities = {"wheel.x"}}), Contains("both sides"));
}

namespace {

/// The boundary of a region has the farthest places, farthest(φ), and its bounds are their distances.
void check_region(const PointRegion& region, auto farthest) {
  REQUIRE(region.farthest.size() == 72);
  for (std::size_t d = 0; d < region.farthest.size(); ++d) {
    const auto& b = region.farthest[d];
    const double phi = static_cast<double>(d) * std::numbers::pi / 36;
    const auto known = farthest(phi);
    constexpr double rounding = 5e-15;  // m, of coordinates of 0.4 m
    CAPTURE(region.point, region.position, d);
    CHECK(b.direction == Approx(phi).margin(1e-15));
    CHECK(std::abs(b.x - known.x()) <= rounding);
    CHECK(std::abs(b.y - known.y()) <= rounding);
    const double reach =
        std::cos(phi) * (known.x() - region.ideal_x) + std::sin(phi) * (known.y() - region.ideal_y);
    CHECK(b.bound >= reach);
    CHECK(b.bound <= reach + rounding);
  }
}

/// The one of some places that is farthest along φ.
Vec2 farthest_of(const std::vector<Vec2>& places, double phi) {
  return *std::ranges::max_element(
      places, {}, [&](const Vec2& p) { return std::cos(phi) * p.x() + std::sin(phi) * p.y(); });
}

}  // namespace

TEST_CASE("the region of an arm's tip is a disc", "[play]") {
  // The drives hold the directions of both links, so that the tip moves by the sum of the eccentricities of its
  // pins: a disc with the radius c₁ + c₂.
  const double c1 = 1e-4, c2 = 2e-4;
  const std::string text = test::body("upper", 1, 1, "position = [0.15, 0.0]\nangle = 0.0\n") +
                           test::body("fore", 1, 1, "position = [0.38, 0.1]\nangle = 1.0\n") +
                           test::pin("shoulder", "ground", "upper", {}, {-0.15, 0}, test::loose(c1, 5e-3)) +
                           test::pin("elbow", "upper", "fore", {0.15, 0}, {-0.1, 0}, test::loose(c2, 5e-3)) +
                           test::surface("s", 0.5) + test::motor("first", "shoulder", 1) +
                           test::motor("second", "elbow", 1, "initial_angle = 1.0\n") +
                           "[assembly]\napproximate = true\n" + test::run_for(1);
  auto scene = parse_scene(text, "arm");
  scene.mechanism.bodies[1].points = {{"tip", {0.1, 0}}};
  const PlayOptions options{
      .quantities = {"fore.tip.x", "fore.tip.y"}, .over = "shoulder", .to = 2, .points = 9};
  const auto play = find_play(scene, options);
  REQUIRE(play.regions.size() == 4);
  for (const auto& region : play.regions) {
    const double turn = play.positions[region.position].coordinate;
    const Vec2 tip{0.3 * std::cos(turn) + 0.2 * std::cos(turn + 1),
                   0.3 * std::sin(turn) + 0.2 * std::sin(turn + 1)};
    check_region(region, [&](double phi) {
      return Vec2{tip.x() + (c1 + c2) * std::cos(phi), tip.y() + (c1 + c2) * std::sin(phi)};
    });
  }
  CHECK(play_region_table(play).rows().size() == 4 * 72);
  auto one = options;
  one.quantities.pop_back();
  CHECK(find_play(scene, one).regions.empty());
}

TEST_CASE("the region of a five-bar's pin is that of two annuli", "[play]") {
  // The couplers act as links of the lengths l₁ ± c_B and l₂ ± (c_C + c_D) from the pins B and D of the cranks. The
  // region has four corners. The outer arcs have a farthest place between the corners only in directions that
  // differ from that of a link by less than 0.05°.
  const double left = 1.7453292519943296, right = 1.2217304763960307;
  const Vec2 B{0.1 * std::cos(left), 0.1 * std::sin(left)},
      D{0.3 + 0.12 * std::cos(right), 0.12 * std::sin(right)};
  std::vector<Vec2> corners;
  for (const double r1 : {0.25 - 0.05e-3, 0.25 + 0.05e-3})
    for (const double r2 : {0.22 - 0.14e-3, 0.22 + 0.14e-3}) {
      const double dx = D.x() - B.x(), dy = D.y() - B.y(), distance = std::hypot(dx, dy);
      const double along = (r1 * r1 - r2 * r2 + distance * distance) / (2 * distance),
                   across = std::sqrt(r1 * r1 - along * along);
      corners.push_back(
          Vec2{B.x() + (along * dx - across * dy) / distance, B.y() + (along * dy + across * dx) / distance});
    }
  const auto play = find_play(scene_named("five_bar"), {.quantities = {"coupler1.tip.x", "coupler1.tip.y"}});
  REQUIRE(play.regions.size() == 1);
  CHECK(play.regions[0].point == "coupler1.tip");
  check_region(play.regions[0], [&](double phi) { return farthest_of(corners, phi); });
}

TEST_CASE("the region of a rod's middle is an arc", "[play]") {
  // The gudgeon lets the end of the rod be c above and below the line of the slider, so the rod turns about the
  // crank pin between both ends. No direction is within the angle of the arc, 6.6° to 7.0° below the x axis.
  const double r = 0.05, l = 0.3, c = 1e-3, crank = 0.78539816339744831;
  std::vector<Vec2> ends;
  for (const double height : {-c, c}) {
    const double sine = (height - r * std::sin(crank)) / l;
    ends.push_back(
        Vec2{r * std::cos(crank) + l / 2 * std::sqrt(1 - sine * sine), r * std::sin(crank) + l / 2 * sine});
  }
  const auto play = find_play(scene_named("slider_crank"), {.quantities = {"rod.x", "rod.y"}});
  REQUIRE(play.regions.size() == 1);
  check_region(play.regions[0], [&](double phi) { return farthest_of(ends, phi); });
}
