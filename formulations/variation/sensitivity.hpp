// Derivatives of the results of a run by its variational equations (event_driven/variation.hpp,
// penalty/penalty_variation.hpp, step_variation.hpp).
//
// The caller (analysis/sensitivity.hpp) builds the systems at displaced values of the keys; this file runs
// the formulation once with all columns, and evaluates the quantities at its end.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formulations/penalty/penalty_mode.hpp"
#include "simulation/table_rows.hpp"
#include "values/sensitivity.hpp"
#include "values/state.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;
class System;
class TracedEquations;
enum class Family;

/// A parameter: its systems at displaced values, and derivatives of the start.
struct VariedKey {
  std::string name;
  double value = 0;           ///< SI
  double spacing = 0;         ///< of the displaced values
  double impact_spacing = 0;  ///< greatest spacing across impacts and projections, at most `spacing`
  /// at value + difference_places[i] · spacing; null for initial values, which have no displaced systems
  std::array<const System*, 4> systems{};
  /// Builds the system at another value; it lives as long as those of `systems`.
  std::function<const System*(double value)> system_at = {};
  std::array<const Scene*, 4> scenes{};  ///< of the same values
  /// d(q, v, z)/dp of the start; of a continued penalty run also that of (v₀, mass) of each contact
  std::vector<double> start;
  double end_rate = 0;  ///< d(end of the run)/dp
  /// reason why there is no derivative from the start; empty: none
  std::string refused;
  /// A significant change of the value, for tolerances.
  double scale() const { return systems[0] ? std::max(std::abs(value), 1e3 * spacing) : 1; }
};

/// Least length (m) over which gaps are curved: the least clearance, else the least radius or arm.
double least_curved_length(const System& system);

/// Terms of the energy balance with derivatives, as run.json names them.
enum class EnergyTerm { kinetic, potential, drive, load, damping, contact, friction, film };
struct EnergyName {
  EnergyTerm term;
  const char* text;
};
inline constexpr std::array energy_quantities{EnergyName{EnergyTerm::kinetic, "kinetic"},
                                              EnergyName{EnergyTerm::potential, "potential"},
                                              EnergyName{EnergyTerm::drive, "work_of_drives"},
                                              EnergyName{EnergyTerm::load, "work_of_loads"},
                                              EnergyName{EnergyTerm::damping, "dissipated_in_dampers"},
                                              EnergyName{EnergyTerm::contact, "dissipated_in_contacts"},
                                              EnergyName{EnergyTerm::friction, "dissipated_by_friction"},
                                              EnergyName{EnergyTerm::film, "dissipated_in_films"}};

/// The signal of an instrument: Σ weights · positions, or Σ weights · accelerations through a low-pass with
/// these poles and residues (simulation/instrument.hpp).
struct PeakChannel {
  std::string name;
  bool filtered = false;
  std::vector<double> weights;  ///< one for each coordinate
  std::vector<std::complex<double>> poles, residues;
  std::optional<double> range;  ///< full scale
};

/// A quantity whose derivatives are requested.
struct VariedQuantity {
  /// event_*: of the contact event with this number, from 1; end, mean: of a column; energy: at the end;
  /// peak: of an instrument
  enum class Of { event_time, event_rate, event_impulse, end, mean, energy, peak };
  std::string name;
  Of of = Of::end;
  std::size_t event = 0;
  Column column = {};
  EnergyTerm term = EnergyTerm::kinetic;
  PeakChannel channel = {};
};

/// Error of an impact: it is late, and its change of the velocities too great by a share.
struct ImpactError {
  double delay = 0;  ///< s
  double excess = 0;
};

/// Contact onset: value and derivatives of time, approach rate and normal impulse.
struct VariedOnset {
  int contact = 0;
  bool lasting = false;
  double t = 0, rate = 0, impulse = 0;
  std::vector<double> dt = {}, drate = {}, dimpulse = {};  ///< one for each key; NaN where there is none
  std::vector<std::string> reasons = {};
};

struct SensitivityRun {
  const Scene& scene;
  const System& system;
  State start;
  double end = 0;  ///< s
  std::vector<VariedKey> keys = {};
  std::vector<VariedQuantity> quantities = {};
  StopToken stop = {};
  /// s. The method chooses steps for the motion alone; derivatives may vary faster, as about a rest.
  double longest_step = INFINITY;
  double most_steps = INFINITY;  ///< after which a run is stopped
  /// Whether the variational equations are evaluated by traced equations where that is possible.
  bool traced = true;
  /// Those of earlier runs with the same keys, for further ones; null: none.
  TracedEquations* equations = nullptr;
  /// Penalty runs: the modes of all contacts with which an earlier run ended that this one continues; empty:
  /// contacts that are closed at the start begin there.
  std::vector<PenaltyMode> contacts = {};
  std::vector<double> restitution =
      {};  ///< of each contact; empty: those of the surfaces. Not of penalty runs
};

/// Runs the scene by the event-driven scheme, by time stepping or by the penalty formulation,
/// with the variational equations of all keys. Throws Interrupted if a stop is requested.
Sensitivities run_sensitivities(const SensitivityRun& run, Family family);

}  // namespace freeplay
