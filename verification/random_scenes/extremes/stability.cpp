// Stability limits of rk4. A step multiplies a mode λ by
//
//     R(z) = 1 + z + z²/2 + z³/6 + z⁴/24,   z = hλ,      and the mode stays bounded while |R| ≤ 1.
//
// Baumgarte's terms make Φ̈ + 2αΦ̇ + β²Φ = 0: λ = −α ± √(α² − β²). A contact at its deepest has the
// tangent stiffness 3/2 K √δ_max, δ_max = (5 m v²/(4K))^(2/5) (Hertz): λ = ± i ω. R leaves the unit
// disc on the imaginary axis at 2√2, on the negative real one at 2.785.
// Source: Hairer, Nørsett, Wanner, Solving ODEs II, IV.2; Baumgarte, CMAME 1 (1972) 1.
#include <complex>

#include "verification/random_scenes/extremes/extremes.hpp"
#include "verification/references/slider_crank_oracle.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::random_scenes {
namespace {

constexpr double step = 1e-3;  // s

std::string axis_at(double hb) { return fmt::format("h alpha at h beta = {:.3g}, rk4", hb); }

/// Three revolutions of the ideal rig. An Euler stage leaves a circle of radius r by ½ r (ωh)²;
/// stabilisation terms as stiff as the step feed it back in full: bounded means within twice that.
Verdict baumgarte(double ha, double hb) {
  auto scene = ideal_rig();
  scene.run.duration = 0.9;
  scene.penalty.stabilisation = Stabilisation::baumgarte;
  scene.penalty.integrator = Integrator::rk4;
  scene.penalty.step = step;
  scene.penalty.alpha = ha / step;
  scene.penalty.beta = hb / step;
  const auto run = test::simulate(scene, Family::penalty);
  const double turned = reference::from_rpm(200.0) * step;
  return within(run, run.extremes.constraint_length, 0.05 * turned * turned,
                "greatest |Φ| in three turns (m)");
}

/// The longest stable step of rk4 for the rig's first impact: approach and effective mass by the
/// oracle, frictionless.
double contact_limit() {
  auto scene = test::read_short(test::flores(), 1e-3);
  scene.penalty.contact = ContactLaw::exact;
  scene.instruments.clear();
  const double K = test::simulate(scene, Family::penalty).contacts.at(0).model.stiffness;
  reference::OracleOptions<double> options;
  options.most_impacts = 1;
  const auto first = reference::SliderCrankOracle<double>({}, options).nonsmooth(1, 0.3).impacts.at(0);
  const double v = -first.v_n_minus, mass = first.impulse_n / (first.v_n_plus - first.v_n_minus);
  const double depth = std::pow(5 * mass * v * v / (4 * K), 0.4);
  return 2 * std::numbers::sqrt2 / std::sqrt(1.5 * K * std::sqrt(depth) / mass);
}

}  // namespace

double rk4_growth(double ha, double hb) {
  using Complex = std::complex<double>;
  const Complex root = std::sqrt(Complex(ha * ha - hb * hb));
  double worst = 0;
  for (const Complex& z : {-ha + root, -ha - root})
    worst = std::max(worst, std::abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))));
  return worst;
}

std::vector<Cell> baumgarte_cells() {
  std::vector<Cell> cells;
  for (const double hb : baumgarte_grid)
    for (const double ha : baumgarte_grid)
      cells.push_back(
          {axis_at(hb), fmt::format("{:.3g}", ha), ha, "penalty", [=] { return baumgarte(ha, hb); }});
  return cells;
}

std::vector<Limit> predicted_limits() {
  std::vector<Limit> limits = {
      {"rk4 step (s)", "penalty", contact_limit(), "2√2 over the contact's frequency at its deepest"},
      {"alpha = beta, rk4 at 1e-5 s (1/s)", "penalty", 2.785e5, "hα = 2.785 at the double root −α"}};
  for (const double hb : baumgarte_grid) {
    double ha = 0;
    while (ha < 4 && rk4_growth(ha, hb) <= 1 + 1e-9) ha += 1e-3;
    if (ha > 0)
      limits.push_back({axis_at(hb), "penalty", ha, "|R(hλ)| = 1 at the greater root of Baumgarte's"});
  }
  return limits;
}

}  // namespace freeplay::verification::random_scenes
