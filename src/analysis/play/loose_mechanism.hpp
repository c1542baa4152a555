// LooseMechanism: the positions that clearances permit to a mechanism whose drives are held.
//
// Each loose joint is described by numbers u_k within its clearance:
//
//     revolute                      e = c u, |u| ≤ 1      e: position of the journal in the bearing
//     two opposite contacts (slot,  (1 − u) g₋ = (1 + u) g₊, |u| ≤ 1
//     teeth, ends of a slider)
//
// with the gaps g₊ and g₋ of the opposite contacts: u = 1 closes the first one, u = −1 the second one. With
// the ideal joints and the drives, whose time t sets the driven coordinates, these are as many equations as
// coordinates,
//
//     F(q; u, t) = 0,        q = Q(u, t) near a regular pose (det F_q ≠ 0),
//
// so an output y(q) is a function h(u) = y(Q(u)) on the product of discs and intervals U. Its derivatives are
// ∂h/∂u = −λᵀ F_u with the adjoint F_qᵀ λ = ∇y: for a revolute joint c λ, where −λ is the reaction in the
// joint to a unit load at the output.
//
// F and y are traced once (numerics/traced.hpp), so the same operations give numbers and enclosures
// (play_extremes.hpp).
//
// Lengths, positions of pins and clearances are constants of the trace. Where some of them vary (tolerances), each
// constant is the quadratic function of the deviation from the stated value through three traces; what several
// deviations change adds up.
#pragma once

#include <Eigen/Core>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/system.hpp"
#include "mechanism/mechanism.hpp"
#include "mechanism/tolerance.hpp"
#include "numerics/curvature_tape.hpp"
#include "numerics/dense.hpp"
#include "values/play.hpp"

namespace freeplay {

/// An output coordinate with its points.
struct OutputQuantity : PlayOutput {
  Link link = {};   ///< of x, y and angle: body j and its point relative to the ground
  Vec2 axis{1, 0};  ///< of a slide, in the frame of body i
};

/// The value of a quantity at q; `e`: after System::place().
double value_of(const OutputQuantity& quantity, const double* q, const Evaluation& e);

/// Reads BODY.x, BODY.y, BODY.theta, BODY.POINT.x, BODY.POINT.y, a joint's name (its angle θ_second −
/// θ_first, or its position along its axis), or "distance(P, Q)" with points BODY, BODY.POINT or ground.
/// Throws ModelError that lists the names.
OutputQuantity output_quantity(const Mechanism& mechanism, const std::string& name);

/// A loose joint or a pair of its opposite contacts, with its numbers u: two of a disc, otherwise one.
struct LooseComponent : PlayClearance {
  int first = 0;  ///< of its entries in u, and of its equations in rows()
  int row = 0;    ///< first of its equations
  int size() const { return disc ? 2 : 1; }
};

/// A number of the mechanism that varies: the mechanism at two deviations from its stated value.
struct VariedNumber {
  Tolerance tolerance;
  std::array<double, 2> deviations{};  ///< distinct, not 0
  std::array<Mechanism, 2> mechanisms = {};
};

class LooseMechanism {
 public:
  /// `pose`: of the ideal mechanism at time t. Throws ModelError for undriven motions, dependent
  /// constraints, joints whose looseness is not described, and numbers whose variation changes the equations.
  LooseMechanism(const Mechanism& mechanism, const std::vector<OutputQuantity>& quantities,
                 const std::vector<double>& pose, double t, const std::vector<VariedNumber>& varied = {});

  int n() const { return n_; }
  /// Number of entries of u.
  int size() const { return size_; }
  const std::vector<LooseComponent>& components() const { return components_; }
  /// Of the varied numbers.
  const std::vector<Tolerance>& tolerances() const { return tolerances_; }
  /// Length scale (m).
  double length() const { return length_; }

  /// The deviations of the varied numbers in equations(), close() and output(), by default 0; enclosures are
  /// those of the stated values.
  void vary(const Eigen::VectorXd& deviations);

  /// F and its derivatives at a point.
  struct Equations {
    Eigen::VectorXd F;
    Eigen::MatrixXd by_q, by_u;
    Eigen::VectorXd by_t;
  };
  /// Evaluates F at q; false where it is not differentiable.
  bool equations(const Eigen::VectorXd& q, const Eigen::VectorXd& u, double t, Equations& f);
  /// Whether the equations and all outputs have derivatives at a pose.
  bool differentiable(const std::vector<double>& q, double t);
  /// Newton's method for F = 0 from q, to rounding; `f` and `factors` are those of the result. False if it
  /// does not converge.
  bool close(const Eigen::VectorXd& u, double t, Eigen::VectorXd& q, Equations& f, DenseLu& factors);
  /// The output `combined` is the coordinate cos φ · x + sin φ · y of the quantities x and y along the direction φ.
  static constexpr int combined = -1;
  void combine(int x, int y, double direction);
  /// Value of quantity k, or of `combined`, and its gradient by q, at the position of the last equations().
  double output(int k, Eigen::VectorXd& gradient);
  /// The second derivatives of sign · y_k − λᵀF by (q, u), at the position of the last equations().
  void second(int k, double sign, const Eigen::VectorXd& lambda, const Eigen::VectorXd& u,
              Eigen::MatrixXd& H);

  /// A set of poses q₀ + S u + δ, u ∈ U, |δ| ≤ ε; it lies in the box |q − q₀| ≤ r.
  struct Poses {
    Eigen::VectorXd q, radius;  ///< q₀ and r
    Eigen::VectorXd beyond;     ///< ε
    Eigen::MatrixXd slope;      ///< S
  };
  /// Enclosures over a set of poses of F_q = v_q − u w_q, with centres and radii: for a pair of gaps
  /// v = ½ (g₋ − g₊) and w = ½ (g₊ + g₋), for other equations F = v.
  struct Enclosures {
    Eigen::MatrixXd by_q, by_q_radius;              ///< v_q
    Eigen::MatrixXd width_by_q, width_by_q_radius;  ///< w_q, a row for each component with gaps
  };
  bool enclose(const Poses& poses, double t, Enclosures& f);
  /// The enclosure of the second derivatives of sign · y_k − λᵀF by q at fixed u, and of those by q and u, over
  /// the box of the last enclose(). Those by u vanish.
  void enclose_second(int k, double sign, const Eigen::VectorXd& lambda, const Eigen::VectorXd& u,
                      Eigen::MatrixXd& centre, Eigen::MatrixXd& radius);

 private:
  /// An equation: one output of the tape, or two opposite gaps.
  struct Row {
    int output = 0;
    int component = -1;  // −1: an ideal joint or a drive
    bool gaps = false;   // outputs `output` (closed at u = 1) and output + 1
    int u = -1;          // entry of u
    int radius = -1;     // of a revolute joint, its entry in discs_
  };
  /// A constant of the trace as a function of a deviation d, first d + second d², added to its stated value.
  struct VariedConstant {
    int number;  // the varied one
    std::size_t slot;
    double first, second;
  };
  /// An output of the tape with its weight.
  struct Term {
    std::size_t output = 0;
    double weight = 0;
  };
  /// Output k as a weighted sum of outputs of the tape.
  std::array<Term, 2> terms(int k) const;
  void list_rows(const Mechanism& mechanism, const System& ideal, const System& loose);
  /// The constants of the equations and quantities of a mechanism that is traced.
  TracedObject traced(const Mechanism& mechanism, const std::vector<OutputQuantity>& quantities,
                      const std::vector<double>& pose, double t, bool shared) const;
  void add_varied(const TracedObject& stated, const std::vector<VariedNumber>& varied,
                  const std::vector<OutputQuantity>& quantities, const std::vector<double>& pose, double t);
  void refuse_dependent(const Mechanism& mechanism, const std::vector<double>& pose);
  /// Calls put(i, c, ∂²) with the second derivatives of sign · y_k − λᵀF at u.
  template <class N, class Put>
  void each_second(CurvatureTape<N>& tape, int k, double sign, const Eigen::VectorXd& lambda,
                   const Eigen::VectorXd& u, Put put);

  int n_ = 0, size_ = 0;
  double length_ = 1;
  std::vector<Row> rows_;
  std::vector<LooseComponent> components_;
  std::vector<int> phi_;       // ideal rows that are outputs of the tape
  std::vector<int> contacts_;  // contacts whose gaps are
  std::vector<int> discs_;     // contacts whose radii are
  int quantities_ = 0;         // first of their outputs
  int radii_ = 0;              // likewise
  std::vector<Tolerance> tolerances_;
  std::vector<VariedConstant> varied_;
  std::vector<double> constants_;  // as stated; empty if none varies
  std::array<Term, 2> combination_;
  std::unique_ptr<CurvatureTape<double>> point_;
  std::unique_ptr<CurvatureTape<Interval>> box_;
  std::vector<double> x_, g_, h_;
  std::vector<Interval> x_box_, g_box_;
};

}  // namespace freeplay
