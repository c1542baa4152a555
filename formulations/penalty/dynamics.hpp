// PenaltyDynamics: the right-hand side of the penalty formulation. Contact forces enter the index-1
// equations of motion with Baumgarte's stabilisation (Comput. Methods Appl. Mech. Eng. 1 (1972) 1):
//
//     M v̇ + Gᵀλ = f + Σ W_N F_N + W_T F_T,       G v̇ = γ − 2α(Gv + Φ_t) − β²Φ.
//
// The integrated vector is x = [q, v, (P_N, P_T) of each contact, bristles (deflections of LuGre,
// shear forces of tangential springs), first-order states of elements, work integrals]. A contact
// is either open or closed during a whole step. An open contact exerts no force at any trial state,
// so the right-hand side of each mode is smooth, and an event is a root of a smooth function.
//
// It owns the contacts with their laws and modes, the saddle point and the pieces of tables.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/motion_kernel.hpp"
#include "dynamics/system.hpp"
#include "formulations/contact/contact_law.hpp"
#include "formulations/contact/coupled_friction.hpp"
#include "formulations/contact/film.hpp"
#include "formulations/contact/friction_law.hpp"
#include "formulations/integrators/kinks.hpp"
#include "formulations/penalty/penalty_mode.hpp"
#include "mechanism/options.hpp"
#include "numerics/saddle_point.hpp"
#include "simulation/formulation.hpp"

namespace freeplay {

class SystemTangent;

/// Quantities that depend on the state alone and are evaluated before the reactions. Forces are in e.force.
struct PenaltyTerms {
  Evaluation e;
  std::vector<ContactRow> rows;  ///< of each closed or lubricated contact
  SparseRow slide;
  std::vector<double> impulse_rate;  ///< (F_N, F_T) of each contact
  std::vector<double> bristle_rate, flow;
  std::vector<double> rate, r;  ///< G v + Φ_t and the right-hand side of G v̇ = r
  double contact_work = 0, friction_loss = 0, film_loss = 0;
  /// Friction that its joint's reaction bounds, f = −factor·S(λ): its row, factor and sliding
  /// speed.
  struct Coupled {
    SparseRow row;
    double factor = 0, u = 0;
  };
  std::vector<Coupled> coupled;

  PenaltyTerms(const System& system, int bristles)
      : e(system.make_evaluation()),
        rows(static_cast<std::size_t>(system.contacts())),
        impulse_rate(2 * system.contacts()),
        bristle_rate(bristles),
        flow(system.states()),
        rate(system.rows()),
        r(system.rows()),
        coupled(system.reactive_frictions().size()) {}
};

/// One contact of the penalty formulation.
struct PenaltyContact : PenaltyMode {
  ContactForce law;
  std::optional<FrictionForce> friction;
  std::optional<ShearSpring> shear;  ///< in place of `friction`
  std::optional<Film> film;

  bool rubs() const { return friction || shear; }
  /// Whether the force jumps at zero depth, where a damper acts at once.
  bool jumps() const { return law.viscous > 0; }
  /// Whether its friction has a state.
  bool has_bristle() const { return shear || (friction && friction->has_state()); }
  PenaltyMode& mode() { return *this; }
  const PenaltyMode& mode() const { return *this; }
  template <class T>
  T force(const T& delta, const T& rate, const T& elastic) const {
    return force(delta, rate, elastic, v0, mass);
  }
  /// The same for other retained data, which may have derivatives.
  template <class T, class Retained>
  T force(const T& delta, const T& rate, const T& elastic, const Retained& speed, const Retained& m) const {
    return in_impact ? law.force(delta, elastic, rate, law.touch_speed(delta, rate, m))
                     : law.force(delta, elastic, rate, speed);
  }
  /// The same on one side of the clamp at zero: `presses`, without the clamp; else zero.
  double force_in_piece(double delta, double rate, double elastic, bool presses) const {
    if (law.own()) return force(delta, rate, elastic);
    if (!presses) return 0;
    return law.unclamped(elastic, rate, in_impact ? law.touch_speed(delta, rate, mass) : v0);
  }
  /// F_N (N) at a gap (m) and its rate, while closed.
  double normal_force(double gap, double rate) const {
    const double delta = std::max(0.0, -gap);
    return force(delta, -rate, law.elastic.force(delta));
  }
  /// F_T (N) along the tangent at the sliding speed v_t; z: the state of its friction.
  template <class T>
  T tangential_force(const T& normal, const T& v_t, const T& z) const {
    return shear ? shear->force(zone, normal, z) : T(-friction->coefficient(v_t, zone, z) * normal);
  }
  /// dz/dt of that state.
  template <class T>
  T bristle_rate(const T& delta, const T& rate, const T& elastic, const T& v_t, const T& z) const {
    return shear ? shear->rate(zone, delta, rate, elastic, v_t, z) : friction->bristle_rate(v_t, zone, z);
  }
  /// Ends of the present zone of its friction: of the sliding speed (m/s), or of the load of a
  /// tangential spring.
  FrictionForce::Ends zone_ends() const { return shear ? FrictionForce::Ends{-1, 1} : friction->ends(zone); }
  /// Tolerance at these ends. Otherwise two contacts that reach an end at the same instant would
  /// change each other's zone back by rounding.
  double zone_tolerance() const { return 1e-9 * (shear ? 1 : std::max(friction->v0, friction->v1)); }
};

/// A closed contact at a nominal state, and the derivatives of its forces there. Beside it, for a
/// displaced value of a parameter, forces of the displaced law at the nominal depth and rates change
/// linearly with the displaced depth and rates: the derivative with respect to the parameter is the same,
/// and displacements may be long against the depth. They are on the nominal side of the clamp at zero.
struct ContactAnchor {
  bool pressed = false;
  double delta = 0, rate = 0, v_t = 0;
  double normal = 0, normal_by_delta = 0, normal_by_rate = 0;
  double tangential_by_normal = 0, tangential_by_v_t = 0, bristle_by_v_t = 0;
  double elastic = 0;  ///< F_el (N)
};

/// Gaps and rows of contacts at given states, beside those of the right-hand side. The evaluation at one
/// state is not repeated.
class ContactRows {
 public:
  using Vector = std::vector<double>;
  explicit ContactRows(const System& system)
      : system_(system),
        any_{system.make_evaluation(), {Vector(system.n())}},
        end_{system.make_evaluation(), {Vector(system.n())}},
        end_rows_(static_cast<std::size_t>(system.contacts())),
        end_known_(end_rows_.size()) {}

  /// Contact k at any state x.
  const ContactRow& at(int k, const Vector& x, double t);
  /// The same without the constraint rows; only the state of the contact's own bodies has to be
  /// valid.
  const ContactRow& alone(int k, const Vector& x);
  /// The evaluation at any state, without Φ and Φ_t, and that of the last at().
  const Evaluation& placed(const Vector& x, double t);
  const Evaluation& last() const { return *last_; }

  /// @name All contacts at one state, which is evaluated once
  ///@{
  /// `known`: the terms there, with the rows of closed contacts; null: none.
  void place_end(const Vector& x, double t, const PenaltyTerms* known,
                 const std::vector<PenaltyContact>& contacts);
  bool is_end(const Vector& x, double t) const { return end_.at.is(x, t); }
  /// Gap, normal and tangent of contact k at the x of the last place_end().
  const ContactRow& end(int k, const Vector& x);
  /// Bounds of the motion of its gap within a step that ends there.
  GapMotion gap_motion(int k, const MotionBounds& bounds, const Vector& x) const {
    return system_.gap_motion(k, bounds, x.data(), end_.e);
  }
  ///@}

  /// A time and the first components of a state.
  struct Instant {
    Vector x;
    double t = NAN;
    bool is(const Vector& of, double at) const {
      return t == at && std::memcmp(x.data(), of.data(), x.size() * sizeof(double)) == 0;
    }
    void set(const Vector& of, double at) {
      std::copy_n(of.data(), x.size(), x.data());
      t = at;
    }
  };

 private:
  struct Placed {
    Evaluation e;
    Instant at;
    void place(const System& system, const Vector& x, double t) {
      if (at.is(x, t)) return;
      system.place(t, x.data(), e);
      at.set(x, t);
    }
  };
  const System& system_;
  Placed any_, end_;  // of at() and of place_end()
  std::vector<ContactRow> end_rows_;
  std::vector<char> end_known_;       // whether end_rows_ are those of end_
  const Evaluation* last_ = nullptr;  // that of the last at()
  ContactRow row_;                    // the result of the last at()
};

/// Friction of joints whose limit depends on the joint's reaction (coupled_friction.hpp).
struct ReactiveFriction {
  CoupledFriction laws;
  /// Changes of a and of λ by a unit of each friction force.
  std::vector<std::vector<double>> response, reaction;
  /// The reason why it has no force at the last evaluation; nullptr if it has.
  const char* trouble = nullptr;
  /// Greatest residual of its equations in the run, over the greatest bound.
  double residual = 0;

  explicit ReactiveFriction(const System& system)
      : laws(system),
        response(laws.size(), std::vector<double>(static_cast<std::size_t>(system.n()))),
        reaction(laws.size(), std::vector<double>(static_cast<std::size_t>(system.rows()))) {}
  /// Adds its effect to a, to λ and to the friction loss. Returns false if the coupled equations have no
  /// solution or several; `redundant`: the rows may be linearly dependent.
  bool add(PenaltyTerms& terms, SaddlePoint& saddle, bool redundant, double* a, std::vector<double>& lambda);
};

class PenaltyDynamics {
 public:
  using Vector = std::vector<double>;
  /// contact_work: work done on dissipative contacts. Their loss is this work less their stored
  /// energy, both functions of the state. The integral ∫ (F − F_el) δ̇ dt would continue to change
  /// where F is clamped at zero, without any error-controlled component changing.
  enum Integral { drive, load, damping, contact_work, friction_loss, film_loss, stabilisation, integrals };

  /// `facts`: facts of the constraint rows.
  PenaltyDynamics(const System& system, const PenaltyOptions& options, std::vector<PenaltyContact> contacts,
                  RowFacts facts);

  /// dx/dt for odeint.
  void operator()(const Vector& x, Vector& dxdt, double t);
  /// ∂(dx/dt)/∂x (column-major, size() × size()) and ∂(dx/dt)/∂t at a state, exact to rounding. The
  /// derivatives of the equations of motion satisfy
  ///
  ///     M v̇ + Gᵀλ = F,   G v̇ = r     ⇒     M dv̇ + Gᵀdλ = dF − dGᵀ λ,   G dv̇ = dr − dG v̇.
  void jacobian(const Vector& x, double t, double* J, double* dfdt);
  /// Derivatives of dx/dt along `directions` of x and `times` of t, exact to rounding. Returns dx/dt. The
  /// directions continue after x with (v₀, mass) of each contact, on which dx/dt depends.
  const Vector& directional(const Vector& x, double t, std::span<const Vector> directions,
                            std::span<const double> times, std::span<Vector> out);
  /// From now on the derivatives are those of these traced equations (dynamics/system_tangent.hpp), and
  /// include those by their parameters. `displaced`: of each parameter, dynamics with the contact laws at
  /// difference_places · spacing beside its value; null: of none.
  struct DisplacedLaws {
    std::array<PenaltyDynamics*, 4> at{};
    double spacing = 0;
  };
  void use_tangent(std::shared_ptr<SystemTangent> traced, std::vector<DisplacedLaws> displaced);
  /// Traces these equations near a state, which otherwise happens where they are first needed.
  void trace_jacobian(const State& near);
  /// Whether the derivatives of the last directional() along the c-th direction include those with respect to
  /// the c-th parameter.
  bool includes_parameter(std::size_t c) const;
  /// Evaluates the anchors of all closed contacts at x.
  void anchor(const Vector& x, double t, std::vector<ContactAnchor>& out);
  /// Anchors of the nominal system, if this one is displaced; null otherwise.
  const std::vector<ContactAnchor>* anchors = nullptr;
  /// Whether closed contacts without depth exert the limit of their force from within contact.
  bool touching = false;
  /// Allocates the work space of jacobian(), which otherwise does so at its first call.
  void reserve_jacobian();

  int size() const { return integral_offset() + integrals; }
  int impulse_offset() const { return 2 * system_.n(); }
  int bristle_offset() const { return impulse_offset() + 2 * system_.contacts(); }
  /// Number of bristle states: one per contact if some contact has one, else none.
  int bristles() const { return bristles_; }
  int state_offset() const { return bristle_offset() + bristles_; }
  int integral_offset() const { return state_offset() + system_.states(); }

  /// Evaluates all contacts at one state, for contact_rows.end().
  void place_end(const Vector& x, double t) {
    if (contact_rows.is_end(x, t)) return;
    // A step ends with a right-hand side at its end. Pieces of curves may be others there.
    contact_rows.place_end(x, t, evaluated_.is(x, t) && !phases.any() ? &terms_ : nullptr, contacts_);
  }
  /// Effective mass of an impact at contact k, 1/(W_Nᵀ A W_N) with the constraints kept, at the
  /// state of the last contact_rows.at().
  double effective_mass(const ContactRow& row);
  /// Energy stored in closed contacts (J): in all, in those that dissipate, and in tangential
  /// springs.
  struct Stored {
    double all = 0, dissipative = 0, shear = 0;
  };
  Stored elastic_energy(const Vector& x, double t);
  EnergyLedger ledger(const Vector& x, double t);

  /// Projects x onto Φ = 0 and G v + Φ_t = 0 by the least mass-weighted change, and records the
  /// change of energy.
  void project(Vector& x, double t);
  bool projects() const { return options_.stabilisation == Stabilisation::projection; }

  /// Makes a second object for the same scene with all contacts open, which can evaluate without
  /// changing the state of this one.
  std::unique_ptr<PenaltyDynamics> twin() const {
    auto other = twin_of(system_, options_, contacts_);
    for (auto& c : other->contacts_) c.closed = false;
    return other;
  }
  /// Makes an object for a system of the same structure with another value of a parameter.
  std::unique_ptr<PenaltyDynamics> twin_of(const System& displaced, const PenaltyOptions& options,
                                           std::vector<PenaltyContact> contacts) const {
    auto other = std::make_unique<PenaltyDynamics>(displaced, options, std::move(contacts), facts_);
    other->phases = phases;
    return other;
  }
  /// Forces and accelerations at x in the present mode; dxdt is work space.
  void report(const Vector& x, double t, Vector& dxdt, Forces& out);
  /// Adds the impulses of the last project() at x.
  void report_projection(const Vector& x, Forces& out) const;
  /// Reactions of the last evaluation (N, N m).
  const std::vector<double>& multipliers() const { return lambda_; }

  const System& system() const { return system_; }
  std::vector<PenaltyContact>& contacts() { return contacts_; }
  const std::vector<PenaltyContact>& contacts() const { return contacts_; }
  const Evaluation& evaluation() const { return terms_.e; }
  bool singular() const { return singular_; }
  const ReactiveFriction& reactive_friction() const { return friction_; }
  /// 1/s, the fastest rate of Baumgarte's terms.
  double pull() const { return std::max(baumgarte_.two_alpha, std::sqrt(baumgarte_.beta_squared)); }
  double nearest_singular() const { return saddle_.nearest_singular(); }
  ContactRows contact_rows;
  Work work;
  Phases phases;  ///< the pieces of torque tables in the present mode
  /// s: the next knot of a table against time. A stage at the end of a step may be a rounding error
  /// beyond it, on a slope of 1e13 N m/s.
  double knot = INFINITY;

  template <class M>
  void serialize(M& m) {
    m.part("penalty dynamics");
    for (auto& c : contacts_) m(c.mode());
    m(phases);
    m(saddle_, singular_, work, friction_.residual);
  }

 private:
  const System& system_;
  PenaltyOptions options_;
  RowFacts facts_;
  struct {
    double two_alpha = 0, beta_squared = 0;
  } baumgarte_;
  int bristles_ = 0;
  std::vector<PenaltyContact> contacts_;
  SaddlePoint saddle_;
  PenaltyTerms terms_;
  ContactRows::Instant
      evaluated_;  // of the last right-hand side, which terms_ are of; t: NaN if they are not
  MotionKernel kernel_;
  std::vector<double> lambda_, r_, scratch_;
  // of the rows, in project() and effective_mass(); lambda_: reactions
  std::vector<double> impulse_;
  struct Tangent;
  std::shared_ptr<Tangent> tangent_;  // the traced equations and work space of derivatives, made at first use
  bool singular_ = false;
  ReactiveFriction friction_;

  struct ActingContact;
  struct RubbingJoint;
  void begin_tangent(const Vector& x, double t);
  void press(ActingContact& p, double z, const double* v, std::size_t parameters) const;
  void differentiate(const Vector& x, double t, std::span<const Vector> directions,
                     std::span<const double> times, std::span<Vector> out);
  void add_contact(std::size_t acting, int s, std::size_t c, const Vector& direction, double* column) const;
  double rounding_of_rows(const double* q, const double* v) const;

  /// Fills the terms; `known`: the evaluation of the System, rate and r are there already.
  void evaluate(const double* q, const double* v, const double* bristle, const double* z, double t,
                bool known);
};

}  // namespace freeplay
