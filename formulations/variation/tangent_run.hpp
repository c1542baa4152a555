// TangentRun: a run with tangent vectors of its motion, in the mechanism's own coordinates u
// (own_coordinates.hpp), by the event-driven scheme or by the penalty formulation. Event-driven runs
// accumulate the predicted growth of a volume beside them (predicted_growth.hpp).
//
// In penalty runs, the data that a contact retains, v₀ and its mass, and bristles follow from the motion
// before. They are carried along in the tangent vectors and do not count as coordinates.
//
// Usage:
//
//     TangentRun run(plan, family);
//     run.step(t);                               // the mode is known now
//     run.vary(run.full());                      // a basis of tangent vectors
//     while (run.t() < end && run.step(end)) {
//       const auto stretched = run.orthonormalise();
//       ...
//     }
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "formulations/variation/own_coordinates.hpp"
#include "formulations/variation/predicted_growth.hpp"
#include "formulations/variation/sensitivity.hpp"
#include "formulations/variation/traced_equations.hpp"
#include "numerics/dense.hpp"

namespace freeplay {

template <class Scheme>
class VariationalRun;
class EventScheme;
class PenaltyScheme;

class TangentRun {
 public:
  using Vector = std::vector<double>;
  /// How event-driven runs differ from others.
  struct Events {
    bool predict = true;  ///< whether predicted() is needed
    /// See Variation.
    std::function<ImpactError(int contact)> impact_error = {};
  };

  /// `run`: without keys. Scene, system and a store of traced equations must outlive this object.
  TangentRun(SensitivityRun run, Family family, Events events);
  ~TangentRun();

  /// A step of the scheme to t_end (s) or before. Returns false if the run or a tangent vector ends, with
  /// failure(). Throws Interrupted if a stop is requested.
  bool step(double t_end);
  const std::string& failure() const { return failure_; }
  double t() const;
  /// Contact onsets since the first vary().
  long onsets() const { return onset_count_; }

  /// Whether tangent vectors can begin here.
  bool may_vary() const;
  /// From now on, with these tangent vectors: displacements of (q, v, z), which are projected onto the
  /// constraints.
  void vary(const std::vector<Vector>& vectors);
  /// A basis of all own coordinates.
  std::vector<Vector> full() const { return own_.basis(directions()); }
  /// Directions of the own motions (own_coordinates.hpp), and coordinates of the vectors along directions at
  /// another state; those of full() are the unit vectors.
  Eigen::MatrixXd directions() const { return own_.motions(x(), t()); }
  Eigen::MatrixXd coordinates(const Eigen::MatrixXd& Z) {
    return own_.of(Z, columns_->columns(), layout().states);
  }
  /// Replaces the vectors by an orthonormal basis of their span, in their order (QR). Returns the
  /// logarithm of the stretching of each since it had unit length; −∞ from then on for one that has
  /// collapsed into the span of those before it.
  std::vector<double> orthonormalise();
  /// Time and cause of the collapse of each vector; empty without one.
  const std::vector<std::string>& collapsed() const { return collapsed_; }
  PredictedGrowth::Logs predicted() const;
  /// Contact onsets of an event-driven run since vary() or forget_onsets(), with the derivatives along the
  /// vectors.
  const std::vector<VariedOnset>& varied_onsets() const { return columns_->onsets(); }
  void forget_onsets() { columns_->forget_onsets(); }
  /// Evaluations for the tangent vectors over those of the run.
  double cost() const;
  /// Both together.
  long evaluations() const;

 private:
  /// Places in the integrated vector: of first-order states, and of integrals with their end.
  struct Layout {
    int states, integrals, end;
  };
  Layout layout() const;
  const Vector& x() const;
  State now() const;
  const EventDriven* events() const;
  /// Projects the columns of an event-driven run onto the constraints, with the own motions Z.
  void project(const Eigen::MatrixXd& Z);
  /// Calls f(scheme).
  template <class F>
  auto with(F f) const;

  SensitivityRun run_;
  TracedEquations equations_;
  OwnCoordinates own_;
  Events events_;
  std::variant<std::unique_ptr<VariationalRun<EventScheme>>, std::unique_ptr<VariationalRun<PenaltyScheme>>>
      motion_;
  std::optional<PredictedGrowth> growth_;
  std::string failure_;
  long onset_count_ = 0;
  DerivativeColumns* columns_ = nullptr;  // of the scheme, since vary()
  std::vector<std::string> collapsed_;
};

}  // namespace freeplay
