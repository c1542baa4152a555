// The mechanism laid flat for stepping:
//
//     M a + Gᵀ λ = f(t, q, v) + contact forces,     Φ(q, t) = 0,   G v + Φ_t = 0,   G a = γ(t, q, v)
//
// plus, for every contact, its gap g and the rows of ġ and of the sliding rate (docs/notation.md). A System
// is constant; what varies with the state lives in an Evaluation. Nothing here allocates once an Evaluation
// is made. That a mechanism is planar is known here and not beyond.
#pragma once

#include <Eigen/Core>
#include <string>
#include <type_traits>
#include <vector>

#include "model/mechanism.hpp"
#include "numerics/dual.hpp"
#include "numerics/sparse.hpp"
#include "values/forces.hpp"
#include "values/state.hpp"

namespace freeplay {

/// A contact pair as the formulations see it.
struct ContactFacts {
  std::string name;                           ///< of the joint
  std::array<int, 2> bodies{ground, ground};  ///< bearing's and journal's
  double clearance = 0;  ///< m: the length that its gaps and penetrations are measured by
  /// m, of curvature at the contact; 0: a sharp corner. Inside a ring and outside discs R_i R_j/|R_i ∓ R_j|.
  double radius = 0;
  bool ring = true;                               ///< a journal inside a bearing
  double radius_bearing = 0, radius_journal = 0;  ///< m, of a ring
  Surface surface;
  std::optional<double> bearing_length;  ///< m
  std::optional<Lubricant> lubricant;
};

template <class T>
using Vec2Of = Eigen::Matrix<T, 2, 1>;

/// A contact's geometry at one state. Without friction the tangent row stays empty. T, here and below, is
/// double, or Gradient for derivatives.
template <class T>
struct ContactRowOf {
  T gap = 0;                       ///< m
  SparseRowOf<T> normal, tangent;  ///< ġ = normal·v, v_T = tangent·v
  /// Only for a lubricated joint: film·v = t·ė − ½(ω_i + ω_j)|e|, the journal's sideways motion relative to
  /// the mean surface, along which the film's tangential force acts (its couples included); spin·v = ω_j −
  /// ω_i.
  SparseRowOf<T> film, spin;
  T gamma_n = 0, gamma_t = 0;  ///< g̈ = normal·a − gamma_n, v̇_T = tangent·a − gamma_t
  template <class M>
  void remember(M& m) {
    m(gap, normal, tangent, film, spin, gamma_n, gamma_t);
  }
};
using ContactRow = ContactRowOf<double>;

/// Coulomb friction of a preloaded joint as the formulations see it.
struct FrictionFacts {
  std::string name;
  double bound = 0;                      ///< N
  std::optional<double> regularisation;  ///< m/s
};

/// Powers of the loads (W): what they put into the mechanism.
template <class T>
struct LoadPower {
  T drive = 0;    ///< torque drives
  T load = 0;     ///< constant forces and torques
  T damping = 0;  ///< dampers, ≤ 0
};

/// What a System computes at one state.
template <class T>
struct EvaluationOf {
  std::vector<T> cosine, sine;       ///< of each body's angle
  std::vector<T> phi, phi_t, gamma;  ///< one per constraint row
  std::vector<T> G;                  ///< values in the order of System::pattern()
  std::vector<T> force;              ///< n
  LoadPower<T> power;
};
using Evaluation = EvaluationOf<double>;
/// A number with its derivatives in four directions at once.
using Gradient = Dual<4>;

class System {
 public:
  explicit System(const Mechanism& mechanism);

  int n() const { return static_cast<int>(mass_.size()); }
  int rows() const { return G_.rows; }
  int contacts() const { return static_cast<int>(contact_facts_.size()); }
  int frictions() const { return static_cast<int>(frictions_.size()); }
  int bodies() const { return n() / 3; }
  const CsrPattern& pattern() const { return G_; }
  const std::vector<double>& mass() const { return mass_; }
  const ContactFacts& contact_facts(int k) const { return contact_facts_[k]; }
  const FrictionFacts& friction_facts(int k) const { return friction_facts_[k]; }
  /// Name of the joint or drive that a constraint row belongs to.
  const std::string& row_name(int row) const { return row_names_[row]; }
  /// Whether a constraint row is measured in rad (else in m).
  bool is_angle_row(int row) const { return angle_rows_[row]; }
  /// Number of rows that prescribe motion; they are the last ones.
  int drive_rows() const { return static_cast<int>(speed_drives_.size()); }
  bool has_friction(int contact) const { return contact_facts(contact).surface.friction.has_value(); }
  /// Whether a coordinate is an angle (rad, else m).
  bool is_angle(int coordinate) const { return coordinate % 3 == 2; }
  /// Whether any load or torque drive does work that is not a change of potential().
  bool has_loads() const {
    return velocity_forces_ || !torque_drives_.empty() || !force_loads_.empty() || !torque_loads_.empty();
  }
  /// Whether a force depends on the velocities (dampers).
  bool has_velocity_forces() const { return velocity_forces_; }
  /// Longest distance of a joint's point from its body's centre of mass (m); 0 when all are central.
  double longest_arm() const { return longest_arm_; }

  template <class T = double>
  EvaluationOf<T> make_evaluation() const;
  /// Fills cosine, sine, phi, phi_t and G.
  template <class T>
  void place(std::type_identity_t<T> t, const T* q, EvaluationOf<T>& e) const;
  /// Fills gamma; needs place().
  template <class T>
  void rate(const T* q, const T* v, EvaluationOf<T>& e) const;
  /// Fills force and power; needs place().
  template <class T>
  void forces(std::type_identity_t<T> t, const T* q, const T* v, const T* z, EvaluationOf<T>& e) const;
  /// First-order states of elements (State::z), in the order of their elements; they begin at 0.
  int states() const { return static_cast<int>(lagged_.size()); }
  /// What errors of state k are measured by, in its own unit.
  double state_scale(int k) const { return lagged_[k].scale; }
  /// ż of the elements' first-order states.
  template <class T>
  void flow(std::type_identity_t<T> t, const T* q, const T* z, T* dz) const;
  /// Gravity and springs (J); constant forces and torques count as loads.
  double potential(const double* q) const;
  double kinetic(const double* v) const;

  /// Gap of contact k alone; needs place().
  double gap(int k, const double* q, const Evaluation& e) const;
  /// All of contact k; needs place(). A concentric journal has no normal: its rows are empty, its gap is c.
  template <class T>
  void contact(int k, const T* q, const T* v, const EvaluationOf<T>& e, ContactRowOf<T>& row) const;
  /// From the first body's point of contact k to the second's, in the world (m): a journal's eccentricity.
  /// Needs place().
  Vec2Of<double> eccentricity(int k, const double* q, const Evaluation& e) const;
  /// Sliding row of a preloaded joint, u = row·v; returns γ in u̇ = row·a − γ. Needs place().
  template <class T>
  T friction(int k, const T* q, const T* v, const EvaluationOf<T>& e, SparseRowOf<T>& row) const;

  /// The first knot of a torque table against time after t (s); infinite when there is none.
  double next_knot(double t) const;

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
                      double ft, double weight, Forces& out) const;
  /// A film in contact k: along its normal and film rows, and a couple along spin.
  void report_film(int k, const double* q, const Evaluation& e, const ContactRow& row, double fn, double ft,
                   double torque, double weight, Forces& out) const;
  /// Coulomb friction of preloaded joint k along its sliding row.
  void report_friction(int k, const double* q, const double* v, const Evaluation& e, const SparseRow& row,
                       double force, double weight, Forces& out) const;
  /// Torque drives and loads at a state.
  void report_loads(double t, const double* q, const double* v, const double* z, const Evaluation& e,
                    double weight, Forces& out) const;
  ///@}

  /// Angle of the main drive's joint (rad), 0 without one.
  double crank_angle(const double* q) const;

 private:
  struct Link {  // two bodies and the arms of a joint's points
    int i = ground, j = ground;
    Vec2 si{0, 0}, sj{0, 0};
  };
  struct PointRows {  // two rows: the points coincide
    Link link;
    int row;
    std::array<int, 2> theta_i, theta_j;  // entries of G that turn with the bodies, −1 where the arm is zero
  };
  struct AngleRow {  // θ_j − θ_i − angle − speed·t
    int i, j, row;
    double angle, speed;
  };
  struct SlideRow {  // no offset across the axis
    Link link;
    Vec2 axis;
    int row;
    bool x = true, y = true;  // which entries of the second body the row has
  };
  struct ContactElement {
    enum class Kind { round, line };  // two circles; a circle or point against a straight wall
    Kind kind = Kind::round;
    Link link;
    double side = 1;  // round: +1 ring, −1 discs; line: free space on the left (+1) or right of the axis
    Vec2 axis{1, 0};  // line: along the wall
    double rest = 0;  // round: |e| at touch; line: what n·d is short of the gap
    double radius_i = 0, radius_j = 0;  // round: R_j < 0 outside each other; line: R_j of the disc
  };
  struct FrictionElement {
    Link link;
    Vec2 axis;
  };
  struct Reaction {  // of an ideal joint or a prescribed speed: rows [begin, end)
    Link link;
    int begin, end, element;
    double speed = 0;  // rad/s, of a drive
  };
  template <class T>
  struct Arms {  // world arms and r_j^P − r_i^P
    Vec2Of<T> ri, rj, d;
  };

  int add_element(const std::string& name, ForceElement::Kind kind, const std::array<int, 2>& bodies,
                  int joint = -1);
  void list_elements(const Mechanism& mechanism);
  template <class T>
  T torque_of(std::size_t drive, const T& t, const T* q, const T* z) const;
  void along(const double* q, const Evaluation& e, const Link& link, const int* column, const double* value,
             int size, double amount, ElementForce& f) const;
  int entry(int column, double constant);
  void end_row(const std::string& name, bool angle);
  void add_points(const Link& link, const std::string& name);
  void add(const RevoluteJoint& joint, const Mechanism& mechanism);
  void add(const TranslationalJoint& joint, const Mechanism& mechanism);
  void add(const RigidJoint& joint);
  void add(const PlaneContact& contact, const Mechanism& mechanism);
  void add(const DiscContact& contact, const Mechanism& mechanism);
  void add_corners(const TranslationalJoint& joint, const Mechanism& mechanism);
  template <class T>
  void round_contact(int k, const Arms<T>& a, const T* v, ContactRowOf<T>& row) const;
  template <class T>
  void line_contact(int k, const Arms<T>& a, const T* v, const EvaluationOf<T>& e,
                    ContactRowOf<T>& row) const;
  void add_angle(int i, int j, double angle, double speed, const std::string& name);
  Link make_link(const std::array<int, 2>& between, const std::array<Vec2, 2>& at);

  template <class T>
  static Vec2Of<T> turned(int body, const Vec2& s, const EvaluationOf<T>& e);
  template <class T>
  static Arms<T> arms(const Link& link, const T* q, const EvaluationOf<T>& e);
  template <class T>
  static Vec2Of<T> relative_velocity(const Link& link, const Arms<T>& a, const T* v);

  std::vector<double> mass_;
  CsrPattern G_;
  std::vector<double> constant_G_;      // entries of G that never change
  std::vector<double> constant_force_;  // gravity
  std::vector<std::string> row_names_;
  std::vector<bool> angle_rows_;
  std::vector<PointRows> points_;
  std::vector<AngleRow> angles_;
  std::vector<SlideRow> slides_;
  std::vector<AngleRow> speed_drives_;
  std::vector<ContactElement> contacts_;
  std::vector<ContactFacts> contact_facts_;
  std::vector<FrictionElement> frictions_;
  std::vector<FrictionFacts> friction_facts_;
  std::vector<std::pair<std::array<int, 2>, TorqueDrive>> torque_drives_;
  struct Lagged {  // a torque drive with a state
    std::size_t drive;
    double scale;  // N m
  };
  std::vector<Lagged> lagged_;
  std::vector<int> state_of_drive_;  // −1: none
  std::vector<ForceLoad> force_loads_;
  std::vector<TorqueLoad> torque_loads_;
  std::vector<std::pair<Link, SpringDamper>> springs_;
  std::vector<TorsionalSpringDamper> torsions_;
  std::vector<ForceElement> force_elements_;
  std::vector<Reaction> reactions_;
  std::vector<int> contact_elements_, friction_elements_, torque_elements_, force_load_elements_,
      torque_load_elements_, spring_elements_, torsion_elements_;  // by their index there
  std::vector<int> contact_joints_;                                // −1: of no joint
  Vec2 gravity_{0, 0};
  std::array<int, 2> crank_{ground, ground};
  bool velocity_forces_ = false;
  double longest_arm_ = 0;
};

}  // namespace freeplay
