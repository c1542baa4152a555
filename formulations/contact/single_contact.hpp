// The laws of one contact and of one joint friction in closed form. The same text gives numbers
// (solvers.cpp, contact_equations.hpp) and the operations of compiled steps
// (time_stepping/lane_trace.cpp): T is double or Traced.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "numerics/choice.hpp"

namespace freeplay {

/// Relative determinant, (D_NN D_TT − D_NT²)/(D_NN D_TT), below which both rows of a contact depend
/// on one freedom.
inline constexpr double same_freedom = 1e-12;

/// A contact alone in its problem (contact_equations.hpp).
template <class T>
struct SingleContact {
  T nn, nt, tt;              ///< D_NN, D_NT, D_TT
  T bn, bt;                  ///< m/s, rates without its impulses
  T target_n, target_t = 0;  ///< m/s
  T friction = 0;            ///< μ
  T bound = 0;               ///< N s, friction without normal impulse
  T determinant() const { return nn * tt - nt * nt; }
};

/// Impulses of a contact (N s).
template <class T>
struct ContactImpulses {
  T normal = 0, tangent = 0;
};

/// A case of the laws: its impulses, and whether they satisfy the laws.
template <class T>
struct ContactCase {
  ContactImpulses<T> P;
  ConditionOf<T> holds;
};

template <class T>
ContactCase<T> sticking(const SingleContact<T>& c, const T& determinant) {
  using std::abs;
  const T bn = c.bn - c.target_n, bt = c.bt - c.target_t;
  const T Pn = (-bn * c.tt + bt * c.nt) / determinant, Pt = (-bt * c.nn + bn * c.nt) / determinant;
  return {{Pn, Pt}, both(is_at_most(T(0), Pn), is_at_most(abs(Pt), c.bound + c.friction * Pn))};
}

/// Sliding with u_T of the sign `side`, ±1. `slope`: D_NN ∓ μ D_NT; `rate`: |u_T|, negative if the contact
/// would slide the other way.
template <class T>
struct Sliding {
  ContactImpulses<T> P;
  T slope, rate;
  ConditionOf<T> holds() const {
    return both(is_below(T(0), slope), both(is_at_most(T(0), P.normal), is_at_most(T(0), rate)));
  }
};
template <class T>
Sliding<T> sliding(const SingleContact<T>& c, double side) {
  const T bn = c.bn - c.target_n, bt = c.bt - c.target_t;
  const T slope = c.nn - T(side) * c.friction * c.nt, Pn = (-bn + T(side) * c.bound * c.nt) / slope,
          Pt = -T(side) * (c.bound + c.friction * Pn);
  return {{Pn, Pt}, slope, T(side) * (bt + c.nt * Pn + c.tt * Pt)};
}

/// The case of a pressed contact whose rows do not depend on one freedom: the first one that holds.
template <class T>
ContactCase<T> pressed(const SingleContact<T>& c, const T& determinant) {
  const auto first_of = [](const ContactCase<T>& a, auto rest) -> ContactCase<T> {
    if constexpr (is_traced<T>) {
      const ContactCase<T> b = rest();
      return {{select(a.holds, a.P.normal, b.P.normal), select(a.holds, a.P.tangent, b.P.tangent)},
              either(a.holds, b.holds)};
    } else {
      return a.holds ? a : rest();
    }
  };
  return first_of(sticking(c, determinant), [&] {
    const auto right = sliding(c, 1);
    return first_of({right.P, right.holds()}, [&] {
      const auto left = sliding(c, -1);
      return ContactCase<T>{left.P, left.holds()};
    });
  });
}

/// Impulse of a joint friction of bound B (N s) alone, or of a contact's friction without normal impulse.
template <class T>
T friction_impulse(const T& D, const T& b, const T& bound) {
  const T stick = -b / D;
  return choose(
      is_below(stick, -bound), [&] { return T(-bound); },
      [&] {
        return choose(
            is_below(bound, stick), [&] { return bound; }, [&] { return stick; });
      });
}

/// Distance of a normal row from the nearer case of its law, as a rate. `rate`: u_N⁺ less its target.
template <class T>
T normal_residual(const T& D, const T& P, const T& rate) {
  using std::abs;
  return least<T>(abs(D) * P, rate);
}
/// The same of a row with friction of the bound B: −P ∈ B Sgn(u) means u = 0, or |P| = B opposed to u; and
/// the excess of |P| over B. `rate`: u_T⁺ less its target.
template <class T>
std::array<T, 2> friction_residuals(const T& D, const T& P, const T& rate, const T& bound) {
  using std::abs, std::max;
  const T limit = choose(
      is_below(rate, T(0)), [&] { return T(-bound); }, [&] { return bound; });
  return {least<T>(abs(rate), D * abs(P + limit)), D * max(T(0), abs(P) - bound)};
}

}  // namespace freeplay
