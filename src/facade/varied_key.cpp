#include "facade/varied_key.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "formulations/differences.hpp"
#include "io/scene/open_scene.hpp"
#include "io/scene/toml_value.hpp"
#include "io/scene/write_scene.hpp"
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

/// A key of the scene with one number, and how to write another value.
struct NumberKey {
  std::string key;                   ///< without indices
  std::string text;                  ///< value of the key
  std::size_t begin = 0, end = 0;    ///< the number within the text
  double value = 0, neighbours = 0;  ///< neighbours: greatest absolute number of its list
};

/// Position of the number with these indices in a TOML value.
std::optional<std::pair<std::size_t, std::size_t>> find_number(const std::string& text,
                                                               const std::vector<std::size_t>& indices) {
  std::size_t at = 0;
  for (const std::size_t index : indices) {
    at = text.find_first_not_of(' ', at);
    if (at == text.npos || text[at] != '[') return {};
    ++at;
    std::size_t passed = 0;
    for (int depth = 0; passed < index && at < text.size(); ++at) {
      if (text[at] == '[') ++depth;
      if (text[at] == ']' && --depth < 0) return {};
      if (text[at] == ',' && depth == 0) ++passed;
    }
    if (passed < index) return {};
  }
  at = text.find_first_not_of(' ', at);
  if (at == text.npos) return {};
  const auto end = std::min(text.find_first_of(",] #", at), text.size());
  return std::pair{at, end};
}

/// Value of a key in a scene: in the canonical text, or as the scene's own text spells it.
std::string value_text(const Scene& scene, const std::string& key) {
  for (const auto& line : canonical_lines(to_toml(scene)))
    if (!line.value.empty() && line.key == key) return line.value;
  if (const auto value = spelled_value(scene, key)) return *value;
  throw ModelError(key, "has no value in this scene; state it there, or correct the name");
}

/// Settings of the penalty formulation that are no property of a contact law.
constexpr std::array numerical_settings{"penalty.alpha", "penalty.beta", "penalty.tolerance", "penalty.step",
                                        "penalty.v0_floor"};

NumberKey number_key(const Scene& scene, const std::string& name, Family family) {
  NumberKey k;
  const auto bracket = name.find('[');
  k.key = name.substr(0, bracket);
  std::vector<std::size_t> indices;
  for (std::size_t at = bracket; at < name.size();) {
    const auto close = name.find(']', at);
    const auto index = close == name.npos ? std::nullopt : number_of(name.substr(at + 1, close - at - 1));
    if (name[at] != '[' || !index || *index < 0 || *index > 1e6 || *index != std::floor(*index))
      throw ModelError(name, "must end with indices such as [0] or [1][0]");
    indices.push_back(static_cast<std::size_t>(*index));
    at = close + 1;
  }
  const bool law =
      family == Family::penalty && std::ranges::find(numerical_settings, name) == numerical_settings.end();
  for (const char* settings : {"nonsmooth.", "penalty."})
    if (name.starts_with(settings) && !(law && name.starts_with("penalty.")))
      throw ModelError(name, "is a numerical setting, not a property of the mechanism");
  k.text = value_text(scene, k.key);
  const auto place = find_number(k.text, indices);
  const auto value =
      place ? number_of(std::string_view(k.text).substr(place->first, place->second - place->first))
            : std::nullopt;
  if (!value)
    throw ModelError(name, fmt::format("is not one number, but {}; {}", k.text,
                                       k.text.starts_with('[') ? "add indices such as [0] or [1][0]"
                                                               : "name a key with a number"));
  k.begin = place->first;
  k.end = place->second;
  k.value = *value;
  if (!indices.empty())
    for (std::size_t at = 0; at < k.text.size();) {
      const auto from = k.text.find_first_not_of("[], ", at);
      if (from == k.text.npos) break;
      at = std::min(k.text.find_first_of("[], ", from), k.text.size());
      if (const auto x = number_of(std::string_view(k.text).substr(from, at - from)))
        k.neighbours = std::max(k.neighbours, std::abs(*x));
    }
  return k;
}

void set_number(Scene& scene, const NumberKey& k, double value) {
  const auto text = k.text.substr(0, k.begin) + toml_number(value) + k.text.substr(k.end);
  try {
    scene.set(k.key, text);
  } catch (const SceneError&) {
    // The text may state the fact by another key, as run.revolutions for run.duration: try the canonical text,
    // which an empty text requests, and report the first error if that fails, too.
    Scene canonical = scene;
    canonical.text.clear();
    try {
      canonical.set(k.key, text);
    } catch (const SceneError&) {
      canonical.text.clear();
    }
    if (canonical.text.empty()) throw;
    scene = std::move(canonical);
  }
}

std::unique_ptr<DisplacedScene> displace(const Scene& scene, const NumberKey& k, double value) {
  auto d = std::make_unique<DisplacedScene>(DisplacedScene{scene, nullptr});
  set_number(d->scene, k, value);
  d->system = std::make_unique<System>(d->scene.mechanism);
  return d;
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

std::optional<double> number_of(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double x = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (error != std::errc() || rest != text.data() + text.size() || !std::isfinite(x)) return {};
  return x;
}

double number_of_key(const Scene& scene, const std::string& name, Family family) {
  return number_key(scene, name, family).value;
}

void set_number_key(Scene& scene, const std::string& name, Family family, double value) {
  set_number(scene, number_key(scene, name, family), value);
}

VariedKey vary(const Scene& scene, const System& system, const VariedStart& from, const std::string& name,
               Family family, DisplacedScenes& displaced) {
  const auto k = number_key(scene, name, family);
  VariedKey v{.name = name, .value = k.value, .start = {}, .refused = {}};
  const double scale = k.value != 0 ? std::abs(k.value) : k.neighbours > 0 ? k.neighbours : 1;
  v.spacing = relative_spacing * scale;
  const auto same = [&](const auto& d) {
    const auto& s = *d->system;
    return s.n() == system.n() && s.rows() == system.rows() && s.contacts() == system.contacts() &&
           s.states() == system.states() && s.frictions() == system.frictions();
  };
  std::string reason;
  std::vector<std::vector<double>> starts;
  for (int tries = 0; tries < 8; ++tries) {
    reason.clear();
    displaced.clear();
    starts.clear();
    try {
      for (const int place : difference_places) {
        const auto& d = *displaced.emplace_back(displace(scene, k, k.value + place * v.spacing));
        starts.push_back(from.of(d.scene, *d.system));
      }
    } catch (const ModelError& e) {
      reason = fmt::format("values beside {} are not possible: {}", k.value, e.message);
      v.spacing *= 0.1;
      continue;
    }
    if (!std::ranges::all_of(displaced, same)) break;
    const double turn = turn_between(system, *displaced[3]->system, from.start);
    if (turn <= most_turn) break;
    v.spacing *= 0.9 * most_turn / turn;
  }
  if (reason.empty() && !std::ranges::all_of(displaced, same))
    reason = "other values change the mechanism's parts";
  if (!reason.empty()) {
    v.refused = reason;
    return v;
  }
  const auto begin = difference(v.spacing, all_of(from.start), [&](std::size_t i) { return starts[i]; });
  const auto ends = difference(v.spacing, {from.end}, [&](std::size_t i) {
    return std::vector{from.end_of(displaced[i]->scene, *displaced[i]->system)};
  });
  if (!begin.smooth || !ends.smooth) v.refused = "the start changes with a kink or a jump at this value";
  const double shift = shift_between(system, *displaced[3]->system, from.start, from.end);
  v.impact_spacing = shift <= most_turn ? v.spacing : v.spacing * most_turn / shift;
  v.start = begin.slope;
  v.end_rate = ends.slope[0];
  for (std::size_t i = 0; i < v.systems.size(); ++i) {
    v.systems[i] = displaced[i]->system.get();
    v.scenes[i] = &displaced[i]->scene;
  }
  v.system_at = [&scene, k, &displaced](double value) {
    displaced.push_back(displace(scene, k, value));
    return displaced.back()->system.get();
  };
  return v;
}

}  // namespace freeplay
