#include "analysis/sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "analysis/varied_key.hpp"
#include "compile/compile.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "facade/identify.hpp"
#include "facade/simulation.hpp"
#include "formulations/make.hpp"
#include "formulations/variation/differences.hpp"
#include "formulations/variation/sensitivity.hpp"
#include "io/scene/points_file.hpp"
#include "io/scene/scene_text.hpp"
#include "io/scene/spelling.hpp"
#include "io/scene/toml_text.hpp"
#include "io/scene/write_scene.hpp"
#include "mechanism/scene.hpp"
#include "simulation/instrument.hpp"

namespace freeplay {
namespace {

/// Least error of a derivative over its scale: rounding, and differences of the constants in the equations.
constexpr double rounding_share = 1e-11;

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
  const auto number = number_in(name.substr(first + 1, second - first - 1));
  const auto part = second == name.npos ? "" : name.substr(second + 1);
  using Of = VariedQuantity::Of;
  const std::pair<const char*, Of> parts[] = {
      {"t", Of::event_time}, {"v_n_minus", Of::event_rate}, {"impulse_n", Of::event_impulse}};
  const auto found = std::ranges::find_if(parts, [&](const auto& p) { return part == p.first; });
  if (!number || !(*number >= 1 && *number <= 1e9) || *number != std::floor(*number) ||
      found == std::end(parts))
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

/// The peak of a quantity with respect to a key of its instrument, which leaves the motion alone: peaks of
/// the same motion behind displaced instruments.
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

/// A run with its derivatives.
struct VariedScene {
  Sensitivities found;
  std::vector<double> spacings;  ///< of each key, across impacts; 0: the key has no displaced values
};

/// Quantities with derivatives, by one run. `share`: of the spacing of displaced values.
VariedScene derivatives_of(const Scene& scene, const SensitivityRequest& request, double share = 1,
                           double most_steps = INFINITY) {
  const auto family = family_of(request.formulation);
  Simulation simulation(scene, request.formulation, {.start = {}, .stop = request.stop});
  const auto& layout = simulation.layout();
  const auto& given = simulation.scene();
  const System system(given.mechanism);
  SensitivityRun run{.scene = given,
                     .system = system,
                     .start = simulation.state(),
                     .end = given.run.duration,
                     .stop = request.stop,
                     .most_steps = most_steps,
                     .traced = compile_choice(request.compile) != Compile::never};
  for (const auto& name : request.of) run.quantities.push_back(quantity_of(given, system, layout, name));
  DisplacedScenes displaced;
  const VariedStart from{.start = run.start,
                         .end = run.end,
                         .of =
                             [&](const Scene& d, const System& s) {
                               const bool rests = d.run.start == RunOptions::Start::equilibrium;
                               return all_of(assemble(d.mechanism, d.run.start, nullptr, request.stop,
                                                      rests ? compliances(family, d, s) : Compliances{}));
                             },
                         .end_of = [](const Scene& d, const System&) { return d.run.duration; }};
  VariedScene all;
  for (std::size_t i = 0; i < request.to.size(); ++i) {
    run.keys.push_back(request.to[i].starts_with("initial.")
                           ? initial_value(layout, run.start, request.to[i])
                           : vary(given, system, from, request.to[i], family, displaced, share));
    all.spacings.push_back(run.keys.back().systems[0] ? run.keys.back().impact_spacing : 0);
  }
  const auto varied = add_instruments(run);
  all.found = run_sensitivities(run, family);
  take_instruments(run, varied, request.of.size(), all.found);
  return all;
}

/// Sets an option. A scene changed in code remains one, because its text may state the keys in their units.
template <class T>
void set_option(Scene& scene, const std::string& key, T& place, const std::type_identity_t<T>& value,
                const std::string& text) {
  if (SceneText(scene).is_original())
    scene.set(key, text);
  else
    place = value;
}

void set_option(Scene& scene, const std::string& key, double& place, double value) {
  set_option(scene, key, place, value, toml_number(value));
}

/// Multiplies the tolerance or the step of the scheme in force.
Scene coarser(const Scene& scene, Family family, double tolerance, double step) {
  Scene other = scene;
  auto& n = other.nonsmooth;
  auto& p = other.penalty;
  if (family == Family::penalty) {
    if (choice_of(p.integrator).traits.adaptive)
      set_option(other, "penalty.tolerance", p.tolerance, tolerance * p.tolerance);
    else
      set_option(other, "penalty.step", p.step, step * p.step);
  } else if (n.scheme_in_force() != Scheme::moreau_jean) {
    set_option(other, "nonsmooth.tolerance", n.tolerance, tolerance * n.tolerance);
  } else if (n.step) {
    set_option(other, "nonsmooth.step", *n.step, step * *n.step);
  } else {
    set_option(other, "nonsmooth.step_tolerance", n.step_tolerance, tolerance * n.step_tolerance);
  }
  return other;
}

/// Differences of the quantities along one direction of all keys at once, by runs without derivatives. They
/// have no part in common with the variational equations: an error of these shows, whatever its cause.
class Direction {
  /// An event-driven run in place of time stepping may have too many events.
  static constexpr double most_steps = 1e5;
  /// Relative change of a quantity by the number of bounces that end an accumulation.
  static constexpr double noise = 2e-10;

 public:
  /// `keys`: those of the direction, with their steps.
  Direction(const Scene& scene, const SensitivityRequest& request, const Sensitivities& found,
            std::vector<double> steps)
      : steps_(std::move(steps)) {
    SensitivityRequest plain = request;
    plain.to.clear();
    plain.errors = false;
    const auto family = family_of(request.formulation);
    const double most = family == Family::penalty ? INFINITY : most_steps;
    for (const double place : {-1.0, -0.5, 0.5, 1.0}) {
      Scene other = scene;
      for (std::size_t i = 0; i < steps_.size(); ++i)
        if (steps_[i] != 0)
          other = property(other, found.keys[i], family).at(found.key_values[i] + place * steps_[i]);
      values_.push_back(derivatives_of(other, plain, 1, most).found);
    }
  }
  /// The difference between the derivative of a quantity along the direction and its differences, and the
  /// error of these; NaN if a run does not reach the quantity or its own end.
  std::pair<double, double> mismatch(const Sensitivities& found, std::size_t q) const {
    if (!std::ranges::all_of(values_, [](const auto& v) { return v.stopped.empty(); })) return {NAN, NAN};
    const auto at = [&](std::size_t i) { return values_[i].quantities[q].value; };
    const double wide = 0.5 * (at(3) - at(0)), close = at(2) - at(1);
    double along = 0;
    for (std::size_t i = 0; i < steps_.size(); ++i)
      if (steps_[i] != 0) along += steps_[i] * found.quantities[q].derivatives[i];
    return {std::abs((4 * close - wide) / 3 - along),
            std::abs(close - wide) + noise * std::abs(found.quantities[q].value)};
  }

 private:
  std::vector<double> steps_;
  std::vector<Sensitivities> values_;
};

/// Estimates of all errors: changes of the derivatives with the tolerance or the step and with the spacing of
/// displaced values, and the difference from runs beside this one.
void estimate_errors(const Scene& scene, const SensitivityRequest& request, VariedScene& all) {
  const auto family = family_of(request.formulation);
  auto& found = all.found;
  const bool steps = family == Family::nonsmooth && scene.nonsmooth.scheme_in_force() == Scheme::moreau_jean;
  std::vector<Sensitivities> others;
  // Errors of first order lie anywhere below their bound, as the impacts lie in their steps: two runs.
  for (const auto& [tolerance, step] : steps ? std::vector<std::pair<double, double>>{{10, 2}, {7, 1.37}}
                                             : std::vector<std::pair<double, double>>{{10, 2}})
    others.push_back(derivatives_of(coarser(scene, family, tolerance, step), request, 0.6).found);
  for (std::size_t q = 0; q < found.quantities.size(); ++q) {
    auto& s = found.quantities[q];
    s.errors.assign(found.keys.size(), NAN);
    for (std::size_t i = 0; i < found.keys.size(); ++i) {
      if (!std::isfinite(s.derivatives[i])) continue;
      s.errors[i] = rounding_share * derivative_scale(found, s, i);
      for (const auto& other : others) {
        const double change = std::abs(other.quantities[q].derivatives[i] - s.derivatives[i]);
        s.errors[i] = std::isfinite(change) ? std::max(s.errors[i], change) : INFINITY;
      }
    }
  }
  std::vector<double> direction = all.spacings;
  for (std::size_t i = 0; i < direction.size(); ++i) {
    const bool whole = std::ranges::all_of(found.quantities, [&](const auto& s) {
      return std::isfinite(s.derivatives[i]) ||
             std::ranges::none_of(s.derivatives, [](double d) { return std::isfinite(d); });
    });
    // Other weights, so that errors of keys with one effect do not cancel.
    direction[i] = whole ? direction[i] * (i % 2 == 0 ? 0.5 : -0.35) : 0;
  }
  Scene exact = scene;
  if (steps)
    set_option(exact, "nonsmooth.scheme", exact.nonsmooth.scheme, Scheme::event_driven, "event-driven");
  const auto unexplained = [&](const std::vector<double>& along, auto take) {
    try {
      const Direction beside(exact, request, found, along);
      for (std::size_t q = 0; q < found.quantities.size(); ++q) {
        const auto [mismatch, own] = beside.mismatch(found, q);
        double explained = 3 * own;
        for (std::size_t i = 0; i < along.size(); ++i)
          if (along[i] != 0) explained += std::abs(along[i]) * found.quantities[q].errors[i];
        if (mismatch > explained) take(found.quantities[q], mismatch);
      }
    } catch (const ModelError&) {
      // Beside the scene there is none in this direction: the estimates stay those of the settings.
    }
  };
  bool any = false;
  if (std::ranges::any_of(direction, [](double d) { return d != 0; }))
    unexplained(direction, [&](const Sensitivity&, double) { any = true; });
  for (std::size_t i = 0; any && i < direction.size(); ++i) {
    if (direction[i] == 0) continue;
    std::vector<double> one(direction.size());
    one[i] = direction[i];
    unexplained(one,
                [&](Sensitivity& s, double mismatch) { s.errors[i] = mismatch / std::abs(direction[i]); });
  }
}

}  // namespace

Sensitivities sensitivities(const Scene& scene, const SensitivityRequest& request) {
  auto all = derivatives_of(scene, request);
  if (request.errors && !request.to.empty()) estimate_errors(scene, request, all);
  return std::move(all.found);
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
