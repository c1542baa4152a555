// Contacts of loose revolute joints: e = r_journal − r_bearing, n = e/|e|, t = perp n,
//     g = c − |e|,        ġ = −n·ė,                              g̈ = −n·ë − (t·ė)²/|e|
//     v_T = t·ė + R_j ω_j − R_i ω_i   (velocity of the journal's surface relative to the bearing's)
//     v̇_T = t·ë − (t·ė)(n·ė)/|e| + R_j α_j − R_i α_i
// and the sliding row of preloaded translational joints, a·ḋ.
#include <cmath>

#include "model/plane.hpp"

namespace freeplay {

Vec2 System::eccentricity(int k, const double* q, const Evaluation& e) const {
  return arms(contacts_[k], q, e).d;
}

double System::gap(int k, const double* q, const Evaluation& e) const {
  const Vec2 d = eccentricity(k, q, e);
  return contact_facts_[k].clearance - std::sqrt(d.squaredNorm());
}

template <class T>
void System::contact(int k, const T* q, const T* v, const EvaluationOf<T>& e, ContactRowOf<T>& row) const {
  using std::sqrt;
  const auto& link = contacts_[k];
  const auto& facts = contact_facts_[k];
  row.normal.clear();
  row.tangent.clear();
  row.gamma_n = row.gamma_t = 0;
  const Arms<T> a = arms(link, q, e);
  const T length = sqrt(dot(a.d, a.d));
  row.gap = facts.clearance - length;
  row.film.clear();
  row.spin.clear();
  // A concentric journal has no normal; a film still resists it, alike in all directions: any will do.
  const bool concentric = !(length > 1e-9 * facts.clearance);
  if (concentric && !facts.lubricant) return;

  Vec2Of<T> n{T(1), T(0)};
  if (!concentric) n = {a.d.x() / length, a.d.y() / length};
  const Vec2Of<T> t = perp(n), rate = relative_velocity(link, a, v);
  const T wi = omega(v, link.i), wj = omega(v, link.j);
  // The part of ë without accelerations.
  const Vec2Of<T> bias{wi * wi * a.ri.x() - wj * wj * a.rj.x(), wi * wi * a.ri.y() - wj * wj * a.rj.y()};
  const T swirl = dot(t, rate);
  row.gamma_n = dot(n, bias);
  if (!concentric) row.gamma_n += swirl * swirl / length;
  const auto push = [](SparseRowOf<T>& r, int body, const Vec2Of<T>& direction, const T& turn) {
    if (body == ground) return;
    r.push(3 * body, direction.x());
    r.push(3 * body + 1, direction.y());
    r.push(3 * body + 2, turn);
  };
  push(row.normal, link.i, n, cross(a.ri, n));
  push(row.normal, link.j, Vec2Of<T>(-n), -cross(a.rj, n));
  if (facts.lubricant) {
    push(row.film, link.i, Vec2Of<T>(-t), -cross(a.ri, t) - 0.5 * length);
    push(row.film, link.j, t, cross(a.rj, t) - 0.5 * length);
    if (link.i != ground) row.spin.push(3 * link.i + 2, -1);
    if (link.j != ground) row.spin.push(3 * link.j + 2, 1);
  }
  if (!facts.surface.friction) return;
  row.gamma_t = -dot(t, bias);
  if (!concentric) row.gamma_t += swirl * dot(n, rate) / length;
  push(row.tangent, link.i, Vec2Of<T>(-t), -cross(a.ri, t) - facts.radius_bearing);
  push(row.tangent, link.j, t, cross(a.rj, t) + facts.radius_journal);
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
