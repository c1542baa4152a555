#include "dynamics/point_bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

class Check {
 public:
  explicit Check(const Mechanism& m) : m_(m) {}

  void all() {
    for (const auto& b : m_.bodies) {
      table_ = "bodies." + b.name;
      const bool turned = b.angle.value_or(0) != 0;
      if (b.point && (b.inertia != 0 || turned || b.angular_velocity.value_or(0) != 0))
        refuse(b.inertia != 0 ? "inertia"
               : turned       ? "angle"
                              : "angular_velocity",
               "needs a body with rotation; a point body has a centre only");
    }
    const auto each = [&](const char* table, const auto& list) {
      for (const auto& element : list)
        std::visit(
            [&](const auto& x) {
              table_ = fmt::format("{}.{}", table, x.name);
              look(x);
            },
            element);
    };
    each("joints", m_.joints);
    each("contacts", m_.contacts);
    each("drives", m_.drives);
    each("loads", m_.loads);
  }

 private:
  bool is_point(int body) const { return body != ground && m_.bodies[static_cast<std::size_t>(body)].point; }
  const std::string& name(int body) const { return m_.bodies[static_cast<std::size_t>(body)].name; }
  int point_of(const std::array<int, 2>& bodies) const {
    return is_point(bodies[0]) ? bodies[0] : is_point(bodies[1]) ? bodies[1] : ground;
  }
  [[noreturn]] void refuse(const char* key, const std::string& why) const {
    throw ModelError(fmt::format("{}.{}", table_, key), why);
  }

  void at_centre(int body, const Vec2& at) const {
    if (is_point(body) && !at.is_zero())
      refuse("at",
             fmt::format("must be [0, 0] on \"{}\": a point body has no other point than its centre; use a "
                         "joint of type \"rod\" for a distance",
                         name(body)));
  }
  void centres(const auto& x) const {
    for (const std::size_t end : {0, 1}) at_centre(x.between[end], x.at[end]);
  }
  /// Checks an element whose directions are those of the first body.
  void second_only(const auto& x, const char* what) const {
    centres(x);
    if (is_point(x.between[0]))
      refuse("between",
             fmt::format("{} is on the first body, but \"{}\" is a point body without directions; give it "
                         "as the second body",
                         what, name(x.between[0])));
  }
  void turning(const std::array<int, 2>& bodies, const char* key, const char* instead) const {
    if (const int body = point_of(bodies); body != ground)
      refuse(key,
             fmt::format("acts on the angle of \"{}\", a point body without angle; {}", name(body), instead));
  }
  /// Friction on a round surface exerts a moment.
  void smooth(const std::array<int, 2>& bodies, int surface, const char* key = "surface") const {
    const int body = point_of(bodies);
    if (body != ground && surface >= 0 && m_.surfaces[static_cast<std::size_t>(surface)].friction)
      refuse(key, fmt::format(
                      "has friction with a couple on \"{}\", a point body; give the body inertia, or use a "
                      "surface without friction",
                      name(body)));
  }
  void joint_angle(int joint, const char* key, const char* instead) const {
    if (joint >= 0) turning(bodies_of(m_.joints[static_cast<std::size_t>(joint)]), key, instead);
  }

  void look(const RevoluteJoint& j) const {
    centres(j);
    if (!j.clearance) return;
    second_only(j, "the bearing");
    smooth(j.between, j.clearance->surface);
    if (const int body = point_of(j.between); body != ground && j.clearance->lubricant >= 0)
      refuse(
          "lubricant",
          fmt::format("has a film with a couple on \"{}\", a point body; give the body inertia", name(body)));
  }
  void look(const SlotJoint& j) const {
    second_only(j, "the slot");
    if (j.clearance) smooth(j.between, j.clearance->surface);
  }
  void look(const RodJoint& j) const { centres(j); }
  void look(const TranslationalJoint& j) const {
    turning(j.between, "between", "a joint of type \"slot\" guides its centre");
  }
  void look(const RigidJoint& j) const {
    turning(j.between, "between", "a joint of type \"revolute\" fixes its centre");
  }
  void look(const GearJoint& j) const { turning(j.between, "between", "give the body inertia"); }
  void look(const RackJoint& j) const { turning(j.between, "between", "give the body inertia"); }
  void look(const RatioJoint& j) const {
    joint_angle(j.joint, "joint", "give the body inertia");
    joint_angle(j.of, "of", "give the body inertia");
  }

  void look(const PlaneContact& c) const {
    second_only(c, "the plane");
    if (c.radius > 0) smooth(c.between, c.surface);
  }
  void look(const DiscContact& c) const {
    centres(c);
    smooth(c.between, c.surface);
  }
  void look(const OutlineContact& c) const {
    second_only(c, "the outline");
    if (c.radius > 0) smooth(c.between, c.surface);
  }
  void look(const CamContact& c) const { turning(c.between, "between", "give the body inertia"); }
  void look(const TravelStop& c) const {
    // With an ideal slot joint there is no sliding on the stop.
    const auto* slot = std::get_if<SlotJoint>(&m_.joints[static_cast<std::size_t>(c.joint)]);
    if (slot && slot->clearance) smooth(slot->between, c.stop.surface);
  }
  void look(const AngleStop& c) const { joint_angle(c.joint, "joint", "give the body inertia"); }

  void look(const auto& x) const {
    if constexpr (requires {
                    x.body;
                    x.at;
                  }) {  // a force
      at_centre(x.body, x.at);
      if (is_point(x.body) && x.axes == ForceLoad::Axes::body)
        refuse("axes",
               fmt::format("must be \"world\": \"{}\" is a point body without directions", name(x.body)));
      if (is_point(x.body) && x.factor >= 0 && x.against == Argument::angle && x.other.of < 0)
        refuse("against",
               fmt::format("reads the angle of \"{}\", a point body without angle; give a joint with `of`",
                           name(x.body)));
    } else if constexpr (requires { x.body; }) {  // a torque
      turning({x.body, ground}, "body", "give the body inertia");
    } else if constexpr (requires {
                           x.between;
                           x.at;
                           x.axis;
                         }) {  // a bushing, a bump stop
      second_only(x, "its direction");
      if constexpr (requires { x.turn_stiffness; })
        if (x.turn_stiffness != 0 || x.turn_damping != 0)
          turning(x.between, x.turn_stiffness != 0 ? "torsional_stiffness" : "torsional_damping",
                  "remove it");
    } else if constexpr (requires {
                           x.between;
                           x.at;
                         }) {  // a spring
      centres(x);
    } else if constexpr (requires { x.between; }) {
      turning(x.between, "between", "give the body inertia");
    } else {  // drives, and friction in a joint
      joint_angle(x.joint, "joint", "give the body inertia");
    }
    if constexpr (requires { x.of; }) joint_angle(x.of, "of", "give the body inertia");
    if constexpr (requires { x.other.of; }) joint_angle(x.other.of, "of", "give the body inertia");
  }

  const Mechanism& m_;
  std::string table_;
};

}  // namespace

void check_point_bodies(const Mechanism& mechanism) {
  if (std::ranges::any_of(mechanism.bodies, &Body::point)) Check(mechanism).all();
}

}  // namespace freeplay
