// Bilateral constraints. For two points with arms r_i, r_j (perp turns by +90°):
//     Φ = r_j^P − r_i^P,   Φ̇ = v_j + ω_j perp r_j − v_i − ω_i perp r_i,   γ = ω_j² r_j − ω_i² r_i
// For a slide along the axis a of body i, n = perp a, d = r_j^P − r_i^P:
//     Φ = n·d,   Φ̇ = n·ḋ − ω_i a·d,   γ = ω_i² n·d + 2 ω_i a·ḋ + n·(ω_j² r_j − ω_i² r_i)
#include <cmath>

#include "model/plane.hpp"

namespace freeplay {

template <class T>
void System::place(std::type_identity_t<T> t, const T* q, EvaluationOf<T>& e) const {
  using std::cos, std::sin;
  for (std::size_t b = 0; b < e.cosine.size(); ++b) {
    e.cosine[b] = cos(q[3 * b + 2]);
    e.sine[b] = sin(q[3 * b + 2]);
  }
  T* G = e.G.data();
  T* phi = e.phi.data();
  for (const auto& p : points_) {
    const Arms<T> a = arms(p.link, q, e);
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
    const Arms<T> a = arms(s.link, q, e);
    const Vec2Of<T> axis = turned(s.link.i, s.axis, e), n = perp(axis);
    phi[s.row] = dot(n, a.d);
    T* g = G + G_.begin[s.row];
    if (s.link.i != ground) {
      *g++ = -n.x();
      *g++ = -n.y();
      *g++ = -dot(axis, a.d) - dot(axis, a.ri);
    }
    if (s.link.j != ground) {
      if (s.x) *g++ = n.x();
      if (s.y) *g++ = n.y();
      if (g < G + G_.begin[s.row + 1]) *g = dot(axis, a.rj);
    }
  }
  for (const auto& r : angles_) phi[r.row] = theta(q, r.j) - theta(q, r.i) - r.angle;
  for (const auto& r : speed_drives_) phi[r.row] = theta(q, r.j) - theta(q, r.i) - r.angle - r.speed * t;
}

template <class T>
void System::rate(const T* q, const T* v, EvaluationOf<T>& e) const {
  T* gamma = e.gamma.data();
  for (const auto& p : points_) {
    const T wi = omega(v, p.link.i), wj = omega(v, p.link.j);
    const Vec2Of<T> rj = turned(p.link.j, p.link.sj, e), ri = turned(p.link.i, p.link.si, e);
    gamma[p.row] = wj * wj * rj.x() - wi * wi * ri.x();
    gamma[p.row + 1] = wj * wj * rj.y() - wi * wi * ri.y();
  }
  for (const auto& s : slides_) {
    const Arms<T> a = arms(s.link, q, e);
    const Vec2Of<T> axis = turned(s.link.i, s.axis, e), n = perp(axis);
    const T wi = omega(v, s.link.i), wj = omega(v, s.link.j);
    gamma[s.row] = wi * wi * dot(n, a.d) + 2 * wi * dot(axis, relative_velocity(s.link, a, v)) +
                   wj * wj * dot(n, a.rj) - wi * wi * dot(n, a.ri);
  }
}

double System::crank_angle(const double* q) const { return theta(q, crank_[1]) - theta(q, crank_[0]); }

template void System::place(double, const double*, Evaluation&) const;
template void System::place(Gradient, const Gradient*, EvaluationOf<Gradient>&) const;
template void System::rate(const double*, const double*, Evaluation&) const;
template void System::rate(const Gradient*, const Gradient*, EvaluationOf<Gradient>&) const;

}  // namespace freeplay
