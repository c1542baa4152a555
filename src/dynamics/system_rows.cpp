// Constraint rows and contact pairs at one state, over all kinds of both.
#include <algorithm>
#include <cmath>

#include "dynamics/system.hpp"
#include "numerics/traced.hpp"

namespace freeplay {

namespace {

/// Rotations (rad) up to which sine and cosine are continued by their series; beyond it the math
/// library is called. The first omitted terms, δ⁷/5040 and δ⁸/40320, are below a hundredth of the
/// rounding error of 1.
constexpr double longest_continued_turn = 1.0 / 128;

}  // namespace

template <class T>
void System::place_near(std::type_identity_t<T> t, const T* q, const T* q_from, const EvaluationOf<T>& from,
                        EvaluationOf<T>& e) const {
  using std::abs, std::cos, std::sin;
  const T *cosine = from.cosine.data(), *sine = from.sine.data();
  const auto bodies = e.cosine.size();
  for (std::size_t b = 0; b < bodies; ++b) {
    const T theta = q[3 * b + 2], turn = theta - q_from[3 * b + 2];
    // An angle that comes to exactly 0. For one that stays 0 the continuation below gives the same, and
    // compiled functions need no other branch.
    if (abs(theta) < abs(turn) * T(1e-300)) {
      e.cosine[b] = 1;
      e.sine[b] = theta;
    } else if (abs(turn) <= T(longest_continued_turn)) {
      // cos(θ + δ) = c − (s sin δ + c (1 − cos δ)), and similarly the sine. The correction is
      // small, and so is its rounding error.
      const T square = turn * turn, c = cosine[b], s = sine[b];
      const T turned = turn - turn * square * (1.0 / 6 - square * (1.0 / 120)),
              less = square * (0.5 - square * (1.0 / 24 - square * (1.0 / 720)));
      e.cosine[b] = c - (s * turned + c * less);
      e.sine[b] = s + (c * turned - s * less);
    } else {
      const T c = cos(theta), s = sin(theta);
      e.cosine[b] = c;
      e.sine[b] = s;
    }
  }
  place_rows(t, q, e);
}

template <class T>
[[gnu::flatten]] void System::place_rows(std::type_identity_t<T> t, const T* q, EvaluationOf<T>& e) const {
  each_row([&](const auto& row) { row.place(t, q, e); });
}

template <class T>
void System::place(std::type_identity_t<T> t, const T* q, EvaluationOf<T>& e, const Piece* pieces) const {
  using std::cos, std::sin;
  if constexpr (!is_traced<T>) e.pieces = pieces;  // a trace has set its own
  if constexpr (std::is_same_v<T, double>)
    if (compiled_.any() && compiled_.place(t, q, e)) return;
  for (std::size_t b = 0; b < e.cosine.size(); ++b) {
    const T theta = q[3 * b + 2];
    if constexpr (std::is_same_v<T, double>)
      if (theta == 0) {  // a body guided without rotation
        e.cosine[b] = 1;
        e.sine[b] = theta;
        continue;
      }
    const T c = cos(theta), s = sin(theta);  // the library computes both in one call
    e.cosine[b] = c;
    e.sine[b] = s;
  }
  place_rows(t, q, e);
}

template <class T>
[[gnu::flatten]] void System::rate(const T* q, const T* v, EvaluationOf<T>& e) const {
  if constexpr (std::is_same_v<T, double>)
    if (compiled_.any() && compiled_.rate(q, v, e)) return;
  each_row([&](const auto& row) {
    if constexpr (requires { row.rate(q, v, e); }) row.rate(q, v, e);
  });
}

Vec2 System::eccentricity(int k, const double* q, const Evaluation& e) const {
  return arms(link_of(k), q, e).d;
}

[[gnu::flatten]] double System::gap(const Pair& pair, const double* q, const Evaluation& e) {
  return std::visit(
      [&](const auto& p) {
        const auto d = arms(p.link, q, e).d;
        if constexpr (requires { p.gap(q, d, e); })  // pairs that need angles
          return p.gap(q, d, e);
        else
          return p.gap(d, e);
      },
      pair);
}

GapMotion System::gap_motion(int k, const MotionBounds& bounds, const double* q, const Evaluation& e) const {
  return std::visit([&](const auto& pair) { return pair.motion(bounds, arms(pair.link, q, e).d); },
                    pairs_[k]);
}

template <class T>
[[gnu::flatten]] void System::contact(const Pair& pair, const ContactFacts& facts, const T* q, const T* v,
                                      const EvaluationOf<T>& e, ContactRowOf<T>& row) {
  row.normal.clear();
  row.tangent.clear();
  row.film.clear();
  row.spin.clear();
  row.gamma_n = row.gamma_t = 0;
  std::visit(
      [&](const auto& p) {
        const auto a = arms(p.link, q, e);
        if constexpr (requires { p.rows(a, q, v, e, row); })
          p.rows(a, q, v, e, row);
        else if constexpr (requires { p.rows(facts, q, a, v, e, row); })
          p.rows(facts, q, a, v, e, row);
        else
          p.rows(facts, a, v, e, row);
      },
      pair);
}

template <class T>
T System::friction(int k, const T* q, const T* v, const EvaluationOf<T>& e, SparseRowOf<T>& row) const {
  return std::visit([&](const auto& sliding) { return sliding.rows(q, v, e, row); }, slidings_[k]);
}

double System::slide_share(int k) const {
  const auto* pin = std::get_if<SpinRow>(&slidings_[k]);
  if (!pin) return 1;
  double mass = 0, inertia = 0;  // reciprocals of mass and inertia
  for (const int body : {pin->link.i, pin->link.j})
    if (body != ground) {
      mass += 1 / mass_[3 * body];
      inertia += 1 / mass_[3 * body + 2];
    }
  return std::min(1.0, pin->radius * std::sqrt(inertia / mass));
}

double System::crank_angle(const double* q) const { return theta(q, crank_.j) - theta(q, crank_.i); }

template void System::place(double, const double*, Evaluation&, const Piece*) const;
template void System::place(Traced, const Traced*, EvaluationOf<Traced>&, const Piece*) const;
template void System::place_near(double, const double*, const double*, const Evaluation&, Evaluation&) const;
template void System::place_near(Traced, const Traced*, const Traced*, const EvaluationOf<Traced>&,
                                 EvaluationOf<Traced>&) const;
template void System::rate(const double*, const double*, Evaluation&) const;
template void System::rate(const Traced*, const Traced*, EvaluationOf<Traced>&) const;
template void System::contact(const Pair&, const ContactFacts&, const Traced*, const Traced*,
                              const EvaluationOf<Traced>&, ContactRowOf<Traced>&);
template void System::contact(const Pair&, const ContactFacts&, const double*, const double*,
                              const Evaluation&, ContactRow&);
template double System::friction(int, const double*, const double*, const Evaluation&, SparseRow&) const;
template Traced System::friction(int, const Traced*, const Traced*, const EvaluationOf<Traced>&,
                                 SparseRowOf<Traced>&) const;

}  // namespace freeplay
