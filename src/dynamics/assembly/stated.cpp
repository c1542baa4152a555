#include "dynamics/assembly/stated.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

std::vector<char> stated(const Mechanism& m, auto of_centre, auto of_angle) {
  std::vector<char> list;
  for (const auto& b : m.bodies) {
    const char centre = (b.*of_centre).has_value(), angle = (b.*of_angle).has_value() && !b.point;
    list.insert(list.end(), {centre, centre, angle});
  }
  return list;
}

/// The list without unchanged values, sorted. Equal changes keep the mechanism's order.
std::vector<Change> sorted(std::vector<Change> list) {
  std::erase_if(list, [](const Change& c) { return !(c.relative > silent_change); });
  std::ranges::stable_sort(list, std::ranges::greater{}, &Change::relative);
  return list;
}

}  // namespace

std::vector<char> stated_positions(const Mechanism& m) { return stated(m, &Body::position, &Body::angle); }
std::vector<char> stated_velocities(const Mechanism& m) {
  return stated(m, &Body::velocity, &Body::angular_velocity);
}

State stated_state(const Mechanism& m) {
  State s;
  for (const auto& b : m.bodies) {
    const Vec2 at = b.position.value_or(Vec2{}), rate = b.velocity.value_or(Vec2{});
    s.q.insert(s.q.end(), {at.x(), at.y(), b.angle.value_or(0)});
    s.v.insert(s.v.end(), {rate.x(), rate.y(), b.angular_velocity.value_or(0)});
  }
  return s;
}

bool any(const std::vector<char>& stated) {
  return std::ranges::any_of(stated, [](char c) { return c != 0; });
}

Metric light_where_absent(const System& system, const std::vector<char>& stated) {
  constexpr double light = 1e-6;
  Metric metric{system.mass()};
  if (!any(stated)) return metric;
  for (std::size_t c = 0; c < stated.size(); ++c)
    if (!stated[c]) metric.weight[c] *= light;
  return metric;
}

std::vector<Change> changed_positions(const Mechanism& m, const std::vector<double>& q, double length) {
  std::vector<Change> list;
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    const auto& body = m.bodies[b];
    const auto add = [&](const char* key, double amount, double scale, const char* unit) {
      list.push_back({fmt::format("bodies.{}.{}", body.name, key), amount, amount / scale, unit});
    };
    if (body.position) add("position", (planar::position(q.data(), b) - *body.position).norm(), length, "m");
    if (body.angle) add("angle", std::abs(planar::angle(q.data(), b) - *body.angle), 1, "rad");
  }
  return sorted(std::move(list));
}

std::vector<Change> changed_velocities(const Mechanism& m, const std::vector<double>& v, double length,
                                       double speed) {
  constexpr double least = 1e-2;  // of the greatest: the scale of a stated zero
  std::vector<Change> list;
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    const auto& body = m.bodies[b];
    const auto add = [&](const char* key, double amount, double size, double greatest, const char* unit) {
      if (amount > 0)
        list.push_back({fmt::format("bodies.{}.{}", body.name, key), amount,
                        amount / std::max(size, least * greatest), unit});
    };
    if (body.velocity)
      add("velocity", (planar::velocity(v.data(), b) - *body.velocity).norm(), body.velocity->norm(), speed,
          "m/s");
    if (body.angular_velocity)
      add("angular_velocity", std::abs(planar::rate(v.data(), b) - *body.angular_velocity),
          std::abs(*body.angular_velocity), speed / length, "rad/s");
  }
  return sorted(std::move(list));
}

double speed_scale(const Mechanism& m, const std::vector<double>& v, double length) {
  // Speeds of rounding size, as beside stated zeros, are no scale.
  double speed = 1e-3 * length;  // m/s: in a second a thousandth of the length
  const auto stated = stated_state(m).v;
  for (const auto* list : {&v, &stated})
    for (std::size_t b = 0; b < m.bodies.size(); ++b)
      speed = std::max({speed, planar::velocity(list->data(), b).norm(),
                        length * std::abs(planar::rate(list->data(), b))});
  for (const auto& drive : m.drives) {
    if (const auto* d = std::get_if<SpeedDrive>(&drive)) speed = std::max(speed, length * std::abs(d->speed));
    if (const auto* d = std::get_if<MotionDrive>(&drive))
      speed = std::max({speed, length * d->pace(m), d->slide_pace(m)});
  }
  return speed;
}

std::string listed(const std::vector<Change>& changes) {
  constexpr std::size_t shown = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(changes.size(), shown); ++i)
    text += fmt::format("{}{} by {:.4g} {}", i > 0 ? ", " : "", changes[i].key, changes[i].amount,
                        changes[i].unit);
  return changes.size() > shown ? fmt::format("{}, and {} more", text, changes.size() - shown) : text;
}

void report_changes(const Mechanism& m, const std::vector<Change>& changes, const OpenJoint& open,
                    const char* per, double limit, std::string& note) {
  if (changes.empty()) return;
  const auto joint = open.name.empty() ? std::string("the constraints")
                                       : fmt::format("{} ({} {:.4g} {}{})", key_of(m, open),
                                                     open.overlap ? "overlaps by" : "open by", open.amount,
                                                     open.angular ? "rad" : "m", per);
  if (changes.front().relative > limit)
    throw ModelError(changes.front().key,
                     fmt::format("the stated initial values contradict {}: it would change {}; correct or "
                                 "remove one of them, or give assembly.approximate = true",
                                 joint, listed(changes)));
  note += fmt::format("{}stated values changed to satisfy {}: {}", note.empty() ? "" : "; ", joint,
                      listed(changes));
}

}  // namespace freeplay
