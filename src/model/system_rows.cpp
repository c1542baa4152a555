// Bilateral constraints. For two points with arms r_i, r_j (perp turns by +90°):
//     Φ = r_j^P − r_i^P,   Φ̇ = v_j + ω_j perp r_j − v_i − ω_i perp r_i,   γ = ω_j² r_j − ω_i² r_i
// For a slide along the axis a of body i, n = perp a, d = r_j^P − r_i^P:
//     Φ = n·d,   Φ̇ = n·ḋ − ω_i a·d,   γ = ω_i² n·d + 2 ω_i a·ḋ + n·(ω_j² r_j − ω_i² r_i)
#include <cmath>

#include "model/system.hpp"

namespace freeplay {
namespace {
inline Vec2 perp(const Vec2& r) { return {-r.y(), r.x()}; }
inline double omega(const double* v, int body) { return body == ground ? 0 : v[3 * body + 2]; }
inline double theta(const double* q, int body) { return body == ground ? 0 : q[3 * body + 2]; }
}  // namespace

Vec2 System::turned(int body, const Vec2& s, const Evaluation& e) const {
  if (body == ground) return s;
  const double c = e.cosine[body], sn = e.sine[body];
  return {c * s.x() - sn * s.y(), sn * s.x() + c * s.y()};
}

System::Arms System::arms(const Link& link, const double* q, const Evaluation& e) const {
  Arms a;
  a.ri = turned(link.i, link.si, e);
  a.rj = turned(link.j, link.sj, e);
  a.d = a.rj - a.ri;
  if (link.i != ground) a.d -= Vec2{q[3 * link.i], q[3 * link.i + 1]};
  if (link.j != ground) a.d += Vec2{q[3 * link.j], q[3 * link.j + 1]};
  return a;
}

Vec2 System::relative_velocity(const Link& link, const Arms& a, const double* v) const {
  Vec2 u{0, 0};
  if (link.i != ground) u -= Vec2{v[3 * link.i], v[3 * link.i + 1]} + v[3 * link.i + 2] * perp(a.ri);
  if (link.j != ground) u += Vec2{v[3 * link.j], v[3 * link.j + 1]} + v[3 * link.j + 2] * perp(a.rj);
  return u;
}

void System::place(double t, const double* q, Evaluation& e) const {
  for (std::size_t b = 0; b < e.cosine.size(); ++b) {
    e.cosine[b] = std::cos(q[3 * b + 2]);
    e.sine[b] = std::sin(q[3 * b + 2]);
  }
  double* G = e.G.data();
  double* phi = e.phi.data();
  for (const auto& p : points_) {
    const Arms a = arms(p.link, q, e);
    phi[p.row] = a.d.x();
    phi[p.row + 1] = a.d.y();
    if (p.theta_i[0] >= 0) {
      G[p.theta_i[0]] = a.ri.y();
      G[p.theta_i[1]] = -a.ri.x();
    }
    if (p.theta_j[0] >= 0) {
      G[p.theta_j[0]] = -a.rj.y();
      G[p.theta_j[1]] = a.rj.x();
    }
  }
  for (const auto& s : slides_) {
    const Arms a = arms(s.link, q, e);
    const Vec2 axis = turned(s.link.i, s.axis, e), n = perp(axis);
    phi[s.row] = n.dot(a.d);
    double* g = G + G_.begin[s.row];
    if (s.link.i != ground) {
      *g++ = -n.x();
      *g++ = -n.y();
      *g++ = -axis.dot(a.d) - axis.dot(a.ri);
    }
    if (s.link.j != ground) {
      *g++ = n.x();
      *g++ = n.y();
      if (g < G + G_.begin[s.row + 1]) *g = axis.dot(a.rj);
    }
  }
  for (const auto& r : angles_) phi[r.row] = theta(q, r.j) - theta(q, r.i) - r.angle;
  for (const auto& r : speed_drives_) phi[r.row] = theta(q, r.j) - theta(q, r.i) - r.angle - r.speed * t;
}

void System::rate(const double* q, const double* v, Evaluation& e) const {
  double* gamma = e.gamma.data();
  for (const auto& p : points_) {
    const double wi = omega(v, p.link.i), wj = omega(v, p.link.j);
    const Vec2 g = wj * wj * turned(p.link.j, p.link.sj, e) - wi * wi * turned(p.link.i, p.link.si, e);
    gamma[p.row] = g.x();
    gamma[p.row + 1] = g.y();
  }
  for (const auto& s : slides_) {
    const Arms a = arms(s.link, q, e);
    const Vec2 axis = turned(s.link.i, s.axis, e), n = perp(axis);
    const double wi = omega(v, s.link.i), wj = omega(v, s.link.j);
    gamma[s.row] = wi * wi * n.dot(a.d) + 2 * wi * axis.dot(relative_velocity(s.link, a, v)) +
                   n.dot(wj * wj * a.rj - wi * wi * a.ri);
  }
}

double System::crank_angle(const double* q) const { return theta(q, crank_[1]) - theta(q, crank_[0]); }

}  // namespace freeplay
