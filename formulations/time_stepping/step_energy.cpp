#include "formulations/time_stepping/step_energy.hpp"

#include <algorithm>

namespace freeplay {
namespace {

/// Works of constraint rows: the drives' work, and the work of constraint errors.
void account_rows(StepData& s) {
  const int first_driven = s.system.rows() - (s.system.has_motions() ? s.system.drive_rows() : 0);
  // If velocities satisfy the rates at both ends (EndRates), the work of all rows on their mean is
  // that of the drives. Ideal joints do no work, and the rotation of their rows within the step is
  // an error of the step that would accumulate from turn to turn.
  const bool met = s.smooth() && s.system.drive_rows() > 0;
  const auto& G = s.system.pattern();
  const int* column = G.column.data();
  const double *value = s.middle.G.data(), *mean = s.v_mean.data();
  auto& integrals = s.totals.integrals;
  double drive = integrals.drive, stabilisation = integrals.stabilisation;
  for (int k = 0, e = 0; k < G.rows; ++k) {
    const double impulse = s.lambda[k], driven = s.middle.phi_t[k];
    drive += impulse * driven;
    double rate = 0;
    for (const int end = G.begin[k + 1]; e < end; ++e) rate += value[e] * mean[column[e]];
    const double work = impulse * (rate + driven);
    // A row driven by a curve has its own rates at both ends of the step. It is driven at their
    // mean, not at the mean of the curve.
    if (met || (k >= first_driven && driven != 0))
      drive -= work;
    else
      stabilisation -= work;
  }
  integrals.drive = drive;
  integrals.stabilisation = stabilisation;
}

/// Losses of contacts and friction; returns their total energy gain.
double account_contacts(StepData& s, const StepProblem& problem, const ImpulseResponses& responses,
                        const StepKernel::Pushed* pushed) {
  auto& integrals = s.totals.integrals;
  double gain = 0;
  for (const auto& c : problem.problem.unknowns) {
    const auto mean_rate = [&](int row) {
      if (pushed) return row == c.normal ? pushed->normal_mean : pushed->tangent_mean;
      return responses.row(problem.place(row)).dot(s.v_mean.data());
    };
    double work = 0;
    if (c.normal >= 0) {
      const double normal = c.impulse_n * mean_rate(c.normal);
      integrals.contact -= normal;
      work += normal;
    }
    if (c.tangent >= 0) {
      const double tangential = c.impulse_t * mean_rate(c.tangent);
      integrals.friction -= tangential;
      work += tangential;
    }
    gain += work;
  }
  return gain;
}

}  // namespace

void account_step(StepData& s, const ContactSet& contacts, const StepProblem& problem,
                  const ImpulseResponses& responses, const FilmStep& films, bool in_impact, bool fixed) {
  const double h = s.length();
  auto& integrals = s.totals.integrals;
  if (!s.whole) {
    for (int i = 0; i < s.system.n(); ++i) s.v_mean[i] = 0.5 * (s.v_old[i] + s.v[i]);
    account_rows(s);
  }
  if (films.any()) integrals.film += films.loss(s.v_old.data(), s.v.data());
  double approach = 0;  // Σ P_N |u_N⁻|
  const StepKernel::Pushed* pushed = nullptr;
  for (const int k : contacts.live())
    if (const auto* u = problem.unknown_of(contacts[k])) {
      approach += u->impulse_n * std::max(0.0, -contacts[k].u_n_minus);
      if (s.whole) pushed = s.kernel.pushed(k);
    }
  const double gain = account_contacts(s, problem, responses, pushed);
  // Lasting contacts may add a gain of h² times forces per step; a greater gain is from an impact
  // that raised the energy. Adaptive steps over impacts are the shortest steps.
  if (in_impact)
    s.totals.extremes.count_gain(gain > (fixed ? 1e-3 : 1e-5) * approach ? gain : 0,
                                 s.system.kinetic(s.v_old.data()), 1e-9);
  if (!s.system.has_loads()) return;
  const Sweep sweep{h, s.v_old.data(), s.v_mean.data()};
  s.system.forces(s.t_old + 0.5 * h, s.q_mid.data(), s.v_mean.data(), s.z_mid.data(), s.middle, {&sweep});
  integrals.drive += h * s.middle.power.drive;
  integrals.load += h * s.middle.power.load;
  integrals.damping -= h * s.middle.power.damping;
}

}  // namespace freeplay
