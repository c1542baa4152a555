#include "dynamics/assembly/meshing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/joint_places.hpp"
#include "dynamics/assembly/other_starts.hpp"
#include "dynamics/assembly/stated.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

/// Calls see(joint) for each gear and rack.
void each_toothed(auto& mechanism, auto see) {
  for (auto& joint : mechanism.joints)
    std::visit(
        [&](auto& j) {
          if constexpr (requires { j.phase; }) see(j);
        },
        joint);
}

/// The phase with which the teeth of a joint mesh at q; empty if they are too far apart.
std::optional<double> phase_at(const auto& joint, const std::vector<double>& q) {
  const auto body = [&](int index) {
    Body b;
    if (index == ground) return b;
    b.position = planar::position(q.data(), static_cast<std::size_t>(index));
    b.angle = planar::angle(q.data(), index);
    return b;
  };
  return joint.phase_of(body(joint.between[0]), body(joint.between[1]), !joint.clearance);
}

/// The mechanism with ideal joints, without loads and teeth.
Mechanism without_teeth(const Mechanism& mechanism) {
  auto m = idealised(mechanism);
  m.loads.clear();
  each_toothed(m, [](auto& joint) { joint.phase.reset(); });
  return m;
}

bool no_position(const std::vector<double>& q) {
  for (std::size_t b = 0; b < q.size() / planar::coordinates; ++b)
    if (!planar::position(q.data(), b).is_zero()) return false;
  return true;
}

/// Whether a joint of `m`, not a drive, is open at q.
bool is_open(const Mechanism& m, const std::vector<double>& q) {
  const System system(m);
  const double length = std::max(system.longest_arm(), 1e-18);
  return std::ranges::any_of(open_joints(system, q, length), [&](const OpenJoint& o) {
    return !o.drive && (o.angular ? length : 1) * o.amount > 1e-9 * length;
  });
}

std::string why_apart(const GearJoint& joint, const std::vector<double>& q) {
  const double distance = (end_place(joint, 1, q) - end_place(joint, 0, q)).norm();
  return fmt::format(
      "there the centres are too close for these gears, or too far apart: {:.6g} m instead of "
      "{:.6g} m",
      distance, joint.pitch(0) + (joint.internal ? -1 : 1) * joint.pitch(1));
}
std::string why_apart(const RackJoint&, const std::vector<double>&) {
  return "there the gear does not lie on the left of the rack's axis";
}

/// The first end of a toothed joint whose point is the origin of its body, the default of `at`, although
/// revolute joints hold this body at other points only; empty if there is none.
std::optional<std::size_t> end_at_origin(const Mechanism& mechanism, const auto& joint) {
  for (const std::size_t end : {0u, 1u}) {
    if (!joint.at[end].is_zero()) continue;
    bool held = false, centred = false;
    for (const auto& other : mechanism.joints)
      if (const auto* pin = std::get_if<RevoluteJoint>(&other))
        for (const std::size_t k : {0u, 1u})
          if (pin->between[k] == joint.between[end]) held = true, centred = centred || pin->at[k].is_zero();
    if (held && !centred) return end;
  }
  return {};
}

/// Why the teeth of a joint without phase do not mesh at q.
ModelError out_of_mesh(const Mechanism& mechanism, const auto& joint, const std::vector<double>& q) {
  const auto why = why_apart(joint, q);
  const auto end = end_at_origin(mechanism, joint);
  if (!end)
    return {"joints." + joint.name,
            fmt::format("phase follows from the bodies' positions, and {}; give the bodies' position, or "
                        "phase",
                        why)};
  const int body = joint.between[*end];
  const auto name = body == ground ? "ground" : mechanism.bodies[static_cast<std::size_t>(body)].name;
  return {fmt::format("joints.{}.at", joint.name),
          fmt::format("is [0, 0] on {} (the default), where no revolute joint holds it, and {}; give at, the "
                      "points of the teeth on both bodies",
                      name, why)};
}

/// Length of a tangent to the circle of radius `base` from a point at radius r.
double beyond(double r, double base) { return std::sqrt(std::max(r * r - base * base, 0.0)); }

TeethAtDistance teeth_of(const GearJoint& g, const std::vector<double>& q) {
  const double kind = g.internal ? -1 : 1, one = g.pitch(0), other = g.pitch(1),
               module = g.tooth_module.value_or(std::min(one, other) / 3), tip = one + kind * module,
               other_tip = other + module;
  const auto flank = g.mesh(1, g.clearance ? g.clearance->normal : 0);
  const double a = (end_place(g, 1, q) - end_place(g, 0, q)).norm(), S = flank.sum();
  TeethAtDistance t{g.name, false, !g.clearance, a, one + kind * other};
  t.apart = kind * (a - tip) - other_tip;
  t.play = 2 * (kind * flank.involute(a) + flank.rest);
  if (g.teeth)
    t.contact_ratio =
        (kind * (beyond(tip, flank.Ri) - beyond(a, S)) + beyond(other_tip, flank.Rj)) / flank.period;
  return t;
}

TeethAtDistance teeth_of(const RackJoint& rack, const std::vector<double>& q) {
  const double r = rack.pitch_radius, module = rack.tooth_module.value_or(r / 3);
  const auto flank = rack.mesh(1, rack.clearance ? rack.clearance->normal : 0);
  Body turn;
  if (rack.between[1] != ground) turn.angle = planar::angle(q.data(), rack.between[1]);
  const Vec2 along = GearJoint::placed(turn, rack.axis);
  const double h = dot(perp(along), end_place(rack, 0, q) - end_place(rack, 1, q));
  TeethAtDistance t{rack.name, true, !rack.clearance, h, r};
  t.apart = h - r - 2 * module;
  t.play = 2 * (flank.rest + flank.sine * h);
  if (rack.tooth_module)
    t.contact_ratio = (beyond(r + module, flank.base) - r * flank.sine +
                       std::min((module - h + r) / flank.sine, r * flank.sine)) /
                      flank.period;
  return t;
}

}  // namespace

bool in_mesh(const Mechanism& mechanism, const std::vector<double>& q) {
  bool any = false, all = true;
  each_toothed(mechanism, [&](const auto& joint) {
    if (!joint.phase) return;
    any = true;
    all = all && phase_at(joint, q);
  });
  return !any || (all && !(no_position(q) && is_open(without_teeth(mechanism), q)));
}

std::vector<double> pose_without_teeth(const Mechanism& mechanism, std::vector<double> q,
                                       const StopToken& stop) {
  auto m = without_teeth(mechanism);
  const auto given = q;
  if (no_position(q)) q = hung(m, q);
  State rough;
  rough.q = std::move(q);
  rough.v.assign(rough.q.size(), 0);
  start_from(m, rough);
  m.assembly.approximate = true;
  try {
    return assemble(m, RunOptions::Start::ideal, nullptr, stop).q;
  } catch (const ModelError&) {
    return given;
  }
}

void set_phases(Mechanism& mechanism) {
  bool absent = false;
  auto meshed = mechanism;
  each_toothed(meshed, [&](auto& joint) {
    absent = absent || !joint.phase;
    joint.phase = joint.phase.value_or(0);
  });
  if (!absent) return;
  auto q = stated_state(mechanism).q;
  if (!in_mesh(meshed, q)) q = pose_without_teeth(meshed, q);
  each_toothed(mechanism, [&](auto& joint) {
    if (joint.phase) return;
    joint.phase = phase_at(joint, q);
    if (!joint.phase) throw out_of_mesh(mechanism, joint, q);
  });
}

std::vector<TeethAtDistance> teeth_at(const Mechanism& mechanism, const std::vector<double>& q) {
  std::vector<TeethAtDistance> list;
  each_toothed(mechanism, [&](const auto& joint) {
    if (joint.phase) list.push_back(teeth_of(joint, q));
  });
  return list;
}

void require_mesh(const Mechanism& mechanism, const std::vector<double>& q) {
  for (const auto& t : teeth_at(mechanism, q))
    if (t.ideal && t.apart >= 0)
      throw ModelError(
          "joints." + t.name,
          fmt::format(
              "{} {:.6g} m apart, {:.3g} m too far for the tips of the teeth to meet ({} at {:.6g} m); "
              "correct the places or the teeth",
              t.rack ? "the gear's centre and the rack's pitch line are" : "the centres are", t.distance,
              t.apart, t.rack ? "the pitch circle touches the line" : "the pitch circles touch", t.standard));
}

}  // namespace freeplay
