// PenaltyTangentRun: a penalty run with tangent vectors of its motion (penalty_variation.hpp), in the
// mechanism's own coordinates (own_coordinates.hpp). Its members are those of TangentRun, so that Lyapunov
// exponents are computed in the same way for both formulations.
//
// The data that a contact retains, v₀ and its mass, and bristles follow from the motion before. They are
// carried along in the tangent vectors and do not count as coordinates.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "formulations/own_coordinates.hpp"
#include "formulations/penalty/penalty_variation.hpp"
#include "formulations/tangent_run.hpp"

namespace freeplay {

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
