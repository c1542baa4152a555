// The set-valued contact laws against closed forms: the rest of a bouncing ball, a block that stops
// on a slope, Painlevé's rod. The ball's impacts and time of rest are claims of "closed-forms",
// energy over elastic impacts of "invariants".
#include <catch2/catch.hpp>

#include "mechanism/scene.hpp"
#include "verification/references/block_on_slope.hpp"
#include "verification/references/bouncing_ball.hpp"
#include "verification/support/support.hpp"
#include "verification/support/ways.hpp"

using namespace freeplay;

namespace {

Scene scene_of(const char* name, Scheme scheme) {
  auto scene = read_scene(test::scene_file(name));
  scene.nonsmooth.scheme = scheme;
  if (!scene.nonsmooth.step) scene.nonsmooth.step = 1e-5;
  return scene;
}

double rest_time(const Result& run) {
  for (const auto& e : run.events)
    if (e.kind == EventKind::contact) return e.t;
  return NAN;
}

}  // namespace

TEST_CASE("the end of an accumulation of impacts is reported in a run that ends shortly before it",
          "[analytic][event-driven]") {
  // Bounces lower than 1e-9 of the radius, which last some microseconds, end at the time at which
  // they come to rest.
  auto scene = scene_of("bouncing_ball", Scheme::event_driven);
  const double rest = reference::ball_accumulation_time({0.5, 9.81, 0.5});
  for (const double before : {1e-9, 1e-8, 1e-7, 1e-6, 3e-6, 1e-5}) {
    scene.run.duration = rest - before;
    const auto run = test::finished(scene, Family::nonsmooth);
    CAPTURE(before, run.events.back().t);
    for (const auto& e : run.events) CHECK(e.t <= scene.run.duration);
    CHECK(run.events.back().t > rest - 3e-5);
  }
}

TEST_CASE("a bouncing ball by time stepping: the error of the time of rest is of order h ln(1/h)",
          "[order]") {
  const reference::BouncingBall ball{0.5, 9.81, 0.5};
  auto scene = scene_of("bouncing_ball", Scheme::moreau_jean);
  std::vector<double> steps, errors;
  for (const double h : {1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5}) {
    double worst = 0;  // the error is a sawtooth over the instant of rest within its step
    for (int part = 0; part < 40; ++part) {
      scene.nonsmooth.step = h * (1 + 0.5 * part / 40);
      const auto run = test::simulate(scene, Family::nonsmooth);
      worst = std::max(worst, std::abs(rest_time(run) - reference::ball_accumulation_time(ball)));
    }
    // Each of the ln(v₁/(g h))/ln(1/e) impacts that a step can resolve is displaced by up to h, and
    // the errors accumulate: the sum is h ln(1/h).
    steps.push_back(h);
    errors.push_back(worst / std::log(reference::ball_impact(ball, 1).approach / (ball.gravity * h)));
  }
  CAPTURE(errors);
  const double p = test::observed_order(steps, errors);
  CHECK(p > 0.9);
  CHECK(p < 1.1);
}

TEST_CASE("a block on two feet stops on a slope and then sticks or slides back", "[analytic]") {
  for (const double mu : {0.5, 0.2}) {
    const reference::BlockOnSlope block{20 * M_PI / 180, mu, 9.81, 1.5};
    REQUIRE(block.sticks() == (mu == 0.5));
    for (const auto scheme : {Scheme::event_driven, Scheme::moreau_jean}) {
      auto scene = scene_of("block_on_slope", scheme);
      scene.mechanism.surfaces[0].friction = mu;
      scene.nonsmooth.step = 1e-4;
      CAPTURE(mu, static_cast<int>(scheme));
      const auto run = test::finished(scene, Family::nonsmooth);
      const auto exact = reference::block_state(block, scene.run.duration);
      // Event-driven: rounding and 1e-10 a step. Time stepping: the stop lies within one step,
      // where the deceleration of 6 m/s² acts up to h = 1e-4 s too long or too short.
      const double bound = scheme == Scheme::event_driven ? 1e-10 : 6e-4;
      CHECK(run.final_state.v[0] == Approx(exact.velocity).margin(bound).epsilon(0));
      CHECK(run.final_state.q[0] == Approx(exact.position).margin(bound * 0.5).epsilon(0));
      CHECK(run.final_state.q[2] == Approx(0).margin(1e-12));
      const double lost = run.ledger.friction;
      const double way = *reference::block_stopping_distance(block);
      const double slid = way + std::abs(exact.position - way);
      CHECK(lost == Approx(2.0 * block.grip() * slid).epsilon(scheme == Scheme::event_driven ? 1e-9 : 1e-3));
    }
  }
}

TEST_CASE("Painlevé's rod: event-driven integration stops with the reason, time stepping reports the jamming",
          "[event-driven][painleve]") {
  const auto refused = test::simulate(scene_of("painleve_rod", Scheme::event_driven), Family::nonsmooth);
  CHECK(refused.ending.status == Ending::Status::failed);
  CHECK_THAT(refused.ending.reason, Catch::Contains("Painlev") && Catch::Contains("end"));

  const auto locked_up = test::simulate(scene_of("painleve_rod", Scheme::moreau_jean), Family::nonsmooth);
  CHECK(locked_up.ending.status == Ending::Status::finished);
  CHECK(std::ranges::any_of(locked_up.notes,
                            [](const std::string& n) { return n.find("Painlev") != std::string::npos; }));
  // Below the critical friction, D_NN/D_NT = 1.3366, the event-driven scheme continues.
  auto mild = scene_of("painleve_rod", Scheme::event_driven);
  mild.mechanism.surfaces[0].friction = 1.3;
  mild.run.duration = 1e-3;
  const auto run = test::simulate(mild, Family::nonsmooth);
  CHECK(run.ending.status == Ending::Status::finished);
}

TEST_CASE("a block on two feet sticks, then both feet start to slip at the same event",
          "[analytic][event-driven]") {
  // Spring force k v t against μ m g: slip from t₀ = μ m g/(k v); then x = v τ − (v/ω) sin ωτ,
  // ω² = k/m.
  const double k = 20, v = 0.5, mu = 0.3, t0 = mu * 9.81 / (k * v), omega = std::sqrt(k), tau = 1 - t0;
  const double exact = v * tau - v / omega * std::sin(omega * tau);
  for (const auto scheme : {Scheme::event_driven, Scheme::moreau_jean}) {
    CAPTURE(static_cast<int>(scheme));
    const auto run = test::finished(scene_of("dragged_block", scheme), Family::nonsmooth);
    // The cart of 10⁶ kg is displaced by 1e-6 of the block's own motion.
    CHECK(run.final_state.q[0] == Approx(exact).margin(2e-6).epsilon(0));
    CHECK(run.final_state.q[1] == Approx(0.05).margin(1e-12));
  }
}

TEST_CASE("contacts of the corners of a fast spinning rod are not missed", "[analytic][event-driven]") {
  // The lower tip is at 0.55 − 0.2 t − 0.5 |sin 100 t|: its first root, bracketed by steps of a
  // microsecond.
  const auto tip = [](double t) { return 0.55 - 0.2 * t - 0.5 * std::abs(std::sin(100 * t)); };
  double t = 0.2;
  while (tip(t) > 0) t += 1e-6;
  auto scene = scene_of("spinning_rod", Scheme::event_driven);
  scene.run.duration = 0.4;
  const auto touches = test::touches(test::simulate(scene, Family::nonsmooth));
  REQUIRE(!touches.empty());
  CHECK(touches[0].t == Approx(t).margin(1e-6).epsilon(0));
}

TEST_CASE("a ball under a large load still bounces", "[analytic][event-driven]") {
  // Without gravity a load of 1000 N accelerates the ball towards the floor: its bounces end by
  // their height, not by the time scale of the scene. First rebound e v, v² = 2 F h/m; rest after
  // (1 + e)/(1 − e) times the fall's time.
  auto scene = scene_of("bouncing_ball", Scheme::event_driven);
  scene.mechanism.gravity = {0, 0};
  scene.mechanism.loads.push_back(ForceLoad{"press", 0, {0, 0}, {0, -1000}});
  scene.run.duration = 0.1;
  const auto run = test::simulate(scene, Family::nonsmooth);
  const auto touches = test::touches(run);
  REQUIRE(touches.size() > 10);
  const double a = 1000 / 0.3, fall = std::sqrt(2 * 0.5 / a);
  CHECK(touches[0].v_n_plus == Approx(0.5 * a * fall).epsilon(1e-9));
  CHECK(rest_time(run) == Approx(3 * fall).margin(1e-9).epsilon(0));
  CHECK(run.final_state.q[1] == Approx(0.05).margin(1e-14));
  CHECK(run.final_state.v[1] == Approx(0).margin(1e-14));
}
