#include "facade/sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "facade/identify.hpp"
#include "facade/simulation.hpp"
#include "formulations/differences.hpp"
#include "formulations/make.hpp"
#include "formulations/sensitivity.hpp"
#include "io/scene/toml_value.hpp"
#include "io/scene/write_scene.hpp"
#include "mechanism/scene.hpp"
#include "simulation/instrument.hpp"

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

std::optional<double> number_of(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double x = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (error != std::errc() || rest != text.data() + text.size() || !std::isfinite(x)) return {};
  return x;
}

/// Value of a key in a scene: in the canonical text, or as the scene's own text spells it.
std::string value_text(const Scene& scene, const std::string& key) {
  for (const auto& text : {to_toml(scene), scene.text})
    for (const auto& line : canonical_lines(text)) {
      const auto last = line.key.find_last_not_of(' ');
      if (!line.value.empty() && line.key.substr(0, last + 1) == key) return line.value;
    }
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

/// A scene with another value of a key, with its system.
struct DisplacedScene {
  DisplacedScene(const Scene& given, const NumberKey& k, double value) : scene(given) {
    scene.set(k.key, k.text.substr(0, k.begin) + toml_number(value) + k.text.substr(k.end));
    system = std::make_unique<System>(scene.mechanism);
  }
  Scene scene;
  std::unique_ptr<System> system;
};

std::vector<double> all_of(const State& s) {
  auto all = s.q;
  all.insert(all.end(), s.v.begin(), s.v.end());
  all.insert(all.end(), s.z.begin(), s.z.end());
  return all;
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

/// The displaced scenes of a key; the first four are those of VariedKey::systems.
using DisplacedScenes = std::vector<std::unique_ptr<DisplacedScene>>;

/// Builds the displaced scenes of a key. A key at the end of its range, or one whose start cannot be
/// assembled beside it, has no derivative.
VariedKey vary(const Scene& scene, const System& system, const State& start, const std::string& name,
               Family family, const StopToken& stop, DisplacedScenes& displaced) {
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
        const auto& d =
            *displaced.emplace_back(std::make_unique<DisplacedScene>(scene, k, k.value + place * v.spacing));
        const bool rests = d.scene.run.start == RunOptions::Start::equilibrium;
        starts.push_back(all_of(assemble(d.scene.mechanism, d.scene.run.start, nullptr, stop,
                                         rests ? compliances(family, d.scene, *d.system) : Compliances{})));
      }
    } catch (const ModelError& e) {
      reason = fmt::format("values beside {} are not possible: {}", k.value, e.message);
      v.spacing *= 0.1;
      continue;
    }
    if (!std::ranges::all_of(displaced, same)) break;
    const double turn = turn_between(system, *displaced[3]->system, start);
    if (turn <= most_turn) break;
    v.spacing *= 0.9 * most_turn / turn;
  }
  if (reason.empty() && !std::ranges::all_of(displaced, same))
    reason = "other values change the mechanism's parts";
  if (!reason.empty()) {
    v.refused = reason;
    return v;
  }
  const auto from = difference(v.spacing, all_of(start), [&](std::size_t i) { return starts[i]; });
  const auto ends = difference(v.spacing, {scene.run.duration},
                               [&](std::size_t i) { return std::vector{displaced[i]->scene.run.duration}; });
  if (!from.smooth || !ends.smooth) v.refused = "the start changes with a kink or a jump at this value";
  const double shift = shift_between(system, *displaced[3]->system, start, scene.run.duration);
  v.impact_spacing = shift <= most_turn ? v.spacing : v.spacing * most_turn / shift;
  v.start = from.slope;
  v.end_rate = ends.slope[0];
  for (std::size_t i = 0; i < v.systems.size(); ++i) {
    v.systems[i] = displaced[i]->system.get();
    v.scenes[i] = &displaced[i]->scene;
  }
  v.system_at = [&scene, k, &displaced](double value) {
    displaced.push_back(std::make_unique<DisplacedScene>(scene, k, value));
    return displaced.back()->system.get();
  };
  return v;
}

const Column* find_column(const std::vector<Column>& columns, const std::string& name) {
  const auto found = std::ranges::find(columns, name, &Column::name);
  return found == columns.end() ? nullptr : &*found;
}

VariedKey initial_value(const Layout& layout, const State& start, const std::string& name) {
  const auto columns = trajectory_columns(layout);
  const auto* column = find_column(columns, name.substr(name.find('.') + 1));
  if (!column || (column->of != Column::Of::position && column->of != Column::Of::velocity))
    throw ModelError(name, "must be initial.BODY.PART with PART x, y, theta, vx, vy or omega");
  const bool rate = column->of == Column::Of::velocity;
  VariedKey v{.name = name, .value = (rate ? start.v : start.q)[column->index], .start = {}, .refused = {}};
  v.start.resize(start.q.size() + start.v.size() + start.z.size());
  v.start[column->index + (rate ? start.q.size() : 0)] = 1;
  return v;
}

VariedQuantity event_quantity(const std::string& name) {
  VariedQuantity q{.name = name, .column = {}};
  const auto first = name.find('.'), second = name.find('.', first + 1);
  const auto number = number_of(name.substr(first + 1, second - first - 1));
  const auto part = second == name.npos ? "" : name.substr(second + 1);
  using Of = VariedQuantity::Of;
  const std::pair<const char*, Of> parts[] = {
      {"t", Of::event_time}, {"v_n_minus", Of::event_rate}, {"impulse_n", Of::event_impulse}};
  const auto found = std::ranges::find_if(parts, [&](const auto& p) { return part == p.first; });
  if (!number || *number < 1 || *number > 1e9 || *number != std::floor(*number) || found == std::end(parts))
    throw ModelError(name, "must be event.N.t, event.N.v_n_minus or event.N.impulse_n with N from 1");
  q.of = found->second;
  q.event = static_cast<std::size_t>(*number);
  return q;
}

VariedQuantity peak_quantity(const Scene& scene, const System& system, const std::string& name) {
  const auto channel = name.substr(name.find('.') + 1);
  const auto found = std::ranges::find(scene.instruments, channel, &Instrument::name);
  if (found == scene.instruments.end())
    throw ModelError(name, fmt::format("\"{}\" is no instrument of the scene", channel));
  const Channel measured(*found);
  if (measured.sensing() == Sensing::force)
    throw ModelError(name,
                     "peaks of forces have no derivatives yet; use an instrument of a motion, or mean.");
  VariedQuantity q{.name = name, .of = VariedQuantity::Of::peak, .column = {}};
  q.channel.name = channel;
  q.channel.range = found->range;
  q.channel.filtered = measured.sensing() == Sensing::velocity;
  // Instruments measure linear functions.
  const auto n = static_cast<std::size_t>(system.n());
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<double> unit(n);
    unit[i] = 1;
    q.channel.weights.push_back(measured.measure(unit.data()));
  }
  if (!q.channel.filtered) return q;
  if (found->order == 1)
    throw ModelError(name,
                     "impacts make the signal of a low-pass of first order jump; use order = 2 or more");
  const LowPass low(found->bandwidth, found->order);
  q.channel.poles.assign(low.poles().begin(), low.poles().end());
  q.channel.residues.assign(low.residues().begin(), low.residues().end());
  return q;
}

VariedQuantity quantity_of(const Scene& scene, const System& system, const Layout& layout,
                           const std::string& name) {
  if (name.starts_with("event.")) return event_quantity(name);
  if (name.starts_with("peak.")) return peak_quantity(scene, system, name);
  VariedQuantity q{.name = name, .column = {}};
  const auto rest = name.substr(std::min(name.find('.') + 1, name.size()));
  if (name.starts_with("energy.")) {
    q.of = VariedQuantity::Of::energy;
    for (const auto& e : energy_quantities) {
      if (rest != e.text) continue;
      q.term = e.term;
      return q;
    }
    std::string words;
    for (const auto& e : energy_quantities) words += fmt::format("{}{}", words.empty() ? "" : ", ", e.text);
    throw ModelError(name, "must be energy. and one of " + words);
  }
  if (!name.starts_with("end.") && !name.starts_with("mean."))
    throw ModelError(name, "must begin with event., end., mean., peak. or energy.");
  q.of = name.starts_with("end.") ? VariedQuantity::Of::end : VariedQuantity::Of::mean;
  for (const auto& columns : {trajectory_columns(layout), force_columns(layout)})
    if (const auto* c = find_column(columns, rest);
        c && c->of != Column::Of::time && c->of != Column::Of::mean) {
      q.column = *c;
      return q;
    }
  throw ModelError(name, fmt::format("\"{}\" is no column of trajectory.csv or forces.csv", rest));
}

}  // namespace

Sensitivities sensitivities(const Scene& scene, const SensitivityRequest& request) {
  const auto family = family_of(request.formulation);
  Simulation simulation(scene, request.formulation, {.start = {}, .stop = request.stop});
  const auto& layout = simulation.layout();
  const auto& given = simulation.scene();
  const System system(given.mechanism);
  SensitivityRun run{.scene = given,
                     .system = system,
                     .start = simulation.state(),
                     .end = given.run.duration,
                     .keys = {},
                     .quantities = {},
                     .stop = request.stop};
  for (const auto& name : request.of) run.quantities.push_back(quantity_of(given, system, layout, name));
  std::vector<DisplacedScenes> displaced(request.to.size());
  for (std::size_t i = 0; i < request.to.size(); ++i)
    run.keys.push_back(request.to[i].starts_with("initial.") ? initial_value(layout, run.start, request.to[i])
                                                             : vary(given, system, run.start, request.to[i],
                                                                    family, request.stop, displaced[i]));
  return run_sensitivities(run, family);
}

double propagated_deviation(const Sensitivity& quantity, const std::vector<double>& deviations) {
  double sum = 0;
  for (std::size_t i = 0; i < deviations.size(); ++i) {
    if (deviations[i] == 0) continue;
    const double part = quantity.derivatives[i] * deviations[i];
    sum += part * part;
  }
  return std::sqrt(sum);
}

}  // namespace freeplay
