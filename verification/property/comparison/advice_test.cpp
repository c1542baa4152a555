// Recommended settings (freeplay advise) on scenes that they were not derived from, against the
// oracle, a closed form and a table of another program; and the option --accuracy.
#include "study/comparison/advice.hpp"
#include "simulation/touches.hpp"
#include "study/comparison/tradeoff.hpp"
#include "study/runs/case_run.hpp"
#include "verification/references/delivered_restitution.hpp"
#include "verification/references/loose_guide.hpp"
#include "verification/references/slider_crank_oracle.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

using Oracle = reference::SliderCrankOracle<long double>;

ContactEvent impact(double t, double v_n_minus, double impulse_n, int contact = 0) {
  ContactEvent e;
  e.t = t;
  e.v_n_minus = v_n_minus;
  e.impulse_n = impulse_n;
  e.contact = contact;
  return e;
}

std::vector<ContactEvent> events(const reference::OracleRun<long double>& run) {
  std::vector<ContactEvent> list;
  for (const auto& i : run.impacts)
    list.push_back(
        impact(static_cast<double>(i.t), static_cast<double>(i.v_n_minus), static_cast<double>(i.impulse_n)));
  return list;
}

/// Error of the contacts of the scene with a setting against known ones; infinite if the run fails.
double touches_off(Scene scene, const Setting& setting, const std::vector<ContactEvent>& exact) {
  setting.apply(scene);
  const auto run = test::simulate(scene, setting.family);
  if (run.ending.status != Ending::Status::finished) return INFINITY;
  auto found = test::touches(run);
  std::erase_if(found, [](const ContactEvent& x) { return x.kind != EventKind::impact; });
  return onset_error(found, exact);
}

/// `error_of` assesses a setting by a reference that the recommendation did not use. The chosen
/// setting reaches the required error; every cheaper one misses half of it, as the recommendation
/// requires, up to the accuracy of its reference. Settings refused for a contact after `known_to`
/// (s) are excepted: the assessment has no list of the lasting contacts that begin there.
template <class Error>
void keeps_its_word(const Advice& advice, double requested, const Error& error_of,
                    double known_to = INFINITY) {
  REQUIRE(advice.chosen >= 0);
  const auto cost = [](const Measured& m) { return m.work.rhs + 10 * m.work.jacobians; };
  const auto& chosen = advice.tried[static_cast<std::size_t>(advice.chosen)];
  CAPTURE(chosen.setting.label(), cost(chosen));
  CHECK(error_of(chosen.setting) <= requested);
  for (const auto& m : advice.tried) {
    if (cost(m) >= cost(chosen) || m.kept_to >= known_to * (1 - 1e-3)) continue;
    CAPTURE(m.setting.label(), cost(m));
    CHECK(error_of(m.setting) > 0.5 * requested - 10 * advice.reference.accuracy);
  }
}

}  // namespace

TEST_CASE("recommended settings reach their accuracy on scenes outside the set they were derived from",
          "[advice]") {
  struct Rig {
    const char* scene;
    long double clearance, rpm, friction;
  };
  for (const auto& rig :
       {Rig{"gudgeon_1mm_250rpm", 1e-3L, 250, 0.01L}, Rig{"gudgeon_mu03", 0.25e-3L, 200, 0.3L}}) {
    auto scene = test::read_short(test::scene_file(rig.scene), 0.02);
    scene.penalty.contact = ContactLaw::exact;
    const double e = *scene.mechanism.surfaces[0].restitution;
    reference::LooseSliderCrank<long double> mechanism;
    mechanism.clearance = rig.clearance;
    mechanism.speed = reference::from_rpm(rig.rpm);
    mechanism.friction = rig.friction;
    for (const double requested : {0.05, 0.001}) {
      for (const auto& [family, formulation] : families) {
        CAPTURE(rig.scene, requested, formulation);
        const auto advice = advise(scene, family, requested, Conduct{}, {});
        REQUIRE(advice.by_events);
        std::vector<ContactEvent> exact;
        if (family == Family::penalty) {
          reference::PenaltyContact<long double> law;
          law.stiffness = test::simulate(scene, Family::penalty).contacts[0].model.stiffness;
          law.chi = reference::exact_chi(e);
          law.friction_v0 = scene.penalty.friction_v0;
          law.friction_v1 = scene.penalty.friction_v1;
          exact = events(Oracle(mechanism).penalty(law, 0.02L));
        } else {
          exact = events(Oracle(mechanism).nonsmooth(e, 0.02L));
        }
        REQUIRE(exact.size() >= 2);
        exact.resize(std::min(exact.size(), advice.reference.touches.size()));
        keeps_its_word(
            advice, requested, [&](const Setting& s) { return touches_off(scene, s, exact); },
            exact.back().t);
      }
    }
  }
}

TEST_CASE("recommended settings reach their accuracy without contacts, against the closed form", "[advice]") {
  auto scene = read_scene(test::source_folder() / "cases/tradeoff/ideal.toml");
  scene.run.duration = 0.07;
  const double r = 0.05, l = 0.3, s = 0.15, omega = reference::from_rpm(200.0);
  for (const auto& one_family : families)
    for (const double requested : {1e-3, 1e-7}) {
      const Family family = one_family.value;
      CAPTURE(one_family.text, requested);
      const auto advice = advise(scene, family, requested, Conduct{}, {});
      REQUIRE(!advice.by_events);
      const double t = advice.reference.state_time, phi = omega * t;
      const auto m = reference::slider_crank(r, l, phi, omega);
      // The rod's centre: from the crank pin a distance s along the rod.
      const std::vector<double> exact = {0,
                                         0,
                                         omega,
                                         -r * omega * std::sin(phi) - s * m.rod_rate * std::sin(m.rod_angle),
                                         r * omega * std::cos(phi) + s * m.rod_rate * std::cos(m.rod_angle),
                                         m.rod_rate,
                                         m.velocity,
                                         0,
                                         0};
      keeps_its_word(advice, requested, [&](const Setting& setting) {
        auto one = scene;
        setting.apply(one);
        one.run.duration = t;
        const auto run = test::simulate(one, family);
        if (run.ending.status != Ending::Status::finished) return double(INFINITY);
        double worst = 0;
        for (std::size_t i = 0; i < exact.size(); ++i)
          worst = std::max(worst, std::abs(run.final_state.v[i] - exact[i]));
        return worst / omega;  // the greatest of them
      });
    }
}

TEST_CASE("recommended settings reach their accuracy for a guide with clearance, against another program",
          "[advice][guide]") {
  const auto& table = reference::guide_tables.front();
  auto scene = read_scene(test::source_folder() / "cases/flores2010-translational/scene.toml");
  scene.run.duration = 0.0065;  // between the fourth contact and the fifth
  scene.run.discard = 0;
  const auto contacts = Simulation(scene, "nonsmooth").layout().contacts;
  for (const double requested : {0.05, 0.001}) {
    CAPTURE(requested);
    const auto advice = advise(scene, Family::nonsmooth, requested, Conduct{}, {});
    REQUIRE(advice.by_events);
    std::vector<ContactEvent> exact;
    for (const auto& i : table.impacts) {
      const auto corner = std::ranges::find(contacts, std::string("guide.") + i.corner) - contacts.begin();
      exact.push_back(impact(i.t, i.v_n_minus, i.impulse_n, static_cast<int>(corner)));
    }
    REQUIRE(advice.reference.touches.size() >= 4);
    exact.resize(std::min(exact.size(), advice.reference.touches.size()));
    keeps_its_word(
        advice, requested, [&](const Setting& s) { return touches_off(scene, s, exact); }, exact.back().t);
  }
}

TEST_CASE("the predicted accuracy holds over the whole run, not only over the first contacts", "[advice]") {
  auto scene = test::read_short(test::flores(), 0.8);
  scene.instruments.clear();
  const double requested = 0.01;
  const auto advice = advise(scene, Family::nonsmooth, requested, Conduct{}, {});
  REQUIRE(advice.chosen >= 0);
  const auto& assessed = advice.reference.touches;
  REQUIRE(assessed.size() > 6);
  const auto& chosen = advice.tried[static_cast<std::size_t>(advice.chosen)];
  // Four contacts would have accepted a cheaper setting, which is wrong later.
  CHECK(std::any_of(advice.tried.begin(), advice.tried.begin() + advice.chosen,
                    [&](const Measured& m) { return m.kept_to >= assessed[3].t; }));
  // The whole run of the chosen setting against a tolerance that the recommendation did not use.
  const auto whole = [&](const Setting& setting) {
    auto one = scene;
    setting.apply(one);
    return test::touches(test::simulate(one, Family::nonsmooth));
  };
  const auto found = whole(chosen.setting),
             exact = whole({Family::nonsmooth, {}, Scheme::event_driven, 1e-12});
  const auto nearest = [](const std::vector<ContactEvent>& list, const ContactEvent& to) {
    return *std::ranges::min_element(list, {}, [&](const ContactEvent& e) {
      return std::abs(e.t - to.t) + (e.contact == to.contact ? 0 : 1);
    });
  };
  double before = 0;
  for (const auto& touch : assessed) {
    const auto a = nearest(found, touch), b = nearest(exact, touch);
    CAPTURE(touch.t);
    CHECK(event_difference(a, b, b.t - before) <= requested);
    before = touch.t;
  }
}

TEST_CASE("the predicted accuracy of statistics includes their sampling error", "[advice]") {
  Statistic s;
  s.difference = -0.01;
  s.error = 0.02;
  CHECK(s.promised() == Approx(0.05));
  Advice none;
  CHECK(std::isinf(none.promised()));
  none.statistics = {s, {"another", 1, 0, 0.01, 0.1}};
  CHECK(none.promised() == Approx(0.05));
  // Four runs of 1, 2, 3 and 4: variance 5/3.
  const auto m = moments({1, 2, 3, 4});
  CHECK(m.mean == Approx(2.5));
  CHECK(m.variance == Approx(5.0 / 3));
}

TEST_CASE("advise refuses statistics of starts that cannot differ", "[advice]") {
  // A ball on a shaken table has no clearance in which to vary its start: eight starts were the
  // same run eight times, whose statistics had no sampling error and whose predicted accuracy was
  // meaningless. Beyond A = 1.2 mm (e = 0.8) the bouncing is chaotic.
  const auto file = test::source_folder() / "cases/ball-on-table/scene.toml";
  const auto chaotic =
      read_scene(file, {"curves.shake.amplitude=1.5e-3", "run.duration=4", "nonsmooth.scheme=event-driven"});
  CHECK_THROWS_AS(advise(chaotic, Family::nonsmooth, 0.01, Conduct{}, {}), AlikeStarts);
  CHECK_THROWS_WITH(advise(chaotic, Family::nonsmooth, 0.01, Conduct{}, {}),
                    Catch::Matchers::Contains("all starts are identical") &&
                        Catch::Matchers::Contains("use a run.duration up to that time"));
  CHECK(perturbed_starts(chaotic, {.starts = 8, .how = {.turn = 0, .play = 0.01}}, 0, Conduct{}).empty());
  // A crank that keeps its angle makes no difference.
  const auto driven = read_scene(test::flores());
  CHECK(differ(driven, {.turn = 1, .play = 0}));
  CHECK_FALSE(differ(driven, {.turn = 0, .play = 0}));
  // Up to the horizon starts need not differ.
  auto brief = chaotic;
  brief.run.duration = 0.2;
  CHECK(advise(brief, Family::nonsmooth, 0.01, Conduct{}, {}).to_the_end);
}

TEST_CASE("the settings of --accuracy are among those of the tables", "[advice]") {
  for (const auto& [family, formulation] : families)
    for (const auto accuracy : {Accuracy::fast, Accuracy::balanced, Accuracy::reference}) {
      const auto keys = setting_for(family, accuracy).keys();
      CAPTURE(formulation, keys);
      CHECK(std::ranges::any_of(all_settings(family), [&](const Setting& s) { return s.keys() == keys; }));
    }
}

TEST_CASE("the state is compared in the flight before the last compared contact", "[advice]") {
  auto scene = test::read_short(test::scene_file("gudgeon_1mm_250rpm"), 0.02);
  scene.penalty.contact = ContactLaw::exact;
  for (const auto& [family, formulation] : families) {
    CAPTURE(formulation);
    const auto reference = make_reference(scene, family, Conduct{});
    const auto& touches = reference.touches;
    REQUIRE(touches.size() >= 2);
    CHECK(reference.state_time > touches[touches.size() - 2].t + touches[touches.size() - 2].duration);
    CHECK(reference.state_time < touches.back().t);
    CHECK(reference.state.t == Approx(reference.state_time).epsilon(1e-12));
  }
}
