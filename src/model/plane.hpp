// Vectors of the plane, for the evaluation of a System.
#pragma once

#include "model/system.hpp"

namespace freeplay {

/// Turned by +90°.
template <class T>
Vec2Of<T> perp(const Vec2Of<T>& r) {
  return {-r.y(), r.x()};
}
template <class T>
T dot(const Vec2Of<T>& a, const Vec2Of<T>& b) {
  return a.x() * b.x() + a.y() * b.y();
}
template <class T>
T cross(const Vec2Of<T>& a, const Vec2Of<T>& b) {
  return a.x() * b.y() - a.y() * b.x();
}
template <class T>
T omega(const T* v, int body) {
  return body == ground ? T(0) : v[3 * body + 2];
}
template <class T>
T theta(const T* q, int body) {
  return body == ground ? T(0) : q[3 * body + 2];
}

template <class T>
Vec2Of<T> System::turned(int body, const Vec2& s, const EvaluationOf<T>& e) {
  if (body == ground) return {T(s.x()), T(s.y())};
  const T &c = e.cosine[body], &sn = e.sine[body];
  return {c * s.x() - sn * s.y(), sn * s.x() + c * s.y()};
}

template <class T>
System::Arms<T> System::arms(const Link& link, const T* q, const EvaluationOf<T>& e) {
  Arms<T> a;
  a.ri = turned(link.i, link.si, e);
  a.rj = turned(link.j, link.sj, e);
  a.d = {a.rj.x() - a.ri.x(), a.rj.y() - a.ri.y()};
  if (link.i != ground) a.d -= Vec2Of<T>{q[3 * link.i], q[3 * link.i + 1]};
  if (link.j != ground) a.d += Vec2Of<T>{q[3 * link.j], q[3 * link.j + 1]};
  return a;
}

template <class T>
Vec2Of<T> System::relative_velocity(const Link& link, const Arms<T>& a, const T* v) {
  Vec2Of<T> u{T(0), T(0)};
  const auto add = [&](int body, const Vec2Of<T>& arm, double sign) {
    if (body == ground) return;
    const T& w = v[3 * body + 2];
    u.x() += sign * (v[3 * body] - w * arm.y());
    u.y() += sign * (v[3 * body + 1] + w * arm.x());
  };
  add(link.i, a.ri, -1);
  add(link.j, a.rj, 1);
  return u;
}

}  // namespace freeplay
