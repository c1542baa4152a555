#include "mechanism/mechanism.hpp"

#include <utility>
#include <variant>

namespace freeplay {
namespace {

void add_elements(Mechanism& mechanism, const Beam& beam) {
  if (beam.is_reduced()) {
    mechanism.loads.emplace_back(beam.only_element());
    return;
  }
  for (int n = beam.is_free(0) ? 1 : 0; n < beam.elements + (beam.is_free(1) ? 0 : 1); ++n)
    mechanism.loads.emplace_back(beam.element(n));
}

}  // namespace

void add_beam(Mechanism& mechanism, Beam beam) {
  beam.first = static_cast<int>(mechanism.bodies.size());
  for (int n = 0; n < beam.elements; ++n) mechanism.bodies.push_back(beam.body(n));
  add_elements(mechanism, beam);
  mechanism.beams.push_back(std::move(beam));
}

Mechanism with_full_beams(Mechanism mechanism) {
  for (auto& beam : mechanism.beams) {
    if (!beam.is_reduced()) continue;
    std::erase_if(mechanism.loads, [name = beam.piece_name(1)](const Load& load) {
      const auto* x = std::get_if<BeamElement>(&load);
      return x && x->made && x->name == name;
    });
    beam.modes.reset();
    add_elements(mechanism, beam);
  }
  return mechanism;
}

Mechanism idealised(Mechanism mechanism) {
  mechanism.contacts.clear();
  for (auto& group : mechanism.groups) {  // keep the bodies, without contacts
    group.walls.clear();
    group.touches.clear();
    group.alone = true;
  }
  for (auto& joint : mechanism.joints)
    std::visit(
        [](auto& j) {
          if constexpr (requires { j.clearance; }) j.clearance.reset();
        },
        joint);
  return mechanism;
}

const SpeedDrive* main_drive(const Mechanism& mechanism) {
  const SpeedDrive* first = nullptr;
  for (const auto& drive : mechanism.drives) {
    if (const auto* motion = std::get_if<MotionDrive>(&drive); motion && motion->crank) return nullptr;
    if (const auto* speed = std::get_if<SpeedDrive>(&drive)) {
      if (speed->crank) return speed;
      if (!first) first = speed;
    }
  }
  return first;
}

int crank_joint(const Mechanism& mechanism) {
  if (const auto* speed = main_drive(mechanism)) return speed->joint;
  const auto joint = [](const Drive& drive) {
    return std::visit([](const auto& d) { return d.joint; }, drive);
  };
  int motion = -1, turning = -1;
  for (const auto& drive : mechanism.drives) {
    if (!std::holds_alternative<RevoluteJoint>(mechanism.joints[joint(drive)])) continue;
    if (turning < 0) turning = joint(drive);
    const auto* prescribed = std::get_if<MotionDrive>(&drive);
    if (prescribed && prescribed->crank) return prescribed->joint;
    if (prescribed && motion < 0) motion = prescribed->joint;
  }
  return motion >= 0 ? motion : turning;
}

}  // namespace freeplay
