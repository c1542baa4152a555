// Forces on a mechanism at rest and their derivatives. With first-order states at their stationary
// values z(q), flow(q, z) = 0, and drives at t = 0,
//
//     R(q, μ) = f(q, 0, z(q)) + Σ_elastic W_N F_el(−g) − Cᵀ μ,      K = −∂R/∂q,   D = −∂R/∂v,
//
// where C consists of the constraint rows G and, for contacts held closed, their rows W_N
// (F_N = −μ). K includes the geometric stiffness ∂(Cᵀμ)/∂q of reactions and contact forces.
// Derivatives are those of the traced equations (dynamics/system_tangent.hpp). Friction, films and contact
// damping exert no force at rest and are not part of D.
#pragma once

#include <Eigen/Core>

#include <vector>

#include "dynamics/assembly/compliance.hpp"
#include "dynamics/system.hpp"
#include "dynamics/system_tangent.hpp"

namespace freeplay {

/// A mechanism at rest at one position.
struct AtRest {
  Eigen::VectorXd q;
  std::vector<double> z;
  Eigen::VectorXd applied;      ///< f: drives, loads and weight
  std::vector<double> gap;      ///< m, of every contact
  std::vector<double> elastic;  ///< N, of elastic contacts
  Eigen::VectorXd force;        ///< f and elastic contacts
  Eigen::MatrixXd C;            ///< G, then one row for each contact held closed
  Eigen::VectorXd c;            ///< Φ and gaps
};

/// −∂R/∂q, −∂R/∂v, ∂R/∂z and the derivatives of the states' flow, all at fixed μ.
struct Linearised {
  Eigen::MatrixXd K, D, Z, flow_q, flow_v, flow_z;
  /// K for states that follow their stationary values.
  Eigen::MatrixXd settled() const;
};

class Statics {
 public:
  explicit Statics(const System& system, Compliances elastic = {});

  const System& system() const { return system_; }
  /// Length (m) that converts an angle of 1 rad.
  double length() const { return length_; }
  /// Contacts held closed, ascending.
  std::vector<int> closed;

  /// Replaces the elastic laws of the contacts.
  void yield_by(Compliances elastic) { elastic_ = std::move(elastic); }

  /// Evaluates the position q. Throws ModelError if a first-order state has no stationary value.
  void look(const Eigen::VectorXd& q, AtRest& at);
  Linearised linearise(const AtRest& at, const Eigen::VectorXd& mu);
  /// −∫ f·dq along the chord from a to b, plus the increase of the energy of elastic contacts: the
  /// change of the potential, if there is one.
  double climb(const AtRest& a, const AtRest& b);
  /// Sum of the absolute values of the forces in R, for each coordinate (N, N m).
  Eigen::VectorXd sizes(const AtRest& at, const Eigen::VectorXd& mu);
  const Compliance* compliance(int contact) const {
    return elastic_.empty() || !elastic_[contact] ? nullptr : &elastic_[contact];
  }

 private:
  void settle_states(const double* q, std::vector<double>& z);
  SystemTangent::Point point(const double* q, const std::vector<double>& z,
                             const std::vector<double>& lambda) const;
  const Eigen::VectorXd& applied(const Eigen::VectorXd& q, std::vector<double>& z);

  const System& system_;
  Compliances elastic_;
  double length_ = 1;
  Evaluation e_;
  SystemTangent tangent_;
  DirectionBlocks blocks_;
  SystemTangent::MotionSlopes motion_;
  ContactRow row_;
  std::vector<double> rest_;
  Eigen::VectorXd f_;
};

}  // namespace freeplay
