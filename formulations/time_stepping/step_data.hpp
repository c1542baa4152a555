// StepData: data of one step that the parts of time stepping read and write: the motion at its
// beginning, middle and end, the mechanism evaluated there, and the totals of the run. Plain data;
// MoreauStepper owns it and passes it to the parts.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dynamics/system.hpp"
#include "formulations/time_stepping/step_diagnostics.hpp"
#include "numerics/saddle_point.hpp"
#include "simulation/contact_log.hpp"
#include "values/ledger.hpp"

namespace freeplay {

// StepKernel: calls the compiled functions of a step (dynamics/system_functions.hpp). They take the
// place of the general path for fixed steps of mechanisms that have them, and give its digits. Each
// call returns false if there are none, or if a comparison has another result than at the sample;
// the general path then does that part of the step.

class ContactSet;
struct StepData;

class StepKernel {
 public:
  /// Evaluates the middle of the step, factorises there, and computes v and λ without contacts.
  bool middle(StepData& step, ContactSet& contacts);
  /// Computes v and λ without contacts again, with the forces at a mean velocity.
  bool again(StepData& step, const ContactSet& contacts, const double* v_mean);
  /// Rates of a contact's rows at v without contacts and at v₀, after middle().
  struct Rates {
    double normal, tangent, normal_old, tangent_old;
  };
  const Rates& rates(int contact) const { return rates_[static_cast<std::size_t>(contact)]; }
  /// Responses and reactions to both rows of a contact, and its entries of D.
  struct Response {
    const double *normal, *tangent;  ///< entries of the rows
    double *a_n, *lambda_n, *a_t, *lambda_t;
  };
  /// D_NN, D_TN, D_TT; null: the general path.
  const double* respond(const StepData& step, int contact, const Response& at);
  /// Adds the impulses of the only active contact to v, λ and force, with its present responses.
  void push(StepData& step, int contact, const double* impulses, const Response& at);
  /// Rates of that contact's rows at v and at the mean velocity; null for others.
  struct Pushed {
    double normal, tangent, normal_mean, tangent_mean;
  };
  const Pushed* pushed(int contact) const { return contact == pushed_ ? &pushed_rates_ : nullptr; }
  /// Computes q, corrected onto Φ = 0, all multipliers, gaps and works, from v with all impulses. q
  /// before the correction is in step.dq.
  bool end(StepData& step);
  /// Evaluates the constraints and gaps at another q.
  bool reached(StepData& step);

  /// The sum of all q and v after end(), to see whether they are finite.
  double sum() const { return sum_; }
  /// The greatest |Φ| in m and in rad after end() or reached().
  const std::array<double, 2>& residuals() const { return residuals_; }

 private:
  void prepare(StepData& step, ContactSet& contacts);

  // arguments of the compiled functions that stay from step to step, and of which data they are
  std::vector<double*> middle_out_, end_out_, reached_out_;
  std::vector<const double*> end_in_;
  const StepData* step_ = nullptr;
  const void *contacts_ = nullptr, *functions_ = nullptr;
  std::vector<Rates> rates_;
  Pushed pushed_rates_{};
  int pushed_ = -1;
  std::array<double, 2> residuals_{};
  std::array<double, 3> D_{};
  double sum_ = 0, h_ = 0;
};

/// Which contacts may act in a step: all contacts whose gaps it would close, by the impact law; or
/// only contacts marked as closed, without restitution, so that the step is smooth.
enum class StepReach { all, closed };

/// The ends of a step.
struct StepEnds {
  const double *q_old, *q, *v_old, *v;
};
/// The state at a time t within the step from t_old to t_new, of n coordinates.
inline void interpolate_step(double t_old, double t_new, double t, const StepEnds& d, int n, double* q,
                             double* v) {
  const double s = t_new > t_old ? (t - t_old) / (t_new - t_old) : 1;
  for (int i = 0; i < n; ++i) {
    q[i] = d.q_old[i] + s * (d.q[i] - d.q_old[i]);
    v[i] = d.v_old[i] + s * (d.v[i] - d.v_old[i]);
  }
}

/// Totals over the steps of a run.
struct RunTotals {
  EnergyLedger integrals;
  Extremes extremes;
  Work work;
  StepDiagnostics found;
};

struct StepData {
  StepData(const System& system, RowFacts facts);

  double length() const { return t - t_old; }
  bool smooth() const { return reach == StepReach::closed; }
  bool fail(std::string why) {
    failure = std::move(why);
    return false;
  }

  const System& system;
  SaddlePoint saddle;           // factorised at q_mid; by EndRates at q
  Evaluation middle, end;       // evaluated at (q_mid, t_old + h/2) and at (q, t)
  std::vector<double> q, v, z;  // at the end; z: first-order states of elements
  // at the beginning; z_old if rates of z depend on velocities
  std::vector<double> q_old, v_old, z_old;
  std::vector<double> q_mid, v_mean, z_mid;  // at the middle
  // N s, of the constraint rows; N after the step (divided by its length)
  std::vector<double> lambda;
  std::vector<double> force;        // N s, M v + h f
  std::vector<double> r;            // right-hand sides of constraint rows
  std::vector<double> dq, dlambda;  // work space: a displacement and its multipliers
  double t = 0, t_old = 0;          // s
  StepReach reach = StepReach::all;
  StepKernel kernel;
  bool whole = false;  // the kernel has evaluated the middle of this step, and will do its end
  bool free = false;   // in such a step: v is without impulses of contacts
  ContactLog* log = nullptr;
  RunTotals totals;
  std::string failure;  // reason of the last failed step
};

}  // namespace freeplay
