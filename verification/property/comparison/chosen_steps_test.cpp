// Moreau–Jean with adaptive steps (step = "automatic", chosen by an error estimate): the order
// where constraint rows rotate, reversal of sliding on a slope, loose tolerances, and impacts
// without restitution. The claims of "setting-choice" contain further cases.
#include "verification/references/dry_friction.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

Scene chosen(Scene scene, double tolerance) {
  scene.run.discard = 0;
  scene.instruments.clear();
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  scene.nonsmooth.step.reset();
  scene.nonsmooth.step_tolerance = tolerance;
  return scene;
}

Result finished(const Scene& scene) { return test::finished(scene, Family::nonsmooth); }

/// The paper's rig up to just after its sixth contact, and its contacts by the event-driven scheme
/// at 1e-13.
struct Rig {
  Scene scene = read_scene(test::flores(), {"run.revolutions=0.2", "run.discard=0"});
  std::vector<ContactEvent> exact;
  Rig() {
    auto events = chosen(scene, 1e-6);
    events.nonsmooth.scheme = Scheme::event_driven;
    events.nonsmooth.tolerance = 1e-13;
    exact = test::touches(finished(events));
    REQUIRE(exact.size() >= 6);
    scene.run.duration = exact[5].t + 1e-5;
  }
};

}  // namespace

TEST_CASE("adaptive time stepping: third order where the constraint rows rotate with the motion",
          "[chosen][order]") {
  // A step is a drift of h/2, an impulse of h, a drift of h/2. Where constraint rows rotate with
  // the motion, the velocities of the middle, continued by (h/2)γ, differ by O(h³) from those at
  // the end, onto which they are projected. That is not symmetric, and leaves h⁴ in the combination
  // of one step and two halves: third order, and errors in proportion to the tolerance.
  const auto scene = read_scene(test::scene_file("swinging_bar"));
  const auto exact =
      reference::pendulum_state(reference::Pendulum{0.8, 0.01, 0.25, 9.81, 1.0471975511965976}, 0.9);
  std::vector<double> each, accepted, errors;
  for (double tolerance = 1e-4; tolerance > 0.9e-8; tolerance /= 10) {
    const auto run = finished(chosen(scene, tolerance));
    const auto& end = run.final_state;
    each.push_back(1.0 / static_cast<double>(run.work.rhs));
    accepted.push_back(tolerance);
    errors.push_back(
        std::max(std::abs(end.q[2] + 1.5707963267948966 - exact.angle), std::abs(end.v[2] - exact.rate) / 5));
  }
  CAPTURE(errors, each);
  CHECK(test::observed_order(each, errors) == Approx(3).margin(0.3).epsilon(0));
  CHECK(test::observed_order(accepted, errors) == Approx(1).margin(0.1).epsilon(0));
}

TEST_CASE("adaptive time stepping: a block slides up a slope and down again", "[chosen]") {
  // A step over the reversal has one direction of friction throughout. Its error, a speed, is
  // accepted up to tolerance × (V + |v|); before and after the reversal the motion is polynomial,
  // which a step integrates to rounding. Both the step itself and one that ends at rest there may
  // have that error: twice that speed, and the displacement by it over the time.
  for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-7})
    for (const double v0 : {0.25, 0.27, 0.3, 0.31, 0.32}) {
      CAPTURE(tolerance, v0);
      // 20 degrees, friction coefficient below their tangent.
      auto scene = read_scene(test::scene_file("block_on_slope"));
      scene.mechanism.surfaces[0].friction = 0.2;
      scene.mechanism.bodies[0].velocity = {v0, 0};
      const auto run = finished(chosen(scene, tolerance));
      const auto exact = reference::block_state({20 * M_PI / 180, 0.2, 9.81, v0}, 0.5);
      const double wrong =
          2 * tolerance * (std::sqrt(9.81 * 0.12) + v0);  // the length scale is at most a lever arm
      CHECK(exact.velocity < -0.1);
      CHECK(run.final_state.v[0] == Approx(exact.velocity).margin(wrong).epsilon(0));
      CHECK(run.final_state.q[0] == Approx(exact.position).margin(wrong * 0.5).epsilon(0));
      CHECK(std::abs(run.ledger.closure()) < 1e-9 * run.ledger.scale());
    }
}

TEST_CASE("adaptive time stepping: loosest tolerance, and vanishing restitution", "[chosen]") {
  const Rig rig;
  {
    // An error of a thousandth of the clearance at each contact, some per cent of it by the sixth:
    // each bounce multiplies an error by two or three.
    const auto found = test::touches(finished(chosen(rig.scene, 1e-3)));
    REQUIRE(found.size() >= 3);
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(found[i].t == Approx(rig.exact[i].t).margin(0.01 * rig.exact[0].t).epsilon(0));
  }
  // As e tends to 0 the first impact becomes a beginning of lasting contact, the same below some e:
  // a bounce of duration 2 e v/g is ended when its height e²v²/(2g) is below 1e-6 × 5e-5 m, and
  // joins the next contact.
  auto ball = chosen(read_scene(test::scene_file("bouncing_ball")), 1e-6);
  for (const double e : {0.0, 1e-8, 1e-4, 1e-2}) {
    CAPTURE(e);
    std::size_t touches = 1;
    for (double hop = 0.5 * e * e; hop > 0; hop = hop > 5e-11 ? hop * e * e : 0) ++touches;
    ball.mechanism.surfaces[0].restitution = e;
    const auto run = finished(ball);
    const auto found = test::touches(run);
    REQUIRE(found.size() == touches);
    CHECK(found[0].t == Approx(std::sqrt(1 / 9.81)).margin(1e-6 * 0.0714).epsilon(0));
    CHECK(found.back().kind == EventKind::contact);
    CHECK(run.final_state.v[1] == 0);
    CHECK(run.final_state.q[1] == Approx(0.05).margin(1e-6 * 0.05).epsilon(0));
    CHECK(std::abs(run.ledger.closure()) < 1e-12 * run.ledger.scale());
  }
  // The rig: the lasting contact after its first onset continues as with the event-driven scheme.
  auto flat = rig.scene;
  flat.mechanism.surfaces[0].restitution = 0;
  flat.run.duration = 0.06;
  auto events = chosen(flat, 1e-6);
  events.nonsmooth.scheme = Scheme::event_driven;
  const auto exact = finished(events), run = finished(chosen(flat, 1e-6));
  REQUIRE(run.events.size() == exact.events.size());
  for (std::size_t i = 0; i < run.events.size(); ++i) {
    CAPTURE(i);
    CHECK(run.events[i].kind == exact.events[i].kind);
    CHECK(run.events[i].t == Approx(exact.events[i].t).margin(1e-5).epsilon(0));
  }
  for (std::size_t i = 0; i < run.final_state.q.size(); ++i)
    CHECK(run.final_state.q[i] == Approx(exact.final_state.q[i]).margin(1e-6).epsilon(0));
}
