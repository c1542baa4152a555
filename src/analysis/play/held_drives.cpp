#include "analysis/play/held_drives.hpp"

#include <fmt/format.h>

#include "mechanism/error.hpp"
#include "mechanism/piecewise.hpp"

namespace freeplay {

std::optional<PrescribedJoint> prescribed_joint(const Drive& drive, const Mechanism& m) {
  if (const auto* speed = std::get_if<SpeedDrive>(&drive))
    return PrescribedJoint{speed->joint, speed->initial_angle};
  const auto* motion = std::get_if<MotionDrive>(&drive);
  if (!motion || motion->of >= 0) return {};
  return PrescribedJoint{motion->joint, motion->course(m.curves).jet(0.0).value};
}

Mechanism held(Mechanism m, int over, std::optional<double> place) {
  const auto before = m;
  const auto curve = [&](double rate) {
    Curve c;
    c.name = rate == 0 ? "held" : "advanced";
    c.value = rate;
    m.curves.push_back(c);
    return static_cast<int>(m.curves.size()) - 1;
  };
  const int rest = curve(0), advance = curve(1);
  for (auto& drive : m.drives) {
    const auto found = prescribed_joint(drive, before);
    if (!found) continue;
    MotionDrive motion;
    motion.name = name_of(drive);
    motion.joint = found->joint;
    const bool moves = found->joint == over && !place;
    motion.velocity = moves ? advance : rest;
    motion.initial = moves ? 0 : found->joint == over ? *place : found->start;
    drive = motion;
  }
  return m;
}

PrescribedJoint driven_joint(const Mechanism& m, const std::string& name) {
  std::string known;
  for (const auto& drive : m.drives) {
    const auto found = prescribed_joint(drive, m);
    if (!found) continue;
    const auto& joint = name_of(m.joints[static_cast<std::size_t>(found->joint)]);
    if (name.empty() ? found->joint == crank_joint(m) : joint == name) return *found;
    known += (known.empty() ? "" : ", ") + joint;
  }
  if (name.empty()) return {};
  throw ModelError("--over", fmt::format("no drive prescribes the motion of a joint \"{}\"; such joints: {}",
                                         name, known.empty() ? "none" : known));
}

}  // namespace freeplay
