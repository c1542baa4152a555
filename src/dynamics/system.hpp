// The equations of motion of a mechanism, ready for evaluation:
//
//     M a + Gᵀ λ = f(t, q, v) + contact forces
//     Φ(q, t) = 0,   G v + Φ_t = 0,   G a = γ(t, q, v)
//
// For every contact it also gives the gap g and the rows of ġ and of the sliding rate
// (docs/theory/notation.md).
//
// Usage:
//
//     const System system(mechanism);
//     auto e = system.make_evaluation();
//     system.place(t, q, e);                // Φ, Φ_t, G and the bodies' orientations
//     system.rate(q, v, e);                 // γ
//     system.forces(t, q, v, z, e);         // f
//     system.contact(k, q, v, e, row);      // gap and rows of contact k
//
// A System owns the constant data of the mechanism and never changes; all quantities that depend on
// the state are in the Evaluation. No function allocates once an Evaluation is made. The constraint
// rows, contact pairs, drives and loads are in rows/, pairs.hpp, cam_pairs.hpp and elements/.
#pragma once

#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "dynamics/compiled_system.hpp"
#include "dynamics/families.hpp"
#include "dynamics/force_report.hpp"
#include "dynamics/parts.hpp"
#include "dynamics/phase.hpp"
#include "values/state.hpp"

namespace freeplay {

class Builder;
struct Mechanism;
template <class Facts>
struct Dynamics;  // dynamics/elements/dynamics.hpp

/// Rows of strain rates B v of elements with large stiffness, for implicit steps. With the strains s they exert
/// −Bᵀ k (s + τ B v), up to terms by the rotation of B.
struct ElasticRows {
  CsrPattern pattern;                      ///< of B
  std::vector<double> stiffness, damping;  ///< k (N/m or N m/rad) and τ (s) of each row
};
struct PlacedElements;  // dynamics/elements.hpp

class System {
 public:
  explicit System(const Mechanism& mechanism);

  int n() const { return static_cast<int>(mass_.size()); }
  int rows() const { return rows_.pattern.rows; }
  int contacts() const { return static_cast<int>(pairs_.size()); }
  int frictions() const { return static_cast<int>(slidings_.size()); }
  int bodies() const { return n() / 3; }
  /// Number of bodies without rotation. One constraint row for each, placed before all other rows,
  /// fixes its angle at zero; no other row, contact or force involves that angle
  /// (dynamics/point_bodies.hpp).
  int points() const { return points_; }
  const CsrPattern& pattern() const { return rows_.pattern; }
  const std::vector<double>& mass() const { return mass_; }
  /// Facts of contact k; beyond contacts(), those of the families.
  const ContactFacts& contact_facts(int k) const { return contact_facts_[k]; }
  /// Contact families: contacts among many bodies whose pairs appear and vanish, so that the pairs
  /// have no index here. Facts, forces and greatest penetration are given for each family as a
  /// whole. Families are numbered from contacts() on.
  const std::vector<ContactFamily>& families() const { return families_; }
  /// Number of contacts and families.
  int reported() const { return static_cast<int>(contact_facts_.size()); }
  const FrictionFacts& friction_facts(int k) const { return friction_facts_[k]; }
  /// Indices, increasing, of the joint frictions whose bound follows from the joint's reaction, or
  /// depends on the speed or direction of sliding.
  const std::vector<int>& reactive_frictions() const { return reactive_; }
  /// Name of the joint or drive that a constraint row belongs to.
  const std::string& row_name(int row) const { return rows_.names[row]; }
  /// Whether a constraint row is measured in rad (else in m).
  bool is_angle_row(int row) const { return rows_.angles[row]; }
  /// Number of rows that prescribe motion; these are the last rows.
  int drive_rows() const {
    return static_cast<int>(std::get<std::vector<SpeedRow>>(rows_.kinds).size() +
                            std::get<std::vector<MotionRow>>(rows_.kinds).size());
  }
  /// Whether the motion of a joint is prescribed along a curve. Its acceleration may then jump at
  /// next_knot().
  bool has_motions() const { return !std::get<std::vector<MotionRow>>(rows_.kinds).empty(); }
  /// Evaluates prescribed motions over a time step, exactly at its end: phi_t and the quantities
  /// that rate() uses. Call it between place() and rate().
  void step_motions(double t0, double t1, Evaluation& e) const {
    for (const auto& row : std::get<std::vector<MotionRow>>(rows_.kinds)) row.step(t0, t1, e);
  }
  /// Whether a contact's rows depend on pieces of phases.
  bool is_outline(int contact) const { return std::holds_alternative<OutlinePair>(pairs_[contact]); }
  bool has_friction(int contact) const { return contact_facts(contact).surface.friction.has_value(); }
  /// Whether a coordinate is an angle (rad); the others are lengths (m).
  bool is_angle(int coordinate) const { return coordinate % 3 == 2; }
  /// Whether any load or torque drive does work that is not a change of potential().
  bool has_loads() const { return loads_work_; }
  /// Whether a force depends on the velocities (dampers).
  bool has_velocity_forces() const { return velocity_forces_; }
  /// Greatest distance of a joint's point from its body's centre of mass (m); 0 if all are central.
  double longest_arm() const { return longest_arm_; }
  /// Length of the mechanism (m): the longest arm; without arms the greatest radius of a contact
  /// or, if all are sharp, a length of the motion (Builder::span()).
  double size() const { return size_; }

  template <class T = double>
  EvaluationOf<T> make_evaluation() const;
  /// Fills cosine, sine, phi, phi_t and G.
  template <class T>
  void place(std::type_identity_t<T> t, const T* q, EvaluationOf<T>& e, const Piece* pieces = nullptr) const;
  /// Equivalent to place() for a configuration near q_from, at which `from` was placed. Sines and
  /// cosines are continued from there to rounding accuracy, so that a time step calls the math
  /// library once for each body.
  template <class T>
  void place_near(std::type_identity_t<T> t, const T* q, const T* q_from, const EvaluationOf<T>& from,
                  EvaluationOf<T>& e) const;
  /// Fills gamma; needs place().
  template <class T>
  void rate(const T* q, const T* v, EvaluationOf<T>& e) const;
  /// Fills force and power; needs place(). `reading` says how tables are evaluated.
  template <class T>
  void forces(std::type_identity_t<T> t, const T* q, const T* v, std::type_identity_t<const T*> z,
              EvaluationOf<T>& e, const ReadingOf<std::type_identity_t<T>>& reading = {}) const;
  /// Elastic rows of beams.
  const ElasticRows& elastic() const { return elastic_; }
  /// Their values at q, in the order of their pattern; needs place().
  void elastic_rows(const double* q, const Evaluation& e, double* values, double* stiffness) const;
  /// Number of first-order states of elements (State::z), in the order of their elements. Their
  /// initial value is 0.
  int states() const { return static_cast<int>(state_scales_.size()); }
  /// Scale of errors of state k, in its own unit.
  double state_scale(int k) const { return state_scales_[k]; }
  /// Time derivatives ż of the first-order states.
  template <class T>
  void flow(std::type_identity_t<T> t, const T* q, const T* v, const T* z, T* dz,
            const ReadingOf<std::type_identity_t<T>>& reading = {}) const;
  /// Number of drives with a limited demand.
  int limiters() const { return limiters_; }
  /// Their demands over their limits, limiters() entries.
  void saturations(double t, const double* q, const double* v, const double* z, Saturation* list) const;
  /// Name of the first element with states that change at instants only; empty: none.
  const std::string& sampled() const { return sampled_; }
  /// The first instant after t at which such states change (s); infinite if there is none.
  double next_sample(double t, const double* z) const;
  /// Changes the states z as at their instants up to t that were not yet taken. Returns whether there is one.
  bool sample(double t, const double* q, const double* v, double* z) const;
  /// Whether ż of any state depends on the velocities (motors).
  bool has_velocity_flows() const { return velocity_flows_; }
  /// Potential energy of gravity and springs (J). Constant forces and torques count as loads.
  double potential(const double* q) const;
  /// Whether potential() may differ from 0.
  bool has_potential() const { return acts_ || gravity_.x() != 0 || gravity_.y() != 0; }
  double kinetic(const double* v) const;

  /// Bounds on the second derivative of contact k's gap within a step with these bounds of motion;
  /// e and q are those at its end. Needs place().
  GapMotion gap_motion(int k, const MotionBounds& bounds, const double* q, const Evaluation& e) const;
  /// Relative motion of contact k within h (s) at rates v, as a share of the motion that could pass
  /// through the contact undetected.
  double passage(int k, const double* v, double h) const { return passage(pairs_[k], v, h); }
  static double passage(const Pair& pair, const double* v, double h) {
    return std::visit([&](const auto& p) { return p.passage(v, h); }, pair);
  }
  /// Gap of contact k; needs place().
  double gap(int k, const double* q, const Evaluation& e) const { return gap(pairs_[k], q, e); }
  static double gap(const Pair& pair, const double* q, const Evaluation& e);
  /// Gap and rows of contact k; needs place(). A concentric journal has no normal: its rows are
  /// empty and its gap is c.
  template <class T>
  void contact(int k, const T* q, const T* v, const EvaluationOf<T>& e, ContactRowOf<T>& row) const {
    if constexpr (std::is_same_v<T, double>)
      if (compiled_.any_contacts() && compiled_.contact(k, q, v, e, row)) return;
    contact(pairs_[k], contact_facts_[k], q, v, e, row);
  }
  /// Gap and rows of a pair of a family.
  template <class T>
  static void contact(const Pair& pair, const ContactFacts& facts, const T* q, const T* v,
                      const EvaluationOf<T>& e, ContactRowOf<T>& row);
  /// Vector from the first body's point of contact k to the second's, in the world (m): the
  /// eccentricity of a journal. Needs place().
  Vec2 eccentricity(int k, const double* q, const Evaluation& e) const;
  /// Sliding row of a joint with friction: u = row·v. Returns γ in u̇ = row·a − γ. Needs place().
  template <class T>
  T friction(int k, const T* q, const T* v, const EvaluationOf<T>& e, SparseRowOf<T>& row) const;

  /// Ratio of the sliding speed of joint k to the speed of its bodies' masses at equal energy, at
  /// most 1; it is much smaller for a thin pin.
  double slide_share(int k) const;

  /// The first knot of a table or curve of time after t (s); infinite if there is none.
  double next_knot(double t) const;
  /// @name Phases: coordinates at which forces have kinks (dynamics/phase.hpp), and curves
  ///@{
  int phases() const { return static_cast<int>(curves_.phases.size()); }
  const Phase& phase(int k) const { return curves_.phases[k]; }
  const CurveFacts& curves() const { return curves_; }
  ///@}
  /// Greatest rotation of a body within a step (rad), so that no feature of a profile is stepped
  /// over.
  double longest_turn() const { return longest_turn_; }

  /// Resulting forces of joints, contacts, drives and loads.
  const ForceReport& report() const { return report_; }
  Forces make_forces() const {
    return {std::vector<ElementForce>(report_.elements.size()), std::vector<double>(mass_.size())};
  }
  static const Link& link_of(const Pair& pair) {
    return std::visit([](const auto& p) -> const Link& { return p.link; }, pair);
  }

  /// Compiled functions, which place(), rate(), forces() and contact() of double call.
  CompiledSystem& compiled() { return compiled_; }
  const CompiledSystem& compiled() const { return compiled_; }

  /// Angle of the main drive's joint (rad); 0 if there is none.
  double crank_angle(const double* q) const;
  /// The rows, contacts and states that each joint, contact, drive and load contributes, in the
  /// order of the mechanism.
  const std::vector<Carried>& carried() const { return carried_; }

 private:
  friend class Builder;

  void list_elements(const Mechanism& mechanism);
  /// Number of rows along curves: prescribed motions and ratios.
  int motion_rows() const {
    return static_cast<int>(std::get<std::vector<MotionRow>>(rows_.kinds).size() +
                            std::get<std::vector<RatioRow>>(rows_.kinds).size());
  }
  /// Calls f with every constraint row. Kinds of rows that few mechanisms have are skipped
  /// together.
  template <class F>
  [[gnu::always_inline]] void each_row(F f) const {
    const auto over = [&f](const auto& list) __attribute__((always_inline)) {
      for (const auto& row : list) f(row);
    };
    over(std::get<std::vector<PointRows>>(rows_.kinds));
    over(std::get<std::vector<SlideRow>>(rows_.kinds));
    over(std::get<std::vector<AngleRow>>(rows_.kinds));
    over(std::get<std::vector<SpeedRow>>(rows_.kinds));
    if (rows_.rare) each_rare_row(f);
  }
  /// A function of its own, so that kinds that a mechanism does not have leave the inlining of the others alone.
  template <class F>
  [[gnu::noinline]] void each_rare_row(F& f) const {
    const auto over = [&f](const auto& list) {
      for (const auto& row : list) f(row);
    };
    over(std::get<std::vector<MotionRow>>(rows_.kinds));
    over(std::get<std::vector<RatioRow>>(rows_.kinds));
    over(std::get<std::vector<MeshRow<InvoluteMesh>>>(rows_.kinds));
    over(std::get<std::vector<MeshRow<RackMesh>>>(rows_.kinds));
    over(std::get<std::vector<DistanceRow>>(rows_.kinds));
    over(std::get<std::vector<ReducedBeamRows>>(rows_.kinds));
  }
  /// Adds the forces of drives and loads.
  template <class T>
  void apply(const Motion<T>& motion, const T* z, EvaluationOf<T>& e) const;
  template <class T>
  void place_rows(std::type_identity_t<T> t, const T* q, EvaluationOf<T>& e) const;
  template <class Element>
  void add(Builder& builder, const Element& element, const Dynamics<Element>& dynamics, int joint);
  template <class Element>
  void place_load(Builder& builder, const Element& element);
  void add_groups(Builder& builder, const Mechanism& mechanism);
  void add_families();
  const Link& link_of(int contact) const { return link_of(pairs_[contact]); }

  std::vector<double> mass_;
  /// The constraint rows.
  struct {
    CsrPattern pattern;             // of G
    std::vector<double> constants;  // constant entries of G
    std::vector<std::string> names;
    std::vector<bool> angles;
    ConstraintRows kinds;
    bool rare = false;  // has rare kinds
  } rows_;
  std::vector<double> constant_force_;  // gravity
  std::vector<Pair> pairs_;
  std::vector<ContactFacts> contact_facts_;  // of the contacts, then of the families
  std::vector<ContactFamily> families_;
  std::vector<int> contact_joints_;  // −1: belongs to no joint
  std::vector<FrictionRow> slidings_;
  std::vector<FrictionFacts> friction_facts_;
  std::vector<int> reactive_;
  std::shared_ptr<PlacedElements> placed_;  // constant after the construction
  CurveFacts curves_;
  ElasticRows elastic_;
  std::vector<double> state_scales_;
  std::string sampled_;
  ForceReport report_;
  std::vector<Carried> carried_;
  Vec2 gravity_{0, 0};
  Link crank_;
  bool velocity_forces_ = false, velocity_flows_ = false, loads_work_ = false;
  CompiledSystem compiled_;
  int points_ = 0, limiters_ = 0;
  bool acts_ = false;  // a drive or load applies a force
  double longest_arm_ = 0, size_ = 1, longest_turn_ = 0.3;
};

}  // namespace freeplay
