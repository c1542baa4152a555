// The dynamics of all kinds of element in mechanism/elements.hpp.
#pragma once

#include "dynamics/elements/angle_stop.hpp"
#include "dynamics/elements/bump_stop.hpp"
#include "dynamics/elements/bushing.hpp"
#include "dynamics/elements/cam_contact.hpp"
#include "dynamics/elements/controller.hpp"
#include "dynamics/elements/dc_motor.hpp"
#include "dynamics/elements/disc_contact.hpp"
#include "dynamics/elements/effort_drive.hpp"
#include "dynamics/elements/force_load.hpp"
#include "dynamics/elements/gear_joint.hpp"
#include "dynamics/elements/governor.hpp"
#include "dynamics/elements/induction_motor.hpp"
#include "dynamics/elements/joint_friction.hpp"
#include "dynamics/elements/motion_drive.hpp"
#include "dynamics/elements/plane_contact.hpp"
#include "dynamics/elements/rack_joint.hpp"
#include "dynamics/elements/revolute_joint.hpp"
#include "dynamics/elements/rigid_joint.hpp"
#include "dynamics/elements/rod_joint.hpp"
#include "dynamics/elements/slot_joint.hpp"
#include "dynamics/elements/speed_drive.hpp"
#include "dynamics/elements/spring_damper.hpp"
#include "dynamics/elements/torque_drive.hpp"
#include "dynamics/elements/torque_load.hpp"
#include "dynamics/elements/torsional_spring_damper.hpp"
#include "dynamics/elements/translational_joint.hpp"
#include "dynamics/elements/travel_stop.hpp"
#include "mechanism/elements.hpp"

namespace freeplay {

/// Whether each kind in a list of facts has its Dynamics.
template <class List>
constexpr bool complete_dynamics = false;
template <class... Kinds>
constexpr bool complete_dynamics<std::variant<Kinds...>> = requires {
  (sizeof(Dynamics<Kinds>) + ...);
};
static_assert(complete_dynamics<Joint> && complete_dynamics<Contact> && complete_dynamics<Drive> &&
              complete_dynamics<Load>);

}  // namespace freeplay
