// Shared by the parts of the claim set "forces": scenes, ways to run them, and reasons of bounds.
#pragma once

#include "verification/claims/claim.hpp"
#include "verification/claims/force_balance.hpp"
#include "verification/references/slider_crank.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::force_claims {

using Point = reference::Planar<double>;

// The parts, in the order of the set.
void balance(Findings& f);     ///< balance by each integrator and scheme
void tolerances(Findings& f);  ///< error of the means against the tolerance
void csv(Findings& f);         ///< balance from the columns of forces.csv alone
void slider_cranks(Findings& f);
void bearings(Findings& f);  ///< a rotor under a torque with a body welded on, a slider on a guide
void load_cell(Findings& f);
void torque_sensor(Findings& f);
void watching(Findings& f);  ///< observing forces changes no result
/// undetermined reactions, and their determined sums
void redundant(Findings& f);

/// A scene with one of each element: verification/scenes/forces.toml.
Scene everything();
/// A consistent state of everything().
State start_of_everything();
/// The scene everything() for the nonsmooth formulation: no film, steps of 1e-5 s.
Scene nonsmooth(Scheme scheme);

/// Options of the penalty formulation for everything(); fixed steps are 1e-6 s.
struct Way {
  const char* name;
  Integrator integrator;
  Stabilisation stabilisation;
  FrictionLaw friction;
  ContactLaw contact;
  double duration = 0.012;  // s
};
Scene penalty(const Way& way);

/// A slider-crank that turns once, from crank angle 0, at a tolerance of 1e-10. Elements: main,
/// big_end, gudgeon, guide, motor, push.
Scene slider_crank(const reference::LoadedSliderCrank<double>& s);
/// The paper's ideal rig, without weight.
reference::LoadedSliderCrank<double> rig();
/// The ideal rig with weight, an eccentric crank, an offset slider and a load on it.
reference::LoadedSliderCrank<double> loaded();

/// A run in memory. Throws when it does not finish.
Result run(const Scene& scene, Family family, std::vector<Observer*> observers,
           const std::optional<State>& start = {});

/// A run with its result files. Throws when it does not finish.
struct Files {
  test::Columns trajectory, forces;
  Result result;
  Layout layout;
};
Files files(const Scene& scene, Family family, const std::optional<State>& start = {});

/// Index of the force element of that name. Throws when there is none.
std::size_t find(const Layout& layout, const std::string& name);

// Reasons of bounds.
inline constexpr const char* drift =
    "the points of an ideal joint are apart by its drift: 1e-11 m over lever arms of 1 cm";
inline constexpr const char* hertz =
    "Hertz's force begins as δ^(3/2): three-point quadrature errs by 1e-4 of a step that has at most 1e-3 of "
    "the impulse, margin of ten";

}  // namespace freeplay::verification::force_claims
