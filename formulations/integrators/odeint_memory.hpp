// Serialization of Boost.Odeint's stepper of Bulirsch and Stoer, for snapshots. Odeint has no
// interface to save and restore the order and the step that it keeps: they are in private members, and
// reset() clears only a part of them.
//
// The private members are accessed by a rule of the language: names in the declaration of an
// explicit specialisation are not subject to access control ([temp.spec.general] 6). A
// specialisation for each member takes the pointer to it as its argument, and a friend function
// returns that pointer.
//
// This depends on the internals of one version of Boost. Before allowing another version, check
// bulirsch_stoer_dense_out.hpp for new members.
#pragma once

#include <boost/version.hpp>

#if BOOST_VERSION != 107400
#error "formulations/integrators/odeint_memory.hpp knows the private members of Boost.Odeint 1.74 only"
#endif

#include <algorithm>
#include <boost/numeric/odeint/stepper/bulirsch_stoer_dense_out.hpp>
#include <vector>

#include "formulations/integrators/vector_algebra.hpp"
#include "values/memory.hpp"

namespace freeplay {

using BulirschStoerStepper = boost::numeric::odeint::bulirsch_stoer_dense_out<std::vector<double>>;

namespace odeint_memory {

template <auto Member>
struct Key;
template <auto Member>
constexpr auto member_of(const Key<Member>*) {
  return Member;
}

/// Defines pointer(Class_member{}) as the pointer to that member.
#define FREEPLAY_REVEAL(Class, member)                                                                      \
  struct Class##_##member {};                                                                               \
  constexpr auto pointer(Class##_##member);                                                                 \
  template <>                                                                                               \
  struct Key<&Class::member> {                                                                              \
    friend constexpr auto pointer(Class##_##member) { return member_of(static_cast<const Key*>(nullptr)); } \
  };
FREEPLAY_REVEAL(BulirschStoerStepper, m_last_step_rejected)
FREEPLAY_REVEAL(BulirschStoerStepper, m_first)
FREEPLAY_REVEAL(BulirschStoerStepper, m_t)
FREEPLAY_REVEAL(BulirschStoerStepper, m_dt)
FREEPLAY_REVEAL(BulirschStoerStepper, m_current_k_opt)
FREEPLAY_REVEAL(BulirschStoerStepper, m_k_final)
FREEPLAY_REVEAL(BulirschStoerStepper, m_current_state_x1)
FREEPLAY_REVEAL(BulirschStoerStepper, m_x1)
FREEPLAY_REVEAL(BulirschStoerStepper, m_x2)
FREEPLAY_REVEAL(BulirschStoerStepper, m_dxdt1)
FREEPLAY_REVEAL(BulirschStoerStepper, m_dxdt2)
#undef FREEPLAY_REVEAL

inline void require(bool fits) {
  if (!fits) throw MemoryError("the snapshot's integrator has another size, or is damaged");
}

/// For states like y. The table of the last step, which interpolation uses, is not serialized.
template <class M>
void serialize(M& m, BulirschStoerStepper& stepper, const std::vector<double>& y) {
  auto& x1 = stepper.*pointer(BulirschStoerStepper_m_x1{});
  auto& order = stepper.*pointer(BulirschStoerStepper_m_current_k_opt{});
  bool begun = !x1.m_v.empty();  // otherwise time and step are not set yet
  m(begun, order);
  if constexpr (M::reading) {
    require(order >= 2 && order < BulirschStoerStepper::m_k_max);
    stepper.*pointer(BulirschStoerStepper_m_k_final{}) = 0;
    stepper.adjust_size(y);
  }
  if (!begun) {
    if constexpr (M::reading) stepper.reset();
    return;
  }
  m(stepper.*pointer(BulirschStoerStepper_m_last_step_rejected{}),
    stepper.*pointer(BulirschStoerStepper_m_first{}), stepper.*pointer(BulirschStoerStepper_m_t{}),
    stepper.*pointer(BulirschStoerStepper_m_dt{}),
    stepper.*pointer(BulirschStoerStepper_m_current_state_x1{}));
  for (auto* x : {&x1, &(stepper.*pointer(BulirschStoerStepper_m_x2{})),
                  &(stepper.*pointer(BulirschStoerStepper_m_dxdt1{})),
                  &(stepper.*pointer(BulirschStoerStepper_m_dxdt2{}))}) {
    m(x->m_v);
    if constexpr (M::reading) require(x->m_v.size() == y.size());
  }
}

}  // namespace odeint_memory
}  // namespace freeplay
