// SlidingFriction: friction of contacts in a time step with a coefficient that falls from a static value
// with the sliding speed (mechanism/static_friction.hpp),
//
//     −P_T ∈ μ(|ū_T|) P_N Sgn(u_T⁺),     ū_T = ½ (u_T⁻ + u_T⁺).
//
// The mean of the rates at both ends keeps the error of a step of third order; the rate at its beginning
// would make it of second order. Coefficients and impulses are iterated from the coefficients at the
// beginning until they agree (contact/coupled_friction.hpp), as far as the residual of the rates allows. A
// contact that rests through the step has the coefficient at rest. In a step over an impact the
// coefficients stay those at u_T⁻, as in the event-driven scheme (step_problem.cpp).
//
// Usage: clear(), add() the contacts of a problem, then solve(). Nothing is kept between steps but
// room, which is new where the number of contacts changes.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <vector>

#include "formulations/contact/contact_problem.hpp"
#include "formulations/contact/coupled_friction.hpp"
#include "mechanism/surface.hpp"

namespace freeplay {

class SlidingFriction {
 public:
  struct Contact {
    int unknown;             ///< index in the contact problem
    const Surface* surface;  ///< with friction by speed
    double before;  ///< m/s, W_T v⁻ + W_T v⁺ − u_T⁺, to which the rate of the problem is added
  };
  void clear() { contacts_.clear(); }
  void add(const Contact& contact) { contacts_.push_back(contact); }
  bool any() const { return !contacts_.empty(); }

  /// Solves by `solve`, which returns a ContactSolution of the problem with the present coefficients of
  /// `unknowns`; `rate(row)` returns the rate of a row with its impulses. Returns the last solution; met()
  /// says whether the coefficients agree with it.
  template <class Solve, class Rate>
  ContactSolution solve(std::vector<ContactUnknown>& unknowns, Solve solve, Rate rate);
  bool met() const { return met_; }
  /// Greatest difference of a coefficient and that of its speed, over the greatest coefficient.
  double residual() const { return iteration_.residual(); }

 private:
  std::vector<Contact> contacts_;
  BoundIteration iteration_;
  Eigen::VectorXd image_;
  bool met_ = true;
};

template <class Solve, class Rate>
ContactSolution SlidingFriction::solve(std::vector<ContactUnknown>& unknowns, Solve solve, Rate rate) {
  const auto count = static_cast<Eigen::Index>(contacts_.size());
  image_.resize(count);
  double steepest = 0;  // of μ (s/m)
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& c = contacts_[static_cast<std::size_t>(i)];
    const auto curve = c.surface->peak.curve(*c.surface->friction);
    steepest = std::max(steepest, curve.more * curve.exponent / curve.stribeck);
    image_[i] = unknowns[static_cast<std::size_t>(c.unknown)].friction;
  }
  met_ = true;
  iteration_.start(image_);
  for (;;) {
    for (Eigen::Index i = 0; i < count; ++i)
      unknowns[static_cast<std::size_t>(contacts_[static_cast<std::size_t>(i)].unknown)].friction =
          iteration_.bounds()[i];
    const ContactSolution result = solve();
    if (!result.solved) return result;
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto& c = contacts_[static_cast<std::size_t>(i)];
      const auto& u = unknowns[static_cast<std::size_t>(c.unknown)];
      image_[i] = c.surface->friction_at(0.5 * (c.before + rate(u.tangent)));
    }
    const double apart = (image_ - iteration_.bounds()).cwiseAbs().maxCoeff();
    if (apart <= steepest * result.residual_rate) return result;
    if (!iteration_.refine(image_)) {
      met_ = iteration_.met();
      return result;
    }
  }
}

}  // namespace freeplay
