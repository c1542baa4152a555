// Constant force F in the world's directions on a point of a body; its power is F·v_P.
#pragma once

#include <string>

#include "model/body.hpp"
#include "values/forces.hpp"

namespace freeplay {

struct ForceLoad {
  static constexpr std::string_view type = "force", what = "a force";
  static constexpr auto reports = ForceElement::Kind::force;
  std::string name;
  int body = ground;
  Vec2 at{0, 0};     ///< m, in the body's frame
  Vec2 force{0, 0};  ///< N

  static void keys(auto& k, auto& l) {
    k.body({"body", "", "the loaded body"}, l.body);
    k.point_of({"at", "m", "the loaded point in the body's frame"}, l.body, l.at);
    k.need({"force", "N", "constant force in the world's directions"}, l.force);
  }

  auto link(auto& b) const { return b.free_link({ground, body}, {Vec2{0, 0}, at}); }
  bool does_work() const { return true; }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    const auto a = m.arms(link);
    const Vec2Of<T> f{T(force.x()), T(force.y())};
    out.pull(link, a, f);
    out.power.load += dot(f, m.relative_velocity(link, a));
  }
};

}  // namespace freeplay
