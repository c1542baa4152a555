#include "analysis/varied_key.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "formulations/variation/differences.hpp"
#include "mechanism/error.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

/// Spacing of displaced values relative to the value: truncation errors of fourth order and rounding
/// errors are then both below 1e-12.
constexpr double relative_spacing = 5e-4;
/// Greatest displacement of a journal by a displaced value, over its clearance. The direction of contact
/// turns by this angle.
constexpr double most_turn = 3e-3;
/// Greatest share of the term of third order in a difference of the start. That of fifth order, the error, is
/// about the square of it.
constexpr double most_bend = 1e-5;

/// Settings of the penalty formulation that are no property of a contact law.
constexpr std::array numerical_settings{"penalty.alpha", "penalty.beta", "penalty.tolerance", "penalty.step",
                                        "penalty.v0_floor"};

/// Refuses numerical settings, with respect to which nothing is differentiated.
void require_property(const std::string& name, Family family) {
  const bool law = family == Family::penalty && name.starts_with("penalty.") &&
                   std::ranges::find(numerical_settings, name) == numerical_settings.end();
  if (!law && (name.starts_with("nonsmooth.") || name.starts_with("penalty.")))
    throw ModelError(name, "is a numerical setting, not a property of the mechanism");
}

/// Greatest displacement of a journal between two systems at one configuration, over its clearance.
double turn_between(const System& a, const System& b, const State& at) {
  auto here = a.make_evaluation(), there = b.make_evaluation();
  a.place(at.t, at.q.data(), here);
  b.place(at.t, at.q.data(), there);
  double most = 0;
  for (int k = 0; k < a.contacts(); ++k) {
    if (!a.contact_facts(k).has_clearance) continue;
    const auto x = a.eccentricity(k, at.q.data(), here), y = b.eccentricity(k, at.q.data(), there);
    most = std::max(most, std::hypot(x.x() - y.x(), x.y() - y.y()) / a.contact_facts(k).clearance);
  }
  return most;
}

/// Whether the outer values of a difference of (q, v, z) give nearly its slope of fourth order. n: size of q
bool is_straight(const std::vector<double>& slope, const std::vector<std::vector<double>>& values,
                 double spacing, std::size_t n) {
  double greatest[3] = {}, bend[3] = {};
  for (std::size_t i = 0; i < slope.size(); ++i) {
    const auto part = std::min<std::size_t>(i / std::max<std::size_t>(n, 1), 2);
    greatest[part] = std::max(greatest[part], std::abs(slope[i]));
    bend[part] = std::max(bend[part], std::abs(slope[i] - (values[3][i] - values[0][i]) / (4 * spacing)));
  }
  return std::ranges::all_of(std::array{0, 1, 2}, [&](int i) { return bend[i] <= most_bend * greatest[i]; });
}

/// Greatest displacement of a point by the projection onto the constraints of the other system until the end
/// of the run, over the least clearance.
double shift_between(const System& a, const System& b, const State& at, double end) {
  double least = INFINITY, most = 0;
  for (int k = 0; k < a.contacts(); ++k)
    if (a.contact_facts(k).has_clearance) least = std::min(least, a.contact_facts(k).clearance);
  auto here = a.make_evaluation(), there = b.make_evaluation();
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const double t = at.t + share * (end - at.t);
    a.place(t, at.q.data(), here);
    b.place(t, at.q.data(), there);
    for (int k = 0; k < a.rows(); ++k)
      most = std::max(
          most, std::abs(here.phi[k] - there.phi[k]) * (a.is_angle_row(k) ? a.longest_arm() : 1) / least);
  }
  return most;
}

}  // namespace

Parameter property(const Scene& scene, const std::string& name, Family family) {
  require_property(name, family);
  return {scene, name};
}

VariedKey vary(const Scene& scene, const System& system, const VariedStart& from, const std::string& name,
               Family family, DisplacedScenes& displaced, double share) {
  const auto key = property(scene, name, family);
  const double value = key.value();
  VariedKey v{.name = name, .value = value, .start = {}, .refused = {}};
  const double scale = value != 0 ? std::abs(value) : key.greatest() > 0 ? key.greatest() : 1;
  v.spacing = share * relative_spacing * scale;
  const auto same = [&](const auto& d) {
    const auto& s = d->system;
    return s.n() == system.n() && s.rows() == system.rows() && s.contacts() == system.contacts() &&
           s.states() == system.states() && s.frictions() == system.frictions();
  };
  // Whether rounding alone makes the difference of the starts look unsmooth.
  const auto only_rounds = [&](const Difference& wide) {
    constexpr double ratio = 0.03;
    try {
      return is_rounding(wide,
                         difference(ratio * v.spacing, all_of(from.start),
                                    [&](std::size_t i) {
                                      const auto& d =
                                          displaced.at(key, value + difference_places[i] * ratio * v.spacing);
                                      return from.of(d.scene, d.system);
                                    }),
                         ratio);
    } catch (const ModelError&) {
      return false;
    }
  };
  // The start is a function of the key alone: its difference keeps the widest spacing over which the start is
  // nearly linear. The systems are compared at one configuration, where a displaced journal turns its
  // contact.
  std::string reason;
  std::vector<const DisplacedScene*> list;
  std::vector<double> start, end;  // derivatives
  bool is_smooth = false;
  for (int tries = 0; tries < 8; ++tries) {
    reason.clear();
    list.clear();
    std::vector<std::vector<double>> starts;
    try {
      for (const int place : difference_places) {
        const auto& d = *list.emplace_back(&displaced.at(key, value + place * v.spacing));
        if (start.empty()) starts.push_back(from.of(d.scene, d.system));
      }
    } catch (const ModelError& e) {
      reason = fmt::format("values beside {} are not possible: {}", value, e.message);
      v.spacing *= 0.1;
      continue;
    }
    if (!std::ranges::all_of(list, same)) {
      reason = "other values change the mechanism's parts";
      break;
    }
    const double turn = turn_between(system, list[3]->system, from.start);
    if (start.empty()) {
      const auto begin = difference(v.spacing, all_of(from.start), [&](std::size_t i) { return starts[i]; });
      const auto ends = difference(v.spacing, {from.end}, [&](std::size_t i) {
        return std::vector{from.end_of(list[i]->scene, list[i]->system)};
      });
      is_smooth = ends.smooth && (begin.smooth || only_rounds(begin));
      if (turn <= share * most_turn ||
          (is_smooth && is_straight(begin.slope, starts, v.spacing, from.start.q.size()))) {
        start = begin.slope;
        end = ends.slope;
      }
    }
    if (turn <= share * most_turn) break;
    v.spacing *= 0.9 * share * most_turn / turn;
  }
  if (!reason.empty()) {
    v.refused = reason;
    return v;
  }
  if (!is_smooth || start.empty()) v.refused = "the start changes with a kink or a jump at this value";
  const double shift = shift_between(system, list[3]->system, from.start, from.end);
  v.impact_spacing = shift <= share * most_turn ? v.spacing : v.spacing * share * most_turn / shift;
  v.start = std::move(start);
  v.end_rate = end.empty() ? 0 : end[0];
  for (std::size_t i = 0; i < v.systems.size(); ++i) {
    v.systems[i] = &list[i]->system;
    v.scenes[i] = &list[i]->scene;
  }
  v.system_at = [key, &displaced](double at) { return &displaced.at(key, at).system; };
  return v;
}

}  // namespace freeplay
