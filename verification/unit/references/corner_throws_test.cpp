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

TEST_CASE("bodies thrown into a box, whose corners wedge together, come to rest on its floor (event-driven)",
          "[throws]") {
  using namespace test;
  constexpr double R = 0.01, width = 0.059635326017075378,
                   height = 0.17262442948198109;  // m, from the middle
  const auto ball = [](const char* name, double mass, const char* start) {
    return body(name, mass, 0.5 * mass * R * R, start);
  };
  auto text = "gravity = [0.0, -1.0066061356279052]\n" +
              ball("b0", 0.027802866127816558,
                   "position = [0.010106322419567892, -0.06297671078300994]\n"
                   "velocity = [-0.19617029537249631, -0.20509282277772073]\n"
                   "angular_velocity = 0.17108067245526096\n") +
              ball("b1", 0.4182640323228749,
                   "position = [-0.024823902171595857, -0.030696197606387986]\n"
                   "velocity = [-0.021721702837614307, 0.28297352944630771]\n"
                   "angular_velocity = -10.499992935614561\n");
  struct Wall {
    const char* name;
    Vec2 at, axis;
  };
  for (const char* b : {"b0", "b1"})
    for (const auto& w : {Wall{"floor", {0, -height}, {1, 0}}, Wall{"left", {-width, 0}, {0, -1}},
                          Wall{"right", {width, 0}, {0, 1}}, Wall{"lid", {0, height}, {-1, 0}}})
      text += plane(std::string(w.name) + b, "ground", b, R, "s",
                    fmt::format("at = [[{}, {}], [0, 0]]\naxis = [{}, {}]\n", w.at.x(), w.at.y(), w.axis.x(),
                                w.axis.y()));
  text += discs("c01", "b0", "b1", R, R) +
          discs("peg0", "ground", "b0", 0.005, R, "s",
                "at = [[0.0042724569469007531, 0.14227130654724052], [0, 0]]\n") +
          discs("peg1", "ground", "b1", 0.005, R, "s",
                "at = [[0.048082990050205603, 0.065379768914558045], [0, 0]]\n") +
          surface("s", 0.3, 1.0) + run_for(16.991040619889805, "start = \"given\"\n");
  const auto result = finished(event_driven, text);
  const auto& end = result.final_state;
  for (int i = 0; i < 2; ++i) {
    const double *q = end.q.data() + 3 * i, *v = end.v.data() + 3 * i;
    // The gap of a closed contact is accurate to the error of integration: 1e-10 of metres of
    // motion in some hundred steps.
    CHECK(std::abs(q[1] + height - R) < 1e-8);
    CHECK(std::abs(v[1]) < 1e-8);
    CHECK(std::abs(v[0] + R * v[2]) < 1e-6);  // rolling, within the threshold of sliding
  }
  CHECK(result.ledger.contact + result.ledger.friction > 0);
}
