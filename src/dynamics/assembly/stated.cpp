#include "dynamics/assembly/stated.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/assembly/assembly.hpp"
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
  std::string text;
  for (std::size_t i = 0; i < std::min(changes.size(), listed_changes); ++i)
    text += fmt::format("{}{} by {:.4g} {}", i > 0 ? ", " : "", changes[i].key, changes[i].amount,
                        changes[i].unit);
  return changes.size() > listed_changes
             ? fmt::format("{}, and {} more", text, changes.size() - listed_changes)
             : text;
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

namespace {

/// Rates of the constraints at one position.
class Rates {
 public:
  Rates(const Mechanism& mechanism, const System& system, const State& s)
      : mechanism_(mechanism), system_(system), e_(system.make_evaluation()), r_(e_.phi.size()) {
    system.place(0, s.q.data(), e_);
    redundant_ = !redundant_rows(system, s.q).empty();
  }
  /// v += least change in the metric that satisfies the rates; two passes, the second of which
  /// removes the rounding of the first.
  void satisfy(const Metric& metric, std::vector<double>& v) {
    MovableRows rows(system_, metric, redundant_);
    rows.choose(e_.G);
    if (!rows.factor(e_.G))
      throw ModelError("",
                       "the velocities cannot be made consistent: a mass, length or speed exceeds the range "
                       "of numbers");
    std::vector<double> dv(v.size());
    for (int i = 0; i < 2; ++i) {
      worst(v);
      rows.solve(nullptr, r_, dv);
      for (std::size_t c = 0; c < v.size(); ++c) v[c] += dv[c];
    }
  }
  /// The row with the greatest violation, with its amount (m/s, rad/s) in r_.
  std::pair<double, int> worst(const std::vector<double>& v) {
    std::pair<double, int> found{0, -1};
    for (int k = 0; k < system_.rows(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      r_[i] = -e_.phi_t[i] - row_dot(system_.pattern(), e_.G.data(), k, v.data());
      if (std::abs(r_[i]) > found.first) found = {std::abs(r_[i]), k};
    }
    return found;
  }
  OpenJoint open(const std::vector<double>& v) {
    const auto [amount, row] = worst(v);
    if (row < 0) return {};
    return {system_.row_name(row), amount, system_.is_angle_row(row), false,
            row >= system_.rows() - system_.drive_rows()};
  }
  /// Scale of rounding: the size of the terms of the constraint rates.
  double terms(const std::vector<double>& v) {
    double most = worst(v).first;
    for (int k = 0; k < system_.rows(); ++k) {
      double sum = std::abs(e_.phi_t[static_cast<std::size_t>(k)]);
      for (int i = system_.pattern().begin[k]; i < system_.pattern().begin[k + 1]; ++i)
        sum += std::abs(e_.G[static_cast<std::size_t>(i)] * v[system_.pattern().column[i]]);
      most = std::max(most, sum);
    }
    return most;
  }
  void refuse_if_open(const State& s, double terms) {
    const auto [amount, row] = worst(s.v);
    if (amount > 1e-9 * terms)
      throw ModelError(
          key_of(mechanism_, open(s.v)),
          fmt::format("no velocities satisfy all constraints; this one is violated by {:.3g} {}: the drives "
                      "contradict each other, or the start is a locked position",
                      amount, system_.is_angle_row(row) ? "rad/s" : "m/s"));
  }

 private:
  const Mechanism& mechanism_;
  const System& system_;
  Evaluation e_;
  std::vector<double> r_;
  bool redundant_ = false;
};

}  // namespace

OpenJoint assemble_velocities(const Mechanism& mechanism, const System& system,
                              const std::vector<char>& stated, State& s) {
  constexpr double closed = 1e-9;  // of the terms of the rates
  Rates rates(mechanism, system, s);
  const Metric whole{system.mass()};
  double terms = rates.terms(s.v);
  OpenJoint violated;
  if (any(stated)) {
    const Metric holding{system.mass(), stated};
    const auto rough = s.v;
    rates.satisfy(holding, s.v);
    terms = std::max(terms, rates.terms(s.v));
    violated = rates.open(s.v);
    if (violated.amount > closed * terms) {
      // Each pass begins at the last one's absent velocities, whose weight then has no effect.
      for (int i = 0; i < 3; ++i) {
        for (std::size_t c = 0; c < s.v.size(); ++c)
          if (stated[c]) s.v[c] = rough[c];
        rates.satisfy(light_where_absent(system, stated), s.v);
      }
      // Absent velocities that the corrected ones leave open are nearest to the rough ones.
      auto settled = s.v;
      for (std::size_t c = 0; c < settled.size(); ++c)
        if (!stated[c]) settled[c] = rough[c];
      rates.satisfy(holding, settled);
      if (rates.worst(settled).first <= closed * terms) s.v = settled;
    }
  }
  rates.satisfy(whole, s.v);
  rates.refuse_if_open(s, terms);
  return violated;
}

}  // namespace freeplay
