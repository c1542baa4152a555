// Derivatives of works and impulses where a key changes forces but not the motion, and where a
// derivative does not exist because contacts close together or at the end.
#include "analysis/sensitivity.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// Derivatives of the block that a carriage pulls, from a height (m), for a duration (s).
Sensitivities of_block(double height, double duration, double phase, std::vector<std::string> quantities,
                       std::vector<std::string> keys) {
  const auto scene =
      read_scene(test::scene_file("tests/block_behind_carriage"),
                 {fmt::format("bodies.block.position=[0, {}]", height),
                  fmt::format("run.duration={}", duration), fmt::format("curves.m.phase={}", phase)});
  return sensitivities(scene, {.of = std::move(quantities), .to = std::move(keys)});
}

}  // namespace

TEST_CASE("the work of friction in a prescribed motion is proportional to its coefficient", "[sensitivity]") {
  // Neither the motion nor the normal forces depend on μ: the energy lost by friction is μ times a
  // constant, also across an impact from a drop of 10 mm, and the drive supplies it.
  for (const double height : {0.05, 0.06}) {
    const auto all = of_block(height, 0.1, 0, {"energy.dissipated_by_friction", "energy.work_of_drives"},
                              {"surfaces.s.friction"});
    const double loss = all.quantities[0].value;
    REQUIRE(loss > 0.01);
    for (const auto& q : all.quantities) {
      INFO(q.name << " " << height);
      CHECK(q.reasons[0].empty());
      CHECK(q.derivatives[0] == Approx(loss / 0.3).epsilon(1e-9));
    }
  }
}

TEST_CASE("the mean friction force jumps with the time of a reversal", "[sensitivity]") {
  // The block slides with x = 0.1 sin(2π(t/P) + φ) and turns at t* = P(1/4 − φ/(2π)), here before
  // the end T. Its friction is −μN before and μN after: ∫ F_T dt = μN (T − 2 t*) up to the sign of
  // the tangent, with derivatives −2 μN ∂t*/∂p, ∂t*/∂P = 1/4 − φ/(2π), ∂t*/∂φ = −P/(2π).
  const double phase = 0.2, end = 0.4, load = 0.3 * 20;
  const auto all = of_block(0.05, end, phase, {"mean.floor.ft"}, {"curves.m.period", "curves.m.phase"});
  const auto& q = all.quantities[0];
  const double turn = 0.25 - phase / (2 * std::numbers::pi);
  REQUIRE(turn < end);
  const double sign = q.value / (load * (end - 2 * turn) / end) > 0 ? 1 : -1;
  CHECK(sign * q.value == Approx(load * (end - 2 * turn) / end).epsilon(1e-9));
  CHECK(sign * q.derivatives[0] == Approx(-2 * load * turn / end).epsilon(1e-8));
  CHECK(sign * q.derivatives[1] == Approx(load / (std::numbers::pi * end)).epsilon(1e-8));
}

TEST_CASE("simultaneous contact events and those at the end have no derivative by a key that parts them",
          "[sensitivity]") {
  const auto with = [&](double duration) {
    const auto scene = test::read_short(test::scene_file("tests/two_falling_balls"), duration);
    return sensitivities(scene, {.of = {"event.1.t", "end.a.vy"}, .to = {"initial.a.y", "gravity[1]"}});
  };
  // Both fall for t = √(2h/g) = √0.1 s. Gravity moves both alike: ∂t/∂g = −t/(2g), g = −10 upwards.
  const double fall = std::sqrt(0.1);
  const auto all = with(0.5);
  CHECK(all.quantities[0].value == Approx(fall).epsilon(1e-12));
  CHECK_FALSE(all.quantities[0].reasons[0].empty());
  CHECK(std::isnan(all.quantities[0].derivatives[0]));
  CHECK(all.quantities[0].reasons[1].empty());
  CHECK(all.quantities[0].derivatives[1] == Approx(fall / 20).epsilon(1e-10));
  CHECK(all.quantities[1].reasons[0].empty());
  // A run that ends with the impact, to rounding.
  const auto cut = with(fall * (1 + 1e-14));
  for (const auto& reason : cut.quantities[1].reasons) CHECK_FALSE(reason.empty());
}
