// Derivatives by the keys of ratios between two joints, against closed forms: two flywheels of inertia
// J_1 and J_2 with y = r θ (verification/unit/dynamics/ratio_test.cpp).
#include "verification/support/rig.hpp"
#include "verification/unit/variation/varied_scenes.hpp"

using namespace freeplay;
using namespace freeplay::test::varied;

namespace {

constexpr double J1 = 0.1, J2 = 0.05, r = 1.5;

std::string flywheels(const std::string& keys, const std::string& belt, double duration) {
  return test::body("one", 1, J1, keys) + test::body("two", 1, J2, "position = [0.5, 0]\n") +
         test::pin("lead", "ground", "one") + test::pin("follow", "ground", "two", {0.5, 0}) +
         test::surface("hard", 0.6) + belt + "joint = \"follow\"\nof = \"lead\"\nratio = 1.5\n" +
         test::run_for(duration, "[nonsmooth]\nscheme = \"event-driven\"\ntolerance = 1e-12\n");
}

}  // namespace

TEST_CASE("the ratio of an ideal drive changes its acceleration as in closed form", "[sensitivity][ratio]") {
  // θ = ½ M T²/J, J = J_1 + r² J_2
  const double M = 2, T = 0.5, J = J1 + r * r * J2;
  const auto q = of(flywheels("",
                              "[loads.engine]\ntype = \"torque\"\nbody = \"one\"\ntorque = 2\n[joints.belt]\n"
                              "type = \"ratio\"\noffset = 0\n",
                              T),
                    {"end.one.theta"}, {"joints.belt.ratio"})
                     .quantities[0];
  CHECK(q.value == Approx(0.5 * M * T * T / J).epsilon(1e-9));
  check_derivatives(q, {-q.value * 2 * r * J2 / J}, 1e-8);
}

TEST_CASE("ratio, offset and backlash change the first impact as in closed form", "[sensitivity][ratio]") {
  // The forward contact closes at t = (b/2 − o)/(r w), with ẏ = (1 + e) r w J_1/(J_1 + r² J_2) after it.
  const double w = 3, b = 0.02, o = 0.002, e = 0.6, t = (0.5 * b - o) / (r * w), J = J1 + r * r * J2;
  const auto all =
      of(flywheels("angular_velocity = 3\n",
                   "[joints.belt]\ntype = \"ratio\"\noffset = 0.002\nbacklash = 0.02\n"
                   "radius = 0.05\nsurface = \"hard\"\n",
                   1.5 * t),
         {"event.1.t", "end.two.omega"},
         {"joints.belt.ratio", "joints.belt.offset", "joints.belt.backlash", "joints.belt.radius"});
  CHECK(all.quantities[0].value == Approx(t).epsilon(1e-9));
  check_derivatives(all.quantities[0], {-t / r, -1 / (r * w), 0.5 / (r * w), 0}, 1e-8, 1e-9);
  CHECK(all.quantities[1].value == Approx((1 + e) * r * w * J1 / J).epsilon(1e-9));
  check_derivatives(all.quantities[1], {(1 + e) * w * J1 * (J1 - r * r * J2) / (J * J), 0, 0, 0}, 1e-8, 1e-8);
}

TEST_CASE("the stiffness of an elastic ratio changes the motion as in closed form", "[sensitivity][ratio]") {
  // y = (x − x_0)/(1 + r² J_2/J_1), x = x_0 cos ω t, ω² = k (1/J_2 + r²/J_1)
  const double k = 20, x0 = 0.5, T = 0.3, omega = std::sqrt(k * (1 / J2 + r * r / J1)),
               part = 1 / (1 + r * r * J2 / J1);
  const auto q =
      of(flywheels("", "[loads.belt]\ntype = \"elastic-ratio\"\noffset = -0.5\nstiffness = 20\n", T),
         {"end.two.theta"}, {"loads.belt.stiffness", "loads.belt.offset"})
          .quantities[0];
  CHECK(q.value == Approx(part * x0 * (std::cos(omega * T) - 1)).epsilon(1e-8));
  check_derivatives(
      q, {-part * x0 * std::sin(omega * T) * T * omega / (2 * k), part * (1 - std::cos(omega * T))}, 1e-7);
}
