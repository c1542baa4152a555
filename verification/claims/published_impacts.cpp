// Published examples of impacts (cases/published): examples of Siconos, and the woodpecker toy of
// Glocker. Each run is compared with a reference in minimal coordinates
// (verification/references/published), and with the published numbers where they are given.
#include "verification/claims/claim.hpp"
#include "verification/references/published/siconos_impacts.hpp"
#include "verification/references/published/woodpecker.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

using Impacts = std::vector<reference::PublishedImpact>;
constexpr const char* independent = "independent event-driven program, order 8 in long double";
constexpr const char* event_scheme = "event-driven";
constexpr const char* penalty_scheme = "penalty";

Scene published_scene(const char* name, const std::vector<std::string>& overrides = {}) {
  return read_scene(test::published(name), overrides);
}
Scene stepped(Scene scene, double h) {
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  scene.nonsmooth.step = h;
  return scene;
}
std::string steps_of(double h) { return fmt::format("Moreau–Jean, h = {:.1e} s", h); }

/// Contact onsets after the start, of one contact if it is named.
std::vector<Event> onsets(const Result& run, const std::string& contact = {}) {
  std::vector<Event> list;
  for (const auto& e : run.events)
    if (e.kind != EventKind::separation && e.t > 0 && (contact.empty() || e.joint == contact))
      list.push_back(e);
  return list;
}

/// Bounds of the event-driven scheme, with their reason.
struct Accuracy {
  double time, relative;
  const char* reason;
};

/// Times, approach speeds and impulses of all impacts of an event-driven run. The impulse of a
/// contact that lasts is not known at its onset and is not claimed.
void all_impacts(Findings& f, const char* subject, const std::vector<Event>& found, const Impacts& exact,
                 const Accuracy& bound) {
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const auto& e = exact[i];
    const auto& onset = found.at(i);
    const auto name = [&](const char* what) {
      return claim_name(subject, fmt::format("{} of impact {}", what, i + 1), event_scheme);
    };
    f.within(name("time"), "s", onset.t, double(e.t), bound.time, independent, bound.reason);
    f.relative(name("approach speed"), "m/s", -onset.v_n_minus, double(-e.v_n_minus), bound.relative,
               independent, bound.reason);
    if (onset.kind != EventKind::impact) continue;
    f.relative(name("normal impulse"), "N s", onset.impulse_n, double(e.impulse_n), bound.relative,
               independent, bound.reason);
    if (e.impulse_t != 0)
      f.relative(name("tangential impulse"), "N s", onset.impulse_t, double(e.impulse_t), bound.relative,
                 independent, bound.reason);
  }
}

/// Times of the first impacts by Moreau–Jean: an impact is located within h, and an error of its
/// time and of its place grows up to fourfold until the next one (as in oracle.cpp).
void first_times(Findings& f, const char* subject, const std::vector<Event>& found, const Impacts& exact,
                 std::size_t count, double h) {
  double late = h;
  for (std::size_t i = 0; i < count; ++i, late *= 4)
    f.within(claim_name(subject, fmt::format("time of impact {}", i + 1), steps_of(h)), "s", found.at(i).t,
             double(exact[i].t), late, independent, "h, times four per further impact");
}

/// All impacts of a pendulum by events, and the first three by Moreau–Jean in a run of `duration`
/// (s).
void impacts_of_pendulum(Findings& f, const char* subject, Scene scene, const Impacts& exact,
                         double duration) {
  all_impacts(
      f, subject, onsets(test::simulate(scene, Family::nonsmooth)), exact,
      {1e-11, 1e-9, "tolerance 1e-12 per step, some 1e3 steps; errors grow up to fourfold per impact"});
  const double h = 1e-5;
  scene.run.duration = duration;
  first_times(f, subject, onsets(test::simulate(stepped(scene, h), Family::nonsmooth)), exact, 3, h);
}

void oscillator_at_wall(Findings& f) {
  const char* const subject = "oscillator at a wall (Siconos)";
  const char* const closed = "harmonic flights in closed form";
  const reference::OscillatorAtWall exact;
  auto scene = published_scene("oscillator-at-wall");
  const auto run = test::simulate(scene, Family::nonsmooth);
  const auto found = onsets(run);
  for (const int n : {1, 2, 10, 92}) {
    const auto e = exact.impact(n);
    const auto name = [&](const char* what) {
      return claim_name(subject, fmt::format("{} of impact {}", what, n), event_scheme);
    };
    const auto& onset = found.at(std::size_t(n - 1));
    const char* const reason = "tolerance 1e-12 per step, up to 1e5 steps; flights do not amplify errors";
    f.within(name("time"), "s", onset.t, double(e.t), 1e-11, closed, reason);
    f.relative(name("normal impulse"), "N s", onset.impulse_n, double(e.impulse), 1e-9, closed, reason);
  }
  f.within(claim_name(subject, "published time of impact 92", event_scheme), "s", found.at(91).t,
           reference::published_impact_92, 1e-11, "LinearOscillatorED.ref of Siconos",
           "tolerances of the published program, about 1e-12 s");
  f.within(claim_name(subject, "time of rest", event_scheme), "s", found.back().t,
           double(exact.accumulation()), 1e-9, "sum of the flights",
           "required accuracy; the accumulation of impacts is ended in closed form");
  f.within(claim_name(subject, "published time of rest", event_scheme), "s", found.back().t,
           reference::published_rest, 2e-6, "LinearOscillatorED.ref of Siconos",
           "flights that leave the wall below 1e-6 m/s last 2e-6 s together");
  f.within(claim_name(subject, "position along the wall after 1 s", event_scheme), "m", run.final_state.q[1],
           double(exact.along_wall(1)), 1e-11, "y₀ cos ωt", "tolerance 1e-12 of 1 m per step");

  const double h = 1e-6;
  scene.run.duration = 0.05;
  const auto by_steps = onsets(test::simulate(stepped(scene, h), Family::nonsmooth));
  const auto by_penalty = onsets(test::simulate(scene, Family::penalty));
  for (int n = 1; n <= 3; ++n) {
    const auto e = exact.impact(n);
    const auto name = [&](const char* scheme) {
      return claim_name(subject, fmt::format("time of impact {}", n), scheme);
    };
    f.within(name(steps_of(h).c_str()), "s", by_steps.at(std::size_t(n - 1)).t, double(e.t), 2 * n * h,
             closed, "an impact is located within h, and the flight begins up to v h from the wall");
    f.within(name(penalty_scheme), "s", by_penalty.at(std::size_t(n - 1)).t, double(e.t),
             1e-9 + 2e-6 * (n - 1), closed, "contact times, 1e-6 s each for K = 1e10 N/m^1.5, margin of two");
    f.relative(claim_name(subject, fmt::format("approach speed of impact {}", n), penalty_scheme), "m/s",
               -by_penalty.at(std::size_t(n - 1)).v_n_minus, double(e.approach), 1e-6, closed,
               "restitution 0.9 of the exact law; work of the spring within 1e-4 m of penetration");
  }
}

void pendulum_between_stops(Findings& f) {
  const char* const subject = "pendulum on a slider between stops (Siconos)";
  auto scene = published_scene("pendulum-between-stops");
  const auto exact = reference::pendulum_between_stops(3);
  impacts_of_pendulum(f, subject, scene, exact, 3);
  scene.run.duration = 1;
  const auto found = onsets(test::simulate(scene, Family::penalty));
  double late = 1e-9;
  for (std::size_t i = 0; i < 3; ++i, late = 4 * (late + 4e-5))
    f.within(claim_name(subject, fmt::format("time of impact {}", i + 1), penalty_scheme), "s", found.at(i).t,
             double(exact[i].t), late, independent,
             "contact times, 4e-5 s each for K = 1e10 N/m^1.5, times four per further impact");
  f.relative(claim_name(subject, "normal impulse of impact 1", penalty_scheme), "N s", found.at(0).impulse_n,
             double(exact[0].impulse_n), 3e-4, independent,
             "acceleration of 10 m/s² during the contact time");
}

void double_pendulum_at_wall(Findings& f) {
  impacts_of_pendulum(f, "double pendulum at a wall (Siconos)", published_scene("double-pendulum-at-wall"),
                      reference::double_pendulum_at_wall(5), 1.5);
}

void impacting_stick(Findings& f) {
  const char* const subject = "impacting stick (Siconos)";
  auto scene = published_scene("impacting-stick");
  auto motion = reference::impacting_stick();
  motion.run(0.2L);
  const auto& exact = motion.impacts;
  all_impacts(f, subject, onsets(test::simulate(scene, Family::nonsmooth)), exact,
              {1e-12, 1e-10, "rounding: flights are polynomials in time, the contact point is not"});
  const double h = 1e-5;
  const auto found = onsets(test::simulate(stepped(scene, h), Family::nonsmooth));
  first_times(f, subject, found, exact, 2, h);
  for (std::size_t i = 0; i < 2; ++i)
    f.relative(claim_name(subject, fmt::format("normal impulse of impact {}", i + 1), steps_of(h)), "N s",
               found.at(i).impulse_n, double(exact[i].impulse_n), 1e-3, independent,
               "change of the approach speed by gravity within the bound of the time, 4 h");

  // The elastic impact with reversal of sliding.
  const reference::ImpactingStick rod;
  const auto& first = exact[0];
  const auto elastic = reference::elastic_impact(
      rod, std::numbers::pi_v<reference::Long> / 4 + 0.1L * first.t, first.v_n_minus, first.v_t_minus);
  const char* const routh = "Routh's method: work of the normal impulse is zero, sliding reverses";
  scene.run.duration = 0.1;
  scene.nonsmooth.impact_law = ImpactLaw::energetic;
  const auto energetic = onsets(test::simulate(scene, Family::nonsmooth)).at(0);
  scene.nonsmooth.impact_law = ImpactLaw::newton;
  scene.penalty.tolerance = 1e-11;
  const auto compliant = onsets(test::simulate(scene, Family::penalty)).at(0);
  const auto claim = [&](const Event& e, const char* scheme, double normal, double tangential,
                         const char* reason) {
    const auto name = [&](const char* what) {
      return claim_name("impacting stick (Siconos), elastic contact", what, scheme);
    };
    f.within(name("normal impulse of impact 1"), "N s", e.impulse_n, double(elastic.impulse_n), normal, routh,
             reason);
    f.within(name("tangential impulse of impact 1"), "N s", e.impulse_t, double(elastic.impulse_t),
             tangential, routh, reason);
    f.within(name("separation speed of impact 1"), "m/s", e.v_n_plus, double(elastic.v_n_plus), 2 * normal,
             routh, reason);
  };
  claim(energetic, "event-driven, energetic law", 1e-11, 1e-11, "rounding");
  claim(compliant, penalty_scheme, 4e-4, 2e-5,
        "weight during the contact time, 2e-5 s for K = 1e10 N/m^1.5, and the regularised friction below "
        "1e-3 m/s; margin of two");
  f.within(claim_name(subject, "time of impact 1", penalty_scheme), "s", compliant.t, double(first.t), 1e-9,
           independent, "free flight, tolerance 1e-11 per step");
}

void rocking_block(Findings& f) {
  const char* const subject = "rocking block (Siconos), corners as in the stored results";
  const char* const fall = "free fall in closed form";
  auto scene = published_scene("rocking-block");
  const auto exact = reference::first_fall({});
  const auto claim = [&](const Event& e, const char* scheme, double time, double relative,
                         const char* reason) {
    f.within(claim_name(subject, "time of impact 1", scheme), "s", e.t, double(exact.t), time, fall, reason);
    f.relative(claim_name(subject, "normal impulse of impact 1", scheme), "N s", e.impulse_n,
               double(exact.impulse_n), relative, fall, reason);
  };
  const auto first = onsets(test::simulate(scene, Family::nonsmooth)).at(0);
  claim(first, event_scheme, 1e-12, 1e-11, "rounding: the fall is a polynomial in time");
  claim(onsets(test::simulate(stepped(scene, 1e-5), Family::nonsmooth)).at(0), steps_of(1e-5).c_str(), 1e-5,
        1e-4, "the step h; g h is 3.3e-5 of the approach speed, margin of three");
  claim(onsets(test::simulate(scene, Family::penalty)).at(0), penalty_scheme, 1e-9, 1e-4,
        "weight during the contact time, 3.2e-5 s for K = 1e10 N/m^1.5, margin of two");
  const char* const stored = "RockingBlockED_Lsodar_LZBimpact.ref of Siconos";
  f.within(claim_name(subject, "published time of impact 1", event_scheme), "s", first.t,
           reference::published_fall, 1e-12, stored, "the published program is exact for a free fall");
  f.within(claim_name(subject, "published approach speed of impact 1", event_scheme), "m/s", -first.v_n_minus,
           reference::published_fall_speed, 1e-12, stored, "the published program is exact for a free fall");
  scene.mechanism.surfaces[0].restitution = 0.8;
  f.within(claim_name(subject, "published impulse of impact 1, e = 0.8", event_scheme), "N s",
           onsets(test::simulate(scene, Family::nonsmooth)).at(0).impulse_n,
           reference::published_rebound + reference::published_fall_speed, 5e-5, stored,
           "impulse step 5e-5 N s of the published program");

  // The block of 1 m × 0.5 m stands on corner A until corner B meets the floor.
  const char* const standing = "rocking block of 1 m × 0.5 m (Siconos, as programmed)";
  reference::RockingBlock block;
  block.half_width = 0.5L, block.half_height = 0.25L;
  const auto both = reference::rocking_block(block, 0.6L);
  const auto wide = published_scene(
      "rocking-block",
      {"bodies.block.points.A=[-0.5,-0.25]", "bodies.block.points.B=[0.5,-0.25]", "run.duration=0.6"});
  const auto found = onsets(test::simulate(wide, Family::nonsmooth), "B").at(0);
  const char* const reason = "tolerance 1e-12 per step, some hundred steps";
  f.within(claim_name(standing, "time of the impact of corner B", event_scheme), "s", found.t,
           double(both.at(1).t), 1e-11, independent, reason);
  f.relative(claim_name(standing, "normal impulse of corner B, corner A in contact", event_scheme), "N s",
             found.impulse_n, double(both.at(1).impulse_n), 1e-9, independent, reason);
}

void woodpecker(Findings& f) {
  const char* const subject = "woodpecker toy";
  const auto scene = published_scene("woodpecker");
  const reference::Woodpecker toy;
  auto motion = reference::woodpecker(toy);
  motion.run(0.62L);
  all_impacts(
      f, subject, onsets(test::simulate(scene, Family::nonsmooth)), motion.impacts,
      {1e-10, 1e-8, "tolerance 1e-12 per step, some 1e4 steps; errors grow up to tenfold per impact"});
  std::vector<double> pecks;
  for (const auto& e : motion.impacts)
    if (e.contact == 0) pecks.push_back(double(e.t));
  const double period = pecks.at(4) - pecks.at(3), from = pecks.at(3) + 0.006;

  // Energy of one peck: the loss over a period.
  auto again = reference::woodpecker(toy);
  again.run(from);
  const double before = double(toy.energy(again.q, again.v));
  again.run(from + period);
  const double loss = before - double(toy.energy(again.q, again.v));
  const auto claim = [&](const Scene& by, const char* scheme, double time, double relative,
                         const char* reason) {
    const auto beak = onsets(test::simulate(by, Family::nonsmooth), "beak");
    for (std::size_t i = 0; i < pecks.size(); ++i)
      f.within(claim_name(subject, fmt::format("time of peck {}", i + 1), scheme), "s", beak.at(i).t,
               pecks[i], double(i + 1) * time, independent, reason);
    f.within(claim_name(subject, "period from peck 4 to peck 5", scheme), "s", beak.at(4).t - beak.at(3).t,
             period, 9 * time, independent, reason);
    auto part = by;
    const auto energy_at = [&](double t) {
      part.run.duration = t;
      const auto ledger = test::simulate(part, Family::nonsmooth).ledger;
      return ledger.kinetic + ledger.potential + ledger.elastic;
    };
    f.relative(claim_name(subject, "energy lost in the period from peck 4", scheme), "J",
               energy_at(from) - energy_at(from + period), loss, relative, independent, reason);
  };
  claim(scene, event_scheme, 1e-10, 1e-8, "tolerance 1e-12 per step, some 1e4 steps");
  for (const double h : {1e-5, 2.5e-6})
    claim(stepped(scene, h), steps_of(h).c_str(), 5 * h, 1000 * h,
          "h for each of the five changes of contact of a peck; energy: weight times 0.3 m/s over 45 h");
}

void woodpecker_small_angles(Findings& f) {
  const char* const subject = "woodpecker toy, small angles";
  auto scene = published_scene("woodpecker-small-angles");
  const reference::Woodpecker toy{.stretch = 1e-5L};
  auto motion = reference::woodpecker(toy);
  motion.run(0.62L);
  all_impacts(f, subject, onsets(test::simulate(scene, Family::nonsmooth)), motion.impacts,
              {1e-8, 1e-6, "arms of 2500 m are rounded to 5e-13 m; errors grow up to tenfold per impact"});
  const reference::Woodpecker published{.linear = true};
  auto linear = reference::woodpecker(published);
  linear.run(0.29998L);
  scene.run.duration = 0.29998;
  const auto end = test::simulate(scene, Family::nonsmooth).final_state;
  const double height = end.q[1], rate = end.v[5] / 1e-5;
  const auto name = [&](const char* what) { return claim_name(subject, what, event_scheme); };
  const char* const rest = "nonlinear terms of a stretch of 1e-5, times ten per peck";
  f.within(name("height of the sleeve after 0.29998 s"), "m", height, double(linear.q[0]), 1e-6,
           "linear model in long double", rest);
  f.within(name("angular velocity of the bird after 0.29998 s, unstretched"), "rad/s", rate,
           double(linear.v[2]), 1e-3, "linear model in long double", rest);
  const char* const stored = "Woodpecker.ref of Siconos, time stepping with h = 2e-5 s";
  f.within(name("published height of the sleeve after 0.29998 s"), "m", height, reference::published_height,
           7e-5, stored, "0.34 m/s times h for each of ten changes of contact");
  f.within(name("published angular velocity of the bird after 0.29998 s"), "rad/s", rate,
           reference::published_bird_rate, 0.026, stored,
           "127 rad/s² times h for each of ten changes of contact");
}

}  // namespace

void published_impacts(Findings& f) {
  oscillator_at_wall(f);
  pendulum_between_stops(f);
  double_pendulum_at_wall(f);
  impacting_stick(f);
  rocking_block(f);
  woodpecker(f);
  woodpecker_small_angles(f);
}

}  // namespace freeplay::verification
