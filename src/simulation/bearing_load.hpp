// Loads of bearings over a run, in the axes of bearing and journal: the input of wear by Archard's law,
//
//     depth rate = k p |v_T|
//
// For every observed joint the observer integrates F ds = F |v_T| dt, where F is the magnitude of the
// resultant of the normal forces of all contacts of the joint (JOINT, JOINT.1, …; friction is not part of it)
// and v_T = t·ḋ + R_j ω_j − R_b ω_i the sliding rate at its direction n, t = perp n. Integrals over time are
// Gauss's with three points a step. Both formulations are treated alike.
//
// An impact with the normal impulse P contributes P (|v_T⁻| + |v_T⁺|)/2 to ∫ F ds. The force that it stands
// for is that of the impact of the same speeds on the elastic foundation without loss: with the effective
// mass m = P/(v_n⁻ + v_n⁺), the greatest force F_max has the energy ∫ F dδ = m v_n⁻²/2, and
//
//     ∫ F² dt/∫ F dt = F_max B((2n + 1)/(n + 1), 1/2)/2
//
// for the local exponent n of F(δ); π/4 F_max for a linear contact.
//
// The loads are collected in classes of a degree of the direction in both bodies. A class keeps weighed means
// of its directions, so that a constant direction is exact.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <map>

#include "simulation/bearing_pressure.hpp"
#include "simulation/observer.hpp"

namespace freeplay {

struct Scene;

/// One class of the loads of a joint during a run.
struct BearingLoad {
  /// rad, mean direction of the force on the bearing (where the journal presses) in the axes of each body,
  /// weighed with F ds
  double on_bearing = 0, on_journal = 0;
  double force = 0;     ///< N, ∫ F² ds/∫ F ds
  double work = 0;      ///< N m, ∫ F ds
  double impulse = 0;   ///< N s, ∫ F dt
  double greatest = 0;  ///< N, greatest F
};

/// The loads of a joint during a run.
struct BearingLoads {
  std::string joint;               ///< name of the joint
  double time = 0;                 ///< s, observed
  std::vector<BearingLoad> loads;  ///< classes, in the order of their directions
  double sliding = 0;              ///< m, ∫ |v_T| dt while in contact
  /// N m, ∫ F ds of each completed turn of the drive whose turns are counted
  std::vector<double> work_of_turns;
};

/// The loads of the dry revolute joints that state wear or whose contact law is the elastic foundation.
class BearingLoadObserver final : public Observer {
 public:
  /// Observes from run.discard on. `penalty`: whether the run uses the scene's contact law. Throws ModelError
  /// that names a missing key.
  explicit BearingLoadObserver(const Scene& scene, bool penalty);
  ~BearingLoadObserver() override;

  /// Whether a run of this scene has bearings to observe.
  static bool needed(const Scene& scene, bool penalty);

  /// The loads up to now, one entry for each observed joint, in the scene's order.
  std::vector<BearingLoads> loads() const;

  Wants wants() const override { return {.forces = true}; }
  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;
  void save(MemoryWriter& m) override;
  void load(MemoryReader& m) override;

 private:
  struct Bearing;
  std::vector<Bearing> bearings_;
};

}  // namespace freeplay
