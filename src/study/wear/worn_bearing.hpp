// Worn surfaces of a bearing and its journal, and their wear by the loads of some turns.
//
// The depth of wear of each surface is a function of the polar angle of its own body, at n equal angles. A
// class of loads (simulation/bearing_load.hpp) with the force F and the sliding distance Δs = ∫F ds/F presses
// the journal into the bearing with the pressure p(φ) of the elastic foundation, and removes
//
//     Δh = f k p Δs,    with f such that the area ∫ (R + h + Δh/2) Δh dφ = k F Δs/L
//
// from each surface (journal: R − h − Δh/2): Archard's law, of which the pressure gives the shape. Each class
// is an implicit step: p is that of the end of the step, with the foundation softened by s = f (k_b + k_j) Δs
// (bearing_pressure.hpp). It is stable for any Δs. If Δs is large or the foundation rigid, the worn place has
// the shape of the journal.
//
// The loads of many turns are applied in passes over all classes in the order of their directions, forward and
// backward in turn, each with an equal share of Δs. They begin beside the widest range of directions without
// loads, because the last class of a pass leaves a local deviation. It decreases with the power −2/3 of the number
// of passes, and later loads remove it. A class stands for directions that are even over its width: each pass
// takes another one of them, by the multiples of the golden section. The number of passes is doubled until the
// depths, in the mean over a surface, and the greatest depth change by less than a tolerance, at most up to 32.
// It concerns the shape only: the worn areas are exact.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "simulation/bearing_load.hpp"
#include "simulation/bearing_pressure.hpp"

namespace freeplay {

/// Bearing and journal of one joint: constants.
struct WearingJoint {
  std::string name;                  ///< of the joint
  Foundation foundation;             ///< between both surfaces
  double bearing = 0, journal = 0;   ///< m²/N, wear coefficients; 0: does not wear
  std::vector<double> bearing_form;  ///< m, initial deviations of the polar radius at n equal angles
  std::vector<double> journal_form;  ///< m, likewise; empty: round
};

/// Bearing and journal of one joint: the worn surfaces.
class WornBearing {
 public:
  /// Unworn. `joint.bearing_form` has n ≥ 8 angles, and `joint.journal_form` n or none.
  explicit WornBearing(WearingJoint joint);

  /// Wears both surfaces by these loads, times `share`. `tolerance`: greatest change when the number of
  /// passes is doubled, of the depths in the mean over a surface and of the greatest growth, as a share of
  /// them. Throws NoEquilibrium.
  void wear(std::span<const BearingLoad> loads, double share, double tolerance);

  /// Constants of the joint.
  const WearingJoint& joint() const { return joint_; }
  /// m, depths of wear at n equal angles from 0 in the axes of each body
  std::vector<double> bearing_depth() const;
  std::vector<double> journal_depth() const;
  /// m, present deviations of the polar radii; journal: empty if it is round
  const std::vector<double>& bearing_form() const { return bearing_; }
  const std::vector<double>& journal_form() const { return journal_; }
  /// Whether a surface has lost material.
  bool bearing_worn() const { return bearing_ != joint_.bearing_form; }
  bool journal_worn() const { return journal_ != joint_.journal_form; }
  /// m², worn areas of the cross-section
  double bearing_area() const;
  double journal_area() const;
  /// m, greatest depths, also between the angles
  double greatest_bearing() const;
  double greatest_journal() const;
  /// m, nominal radial clearance with both greatest depths: the greatest distance of the surfaces if they are
  /// placed concentrically
  double greatest_clearance() const;
  /// m, half of the greatest free movement of the journal's centre along a line, over all directions and
  /// angles between both bodies: the radial clearance that a measurement of the play shows
  double measured_clearance() const;

 private:
  /// `number`: of the pass, from 0.
  void pass(std::span<const BearingLoad> loads, double share, int number);
  /// The state of a class of loads after its last step.
  struct LastStep {
    double softening = 0;  // m²/N, f_b k_b + f_j k_j; 0: there was none
    Vec2 centre{};         // m
  };
  void apply(const BearingLoad& load, double sliding, LastStep& last);
  /// m, by how much p would deepen each surface, without f
  void growth(const BearingLoad& load, double sliding);

  WearingJoint joint_;
  std::vector<double> bearing_, journal_;
  std::size_t first_ = 0;                                // class with which a pass begins
  int passes_ = 4;                                       // of the last loads
  std::vector<LastStep> last_;                           // of each class
  std::vector<double> deeper_bearing_, deeper_journal_;  // m, of the present class
  Pressure pressure_;
};

}  // namespace freeplay
