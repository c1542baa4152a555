// The kinds of element that a mechanism may have. Each kind of joint, contact, drive and load is a file of elements/, and is
// listed here once: reader, canonical text, documentation and System go over these lists.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <variant>

#include "model/elements/angle_stop.hpp"
#include "model/elements/bump_stop.hpp"
#include "model/elements/bushing.hpp"
#include "model/elements/cam_contact.hpp"
#include "model/elements/dc_motor.hpp"
#include "model/elements/disc_contact.hpp"
#include "model/elements/effort_drive.hpp"
#include "model/elements/force_load.hpp"
#include "model/elements/gear_joint.hpp"
#include "model/elements/governor.hpp"
#include "model/elements/induction_motor.hpp"
#include "model/elements/joint_friction.hpp"
#include "model/elements/motion_drive.hpp"
#include "model/elements/plane_contact.hpp"
#include "model/elements/rack_joint.hpp"
#include "model/elements/revolute_joint.hpp"
#include "model/elements/rigid_joint.hpp"
#include "model/elements/rod_joint.hpp"
#include "model/elements/slot_joint.hpp"
#include "model/elements/speed_drive.hpp"
#include "model/elements/spring_damper.hpp"
#include "model/elements/torque_drive.hpp"
#include "model/elements/torque_load.hpp"
#include "model/elements/torsional_spring_damper.hpp"
#include "model/elements/translational_joint.hpp"
#include "model/elements/travel_stop.hpp"

namespace freeplay {

using Joint =
    std::variant<RevoluteJoint, TranslationalJoint, RigidJoint, GearJoint, RackJoint, SlotJoint, RodJoint>;
using Contact = std::variant<PlaneContact, DiscContact, CamContact, TravelStop, AngleStop>;
using Drive = std::variant<SpeedDrive, TorqueDrive, MotionDrive, TorqueCurveDrive, ForceDrive, DcMotor,
                           InductionMotor, Governor>;
using Load = std::variant<ForceLoad, TorqueLoad, SpringDamper, TorsionalSpringDamper, JointFriction, Bushing,
                          BumpStop, TorsionalBumpStop>;

/// The word for a kind of element: its `type` in a scene, or for drives "speed drive".
template <class Kind>
constexpr std::string_view word_of() {
  if constexpr (requires { Kind::type; })
    return Kind::type;
  else
    return Kind::what.substr(Kind::what.find(' ') + 1);
}
/// The name of any element.
template <class... Kinds>
const std::string& name_of(const std::variant<Kinds...>& element) {
  return std::visit([](const auto& x) -> const std::string& { return x.name; }, element);
}
inline const std::array<int, 2>& bodies_of(const Joint& joint) {
  return std::visit([](const auto& j) -> const std::array<int, 2>& { return j.between; }, joint);
}

}  // namespace freeplay
