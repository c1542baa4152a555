// Contacts of loose revolute joints: e = r_journal − r_bearing, n = e/|e|, t = perp n,
//     g = c − |e|,        ġ = −n·ė,                              g̈ = −n·ë − (t·ė)²/|e|
//     v_T = t·ė + R_j ω_j − R_i ω_i   (velocity of the journal's surface relative to the bearing's)
//     v̇_T = t·ë − (t·ė)(n·ė)/|e| + R_j α_j − R_i α_i
// and the sliding row of preloaded translational joints, a·ḋ.
#include <cmath>

#include "model/system.hpp"

namespace freeplay {
namespace {
inline Vec2 perp(const Vec2& r) { return {-r.y(), r.x()}; }
inline double omega(const double* v, int body) { return body == ground ? 0 : v[3 * body + 2]; }
}  // namespace

Vec2 System::eccentricity(int k, const double* q, const Evaluation& e) const {
  return arms(contacts_[k], q, e).d;
}

double System::gap(int k, const double* q, const Evaluation& e) const {
  const Vec2 d = eccentricity(k, q, e);
  return contact_facts_[k].clearance - std::sqrt(d.squaredNorm());
}

void System::contact(int k, const double* q, const double* v, const Evaluation& e, ContactRow& row) const {
  const auto& link = contacts_[k];
  const auto& facts = contact_facts_[k];
  row.normal.clear();
  row.tangent.clear();
  row.gamma_n = row.gamma_t = 0;
  const Arms a = arms(link, q, e);
  const double length = std::sqrt(a.d.squaredNorm());
  row.gap = facts.clearance - length;
  row.film.clear();
  row.spin.clear();
  // A concentric journal has no normal; a film still resists it, alike in all directions: any will do.
  const bool concentric = !(length > 1e-9 * facts.clearance);
  if (concentric && !facts.lubricant) return;

  const Vec2 n = concentric ? Vec2{1, 0} : Vec2{a.d / length}, t = perp(n);
  const Vec2 rate = relative_velocity(link, a, v);
  const double wi = omega(v, link.i), wj = omega(v, link.j);
  const Vec2 bias = wi * wi * a.ri - wj * wj * a.rj;  // the part of ë without accelerations
  const double swirl = t.dot(rate);
  row.gamma_n = n.dot(bias) + (concentric ? 0 : swirl * swirl / length);
  const auto push = [](SparseRow& r, int body, const Vec2& direction, double turn) {
    if (body == ground) return;
    r.push(3 * body, direction.x());
    r.push(3 * body + 1, direction.y());
    r.push(3 * body + 2, turn);
  };
  push(row.normal, link.i, n, n.dot(perp(a.ri)));
  push(row.normal, link.j, -n, -n.dot(perp(a.rj)));
  if (facts.lubricant) {
    push(row.film, link.i, -t, -t.dot(perp(a.ri)) - 0.5 * length);
    push(row.film, link.j, t, t.dot(perp(a.rj)) - 0.5 * length);
    if (link.i != ground) row.spin.push(3 * link.i + 2, -1);
    if (link.j != ground) row.spin.push(3 * link.j + 2, 1);
  }
  if (!facts.surface.friction) return;
  row.gamma_t = -t.dot(bias) + (concentric ? 0 : swirl * n.dot(rate) / length);
  push(row.tangent, link.i, -t, -t.dot(perp(a.ri)) - facts.radius_bearing);
  push(row.tangent, link.j, t, t.dot(perp(a.rj)) + facts.radius_journal);
}

double System::friction(int k, const double* q, const double* v, const Evaluation& e, SparseRow& row) const {
  const auto& f = frictions_[k];
  const Arms a = arms(f.link, q, e);
  const Vec2 axis = turned(f.link.i, f.axis, e);
  row.clear();
  if (f.link.i != ground) {
    row.push(3 * f.link.i, -axis.x());
    row.push(3 * f.link.i + 1, -axis.y());
    row.push(3 * f.link.i + 2, -axis.dot(perp(a.ri)));
  }
  if (f.link.j != ground) {
    row.push(3 * f.link.j, axis.x());
    row.push(3 * f.link.j + 1, axis.y());
    row.push(3 * f.link.j + 2, axis.dot(perp(a.rj)));
  }
  // u = a·ḋ, so u̇ = a·d̈ + ω_i n·ḋ with n = perp a.
  const double wi = omega(v, f.link.i), wj = omega(v, f.link.j);
  return -(wi * perp(axis).dot(relative_velocity(f.link, a, v)) + axis.dot(wi * wi * a.ri - wj * wj * a.rj));
}

}  // namespace freeplay
