// The contacts of time stepping, what each did so far, and which of them take part in a step:
//
//     g_m + (h/2) (W_Nᵀ v⁺ − (h/4) γ_N) ≤ 0            (the gap that the motion without the contact would have)
//
// Rates at a step's ends, with the row W and its γ at the middle and a_γ the accelerations that the constraints' own γ asks for,
// M a_γ + GᵀΛ = 0, G a_γ = γ:
//
//     u⁻ = Wᵀv + (h/2) γ_c,            u⁺ = Wᵀv⁺ − (h/2) γ_c
//     u⁻ = Wᵀ(v + (h/2) a_γ),          u⁺ = Wᵀ(v⁺ − (h/2) a_γ)      where it is in impact: rates at that instant
//
// Contacts of the system have their numbers. Pairs among many bodies (docs/development/decisions/028-groups.md) have a slot behind them as
// long as they are near or in contact, and leave it to another pair then. A pair without a slot cannot touch before the
// list of near pairs is made anew, in the middle of a step if need be (dynamics/neighbours.hpp).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "dynamics/neighbours.hpp"
#include "formulations/time_stepping/impulse_responses.hpp"
#include "formulations/time_stepping/step_data.hpp"

namespace freeplay {

struct StepContact {
  double restitution = 0;
  bool active = false;  // in this step
  bool closed = false;  // StepReach::closed knows it
  bool struck = false;  // in this step: open before, and approaching
  bool held = false;    // in this step: brought back to its gap's zero from either side
  bool soft = false;    // in impact next without restitution: its bounces are over
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

class ContactSet {
 public:
  /// `step`: s, of fixed steps, 0 of adaptive ones. `restitution`: of each contact and behind them of each family.
  ContactSet(const System& system, const std::vector<double>& restitution, double step);
  void start(StepData& step, ImpulseResponses& responses);

  std::vector<StepContact>& all() { return contacts_; }
  const std::vector<StepContact>& all() const { return contacts_; }
  StepContact& operator[](int k) { return contacts_[k]; }
  const StepContact& operator[](int k) const { return contacts_[k]; }
  /// Indices in the order of contact problems: the system's contacts, then pairs in their order.
  const std::vector<int>& live() const { return live_; }
  std::span<const int> seated() const { return std::span(live_).subspan(numbered()); }

  /// @name Which take part
  ///@{
  bool in_reach(const StepContact& c, StepReach reach) const { return reach == StepReach::all || c.closed; }
  /// Rows at the middle of the step from q_old at v_old.
  void look_at_rows(StepData& step, ImpulseResponses& responses);
  /// Before the impulses of a step are looked for: with many contacts those that last take part from the beginning.
  void begin(const StepData& step, bool many);
  /// Adds those whose gap the motion v would have closed by the end of the step. True when one was added.
  bool activate(StepData& step, ImpulseResponses& responses);
  /// Which active contacts are in impact, and the bias of every one's rates. True where one is.
  bool find_struck(StepData& step);
  /// How far a closed contact may stand off and still act (m).
  double slack = 0;
  ///@}

  /// @name Facts of a contact, by its index here
  ///@{
  bool is_seated(int k) const { return k >= system_.contacts(); }
  /// The number that facts, greatest penetration and events are told by: the contact's own or that of its family.
  int told_as(int k) const { return is_seated(k) ? system_.contacts() + pair(k).family : k; }
  const ContactFacts& facts(int k) const { return system_.contact_facts(told_as(k)); }
  double gap(int k, const double* q, const Evaluation& e) const;
  const Neighbours::Pair& pair(int k) const { return slot(k).pair; }
  const Pair& shape(int k) const { return slot(k).shape; }
  ///@}

  /// Sees to it that whatever a step of h from q at v0 to v1 may close has a slot. h = 0: whatever overlaps at q.
  void keep_near(double h, const double* q, const double* v0, const double* v1, StepData& step,
                 ImpulseResponses& responses) {
    if (near_) renew_pairs(h, q, v0, v1, step, responses);
  }

  template <class M>
  void remember(M& m, StepData& step, ImpulseResponses& responses) {
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
    std::vector<int> free;            // slots
    std::vector<int> kept;            // while the list is made
    std::vector<double> restitution;  // of each family
    template <class M>
    void remember(M& m) {
      m(neighbours, free);
      auto size = static_cast<std::uint64_t>(slots.size());
      m(size);
      if constexpr (M::reading) {
        if (size > m.left()) throw MemoryError("the snapshot is cut short");
        slots.resize(size);
      }
      for (auto& s : slots) m(s.pair);
    }
  };
  std::size_t numbered() const { return static_cast<std::size_t>(system_.contacts()); }
  const Slot& slot(int k) const { return near_->slots[static_cast<std::size_t>(k) - numbered()]; }
  void look(int k, const double* q, const double* v, const Evaluation& e, ContactRow& row) const;
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
};

}  // namespace freeplay
