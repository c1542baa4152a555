#include "simulation/pressure_table.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mechanism/scene.hpp"
#include "simulation/bearing_pressure.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {
namespace {

using std::numbers::pi;

SurfaceLoad empty_surface(std::size_t n) {
  const std::vector<double> zero(n);
  return {zero, zero, zero, zero};
}

/// What a class of loads adds to one of its surfaces.
struct Addition {
  double impulse_share = 0;  ///< ∫ F dt/(F T)
  double distance = 0;       ///< m, ∫ F ds/F
  double wear = 0;           ///< m/(s Pa), k ∫F ds/(T ∫ p dA)
};

/// Calls take(k, p, share) with pressures turned to angles less by `turn`, for directions that are
/// distributed evenly over `width`. They are interpolated linearly, which keeps their sum.
template <class Take>
void each_turned(const std::vector<double>& values, double turn, double width, const Take& take) {
  const auto n = static_cast<long>(values.size());
  const double step = 2 * pi / static_cast<double>(n);
  const int parts = width > 0 ? static_cast<int>(std::ceil(4 * width / step)) : 1;
  for (int part = 0; part < parts; ++part) {
    const double place = (turn + width * ((part + 0.5) / parts - 0.5)) / step, low = std::floor(place);
    const double share = place - low;
    const auto at = [&](long k) { return values[static_cast<std::size_t>((k % n + n) % n)]; };
    const auto first = static_cast<long>(low) % n;
    for (long k = 0; k < n; ++k)
      take(static_cast<std::size_t>(k), (1 - share) * at(k + first) + share * at(k + first + 1), 1.0 / parts);
  }
}

void add_class(SurfaceLoad& surface, const std::vector<double>& p, double turn, double width,
               const Addition& add) {
  each_turned(p, turn, width, [&](std::size_t k, double pressure, double share) {
    surface.mean[k] += share * add.impulse_share * pressure;
    surface.wear_rate[k] += share * add.wear * pressure;
    if (pressure > 0) surface.sliding[k] += share * add.distance;
  });
}
void raise_greatest(SurfaceLoad& surface, const std::vector<double>& p, double turn, double width) {
  each_turned(p, turn, width, [&](std::size_t k, double pressure, double) {
    surface.greatest[k] = std::max(surface.greatest[k], pressure);
  });
}

const RevoluteJoint& bearing_named(const Scene& scene, const std::string& name) {
  const auto& joints = scene.mechanism.joints;
  return std::get<RevoluteJoint>(*std::ranges::find(joints, name, [](const Joint& j) { return name_of(j); }));
}

BearingSurfaces surfaces_of(const Scene& scene, const BearingLoads& loads, std::size_t n) {
  const auto& joint = bearing_named(scene, loads.joint);
  const auto& c = *joint.clearance;
  const auto foundation = foundation_of(scene.mechanism, joint);
  auto bearing = polar_deviations(scene.mechanism, c.bearing_profile, c.bearing_radius, n);
  const auto journal = polar_deviations(scene.mechanism, c.journal_profile, foundation.journal_radius(), n);
  bearing.resize(n);
  BearingSurfaces out{loads.joint, empty_surface(n)};
  if (!loads.merged) out.journal = empty_surface(n);
  Pressure pressure;
  if (!(loads.time > 0)) return out;
  for (const auto& load : loads.loads) {
    const double turn = loads.merged ? 0 : load.on_bearing - load.on_journal;
    const auto find = [&](double force) {
      solve(foundation, bearing, journal, turn, force, load.on_bearing, 0, pressure);
      out.greatest = std::max(out.greatest, pressure.greatest);
      const auto pressed = std::ranges::count_if(pressure.p, [](double p) { return p > 0; });
      out.width = std::max(out.width, foundation.bearing_radius * 2 * pi / static_cast<double>(n) *
                                          static_cast<double>(pressed));
    };
    try {
      find(load.greatest);
      raise_greatest(out.bearing, pressure.p, 0, load.width_on_bearing);
      if (out.journal) raise_greatest(*out.journal, pressure.p, turn, load.width_on_journal);
      if (load.greatest > load.force) find(load.force);
    } catch (const NoEquilibrium& e) {
      out.omitted += load.impulse;
      if (out.reason.empty()) out.reason = e.what();
      continue;
    }
    Addition add{load.impulse / (load.force * loads.time), load.work / load.force,
                 c.bearing_wear.value_or(0) * load.work / (pressure.total * loads.time)};
    add_class(out.bearing, pressure.p, 0, load.width_on_bearing, add);
    if (!out.journal) continue;
    // ∫ p dA on the smaller circumference of the journal
    add.wear = c.journal_wear.value_or(0) * load.work * foundation.bearing_radius /
               (foundation.journal_radius() * pressure.total * loads.time);
    add_class(*out.journal, pressure.p, turn, load.width_on_journal, add);
  }
  return out;
}

}  // namespace

std::vector<BearingSurfaces> pressures(const Scene& scene, const std::vector<BearingLoads>& loads,
                                       std::size_t angles) {
  std::vector<BearingSurfaces> list;
  for (const auto& one : loads) list.push_back(surfaces_of(scene, one, angles));
  return list;
}

Table pressure_table(const std::vector<BearingSurfaces>& list) {
  Table table({"angle"});
  std::vector<const std::vector<double>*> columns;
  const auto add = [&](const std::string& owner, const SurfaceLoad& s) {
    for (const auto& [name, values] :
         {std::pair{".pressure_greatest", &s.greatest}, std::pair{".pressure_mean", &s.mean},
          std::pair{".sliding", &s.sliding}, std::pair{".wear_rate", &s.wear_rate}}) {
      table.column(owner + name);
      columns.push_back(values);
    }
  };
  for (const auto& one : list) {
    add(one.joint + ".bearing", one.bearing);
    if (one.journal) add(one.joint + ".journal", *one.journal);
  }
  if (columns.empty()) return table;
  const auto n = columns.front()->size();
  for (std::size_t k = 0; k < n; ++k) {
    std::vector<double> row{2 * pi * static_cast<double>(k) / static_cast<double>(n)};
    for (const auto* values : columns) row.push_back((*values)[k]);
    table.row(row);
  }
  return table;
}

void into(Result& result, const Scene& scene, const std::vector<BearingLoads>& loads,
          const std::vector<BearingSurfaces>& list) {
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const auto& l = loads[i];
    if (!(l.time > 0)) continue;
    const auto& c = *bearing_named(scene, l.joint).clearance;
    BearingSummary s;
    s.joint = l.joint;
    s.time = l.time;
    s.sliding = l.sliding;
    double impulse = 0;
    for (const auto& load : l.loads) s.work += load.work, impulse += load.impulse;
    const auto area = [&](const std::optional<double>& k) {
      return k ? std::optional(*k * s.work / (*c.bearing_length * l.time)) : std::nullopt;
    };
    s.bearing_wear_rate = area(c.bearing_wear);
    s.journal_wear_rate = area(c.journal_wear);
    s.greatest_pressure = list[i].greatest;
    if (list[i].omitted > omitted_share * impulse)
      result.notes.push_back(
          diagnostic<Diagnostic::no_pressure>(l.joint, list[i].omitted, impulse, list[i].reason));
    const auto& layer = scene.mechanism.surfaces[static_cast<std::size_t>(c.surface)].layer_thickness;
    if (layer && list[i].width > 0 && *layer > list[i].width)
      result.notes.push_back(diagnostic<Diagnostic::thick_layer>(l.joint, 1e3 * *layer, 1e3 * list[i].width));
    result.bearings.push_back(s);
  }
}

}  // namespace freeplay
