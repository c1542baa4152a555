// Bodies on one line, each in contact with the next, and the first with an optional floor. Without
// gravity, or all in the same free fall, so that between impacts
//
//     gaps between bodies are linear in time, that of the floor is a parabola:
//     g_i = g_i0 + u_i t   (− ½ G t² for the floor)
//
// and the next impact is a root in closed form. Contacts whose gap is below `closed` take part in
// it together: with the Delassus matrix D of those contacts (tridiagonal), Newton's law in its
// complementary form,
//
//     u⁺ = u⁻ + D λ,      0 ≤ u⁺ + e u⁻  ⊥  λ ≥ 0
//
// which has one solution, since D is positive definite; it is found by trying all sets of contacts.
// Of n equal bodies at rest, all in contact, the conditions are met by u⁺ = (e v, 0, …, 0): all have
// one speed, and
//
//     on a floor at the speed v:     speed e v,                 λ_k = (1 + e) m v (n − k) > 0
//     a body arrives with speed v:   speed (1 + e) v/(n + 1),   λ_k = (1 + e) m v (n − k)/(n + 1) > 0,
//                                    the arriving body has the speed v (1 − n e)/(n + 1)
//
// for k = 0 … n − 1; with e = 1 the column bounces as a single ball. Source: Moreau 1988 for the
// law. `compliant` has Hertz's forces K_i δ^(3/2) instead, without loss, by RK4 in tiny steps (where
// a contact begins or ends of order 5/2). Units: m, s, kg.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

/// Height of the column above the floor and its velocity upwards, at the time t (s) after its
/// release from rest at height h (m), with e = 1.
struct ColumnMotion {
  double height, speed;
};
inline ColumnMotion elastic_column(double h, double g, double t) {
  const double fall = std::sqrt(2 * h / g);
  if (t < fall) return {h - 0.5 * g * t * t, -g * t};
  const double since = std::fmod(t - fall, 2 * fall);
  return {g * fall * since - 0.5 * g * since * since, g * fall - g * since};
}

/// Speeds (m/s) after a bead with the speed v hits a row of n beads of the same mass at rest.
struct RowImpact {
  double arriving, row;
};
inline RowImpact row_impact(int n, double v, double e) {
  if (n < 1) throw std::invalid_argument("row_impact: a row has a bead");
  return {v * (1 - n * e) / (n + 1), (1 + e) * v / (n + 1)};
}

struct TouchingRow {
  std::vector<double> mass, x, v;  ///< of centres, increasing x
  std::vector<double> reach;       ///< half length of each along the line
  bool floor = false;              ///< at x = 0
  double gravity = 0;              ///< towards −x
  double restitution = 1;
  /// N/m^(3/2), of the contacts in their order, the floor's first if present
  std::vector<double> stiffness = {};
  double closed = 1e-12;  ///< m

  struct Rows {
    std::vector<std::vector<double>> x, v;  ///< by instant and body
    std::size_t known = 0;
    long impacts = 0;
  };

  std::size_t contacts() const { return mass.size() - (floor ? 0 : 1); }
  double gap(std::size_t c, const std::vector<double>& at) const {
    if (floor && c == 0) return at[0] - reach[0];
    const std::size_t j = floor ? c : c + 1;
    return at[j] - at[j - 1] - reach[j] - reach[j - 1];
  }
  double rate(std::size_t c, const std::vector<double>& of) const {
    if (floor && c == 0) return of[0];
    const std::size_t j = floor ? c : c + 1;
    return of[j] - of[j - 1];
  }

  Rows at(const std::vector<double>& instants, int most_impacts) const {
    Rows rows;
    auto q = x, u = v;
    double t = 0, resting = 0;
    for (const double until : instants) {
      for (;;) {
        if (floor && gravity > 0 && gap(0, q) <= closed && std::abs(rate(0, u)) <= resting) {
          for (std::size_t c = 1; c < contacts(); ++c)
            if (gap(c, q) > closed || std::abs(rate(c, u)) > resting) return rows;
          std::fill(u.begin(), u.end(), 0.0);
          break;
        }
        double next = until - t;
        bool impact = false;
        for (std::size_t c = 0; c < contacts(); ++c) {
          const double g = std::max(gap(c, q), 0.0), r = rate(c, u), G = floor && c == 0 ? gravity : 0;
          // g + r τ − ½ G τ² = 0; a closed contact that does not approach is no event.
          double root = INFINITY;
          if (g <= closed && r < -resting)
            root = 0;
          else if (G > 0 && (g > closed || r > resting))
            root = (r + std::sqrt(r * r + 2 * G * g)) / G;
          else if (g > closed && r < -resting)
            root = -g / r;
          if (root < next) next = root, impact = true;
        }
        for (std::size_t i = 0; i < q.size(); ++i) {
          q[i] += u[i] * next - 0.5 * gravity * next * next;
          u[i] -= gravity * next;
        }
        t += next;
        if (!impact) break;
        if (++rows.impacts > most_impacts) return rows;
        double fastest = 0;
        for (std::size_t c = 0; c < contacts(); ++c) fastest = std::max(fastest, std::abs(rate(c, u)));
        resting = 1e-11 * fastest;
        apply_impact(q, u);
      }
      t = until;
      rows.x.push_back(q);
      rows.v.push_back(u);
      ++rows.known;
    }
    return rows;
  }

  Rows compliant(const std::vector<double>& instants, double step) const {
    Rows rows;
    auto q = x, u = v;
    double t = 0;
    const auto force = [&](const std::vector<double>& at, std::vector<double>& a) {
      std::fill(a.begin(), a.end(), -gravity);
      for (std::size_t c = 0; c < contacts(); ++c) {
        const double depth = -gap(c, at);
        if (depth <= 0) continue;
        const double F = stiffness[c] * depth * std::sqrt(depth);
        const std::size_t j = floor ? c : c + 1;
        a[j] += F / mass[j];
        if (j > 0) a[j - 1] -= F / mass[j - 1];
      }
    };
    const std::size_t n = q.size();
    std::vector<double> a1(n), a2(n), a3(n), a4(n), q2(n), q3(n), q4(n);
    for (const double until : instants) {
      const auto count = std::max(1L, static_cast<long>(std::ceil((until - t) / step)));
      const double h = (until - t) / static_cast<double>(count);
      for (long k = 0; k < count && h > 0; ++k) {
        force(q, a1);
        for (std::size_t i = 0; i < n; ++i) q2[i] = q[i] + 0.5 * h * u[i];
        force(q2, a2);
        for (std::size_t i = 0; i < n; ++i) q3[i] = q[i] + 0.5 * h * (u[i] + 0.5 * h * a1[i]);
        force(q3, a3);
        for (std::size_t i = 0; i < n; ++i) q4[i] = q[i] + h * (u[i] + 0.5 * h * a2[i]);
        force(q4, a4);
        for (std::size_t i = 0; i < n; ++i) {
          q[i] += h * (u[i] + h / 6 * (a1[i] + a2[i] + a3[i]));
          u[i] += h / 6 * (a1[i] + 2 * a2[i] + 2 * a3[i] + a4[i]);
        }
      }
      t = until;
      rows.x.push_back(q);
      rows.v.push_back(u);
      ++rows.known;
    }
    return rows;
  }

 private:
  void apply_impact(const std::vector<double>& q, std::vector<double>& u) const {
    std::vector<std::size_t> on;
    for (std::size_t c = 0; c < contacts(); ++c)
      if (gap(c, q) <= closed) on.push_back(c);
    std::vector<double> before;
    for (const auto c : on) before.push_back(rate(c, u));
    double size = 0;
    for (const double b : before) size = std::max(size, std::abs(b));
    const auto body = [&](std::size_t c) { return floor ? c : c + 1; };
    const auto entry = [&](std::size_t a, std::size_t b) {
      const std::size_t i = body(on[a]), j = body(on[b]);
      if (i == j) return 1 / mass[i] + (i > 0 ? 1 / mass[i - 1] : 0);
      if (i + 1 == j) return -1 / mass[i];
      if (j + 1 == i) return -1 / mass[j];
      return 0.0;
    };
    const std::size_t m = on.size();
    for (std::size_t set = 0; set < (std::size_t{1} << m); ++set) {
      // λ of the set from u⁺ = −e u⁻; D is positive definite.
      std::vector<std::size_t> active;
      for (std::size_t k = 0; k < m; ++k)
        if (set >> k & 1) active.push_back(k);
      const std::size_t n = active.size();
      std::vector<std::vector<double>> a(n, std::vector<double>(n));
      std::vector<double> impulses(n), lambda(m, 0);
      for (std::size_t r = 0; r < n; ++r) {
        for (std::size_t c = 0; c < n; ++c) a[r][c] = entry(active[r], active[c]);
        impulses[r] = -(1 + restitution) * before[active[r]];
      }
      eliminate(a, impulses, Pivots::none);
      for (std::size_t k = 0; k < n; ++k) lambda[active[k]] = impulses[k];
      auto after = u;
      for (std::size_t k = 0; k < m; ++k) {
        const std::size_t j = body(on[k]);
        after[j] += lambda[k] / mass[j];
        if (j > 0) after[j - 1] -= lambda[k] / mass[j - 1];
      }
      bool right = true;
      for (std::size_t k = 0; k < m; ++k)
        right = right && rate(on[k], after) + restitution * before[k] >= -1e-12 * size && lambda[k] >= 0;
      if (right) {
        u = after;
        return;
      }
    }
  }
};

}  // namespace freeplay::reference
