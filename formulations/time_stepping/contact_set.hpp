// ContactSet: the contacts of time stepping, their data, and which of them take part in a step. A
// contact takes part if the motion without it would close its gap,
//
//     g_m + (h/2) (W_Nᵀ v⁺ − (h/4) γ_N) ≤ 0.
//
// The rates at the ends of a step use the row W and its γ at the middle, and the accelerations a_γ
// that the constraints' own γ requires, M a_γ + GᵀΛ = 0, G a_γ = γ:
//
//     u⁻ = Wᵀv + (h/2) γ_c,            u⁺ = Wᵀv⁺ − (h/2) γ_c
//     u⁻ = Wᵀ(v + (h/2) a_γ),          u⁺ = Wᵀ(v⁺ − (h/2) a_γ)    in impact, at that instant
//
// Contacts of the system keep their numbers. Pairs within groups of many bodies
// (docs/development/decisions/028-groups.md) have a slot after them while they are near or in
// contact; the slot is then reused for another pair. A pair without a slot cannot come into contact
// before the list of near pairs is renewed, which may happen in the middle of a step
// (dynamics/families.hpp).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "dynamics/families.hpp"
#include "dynamics/system.hpp"
#include "formulations/time_stepping/step_data.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay {

/// ImpulseResponses: the rows w of a step's contact problems, each at its place, and the responses A
/// w of the mechanism to unit impulses along them (numerics/saddle_point.hpp).
///
/// With few contacts, the responses are dense vectors and row r of a problem has place r. With many
/// contacts, the rows of each contact have their own places, so that responses are computed once per
/// step for all its problems, and responses are stored in sparse form (numerics/saddle_point.hpp).
class ImpulseResponses {
 public:
  /// `rows`: number of rows of all numbered contacts and friction elements; `many`: each row has
  /// its own place.
  ImpulseResponses(const System& system, int rows, bool many);
  bool many() const { return many_; }

  /// Discards the responses after a new factorisation of the saddle point, which must stay at its
  /// address until the next begin().
  void begin(SaddlePoint& saddle);

  SparseRow& row(int place) { return rows_[place]; }
  const SparseRow& row(int place) const { return rows_[place]; }
  const std::vector<SparseRow>& rows() const { return rows_; }
  const Responses& sparse() const { return sparse_; }
  /// @name Places, with many contacts
  ///@{
  /// of its normal row; the tangential one follows
  int first(int contact) const { return first_[contact]; }
  int friction(int k) const { return friction_[k]; }  ///< of a friction element's row
  ///@}

  /// Computes the response to row(place); with many contacts once per step.
  void respond(SaddlePoint& saddle, int place);
  /// Computes the response to row(place) + factor·`beside` (null: none), with its reactions if
  /// contacts are few.
  void respond(SaddlePoint& saddle, int place, const SparseRow* beside, double factor);
  /// `row` · A w of the row at a place.
  double along(const SparseRow& row, int place) const;
  /// x += by A w
  void push(int place, double by, double* x) const;
  /// @name With few contacts: A w, and the multipliers of the constraint rows with it
  ///@{
  double* response(int place) { return response_.data() + static_cast<long>(place) * n_; }
  const double* response(int place) const { return response_.data() + static_cast<long>(place) * n_; }
  double* reaction(int place) { return reaction_.data() + static_cast<long>(place) * m_; }
  const double* reaction(int place) const { return reaction_.data() + static_cast<long>(place) * m_; }
  ///@}

  /// @name Contacts of pairs, with slots after the numbered contacts
  ///@{
  void add_contact();
  /// Removes all contacts after the first `contacts`.
  void keep_contacts(int contacts);
  /// Discards the responses of a contact whose rows are new.
  void renew(int contact);
  ///@}

 private:
  int n_, m_;
  bool many_;
  std::vector<SparseRow> rows_;
  std::vector<double> response_, reaction_;
  Responses sparse_;
  std::vector<char> taken_;  // responses computed in this step
  std::vector<int> first_, friction_;
};

struct StepContact {
  double restitution = 0;
  const Surface* by_speed = nullptr;  // whose restitution depends on the approach speed
  bool active = false;                // takes part in this step
  bool closed = false;                // takes part in steps with StepReach::closed
  bool in_impact = false;             // in impact in this step: it was open before, and approaches
  bool held = false;                  // in this step: its gap is corrected to zero from either side
  bool soft = false;                  // its next impact is without restitution: its bounces have ended
  ContactRow row;
  double gap = 0;  // at the end of the last step
  double u_n_minus = 0, u_t_minus = 0, u_n_plus = 0, u_t_plus = 0;
  double impulse_n = 0, impulse_t = 0;  // since the onset of the present contact
  double last_n = 0, last_t = 0;        // of the last step, the initial guess of the next solve
  double t_onset = 0, t_left = 0;
  double t_pressed = 0;           // end of the last step with an impulse
  int steps = 0;                  // number of steps since the onset of the present contact
  double bias_n = 0, bias_t = 0;  // u⁻ − Wᵀv = Wᵀv⁺ − u⁺
  int unknown = -1;               // index in the contact problem of the step
  /// e at an approach speed (m/s).
  double restitution_at(double approach) const {
    return by_speed ? by_speed->restitution_at(approach) : restitution;
  }
  template <class M>
  void serialize(M& m) {
    m(active, closed, in_impact, held, soft, row, gap, u_n_minus, u_t_minus, u_n_plus, u_t_plus, impulse_n,
      impulse_t, last_n, last_t, t_onset, t_left, t_pressed, steps, bias_n, bias_t, unknown);
  }
};

class ContactSet {
 public:
  /// `step`: fixed step length (s), 0 for adaptive steps. `restitution`: of each contact, followed
  /// by each family of pairs.
  ContactSet(const System& system, const std::vector<double>& restitution, double step);
  void start(StepData& step, ImpulseResponses& responses);

  std::vector<StepContact>& all() { return contacts_; }
  const std::vector<StepContact>& all() const { return contacts_; }
  StepContact& operator[](int k) { return contacts_[k]; }
  const StepContact& operator[](int k) const { return contacts_[k]; }
  /// Indices in the order of contact problems: the system's contacts, then pairs in their order.
  const std::vector<int>& live() const { return live_; }
  std::span<const int> slot_contacts() const { return std::span(live_).subspan(numbered()); }

  /// @name Contacts that take part
  ///@{
  bool in_reach(const StepContact& c, StepReach reach) const { return reach == StepReach::all || c.closed; }
  /// Evaluates the rows at the middle of the step from q_old at v_old.
  void look_at_rows(StepData& step, ImpulseResponses& responses);
  /// Called before the impulses of a step are computed. With many contacts, contacts that were
  /// pressed in the last steps take part from the beginning.
  void begin(const StepData& step, bool many);
  /// Adds contacts whose gaps the motion v would have closed by the end of the step. Returns true
  /// if any was added.
  bool activate(StepData& step, ImpulseResponses& responses);
  /// Whether contacts might still be added.
  bool waiting() const { return waiting_; }
  /// Determines which active contacts are in impact, and the rate bias of all. Returns true if any
  /// is in impact.
  bool find_impacts(StepData& step);
  /// Whether the restitution of a contact depends on its approach speed.
  bool restitution_by_speed() const { return by_speed_; }
  /// Gap (m) up to which a closed contact still takes part.
  double slack = 0;
  ///@}

  /// @name Facts of a contact, by its index in this set
  ///@{
  bool has_slot(int k) const { return k >= system_.contacts(); }
  /// The number for facts, greatest penetration and events: the contact's own number or that of its
  /// family.
  int reported_index(int k) const { return has_slot(k) ? system_.contacts() + pair(k).family : k; }
  const ContactFacts& facts(int k) const { return system_.contact_facts(reported_index(k)); }
  double gap(int k, const double* q, const Evaluation& e) const;
  const Neighbours::Pair& pair(int k) const { return slot(k).pair; }
  const Pair& shape(int k) const { return slot(k).shape; }
  ///@}

  /// Ensures that each pair that a step of h from q at v0 to v1 may close has a slot. With h = 0:
  /// each pair that overlaps at q.
  void keep_near(double h, const double* q, const double* v0, const double* v1, StepData& step,
                 ImpulseResponses& responses) {
    if (near_) renew_pairs(h, q, v0, v1, step, responses);
  }

  template <class M>
  void serialize(M& m, StepData& step, ImpulseResponses& responses) {
    if (near_) {
      m(*near_, live_);
      if constexpr (M::reading) take_slots_again(step, responses);
    }
    for (auto& c : contacts_) m(c);
  }

 private:
  struct Slot {
    Neighbours::Pair pair;
    Pair shape;
  };
  struct Near {
    explicit Near(const System& system) : neighbours(system.families()) {}
    Neighbours neighbours;
    std::vector<Slot> slots;
    std::vector<int> free;            // unused slots
    std::vector<int> kept;            // work space while the list is renewed
    std::vector<double> restitution;  // of each family
    template <class M>
    void serialize(M& m) {
      m(neighbours, free);
      auto size = static_cast<std::uint64_t>(slots.size());
      m(size);
      if constexpr (M::reading) {
        if (size > m.left()) throw MemoryError("the snapshot is incomplete");
        slots.resize(size);
      }
      for (auto& s : slots) m(s.pair);
    }
  };
  std::size_t numbered() const { return static_cast<std::size_t>(system_.contacts()); }
  const Slot& slot(int k) const { return near_->slots[static_cast<std::size_t>(k) - numbered()]; }
  void look(int k, const double* q, const double* v, const Evaluation& e, ContactRow& row) const;
  void set_restitution(int k, double restitution);
  void renew_pairs(double h, const double* q, const double* v0, const double* v1, StepData& step,
                   ImpulseResponses& responses);
  void give_slots(const double* q, StepData& step, ImpulseResponses& responses);
  void take_slots_again(StepData& step, ImpulseResponses& responses);
  int new_slot(StepData& step, ImpulseResponses& responses);

  const System& system_;
  double step_;
  std::vector<StepContact> contacts_;
  std::vector<int> live_;
  std::unique_ptr<Near> near_;
  std::vector<double> a_gamma_;
  bool waiting_ = false, by_speed_ = false;
};

}  // namespace freeplay
