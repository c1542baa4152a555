#include "facade/sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "facade/compile.hpp"
#include "facade/identify.hpp"
#include "facade/simulation.hpp"
#include "facade/varied_key.hpp"
#include "formulations/differences.hpp"
#include "formulations/make.hpp"
#include "formulations/sensitivity.hpp"
#include "io/scene/spelling.hpp"
#include "mechanism/scene.hpp"
#include "simulation/instrument.hpp"

namespace freeplay {
namespace {

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
    throw ModelError(name, "peaks of forces have no derivatives; use an instrument of a motion, or mean.");
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
  std::vector<std::string> names;
  for (const auto& columns : {trajectory_columns(layout), force_columns(layout)})
    for (const auto& c : columns) {
      const bool varies = c.of != Column::Of::time && c.of != Column::Of::mean;
      if (c.name() == rest && varies) {
        q.column = c;
        return q;
      }
      if (c.name() == rest)
        throw ModelError(name,
                         fmt::format("\"{}\" has no derivative: it is the time, or a mean over a row", rest));
      if (varies) names.push_back(c.name());
    }
  throw ModelError(name, fmt::format("\"{}\" is no column of trajectory.csv or forces.csv{}", rest,
                                     meant(rest, names, "there is")));
}

/// The peak of a quantity with respect to a key of its instrument, which leaves the motion alone: peaks of the
/// same motion behind displaced instruments.
struct VariedInstrument {
  std::size_t quantity = 0, key = 0;
  std::size_t first = 0;  ///< of its four quantities, one for each displaced value
};

bool same_signal(const PeakChannel& a, const PeakChannel& b) {
  return a.filtered == b.filtered && a.weights == b.weights && a.poles == b.poles && a.residues == b.residues;
}

/// Adds the quantities behind displaced instruments to the run.
std::vector<VariedInstrument> add_instruments(SensitivityRun& run) {
  std::vector<VariedInstrument> varied;
  const auto count = run.quantities.size();
  for (std::size_t q = 0; q < count; ++q) {
    if (run.quantities[q].of != VariedQuantity::Of::peak) continue;
    for (std::size_t key = 0; key < run.keys.size(); ++key) {
      const auto& k = run.keys[key];
      std::vector<VariedQuantity> displaced;
      for (std::size_t i = 0; i < k.scenes.size() && k.scenes[i]; ++i)
        displaced.push_back(peak_quantity(*k.scenes[i], *k.systems[i], run.quantities[q].name));
      if (std::ranges::all_of(
              displaced, [&](const auto& d) { return same_signal(d.channel, run.quantities[q].channel); }))
        continue;
      varied.push_back({q, key, run.quantities.size()});
      run.quantities.insert(run.quantities.end(), displaced.begin(), displaced.end());
    }
  }
  return varied;
}

/// Adds the differences to the derivatives, and removes the added quantities.
void take_instruments(const SensitivityRun& run, const std::vector<VariedInstrument>& varied,
                      std::size_t count, Sensitivities& all) {
  for (const auto& v : varied) {
    auto& s = all.quantities[v.quantity];
    const auto change = difference(run.keys[v.key].spacing, {s.value}, [&](std::size_t i) {
      return std::vector{all.quantities[v.first + i].value};
    });
    s.derivatives[v.key] += change.slope[0];
    if (change.smooth || !s.reasons[v.key].empty()) continue;
    s.derivatives[v.key] = NAN;
    s.reasons[v.key] = "the peak changes with a kink at this value of the instrument";
  }
  all.quantities.resize(count);
  for (auto& q : all.quantities)
    for (double& d : q.derivatives) d += 0.0;  // no −0
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
                     .stop = request.stop,
                     .traced = compile_choice(request.compile) != Compile::never};
  for (const auto& name : request.of) run.quantities.push_back(quantity_of(given, system, layout, name));
  std::vector<DisplacedScenes> displaced(request.to.size());
  const VariedStart from{.start = run.start,
                         .end = run.end,
                         .of =
                             [&](const Scene& d, const System& s) {
                               const bool rests = d.run.start == RunOptions::Start::equilibrium;
                               return all_of(assemble(d.mechanism, d.run.start, nullptr, request.stop,
                                                      rests ? compliances(family, d, s) : Compliances{}));
                             },
                         .end_of = [](const Scene& d, const System&) { return d.run.duration; }};
  for (std::size_t i = 0; i < request.to.size(); ++i)
    run.keys.push_back(request.to[i].starts_with("initial.")
                           ? initial_value(layout, run.start, request.to[i])
                           : vary(given, system, from, request.to[i], family, displaced[i]));
  const auto varied = add_instruments(run);
  auto all = run_sensitivities(run, family);
  take_instruments(run, varied, request.of.size(), all);
  return all;
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
