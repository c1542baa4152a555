// Moreau–Jean with steps that an estimate of their error chooses, against closed forms and the event-driven scheme: what it
// costs, how its error falls with what is accepted, what lies between smooth motion and impacts.
#include <catch2/catch.hpp>

#include "mechanism/scene.hpp"
#include "verification/references/block_on_slope.hpp"
#include "verification/references/bouncing_ball.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/support/support.hpp"

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

Result finished(const Scene& scene) {
  auto run = test::simulate(scene, Family::nonsmooth);
  CAPTURE(run.ending.reason);
  REQUIRE(run.ending.status == Ending::Status::finished);
  return run;
}

/// The paper's rig up to just after its sixth touch, and its touches by the event-driven scheme at 1e-13.
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

/// Orders of the error at the end of smooth motion: in the number of solves, and in what is accepted.
struct Orders {
  double in_solves, in_tolerance;
};
template <class Error>
Orders orders(const Scene& scene, Error error) {
  std::vector<double> each, accepted, errors;
  for (double tolerance = 1e-4; tolerance > 0.9e-8; tolerance /= 10) {
    const auto run = finished(chosen(scene, tolerance));
    each.push_back(1.0 / static_cast<double>(run.work.rhs));
    accepted.push_back(tolerance);
    errors.push_back(error(run.final_state));
  }
  UNSCOPED_INFO("errors " << Catch::Detail::stringify(errors) << ", 1/solves "
                          << Catch::Detail::stringify(each));
  return {test::observed_order(each, errors), test::observed_order(accepted, errors)};
}

}  // namespace

TEST_CASE("chosen steps: the paper's first six touches to a microsecond, with at most 2,000 solves",
          "[chosen]") {
  const Rig rig;
  const auto run = finished(chosen(rig.scene, 1e-6));
  CAPTURE(run.work.rhs, run.work.steps, run.work.rejected);
  CHECK(run.work.rhs <= 2000);
  const auto found = test::touches(run);
  REQUIRE(found.size() == 6);
  for (std::size_t i = 0; i < 6; ++i) {
    CAPTURE(i);
    CHECK(found[i].t == Approx(rig.exact[i].t).margin(1e-6).epsilon(0));
    // 1e-6 s late is this much of the approach speed, by the approach's acceleration: the touches before are
    // hundreds of microseconds away, over which the speed itself arose.
    CHECK(found[i].v_n_minus == Approx(rig.exact[i].v_n_minus).epsilon(1e-2));
    CHECK(found[i].impulse_n == Approx(rig.exact[i].impulse_n).epsilon(1e-2));
  }
}

TEST_CASE("chosen steps: errors of touches fall in proportion to what is accepted", "[chosen][order]") {
  // A touch is landed on to a tenth of tolerance × clearance and acts anywhere in a step of tolerance × ℓ: first order. The
  // smooth stretches before it are off by tolerance to tolerance^{4/3} (below). Where a step falls is a lottery: the
  // greatest of a window of tolerances, from where the shortest flight has more than a step or two of its own.
  Rig rig;
  rig.scene.run.duration += 1e-4;  // the sixth may be late
  std::vector<double> accepted, time, speed, impulse;
  for (const double tolerance : {1e-5, 1e-6, 1e-7, 1e-8}) {
    double worst[3] = {0, 0, 0};
    for (int part = 0; part < 10; ++part) {
      const auto found = test::touches(finished(chosen(rig.scene, tolerance * (1 + 0.1 * part))));
      REQUIRE(found.size() >= 6);
      for (std::size_t i = 0; i < 6; ++i) {
        const auto& exact = rig.exact[i];
        worst[0] = std::max(worst[0], std::abs(found[i].t - exact.t));
        worst[1] = std::max(worst[1], std::abs(found[i].v_n_minus / exact.v_n_minus - 1));
        worst[2] = std::max(worst[2], std::abs(found[i].impulse_n / exact.impulse_n - 1));
      }
    }
    accepted.push_back(tolerance);
    time.push_back(worst[0]);
    speed.push_back(worst[1]);
    impulse.push_back(worst[2]);
  }
  CAPTURE(time, speed, impulse);
  for (const auto* errors : {&time, &speed, &impulse}) {
    const double p = test::observed_order(accepted, *errors);
    CHECK(p > 0.7);
    CHECK(p < 1.3);
  }
}

TEST_CASE("chosen steps: smooth motion without rows is of fourth order, with rows that turn of third",
          "[chosen][order]") {
  // A step is a drift of h/2, a kick of h, a drift of h/2: symmetric where forces know the place alone, so that its error has
  // odd powers of h only: c₃h³ + c₅h⁵, and Richardson's combination of one step and two halves leaves h⁵, fourth order.
  // A step is then chosen by its h³: errors go with tolerance^{4/3}. Where rows turn with the motion the middle's rates,
  // continued by (h/2)γ, miss those at the end by O(h³), onto which they are moved: that is not symmetric, and leaves h⁴
  // in the combination: third order, and errors go with tolerance.
  const auto spring = orders(read_scene(test::scene_file("hanging_mass")), [](const State& end) {
    const double w = std::sqrt(80 / 2.0), rest = -(1 + 2 * 9.81 / 80), a = -1 - rest;
    return std::max(std::abs(end.q[1] - rest - a * std::cos(w * 1.3)) / a,
                    std::abs(end.v[1] + a * w * std::sin(w * 1.3)) / (a * w));
  });
  CHECK(spring.in_solves > 3.7);
  CHECK(spring.in_solves < 4.3);
  CHECK(spring.in_tolerance > 3.7 / 3);
  CHECK(spring.in_tolerance < 4.3 / 3);
  const auto bar = orders(read_scene(test::scene_file("swinging_bar")), [](const State& end) {
    const auto exact =
        reference::pendulum_state(reference::Pendulum{0.8, 0.01, 0.25, 9.81, 1.0471975511965976}, 0.9);
    return std::max(std::abs(end.q[2] + 1.5707963267948966 - exact.angle),
                    std::abs(end.v[2] - exact.rate) / 5);
  });
  CHECK(bar.in_solves > 2.7);
  CHECK(bar.in_solves < 3.3);
  CHECK(bar.in_tolerance > 0.9);
  CHECK(bar.in_tolerance < 1.1);
}

TEST_CASE("chosen steps: a ball comes to rest through infinitely many bounces", "[chosen]") {
  // A touch that acts δ late shifts all that follows by δ (1 + 2e + 2e² + …) = δ (1 + e)/(1 − e): its approach is faster by
  // g δ. What is told of each touch is how far off it may be by itself. The last, which ends the hops, stands for all that
  // are left.
  for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
    auto scene = chosen(read_scene(test::scene_file("bouncing_ball")), tolerance);
    scene.run.duration = 1.2;
    const auto run = finished(scene);
    CAPTURE(tolerance, run.work.steps, run.notes);
    const reference::BouncingBall ball{0.5, 9.81, 0.5};
    const auto found = test::touches(run);
    const double low = tolerance * 1e-3 * 0.05;  // of the scale of a plane: a thousandth of the radius
    // The k-th hop is 0.5 m × e^{2k} high; the first below `low` ends in lasting contact.
    const double hops = std::ceil(std::log(0.5 / low) / std::log(4.0));
    REQUIRE(static_cast<double>(found.size()) == hops + 1);
    double told = 0;
    for (std::size_t k = 0; k + 1 < found.size(); ++k) {
      CAPTURE(k);
      const auto exact = reference::ball_impact(ball, static_cast<int>(k) + 1);
      told += found[k].t_uncertainty;
      CHECK(std::abs(found[k].t - exact.t) <= 3 * told + 1e-12);
      CHECK(found[k].v_n_minus == Approx(-exact.approach).margin(3 * 9.81 * told + 1e-12).epsilon(0));
      CHECK(found[k].kind == EventKind::impact);
    }
    const auto& last = found.back();
    CHECK(last.kind == EventKind::contact);
    CHECK(std::abs(last.t - reference::ball_accumulation_time(ball)) <= 3 * told + last.t_uncertainty);
    CHECK(last.t_uncertainty < 1.1 * std::sqrt(8 * low / 9.81));  // e/(1 − e) = 1 flight of that height
    CHECK(run.final_state.v[1] == 0);
    CHECK(run.final_state.q[1] == Approx(0.05).margin(low).epsilon(0));
    CHECK(std::abs(run.ledger.closure()) < 1e-12 * run.ledger.scale());
    CHECK(run.ledger.contact == Approx(0.3 * 9.81 * 0.5).epsilon(10 * tolerance));
  }
}

TEST_CASE("chosen steps: elastic impacts of a ring and its journal keep the energy", "[chosen]") {
  // Without restitution lost the law u⁺ = −u⁻ makes the mean rate of a step's normal zero, and flights are straight: rounding
  // of some hundred impacts.
  auto scene = read_scene(test::scene_file("ring"));
  scene.mechanism.surfaces[0].restitution = 1;
  scene.mechanism.surfaces[0].friction.reset();
  for (const double tolerance : {1e-3, 1e-6}) {
    const auto run = finished(chosen(scene, tolerance));
    CAPTURE(tolerance, run.work.events);
    CHECK(run.work.events > 50);
    CHECK(std::abs(run.ledger.kinetic / run.ledger.initial - 1) < 1e-11);
    CHECK(std::abs(run.ledger.contact) < 1e-11 * run.ledger.initial);
  }
}

TEST_CASE("chosen steps: sliding that turns round under a preload, and up a slope and down again",
          "[chosen]") {
  // A step over the instant of turning has one friction all along. Its error, the speed that it has wrong, is accepted up to
  // tolerance × (V + |v|); before and after the motion is polynomial, which a step meets to rounding. Both the step itself and
  // one that ends at rest there may be wrong: twice that, and its time's worth of the way.
  for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-7})
    for (const double v0 : {0.25, 0.27, 0.3, 0.31, 0.32}) {
      CAPTURE(tolerance, v0);
      {  // 2 kg against 6 N of friction and a pull of 10 N: −8 m/s², then −2 m/s²
        auto scene = read_scene(test::scene_file("pulled_block"));
        scene.mechanism.bodies[0].velocity = {v0, 0};
        const auto run = finished(chosen(scene, tolerance));
        const double stop = v0 / 8, rest = 0.2 - stop, wrong = 2 * tolerance * (std::sqrt(9.81) + v0);
        CHECK(run.final_state.v[0] == Approx(-2 * rest).margin(wrong).epsilon(0));
        CHECK(run.final_state.q[0] == Approx(0.5 * v0 * stop - rest * rest).margin(wrong * rest).epsilon(0));
        CHECK(std::abs(run.ledger.closure()) < 1e-9 * run.ledger.scale());
      }
      {  // a slope of 20 degrees, friction below its tangent
        auto scene = read_scene(test::scene_file("block_on_slope"));
        scene.mechanism.surfaces[0].friction = 0.2;
        scene.mechanism.bodies[0].velocity = {v0, 0};
        const auto run = finished(chosen(scene, tolerance));
        const auto exact = reference::block_state({20 * M_PI / 180, 0.2, 9.81, v0}, 0.5);
        const double wrong =
            2 * tolerance * (std::sqrt(9.81 * 0.12) + v0);  // no scale of length is above an arm
        CHECK(exact.velocity < -0.1);
        CHECK(run.final_state.v[0] == Approx(exact.velocity).margin(wrong).epsilon(0));
        CHECK(run.final_state.q[0] == Approx(exact.position).margin(wrong * 0.5).epsilon(0));
      }
    }
}

TEST_CASE("chosen steps: at their loosest, and without restitution", "[chosen]") {
  const Rig rig;
  {
    // A thousandth of the clearance off at each landing, some per cent of it by the sixth touch: each rattle multiplies an
    // error by two or three.
    const auto found = test::touches(finished(chosen(rig.scene, 1e-3)));
    REQUIRE(found.size() >= 3);
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(found[i].t == Approx(rig.exact[i].t).margin(0.01 * rig.exact[0].t).epsilon(0));
  }
  // As e goes to 0 the first impact becomes a beginning of lasting contact, the same from some e on: a hop of
  // 2 e v/g is over when it is e²v²/(2g) < 1e-6 × 5e-5 m high, and ends in the next touch.
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
  // The rig: what rests after its first touch goes on as with the event-driven scheme.
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
