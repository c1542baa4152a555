// Motion between events under set-valued laws. In a mode every contact is open or closed and every closed one
// with friction, like every preloaded joint, sticks or slips one way:
//
//     M v̇ + Gᵀλ = f + Σ (W_N − s μ W_T) λ_N + Σ W_T λ_T,    G v̇ = γ,
//     W_Nᵀ v̇ = γ_N (closed),   W_Tᵀ v̇ = γ_T (sticking),   s = sgn u_T of those that slip.
//
// Which mode follows an event is a complementarity problem in accelerations (Glocker, Set-Valued Force
// Laws, 2001):
//     0 ≤ g̈ ⊥ λ_N ≥ 0,   −λ_T ∈ μ λ_N Sgn(u̇_T) where u_T = 0,   λ_T = −s μ λ_N where it is not.
// Films of lubricated joints are forces in f; a mode of a scene that has any may be integrated implicitly, with jacobian().
// Friction that its joint's reaction bounds (dynamics/reaction_bound.hpp) is λ_T = −s μ(|u|) S(λ) where it slips, solved with
// the reactions of the same instant (contact/coupled_friction.hpp), and in every other problem has bounds that are iterated
// until they agree with its reactions (bound_iteration.hpp): forces where modes are chosen, impulses within impacts.
// The integrated vector is [q, v, (P_N, P_T) of each contact, first-order states of elements, work
// integrals].
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "dynamics/system.hpp"
#include "formulations/contact/bound_iteration.hpp"
#include "formulations/contact/contact_problem.hpp"
#include "formulations/contact/coupled_friction.hpp"
#include "formulations/contact/film.hpp"
#include "formulations/contact/impact.hpp"
#include "formulations/integrators/phases.hpp"
#include "numerics/saddle_point.hpp"
#include "simulation/formulation.hpp"

namespace freeplay {

inline bool is_finite(const std::vector<double>& x) {
  return std::ranges::all_of(x, [](double y) { return std::isfinite(y); });
}

class EventDynamics {
 public:
  using Vector = std::vector<double>;
  /// film_loss: only where there are films.
  enum Integral { drive, load, damping, friction_loss, integrals, film_loss = integrals };
  struct Contact {
    bool closed = false;
    int slip = 0;    ///< of a closed one with friction: 0 sticks, ±1 the sign of u_T
    int forced = 0;  ///< it has just been torn from sticking this way: the next choice starts from that
    /// Closed without load: no force acts, and the gap stays zero by project() until its rate is more than rounding.
    bool resting = false;
    double restitution = 0;
    ContactRow row;
    double lambda_n = 0, lambda_t = 0;  ///< N, at the last evaluation
    double mobility = 0;                ///< 1/kg, of λ_N on its own gap
    int unknown = -1, tangent_unknown = -1;
    template <class M>
    void remember(M& m) {
      m(closed, slip, forced, resting, row, lambda_n, lambda_t, mobility, unknown, tangent_unknown);
    }
  };
  struct Preloaded {
    int slip = 0, forced = 0;  ///< as of a contact
    SparseRow row;
    double gamma = 0, rate = 0, lambda = 0;
    double bound = 0;  ///< N, at the last evaluation
    double share =
        1;  ///< of a speed that is none: its sliding over the speed of the bodies that it stands for
    int unknown = -1;
    template <class M>
    void remember(M& m) {
      m(slip, forced, row, gamma, rate, lambda, bound, unknown);
    }
  };

  EventDynamics(const System& system, const NonsmoothOptions& options, std::vector<double> restitution,
                RowFacts facts, double speed_scale);

  /// Why the last evaluation failed; empty when it did not.
  const std::string& trouble() const { return trouble_; }

  /// dx/dt of the present mode.
  void operator()(const Vector& x, Vector& dxdt, double t);
  /// ∂(dx/dt)/∂x of the present mode (column-major, size() × size()) and ∂(dx/dt)/∂t (event_jacobian.cpp).
  void jacobian(const Vector& x, double t, double* J, double* dfdt);
  /// Makes what jacobian() works in, which it else makes when first called.
  void reserve_jacobian();
  bool has_films() const { return !films_.empty(); }

  /// Impulses of all contacts in `struck` (gap closed), added to v and to the impulses and works in x. An
  /// empty text, or why there are none. Contacts in `soft` take e = 0 and e_T = 0. `jammed`: an impact without
  /// collision: the contacts press at rates that only just approach, and friction takes what impulses it needs.
  std::string strike(Vector& x, double t, const std::vector<int>& struck, const std::vector<int>& soft,
                     bool jammed = false);
  /// The last choice of a mode found none; all having been tried where it is proved.
  bool jammed() const { return jam_; }
  bool jam_proved() const { return jam_proved_; }
  /// The last strike took e = 0 for want of impulses that keep the law.
  bool struck_inelastic() const { return impact_.inelastic(); }
  /// The rate of approach that the last impact without collision was given (m/s).
  double jam_rate() const { return jam_rate_; }
  /// The rate (m/s) that contact `i` of the last strike would have from its own normal impulse alone.
  double struck_rate(std::size_t i) const {
    const auto& c = struck_[i];
    return c.impulse_n * K_(c.normal, c.normal);
  }
  /// Impulses of the last strike at x, into a cleared table.
  void report_strike(const Vector& x, const std::vector<int>& struck, Forces& out);
  double impact_gain() const { return impact_.normal_work() + impact_.tangential_work(); }

  /// Chooses the mode from the contacts that touch without relative normal speed (`candidates`), by the
  /// problem in accelerations. An empty text, or why it cannot be chosen.
  std::string choose(const Vector& x, double t, const std::vector<int>& candidates);
  /// @name What is to slide one way by `forced`
  ///@{
  bool torn() const;
  /// How fast some of it would begin to slide the other way in the mode chosen, in acceleration_scale(): infinite where that is not known.
  double torn_back(const Vector& x, double t);
  void mend();
  ///@}
  /// g̈ of an open contact in the present mode.
  double gap_acceleration(int k, const Vector& x, double t);
  /// λ_N of contact k as the acceleration of its gap that it makes (m/s²), at the last evaluation of a mode.
  double pressure(int k) const { return contacts_[k].lambda_n * contacts_[k].mobility; }
  /// Greatest acceleration at the last evaluation (m/s²).
  double acceleration_scale() const { return greatest(a_.data()); }
  /// ω² times the longest arm (m/s²): where nothing is accelerated, such terms cancel in a contact's pressure.
  double centripetal_scale(const double* v) const;
  /// Moves x onto the constraints of the mode, positions then velocities, by the least mass-weighted change; adds
  /// the impulses of the latter to `book`, if there is one.
  void project(Vector& x, double t, Forces* book = nullptr);

  /// Another one of the same scene, to look without touching this one's memory.
  std::unique_ptr<EventDynamics> twin() const {
    std::vector<double> restitution;
    for (const auto& c : contacts_) restitution.push_back(c.restitution);
    auto other = std::make_unique<EventDynamics>(system_, options_, restitution, facts_, speed_scale_);
    other->phases = phases;
    return other;
  }
  /// Takes another's mode.
  void take_mode(const EventDynamics& other);
  /// Forces and accelerations at x in the present mode.
  void report(const Vector& x, double t, Forces& out);
  const std::vector<double>& multipliers() const { return lambda_; }

  /// Takes the violations of constraints and walls at a state into `extremes`.
  void keep_extremes(const Vector& x, double t);
  /// How a contact's gap may bend within a step, x its end and the state of the last look().
  GapMotion gap_motion(int k, const MotionBounds& bounds, const Vector& x) const {
    return system_.gap_motion(k, bounds, x.data(), e_);
  }
  /// Fills row() of contact k at a state.
  const ContactRow& look(int k, const Vector& x, double t);
  double slide_rate(int k, const Vector& x, double t);
  /// A contact without load whose gap (m) is less is closed: 1e-9 of the clearance, or rounding of the positions.
  double closed_gap(int k, const double* q) const;

  int size() const { return integral_offset() + integrals + has_films(); }
  int impulse_offset() const { return 2 * system_.n(); }
  int state_offset() const { return impulse_offset() + 2 * system_.contacts(); }
  int integral_offset() const { return state_offset() + system_.states(); }
  const System& system() const { return system_; }
  bool singular() const { return saddle_.singular(); }
  double nearest_singular() const { return saddle_.nearest_singular(); }
  std::vector<Contact>& contacts() { return contacts_; }
  const std::vector<Contact>& contacts() const { return contacts_; }
  std::vector<Preloaded>& preloaded() { return preloaded_; }
  const std::vector<Preloaded>& preloaded() const { return preloaded_; }
  /// Below it a relative speed is none (m/s): rounding of the velocities, or 1e-10 of the scene's scale.
  double speed_tolerance() const { return speed_tolerance_; }
  /// Below it a sliding speed is none: the accelerations decide which way it goes on. Wider, because a
  /// located end of sliding is only as sharp as the dense output.
  double slide_tolerance() const { return slide_tolerance_; }
  void measure_speeds(const Vector& x);

  Phases phases;  ///< the pieces of torque tables that the present mode is held to
  /// s: no stage sees a prescribed motion beyond it; its acceleration may jump at a knot, which the next step sees.
  double knot = INFINITY;
  Work work;
  Extremes extremes;
  double contact_loss = 0, stabilisation = 0;  ///< J
  long undecided = 0;                          ///< problems whose uniqueness was not decided
  long wedged = 0;                             ///< impacts that took Poisson's ratios for the energetic law's
  long unreported = 0;                         ///< instants at which report() found no forces

  template <class M>
  void remember(M& m) {
    m.part("event dynamics");
    for (auto& c : contacts_) m(c);
    for (auto& p : preloaded_) m(p);
    m(phases, saddle_, speed_tolerance_, slide_tolerance_, a_, work, extremes, contact_loss, stabilisation,
      undecided, wedged, status_.modes_left, impact_.modes_left());
  }
  /// To be called where a phase goes over to another piece.
  void forget_place() { placed_t_ = __builtin_nan(""); }

 private:
  /// Greatest of rates or accelerations of all coordinates, those of angles at the longest arm.
  double greatest(const double* rates) const;
  void place(const double* q, double t);
  void add_films(const double* q, const double* v);
  void solve_active();
  void share_friction();
  void solve_rows();
  bool add_coupled();
  void keep_bounds();
  ContactSolution settle_bounds(const Vector& x, double t, const std::vector<int>& candidates);
  bool other_motion(const Vector& x, double t, const std::vector<int>& candidates);
  void press_jammed();
  std::string strike_bounded(const Vector& x, std::size_t contacts);
  bool solve_free(const Vector& x, double t);
  bool solve_mode(const Vector& x, double t);
  bool passes_pole();
  std::string name_of_unknown(int i) const;
  std::string unsolved(const ContactSolution& solution) const;
  void pose(const Vector& x, const std::vector<int>& candidates);
  /// Room for the responses of so many rows, and for what they do to each other; keeps what is there.
  void make_room(int rows);
  /// Adds a column A·`column` to the responses and its row; returns its index.
  int add(const SparseRow& row, const SparseRow* beside, double factor);
  double* response(int r) { return response_.data() + static_cast<long>(r) * system_.n(); }
  double* reaction(int r) { return reaction_.data() + static_cast<long>(r) * system_.rows(); }

  const System& system_;
  NonsmoothOptions options_;
  RowFacts facts_;
  double speed_scale_, speed_tolerance_ = 0, slide_tolerance_ = 0;
  SaddlePoint saddle_;
  Evaluation e_;
  Vector placed_;  // q and t that e_ was placed at
  double placed_t_ = __builtin_nan("");
  std::vector<Contact> contacts_;
  std::vector<Preloaded> preloaded_;
  struct JointFilm {
    int contact;
    Film law;
  };
  std::vector<JointFilm> films_;
  ContactRow film_row_;
  double film_loss_ = 0;  // W, at the last evaluation
  struct Tangent;         // of jacobian()
  std::shared_ptr<Tangent> tangent_;
  ImpactProblem impact_;
  ContactProblem status_;
  std::vector<ImpactContact> struck_;
  std::vector<SparseRow> rows_;
  std::vector<double> response_, reaction_;
  int used_ = 0, room_ = 0;
  CoupledFriction coupled_;
  BoundIteration bounds_;
  Eigen::VectorXd bound_image_;
  bool dependent_ = false;  // the active rows depend on each other
  bool jam_ = false, jam_proved_ = false;
  bool reporting_ = false;
  double jam_rate_ = 0;
  int turn_ = 1, orientation_ = 0;  // signs of the determinant of what holds: now, and since the mode began
  bool pole_ = false;               // the last evaluation lay behind a pole of its forces
  std::string trouble_;
  std::vector<int> posed_, posed_slips_, posed_resting_;  // contacts and preloaded joints of status_
  Eigen::MatrixXd K_;
  Eigen::VectorXd rhs_, solution_;
  Eigen::PartialPivLU<Eigen::MatrixXd> active_;  // of the rows that hold
  /// Of add_coupled(): the rows' forces without that friction and by a unit of each, and multipliers with them.
  Eigen::VectorXd held_forces_;
  std::vector<Eigen::VectorXd> answers_;
  Vector held_reactions_;
  Vector a_, lambda_, r_;
  Vector change_;  // of positions or velocities by project()
  /// What a row of project() belongs to: contact and which of its rows, or a preloaded joint.
  struct Owner {
    int contact, friction;
    bool tangent;
  };
  std::vector<Owner> owners_;
  std::vector<double> struck_lambda_;  // impulses of the constraint rows in the last strike
};

}  // namespace freeplay
