// ModeEquations: the equations of motion of the event-driven scheme at one state. It owns the data
// that the choice of the mode, the motion, impacts and projection share: the mode itself, the
// saddle point of the constraints
//
//     M v̇ + Gᵀλ = f,   G v̇ = γ,
//
// the active rows beside it, and the tolerances below which a speed counts as zero.
//
// The integrated vector is [q, v, (P_N, P_T) of each contact, first-order states of elements, work
// integrals].
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "dynamics/system.hpp"
#include "formulations/contact/coupled_friction.hpp"
#include "formulations/contact/film.hpp"
#include "formulations/integrators/kinks.hpp"
#include "numerics/dense.hpp"
#include "numerics/saddle_point.hpp"
#include "simulation/formulation.hpp"

namespace freeplay {

/// ActiveRows: the rows that take part in a problem of the event-driven scheme. With the response
/// r = A w of the mechanism to a unit force along a row w (A the inverse of the saddle point), the
/// rows W and the responses X,
///
///     K x = b,   K = W X.
///
/// The row of a sliding contact responds to the normal force and its friction together, so K need
/// not be symmetric. If there are several solutions (sticking contacts of one body share a row),
/// solve() gives the one of least norm.
class ActiveRows {
 public:
  /// For a mechanism of n coordinates and m constraint rows; at most `most` rows are active at one
  /// time.
  ActiveRows(int n, int m, int most);

  void clear() { used_ = 0; }
  int used() const { return used_; }
  int most() const { return static_cast<int>(rows_.size()); }
  /// Adds a row and the response to `row` + `factor` · `beside`; returns its index.
  int add(SaddlePoint& saddle, const SparseRow& row, const SparseRow* beside = nullptr, double factor = 0);
  /// The same at place `r` after the rows in use, without counting it.
  void put(int r, SaddlePoint& saddle, const SparseRow& row, const SparseRow* beside = nullptr,
           double factor = 0);

  const SparseRow& row(int r) const { return rows_[static_cast<std::size_t>(r)]; }
  /// n numbers
  const double* response(int r) const { return response_.data() + static_cast<long>(r) * n_; }
  const double* reaction(int r) const {
    return reaction_.data() + static_cast<long>(r) * m_;
  }  ///< m multipliers

  void fill();            ///< K of all rows
  void fill_symmetric();  ///< K of rows whose response is to themselves alone
  void solve();           ///< K x = b of the rows in use
  /// The least x/√weight: if K is singular, forces are shared in proportion to the weights (one per
  /// row).
  void share(const Eigen::VectorXd& weight);
  /// The least of these with C x + c ≥ 0. Returns false and keeps x if there are none.
  bool share_within(const Eigen::VectorXd& weight, const Eigen::MatrixXd& C, const Eigen::VectorXd& c);
  bool dependent() const { return dependent_; }  ///< K was singular in the last solve()
  /// sign of the determinant of K in the last solve()
  int turn() const { return turn_; }
  /// Adds the response to x to accelerations (or rates) `a` and multipliers `lambda`.
  void apply(double* a, double* lambda) const;

  Eigen::MatrixXd K;
  Eigen::VectorXd b, x;

 private:
  void make_room(int rows);

  int n_, m_, used_ = 0, room_ = 0;
  std::vector<SparseRow> rows_;
  std::vector<double> response_, reaction_;
  DenseLu lu_;
  bool dependent_ = false;
  int turn_ = 1;
};

inline bool is_finite(const std::vector<double>& x) {
  return std::ranges::all_of(x, [](double y) { return std::isfinite(y); });
}

/// A contact in a mode: open, closed and sticking, or closed and slipping in one direction.
struct ModeContact {
  bool closed = false;
  int slip = 0;  ///< of a closed contact with friction: 0 sticks, ±1 the sign of u_T
  /// Closed without load: no force acts, and projection keeps the gap at zero until its rate
  /// exceeds rounding.
  bool resting = false;
  double restitution = 0;
  const Surface* by_speed = nullptr;  ///< whose restitution depends on the approach speed
  ContactRow row;
  double lambda_n = 0, lambda_t = 0;  ///< N, at the last evaluation
  double mobility = 0;                ///< 1/kg, response of its gap to its own λ_N
  int unknown = -1, tangent_unknown = -1;
  template <class M>
  void serialize(M& m) {
    m(closed, slip, resting, row, lambda_n, lambda_t, mobility, unknown, tangent_unknown);
  }
};

/// A joint with friction in a mode.
struct ModeFriction {
  int slip = 0;  ///< as for a contact
  SparseRow row;
  double gamma = 0, rate = 0, lambda = 0;
  double bound = 0;     ///< N, in the direction of its force, at the last evaluation
  double opposite = 0;  ///< N, the bound in the opposite direction
  /// N, what is left to the nearer limit
  double slack() const { return std::min(bound - std::abs(lambda), opposite + std::abs(lambda)); }
  /// reactions of its joint at the choice of the mode, where its bound depends on them
  std::array<double, 2> reaction{};
  /// ratio of its sliding speed to the speed of the bodies, for the tolerance of zero sliding
  double share = 1;
  int unknown = -1;
  template <class M>
  void serialize(M& m) {
    m(slip, row, gamma, rate, lambda, bound, opposite, reaction[0], reaction[1], unknown);
  }
};

/// Films of lubricated joints, whose forces depend on the state only.
class ModeFilms {
 public:
  explicit ModeFilms(const System& system);
  bool any() const { return !films_.empty(); }
  /// Adds their forces to e.force.
  void add(const System& system, const double* q, const double* v, Evaluation& e);
  void report(const System& system, const double* q, const double* v, Evaluation& e, Forces& out);
  double loss() const { return loss_; }  ///< W, at the last add()

  struct JointFilm {
    int contact;
    Film law;
  };
  const std::vector<JointFilm>& list() const { return films_; }

 private:
  std::vector<JointFilm> films_;
  ContactRow row_;
  double loss_ = 0;
};

class ModeEquations {
 public:
  using Vector = std::vector<double>;

  ModeEquations(const System& system, const std::vector<double>& restitution, RowFacts facts,
                double speed_scale);

  const System& system;
  std::vector<ModeContact> contacts;
  std::vector<ModeFriction> preloaded;
  Phases phases;  ///< the pieces of torque tables in the present mode
  /// s: no stage evaluates a prescribed motion beyond this time; its acceleration may jump at a
  /// knot, where the next step begins.
  double knot = INFINITY;
  SaddlePoint saddle;
  Evaluation e;
  ModeFilms films;
  ActiveRows rows;
  CoupledFriction coupled;
  Vector a, lambda;  ///< accelerations and multipliers at the last evaluation
  /// N, the greatest of the forces of active rows that depend on each other, otherwise 0
  double shared_force = 0;
  std::string trouble;
  Work work;
  Extremes extremes;
  struct Counts {
    long undecided = 0;   ///< problems whose uniqueness was not decided
    long wedged = 0;      ///< impacts by the energetic law that used Poisson's ratios
    long unreported = 0;  ///< instants at which no forces were found to report
    /// forces at their limit that rounding left on neither side: the mode was kept
    long unresolved = 0;
  } counts;

  /// @name The integrated vector
  ///@{
  int impulse_offset() const { return 2 * system.n(); }
  int state_offset() const { return impulse_offset() + 2 * system.contacts(); }
  int integral_offset() const { return state_offset() + system.states(); }
  ///@}

  /// Evaluates the system at q (m, rad) and t (s), unless this was the last evaluation.
  void place(const double* q, double t);
  /// Called when e is that of q (m, rad) and t (s).
  void placed(const double* q, double t) {
    e.pieces = phases.pieces();
    placed_t_ = t;
    std::copy(q, q + system.n(), placed_.begin());
  }
  /// Called if a phase moves to another piece, or if e is undefined.
  void forget_place() { placed_t_ = __builtin_nan(""); }
  /// Computes accelerations in `a` with all contacts open, friction of slipping joints as forces
  /// and joints at rest without friction. Returns false if there are none, with the reason in
  /// `trouble` if it is known.
  bool solve_free(const Vector& x, double t);
  /// Adds a row to `rows`.
  int add(const SparseRow& row, const SparseRow* beside = nullptr, double factor = 0) {
    return rows.add(saddle, row, beside, factor);
  }
  /// Σ w²/m of a row: its mobility without constraints.
  double unconstrained_mobility(const SparseRow& row) const;
  /// μ of contact k in its mode: at rest if it sticks, else at its sliding speed at the rates v (its row is
  /// that of v).
  double friction_of(int k, const double* v) const {
    const auto& surface = system.contact_facts(k).surface;
    const auto& c = contacts[static_cast<std::size_t>(k)];
    if (!surface.friction_by_speed()) return *surface.friction;
    return c.slip != 0 ? surface.friction_at(c.row.tangent.dot(v)) : surface.friction_at_rest();
  }
  /// The k-th of the friction bounds that depend on reactions.
  const ReactionBound& bound_of(int k) const { return *system.friction_facts(coupled.friction(k)).reaction; }

  /// Evaluates the row of contact k at a state.
  const ContactRow& look(int k, const Vector& x, double t);
  double slide_rate(int k, const Vector& x, double t);
  /// Gap (m) below which an unloaded contact counts as closed: 1e-9 of the clearance, or the
  /// rounding error of the positions.
  double closed_gap(int k, const double* q) const;
  /// Updates `extremes` with the constraint errors and penetrations at a state.
  void keep_extremes(const Vector& x, double t);

  /// @name Scales and tolerances
  ///@{
  /// Greatest absolute rate or acceleration of all coordinates; angles count at the longest arm.
  double greatest(const double* rates) const;
  /// Greatest acceleration at the last evaluation (m/s²).
  double acceleration_scale() const { return greatest(a.data()); }
  /// Force of a contact (N) that is zero to rounding, for the mobility of its gap (1/kg).
  double force_tolerance(double mobility) const {
    return 1e-8 * std::max(mobility > 0 ? acceleration_scale() / mobility : 0, shared_force);
  }
  /// ω² times the longest arm (m/s²): if nothing is accelerated, terms of this size cancel in a
  /// contact force.
  double centripetal_scale(const double* v) const;
  /// A relative speed below it counts as zero (m/s): rounding of the velocities, or 1e-10 of the
  /// scene's speed scale.
  double speed_tolerance() const { return speed_tolerance_; }
  void raise_speed_tolerance(double least) { speed_tolerance_ = std::max(speed_tolerance_, least); }
  /// A sliding speed below it counts as zero, and the accelerations determine its further
  /// direction. It is larger, because the located end of sliding is only as accurate as the dense
  /// output.
  double slide_tolerance() const { return slide_tolerance_; }
  void measure_speeds(const Vector& x);
  double speed_scale() const { return speed_scale_; }
  ///@}
  RowFacts facts() const { return facts_; }

  template <class M>
  void serialize(M& m) {
    for (auto& c : contacts) m(c);
    for (auto& p : preloaded) m(p);
    m(phases, saddle, speed_tolerance_, slide_tolerance_, fastest_, a, work, extremes);
  }

 private:
  RowFacts facts_;
  double speed_scale_, speed_tolerance_ = 0, slide_tolerance_ = 0;
  double fastest_ =
      0;  // m/s, the greatest speed so far: where all bodies reverse together, the present one vanishes
  Vector placed_;  // q and t of the evaluation e
  double placed_t_ = __builtin_nan("");
};

}  // namespace freeplay
