// Long chaotic runs: means of statistics over runs from perturbed starts, compared between both
// formulations and between the schemes of the nonsmooth one by Welch's test. Runs with another
// restitution are the control: the test must detect them.
#include <oneapi/tbb/parallel_for.h>
#include <boost/math/distributions/students_t.hpp>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "simulation/statistics.hpp"
#include "verification/claims/claim.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

constexpr int starts = 24, turns = 12, discarded = 2;
constexpr double turn = 0.3, clearance = 0.25e-3;  // s, m
/// At the paper's restitution there is a third of an impact per turn: too few to compare.
constexpr double e_paired = 0.9, e_control = 0.1;
/// Impacts are counted above this approach speed (m/s), since an impact law has arbitrarily small
/// ones and a contact force has not.
constexpr double counted_speed = 0.01;

struct Quantity {
  const char *name, *unit;
  /// governed by the restitution: flight, frequency and strength of impacts
  bool of_rebound = false;
};
constexpr Quantity quantities[] = {{"share of time in contact", "", true},
                                   {"energy lost per turn", "J"},
                                   {"greatest approach speed", "m/s"},
                                   {"greatest impulse", "N s", true},
                                   {"impacts per turn above 0.01 m/s", "", true},
                                   {"mean impulse of impacts above 0.01 m/s", "N s", true},
                                   {"total impulse per turn of impacts above 0.01 m/s", "N s", true},
                                   {"mean of e_x over clearance", ""},
                                   {"share of time with e_y > 0", ""},
                                   {"share of time with e_x > 0 and e_y > 0", ""},
                                   {"share of time with a gap above half the clearance", ""}};
constexpr int count = std::size(quantities);
using Values = std::array<double, count>;

/// The paper's slider-crank with initial state i: the journal displaced from the centre at an angle
/// of 2π i/starts.
Scene start(int i) {
  auto scene = read_scene(test::flores());
  scene.instruments.clear();
  scene.mechanism.surfaces[0].young = 207e9 * 1e3;
  scene.mechanism.surfaces[0].restitution = e_paired;
  scene.penalty.contact = ContactLaw::exact;  // delivers the restitution of the impact law
  scene.run.duration = turns * turn;
  scene.run.discard = discarded * turn;
  start_from(scene.mechanism, assemble(scene.mechanism, RunOptions::Start::ideal));
  const double angle = 2 * M_PI * i / starts;
  auto& slider = scene.mechanism.bodies[2];
  slider.position->x() += 0.5 * clearance * std::cos(angle);
  slider.velocity->x() += 0.02 * std::sin(angle);
  scene.run.start = RunOptions::Start::given;
  return scene;
}

Values watch(const Scene& scene, Family family) {
  const System system(scene.mechanism);
  Simulation simulation(scene, test::name_of(family));
  ContactStatistics statistics(scene.run.discard);
  std::vector<double> impulses;
  test::Listener listener;
  Result run;
  listener.on_event = [&](const ContactEvent& event) {
    if (event.kind != EventKind::separation && event.t > discarded * turn && event.v_n_minus < -counted_speed)
      impulses.push_back(event.impulse_n);
  };
  auto e = system.make_evaluation();
  double along = 0, upper = 0, quarter = 0, flying = 0;
  int samples = 0;
  const auto march = [&](double t) {
    run = simulation.run({.until = t, .observers = {&listener, &statistics}, .keep_events = false});
    if (run.ending.status != Ending::Status::finished) throw std::runtime_error(run.ending.reason);
  };
  for (int i = 0; i <= 1000 * (turns - discarded) * turn; ++i, ++samples) {
    const double t = discarded * turn + 1e-3 * i;
    march(std::min(t, scene.run.duration));
    const auto state = simulation.state();
    system.place(t, state.q.data(), e);
    const auto d = system.eccentricity(0, state.q.data(), e);
    along += d.x() / clearance;
    upper += d.y() > 0;
    quarter += d.y() > 0 && d.x() > 0;
    flying += system.gap(0, state.q.data(), e) > 0.5 * clearance;
  }
  march(scene.run.duration);
  statistics.into(run);
  double total = 0;
  for (double x : impulses) total += x;
  const double watched = turns - discarded;
  return {1 - run.contacts[0].flight_fraction,
          (run.ledger.contact + run.ledger.friction) / turns,
          run.contacts[0].fastest_approach,
          run.contacts[0].greatest_impulse,
          static_cast<double>(impulses.size()) / watched,
          impulses.empty() ? 0 : total / static_cast<double>(impulses.size()),
          total / watched,
          along / samples,
          upper / samples,
          quarter / samples,
          flying / samples};
}

/// Welch's test of equal means: their difference, its standard error, and the number of standard
/// errors allowed at 0.1 %.
struct Welch {
  double difference = 0, error = 0, allowed = 0;
  Welch(const std::vector<Values>& one, const std::vector<Values>& other, int q) {
    double mean[2] = {0, 0}, variance[2] = {0, 0};
    const std::vector<Values>* groups[] = {&one, &other};
    const double n = static_cast<double>(one.size());
    for (int k : {0, 1}) {
      for (const auto& x : *groups[k]) mean[k] += x[q] / n;
      for (const auto& x : *groups[k]) variance[k] += (x[q] - mean[k]) * (x[q] - mean[k]) / (n - 1);
    }
    const double a = variance[0] / n, b = variance[1] / n;
    difference = mean[0] - mean[1];
    error = std::sqrt(a + b);
    const double freedom = a + b > 0 ? (a + b) * (a + b) / ((a * a + b * b) / (n - 1)) : 2 * n - 2;
    allowed = boost::math::quantile(boost::math::complement(boost::math::students_t(freedom), 5e-4));
  }
};

}  // namespace

Findings statistics() {
  std::vector<Values> penalty(starts), nonsmooth(starts), control(starts), chosen(starts), events(starts);
  oneapi::tbb::parallel_for(0, 5 * starts, [&](int job) {
    const int i = job / 5;
    auto scene = start(i);
    const auto by = [&](std::optional<Scheme> scheme) {
      scene.nonsmooth.scheme = scheme;
      scene.nonsmooth.step.reset();
      return watch(scene, Family::nonsmooth);
    };
    if (job % 5 == 0) {
      penalty[i] = watch(scene, Family::penalty);
    } else if (job % 5 == 1) {
      nonsmooth[i] = watch(scene, Family::nonsmooth);
    } else if (job % 5 == 2) {
      chosen[i] = by(Scheme::moreau_jean);
    } else if (job % 5 == 3) {
      events[i] = by(Scheme::automatic);
    } else {
      scene.mechanism.surfaces[0].restitution = e_control;
      control[i] = watch(scene, Family::nonsmooth);
    }
  });
  Findings f;
  const char* const largest = "greatest difference of the eleven means over the allowed one";
  const char* const subject = "paper's slider-crank with clearance, e = 0.9, K × 1000";
  int detected = 0;
  for (int q = 0; q < count; ++q) {
    const Welch welch(penalty, nonsmooth, q);
    double mean = 0;
    for (const auto& x : nonsmooth) mean += x[q] / starts;
    f.within(
        claim_name(subject, fmt::format("{}, difference of means of {} runs", quantities[q].name, starts),
                   "penalty against Moreau–Jean, h = 1e-5 s"),
        quantities[q].unit, welch.difference, 0, welch.allowed * welch.error,
        fmt::format("0; mean of Moreau–Jean: {:.4g}", mean),
        fmt::format("Welch's test at 0.1 %: {:.2f} standard errors of {:.2g}", welch.allowed, welch.error));
    const Welch power(control, nonsmooth, q);
    detected += quantities[q].of_rebound && std::abs(power.difference) > power.allowed * power.error;
  }
  const auto apart = [&](const std::vector<Values>& one, const std::vector<Values>& other) {
    double most = 0;
    for (int q = 0; q < count; ++q) {
      const Welch welch(one, other, q);
      most = greatest(most, std::abs(welch.difference) / (welch.allowed * welch.error));
    }
    return most;
  };
  const auto reason = "Welch's test at 0.1 %, 24 runs each";
  f.at_most(claim_name(subject, largest, "Moreau–Jean, h = 1e-5 s, against automatic"), "",
            apart(nonsmooth, events), 1, "0", reason);
  f.at_most(claim_name(subject, largest, "Moreau–Jean, adaptive steps, against automatic"), "",
            apart(chosen, events), 1, "0", reason);
  const auto rebounds = static_cast<double>(std::ranges::count_if(quantities, &Quantity::of_rebound));
  f.within(
      claim_name(subject, fmt::format("number of rebound statistics that detect e = {}, control", e_control),
                 "Moreau–Jean, h = 1e-5 s"),
      "", detected, rebounds, 0, "all statistics governed by restitution", "exact; Welch's test at 0.1 %");
  return f;
}

}  // namespace freeplay::verification
