// Multiple shooting: unstable motions of several periods from starts at which the map of all
// periods is far from linear.
#include <cstddef>

#include "analysis/orbit.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("unstable motions of three periods of a ball on a table", "[orbit]") {
  // The table moves by A sin(Ωt + φ). Between impacts i and i + 1, a time τ apart, the ball falls
  // from the table with the speed w_i + e u_i, u_i the approach speed and w_i that of the table:
  //     A sin(Ωt_i + φ) + (w_i + e u_i) τ − g τ²/2 = A sin(Ωt_{i+1} + φ),
  //     u_{i+1} = w_{i+1} − w_i − e u_i + g τ.
  // With A = 1.6 mm the motion is chaotic, and the map of three periods alone leads to no motion
  // from these starts.
  auto scene =
      read_scene(test::source_folder() / "cases/ball-on-table/scene.toml", {"curves.shake.amplitude=1.6e-3"});
  scene.nonsmooth.scheme = Scheme::event_driven;
  constexpr double A = 1.6e-3, frequency = 15.76357202168447, phase = 4.091478, g = 9.81, e = 0.8;
  constexpr double rate = 2 * std::numbers::pi * frequency;
  const auto height = [&](double t) { return A * std::sin(rate * t + phase); };
  const auto speed = [&](double t) { return A * rate * std::cos(rate * t + phase); };
  for (const double settle : {41.0, 43.0}) {
    const auto found = orbit(scene, {.periods = 3, .settle = settle});
    INFO(settle << ": " << found.failure);
    REQUIRE(found.failure.empty());
    CHECK_FALSE(found.stable);
    REQUIRE(found.impacts.size() >= 2);
    // Motions of one period have equal impacts.
    const auto [least, most] = std::ranges::minmax(found.impacts, {}, &OrbitImpact::speed);
    CHECK(most.speed - least.speed > 1e-3);
    for (std::size_t i = 0; i < found.impacts.size(); ++i) {
      const bool last = i + 1 == found.impacts.size();
      const auto &a = found.impacts[i], &b = last ? found.impacts.front() : found.impacts[i + 1];
      const double tau = b.t - a.t + (last ? 3 / frequency : 0), up = speed(a.t) + e * a.speed;
      // Residuals of 1e-8 of the state, relative to 0.01 m and 1 m/s, and the growth over a flight.
      CHECK(height(a.t) + up * tau - 0.5 * g * tau * tau == Approx(height(b.t)).margin(1e-8));
      CHECK(speed(b.t) - up + g * tau == Approx(b.speed).epsilon(1e-6));
    }
  }
}
