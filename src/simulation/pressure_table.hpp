// Pressure and wear over the angle of bearings and journals, from the loads of a run (bearing_load.hpp).
//
// For each class of loads with the force F, ∫ F ds and ∫ F dt, solve() gives the pressure p(φ). Over the
// observed time T,
//
//     mean pressure      Σ p ∫F dt/(F T)
//     sliding distance   Σ ∫F ds/F       of the classes with p > 0 at the angle
//     wear rate          Σ k p̂ ∫F ds/(F T),   p̂ = p F/∫ p dA
//
// p̂ is normalised so that the worn area of the cross-section grows with k ∫F ds/L. The pressure on the
// journal is that on the bearing, turned by the class's angle between both bodies. The directions of a class
// are distributed evenly over their width.
//
//     const auto list = pressures(scene, observer.loads());
//     Table table = pressure_table(list);
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "simulation/bearing_load.hpp"
#include "values/result.hpp"
#include "values/table.hpp"

namespace freeplay {

/// Of one surface, at equal angles from 0 in the axes of its body.
struct SurfaceLoad {
  std::vector<double> greatest, mean;  ///< Pa, over time; each a mean over two steps of the angle
  std::vector<double> sliding;         ///< m
  std::vector<double> wear_rate;       ///< m/s, depth over time
};

/// Of one joint.
struct BearingSurfaces {
  std::string joint;                        ///< name of the joint
  SurfaceLoad bearing;                      ///< of the bearing
  std::optional<SurfaceLoad> journal = {};  ///< empty if the directions in its body are merged
  double greatest = 0;                      ///< Pa, greatest pressure
  double width = 0;                         ///< m, arc of the widest contact, up to two steps of the angle
  /// N s, ∫ F dt of loads that no position of the journal balances, and the first reason
  double omitted = 0;
  std::string reason = {};
};

/// Number of angles of pressure.csv.
inline constexpr std::size_t pressure_angles = 720;

/// The pressures of the observed joints; `loads`: of a BearingLoadObserver of this scene.
std::vector<BearingSurfaces> pressures(const Scene& scene, const std::vector<BearingLoads>& loads,
                                       std::size_t angles = pressure_angles);

/// pressure.csv: `angle` and the columns of each joint.
Table pressure_table(const std::vector<BearingSurfaces>& list);

/// Writes Result::bearings, a warning for omitted loads, and a note on a layer that is not thin.
void into(Result& result, const Scene& scene, const std::vector<BearingLoads>& loads,
          const std::vector<BearingSurfaces>& list);

}  // namespace freeplay
