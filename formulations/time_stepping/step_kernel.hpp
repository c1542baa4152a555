// StepKernel: calls the compiled functions of a step (dynamics/system_functions.hpp). They take the
// place of the general path for fixed steps of mechanisms that have them, and give its digits. Each
// call returns false if there are none, or if a comparison has another result than at the sample;
// the general path then does that part of the step.
#pragma once

#include <array>
#include <vector>

namespace freeplay {

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

}  // namespace freeplay
