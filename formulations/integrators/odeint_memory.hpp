// Serialization of Boost.Odeint's multistep steppers, for snapshots. Odeint has no interface to
// save and restore the history of such a stepper: it is in private members, and reset() clears only
// a part of it. Adams' method keeps its table of differences, and the errors of other orders (some
// of them from before the last reset), by which it chooses the next order. The method of Bulirsch
// and Stoer keeps its order.
//
// The private members are accessed by a rule of the language: names in the declaration of an
// explicit specialisation are not subject to access control ([temp.spec.general] 6). A
// specialisation for each member takes the pointer to it as its argument, and a friend function
// returns that pointer.
//
// This depends on the internals of one version of Boost. Before allowing another version, check
// bulirsch_stoer_dense_out.hpp, controlled_adams_bashforth_moulton.hpp,
// adaptive_adams_bashforth_moulton.hpp and detail/adaptive_adams_coefficients.hpp for new members.
#pragma once

#include <boost/version.hpp>

#if BOOST_VERSION != 107400
#error "formulations/integrators/odeint_memory.hpp knows the private members of Boost.Odeint 1.74 only"
#endif

#include <algorithm>
#include <boost/numeric/odeint/stepper/adaptive_adams_bashforth_moulton.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer_dense_out.hpp>
#include <boost/numeric/odeint/stepper/controlled_adams_bashforth_moulton.hpp>
#include <cmath>
#include <vector>

#include "formulations/integrators/vector_algebra.hpp"
#include "values/memory.hpp"

namespace freeplay {

/// Step control on the greatest scaled error; a step is accepted if the proposed step is at least
/// 0.9 of it.
struct AdamsAdjuster {
  double tolerance = 1e-8;
  double adjust_stepsize(std::size_t steps, double dt, std::vector<double>& error, const std::vector<double>&,
                         const std::vector<double>&) {
    constexpr double refused = 1e10;
    double ratio = 0;
    for (const double e : error) {
      const double share = std::abs(e) / tolerance;
      ratio = share < refused ? std::max(ratio, share) : refused;
      if (!(share < refused)) break;  // a component that is not finite rejects the step
    }
    const double factor = 0.9 * std::pow(ratio, -1.0 / (static_cast<double>(steps) + 1));
    return dt * std::min(ratio <= 1 ? std::max(1.0, 0.9 * factor) : factor, 2.0);
  }
  static double threshold() { return 0.9; }
};

using AdamsTable = boost::numeric::odeint::adaptive_adams_bashforth_moulton<8, std::vector<double>>;
using AdamsCoefficients = AdamsTable::coeff_type;
using AdamsStepper = boost::numeric::odeint::controlled_adams_bashforth_moulton<AdamsTable, AdamsAdjuster>;
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
FREEPLAY_REVEAL(AdamsStepper, m_stepper)
FREEPLAY_REVEAL(AdamsStepper, m_xerr)
FREEPLAY_REVEAL(AdamsCoefficients, m_ns)
FREEPLAY_REVEAL(AdamsCoefficients, m_time_storage)
FREEPLAY_REVEAL(AdamsCoefficients, c)
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

/// For a state of `size` components. Unset entries of an unfinished table are serialized as they
/// are.
template <class M>
void serialize(M& m, AdamsStepper& stepper, std::size_t size) {
  auto& k = (stepper.*pointer(AdamsStepper_m_stepper{})).coeff();
  auto& steps_alike = k.*pointer(AdamsCoefficients_m_ns{});
  m(k.m_eo, k.m_steps_init, steps_alike);
  if constexpr (M::reading) {
    constexpr std::size_t order = AdamsTable::order_value;
    require(k.m_eo >= 1 && k.m_eo <= order && k.m_steps_init >= 1 && k.m_steps_init <= order + 1 &&
            steps_alike <= order + 2);
  }
  // Rotating buffers: in their own order, wherever they begin.
  const auto vector = [&](auto& wrapped) {
    // A vector not yet sized by Odeint is serialized as zeros, its later content. Odeint sizes each
    // vector only once, and a vector restored into a used stepper must not shrink.
    if (M::reading || !wrapped.m_v.empty()) {
      m(wrapped.m_v);
    } else {
      std::vector<double> zeros(size);
      m(zeros);
    }
    if constexpr (M::reading) require(wrapped.m_v.size() == size);
  };
  const auto numbers = [&](auto& values) {
    for (std::size_t i = 0; i < values.size(); ++i) m(values[i]);
  };
  for (std::size_t i = 0; i < k.beta.size(); ++i) numbers(k.beta[i]);
  for (std::size_t i = 0; i < k.phi.size(); ++i)
    for (auto& difference : k.phi[i]) vector(difference);
  numbers(k.g);
  numbers(k.*pointer(AdamsCoefficients_m_time_storage{}));
  numbers(k.*pointer(AdamsCoefficients_c{}));
  // One of these remains from the last step in which it was known; the choice of the order reads
  // it.
  for (auto& error : stepper.*pointer(AdamsStepper_m_xerr{})) vector(error);
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
