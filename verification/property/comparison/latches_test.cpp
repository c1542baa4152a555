// Mechanisms of outlines: a Geneva wheel and a latch at its greatest force against closed forms, a deadbeat
// escapement against an independent integration.
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// The wheel of cases/geneva-wheel at time t. The pin is on the driving side of the slot, at a distance c
/// from its middle, a sin(α + β) − C sin β = c, from the crank angle at which it reaches that side to the one
/// at which it moves along it. Between these motions the wheel rests.
struct Geneva {
  static constexpr double a = 0.05, C = 0.070710678118654752, c = 5e-5, start = -M_PI / 3;
  double stop = std::asin((a - c) / C), rest = stop - M_PI / 2;
  double entry = std::asin((c - C * std::cos(stop)) / a) - rest, exit = M_PI / 2 - stop;

  double time(double alpha) const { return (alpha - start) / (2 * M_PI); }
  double angle(double t) const {
    const double total = start + 2 * M_PI * t, turn = std::floor((total + M_PI) / (2 * M_PI));
    const double alpha = total - 2 * M_PI * turn, before = rest + turn * M_PI / 2;
    if (alpha < entry) return before;
    if (alpha > exit) return before + M_PI / 2;
    const double A = a * std::sin(alpha), B = a * std::cos(alpha) - C;
    return std::atan2(B, A) + std::acos(c / std::hypot(A, B)) + turn * M_PI / 2;
  }
};

/// A block that a force F pulls along x, and a pawl whose round end a force P presses on the ramp of the
/// block's tooth, inclined by γ. Both are guided without rotation. The ramp slips at F = P tan(γ + atan μ).
struct Latch {
  double pull, press = 20, incline = std::atan(0.8), friction = 0.2, block = 2, pawl = 0.5, restitution = 0;
  double greatest() const { return press * std::tan(incline + std::atan(friction)); }
  /// m/s², of the block, when the ramp slips: N (sin γ + μ cos γ) acts on it, N (cos γ − μ sin γ) on the
  /// pawl.
  double acceleration() const {
    const double slope = std::tan(incline);
    return (pull - greatest()) / (block + pawl * slope * std::tan(incline + std::atan(friction)));
  }
  std::string text(double duration) const {
    const double R = 0.01, width = 0.05, height = 0.04;
    // The pawl touches the middle of the right ramp.
    const Vec2 at = Vec2{0.5 * width, 0.5 * height} + R * Vec2{std::sin(incline), std::cos(incline)};
    return "gravity = [0, 0]\n" + test::body("block", block, 1e-3, "position = [0, 0]\nvelocity = [0, 0]\n") +
           test::body("pawl", pawl, 1e-4,
                      fmt::format("position = [{:.17g}, {:.17g}]\nvelocity = [0, 0]\n", at.x(), at.y())) +
           test::guide("rail", "ground", "block", {1, 0}) +
           test::guide("stem", "ground", "pawl", {0, 1}, at) +
           test::surface("s", restitution, friction, "young = 2e11\npoisson = 0.3\n") +
           "[contacts.tooth]\ntype = \"outline\"\nbetween = [\"block\", \"pawl\"]\n"
           "points = [[-0.05, 0], [0.05, 0], [0, 0.04]]\ncorner_radius = 1e-3\nradius = 0.01\n"
           "surface = \"s\"\n" +
           test::force("pull", "block", {pull, 0}) + test::force("press", "pawl", {0, -press}) +
           test::run_for(duration, "start = \"given\"\n");
  }
};

const test::Way rigid[] = {test::event_driven, test::automatic, test::chosen_steps, test::fixed_steps(1e-4)};

}  // namespace

TEST_CASE("a Geneva wheel turns and rests as its geometry says", "[outline]") {
  const Geneva expected;
  auto scene =
      read_scene(test::source_folder() / "cases/geneva-wheel/scene.toml", {"surfaces.steel.restitution=0"});
  const auto exact = test::motion_rows(scene, Family::nonsmooth, 1e-3);
  // The mouth of the slot recedes by c²/(2 (r + R)) = 2.3e-7 m at the end of a step, 5e-6 rad at 50 mm.
  CHECK(exact.worst([&](const auto& row) { return row.q[2] - expected.angle(row.t); }) < 5e-6);
  // The pin approaches at 4.4e-4 m/s; positions have errors below 1e-10 m.
  CHECK(test::touch(exact.run, 0).t == Approx(expected.time(expected.entry)).margin(1e-6));
  CHECK(expected.time(expected.entry) == Approx(0.04205070883688835).epsilon(1e-12));
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  // a fifth of the clearance, at 20 mm from the wheel's centre
  const double loose = 0.2 * Geneva::c / 0.02;
  const auto stepped = test::motion_rows(scene, Family::nonsmooth, 1e-3);
  CHECK(stepped.worst([&](const auto& row) { return row.q[2] - expected.angle(row.t); }) < loose);
  scene = read_scene(test::source_folder() / "cases/geneva-wheel/scene.toml");
  const auto soft = test::motion_rows(scene, Family::penalty, 1e-3);
  // A pin that leaves its side stays within the clearance, 2 c on 20 mm.
  CHECK(soft.worst([&](const auto& row) { return row.q[2] - expected.angle(row.t); }) < 2 * Geneva::c / 0.02);
}

TEST_CASE("a latch holds below its greatest force and slips above it", "[outline]") {
  Latch latch{0};
  latch.pull = 0.999 * latch.greatest();
  for (const auto& way : rigid) {
    CAPTURE(way.name);
    const auto held = test::finished(way, latch.text(0.05)).final_state;
    CHECK(std::abs(held.q[0]) < 1e-9);  // sticking is exact
    CHECK(std::abs(held.v[0]) < 1e-9);
  }
  latch.pull = 1.1 * latch.greatest();
  REQUIRE(latch.acceleration() > 0);
  const double t = 0.08, moved = 0.5 * latch.acceleration() * t * t;
  REQUIRE(moved < 0.02);  // on the ramp
  for (const auto& way : rigid) {
    CAPTURE(way.name);
    const auto slipped = test::finished(way, latch.text(t)).final_state;
    CHECK(slipped.q[0] == Approx(moved).epsilon(1e-6));
    CHECK(slipped.v[0] == Approx(latch.acceleration() * t).epsilon(1e-6));
    // The pawl rises by the slope of the ramp.
    CHECK(slipped.v[4] / slipped.v[0] == Approx(std::tan(latch.incline)).epsilon(1e-9));
  }
}

TEST_CASE("a latch with penalty contact creeps with its regularised friction, and slips", "[outline]") {
  // Ambrósio's friction is μ (u − v₀)/(v₁ − v₀) between v₀ and v₁. A latch at rest has the sliding speed u at
  // which the friction suffices, tan(γ + atan μ_u) = F/P, and its block u cos γ.
  constexpr double v0 = 1e-6, v1 = 1e-5;
  const test::Way soft{
      "penalty",
      Family::penalty,
      {},
      0,
      {fmt::format("penalty.friction_v0={}", v0), fmt::format("penalty.friction_v1={}", v1)}};
  for (const double share : {0.9, 0.95}) {
    CAPTURE(share);
    Latch latch{.pull = 0, .restitution = 0.2};
    latch.pull = share * latch.greatest();
    const double friction = std::tan(std::atan(latch.pull / latch.press) - latch.incline),
                 creep = (v0 + friction / latch.friction * (v1 - v0)) * std::cos(latch.incline), t = 0.08;
    const auto run = test::finished(soft, latch.text(t));
    CHECK(run.final_state.v[0] == Approx(creep).epsilon(1e-6));
    // The contact starts without force and sinks in by δ, along the ramp by up to δ/sin γ.
    CHECK(run.final_state.q[0] - creep * t > 0);
    CHECK(run.final_state.q[0] - creep * t < run.extremes.penetration[0] / std::sin(latch.incline));
  }
  Latch latch{.pull = 0, .restitution = 0.2};
  latch.pull = 1.1 * latch.greatest();
  const auto early = test::finished(soft, latch.text(0.04)).final_state,
             late = test::finished(soft, latch.text(0.08)).final_state;
  // The vibration of the start has decayed after 0.02 s: the rest moves as a rigid latch.
  CHECK(late.v[0] - early.v[0] == Approx(0.04 * latch.acceleration()).epsilon(1e-6));
  CHECK(late.v[4] / late.v[0] == Approx(std::tan(latch.incline)).epsilon(1e-6));
}

TEST_CASE("a deadbeat escapement moves as an independent integration says", "[outline]") {
  // cases/escapement without restitution. Expected: the angles of both bodies by SciPy's DOP853 at 1e-11, with
  // a constraint N a = γ for a resting pin and impacts by N M⁻¹ Nᵀ P = −N v. At 3e-13 its times change by
  // 1e-12 s. The bound is a thousand steps of tolerance 1e-8.
  const auto scene = read_scene(test::source_folder() / "cases/escapement/scene.toml",
                                {"surfaces.steel.restitution=0", "run.duration=1.3"});
  const auto run = test::finished(scene, Family::nonsmooth);
  const std::vector<double> lands = {0.16500186770439798, 0.41772989292024054, 0.66464177918983,
                                     0.9173570645389209, 1.1644005421294712},
                            leaves = {0.15767993141404432, 0.410498833812579, 0.6573161850408737,
                                      0.9101227701623379, 1.1570719293546068};
  std::vector<double> found_lands, found_leaves;
  for (const auto& e : run.events)
    if (e.t > 1e-3)  // the first pin rests at the start
      (e.kind == EventKind::separation ? found_leaves : found_lands).push_back(e.t);
  REQUIRE(found_lands.size() == lands.size());
  REQUIRE(found_leaves.size() == leaves.size());
  for (std::size_t i = 0; i < lands.size(); ++i) {
    CHECK(found_lands[i] == Approx(lands[i]).margin(1e-5));
    CHECK(found_leaves[i] == Approx(leaves[i]).margin(1e-5));
  }
  const auto& end = run.final_state;
  CHECK(end.q[2] == Approx(0.060481285616083465).margin(1e-5));
  CHECK(end.v[2] == Approx(-0.5340454632302891).margin(1e-4));
  CHECK(end.q[5] == Approx(-0.46322817536341276).margin(1e-5));
}

TEST_CASE("the anchor of an escapement passes its middle in every scheme as an independent integration says",
          "[outline]") {
  // cases/escapement/README.md: SciPy's DOP853, without restitution, six digits. Fixed steps: pins leave and
  // land up to h late. Penalty: restitution 0.2, so that a pin rests 4.5 ms after it lands, with the same sum
  // of impulses. Margin: 1e-5 of the period.
  const double passages[] = {0.126112, 0.376393, 0.626630, 0.876844, 1.127019};
  for (const auto& way : {test::event_driven, test::chosen_steps, test::fixed_steps(1e-4), test::penalty}) {
    CAPTURE(way.name);
    std::vector<std::string> options{"run.duration=1.3"};
    if (!way.penalty()) options.push_back("surfaces.steel.restitution=0");
    auto scene = read_scene(test::source_folder() / "cases/escapement/scene.toml", options);
    way.choose(scene);
    const auto motion = test::motion_rows(scene, way.family, 1e-3);
    std::vector<double> found;
    for (std::size_t i = 1; i < motion.rows.size(); ++i) {
      const auto &a = motion.rows[i - 1], &b = motion.rows[i];
      // Linear: the cube of the phase per row, 2e-8 s.
      if (a.q[2] * b.q[2] < 0) found.push_back(a.t + (b.t - a.t) * a.q[2] / (a.q[2] - b.q[2]));
    }
    REQUIRE(found.size() == std::size(passages));
    const double error = way.penalty() || way.fixed() ? 5e-6 : 1e-6;
    for (std::size_t i = 0; i < found.size(); ++i)
      CHECK(found[i] == Approx(passages[i]).epsilon(0).margin(error));
    // The end of the integration; its greatest speed is 0.8 rad/s.
    CHECK(motion.run.final_state.q[2] == Approx(0.060481285616083465).epsilon(0).margin(2 * error));
    CHECK(motion.run.final_state.q[5] == Approx(-0.46322817536341276).epsilon(0).margin(2 * error));
  }
}
