// The restitution ê that a free impact on F = K δⁿ (1 + χ δ̇/v₀) delivers, for any K, n and mass:
//
//     χ (1 + ê) = ln[(1 + χ)/(1 − χ ê)],       0 < ê < min(1, 1/χ).
//
// Divide m δ̇ dδ̇ = −F dδ by the bracket and integrate δ̇ from v₀ to −ê v₀: the loop ∮ K δⁿ dδ
// vanishes. The equation has the trivial root ê = −1 and, for small χ, terms that cancel to second
// order.
// With
//
//     h(x) = (x − ln(1 + x))/x² = ½ − x/3 + x²/4 − …      it reads      h(χ) = ê² h(−χ ê),
//
// whose terms are of order one and whose difference falls monotonically in ê and in χ: bisection is
// safe.
// Sign convention: δ > 0 penetration, v₀ > 0 approach speed, ê ≥ 0 the ratio of separation to
// approach speed.
// Units: m, kg, s, K in N/mⁿ; χ and ê are dimensionless.
// Source: the separation of variables of Hunt and Crossley, J. Appl. Mech. 42 (1975) 440, and
// Gonthier, McPhee, Lange, Piedbœuf, Multibody Syst. Dyn. 11 (2004) 209.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace freeplay::reference {

/// h(x) = (x − ln(1 + x))/x², x > −1.
inline long double separation_kernel(long double x) {
  if (std::abs(x) >= 0.05L) return (x - std::log1p(x)) / (x * x);
  long double sum = 0;  // 0.05^16 is below the rounding of long double
  for (int k = 16; k >= 0; --k) sum = 1.0L / (k + 2) - x * sum;
  return sum;
}

/// The x in (low, high) where the falling function f changes sign, by bisection down to
/// neighbouring numbers.
template <class Function>
long double bisect_falling(Function f, long double low, long double high) {
  for (;;) {
    const long double middle = low + (high - low) / 2;
    if (middle <= low || middle >= high) return middle;
    (f(middle) > 0 ? low : high) = middle;
  }
}

/// ê from χ ≥ 0.
inline long double delivered_restitution(long double chi) {
  if (!(chi >= 0)) throw std::invalid_argument("delivered_restitution: need χ ≥ 0");
  if (chi == 0) return 1;
  const auto f = [chi](long double e) {
    return chi * e >= 1 ? -1.0L : separation_kernel(chi) - e * e * separation_kernel(-chi * e);
  };
  return bisect_falling(f, 0, chi > 1 ? 1 / chi : 1);
}

/// The χ that delivers ê, 0 < ê ≤ 1: the exact law. Its absolute error is a few roundings of long
/// double.
inline long double exact_chi(long double e) {
  if (!(e > 0 && e <= 1)) throw std::invalid_argument("exact_chi: need 0 < ê ≤ 1");
  if (e == 1) return 0;
  const auto f = [e](long double chi) {
    return chi * e >= 1 ? -1.0L : separation_kernel(chi) - e * e * separation_kernel(-chi * e);
  };
  return bisect_falling(f, 0, 1 / e);
}

/// One published law: its χ(e) and the ê that it delivers for the required restitutions of
/// delivered_table_e.
struct DampingLaw {
  const char* name;
  double (*chi)(double e);
  std::array<double, 6> delivered;
  double digit;  ///< last digit kept in the row
};
inline constexpr std::array<double, 6> delivered_table_e{0.1, 0.3, 0.46, 0.5, 0.7, 0.9};

/// Rows computed by an independent program, rounded to the digits shown; the first value of Zhiying
/// and Qishao was printed there as .218, a wrong rounding of 0.21747. Sources of χ(e): Hunt and
/// Crossley 1975; Herbert and McWhannell 1977; Lee and Wang 1983; Lankarani and Nikravesh 1990;
/// Gonthier et al. 2004 (closed form); Zhiying and Qishao 2006; Flores et al. 2011; Hu and Guo
/// 2015; Carvalho and Martins 2019; Gharib and Hurmuzlu 2012.
inline const std::array<DampingLaw, 10> delivered_table{{
    {"hunt-crossley",
     [](double e) { return 3 * (1 - e) / 2; },
     {.51583, .58129, .64504, .66296, .76800, .90902},
     1e-5},
    {"herbert-mcwhannell",
     [](double e) { return 6 * (1 - e) / ((2 * e - 1) * (2 * e - 1) + 3); },
     {.491, .520, .575, .594, .723, .901},
     1e-3},
    {"lee-wang", [](double e) { return 3 * (1 - e) / 4; }, {.687, .739, .786, .799, .869, .952}, 1e-3},
    {"lankarani-nikravesh",
     [](double e) { return 3 * (1 - e * e) / 4; },
     {.66527, .68422, .71499, .72524, .79597, .91318},
     1e-5},
    {"gonthier", [](double e) { return (1 - e * e) / e; }, {.101, .304, .452, .488, .670, .876}, 1e-3},
    {"zhiying-qishao",
     [](double e) { return 0.75 * (1 - e * e) * std::exp(2 * (1 - e)); },
     {.217, .327, .448, .483, .680, .896},
     1e-3},
    {"flores",
     [](double e) { return 8 * (1 - e) / (5 * e); },
     {.06944, .25621, .42746, .47044, .68318, .89392},
     1e-5},
    {"hu-guo", [](double e) { return 3 * (1 - e) / (2 * e); }, {.074, .271, .445, .488, .697, .900}, 1e-3},
    {"carvalho-martins",
     [](double e) { return 3 * (1 - e) * (11 - e) / (2 * (1 + 9 * e)); },
     {.129, .304, .460, .500, .700, .900},
     1e-3},
    {"gharib-hurmuzlu",
     [](double e) { return 1 / e; },
     {.09998, .28188, .38867, .41072, .50078, .56681},
     1e-5},
}};
/// χ of the exact law for delivered_table_e, rounded to 1e-5.
inline constexpr std::array<double, 6> exact_chi_table{9.99816, 3.08708, 1.66351, 1.43275, .63483, .16648};

}  // namespace freeplay::reference
