// The lists of all kinds of joint, contact, drive and load. The facts of each kind are in a file of
// elements/, and each kind is named here once. Reader, canonical text, documentation and System
// iterate over these lists:
//
//     std::visit([](const auto& joint) { use(joint.name, joint.between); }, mechanism.joints[k]);
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <variant>

#include "mechanism/elements/angle_stop.hpp"
#include "mechanism/elements/beam_element.hpp"
#include "mechanism/elements/bump_stop.hpp"
#include "mechanism/elements/bushing.hpp"
#include "mechanism/elements/cam_contact.hpp"
#include "mechanism/elements/controller.hpp"
#include "mechanism/elements/dc_motor.hpp"
#include "mechanism/elements/disc_contact.hpp"
#include "mechanism/elements/effort_drive.hpp"
#include "mechanism/elements/elastic_ratio.hpp"
#include "mechanism/elements/force_load.hpp"
#include "mechanism/elements/freewheel.hpp"
#include "mechanism/elements/gear_joint.hpp"
#include "mechanism/elements/governor.hpp"
#include "mechanism/elements/induction_motor.hpp"
#include "mechanism/elements/joint_friction.hpp"
#include "mechanism/elements/motion_drive.hpp"
#include "mechanism/elements/outline_contact.hpp"
#include "mechanism/elements/plane_contact.hpp"
#include "mechanism/elements/rack_joint.hpp"
#include "mechanism/elements/ratio_joint.hpp"
#include "mechanism/elements/revolute_joint.hpp"
#include "mechanism/elements/rigid_joint.hpp"
#include "mechanism/elements/rod_joint.hpp"
#include "mechanism/elements/slot_joint.hpp"
#include "mechanism/elements/speed_drive.hpp"
#include "mechanism/elements/spring_damper.hpp"
#include "mechanism/elements/torque_drive.hpp"
#include "mechanism/elements/torque_load.hpp"
#include "mechanism/elements/torsional_spring_damper.hpp"
#include "mechanism/elements/translational_joint.hpp"
#include "mechanism/elements/travel_stop.hpp"

namespace freeplay {

/// Any kind of joint.
using Joint = std::variant<RevoluteJoint, TranslationalJoint, RigidJoint, GearJoint, RackJoint, SlotJoint,
                           RodJoint, RatioJoint>;
/// Any kind of contact outside joints.
using Contact = std::variant<PlaneContact, DiscContact, CamContact, TravelStop, AngleStop, OutlineContact>;
/// Any kind of drive.
using Drive = std::variant<SpeedDrive, TorqueDrive, MotionDrive, TorqueCurveDrive, ForceDrive, DcMotor,
                           InductionMotor, Governor, AngleController, PositionController>;
/// Any kind of load.
using Load = std::variant<ForceLoad, TorqueLoad, SpringDamper, TorsionalSpringDamper, JointFriction,
                          Freewheel, Bushing, BumpStop, TorsionalBumpStop, BeamElement, ElasticRatio>;

/// The word for a kind of element: its `type` in a scene; for drives, for example, "speed drive".
template <class Kind>
constexpr std::string_view word_of() {
  if constexpr (requires { Kind::type; })
    return Kind::type;
  else
    return Kind::what.substr(Kind::what.find(' ') + 1);
}
/// The name of an element of any kind.
template <class... Kinds>
const std::string& name_of(const std::variant<Kinds...>& element) {
  return std::visit([](const auto& x) -> const std::string& { return x.name; }, element);
}
/// The two bodies of a joint of any kind.
inline const std::array<int, 2>& bodies_of(const Joint& joint) {
  return std::visit([](const auto& j) -> const std::array<int, 2>& { return j.between; }, joint);
}

}  // namespace freeplay
