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

struct Method {
  const char* name;
  Family family = Family::nonsmooth;
  std::optional<Scheme> scheme = {};  ///< none: the scene's, with its fixed steps
  double restitution = e_paired;
};
constexpr Method methods[] = {{"penalty", Family::penalty},
                              {"Moreau–Jean, h = 1e-5 s"},
                              {"Moreau–Jean, adaptive steps", Family::nonsmooth, Scheme::moreau_jean},
                              {"automatic", Family::nonsmooth, Scheme::automatic},
                              {"control", Family::nonsmooth, {}, e_control}};
enum class By { penalty, fixed_steps, adaptive_steps, automatic, control };
constexpr const Method& method_of(By by) { return methods[static_cast<std::size_t>(by)]; }

/// The values of all starts by a method, computed once.
const std::vector<Values>& runs_by(By by) {
  static std::array<std::vector<Values>, std::size(methods)> known;
  auto& runs = known[static_cast<std::size_t>(by)];
  if (!runs.empty()) return runs;
  runs.resize(starts);
  const auto& method = method_of(by);
  oneapi::tbb::parallel_for(0, starts, [&](int i) {
    auto scene = start(i);
    scene.mechanism.surfaces[0].restitution = method.restitution;
    if (method.scheme) scene.nonsmooth.step.reset(), scene.nonsmooth.scheme = method.scheme;
    runs[i] = watch(scene, method.family);
  });
  return runs;
}

constexpr const char* subject = "paper's slider-crank with clearance, e = 0.9, K × 1000";

void formulations(Findings& f) {
  const auto &compliant = runs_by(By::penalty), &rigid = runs_by(By::fixed_steps);
  for (int q = 0; q < count; ++q) {
    const Welch welch(compliant, rigid, q);
    double mean = 0;
    for (const auto& x : rigid) mean += x[q] / starts;
    f.within(
        claim_name(subject, fmt::format("{}, difference of means of {} runs", quantities[q].name, starts),
                   fmt::format("penalty against {}", method_of(By::fixed_steps).name)),
        quantities[q].unit, welch.difference, 0, welch.allowed * welch.error,
        fmt::format("0; mean of Moreau–Jean: {:.4g}", mean),
        fmt::format("Welch's test at 0.1 %: {:.2f} standard errors of {:.2g}", welch.allowed, welch.error));
  }
}

void against_automatic(Findings& f, By one) {
  double most = 0;
  for (int q = 0; q < count; ++q) {
    const Welch welch(runs_by(one), runs_by(By::automatic), q);
    most = greatest(most, std::abs(welch.difference) / (welch.allowed * welch.error));
  }
  f.at_most(claim_name(subject, "greatest difference of the eleven means over the allowed one",
                       fmt::format("{}, against automatic", method_of(one).name)),
            "", most, 1, "0", "Welch's test at 0.1 %, 24 runs each");
}
void fixed_against_automatic(Findings& f) { against_automatic(f, By::fixed_steps); }
void adaptive_against_automatic(Findings& f) { against_automatic(f, By::adaptive_steps); }

/// Whether the test detects another restitution.
void power(Findings& f) {
  int detected = 0;
  for (int q = 0; q < count; ++q) {
    const Welch welch(runs_by(By::control), runs_by(By::fixed_steps), q);
    detected += quantities[q].of_rebound && std::abs(welch.difference) > welch.allowed * welch.error;
  }
  const auto rebounds = static_cast<double>(std::ranges::count_if(quantities, &Quantity::of_rebound));
  f.within(
      claim_name(subject, fmt::format("number of rebound statistics that detect e = {}, control", e_control),
                 method_of(By::fixed_steps).name),
      "", detected, rebounds, 0, "all statistics governed by restitution", "exact; Welch's test at 0.1 %");
}

}  // namespace

Parts statistics() {
  return {{formulations, count}, {fixed_against_automatic, 1}, {adaptive_against_automatic, 1}, {power, 1}};
}

}  // namespace freeplay::verification
