#include "formulations/time_stepping/lane_functions.hpp"

#include <numeric>

#include "dynamics/system.hpp"
#include "dynamics/system_functions.hpp"

namespace freeplay {

namespace {

/// Number of contact rows up to which a step has one dense contact problem.
constexpr int most_rows = 24;

/// The functions from a table of `count`.
LaneFunctions functions_of(const CompiledFunction* table, int count, int contacts) {
  LaneFunctions f;
  f.middle = table[0];
  f.end = table[1];
  const auto* next = table + 2;
  for (auto* list : {&f.contacts, &f.opens}) {
    list->assign(next, next + contacts);
    next += contacts;
  }
  if (next < table + count) f.slide = *next;
  return f;
}

/// Whether its steps iterate for the mean velocity, on which forces depend.
bool iterates(const System& system) { return system.has_velocity_forces() || system.curves().sweeps; }

}  // namespace

bool has_whole_steps(const System& system) {
  int rows = system.frictions();
  for (int k = 0; k < system.contacts(); ++k) {
    if (system.contact_facts(k).lubricant) return false;
    rows += system.has_friction(k) ? 2 : 1;
  }
  return system.n() > 0 && rows <= most_rows && system.elastic().pattern.rows == 0 && system.states() == 0 &&
         system.reactive_frictions().empty() && (system.frictions() == 0 || !iterates(system)) &&
         system.families().empty() && !system.has_motions();
}

bool has_ordinary_steps(const System& system) {
  for (int k = 0; k < system.contacts(); ++k)
    if (const auto& surface = system.contact_facts(k).surface;
        surface.restitution_by_speed() || surface.friction_by_speed())
      return false;
  return has_whole_steps(system) && !iterates(system) && !system.has_loads() && system.frictions() <= 1;
}

LaneFunctions TracedLanes::compiled(const CompiledFunction* table) const {
  auto f = functions_of(table, object.functions(), contacts);
  f.lanes = object.lanes();
  f.factors = factors;
  f.ratios = ratios;
  return f;
}

LaneFunctions single_lane(const System& system) {
  const auto& all = system.compiled().functions();
  const int count = static_cast<int>(all.steps.size());
  const int ordinary = 2 + 2 * system.contacts() + system.frictions();
  if (count != ordinary || !has_ordinary_steps(system)) return {};
  auto f = functions_of(all.steps.data(), count, system.contacts());
  f.lanes = 1;
  f.factors = all.solve.factors;
  f.ratios = all.solve.ratios;
  f.object = all.object;
  return f;
}

int LaneFunctions::size(LaneArray array, const System& system) const {
  using enum LaneArray;
  constexpr int row_size = SparseRow::max_size;
  const int K = system.contacts(), n = system.n(), m = system.rows();
  switch (array) {
    case q_old:
    case v_old:
    case q:
    case v:
    case q_middle:
    case momentum:
    case q_free:
    case v_mean:
      return n;
    case cosine:
    case sine:
      return system.bodies();
    case phi_t:
    case gamma:
    case lambda:
      return m;
    case G:
      return static_cast<int>(system.pattern().column.size());
    case LaneArray::factors:
      return this->factors;
    case LaneArray::ratios:
      return std::accumulate(this->ratios.begin(), this->ratios.end(), 0);
    case restitution:
    case acts:
    case opens:
    case gap:
    case middle_gap:
    case gamma_n:
    case gamma_t:
    case reach:
    case slide_reach:
      return K;
    case record:
      return K * lane_record_size;
    case rates:
      return K * lane_rate_size;
    case normal:
    case tangent:
      return K * row_size;
    case slide_row:
      return row_size;
    case totals:
      return lane_total_size;
    case slide_impulse:
      return slide ? 1 : 0;
    default:
      return 1;
  }
}

int lanes_of_machine() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512f") ? 8 : 4;
#else
  return 4;
#endif
}

}  // namespace freeplay
