// The dynamics of all kinds of element in mechanism/elements.hpp.
#pragma once

#include <tuple>
#include <variant>
#include <vector>

#include "dynamics/elements/angle_stop.hpp"
#include "dynamics/elements/beam_element.hpp"
#include "dynamics/elements/bump_stop.hpp"
#include "dynamics/elements/bushing.hpp"
#include "dynamics/elements/cam_contact.hpp"
#include "dynamics/elements/controller.hpp"
#include "dynamics/elements/dc_motor.hpp"
#include "dynamics/elements/disc_contact.hpp"
#include "dynamics/elements/effort_drive.hpp"
#include "dynamics/elements/elastic_ratio.hpp"
#include "dynamics/elements/force_load.hpp"
#include "dynamics/elements/freewheel.hpp"
#include "dynamics/elements/gear_joint.hpp"
#include "dynamics/elements/governor.hpp"
#include "dynamics/elements/induction_motor.hpp"
#include "dynamics/elements/joint_friction.hpp"
#include "dynamics/elements/motion_drive.hpp"
#include "dynamics/elements/outline_contact.hpp"
#include "dynamics/elements/plane_contact.hpp"
#include "dynamics/elements/rack_joint.hpp"
#include "dynamics/elements/ratio_joint.hpp"
#include "dynamics/elements/reduced_beam.hpp"
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
#include "dynamics/system.hpp"
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

// Drives, loads and reduced beams of a System with their links and indices. Only the sources of System include
// this file, so that a change of an element's dynamics recompiles these alone.

/// A drive, load or reduced beam with its place in the System.
template <class Facts>
struct Placed {
  Dynamics<Facts> facts;
  Link link;
  int element = -1;  ///< index in ForceReport::elements; −1: a reduced beam
  int state = -1;    ///< index of its (first) first-order state; −1: none
  int phase = -1;    ///< index of its phase in System::phases; −1: none
};

template <class... Lists>
struct PlacedKinds;
template <class... D, class... L>
struct PlacedKinds<std::variant<D...>, std::variant<L...>> {
  using type = std::tuple<std::vector<Placed<D>>..., std::vector<Placed<L>>..., std::vector<Placed<Beam>>>;
};
struct PlacedElements {
  PlacedKinds<Drive, Load>::type lists;
};

/// Whether a kind of drive or load applies a force by itself; the others add rows.
template <class Facts>
concept Acts = requires(const Dynamics<Facts>& f) {
  f.does_work();
};

/// Calls f with every item of every vector in a tuple of vectors.
template <class... Items, class F>
[[gnu::always_inline]] inline void for_each_item(const std::tuple<std::vector<Items>...>& lists, F f) {
  const auto over = [&f]<class Item>(const std::vector<Item>& list) __attribute__((always_inline)) {
    for (const auto& item : list) f(item);
  };
  (over(std::get<std::vector<Items>>(lists)), ...);
}

}  // namespace freeplay
