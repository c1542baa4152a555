// TangentRun: an event-driven run with tangent vectors of its motion, in the mechanism's own
// coordinates u (own_coordinates.hpp). Without applied forces that depend on velocities or first-order
// states the motion preserves the volume of u (Liouville), since M δv and δq are conjugate. Therefore the
// growth of a volume follows without tangent vectors from
//
//     d ln|V|/dt = tr(Zᵀ ∂F/∂v Z) + tr(∂ż/∂z)                     within a mode,
//     ln|V⁺/V⁻| = ln|det(∂v⁺/∂v⁻)| + Σ ln|ġ⁺/ġ⁻|                  at an impact,
//
// the sum over the contacts in impact, and ln|ü⁺/ü⁻| where the sliding u of a joint with friction is
// reversed. For a frictionless impact of one contact the second line is 2 ln e. TangentRun accumulates
// these logarithms beside the tangent vectors (Predicted). They do not exist while contacts last, where
// the motion has fewer coordinates.
//
// Usage:
//
//     TangentRun run(plan);
//     run.step(t);                                // the mode is known now
//     run.vary(run.full());                       // a basis of tangent vectors
//     while (run.t() < end && run.step(end)) {
//       const auto stretched = run.orthonormalise();
//       ...
//     }
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formulations/event_driven/event_driven.hpp"
#include "formulations/penalty/penalty_variation.hpp"
#include "formulations/variation/own_coordinates.hpp"
#include "numerics/dense.hpp"
#include "simulation/contact_log.hpp"
#include "values/state.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

class TangentRun {
 public:
  struct Plan {
    const Scene& scene;
    const System& system;
    State start;
    double end = 0;  ///< s
    /// of each contact; empty: those of the surfaces
    std::vector<double> restitution = {};
    StopToken stop = {};
    bool predict = true;  ///< whether predicted() is needed
  };
  using Vector = std::vector<double>;
  /// Logarithms of the growth of a volume of all own coordinates.
  struct Predicted {
    double flow = 0, impacts = 0;
    std::string unknown;  ///< why they do not exist; empty if they do
  };

  explicit TangentRun(const Plan& plan);

  /// A step of the scheme to t_end (s) or before. Returns false if the run or a tangent vector ends, with
  /// failure(). Throws Interrupted if a stop is requested.
  bool step(double t_end);
  const std::string& failure() const { return failure_; }
  double t() const { return scheme_.t(); }
  const Vector& x() const { return scheme_.x(); }
  /// Contact onsets so far.
  long onsets() const { return onset_count_; }
  const System& system() const { return system_; }

  /// Whether tangent vectors can begin here.
  bool may_vary() const { return true; }
  /// From now on, with these tangent vectors: displacements of (q, v, z), which are projected onto the
  /// constraints.
  void vary(const std::vector<Vector>& vectors);
  /// A basis of all own coordinates.
  std::vector<Vector> full() const;
  /// Directions of the own motions (own_coordinates.hpp), and coordinates of the vectors along directions at
  /// another state; those of full() are the unit vectors.
  Eigen::MatrixXd directions() const { return own_.motions(scheme_.x(), scheme_.t()); }
  Eigen::MatrixXd coordinates(const Eigen::MatrixXd& Z) {
    return own_.of(Z, scheme_.variation().columns(), scheme_.dynamics().state_offset());
  }
  /// Replaces the vectors by an orthonormal basis of their span, in their order (QR). Returns the
  /// logarithm of the stretching of each since it had unit length; −∞ from then on for one that has
  /// collapsed into the span of those before it.
  std::vector<double> orthonormalise();
  /// Time and cause of the collapse of each vector; empty without one.
  const std::vector<std::string>& collapsed() const { return collapsed_; }
  const Predicted& predicted() const { return predicted_; }
  /// Contact onsets since vary() or forget_onsets(), with the derivatives along the vectors.
  const std::vector<VariedOnset>& varied_onsets() { return scheme_.variation().onsets(); }
  void forget_onsets() { scheme_.variation().forget_onsets(); }
  /// Evaluations for the tangent vectors over those of the run.
  double cost() const;
  /// Both together.
  long evaluations() const { return scheme_.work().rhs + (varied_ ? scheme_.variation().evaluations() : 0); }

  /// From now on, after vary(); see Variation::impact_error.
  void respond_to(std::function<Variation::ImpactError(int contact)> error) {
    scheme_.variation().impact_error = std::move(error);
  }

 private:
  Eigen::VectorXd own(const Eigen::MatrixXd& Z, const Vector& column) const {
    return own_.of(Z, column, scheme_.dynamics().state_offset());
  }
  void remove_drift(const Eigen::MatrixXd& Z);
  void predict_event(const EventDynamics& d, const Variation::Passed& p);
  void predict_impact(const EventDynamics& d, const Variation::Passed& p, const std::vector<int>& onsets);
  double divergence(const Vector& x, double t);
  bool reduced(const EventDynamics& d) const;
  void leave_unknown(const std::string& reason) {
    if (predicted_.unknown.empty()) predicted_.unknown = reason;
  }

  const Scene& scene_;
  const System& system_;
  StopToken stop_;
  double end_;
  std::vector<double> restitution_;
  EventDriven scheme_;
  ContactLog log_;
  std::unique_ptr<EventDynamics> probe_;  // in the mode of the last step
  OwnCoordinates own_;
  bool predict_, varied_ = false, dissipative_ = false;
  long onset_count_ = 0;
  std::vector<std::string> collapsed_;
  Predicted predicted_;
  std::string failure_;
};

/// PenaltyTangentRun: a penalty run with tangent vectors of its motion (penalty_variation.hpp), in the
/// mechanism's own coordinates (own_coordinates.hpp). Its members are those of TangentRun, so that Lyapunov
/// exponents are computed in the same way for both formulations.
///
/// The data that a contact retains, v₀ and its mass, and bristles follow from the motion before. They are
/// carried along in the tangent vectors and do not count as coordinates.
class PenaltyTangentRun {
 public:
  using Vector = std::vector<double>;

  /// Of the plan, `restitution` and `predict` have no meaning.
  explicit PenaltyTangentRun(const TangentRun::Plan& plan);

  bool step(double t_end);
  const std::string& failure() const { return failure_; }
  double t() const { return parts_.steps->t(); }
  long onsets() const { return onset_count_; }
  /// Whether tangent vectors can begin here: no contact is closed.
  bool may_vary() const;
  void vary(const std::vector<Vector>& vectors);
  std::vector<Vector> full() const;
  Eigen::MatrixXd directions() const { return own_.motions(parts_.steps->x(), parts_.steps->t()); }
  Eigen::MatrixXd coordinates(const Eigen::MatrixXd& Z) {
    return own_.of(Z, variation_->columns(), parts_.steps->dynamics().state_offset());
  }
  std::vector<double> orthonormalise();
  const std::vector<std::string>& collapsed() const { return collapsed_; }
  /// Always unknown.
  const TangentRun::Predicted& predicted() const { return predicted_; }
  void forget_onsets() {}
  double cost() const;

 private:
  const Scene& scene_;
  const System& system_;
  StopToken stop_;
  double end_;
  PenaltyParts parts_;
  OwnCoordinates own_;
  std::unique_ptr<PenaltyVariation> variation_;
  long onset_count_ = 0;
  std::vector<std::string> collapsed_;
  TangentRun::Predicted predicted_;
  std::string failure_;
};

}  // namespace freeplay
