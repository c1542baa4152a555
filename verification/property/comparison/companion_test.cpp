// The error estimate of the first contacts of a time-stepping run, against closed forms and the
// event-driven scheme.
#include <atomic>

#include "facade/assess.hpp"
#include "facade/run_folder.hpp"
#include "simulation/touches.hpp"
#include "verification/references/bouncing_ball.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

ContactEvent touch(double t, double v, double impulse, int contact = 0) {
  ContactEvent e;
  e.t = t;
  e.contact = contact;
  e.v_n_minus = -v;
  e.impulse_n = impulse;
  return e;
}

std::vector<ContactEvent> assessed(const Scene& scene) {
  auto list = test::touches(test::simulate(scene, Family::nonsmooth));
  std::erase_if(list, [](const ContactEvent& e) { return !is_onset(e); });
  return list;
}

}  // namespace

TEST_CASE("the difference of two lists of contacts is measured by interval, speed and impulse",
          "[companion]") {
  const std::vector<ContactEvent> exact{touch(1, 2, 4), touch(1.5, 1, 2, 1), touch(1.5 + 1e-9, 1, 2, 0)};
  const std::vector<ContactEvent> found{touch(1.01, 2, 4), touch(1.5, 1, 2.2, 0), touch(1.5, 1.05, 2, 1)};
  const auto d = onset_difference(found, exact);
  CHECK(d.time == Approx(0.01));
  CHECK(d.speed == Approx(0.05));
  CHECK(d.impulse == Approx(0.1));
  CHECK(d.touches == 3);
  CHECK(std::isinf(onset_difference({found[0]}, exact).greatest()));
  // A contact that rests at the start had its onset before.
  CHECK_FALSE(is_onset(touch(0, 0, 0)));
}

TEST_CASE("a gap that a step leaves after an impact without rebound is no contact event", "[companion]") {
  // A ball falls 0.5 m onto a plane with e = 0 and stays there: one contact event, whatever the step.
  const double g = 9.81, speed = std::sqrt(2 * g * 0.5);
  auto scene = read_scene(test::scene_file("bouncing_ball"));
  scene.mechanism.surfaces[0].restitution = 0;
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  for (const double step : {1e-3, 7e-4, 3e-4, 1e-4, 3.3e-5}) {
    CAPTURE(step);
    scene.nonsmooth.step = step;
    const auto doubt = doubt_first_touches(scene, {}, {});
    REQUIRE(doubt);
    CHECK(doubt->touches == 1);
    CHECK_FALSE(doubt->missing);
    // The speed is that of the beginning of a step, off by up to g h; the factor is at most 4.
    CHECK(doubt->greatest() < 4 * g * step / speed + 1e-9);
  }
  // With a rebound the second contact event counts.
  scene.mechanism.surfaces[0].restitution = 0.1;
  scene.nonsmooth.step = 1e-4;
  CHECK(doubt_first_touches(scene, {}, {})->touches > 1);
}

TEST_CASE("the error estimate of the first contacts covers their error", "[companion]") {
  int cases = 0;
  for (const auto* name :
       {"gudgeon", "gudgeon_1mm_250rpm", "gudgeon_mu03", "four_bar", "four_bar_two", "big_end"})
    for (const double step : {1e-5, 3e-5}) {
      CAPTURE(name, step);
      auto scene = read_scene(test::scene_file(name));
      scene.run.duration = std::min(scene.run.duration, 0.1);
      scene.run.discard = 0;
      scene.instruments.clear();
      scene.nonsmooth.scheme = Scheme::moreau_jean;
      scene.nonsmooth.step = step;
      const auto doubt = doubt_first_touches(scene, {}, {});
      REQUIRE(doubt);
      auto found = assessed(scene);
      found.resize(static_cast<std::size_t>(doubt->touches));
      scene.nonsmooth.scheme = Scheme::event_driven;
      scene.nonsmooth.tolerance = 1e-12;
      auto exact = assessed(scene);
      REQUIRE(exact.size() >= found.size());
      exact.resize(found.size());
      const double off = onset_difference(found, exact).greatest();
      CAPTURE(off);
      // Twice the remaining first-order error: it covers the error, and by less than a factor of
      // ten.
      CHECK(doubt->greatest() >= off);
      CHECK(doubt->greatest() <= 10 * off);
      ++cases;
    }
  CHECK(cases == 12);
}

TEST_CASE("the error estimate covers the error of a bouncing ball, against the closed form", "[companion]") {
  auto scene = read_scene(test::scene_file("bouncing_ball"));
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  scene.run.duration = 3;
  const reference::BouncingBall ball{0.5, 9.81, 0.5};
  for (const double step : {1.1e-3, 1e-4}) {
    scene.nonsmooth.step = step;
    const auto doubt = doubt_first_touches(scene, {}, {});
    REQUIRE(doubt);
    CHECK(doubt->touches == companion_touches);
    const auto found = assessed(scene);
    double worst = 0, before = 0;
    for (int k = 1; k <= companion_touches; ++k) {
      const auto exact = reference::ball_impact(ball, k);
      worst = std::max({worst, std::abs(found[k - 1].t - exact.t) / (exact.t - before),
                        std::abs(-found[k - 1].v_n_minus / exact.approach - 1)});
      before = exact.t;
    }
    CAPTURE(step, worst);
    CHECK(doubt->greatest() >= worst);
  }
}

TEST_CASE("a companion run changes no digit of the run and adds its estimate as one note", "[companion]") {
  const auto scene = test::read_short(test::scene_file("gudgeon"), 0.05);  // Moreau–Jean, h = 1e-5 s
  const auto alone = run_scene(scene, {.formulation = "nonsmooth"});
  const auto with = run_scene(scene, {.formulation = "nonsmooth", .companion = true});
  CHECK(alone.final_state.v == with.final_state.v);
  CHECK(alone.work.steps == with.work.steps);
  CHECK_FALSE(alone.first_touches);
  CHECK(with.first_touches);
  CHECK(with.notes.size() == alone.notes.size() + 1);
}

TEST_CASE("first contacts have no estimate unless a time-stepped run reaches one", "[companion]") {
  auto scene = test::read_short(test::scene_file("gudgeon"), 0.05);
  REQUIRE(doubt_first_touches(scene, {}, {}));
  CHECK_FALSE(run_scene(scene, {.formulation = "penalty", .companion = true}).first_touches);
  const std::atomic<bool> stop = true;  // requested before the start
  CHECK_FALSE(doubt_first_touches(scene, {}, StopToken(stop)));
  scene.nonsmooth.scheme = Scheme::event_driven;  // locates its events: no error of the step
  CHECK_FALSE(doubt_first_touches(scene, {}, {}));
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  scene.run.duration = 2e-3;  // before the first contact
  CHECK_FALSE(doubt_first_touches(scene, {}, {}));
}
