#include "dynamics/assembly/dyads.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "dynamics/assembly/joint_places.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

const Joint& joint_of(const Mechanism& m, int k) { return m.joints[static_cast<std::size_t>(k)]; }
bool is_pin(const Joint& joint) { return std::holds_alternative<RevoluteJoint>(joint); }
bool is_guide(const Joint& joint) { return std::holds_alternative<TranslationalJoint>(joint); }

/// Rows by which an ideal joint holds one body to the other, with those of its drives.
int rows_of(const Mechanism& m, int k) {
  const auto& joint = joint_of(m, k);
  const int own = is_pin(joint) || is_guide(joint) ? 2 : std::holds_alternative<RigidJoint>(joint) ? 3 : 1;
  return own + static_cast<int>(std::ranges::count_if(m.drives, [&](const Drive& d) {
           const auto* speed = std::get_if<SpeedDrive>(&d);
           const auto* motion = std::get_if<MotionDrive>(&d);
           return (speed && speed->joint == k) || (motion && motion->joint == k);
         }));
}

/// The search for dyads.
class Growth {
 public:
  explicit Growth(const Mechanism& m) : m_(m), known_(m.bodies.size(), 0) {}

  std::vector<Dyad> grow() {
    while (add_body() || add_dyad()) {
    }
    return std::move(found_);
  }

 private:
  bool known(int body) const { return body == ground || known_[static_cast<std::size_t>(body)]; }
  int joints() const { return static_cast<int>(m_.joints.size()); }
  /// Joints between a body and known bodies.
  std::vector<int> to_known(int body) const {
    std::vector<int> list;
    for (int k = 0; k < joints(); ++k) {
      const auto pair = bodies_of(joint_of(m_, k));
      if ((pair[0] == body && known(pair[1])) || (pair[1] == body && known(pair[0]))) list.push_back(k);
    }
    return list;
  }
  bool add_body() {
    for (int b = 0; b < static_cast<int>(m_.bodies.size()); ++b) {
      if (known(b)) continue;
      int rows = m_.bodies[static_cast<std::size_t>(b)].point ? 1 : 0, rod = -1, carrier = -1;
      for (const int k : to_known(b)) {
        rows += rows_of(m_, k);
        if (std::holds_alternative<RodJoint>(joint_of(m_, k))) rod = k;
        if (is_pin(joint_of(m_, k)) || is_guide(joint_of(m_, k))) carrier = k;
      }
      if (rows < 3) continue;
      if (rod >= 0 && carrier >= 0 && rows_of(m_, carrier) == 2)
        found_.push_back({rod, {b, b}, {rod, carrier}});
      known_[static_cast<std::size_t>(b)] = 1;
      return true;
    }
    return false;
  }
  bool add_dyad() {
    for (int J = 0; J < joints(); ++J) {
      const auto [i, j] = bodies_of(joint_of(m_, J));
      if (known(i) || known(j) || !(is_pin(joint_of(m_, J)) || is_guide(joint_of(m_, J)))) continue;
      const auto K = to_known(i), L = to_known(j);
      const auto carries = [&](const std::vector<int>& list) {
        return list.size() == 1 && (is_pin(joint_of(m_, list[0])) || is_guide(joint_of(m_, list[0])));
      };
      if (!carries(K) || !carries(L)) continue;
      if (is_pin(joint_of(m_, J))) found_.push_back({J, {i, j}, {K[0], L[0]}});
      known_[static_cast<std::size_t>(i)] = known_[static_cast<std::size_t>(j)] = 1;
      return true;
    }
    return false;
  }

  const Mechanism& m_;
  std::vector<char> known_;
  std::vector<Dyad> found_;
};

}  // namespace

std::vector<Dyad> dyads(const Mechanism& mechanism) { return Growth(mechanism).grow(); }

double transmission_angle(const Mechanism& m, const Dyad& dyad, const std::vector<double>& q) {
  const auto end_on = [&](int joint, int body) {
    return end_place(joint_of(m, joint), bodies_of(joint_of(m, joint))[0] == body ? 0 : 1, q);
  };
  const Vec2 p = end_on(dyad.joint, dyad.bodies[1]);
  std::array<Vec2, 2> along;
  for (std::size_t n = 0; n < 2; ++n) {
    const auto& joint = joint_of(m, dyad.carried[n]);
    if (const auto* guide = std::get_if<TranslationalJoint>(&joint))
      along[n] = perp(place_of(q, guide->between[0], guide->axis) - place_of(q, guide->between[0], {0, 0}));
    else if (dyad.carried[n] == dyad.joint)  // the other end of a rod
      along[n] = end_place(joint, bodies_of(joint)[0] == dyad.bodies[1] ? 1 : 0, q) - p;
    else
      along[n] = end_on(dyad.carried[n], dyad.bodies[n]) - p;
  }
  return std::atan2(std::abs(cross(along[0], along[1])), std::abs(dot(along[0], along[1])));
}

}  // namespace freeplay
