// User-supplied applied forces: closed forms in both formulations, in world and in body axes; their
// report.
#include "facade/law_plugin.hpp"
#include "mechanism/outside.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

constexpr double k = 40, damping = 1.5, mass = 2, shove = 3;

/// F = (−k x − c ẋ + shove, 0): from rest at 0 the step response of a damped oscillator.
Vec2 oscillator(const void*, const char*, double, const Vec2& r, const Vec2& v) {
  return {shove - k * r.x() - damping * v.x(), 0};
}
double step_response(double t) {
  const double decay = damping / (2 * mass), w = std::sqrt(k / mass - decay * decay);
  return shove / k * (1 - std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t)));
}
/// A force proportional to time.
Vec2 ramp(const void*, const char*, double t, const Vec2&, const Vec2&) { return {shove * t, 0}; }

/// A free body, rotating at 2 rad/s, with a load whose force that of the user replaces.
Scene free_body(const std::string& more = {}, const std::vector<std::string>& overrides = {}) {
  return parse_scene(test::body("block", 2, 0.1, "angular_velocity = 2\n") +
                         "[loads.hand]\ntype = \"force\"\nbody = \"block\"\nforce = [5, 7]\n" + more +
                         test::run_for(1.5, "start = \"given\"\n"),
                     "block", overrides);
}

Outside in_hand(decltype(OwnForce::force) force, const char* name = "function") {
  return {.forces = {{"hand", std::make_shared<OwnForce>(OwnForce{force, {}, name, "0123"})}}};
}

struct Way {
  const char *formulation, *key, *value;
  double bound;  ///< m, of displacements of about 0.1 m
};

}  // namespace

TEST_CASE("a body under a user-supplied spring and damper moves as in the closed form", "[own-force]") {
  // Bounds: tolerances of 1e-9 and 1e-10 times the steps; a fixed step of 1 ms is of second order,
  // 1e-3² times x'''/12.
  const auto way = GENERATE(Way{"penalty", "penalty.integrator", "dopri5", 1e-7},
                            Way{"penalty", "penalty.integrator", "adams_bashforth_moulton", 1e-7},
                            Way{"penalty", "penalty.integrator", "rosenbrock4", 1e-6},
                            Way{"nonsmooth", "nonsmooth.scheme", "event-driven", 1e-7},
                            Way{"nonsmooth", "nonsmooth.step", "1e-3", 1e-5});
  CAPTURE(way.value);
  auto scene = free_body("", {fmt::format("{}={}", way.key, way.value)});
  put(scene, in_hand(oscillator));
  Simulation simulation(scene, way.formulation);
  const auto result = test::finished(simulation);
  CHECK(result.final_state.q[0] == Approx(step_response(1.5)).margin(way.bound));
  CHECK(result.final_state.q[2] == Approx(3).margin(1e-9));
  CHECK(std::abs(result.ledger.closure()) < 1e-4 * result.ledger.scale());
}

TEST_CASE("a user-supplied force in body axes turns with the body", "[own-force]") {
  // m ẍ = F t cos 2t, m ÿ = F t sin 2t from rest: integrated twice by hand.
  const auto formulation = GENERATE("penalty", "nonsmooth");
  auto scene = free_body("axes = \"body\"\n");
  put(scene, in_hand(ramp));
  const auto q = Simulation(scene, formulation).run().final_state.q;
  const double t = 1.5, a = shove / mass, w = 2;
  const double x = a * (2 * std::sin(w * t) / (w * w * w) - t * std::cos(w * t) / (w * w) - t / (w * w));
  const double y = a * (2 / (w * w * w) - t * std::sin(w * t) / (w * w) - 2 * std::cos(w * t) / (w * w * w));
  CHECK(q[0] == Approx(x).margin(1e-6));
  CHECK(q[1] == Approx(y).margin(1e-6));
}

TEST_CASE("a user-supplied force is reported and is part of the identity of a run", "[own-force]") {
  auto scene = free_body();
  const auto before = Simulation(scene, "nonsmooth").identity();
  put(scene, in_hand(ramp, "ramp"));
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    Simulation simulation(scene, formulation);
    CHECK_THAT(simulation.identity().formulation,
               Contains("load_forces = [\"hand\"]") && Contains("load_force_digests = [\"0123\"]"));
    const auto result = simulation.run();
    REQUIRE(!result.notes.empty());
    CHECK_THAT(result.notes.back(), Contains("the force of hand comes from ramp (digest 0123)"));
  }
  CHECK(Simulation(scene, "nonsmooth").identity().digest() != before.digest());
  scene.set("bodies.block.mass", "3");  // the force is kept
  CHECK(outside_of(scene).forces.contains("hand"));
  auto foot = outside_of(scene);
  foot.forces["foot"] = foot.forces["hand"];
  CHECK_THROWS_WITH(put(scene, foot), Contains("foot is not one; such loads are hand"));
  CHECK(outside_of(scene).forces.size() == 1);
  put(scene, {});
  CHECK(outside_of(scene).empty());
}

TEST_CASE("a non-finite user-supplied force stops the run; its exceptions reach the caller", "[own-force]") {
  const auto formulation = GENERATE("penalty", "nonsmooth");
  auto scene = free_body();
  put(scene, in_hand([](const void*, const char*, double t, const Vec2&, const Vec2&) {
        return Vec2{t > 0.1 ? std::nan("") : 1, 0};
      }));
  const auto result = Simulation(scene, formulation).run();
  CHECK(result.ending.status == Ending::Status::failed);
  CHECK(!result.ending.reason.empty());
  put(scene, in_hand([](const void*, const char*, double, const Vec2&, const Vec2&) -> Vec2 {
        throw std::domain_error("no such place");
      }));
  CHECK_THROWS_WITH(Simulation(scene, formulation).run(), "no such place");
}
