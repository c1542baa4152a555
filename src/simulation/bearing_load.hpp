// Loads of bearings over a run, in the axes of bearing and journal: the input of wear by Archard's law,
//
//     depth rate = k p |v_T|
//
// For every observed joint the observer integrates F ds = F |v_T| dt, where F is the magnitude of the
// resultant of the normal forces of all contacts of the joint (JOINT, or JOINT.1, JOINT.2, … of profiles;
// friction is not part of it) and v_T = t·ḋ + R_j ω_j − R_b ω_i the sliding rate in the direction n of this
// force, t = perp n. d is the journal's centre relative to the bearing's, and the radii are the nominal ones.
// Integrals over time are Gauss's with three points, over parts of a step in which no body of an observed
// joint turns by more than 0.25°. Both formulations are treated alike.
//
// An impact with the normal impulse P contributes P (|v_T⁻| + |v_T⁺|)/2 to ∫ F ds. The force that it stands
// for is the mean ∫ F² dt/∫ F dt of an impact with the same approach speed v⁻ on the elastic foundation
// without loss. With the effective mass m = P/(v⁻ + v⁺) its greatest force F_max follows from the energy
// ∫ F dδ = m v⁻²/2, and for the local exponent n of F(δ) ∝ δⁿ
//
//     ∫ F² dt/∫ F dt = F_max B((2n + 1)/(n + 1), 1/2)/2,    B: Euler's beta function
//
// A foundation that is matched to Hertz's width is linear, F = (π/2) E* L δ: π/4 F_max with F_max =
// v⁻ √(m (π/2) E* L). An impulse without approach speed, of a contact that is closed already, takes the mean
// force of its class.
//
// The loads are collected in classes of a degree of the direction in both bodies. A class keeps weighted
// means of its directions, so that a constant direction is exact. If the journal neither wears nor has a
// profile, the classes are those of the direction in the bearing's body alone.
//
// Use: pass it to a run, then loads(). pressures() (pressure_table.hpp) makes the pressures of them.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "simulation/observer.hpp"

namespace freeplay {

struct Scene;

/// One class of the loads of a joint during a run.
struct BearingLoad {
  /// rad, mean direction of the force on the bearing (where the journal presses) in the axes of each body,
  /// weighted by F ds, or by F dt without sliding. on_journal has no meaning if the journal's directions are
  /// merged (BearingLoads::merged).
  double on_bearing = 0, on_journal = 0;
  /// rad, width of an even distribution with the variance of these directions; 0: one direction
  double width_on_bearing = 0, width_on_journal = 0;
  double force = 0;     ///< N, ∫ F² ds/∫ F ds; without sliding ∫ F² dt/∫ F dt
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
  bool merged = false;             ///< whether the directions in the journal's body are merged
  /// N m, ∫ F ds of each completed turn of the drive whose turns are counted
  std::vector<double> work_of_turns;
};

/// The loads of the dry revolute joints that state wear, or whose contact law is the elastic foundation of a
/// layer.
class BearingLoadObserver final : public Observer {
 public:
  /// Observes from run.discard on; keeps no reference to the scene. Throws ModelError that names a missing
  /// key.
  explicit BearingLoadObserver(const Scene& scene);
  ~BearingLoadObserver() override;

  /// Whether a scene has bearings to observe.
  static bool needed(const Scene& scene);
  /// The loads up to now, one entry for each observed joint, in the scene's order.
  std::vector<BearingLoads> loads() const;

  Wants wants() const override { return {.forces = true}; }
  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;
  void save(MemoryWriter& m) override { serialize(m); }
  void load(MemoryReader& m) override { serialize(m); }

 private:
  struct Bearing;
  template <class M>
  void serialize(M& m);
  void observe(const Step& step, double a, double b);
  void observe_part(const Step& step, double a, double b);
  void add_impacts(const Forces& impulses, std::span<const double> before, std::span<const double> after);

  std::vector<Bearing> bearings_;
  double discard_ = 0, time_ = 0;               // s, end of the excluded start; observed
  double turn_ = 0;                             // s, of a turn of the drive; 0: none
  long turns_ = 0;                              // completed
  std::vector<double> q_, v_, before_, after_;  // work space; before_: velocities at the end of the last step
  Forces forces_;
};

/// Degree of an angle (rad), 0 to 359: the classes' directions.
int degree_of(double angle);
/// Width (rad) of an even distribution of directions whose mean vector has a length of `length` and whose parts
/// have a variance of `within` of their own: √12 times the standard deviation; 0 below rounding.
double even_width(double length, double within = 0);
/// A smaller share of all loads is omitted without a warning: forces of rounding press nothing.
inline constexpr double omitted_share = 1e-6;

/// The joints that a BearingLoadObserver observes, as indices into Mechanism::joints.
std::vector<std::size_t> observed_bearings(const Scene& scene);

}  // namespace freeplay
