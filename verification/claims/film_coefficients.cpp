// Films in steady running: Sommerfeld number, attitude angle, power loss, stiffness, damping and
// critical mass against closed forms and a published example; small whirl of a journal by every
// scheme against the linear coefficients; film statistics of runs.
#include "formulations/contact/steady_film.hpp"
#include "simulation/film_statistics.hpp"
#include "verification/claims/claim.hpp"
#include "verification/claims/journal_scene.hpp"
#include "verification/references/journal_bearing.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

using journal_scene::c;
using journal_scene::film_ways;
using journal_scene::journal;
using journal_scene::L;
using journal_scene::name_of;
using journal_scene::R;
using reference::JournalBearing;
using reference::JournalCoefficients;

Film law_of(const JournalBearing& b) {
  return {b.is_short ? Film::Kind::short_bearing : Film::Kind::long_bearing,
          b.cavitated,
          b.viscosity,
          b.length,
          b.radius,
          b.clearance,
          0.001 * b.clearance};
}

/// Greatest deviation of the entries of a matrix over its greatest entry.
double deviation(const SteadyFilm::Matrix& found, const reference::Matrix2& expected) {
  double apart = 0, size = 0;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      apart = greatest(apart, std::abs(found[i][j] - expected[i][j]));
      size = std::max(size, std::abs(expected[i][j]));
    }
  return apart / size;
}

/// S over ε in closed form.
double sommerfeld_of(const JournalBearing& b, double e) {
  const double pi = std::numbers::pi, s2 = 1 - e * e, slender = 2 * b.radius / b.length;
  if (b.is_short)
    return slender * slender * s2 * s2 /
           (pi * e * (b.cavitated ? std::sqrt(pi * pi * s2 + 16 * e * e) : 2 * pi * std::sqrt(s2)));
  return (2 + e * e) * (b.cavitated ? s2 / (6 * pi * e * std::sqrt(pi * pi * s2 + 4 * e * e))
                                    : std::sqrt(s2) / (12 * pi * pi * e));
}

/// Equilibrium and coefficients at given eccentricity ratios.
void runs_steadily(Findings& f) {
  constexpr double omega = 100;
  for (const bool is_short : {true, false})
    for (const bool cavitated : {true, false}) {
      const JournalBearing b{is_short, cavitated, 0.03, R, L, c};
      const auto law = law_of(b);
      for (const double e : {0.1, 0.5, 0.9}) {
        const auto s = steady_film(law, e, omega);
        const auto expected = reference::journal_coefficients(b, e, omega);
        const auto subject = fmt::format("{}, ε = {}", name_of(b), e);
        f.relative(claim_name(subject, "Sommerfeld number"), "", s.sommerfeld, sommerfeld_of(b, e), 1e-12,
                   is_short ? "Ocvirk: S (L/D)² over ε" : "Sommerfeld: S over ε",
                   "rounding of closed forms, some hundred operations");
        f.within(claim_name(subject, "attitude angle"), "rad", s.attitude,
                 cavitated ? std::atan(std::numbers::pi * std::sqrt(1 - e * e) / ((is_short ? 4 : 2) * e))
                           : std::numbers::pi / 2,
                 1e-12,
                 !cavitated ? "90°"
                 : is_short ? "tan φ = π√(1 − ε²)/(4ε)"
                            : "tan φ = π√(1 − ε²)/(2ε)",
                 "rounding");
        f.relative(claim_name(subject, "eccentricity ratio for the load of ε"), "",
                   steady_ratio(law, b.capacity(e, omega), omega).value_or(NAN), e, 1e-12,
                   "closed form of the load", "rounding");
        f.at_most(claim_name(subject, "error of the stiffness over its greatest coefficient"), "",
                  deviation(s.stiffness, expected.stiffness), 1e-11,
                  "derivatives of the load's closed form, by hand",
                  "rounding: the primitives of the long film lose 1/ε² = 100 of 2e-16 at ε = 0.1");
        f.at_most(claim_name(subject, "error of the damping over its greatest coefficient"), "",
                  deviation(s.damping, expected.damping), 1e-11,
                  "integrals of the pressure by squeeze and rotation, by hand", "as of the stiffness");
      }
    }
  for (const double e : {0.1, 0.5, 0.9}) {
    const JournalBearing b{true, true, 0.03, R, L, c};
    const auto s = steady_film(law_of(b), e, omega);
    const auto expected = reference::short_textbook(e);
    const auto subject = fmt::format("{}, ε = {}", name_of(b), e);
    const char* const source = "Friswell, Penny, Garvey and Lees (2010), p. 177: functions of ε";
    f.at_most(claim_name(subject, "error of K c/W over its greatest coefficient, textbook"), "",
              deviation(s.scaled_stiffness(c), expected.stiffness), 1e-11, source, "rounding");
    f.at_most(claim_name(subject, "error of C cω/W over its greatest coefficient, textbook"), "",
              deviation(s.scaled_damping(c), expected.damping), 1e-11, source, "rounding");
  }
  const JournalBearing full{false, false, 0.03, R, L, c};
  const double e = 0.5;
  f.relative("long full film, ε = 0.5: power loss", "W", steady_film(law_of(full), e, omega).loss,
             4 * std::numbers::pi * full.viscosity * omega * omega * R * R * R * L / c * (1 + 2 * e * e) /
                 ((2 + e * e) * std::sqrt(1 - e * e)),
             1e-12, "Sommerfeld: friction torque 4π μωLR³ (1 + 2ε²)/(c (2 + ε²) √(1 − ε²))", "rounding");
}

/// The example of a textbook, as another program prints it.
void agrees_with_published_example(Findings& f) {
  const Film law{Film::Kind::short_bearing, true, 0.1, 30e-3, 50e-3, 0.1e-3, 1e-6};
  const double omega = 50 * std::numbers::pi;
  const auto s = steady_film(law, steady_ratio(law, 525, omega).value_or(NAN), omega);
  const char* const subject = "short bearing of Friswell et al., 525 N at 1500 rpm";
  const char* const source =
      "Friswell, Penny, Garvey and Lees (2010), p. 177, digits by ROSS (JOSS 5 (2020) 2120), "
      "CylindricalBearing";
  const auto digits = "digits of the published value";
  f.within(claim_name(subject, "eccentricity ratio"), "", s.ratio, 0.266298, 1e-6, source, digits);
  // The book's axes (u, v): load along −v. In ours x = −v and y = u.
  const struct {
    const char* name;
    double found, expected;
  } values[] = {{"K_xx", s.stiffness[0][0], 8.815303e6},   {"K_xy", s.stiffness[0][1], 25.060393e6},
                {"K_yx", s.stiffness[1][0], -16.393593e6}, {"K_yy", s.stiffness[1][1], 12.80796e6},
                {"C_xx", s.damping[0][0], 294.911619e3},   {"C_xy", s.damping[0][1], 81.924371e3},
                {"C_yx", s.damping[1][0], 81.924371e3},    {"C_yy", s.damping[1][1], 232.89693e3}};
  for (const auto& v : values)
    f.relative(claim_name(subject, v.name), v.name[0] == 'K' ? "N/m" : "N s/m", v.found, v.expected, 1e-6,
               source, digits);
}

/// Instability of a rigid rotor in cavitated short bearings.
void has_critical_mass(Findings& f) {
  const JournalBearing b{true, true, 0.03, R, L, c};
  const auto law = law_of(b);
  const char* const subject = "rigid rotor in short half-Sommerfeld films";
  const auto scaled_mass = [&](const SteadyFilm& s) {
    return s.critical_mass.value_or(INFINITY) * c * s.speed * s.speed / s.load;
  };
  const auto centred = steady_film(law, 1e-3, 100);
  f.relative(claim_name(subject, "critical mass times cω²/W at ε = 0.001"), "", scaled_mass(centred),
             24 / std::numbers::pi, 1e-5, "limit ε → 0 of the textbook's functions: 24/π",
             "next order of the expansion: a few ε²");
  f.within(claim_name(subject, "whirl frequency over speed at ε = 0.001"), "", centred.whirl_ratio, 0.5, 1e-5,
           "half-speed whirl", "next order of the expansion: a few ε²");
  for (const double e : {0.3, 0.5, 0.7}) {
    const auto expected = reference::whirl_threshold(reference::short_textbook(e));
    f.relative(claim_name(subject, fmt::format("critical mass times cω²/W at ε = {}", e)), "",
               scaled_mass(steady_film(law, e, 100)), expected.mass, 1e-10,
               "Routh–Hurwitz with the textbook's functions", "rounding, times the slope d ln m/dε < 100");
  }
  // ε beyond which any mass is stable, by bisection.
  const auto bisect = [](auto unstable) {
    double low = 0.5, high = 0.9;
    for (int i = 0; i < 60; ++i) (unstable(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    return 0.5 * (low + high);
  };
  f.within(claim_name(subject, "ε beyond which any mass is stable"), "",
           bisect([&](double e) { return steady_film(law, e, 100).critical_mass.has_value(); }),
           bisect([](double e) {
             return reference::whirl_threshold(reference::short_textbook(e)).ratio_squared > 0;
           }),
           1e-9, "the textbook's functions: (ν/ω)² = 0, known as ε ≈ 0.76",
           "rounding, as (ν/ω)² has a simple root there");
  for (const bool is_short : {true, false}) {
    const JournalBearing full{is_short, false, 0.03, R, L, c};
    f.within(claim_name(fmt::format("rigid rotor in {}s", name_of(full)), "critical mass at ε = 0.5"), "kg",
             steady_film(law_of(full), 0.5, 100).critical_mass.value_or(INFINITY), 0, 0,
             "the full film has no direct stiffness: unstable at any mass", "exact");
  }
}

/// Small whirl about the equilibrium: half the difference of two runs with opposite displacements
/// follows the linear equations up to third order.
void whirls_as_linearised(Findings& f) {
  const double omega = 100, e = 0.5, T = 0.2, start = 3e-4 * c;
  for (const bool is_short : {true, false}) {
    const JournalBearing b{is_short, true, is_short ? 0.03 : 0.003, R, L, c};
    const double W = b.capacity(e, omega), phi = b.attitude(e, omega);
    const auto linear = reference::journal_coefficients(b, e, omega);
    JournalCoefficients scaled = linear;
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) {
        scaled.stiffness[i][j] *= c / W;
        scaled.damping[i][j] *= c * omega / W;
      }
    const double critical = reference::whirl_threshold(scaled).mass * W / (c * omega * omega);
    for (const double share : {0.7, 1.4}) {
      const double mass = share * critical;
      const auto exact = reference::small_whirl(linear, mass, {start, 0}, T);
      const double growth = std::hypot(exact[0], exact[1]) / start;
      for (const auto& way : film_ways) {
        std::array<double, 2> x{};
        for (const double sign : {1.0, -1.0}) {
          // The load acts along −y of the world, and the journal turns counterclockwise.
          auto scene = journal(b, mass, 1e9, omega, W / mass, T,
                               {e * c * std::sin(phi), -e * c * std::cos(phi) - sign * start});
          scene.nonsmooth.step_tolerance = 1e-11;
          scene.penalty.tolerance = scene.nonsmooth.tolerance = 1e-12;
          const auto s = test::finished(way, scene).final_state;
          x[0] -= 0.5 * sign * s.q[1];
          x[1] += 0.5 * sign * s.q[0];
        }
        const auto subject = fmt::format("{}, small whirl at {} of the critical mass", name_of(b), share);
        f.at_most(
            claim_name(subject, "position error over displacement after 0.2 s", way.name), "",
            std::hypot(x[0] - exact[0], x[1] - exact[1]) / start, 1e-4,
            fmt::format("linear coefficients by hand; the displacement changes by a factor of {:.4f}",
                        growth),
            "third order in the displacement: (3e-4/(1 − ε))² times some ten; fixed steps: (ωh)²/12 ωt");
      }
    }
  }
}

/// Film statistics of a steady run, for both directions of rotation, and of the gudgeon pin.
void has_statistics(Findings& f) {
  for (const double omega : {100.0, -100.0}) {
    const JournalBearing b{true, true, 0.03, R, L, c};
    const double e = 0.8, W = b.capacity(e, 100), phi = b.attitude(e, 100), mass = 2;
    for (const auto& way : film_ways) {
      auto scene = journal(b, mass, 1e9, omega, W / mass, 0.05,
                           {std::copysign(e * c * std::sin(phi), omega), -e * c * std::cos(phi)});
      way.choose(scene);
      Simulation simulation(scene, way.penalty() ? "penalty" : "nonsmooth");
      FilmStatistics statistics(film_probe(scene), 0.01);
      auto run = test::finished(simulation, {&statistics});
      statistics.into(run);
      const auto film = run.contacts.front().film.value_or(FilmSummary{});
      const auto subject =
          fmt::format("short half-Sommerfeld film, run at ε = 0.8, {} rad/s", static_cast<int>(omega));
      const char* const reason =
          "it stays at its stable equilibrium within the tolerance, 1e-6 of the clearance, "
          "times d ln W/dε < 10";
      const auto value = [&](const char* name, const char* unit, double found, double expected,
                             const char* source) {
        f.relative(claim_name(subject, name, way.name), unit, found, expected, 1e-5, source, reason);
      };
      value("mean eccentricity ratio", "", film.mean_ratio, e, "start at equilibrium");
      value("least film thickness", "m", film.least_thickness, c * (1 - e), "c (1 − ε)");
      value("mean load", "N", film.mean_load, W, "weight");
      value("attitude angle", "rad", film.attitude, phi, "tan φ = π√(1 − ε²)/(4ε)");
      value("Sommerfeld number", "", film.sommerfeld, sommerfeld_of(b, e), "Ocvirk: S (L/D)² over ε");
      value("mean power loss", "W", film.mean_loss,
            b.petroff() * omega * omega / std::sqrt(1 - e * e) + 0.5 * W * std::sin(phi) * e * c * 100,
            "2π μω²R³L/(c√(1 − ε²)) + ½ω W_t εc");
    }
  }
  const auto scene = read_scene(test::source_folder() / "cases/lubricated-pin/scene.toml",
                                {"run.revolutions=1", "run.discard=0"});
  for (const auto& way : film_ways) {
    auto chosen = scene;
    way.choose(chosen);
    Simulation simulation(chosen, way.penalty() ? "penalty" : "nonsmooth");
    FilmStatistics statistics(film_probe(chosen), 0);
    auto run = test::finished(simulation, {&statistics});
    statistics.into(run);
    const double expected = run.ledger.film / run.t_end,
                 found = run.contacts.front().film.value_or(FilmSummary{}).mean_loss;
    f.at_most(claim_name("slider-crank with lubricated gudgeon pin",
                         "relative error of the film statistics' mean power loss, one turn", way.name),
              "", std::abs(found - expected) / expected, 1e-3, "energy ledger: absorbed work over the time",
              "Gauss's rule on the dense output; fixed steps of 1e-5 s have its velocities to 1e-3 at a "
              "reversal");
  }
}

}  // namespace

void film_coefficients(Findings& f) {
  runs_steadily(f);
  agrees_with_published_example(f);
  has_critical_mass(f);
  whirls_as_linearised(f);
  has_statistics(f);
}

}  // namespace freeplay::verification
