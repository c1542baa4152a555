// Moreau–Jean time stepping with θ = ½ (Moreau 1988; Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235),
// second order on smooth stretches. With q_m = q + (h/2) v and everything evaluated at (q_m, t + h/2):
//
//     M (v⁺ − v) + GᵀΛ = h f + W P
//     G v⁺ + Φ_t = (h/2) γ                       (the rate of Φ at the end of the step)
//     u⁻ = Wᵀv + (h/2) γ_c,   u⁺ = Wᵀv⁺ − (h/2) γ_c   (rates of the gaps at the step's ends)
//     u⁻ = Wᵀ(v + (h/2) a_γ),   u⁺ = Wᵀ(v⁺ − (h/2) a_γ)   (where it is struck: rates at the instant of the impact)
//     0 ≤ u_N⁺ + e u_N⁻ ⊥ P_N ≥ 0,   −P_T ∈ μ P_N Sgn(u_T⁺)
//     q⁺ = q_m + (h/2) v⁺
//
// Friction that its joint's reaction bounds, −P_T ∈ μ S(Λ) Sgn(u_T⁺) (dynamics/reaction_bound.hpp), has the bound that the
// impulses Λ of this very step give, those of impacts among them: bounds and impulses are iterated until they agree
// (bound_iteration.hpp). μ is that of the mean of the sliding speeds at the step's ends.
//
// with a_γ the accelerations that the constraints' own γ asks for: M a_γ + GᵀΛ = 0, G a_γ = γ. Without them v is
// not a motion of the middle of the step, and restitution is wrong by hω; with γ_c instead normals that turn would
// be struck by (1 − e)(h/2)γ_c. Where the law takes in the contacts that the motion would close without them.
// Films of lubricated joints are smooth forces, implicit in the velocities (film_step.hpp).
// First-order states of elements take the same midpoint, z⁺ = z + h ż(t + h/2, q_m, (z + z⁺)/2).
// Then positions are brought back: the least mass-weighted movement onto Φ = 0 and g ≥ 0, velocities
// untouched.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "dynamics/neighbours.hpp"
#include "dynamics/system.hpp"
#include "formulations/contact/bound_iteration.hpp"
#include "formulations/contact/contact_islands.hpp"
#include "formulations/contact/contact_problem.hpp"
#include "formulations/contact/coupled_friction.hpp"
#include "formulations/time_stepping/film_step.hpp"
#include "mechanism/options.hpp"
#include "numerics/saddle_point.hpp"
#include "simulation/formulation.hpp"

namespace freeplay {

class MoreauStepper {
 public:
  /// `step`: s, of step(); only advance() is used where it is 0. `restitution`: e of each contact. `facts`: of the
  /// constraint rows.
  MoreauStepper(const System& system, const NonsmoothOptions& options, double step,
                std::vector<double> restitution, RowFacts facts);

  void start(const State& state, ContactLog& log);
  /// One step of the fixed length, or up to t_end.
  bool step(double t_end);
  const std::string& failure() const { return failure_; }

  /// @name For a controller of steps
  ///@{
  /// Which contacts may act in a step: all whose gap it would close, by the impact law; or those that are held to be
  /// closed alone, without restitution, so that the step is smooth.
  enum class Reach { all, closed };
  /// One step to t_new.
  bool advance(double t_new, Reach reach);
  struct Contact {
    double restitution = 0;
    bool active = false;  // in this step
    bool closed = false;  // Reach::closed knows it
    bool struck = false;  // in this step: open before, and approaching
    bool held = false;    // in this step: brought back to its gap's zero from either side
    bool soft = false;    // struck next without restitution: its hops are over
    ContactRow row;
    double gap = 0;  // at the end of the last step
    double u_n_minus = 0, u_t_minus = 0, u_n_plus = 0, u_t_plus = 0;
    double impulse_n = 0, impulse_t = 0;  // of the present episode
    double last_n = 0, last_t = 0;        // of the last step, to start the next solve from
    double t_touch = 0, t_left = 0;
    double t_pressed = 0;           // end of the last step with an impulse
    int steps = 0;                  // of the present episode
    double bias_n = 0, bias_t = 0;  // u⁻ − Wᵀv = Wᵀv⁺ − u⁺
    int unknown = -1;               // in the step's contact problem
    template <class M>
    void remember(M& m) {
      m(active, closed, struck, held, soft, row, gap, u_n_minus, u_t_minus, u_n_plus, u_t_plus, impulse_n,
        impulse_t, last_n, last_t, t_touch, t_left, t_pressed, steps, bias_n, bias_t, unknown);
    }
  };
  /// All that a step changes but the work done: what a refused step must give back.
  struct Place {
    std::vector<double> q, v, z, slide_last;
    std::vector<Contact> contacts;
    ContactLog log;
    EnergyLedger integrals;
    Extremes extremes;
    double t = 0;
    long events = 0, jams = 0, undecided = 0, unswept = 0, inelastic = 0, locked = 0;
    double locked_since = 0, slide_scale = 0;
    std::string motions, jam;
  };
  void keep(Place& place) const;
  void go_back(const Place& place);
  /// The end of two half steps, from the same place as one step that ended at `whole`: Richardson's extrapolation of
  /// state and energies.
  void extrapolate(const Place& whole);
  std::vector<Contact>& contacts() { return contacts_; }
  const std::vector<Contact>& contacts() const { return contacts_; }
  /// What every contact and preloaded joint did in the last step: open, pressed and sticking, sliding either way.
  void modes(std::vector<signed char>& list) const;
  /// The greatest sliding rate (m/s) that the last step may have wrong as friction had the direction of its end all along:
  /// that at its beginning of what slides the other way at its end; what the step would have given to what it stopped and
  /// friction cannot hold.
  double turned_round() const;
  /// What is pressed on the whole of the last step and of the one before, with impulses `first`, but by the forces' own course would
  /// have pulled at an end of the two: the rate (m/s) that it took for it.
  double lifted(const std::vector<double>& first) const;
  /// Logs the loss of what is no longer closed, which the next step would do.
  void leave_all_open();
  /// How far a closed contact may stand off and still act (m).
  void set_slack(double slack) { slack_ = slack; }
  Work& work() { return work_; }
  Extremes& extremes() { return extremes_; }
  EnergyLedger& integrals() { return integrals_; }
  /// Impulses of the last step but its impacts; with within() all.
  const Forces& smooth() const { return smooth_; }
  const Evaluation& end() const { return end_; }  ///< placed at the end of the last step
  ///@}

  template <class M>
  void remember(M& m) {
    m.part("moreau-jean");
    if (near_) {
      m(*near_, live_);
      if constexpr (M::reading) seat_again();
    }
    for (auto& c : contacts_) m(c);
    m(saddle_, slide_last_, q_, v_, q_old_, v_old_, v_trial_, z_, t_, t_old_, t_start_, index_, integrals_,
      extremes_, work_, flights_, passage_, bend_, motions_, jam_, jams_, undecided_, unswept_, inelastic_,
      locked_, locked_since_, problem_.modes_left, position_problem_.modes_left, slack_, films_.leap,
      unsettled_);
  }

  double t() const { return t_; }
  double t_old() const { return t_old_; }
  const double* v() const { return v_.data(); }
  const double* v_old() const { return v_old_.data(); }
  void interpolate(double t, double* q, double* v) const;
  /// The impacts of the last step, at their touches' mean by normal impulse.
  Struck struck() const {
    if (!struck_) return {t_, {}};
    return {struck_t_, struck_v_};
  }

  const double* q() const { return q_.data(); }
  std::span<const double> z() const { return z_; }
  /// Of the last step, its impacts among it: impulses over its length.
  std::span<const double> multipliers() const { return lambda_; }

  /// @name Forces; see Step. A step knows its impulses alone: its forces are these over its length.
  ///@{
  void watch_forces(bool on);
  void forces(double t, Forces& out);
  void add_impulse(double a, double b, Forces& sum) const;
  const Forces& before() const { return nothing_; }
  const Forces& within() const { return within_; }
  ///@}
  const EnergyLedger& integrals() const { return integrals_; }
  /// J, of drives and of loads.
  std::array<double, 2> outside_work() const { return {integrals_.drive, integrals_.load}; }
  const Extremes& extremes() const { return extremes_; }
  /// What a reader of the results must know of this run's contacts.
  void tell(std::vector<std::string>& notes) const;
  const Work& work() const { return work_; }
  /// The greatest share of what a contact could pass through that it moved in one step, and which it was.
  struct Passage {
    double share = 0;
    int contact = -1;
    template <class M>
    void remember(M& m) {
      m(share, contact);
    }
  };
  const Passage& passage() const { return passage_; }
  /// By how much of its greatest value a curve departed from a straight line within one step at most, over what it may, and
  /// which it was.
  struct Bend {
    double share = 0, over = 0;
    int reader = -1;
    template <class M>
    void remember(M& m) {
      m(share, over, reader);
    }
  };
  bool singular() const { return saddle_.singular(); }
  double nearest_singular() const { return saddle_.nearest_singular(); }

 private:
  /// The key whose smaller value shortens the steps.
  const char* finer() const { return step_ > 0 ? "nonsmooth.step" : "nonsmooth.step_tolerance"; }
  bool advance_states(double h, const double* v_mean);
  bool solve_velocities(double h, const double* v_force);
  bool solve_contacts();
  ContactSolution solve_laws();
  ContactSolution solve_bounds();
  ContactSolution settle_bounds(const Eigen::VectorXd& first);
  void follow_bounds();
  bool laws_hold(double share) const;
  void look_at_end(double h);
  void hold_driven();
  bool strip_restitution();
  void tell_painleve(const ContactSolution& result);
  bool activate(double h);
  /// @name Contacts by their place in contacts_: those of the system, then seats of pairs that are near (moreau_near.cpp)
  ///@{
  bool seated(int k) const { return k >= system_.contacts(); }
  /// The number that facts, greatest penetration and events are told by: the contact's own or that of its family.
  int told_as(int k) const { return seated(k) ? system_.contacts() + pair_of(k).family : k; }
  const ContactFacts& facts_of(int k) const { return system_.contact_facts(told_as(k)); }
  void look(int k, const double* q, const double* v, const Evaluation& e, ContactRow& row) const;
  double gap_of(int k, const double* q, const Evaluation& e) const;
  const Neighbours::Pair& pair_of(int k) const;
  void keep_near(double h, const double* q, const double* v0, const double* v1);
  void seat(const double* q);
  void seat_again();
  int new_seat();
  void make_room();
  ///@}
  void collect(double h);
  bool find_struck(double h);
  int add_row(const SparseRow& row, double end_rate_bias, int place);
  /// @name Rows and the responses to them, by their places in rows_
  ///@{
  int place_of(int row) const { return many_ ? many_->place[row] : row; }
  const SparseRow& row_of(int row) const { return rows_[place_of(row)]; }
  void respond(int place);
  void respond(int place, const SparseRow* beside, double factor);
  double along(const SparseRow& row, int place) const;
  void push(int place, double by, double* x) const;
  ///@}
  double rate_of(int row) const { return many_ ? many_->islands.rate(row) : problem_.rate(row); }
  double delassus(int r, int s) const { return many_ ? many_->islands.D(r, s) : problem_.D(r, s); }
  ContactSolution solve_islands();
  void react_to_all();
  bool bring_back(double t_new);
  double rounding_of_places() const;
  void compromise();
  bool hold_lasting();
  void draw_closed(double t_new);
  void book_leads();
  bool meet_rates();
  /// Everything that a Place holds, named once.
  template <class Self, class P, class Copy>
  static void each_kept(Self& stepper, P& place, Copy copy);
  bool in_reach(const Contact& c) const { return reach_ == Reach::all || c.closed; }
  void account(double h);
  void book(double h);
  void log_contacts(double h);
  void keep_struck();
  static double left_out(const Contact& c);
  bool leaves(const Contact& c, double h) const;
  void log_leave(int k);
  void keep_flight(double approach, double steps);
  void keep_passage(double h);
  void keep_bend();
  const double* response(int row) const { return response_.data() + static_cast<long>(row) * system_.n(); }
  double* response(int row) { return response_.data() + static_cast<long>(row) * system_.n(); }
  double* reaction(int row) { return reaction_.data() + static_cast<long>(row) * system_.rows(); }

  /// What mechanisms of many contacts have in place of a dense D and whole responses. Each contact's rows have their own
  /// places in rows_, so that what a step has computed of them serves all its contact problems.
  struct Many {
    Many(const SaddlePoint& saddle, const System& system, const NonsmoothOptions& options, int rows);
    void begin(SaddlePoint& saddle);
    Responses responses;
    ContactIslands islands, positions;
    std::vector<int> first;      // place of each contact's normal row
    std::vector<int> friction;   // of each friction element's
    std::vector<int> place, id;  // of each row and unknown of the present problem
    std::vector<char> taken;     // responses of this step
  };

  /// Pairs of the system's families that are near: each has a seat in contacts_ behind the system's own, which it keeps as
  /// long as it is near or in contact, and leaves to another.
  struct Near {
    explicit Near(const System& system) : neighbours(system.families()) {}
    struct Seat {
      Neighbours::Pair pair;
      Pair shape;
    };
    Neighbours neighbours;
    std::vector<Seat> seats;
    std::vector<int> free;            // seats
    std::vector<int> kept;            // while the list is made
    std::vector<double> restitution;  // of each family
    template <class M>
    void remember(M& m) {
      m(neighbours, free);
      auto size = static_cast<std::uint64_t>(seats.size());
      m(size);
      if constexpr (M::reading) {
        if (size > m.left()) throw MemoryError("the snapshot is cut short");
        seats.resize(size);
      }
      for (auto& s : seats) m(s.pair);
    }
  };

  using Multipliers = SaddlePoint::Multipliers;

  const System& system_;
  double step_;  // s, fixed; 0: controlled from outside
  SaddlePoint saddle_;
  Evaluation e_, end_;
  ContactProblem problem_, position_problem_;
  std::vector<Contact> contacts_;
  std::unique_ptr<Near> near_;
  std::vector<int>
      live_;  // of contacts_, in the order of problems: the system's, then those that are seated by their pairs
  FilmStep films_;
  std::vector<SparseRow> slides_, rows_;
  std::unique_ptr<Many> many_;
  CoupledFriction coupled_;  // friction that its joint's reaction bounds: how far that feeds on itself
  BoundIteration bounds_;
  std::vector<double> q_end_, v_end_,
      taken_back_;              // what meet_rates() will do, and where it finds the step's end
  std::vector<double> driven_;  // of each friction's row: > 0, no force moves it, for its rate is prescribed
  Eigen::VectorXd bound_image_, bound_start_;
  std::vector<ContactUnknown> found_;  // one motion, while others are looked for
  /// Multipliers of eliminated rows are found once, from the velocities that all impulses give. Not where they are asked for while
  /// impulses are looked for, nor where react_to_all() finds them.
  bool late_multipliers_ = false;
  bool redundant_;                                   // rows depend on each other from the start on
  ContactRow end_row_;                               // what meet_rates() looks at
  std::vector<double> end_impulse_, least_impulse_;  // N s, of its rows, and how far back they may go
  std::vector<double> slope_;                        // friction's impulse over the normal one, along
  std::vector<SparseRow> along_;
  std::vector<int> held_;  // the unknown whose friction holds what slides along a row, −1: none
  std::vector<double> slide_gamma_, slide_last_;  // slide_last_: impulses of the last step
  std::vector<double> response_,
      reaction_;  // A W and its multipliers, one column for each row of the problem
  std::vector<double> q_, v_, q_old_, v_old_, q_mid_, v_mean_, v_trial_, v_free_, lambda_free_, force_, r_,
      lambda_, dq_, lambda_dq_, a_gamma_;
  std::vector<double> z_, z_mid_, flow_;  // first-order states of elements, and their rates at mid-step
  double t_ = 0, t_old_ = 0, t_start_ = 0;
  long index_ = 0;
  Reach reach_ = Reach::all;
  double slack_ = 0;
  ContactLog* log_ = nullptr;
  EnergyLedger integrals_;
  Extremes extremes_;
  Work work_;
  bool struck_ = false;              // a contact was touched in this step
  double struck_t_ = 0;              // s
  std::vector<double> struck_v_;     // what that did to the velocities
  std::array<double, 128> flights_;  // steps of the shortest flight, by the binary exponent of the approach
  Passage passage_;
  Bend bend_;
  std::vector<double> greatest_;  // |y| of each curve that is read
  std::vector<int> passing_;      // contacts that something may pass through
  std::string failure_;
  std::string motions_, jam_;  // of the first problem with more motions than one, and of the first jam
  long jams_ = 0, undecided_ = 0;
  long unsettled_ = 0;       // fixed steps whose films were not met
  long unswept_ = 0;         // steps over a table whose sweep did not settle
  long inelastic_ = 0;       // steps whose impacts were taken without restitution
  long locked_ = 0;          // problems in which friction in joints outgrows the reactions that bound it
  double slide_scale_ = 0;   // m/s, the fastest that joints with friction have slid
  double locked_since_ = 0;  // s, the first of them
  bool watching_ = false;
  Forces nothing_, smooth_, within_;  // impulses of the last step: without its impacts, and theirs
  std::vector<double> struck_lambda_, smooth_lambda_;
  std::vector<double> z_old_;  // at the step's beginning, where flows depend on velocities
};

}  // namespace freeplay
