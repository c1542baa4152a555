// Dynamics of mechanism/elements/elastic_ratio.hpp, which states the equations.
#pragma once

#include "dynamics/argument.hpp"
#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/elastic_ratio.hpp"

namespace freeplay {

template <>
struct Dynamics<ElasticRatio> : ElasticRatio {
  // Set by prepare().
  Link leads = {};  ///< the bodies of the joint `of`
  bool slides = false;
  Vec2 axis{1, 0};  ///< of a translational joint

  void prepare(const auto& mechanism) {
    const auto& pair = std::get<RevoluteJoint>(mechanism.joints[static_cast<std::size_t>(of)]).between;
    leads = {pair[0], pair[1]};
    if (const auto* s = slider(mechanism)) slides = true, axis = s->axis;
  }
  auto link(auto& b) const { return b.joint_link(joint); }
  bool does_work() const { return damping > 0; }
  bool needs_velocity() const { return damping > 0; }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    const T turned = ratio * m.angle(leads) + offset, turning = ratio * m.spin(leads);
    const auto force = [&](const T& place, const T& rate) {
      const T relative = rate - turning, f = -(stiffness * (place - turned) + damping * relative);
      out.beside(leads, T(-ratio * f));
      out.power.damping -= damping * relative * relative;
      return f;
    };
    if (!slides) return out.couple(link, force(m.angle(link), m.spin(link)));
    const AlongAxis<T> on(link, axis, m.q, m.e);
    const T f = force(on.place, on.rate(link, m.v));
    out.pull(link, on.arms, Vec2Of<T>{f * on.axis.x(), f * on.axis.y()});
  }

  double potential(const auto& at_rest, const auto& link) const {
    double x = -ratio * at_rest.angle(leads) - offset;
    if (slides) {
      const Vec2 from = at_rest.point(link.i, link.si);
      x += dot(at_rest.point(link.i, link.si + axis) - from, at_rest.point(link.j, link.sj) - from);
    } else {
      x += at_rest.angle(link);
    }
    return 0.5 * stiffness * x * x;
  }
};

}  // namespace freeplay
