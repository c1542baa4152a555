// TangentRun: a run with tangent vectors of its motion, in the mechanism's own coordinates u
// (own_coordinates.hpp), by the event-driven scheme or by the penalty formulation.
//
// Without applied forces that depend on velocities or first-order states an event-driven motion preserves the
// volume of u (Liouville), since M δv and δq are conjugate. Therefore the growth of a volume follows without
// tangent vectors from
//
//     d ln|V|/dt = tr(Zᵀ ∂F/∂v Z) + tr(∂ż/∂z)                     within a mode,
//     ln|V⁺/V⁻| = ln|det(∂v⁺/∂v⁻)| + Σ ln|ġ⁺/ġ⁻|                  at an impact,
//
// the sum over the contacts in impact, and ln|ü⁺/ü⁻| where the sliding u of a joint with friction is
// reversed. For a frictionless impact of one contact the second line is 2 ln e. Event-driven runs
// accumulate these logarithms beside the tangent vectors (Predicted). They do not exist while contacts last,
// where the motion has fewer coordinates.
//
// In penalty runs, the data that a contact retains, v₀ and its mass, and bristles follow from the motion
// before. They are carried along in the tangent vectors and do not count as coordinates.
//
// Usage:
//
//     const auto run = make_tangent_run(plan, family);
//     run->step(t);                               // the mode is known now
//     run->vary(run->full());                     // a basis of tangent vectors
//     while (run->t() < end && run->step(end)) {
//       const auto stretched = run->orthonormalise();
//       ...
//     }
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "formulations/event_driven/variation.hpp"
#include "formulations/variation/own_coordinates.hpp"
#include "numerics/dense.hpp"
#include "values/state.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;
enum class Family;

class TangentRun {
 public:
  struct Plan {
    const Scene& scene;
    const System& system;
    State start;
    double end = 0;  ///< s
    /// of each contact; empty: those of the surfaces. Not of penalty runs
    std::vector<double> restitution = {};
    StopToken stop = {};
    bool predict = true;  ///< whether predicted() is needed
    /// See Variation. Not of penalty runs
    std::function<Variation::ImpactError(int contact)> impact_error = {};
  };
  using Vector = std::vector<double>;
  /// Logarithms of the growth of a volume of all own coordinates.
  struct Predicted {
    double flow = 0, impacts = 0;
    std::string unknown;  ///< why they do not exist; empty if they do
  };

  virtual ~TangentRun() = default;

  /// A step of the scheme to t_end (s) or before. Returns false if the run or a tangent vector ends, with
  /// failure(). Throws Interrupted if a stop is requested.
  virtual bool step(double t_end);
  const std::string& failure() const { return failure_; }
  virtual double t() const = 0;
  /// Contact onsets so far.
  long onsets() const { return onset_count_; }

  /// Whether tangent vectors can begin here.
  virtual bool may_vary() const { return true; }
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
  /// Unknown in penalty runs.
  const Predicted& predicted() const { return predicted_; }
  /// Contact onsets of an event-driven run since vary() or forget_onsets(), with the derivatives along the
  /// vectors.
  const std::vector<VariedOnset>& varied_onsets() const { return columns_->onsets(); }
  void forget_onsets() { columns_->forget_onsets(); }
  /// Evaluations for the tangent vectors over those of the run.
  double cost() const;
  /// Both together.
  long evaluations() const { return own_evaluations() + (columns_ ? columns_->evaluations() : 0); }

 protected:
  /// Places in the integrated vector: of first-order states, and of integrals with their end.
  struct Layout {
    int states, integrals, end;
  };
  explicit TangentRun(const Plan& plan);
  /// Makes a step of the scheme; false if there is none, with failure_.
  virtual bool advance(double t_end) = 0;
  /// Begins the columns of the keys; `length` (m) and `duration` (s): see VariedColumns.
  virtual DerivativeColumns& begin_columns(const std::vector<VariedKey>& keys, double length,
                                           double duration) = 0;
  /// Projects the columns onto the constraints.
  virtual void project(const Eigen::MatrixXd& /*Z*/) {}
  virtual const Vector& x() const = 0;
  virtual Layout layout() const = 0;
  virtual long own_evaluations() const = 0;
  State now() const;

  const Scene& scene_;
  const System& system_;
  OwnCoordinates own_;
  Predicted predicted_;
  std::string failure_;
  TracedEquations equations_;
  long onset_count_ = 0;
  DerivativeColumns* columns_ = nullptr;  // of the subclass, since vary()

 private:
  StopToken stop_;
  double end_;
  std::vector<std::string> collapsed_;
};

std::unique_ptr<TangentRun> make_tangent_run(const TangentRun::Plan& plan, Family family);

}  // namespace freeplay
