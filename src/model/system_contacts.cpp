// Contacts. Round ones, two circles: e = r_j − r_i, n = e/|e|, t = perp n; a journal inside a bearing has
// s = +1 and touches at |e| = R_i − R_j; discs outside each other have s = −1 and, counted with R_j < 0, too:
//     g = s(R_i − R_j − |e|),    ġ = −s n·ė,         g̈ = −s[n·ë + (t·ė)²/|e|]
//     v_T = t·ė + R_j ω_j − R_i ω_i   (velocity of the second surface relative to the first's)
//     v̇_T = t·ë − (t·ė)(n·ė)/|e| + R_j α_j − R_i α_i
// A disc of radius R (0: a corner) against a wall along the axis a of body i, n = s perp a into the free
// space, d = r_j − r_i, y = n·d − R the contact point's distance from body i's point along n:
//     g = n·d − rest,    ġ = n·ḋ − s ω_i a·d,    g̈ = n·d̈ − s α_i a·d − 2 s ω_i a·ḋ − ω_i² n·d
//     v_T = a·ḋ + s R ω_j + s y ω_i,             v̇_T = a·d̈ + ω_i perp(a)·ḋ + s(ω_i ġ + R α_j + y α_i)
// And the sliding row of preloaded translational joints, a·ḋ.
#include <cmath>

#include "model/plane.hpp"

namespace freeplay {
namespace {

template <class T>
void push(SparseRowOf<T>& row, int body, const Vec2Of<T>& direction, const T& turn) {
  if (body == ground) return;
  row.push(3 * body, direction.x());
  row.push(3 * body + 1, direction.y());
  row.push(3 * body + 2, turn);
}

/// The part of ë that the accelerations leave out.
template <class T>
Vec2Of<T> bias(const Vec2Of<T>& ri, const T& wi, const Vec2Of<T>& rj, const T& wj) {
  return {wi * wi * ri.x() - wj * wj * rj.x(), wi * wi * ri.y() - wj * wj * rj.y()};
}

}  // namespace

Vec2Of<double> System::eccentricity(int k, const double* q, const Evaluation& e) const {
  return arms(contacts_[k].link, q, e).d;
}

double System::gap(int k, const double* q, const Evaluation& e) const {
  const auto& c = contacts_[k];
  const Vec2Of<double> d = eccentricity(k, q, e);
  if (c.kind == ContactElement::Kind::round) return c.side * (c.rest - std::sqrt(d.squaredNorm()));
  return c.side * dot(perp(turned(c.link.i, c.axis, e)), d) - c.rest;
}

template <class T>
void System::contact(int k, const T* q, const T* v, const EvaluationOf<T>& e, ContactRowOf<T>& row) const {
  row.normal.clear();
  row.tangent.clear();
  row.film.clear();
  row.spin.clear();
  row.gamma_n = row.gamma_t = 0;
  const auto a = arms(contacts_[k].link, q, e);
  if (contacts_[k].kind == ContactElement::Kind::round)
    round_contact(k, a, v, row);
  else
    line_contact(k, a, v, e, row);
}

template <class T>
void System::round_contact(int k, const Arms<T>& a, const T* v, ContactRowOf<T>& row) const {
  using std::sqrt;
  const auto& c = contacts_[k];
  const auto& facts = contact_facts_[k];
  const int i = c.link.i, j = c.link.j;
  const T length = sqrt(dot(a.d, a.d));
  row.gap = c.side * (c.rest - length);
  // A concentric journal has no normal; a film still resists it, alike in all directions: any will do.
  const bool concentric = !(length > 1e-9 * facts.clearance);
  if (concentric && !facts.lubricant) return;

  Vec2Of<T> n{T(1), T(0)};
  if (!concentric) n = {a.d.x() / length, a.d.y() / length};
  const Vec2Of<T> t = perp(n), rate = relative_velocity(c.link, a, v);
  const Vec2Of<T> rest = bias(a.ri, omega(v, i), a.rj, omega(v, j));
  const T swirl = dot(t, rate);
  row.gamma_n = c.side * dot(n, rest);
  if (!concentric) row.gamma_n += c.side * swirl * swirl / length;
  const Vec2Of<T> outward{c.side * n.x(), c.side * n.y()}, inward = -outward;
  push(row.normal, i, outward, cross(a.ri, outward));
  push(row.normal, j, inward, cross(a.rj, inward));
  const Vec2Of<T> back = -t;
  if (facts.lubricant) {
    push(row.film, i, back, T(cross(a.ri, back) - 0.5 * length));
    push(row.film, j, t, T(cross(a.rj, t) - 0.5 * length));
    if (i != ground) row.spin.push(3 * i + 2, -1);
    if (j != ground) row.spin.push(3 * j + 2, 1);
  }
  if (!facts.surface.friction) return;
  row.gamma_t = -dot(t, rest);
  if (!concentric) row.gamma_t += swirl * dot(n, rate) / length;
  push(row.tangent, i, back, T(cross(a.ri, back) - c.radius_i));
  push(row.tangent, j, t, T(cross(a.rj, t) + c.radius_j));
}

template <class T>
void System::line_contact(int k, const Arms<T>& a, const T* v, const EvaluationOf<T>& e,
                          ContactRowOf<T>& row) const {
  const auto& c = contacts_[k];
  const int i = c.link.i, j = c.link.j;
  const double s = c.side;
  const Vec2Of<T> axis = turned(i, c.axis, e), left = perp(axis), n{s * left.x(), s * left.y()};
  const Vec2Of<T> rate = relative_velocity(c.link, a, v);
  const T wi = omega(v, i), wj = omega(v, j), along = dot(axis, a.d), height = dot(n, a.d);
  const Vec2Of<T> rest = bias(a.ri, wi, a.rj, wj), back = -n;
  row.gap = height - c.rest;
  row.gamma_n = 2 * s * wi * dot(axis, rate) + wi * wi * height - dot(n, rest);
  push(row.normal, i, back, T(cross(a.ri, back) - s * along));
  push(row.normal, j, n, cross(a.rj, n));
  if (!contact_facts_[k].surface.friction) return;
  const T y = height - c.radius_j, closing = dot(n, rate) - s * wi * along;
  row.gamma_t = -(dot(axis, rest) + wi * dot(left, rate) + s * wi * closing);
  const Vec2Of<T> behind = -axis;
  push(row.tangent, i, behind, T(cross(a.ri, behind) + s * y));
  push(row.tangent, j, axis, T(cross(a.rj, axis) + s * c.radius_j));
}

template <class T>
T System::friction(int k, const T* q, const T* v, const EvaluationOf<T>& e, SparseRowOf<T>& row) const {
  const auto& f = frictions_[k];
  const Arms<T> a = arms(f.link, q, e);
  const Vec2Of<T> axis = turned(f.link.i, f.axis, e);
  row.clear();
  if (f.link.i != ground) {
    row.push(3 * f.link.i, -axis.x());
    row.push(3 * f.link.i + 1, -axis.y());
    row.push(3 * f.link.i + 2, -cross(a.ri, axis));
  }
  if (f.link.j != ground) {
    row.push(3 * f.link.j, axis.x());
    row.push(3 * f.link.j + 1, axis.y());
    row.push(3 * f.link.j + 2, cross(a.rj, axis));
  }
  // u = a·ḋ, so u̇ = a·d̈ + ω_i n·ḋ with n = perp a.
  const T wi = omega(v, f.link.i), wj = omega(v, f.link.j);
  return -(wi * dot(perp(axis), relative_velocity(f.link, a, v)) + wi * wi * dot(axis, a.ri) -
           wj * wj * dot(axis, a.rj));
}

template void System::contact(int, const double*, const double*, const Evaluation&, ContactRow&) const;
template void System::contact(int, const Gradient*, const Gradient*, const EvaluationOf<Gradient>&,
                              ContactRowOf<Gradient>&) const;
template double System::friction(int, const double*, const double*, const Evaluation&, SparseRow&) const;
template Gradient System::friction(int, const Gradient*, const Gradient*, const EvaluationOf<Gradient>&,
                                   SparseRowOf<Gradient>&) const;

}  // namespace freeplay
