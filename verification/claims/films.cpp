// Lubricated joints by every scheme: steady running, squeezing and whirl of a journal in its film by their closed forms, the
// limits of no oil and of very thick oil, and a mechanism by one formulation against the other.
#include <fmt/format.h>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/journal_bearing.hpp"
#include "verification/support/support.hpp"
#include "verification/support/ways.hpp"

namespace freeplay::verification {
namespace {

using reference::JournalBearing;

constexpr double R = 20e-3, L = 15e-3, c = 0.1e-3, g = 9.81;

using test::Way;
const Way film_ways[] = {test::penalty, test::fixed_steps(1e-5, "Moreau–Jean, fixed steps"),
                         test::chosen_steps, test::event_driven, test::automatic};

std::string name_of(const JournalBearing& b) {
  return fmt::format("{} {} film", b.is_short ? "short" : "long", b.cavitated ? "half-Sommerfeld" : "full");
}

/// A journal on a shaft that may also move across its bearing at rest.
Scene journal(const JournalBearing& b, double mass, double inertia, double omega, double gravity,
              double duration, Vec2 from = {0, 0}, Vec2 velocity = {0, 0}) {
  return parse_scene(
      fmt::format(R"(
gravity = [0, {}]
[bodies.shaft]
mass = {}
inertia = {}
angular_velocity = {}
position = [{}, {}]
velocity = [{}, {}]
[lubricants.oil]
viscosity = {}
film = "{}"
cavitation = "{}"
[surfaces.steel]
young = 2e11
poisson = 0.3
restitution = 0.5
[joints.bearing]
type = "revolute"
between = ["ground", "shaft"]
clearance = {}
bearing_radius = {}
bearing_length = {}
surface = "steel"
lubricant = "oil"
[run]
duration = {}
)",
                  -gravity, mass, inertia, omega, from.x(), from.y(), velocity.x(), velocity.y(), b.viscosity,
                  b.is_short ? "short" : "long", b.cavitated ? "half-sommerfeld" : "none", b.clearance,
                  b.radius, b.length, duration),
      "journal");
}

Result by(Scene scene, const Way& way) {
  way.choose(scene);
  return test::finished(scene, way.family);
}

/// A shaft whose speed hardly changes settles where the cavitated film carries it.
void settles(Findings& f) {
  for (const bool is_short : {true, false}) {
    const JournalBearing b{is_short, true, is_short ? 0.03 : 0.003, R, L, c};
    const double W = 2 * g, omega = 100, e = b.eccentricity(W, omega), phi = b.attitude(e, omega);
    for (const auto& way : film_ways) {
      const auto s = by(journal(b, 2, 1e6, omega, g, 1.5), way).final_state;
      const auto what = fmt::format("{}, {}: steady running", name_of(b), way.name);
      f.relative(
          what + ", eccentricity over clearance", "", std::hypot(s.q[0], s.q[1]) / c, e, 1e-5,
          is_short ? "Ocvirk's short bearing" : "Sommerfeld's long bearing, no tension",
          "1.5 s are over twenty of the slowest decay times 2e/(Wω) …: e^−20, and 1e-6 of the schemes");
      f.within(what + ", attitude angle", "rad", std::atan2(s.q[0], -s.q[1]), phi, 1e-5,
               is_short ? "tan φ = π√(1 − ε²)/(4ε)" : "tan φ = π√(1 − ε²)/(2ε)", "the same");
    }
  }
}

/// The full film carries at a right angle to its eccentricity; a journal that starts there stays.
void stays(Findings& f) {
  for (const bool is_short : {true, false}) {
    const JournalBearing b{is_short, false, is_short ? 0.03 : 0.003, R, L, c};
    const double W = 2 * g, omega = 100, e = b.eccentricity(W, omega);
    for (const auto& way : film_ways) {
      const auto s = by(journal(b, 2, 1e6, omega, g, 0.1, {e * c, 0}), way).final_state;
      f.at_most(
          fmt::format("{}, {}: leaves its steady running by, over clearance", name_of(b), way.name), "",
          std::hypot(s.q[0] - e * c, s.q[1]) / c, 1e-7,
          fmt::format("Sommerfeld's equilibrium, ε = {:.6f}", e),
          "it is unstable, but grows by ω³εc/(8g) ≈ 1/s: what begins at the position's rounding stays small");
    }
  }
}

/// The time of squeezing: a load presses a journal from ε = 0.1 to 0.8.
void squeezes(Findings& f) {
  for (const bool is_short : {true, false}) {
    JournalBearing b{is_short, false, 1, R, L, c};
    const double m = 2, W = m * g, T = 0.5;
    b.viscosity = W * T / (b.K() * (b.f(0.8) - b.f(0.1)));  // K is in proportion to it
    for (const auto& way : film_ways) {
      const auto s = by(journal(b, m, 0.5, 0, g, T, {0, -0.1 * c}), way).final_state;
      const double e = -s.q[1] / c;
      const auto what = fmt::format("{}, {}: squeezed from ε = 0.1", name_of(b), way.name);
      f.within(what + ", ε after the time to 0.8 without inertia", "", e, 0.8, 1e-4,
               "K (f(0.8) − f(0.1))/W, f = ε/(1 − ε²)^(3/2) or ε/√(1 − ε²)",
               "inertia holds back m v/(W t) = c/(g t²) = 4e-5 of the impulse");
      f.relative(
          what + ", impulse that the film took", "N s", b.K() * (b.f(e) - b.f(0.1)), W * T + m * s.v[1], 2e-5,
          "momentum: K (f − f₀) = W t − m v, inertia included",
          "chosen steps to 1e-6 of the clearance, times d ln f/dε = 6; fixed ones of 2e-5 of the time");
    }
    std::vector<double> steps{4e-3, 2e-3, 1e-3, 5e-4}, errors;
    for (const double h : steps) {
      const auto s =
          by(journal(b, m, 0.5, 0, g, T, {0, -0.1 * c}), {"", Family::nonsmooth, Scheme::moreau_jean, h})
              .final_state;
      errors.push_back(std::abs(b.K() * (b.f(-s.q[1] / c) - b.f(0.1)) - W * T - m * s.v[1]));
    }
    f.between(fmt::format("order of Moreau–Jean, squeezed {} that its steps do not resolve", name_of(b)), "",
              test::observed_order(steps, errors), 1.8, 2.2,
              "theory: 2, places go the way of the middle's rates", "asymptotic regime; hC/m is 25 and more");
  }
}

/// A light journal in a full film goes round at half the speed of its shaft, and slowly outwards.
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
      found.nonsmooth.step_tolerance = 1e-11;  // of the clearance, of which this is 1e-4
      found.penalty.tolerance = found.nonsmooth.tolerance = 1e-12;
      f.at_most(
          fmt::format("{}, {}: whirl at half speed, error over eccentricity", name_of(b), way.name), "",
          apart(by(found, way)), 1e-4, fmt::format("z₀e^(st), s = {:.2f} + {:.2f}i 1/s", s.real(), s.imag()),
          "chosen steps: 1e-7 of the eccentricity each, up to a thousand of them; fixed ones (ωh)²/24 ω t = 5e-5");
    }
    std::vector<double> steps{2e-4, 1e-4, 5e-5, 2.5e-5}, errors;
    for (const double h : steps)
      errors.push_back(apart(by(scene(T), {"", Family::nonsmooth, Scheme::moreau_jean, h})));
    f.between(fmt::format("order of Moreau–Jean, whirl in a {}", name_of(b)), "",
              test::observed_order(steps, errors), 1.9, 2.1, "theory: 2 (θ = ½ + O(h))",
              "asymptotic regime, hC/m from 0.4 to 0.05");
    f.curves.push_back(
        {"film_orders", name_of(b), "step (s)", "error over eccentricity or clearance", steps, errors});
  }
}

/// The shear of the film brakes a concentric shaft.
void brakes(Findings& f) {
  const JournalBearing b{true, true, 0.05, R, L, c};
  const double I = 1e-3, T = 0.2, omega = 100;
  for (const auto& way : film_ways) {
    const auto s = by(journal(b, 2, I, omega, 0, T), way).final_state;
    f.relative(fmt::format("{}: speed of a shaft braked by its film", way.name), "rad/s", s.v[2],
               omega * std::exp(-b.petroff() * T / I), 1e-5, "Petroff: ω₀ e^(−2πμR³Lt/(cI))",
               "chosen steps: 1e-6 a step of the speed's scale");
  }
}

/// Thin and thick oil.
void limits(Findings& f) {
  const double fall = std::sqrt(2 * c / g);
  for (const auto& way : film_ways) {
    const JournalBearing thin{true, true, 1e-13, R, L, c};
    const auto run = by(journal(thin, 2, 0.5, 0, g, 3 * fall), way);
    const auto touch = test::touch(run, 0);
    const bool fixed = way.step > 0;
    f.relative(fmt::format("{}: oil of 1e-13 Pa s, first touch of a journal that falls", way.name), "s",
               touch.t, fall, fixed ? 5e-3 : 1e-5, "√(2c/g), dry",
               fixed ? "a touch of a fixed step, told to 1.5 of it"
                     : "the film takes K f(0.99) = 1e-9 N s of 0.09, chosen steps land to 1e-6");
    f.relative(fmt::format("{}: the same, speed of that touch", way.name), "m/s", -touch.v_n_minus,
               std::sqrt(2 * g * c), fixed ? 5e-3 : 1e-5, "√(2gc), dry", "the same");
    const JournalBearing thick{true, false, 1e5, R, L, c};
    const auto s = by(journal(thick, 2, 0.5, 0, g, 0.1, {0, 0}), way).final_state;
    f.relative(fmt::format("{}: oil of 1e5 Pa s, a journal's way over clearance in 0.1 s", way.name), "",
               -s.q[1] / c, 2 * g * 0.1 / thick.K(), 1e-3, "ε = W t/K",
               "inertia m/C = 1e-8 s; it moves by 3e-12 m, rounding 4e-18");
    // Thrown in at 1 m/s it stops within m v/K of the clearance, far less than a step's way.
    const auto thrown = by(journal(thick, 2, 0.5, 0, 0, 0.01, {0, 0}, {0, -1}), way).final_state;
    f.relative(fmt::format("{}: the same, thrown in at 1 m/s, way over clearance", way.name), "",
               -thrown.q[1] / c, 2 / thick.K(), fixed ? 0.05 : 1e-3, "ε = m v/K",
               fixed ? "the step over which it stops takes the film as before: θ is of its decay alone"
                     : "chosen steps to 1e-6 of the clearance would allow more");
  }
}

/// A mechanism: the case of the lubricated gudgeon pin, whose film carries without dry contact.
void pin(Findings& f) {
  const auto scene = read_scene(test::source_folder() / "cases/lubricated-pin/scene.toml",
                                {"run.revolutions=1", "run.discard=0"});
  auto fine = scene;
  fine.penalty.tolerance = 1e-12;
  const auto exact = by(fine, film_ways[0]);
  const double clearance = 0.25e-3;
  for (const auto& way : film_ways) {
    const auto run = by(scene, way);
    double apart = 0;
    for (std::size_t i = 0; i < run.final_state.q.size(); ++i)
      apart = greatest(apart, std::abs(run.final_state.q[i] - exact.final_state.q[i]) *
                                  (i % 3 == 2 ? 0.15 : 1) / clearance);
    const bool chosen = way.chosen();
    const double bound = way.step > 0 ? 1e-4 : chosen ? 5e-3 : 1e-6;
    const auto what = fmt::format("lubricated gudgeon pin, {}", way.name);
    f.at_most(what + ": places after one turn, apart from penalty's at 1e-12, over clearance", "", apart,
              bound, "the other formulation",
              way.step > 0 ? "h² of the film's rates: (1e-5 · 1e3)²"
              : chosen     ? "1e-6 a step over some thousand steps"
                           : "tolerance 1e-8 or finer a step; the film forgets");
    f.relative(what + ": work that the film took", "J", run.ledger.film, exact.ledger.film,
               chosen ? 1e-3 : 1e-4, "the other formulation", "the same");
    f.at_most(what + ": closure of the energy over its greatest term", "",
              std::abs(run.ledger.closure()) / run.ledger.scale(), 1e-9, "",
              "what the film took is what it did");
  }
  auto quarter = read_scene(test::source_folder() / "cases/lubricated-pin/scene.toml",
                            {"run.revolutions=0.25", "run.discard=0"});
  quarter.nonsmooth.tolerance = 1e-12;
  const auto end = by(quarter, film_ways[3]).final_state;
  std::vector<double> steps{2e-4, 1e-4, 5e-5, 2.5e-5}, errors;
  for (const double h : steps) {
    const auto s = by(quarter, {"", Family::nonsmooth, Scheme::moreau_jean, h}).final_state;
    errors.push_back(std::hypot(s.q[6] - end.q[6], s.q[4] - end.q[4]) / clearance);
  }
  f.between("order of Moreau–Jean, lubricated gudgeon pin, a quarter turn", "",
            test::observed_order(steps, errors), 1.9, 2.1, "theory: 2; apart from event-driven at 1e-12",
            "asymptotic regime");
  f.curves.push_back({"film_orders", "lubricated pin of a slider-crank", "step (s)",
                      "error over eccentricity or clearance", steps, errors});
}

}  // namespace

Findings films() {
  Findings f;
  settles(f);
  stays(f);
  squeezes(f);
  whirls(f);
  brakes(f);
  limits(f);
  pin(f);
  return f;
}

}  // namespace freeplay::verification
