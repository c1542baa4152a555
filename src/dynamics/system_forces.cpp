// Applied forces, their potential, and the powers of forces without one, over all drives and loads.
#include <algorithm>
#include <cmath>

#include "dynamics/placed.hpp"
#include "dynamics/system.hpp"
#include "numerics/traced.hpp"

namespace freeplay {

/// Sums over drives and loads: generalised forces and powers.
template <class T>
struct AppliedForces {
  std::vector<T>& f;
  LoadPower<T>& power;

  /// Adds a force on the second body at its arm, and its reaction on the first.
  void pull(const Link& link, const Arms<T>& a, const Vec2Of<T>& force) const {
    const auto push = [&](int body, const Vec2Of<T>& arm, double sign) {
      if (body == ground) return;
      f[3 * body] += sign * force.x();
      f[3 * body + 1] += sign * force.y();
      f[3 * body + 2] += sign * cross(arm, force);
    };
    push(link.i, a.ri, -1);
    push(link.j, a.rj, 1);
  }
  void couple(const Link& link, const T& torque) const {
    if (link.i != ground) f[3 * link.i + 2] -= torque;
    if (link.j != ground) f[3 * link.j + 2] += torque;
  }
};

template <class T>
void System::forces(std::type_identity_t<T> t, const T* q, const T* v, const T* z, EvaluationOf<T>& e,
                    const Reading& reading) const {
  if constexpr (std::is_same_v<T, double>)
    if (compiled_ && forces_compiled(t, q, v, z, e, reading)) return;
  if constexpr (is_traced<T>)
    apply(Motion<T>{t, q, v, e}, z, e);
  else
    apply(Motion<T>{t, q, v, e, reading}, z, e);
}

void System::forces(const Traced& t, const Traced* q, const Traced* v, const Traced* z,
                    EvaluationOf<Traced>& e, const ReadingOf<Traced>& reading) const {
  apply(Motion<Traced>{t, q, v, e, reading}, z, e);
}

template <class T>
void System::apply(const Motion<T>& motion, const T* z, EvaluationOf<T>& e) const {
  std::ranges::copy(constant_force_, e.force.begin());
  e.power = {};
  if (!acts_) return;
  const AppliedForces<T> out{e.force, e.power};
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (Acts<Facts>)
      x.facts.template act<T>(motion.of(x.phase), x.link, x.state < 0 ? nullptr : z + x.state, out);
  });
}

template <class T>
void System::flow(std::type_identity_t<T> t, const T* q, const T* v, const T* z, T* dz,
                  const Reading& reading) const {
  if (state_scales_.empty()) return;
  const EvaluationOf<T> none;
  Motion<T> motion{t, q, v, none};
  if constexpr (!is_traced<T>) motion.reading = reading;
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.has_state(); })
      if (x.state >= 0) dz[x.state] = x.facts.flow(motion.of(x.phase), x.link, z[x.state]);
    if constexpr (requires { x.facts.states(); })
      if (x.state >= 0) x.facts.template flow<T>(motion, z + x.state, dz + x.state);
  });
}

void System::saturations(double t, const double* q, const double* v, const double* z,
                         Saturation* list) const {
  const Evaluation none;
  const Motion<double> motion{t, q, v, none, {}};
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.limiters(); })
      if (x.facts.limiters() > 0)
        *list++ = x.facts.saturation(motion, x.link, x.state < 0 ? nullptr : z + x.state);
  });
}

double System::next_knot(double t) const {
  double next = INFINITY;
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.next_knot(t); }) next = std::min(next, x.facts.next_knot(t));
  });
  for (const auto& row : std::get<std::vector<MotionRow>>(constraints_))
    if (!row.follows) next = std::min(next, row.course.next_knot(t));
  return next;
}

double System::kinetic(const double* v) const {
  double sum = 0;
  for (std::size_t i = 0; i < mass_.size(); ++i) sum += 0.5 * mass_[i] * v[i] * v[i];
  return sum;
}

double System::potential(const double* q) const {
  double sum = 0;
  const bool heavy = gravity_.x() != 0 || gravity_.y() != 0;
  for (std::size_t b = 0; heavy && b < mass_.size(); b += 3)
    sum -= mass_[b] * (gravity_.x() * q[b] + gravity_.y() * q[b + 1]);
  if (!acts_) return sum;
  const Placement placement{q};
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.potential(placement, x.link); })
      sum += x.facts.potential(placement, x.link);
  });
  return sum;
}

template void System::forces(double, const double*, const double*, const double*, Evaluation&,
                             const Reading&) const;
template void System::forces(Gradient, const Gradient*, const Gradient*, const Gradient*,
                             EvaluationOf<Gradient>&, const Reading&) const;
template void System::forces(Traced, const Traced*, const Traced*, const Traced*, EvaluationOf<Traced>&,
                             const Reading&) const;
template void System::flow(double, const double*, const double*, const double*, double*,
                           const Reading&) const;
template void System::flow(Gradient, const Gradient*, const Gradient*, const Gradient*, Gradient*,
                           const Reading&) const;
template void System::flow(Traced, const Traced*, const Traced*, const Traced*, Traced*,
                           const Reading&) const;

}  // namespace freeplay
