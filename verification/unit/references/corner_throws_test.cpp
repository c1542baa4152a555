// Balls are thrown into a closed box with pegs, with friction near 1 and restitution below 1, and
// come to rest against each other and the walls. Event-driven integration passes all their
// bounces and lockups. Whatever the motion, the final state of a ball on the floor is
//
//     y = y_floor + R,   v_y = 0,   v_x + ω R = 0
//
// (on a level floor only rolling remains; the pegs hang above it), and the lost energy was
// dissipated in contacts.
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

struct Ball {
  double mass, x, y, vx, vy, spin;
};
struct Throws {
  std::vector<Ball> balls;
  double width, height;                     ///< m, from the middle
  std::vector<std::array<double, 3>> pegs;  ///< ball, x, y
  double gravity, restitution, friction, duration;
};
constexpr double R = 0.01;

Result run(const Throws& s) {
  std::string text = fmt::format("gravity = [0.0, {:.17g}]\n", -s.gravity);
  for (std::size_t i = 0; i < s.balls.size(); ++i) {
    const auto& b = s.balls[i];
    text += fmt::format(
        "[bodies.b{}]\nmass = {:.17g}\ninertia = {:.17g}\nposition = [{:.17g}, {:.17g}]\n"
        "velocity = [{:.17g}, {:.17g}]\n"
        "angular_velocity = {:.17g}\n",
        i, b.mass, 0.5 * b.mass * R * R, b.x, b.y, b.vx, b.vy, b.spin);
    const auto wall = [&](const char* name, double x, double y, int ax, int ay) {
      text += test::plane(
          fmt::format("{}{}", name, i), "ground", fmt::format("b{}", i), R, "s",
          fmt::format("at = [[{:.17g}, {:.17g}], [0.0, 0.0]]\naxis = [{}.0, {}.0]\n", x, y, ax, ay));
    };
    wall("floor", 0, -s.height, 1, 0);
    wall("left", -s.width, 0, 0, -1);
    wall("right", s.width, 0, 0, 1);
    wall("lid", 0, s.height, -1, 0);
    for (std::size_t j = 0; j < i; ++j)
      text += test::discs(fmt::format("c{}{}", j, i), fmt::format("b{}", j), fmt::format("b{}", i), R, R);
  }
  for (std::size_t k = 0; k < s.pegs.size(); ++k)
    text += test::discs(fmt::format("peg{}", k), "ground", fmt::format("b{}", s.pegs[k][0]), 0.005, R, "s",
                        fmt::format("at = [[{:.17g}, {:.17g}], [0.0, 0.0]]\n", s.pegs[k][1], s.pegs[k][2]));
  text += fmt::format(
      "[surfaces.s]\nrestitution = {:.17g}\nfriction = {:.17g}\n[run]\nduration = {:.17g}\n"
      "start = \"given\"\n",
      s.restitution, s.friction, s.duration);
  auto scene = parse_scene(text, "throws");
  scene.nonsmooth.scheme = Scheme::event_driven;
  return test::simulate(scene, Family::nonsmooth);
}

}  // namespace

TEST_CASE("bodies thrown into a box, whose corners wedge together, come to rest on its floor (event-driven)",
          "[throws]") {
  const Throws s{
      {{0.027802866127816558, 0.010106322419567892, -0.06297671078300994, -0.19617029537249631,
        -0.20509282277772073, 0.17108067245526096},
       {0.4182640323228749, -0.024823902171595857, -0.030696197606387986, -0.021721702837614307,
        0.28297352944630771, -10.499992935614561}},
      0.059635326017075378,
      0.17262442948198109,
      {{0, 0.0042724569469007531, 0.14227130654724052}, {1, 0.048082990050205603, 0.065379768914558045}},
      1.0066061356279052,
      0.3,
      1,
      16.991040619889805};
  const auto result = run(s);
  INFO(result.ending.reason);
  REQUIRE(result.ending.status == Ending::Status::finished);
  const auto& end = result.final_state;
  for (int i = 0; i < 2; ++i) {
    const double *q = end.q.data() + 3 * i, *v = end.v.data() + 3 * i;
    // The gap of a closed contact is accurate to the error of integration: 1e-10 of metres of
    // motion in some hundred steps.
    CHECK(std::abs(q[1] + s.height - R) < 1e-8);
    CHECK(std::abs(v[1]) < 1e-8);
    CHECK(std::abs(v[0] + R * v[2]) < 1e-6);  // rolling, within the threshold of sliding
  }
  const auto& l = result.ledger;
  CHECK(l.contact + l.friction > 0);
}
