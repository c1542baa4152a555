// What acts on a mechanism at rest, and how that changes with its position. With first-order states at their stationary
// values z(q), flow(q, z) = 0, and drives at t = 0,
//
//     R(q, μ) = f(q, 0, z(q)) + Σ_elastic W_N F_el(−g) − Cᵀ μ,      K = −∂R/∂q,   D = −∂R/∂v,
//
// where C has the constraint rows G and, for contacts that are held closed, their rows W_N (F_N = −μ). K holds the
// geometric stiffness ∂(Cᵀμ)/∂q of reactions and contact forces; derivatives come from dual numbers. Friction, films
// and what damps contacts exert nothing at rest and stay out of D.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/assembly/compliance.hpp"
#include "dynamics/system.hpp"

namespace freeplay {

/// A mechanism at rest at one place.
struct AtRest {
  Eigen::VectorXd q;
  std::vector<double> z;
  Eigen::VectorXd applied;      ///< f: drives, loads and weight
  std::vector<double> gap;      ///< m, of every contact
  std::vector<double> elastic;  ///< N, of elastic contacts
  Eigen::VectorXd force;        ///< f and elastic contacts
  Eigen::MatrixXd C;            ///< G, then a row for each contact held closed
  Eigen::VectorXd c;            ///< Φ and gaps
};

/// −∂R/∂q, −∂R/∂v, ∂R/∂z and the derivatives of the states' flow, all at fixed μ.
struct Linearised {
  Eigen::MatrixXd K, D, Z, flow_q, flow_v, flow_z;
  /// K with the states following their stationary values.
  Eigen::MatrixXd settled() const;
};

class Statics {
 public:
  explicit Statics(const System& system, Compliances elastic = {});

  const System& system() const { return system_; }
  /// m: what an angle of 1 rad counts as.
  double length() const { return length_; }
  /// Contacts that are held closed, ascending.
  std::vector<int> closed;

  /// Contacts yield otherwise from now on.
  void yield_by(Compliances elastic) { elastic_ = std::move(elastic); }

  /// Throws ModelError where a first-order state has no stationary value.
  void look(const Eigen::VectorXd& q, AtRest& at);
  Linearised linearise(const AtRest& at, const Eigen::VectorXd& mu);
  /// −∫ f·dq along the chord from a to b, and what elastic contacts store more: of forces that have a potential its change.
  double climb(const AtRest& a, const AtRest& b);
  /// How large the forces are whose sum R is, by coordinate (N, N m).
  Eigen::VectorXd sizes(const AtRest& at, const Eigen::VectorXd& mu);
  const Compliance* compliance(int contact) const {
    return elastic_.empty() || !elastic_[contact] ? nullptr : &elastic_[contact];
  }

 private:
  void settle_states(const double* q, std::vector<double>& z);
  const Eigen::VectorXd& applied(const Eigen::VectorXd& q, std::vector<double>& z);

  const System& system_;
  Compliances elastic_;
  double length_ = 1;
  Evaluation e_;
  EvaluationOf<Gradient> d_;
  ContactRow row_;
  std::vector<double> rest_;
  Eigen::VectorXd f_;
};

}  // namespace freeplay
