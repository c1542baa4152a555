// The mechanism laid flat for stepping:
//
//     M a + Gᵀ λ = f(t, q, v) + contact forces,     Φ(q, t) = 0,   G v + Φ_t = 0,   G a = γ(t, q, v)
//
// plus, for every contact, its gap g and the rows of ġ and of the sliding rate (docs/theory/notation.md). A System
// is constant; what varies with the state lives in an Evaluation. Nothing here allocates once an Evaluation
// is made. The rows themselves, contacts, drives and loads are files of rows/, pairs/ and elements/.
#pragma once

#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "dynamics/curve_reader.hpp"
#include "dynamics/families.hpp"
#include "dynamics/parts.hpp"
#include "dynamics/phase.hpp"
#include "numerics/dual.hpp"
#include "values/forces.hpp"
#include "values/state.hpp"

namespace freeplay {

class Builder;
struct Mechanism;
struct PlacedElements;  // dynamics/placed.hpp

class System {
 public:
  explicit System(const Mechanism& mechanism);

  int n() const { return static_cast<int>(mass_.size()); }
  int rows() const { return G_.rows; }
  int contacts() const { return static_cast<int>(pairs_.size()); }
  int frictions() const { return static_cast<int>(slidings_.size()); }
  int bodies() const { return n() / 3; }
  /// Bodies without rotation. A row of its own, the first ones, holds the angle of each at zero; no other row, contact or
  /// force has a part in it (dynamics/point_bodies.hpp).
  int points() const { return points_; }
  const CsrPattern& pattern() const { return G_; }
  const std::vector<double>& mass() const { return mass_; }
  /// Of contact k, and behind the contacts of the families.
  const ContactFacts& contact_facts(int k) const { return contact_facts_[k]; }
  /// Contacts among many bodies that have no number here, for their pairs come and go: facts, forces and greatest
  /// penetration are told of each family, numbered on from contacts().
  const std::vector<ContactFamily>& families() const { return families_; }
  /// Contacts and families.
  int reported() const { return static_cast<int>(contact_facts_.size()); }
  const FrictionFacts& friction_facts(int k) const { return friction_facts_[k]; }
  /// Those whose bound follows from their joint's reaction, in order.
  const std::vector<int>& reactive_frictions() const { return reactive_; }
  /// Name of the joint or drive that a constraint row belongs to.
  const std::string& row_name(int row) const { return row_names_[row]; }
  /// Whether a constraint row is measured in rad (else in m).
  bool is_angle_row(int row) const { return angle_rows_[row]; }
  /// Number of rows that prescribe motion; they are the last ones.
  int drive_rows() const {
    return static_cast<int>(std::get<std::vector<SpeedRow>>(constraints_).size() +
                            std::get<std::vector<MotionRow>>(constraints_).size());
  }
  /// Whether a joint's motion is prescribed along a curve: its acceleration may jump at next_knot().
  bool has_motions() const { return !std::get<std::vector<MotionRow>>(constraints_).empty(); }
  /// Prescribed motions over a time step, exact at its end: phi_t, and what rate() takes; between place() and rate().
  void step_motions(double t0, double t1, Evaluation& e) const {
    for (const auto& row : std::get<std::vector<MotionRow>>(constraints_)) row.step(t0, t1, e);
  }
  bool has_friction(int contact) const { return contact_facts(contact).surface.friction.has_value(); }
  /// Whether a coordinate is an angle (rad, else m).
  bool is_angle(int coordinate) const { return coordinate % 3 == 2; }
  /// Whether any load or torque drive does work that is not a change of potential().
  bool has_loads() const { return loads_work_; }
  /// Whether a force depends on the velocities (dampers).
  bool has_velocity_forces() const { return velocity_forces_; }
  /// Longest distance of a joint's point from its body's centre of mass (m); 0 when all are central.
  double longest_arm() const { return longest_arm_; }

  template <class T = double>
  EvaluationOf<T> make_evaluation() const;
  /// Fills cosine, sine, phi, phi_t and G.
  template <class T>
  void place(std::type_identity_t<T> t, const T* q, EvaluationOf<T>& e, const Piece* pieces = nullptr) const;
  /// The same near a configuration q_from that `from` was placed at: sines and cosines are continued from there, to rounding, so
  /// that a time step calls the library once a body.
  void place_near(double t, const double* q, const double* q_from, const Evaluation& from,
                  Evaluation& e) const;
  /// Fills gamma; needs place().
  template <class T>
  void rate(const T* q, const T* v, EvaluationOf<T>& e) const;
  /// Fills force and power; needs place(). `reading`: of tables.
  template <class T>
  void forces(std::type_identity_t<T> t, const T* q, const T* v, const T* z, EvaluationOf<T>& e,
              const Reading& reading = {}) const;
  /// First-order states of elements (State::z), in the order of their elements; they begin at 0.
  int states() const { return static_cast<int>(state_scales_.size()); }
  /// What errors of state k are measured by, in its own unit.
  double state_scale(int k) const { return state_scales_[k]; }
  /// ż of the elements' first-order states.
  template <class T>
  void flow(std::type_identity_t<T> t, const T* q, const T* v, const T* z, T* dz,
            const Reading& reading = {}) const;
  /// Whether any of it depends on the velocities (motors).
  bool has_velocity_flows() const { return velocity_flows_; }
  /// Gravity and springs (J); constant forces and torques count as loads.
  double potential(const double* q) const;
  double kinetic(const double* v) const;

  /// How contact k's gap may bend within a step with these bounds; e and q at its end. Needs place().
  GapMotion gap_motion(int k, const MotionBounds& bounds, const double* q, const Evaluation& e) const;
  /// The share of what contact k could pass through unseen that it moves within h (s) at rates v.
  double passage(int k, const double* v, double h) const { return passage(pairs_[k], v, h); }
  static double passage(const Pair& pair, const double* v, double h) {
    return std::visit([&](const auto& p) { return p.passage(v, h); }, pair);
  }
  /// Gap of contact k alone; needs place().
  double gap(int k, const double* q, const Evaluation& e) const { return gap(pairs_[k], q, e); }
  static double gap(const Pair& pair, const double* q, const Evaluation& e);
  /// All of contact k; needs place(). A concentric journal has no normal: its rows are empty, its gap is c.
  template <class T>
  void contact(int k, const T* q, const T* v, const EvaluationOf<T>& e, ContactRowOf<T>& row) const {
    contact(pairs_[k], contact_facts_[k], q, v, e, row);
  }
  /// The same of a pair of a family.
  template <class T>
  static void contact(const Pair& pair, const ContactFacts& facts, const T* q, const T* v,
                      const EvaluationOf<T>& e, ContactRowOf<T>& row);
  /// From the first body's point of contact k to the second's, in the world (m): a journal's eccentricity.
  /// Needs place().
  Vec2 eccentricity(int k, const double* q, const Evaluation& e) const;
  /// Sliding row of a joint with friction, u = row·v; returns γ in u̇ = row·a − γ. Needs place().
  template <class T>
  T friction(int k, const T* q, const T* v, const EvaluationOf<T>& e, SparseRowOf<T>& row) const;

  /// Sliding speed of joint k over that of its bodies' masses with the same energy, at most 1: of a thin pin far less.
  double slide_share(int k) const;

  /// The first knot of a table or curve against time after t (s); infinite when there is none.
  double next_knot(double t) const;
  /// @name Angles and distances at which tables and one-way forces have kinks (dynamics/phase.hpp)
  ///@{
  int phases() const { return static_cast<int>(phases_.size()); }
  const Phase& phase(int k) const { return phases_[k]; }
  /// Curves that are read and are not constant, prescribed motions first.
  const std::vector<CurveReader>& curve_readers() const { return curve_readers_; }
  /// Whether any is a table's that acts by its mean over what a time step sweeps.
  bool sweeps() const { return sweeps_; }
  /// Whether any is of a force that springs exert, which has kinks and no pulses.
  bool has_spring_kinks() const { return spring_kinks_; }
  ///@}
  /// rad: no body may turn further in a step than this, so that no feature of a profile is jumped over.
  double longest_turn() const { return longest_turn_; }

  /// @name Forces that come out (values/forces.hpp). Each adds `weight` times what it is given; e from place().
  ///@{
  const std::vector<ForceElement>& force_elements() const { return force_elements_; }
  Forces make_forces() const {
    return {std::vector<ElementForce>(force_elements_.size()), std::vector<double>(mass_.size())};
  }
  /// Constraint rows [begin, end) of each element that has any.
  struct ReactionRows {
    int element, begin, end;
  };
  std::vector<ReactionRows> reaction_rows() const {
    std::vector<ReactionRows> list;
    for (const auto& r : reactions_) list.push_back({r.element, r.begin, r.end});
    return list;
  }
  /// Ideal joints and drives of prescribed speed, −Gᵀλ.
  void report_rows(const double* q, const Evaluation& e, const double* lambda, double weight,
                   Forces& out) const;
  /// Contact k: forces along its normal and tangent rows.
  void report_contact(int k, const double* q, const Evaluation& e, const ContactRow& row, double fn,
                      double ft, double weight, Forces& out) const {
    report_contact(k, link_of(pairs_[k]), q, e, row, fn, ft, weight, out);
  }
  /// A pair of the family numbered k, added to its sum.
  void report_contact(int k, const Link& link, const double* q, const Evaluation& e, const ContactRow& row,
                      double fn, double ft, double weight, Forces& out) const;
  static const Link& link_of(const Pair& pair) {
    return std::visit([](const auto& p) -> const Link& { return p.link; }, pair);
  }
  /// A film in contact k: along its normal and film rows, and a couple along spin.
  void report_film(int k, const double* q, const Evaluation& e, const ContactRow& row, double fn, double ft,
                   double torque, double weight, Forces& out) const;
  /// Coulomb friction of joint k along its sliding row.
  void report_friction(int k, const double* q, const double* v, const Evaluation& e, const SparseRow& row,
                       double force, double weight, Forces& out) const;
  /// Torque drives and loads at a state.
  void report_loads(double t, const double* q, const double* v, const double* z, const Evaluation& e,
                    double weight, Forces& out, const Reading& reading = {}) const;
  ///@}

  /// Angle of the main drive's joint (rad), 0 without one.
  double crank_angle(const double* q) const;
  /// What each joint, contact, drive and load makes the solver carry, in the mechanism's order.
  const std::vector<Carried>& carried() const { return carried_; }

 private:
  friend class Builder;
  struct Reaction {  // of an ideal joint or a prescribed motion: rows [begin, end)
    Link link;
    int begin, end, element;
  };

  int add_element(const std::string& name, ForceElement::Kind kind, const std::array<int, 2>& bodies,
                  int joint = -1);
  void list_elements(const Mechanism& mechanism);
  /// Calls f with every constraint row; kinds that few mechanisms have are passed over together.
  template <class F>
  [[gnu::always_inline]] void each_row(F f) const {
    const auto over = [&f](const auto& list) __attribute__((always_inline)) {
      for (const auto& row : list) f(row);
    };
    over(std::get<std::vector<PointRows>>(constraints_));
    over(std::get<std::vector<SlideRow>>(constraints_));
    over(std::get<std::vector<AngleRow>>(constraints_));
    over(std::get<std::vector<SpeedRow>>(constraints_));
    if (!rare_rows_) return;
    over(std::get<std::vector<MotionRow>>(constraints_));
    over(std::get<std::vector<MeshRow<InvoluteMesh>>>(constraints_));
    over(std::get<std::vector<MeshRow<RackMesh>>>(constraints_));
    over(std::get<std::vector<DistanceRow>>(constraints_));
  }
  template <class T>
  void place_rows(std::type_identity_t<T> t, const T* q, EvaluationOf<T>& e) const;
  template <class Element>
  void add(Builder& builder, const Element& element, int joint);
  template <class Element>
  void place_load(Builder& builder, const Element& element);
  void along(const double* q, const Evaluation& e, const Link& link, const int* column, const double* value,
             int size, double amount, ElementForce& f) const;
  void add_groups(Builder& builder, const Mechanism& mechanism);
  void add_families();
  const Link& link_of(int contact) const { return link_of(pairs_[contact]); }

  std::vector<double> mass_;
  CsrPattern G_;
  std::vector<double> constant_G_;      // entries of G that never change
  std::vector<double> constant_force_;  // gravity
  std::vector<std::string> row_names_;
  std::vector<bool> angle_rows_;
  ConstraintRows constraints_;
  std::vector<Pair> pairs_;
  std::vector<ContactFacts> contact_facts_;  // families' behind the contacts'
  std::vector<ContactFamily> families_;
  std::vector<int> contact_joints_;  // −1: of no joint
  std::vector<FrictionRow> slidings_;
  std::vector<FrictionFacts> friction_facts_;
  std::vector<int> reactive_;
  std::shared_ptr<PlacedElements> placed_;  // not changed once it is built
  std::vector<Phase> phases_;
  std::vector<CurveReader> curve_readers_;
  std::vector<double> state_scales_;
  std::vector<ForceElement> force_elements_;
  std::vector<Reaction> reactions_;
  std::vector<int> contact_elements_, friction_elements_;  // by their index there
  std::vector<Carried> carried_;
  Vec2 gravity_{0, 0};
  Link crank_;
  bool velocity_forces_ = false, velocity_flows_ = false, loads_work_ = false, sweeps_ = false,
       spring_kinks_ = false;
  int points_ = 0;
  bool rare_rows_ = false,
       acts_ = false;  // kinds of rows that few have; a drive or load that applies a force
  double longest_arm_ = 0, longest_turn_ = 0.3;
};

}  // namespace freeplay
