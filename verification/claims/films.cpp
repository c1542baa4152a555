// Lubricated joints by every scheme: steady running, squeeze and whirl of a journal in its film
// against closed forms, the limits of very thin and very thick oil, and a mechanism by both
// formulations.
#include "verification/claims/claim.hpp"
#include "verification/claims/journal_scene.hpp"
#include "verification/references/journal_bearing.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

using journal_scene::c;
using journal_scene::film_ways;
using journal_scene::g;
using journal_scene::journal;
using journal_scene::L;
using journal_scene::name_of;
using journal_scene::R;
using reference::JournalBearing;

/// A shaft of nearly constant speed settles at the equilibrium of the cavitated film.
void settles(Findings& f) {
  for (const bool is_short : {true, false}) {
    const JournalBearing b{is_short, true, is_short ? 0.03 : 0.003, R, L, c};
    const double W = 2 * g, omega = 100, e = b.eccentricity(W, omega), phi = b.attitude(e, omega);
    for (const auto& way : film_ways) {
      const auto s = test::finished(way, journal(b, 2, 1e6, omega, g, 1.5)).final_state;
      const auto subject = fmt::format("{}, steady running", name_of(b));
      f.relative(
          claim_name(subject, "eccentricity over clearance after 1.5 s", way.name), "",
          std::hypot(s.q[0], s.q[1]) / c, e, 1e-5,
          is_short ? "short bearing (Ocvirk)" : "long bearing (Sommerfeld), no negative pressure",
          "1.5 s are more than 20 of the slowest decay times 2e/(Wω) …: e^−20, and 1e-6 of the schemes");
      f.within(claim_name(subject, "attitude angle after 1.5 s", way.name), "rad",
               std::atan2(s.q[0], -s.q[1]), phi, 1e-5,
               is_short ? "tan φ = π√(1 − ε²)/(4ε)" : "tan φ = π√(1 − ε²)/(2ε)",
               "1.5 s are more than 20 of the slowest decay times 2e/(Wω) …: e^−20, and 1e-6 of the schemes");
    }
  }
}

/// The force of the full film is perpendicular to the eccentricity; a journal that starts at
/// equilibrium stays there.
void stays(Findings& f) {
  for (const bool is_short : {true, false}) {
    const JournalBearing b{is_short, false, is_short ? 0.03 : 0.003, R, L, c};
    const double W = 2 * g, omega = 100, e = b.eccentricity(W, omega);
    for (const auto& way : film_ways) {
      const auto s = test::finished(way, journal(b, 2, 1e6, omega, g, 0.1, {e * c, 0})).final_state;
      f.at_most(claim_name(fmt::format("{}, start at equilibrium", name_of(b)),
                           "displacement in 0.1 s over clearance", way.name),
                "", std::hypot(s.q[0] - e * c, s.q[1]) / c, 1e-7,
                fmt::format("Sommerfeld's equilibrium, ε = {:.6f}", e),
                "it is unstable with growth rate ω³εc/(8g) ≈ 1/s, so that deviations of rounding stay small");
    }
  }
}

/// Squeeze time: a load presses a journal from ε = 0.1 to 0.8.
void squeezes(Findings& f) {
  for (const bool is_short : {true, false}) {
    JournalBearing b{is_short, false, 1, R, L, c};
    const double m = 2, W = m * g, T = 0.5;
    b.viscosity = W * T / (b.K() * (b.f(0.8) - b.f(0.1)));  // K is in proportion to it
    for (const auto& way : film_ways) {
      const auto s = test::finished(way, journal(b, m, 0.5, 0, g, T, {0, -0.1 * c})).final_state;
      const double e = -s.q[1] / c;
      const auto subject = fmt::format("{}, squeezed from ε = 0.1", name_of(b));
      f.within(claim_name(subject, "ε after the time to 0.8 without inertia", way.name), "", e, 0.8, 1e-4,
               "K (f(0.8) − f(0.1))/W, f = ε/(1 − ε²)^(3/2) or ε/√(1 − ε²)",
               "inertia takes m v/(W t) = c/(g t²) = 4e-5 of the impulse");
      f.relative(
          claim_name(subject, "impulse of the film force", way.name), "N s", b.K() * (b.f(e) - b.f(0.1)),
          W * T + m * s.v[1], 2e-5, "momentum: K (f − f₀) = W t − m v, inertia included",
          "adaptive steps: 1e-6 of the clearance, times d ln f/dε = 6; fixed steps: 2e-5 of the time each");
    }
    std::vector<double> steps{4e-3, 2e-3, 1e-3, 5e-4}, errors;
    for (const double h : steps) {
      const auto s =
          test::finished(test::fixed_steps(h), journal(b, m, 0.5, 0, g, T, {0, -0.1 * c})).final_state;
      errors.push_back(std::abs(b.K() * (b.f(-s.q[1] / c) - b.f(0.1)) - W * T - m * s.v[1]));
    }
    f.between(
        claim_name(fmt::format("{}, squeezed from ε = 0.1", name_of(b)),
                   "order of the impulse's error, unresolved decay", "Moreau–Jean, h = 5e-4 s to 4e-3 s"),
        "", test::observed_order(steps, errors), 1.8, 2.2,
        "theory: 2, positions follow the midpoint velocity", "asymptotic regime; hC/m ≥ 25");
  }
}

/// Half-speed whirl: a light journal in a full film whirls at half the shaft speed, with slowly
/// growing radius.
void whirls(Findings& f) {
  const double m = 2, omega = 600, T = 0.05, start = 1e-4 * c;
  for (const bool is_short : {true, false}) {
    JournalBearing b{is_short, false, 1, R, L, c};
    b.viscosity = 2000 * m / b.centre();  // C/m = 2000 1/s
    const auto s = reference::whirl(m, b.centre(), omega);
    const auto exact = start * std::exp(s * T), velocity = start * s;
    const auto scene = [&](double duration) {
      return journal(b, m, 1e6, omega, 0, duration, {start, 0}, {velocity.real(), velocity.imag()});
    };
    const auto apart = [&](const Result& run) {
      return std::abs(std::complex<double>(run.final_state.q[0], run.final_state.q[1]) - exact) /
             std::abs(exact);
    };
    for (const auto& way : film_ways) {
      auto found = scene(T);
      found.nonsmooth.step_tolerance = 1e-11;  // of the clearance; the eccentricity is 1e-4 of it
      found.penalty.tolerance = found.nonsmooth.tolerance = 1e-12;
      f.at_most(claim_name(fmt::format("{}, half-speed whirl", name_of(b)),
                           "position error over eccentricity after 0.05 s", way.name),
                "", apart(test::finished(way, found)), 1e-4,
                fmt::format("z₀e^(st), s = {:.2f} + {:.2f}i 1/s", s.real(), s.imag()),
                "adaptive steps: 1e-7 of the eccentricity each, up to a thousand; "
                "fixed steps: (ωh)²/24 ω t = 5e-5");
    }
    std::vector<double> steps{2e-4, 1e-4, 5e-5, 2.5e-5}, errors;
    for (const double h : steps) errors.push_back(apart(test::finished(test::fixed_steps(h), scene(T))));
    f.between(claim_name(fmt::format("{}, half-speed whirl", name_of(b)), "order of the position error",
                         "Moreau–Jean, h = 2.5e-5 s to 2e-4 s"),
              "", test::observed_order(steps, errors), 1.9, 2.1, "theory: 2 (θ = ½ + O(h))",
              "asymptotic regime, hC/m from 0.05 to 0.4");
    f.curves.push_back(
        {"film_orders", name_of(b), "step (s)", "error over eccentricity or clearance", steps, errors});
  }
}

/// The shear of the film brakes a concentric shaft.
void brakes(Findings& f) {
  const JournalBearing b{true, true, 0.05, R, L, c};
  const double I = 1e-3, T = 0.2, omega = 100;
  for (const auto& way : film_ways) {
    const auto s = test::finished(way, journal(b, 2, I, omega, 0, T)).final_state;
    f.relative(claim_name("shaft braked by its film", "speed after 0.2 s", way.name), "rad/s", s.v[2],
               omega * std::exp(-b.petroff() * T / I), 1e-5, "Petroff: ω₀ e^(−2πμR³Lt/(cI))",
               "adaptive steps: 1e-6 per step of the speed's scale");
  }
}

/// Thin and thick oil.
void limits(Findings& f) {
  const char *falling = "journal falling in oil of 1e-13 Pa s", *thick_oil = "journal in oil of 1e5 Pa s";
  const double fall = std::sqrt(2 * c / g);
  for (const auto& way : film_ways) {
    const JournalBearing thin{true, true, 1e-13, R, L, c};
    const auto run = test::finished(way, journal(thin, 2, 0.5, 0, g, 3 * fall));
    const auto touch = test::touch(run, 0);
    const bool fixed = way.step > 0;
    f.relative(
        claim_name(falling, "time of first contact", way.name), "s", touch.t, fall, fixed ? 5e-3 : 1e-5,
        "√(2c/g), dry",
        fixed ? "contact onset within a fixed step, known to 1.5 h"
              : "impulse of the film K f(0.99) = 1e-9 N s of 0.09; adaptive steps locate contacts to 1e-6");
    f.relative(
        claim_name(falling, "speed at first contact", way.name), "m/s", -touch.v_n_minus,
        std::sqrt(2 * g * c), fixed ? 5e-3 : 1e-5, "√(2gc), dry",
        fixed ? "contact onset within a fixed step, known to 1.5 h"
              : "impulse of the film K f(0.99) = 1e-9 N s of 0.09; adaptive steps locate contacts to 1e-6");
    const JournalBearing thick{true, false, 1e5, R, L, c};
    const auto s = test::finished(way, journal(thick, 2, 0.5, 0, g, 0.1, {0, 0})).final_state;
    f.relative(claim_name(thick_oil, "displacement under weight in 0.1 s over clearance", way.name), "",
               -s.q[1] / c, 2 * g * 0.1 / thick.K(), 1e-3, "ε = W t/K",
               "inertia m/C = 1e-8 s; displacement 3e-12 m with rounding 4e-18 m");
    // At 1 m/s the journal stops within m v/K of the clearance, far less than the travel of a step.
    const auto thrown = test::finished(way, journal(thick, 2, 0.5, 0, 0, 0.01, {0, 0}, {0, -1})).final_state;
    f.relative(claim_name(thick_oil, "displacement from 1 m/s over clearance", way.name), "",
               -thrown.q[1] / c, 2 / thick.K(), fixed ? 0.05 : 1e-3, "ε = m v/K",
               fixed ? "the step in which it stops uses the film coefficients at its start"
                     : "tighter than the step tolerance, 1e-6 of the clearance");
  }
}

/// The case of the lubricated gudgeon pin, whose film prevents dry contact.
void pin(Findings& f) {
  const char* const subject = "slider-crank with lubricated gudgeon pin";
  const auto scene = read_scene(test::source_folder() / "cases/lubricated-pin/scene.toml",
                                {"run.revolutions=1", "run.discard=0"});
  auto fine = scene;
  fine.penalty.tolerance = 1e-12;
  const auto exact = test::finished(film_ways[0], fine);
  const double clearance = 0.25e-3;
  for (const auto& way : film_ways) {
    const auto run = test::finished(way, scene);
    double apart = 0;
    for (std::size_t i = 0; i < run.final_state.q.size(); ++i)
      apart = greatest(apart, std::abs(run.final_state.q[i] - exact.final_state.q[i]) *
                                  (i % 3 == 2 ? 0.15 : 1) / clearance);
    const bool chosen = way.chosen();
    const double bound = way.step > 0 ? 1e-4 : chosen ? 5e-3 : 1e-6;
    const auto name = [&](const char* quantity) { return claim_name(subject, quantity, way.name); };
    f.at_most(name("difference of coordinates to a reference run after one turn, over clearance"), "", apart,
              bound, "penalty at tolerance 1e-12",
              way.step > 0 ? "h² of the film's rates: (1e-5 · 1e3)²"
              : chosen     ? "1e-6 per step over some thousand steps"
                           : "tolerance 1e-8 per step or finer; the film damps errors");
    f.relative(name("work absorbed by the film in one turn"), "J", run.ledger.film, exact.ledger.film,
               chosen ? 1e-3 : 1e-4, "penalty at tolerance 1e-12", "as of the coordinates");
    f.at_most(name("error of the energy balance over its greatest term"), "",
              std::abs(run.ledger.closure()) / run.ledger.scale(), 1e-9, "0",
              "rounding: the absorbed work is the integral of the applied force");
  }
  auto quarter = read_scene(test::source_folder() / "cases/lubricated-pin/scene.toml",
                            {"run.revolutions=0.25", "run.discard=0"});
  quarter.nonsmooth.tolerance = 1e-12;
  const auto end = test::finished(film_ways[3], quarter).final_state;
  std::vector<double> steps{2e-4, 1e-4, 5e-5, 2.5e-5}, errors;
  for (const double h : steps) {
    const auto s = test::finished(test::fixed_steps(h), quarter).final_state;
    errors.push_back(std::hypot(s.q[6] - end.q[6], s.q[4] - end.q[4]) / clearance);
  }
  f.between(claim_name(subject, "order of the position error after a quarter turn",
                       "Moreau–Jean, h = 2.5e-5 s to 2e-4 s"),
            "", test::observed_order(steps, errors), 1.9, 2.1, "theory: 2; reference event-driven at 1e-12",
            "asymptotic regime");
  f.curves.push_back({"film_orders", "lubricated pin of a slider-crank", "step (s)",
                      "error over eccentricity or clearance", steps, errors});
}

}  // namespace

Parts films() { return {settles, stays, squeezes, whirls, brakes, limits, pin, film_coefficients}; }

}  // namespace freeplay::verification
