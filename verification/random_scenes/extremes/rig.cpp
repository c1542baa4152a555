// The test rig of the paper along one parameter at a time: its first two contacts against the
// oracle (two coordinates, no code shared with the solvers).
#include "values/warning.hpp"
#include "verification/random_scenes/extremes/extremes.hpp"
#include "verification/references/delivered_restitution.hpp"
#include "verification/references/slider_crank_oracle.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::random_scenes {
namespace {

using Real = long double;

struct Rig {
  Scene scene;
  reference::LooseSliderCrank<Real> oracle;
  double restitution = 0.46;
};

Rig rig() {
  Rig r;
  r.scene = read_scene(test::flores());
  r.scene.instruments.clear();
  r.scene.run.discard = 0;
  r.scene.penalty.contact = ContactLaw::exact;
  r.oracle.friction = 0.01;
  return r;
}

struct ContactOnset {
  double t, v_n_minus, end;  ///< s, m/s; s when a run must have reported it
};
/// The oracle's first two contacts, rounded; a contact still open at its end counts with its onset.
std::vector<ContactOnset> touches(const reference::OracleRun<Real>& run) {
  std::vector<ContactOnset> list;
  for (std::size_t i = 0; i < std::min<std::size_t>(run.impacts.size(), 2); ++i) {
    const auto& x = run.impacts[i];
    list.push_back({static_cast<double>(x.t), static_cast<double>(x.v_n_minus),
                    static_cast<double>(x.t + 2 * x.duration)});
  }
  // A contact that outlasts four durations of Hertz is reported as lasting; one that ends is an
  // impact.
  if (run.open && list.size() < 2)
    list.push_back({static_cast<double>(run.open->t), static_cast<double>(run.open->v_n_minus),
                    static_cast<double>(run.open->t + 5 * run.open->duration)});
  return list;
}

/// Permitted errors of a contact.
struct Bounds {
  double time, speed;  ///< relative
  double slack;        ///< s, additional error of a time
};

Bounds bounds_of(const Scene& scene, Family family) {
  if (family == Family::penalty) return {1e-6, 1e-4, 0};
  if (scene.nonsmooth.scheme == Scheme::event_driven) return {1e-7, 1e-6, 0};
  return {1e-4, 0.02,
          2 * *scene.nonsmooth.step};  // time stepping: an impact acts at some instant in its step
}

/// The first two contacts; of a failed run, those that it had to report before the failure.
Verdict compare(const Result& run, const std::vector<ContactOnset>& expected, const Bounds& b) {
  const bool failed = run.ending.status != Ending::Status::finished;
  const auto found = test::touches(run);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (found.size() <= i) {
      if (failed && run.t_end < expected[i].end * (1 + b.time) + 2 * b.slack) break;
      return beyond_bound(run, fmt::format("contact onset {} is missing", i + 1));
    }
    // an impact multiplies errors by about ten
    const double grown = std::pow(10, static_cast<double>(i));
    const double late = std::abs(found[i].t - expected[i].t),
                 off = std::abs(found[i].v_n_minus / expected[i].v_n_minus - 1);
    // Speeds change over a step by h over the flight, at either end of it (as in
    // property/comparison/event_driven_test.cpp).
    const double steps =
        i > 0 ? 2 * b.slack * static_cast<double>(i) / (expected[i].t - expected[i - 1].t) : 0;
    if (late <= grown * (b.time * expected[i].t + b.slack) && off <= std::max(grown * b.speed, steps))
      continue;
    return beyond_bound(
        run, fmt::format("contact onset {} at {:.6g} s ({:.6g}), {:.4g} m/s ({:.4g})", i + 1, found[i].t,
                         expected[i].t, found[i].v_n_minus, expected[i].v_n_minus));
  }
  return failed ? Verdict{Outcome::refused, run.ending.reason} : Verdict{};
}

/// Without a contact, the flight itself: crank and slider may be as late, and their speeds as far
/// off, as at a contact. Coordinates: the rod's angle and the slider's position, relative to the
/// crank's dimensions.
Verdict compare_flight(const Rig& r, const Result& run, const reference::OracleRun<Real>& exact,
                       const Bounds& b) {
  if (run.ending.status != Ending::Status::finished) return {Outcome::refused, run.ending.reason};
  const double rate = static_cast<double>(r.oracle.speed),
               reach = static_cast<double>(r.oracle.crank_length) * rate;
  const auto off = [&](const std::vector<double>& x, int angle) {
    return std::max(std::abs(x[5] - static_cast<double>(exact.state[angle])) / rate,
                    std::abs(x[6] - static_cast<double>(exact.state[angle + 2])) / reach);
  };
  const double late = off(run.final_state.q, 0), speed = off(run.final_state.v, 1);
  const bool touched = !test::touches(run).empty();
  if (!touched && late <= b.time * static_cast<double>(exact.t) + b.slack && speed <= b.speed)
    return {Outcome::right, "no contact onset in a revolution, nor in the reference"};
  return beyond_bound(run, touched ? "a contact onset that the reference does not have"
                                   : fmt::format("flight off by {:.2g} s, {:.2g} in speed", late, speed));
}

/// Where the oracle refuses an impact (D_NN ≤ μ |D_NT|, Painlevé), the program must not pass it
/// without a report. The flight to the first contact does not depend on the law, and is compared
/// with that of the compliant one.
Verdict beyond_the_oracle(const Rig& r, Family family) {
  auto scene = r.scene;
  const auto turn = 2 * std::numbers::pi / r.oracle.speed;
  scene.run.duration = static_cast<double>(turn);
  const auto run = test::simulate(scene, family);
  reference::OracleOptions<Real> options;
  options.flight_step = 1e-3 / r.oracle.speed;
  options.most_impacts = 1;
  auto expected = touches(reference::SliderCrankOracle<Real>(r.oracle, options).penalty({}, turn));
  if (expected.size() > 1) expected.resize(1);
  const auto flight = compare(run, expected, bounds_of(scene, family));
  if (flight.outcome != Outcome::right) return flight;
  for (const auto& note : run.notes)
    if (note.find("Painlev") != note.npos || is_warning(note)) return {Outcome::doubted, note};
  return {Outcome::silent, "an impact of Painlevé's kind without a word"};
}

/// `beyond`: s that the run continues after the last contact, so that the program can report on it:
/// on the flight before it, and on a late contact itself.
Verdict assess(Rig& r, Family family, const reference::OracleRun<Real>& exact, double beyond) {
  const auto expected = touches(exact);
  const auto bounds = bounds_of(r.scene, family);
  r.scene.run.duration = expected.empty() ? static_cast<double>(exact.t) : expected.back().end + beyond;
  const auto run = test::simulate(r.scene, family);
  return expected.empty() ? compare_flight(r, run, exact, bounds) : compare(run, expected, bounds);
}

Verdict penalty(Rig r) {
  r.scene.run.duration = 1e-3;
  const double K = test::simulate(r.scene, Family::penalty).contacts.at(0).model.stiffness;
  reference::PenaltyContact<Real> law;
  law.stiffness = K;
  law.chi = static_cast<Real>(reference::exact_chi(r.restitution));
  law.friction_v0 = r.scene.penalty.friction_v0;
  law.friction_v1 = r.scene.penalty.friction_v1;
  reference::OracleOptions<Real> options;
  options.flight_step = 1e-3 / r.oracle.speed;
  const auto turn = 2 * std::numbers::pi / r.oracle.speed;
  const auto exact = reference::SliderCrankOracle<Real>(r.oracle, options).penalty(law, turn);
  return assess(r, Family::penalty, exact, 0);
}

Verdict nonsmooth(Rig r) {
  reference::OracleOptions<Real> options;
  options.flight_step = 1e-3 / r.oracle.speed;
  const auto turn = 2 * std::numbers::pi / r.oracle.speed;
  const auto exact = reference::SliderCrankOracle<Real>(r.oracle, options).nonsmooth(r.restitution, turn);
  return assess(r, Family::nonsmooth, exact,
                r.scene.nonsmooth.scheme == Scheme::moreau_jean ? 10 * *r.scene.nonsmooth.step : 1e-9);
}

using Change = std::function<void(Rig&, double)>;

void axis(std::vector<Cell>& cells, const std::string& name, const std::vector<double>& values,
          const Change& change, bool with_penalty = true, bool with_nonsmooth = true) {
  for (double value : values) {
    const auto label = fmt::format("{:.3g}", value);
    if (with_penalty)
      cells.push_back({name, label, value, "penalty", [=] {
                         auto r = rig();
                         change(r, value);
                         return penalty(r);
                       }});
    if (!with_nonsmooth) continue;
    for (const bool events : {false, true})
      cells.push_back({name, label, value, events ? "event-driven" : "moreau-jean", [=] {
                         auto r = rig();
                         if (events) r.scene.nonsmooth.scheme = Scheme::event_driven;
                         change(r, value);
                         try {
                           return nonsmooth(r);
                         } catch (const std::invalid_argument&) {
                           return beyond_the_oracle(r, Family::nonsmooth);
                         }
                       }});
  }
}

}  // namespace

std::vector<Cell> rig_cells() {
  std::vector<Cell> cells;
  axis(cells, "clearance (m)", {1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2}, [](Rig& r, double c) {
    auto& play = *std::get<RevoluteJoint>(r.scene.mechanism.joints[2]).clearance;
    play.radial = c;
    r.oracle.clearance = c;
  });
  axis(
      cells, "stiffness, relative", {1e-6, 1e-4, 1e-2, 1, 1e2, 1e4, 1e6},
      [](Rig& r, double f) { *r.scene.mechanism.surfaces[0].young *= f; }, true, false);
  axis(cells, "restitution", {0, 0.01, 0.5, 0.9, 0.99, 1}, [](Rig& r, double e) {
    r.scene.mechanism.surfaces[0].restitution = e;
    r.restitution = e;
  });
  axis(cells, "friction", {0, 0.1, 0.5, 1, 2}, [](Rig& r, double mu) {
    r.scene.mechanism.surfaces[0].friction = mu;
    r.oracle.friction = mu;
  });
  axis(
      cells, "step (s)", {1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2},
      [](Rig& r, double h) { r.scene.nonsmooth.step = h; }, false, true);
  std::erase_if(cells, [](const Cell& c) { return c.axis == "step (s)" && c.formulation == "event-driven"; });
  axis(
      cells, "rk4 step (s)", {1e-7, 3e-7, 1e-6, 3e-6, 1e-5, 3e-5, 1e-4, 1e-3, 1e-2},
      [](Rig& r, double h) {
        r.scene.penalty.integrator = Integrator::rk4;
        r.scene.penalty.step = h;
      },
      true, false);
  axis(cells, "speed (rpm)", {1, 10, 100, 1000, 5000, 20000}, [](Rig& r, double rpm) {
    auto& drive = std::get<SpeedDrive>(r.scene.mechanism.drives[0]);
    drive.speed = rpm * 2 * std::numbers::pi / 60;
    r.oracle.speed = drive.speed;
  });
  axis(cells, "slider mass, relative", {1e-6, 1e-4, 1e-2, 1, 1e2, 1e4, 1e6}, [](Rig& r, double f) {
    r.scene.mechanism.bodies[2].mass *= f;
    r.scene.mechanism.bodies[2].inertia *= f;
    r.oracle.slider_mass *= f;
  });
  axis(
      cells, "alpha = beta (1/s)", {0, 1, 100, 1e3, 1e4, 1e5, 1e6},
      [](Rig& r, double a) { r.scene.penalty.alpha = r.scene.penalty.beta = a; }, true, false);
  axis(
      cells, "alpha = beta, rk4 at 1e-5 s (1/s)", {1, 100, 1e4, 1e5, 2e5, 2.5e5, 3e5, 4e5, 1e6},
      [](Rig& r, double a) {
        r.scene.penalty.alpha = r.scene.penalty.beta = a;
        r.scene.penalty.integrator = Integrator::rk4;
        r.scene.penalty.step = 1e-5;
      },
      true, false);
  return cells;
}

}  // namespace freeplay::verification::random_scenes
