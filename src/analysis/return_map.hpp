// The return map P of the section t = t₀ mod N T of an event-driven mechanism, and its derivative in local
// coordinates
//
//     x(u) = Π(x_k + B u),   B = diag(Z, (2π/N T) Z, scales of states),   Zᵀ M Z = 1, G Z = 0,
//
// where Π is the projection onto the constraints, among them the contacts that are closed at the section.
// Π changes x orthogonally to B in the mass metric, so that Bᵀ M S B is the derivative of the map in these
// coordinates (docs/theory/orbits.md).
//
// With a shift d, a symmetry of the mechanism, states that differ by a multiple of d count as equal: the
// displacements of the local coordinates are orthogonal to d in the mass metric, and P(x) − x is compared
// without its component along d.
//
// In penalty runs, closed contacts of the section are no constraints: their forces depend on the state and on
// the v₀ and mass that they retain (penalty_mode.hpp). Those that are renewed within the motion are further
// local coordinates, relative to their values. Others keep theirs: they are constants of the motion.
//
// Use: construct; take_closed() and chart() at a state of the section; then at() evaluates the map there.
// A ReturnMap refers to its scene and system.
#pragma once

#include <complex>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "analysis/varied_key.hpp"
#include "formulations/penalty/penalty_mode.hpp"
#include "formulations/variation/end_state.hpp"
#include "formulations/variation/sensitivity.hpp"
#include "formulations/variation/traced_equations.hpp"
#include "numerics/dense.hpp"
#include "values/family.hpp"
#include "values/state.hpp"
#include "values/stop.hpp"

namespace freeplay {

/// Steps of the variational equations over all periods: at least this number.
inline constexpr int fewest_map_steps = 64;

// Tolerances of the Newton methods on the map (orbit.cpp, orbit_shooting.cpp, branch_solver.cpp). A residual
// of 1 is the error of a step at tolerance 1.

/// A motion is accepted as periodic up to this multiple of the formulation's tolerance: the errors of the
/// steps of some periods, or up to its rounding errors if those are greater (ReturnMap::accepted()).
inline constexpr double accepted_errors = 1e3;
/// Directions in which the residual changes less than this, relative to the greatest change, are neutral: the
/// mechanism has a family of periodic motions along them, and Newton steps do not follow them.
inline constexpr double neutral_direction = 1e-9;
/// A Newton step is halved until it reduces the residual, down to this share. A search ends where no share
/// does: at a jump of the map, or at its errors, which are accepted if they are below the bound above.
inline constexpr double least_newton_share = 1e-3;
/// Most Newton steps of a search from a motion that is not periodic.
inline constexpr int most_newton_steps = 40;

/// A state of the section, in penalty runs with the modes of all contacts.
struct SectionState : State {
  std::vector<PenaltyMode> contacts;

  SectionState() = default;
  SectionState(State s, std::vector<PenaltyMode> modes = {})
      : State(std::move(s)), contacts(std::move(modes)) {}
};

/// (q, v, z), in penalty runs also (v₀, mass) of each contact.
std::vector<double> list_of(const SectionState& s);

/// The return map near one state of the section.
struct ReturnPoint {
  SectionState state;
  EndState end;
  std::vector<double> change;  ///< P(x) − x, as list_of(), without whole turns of bodies
  Eigen::VectorXd residual;    ///< the same in local coordinates
  Eigen::MatrixXd map;         ///< derivative of the map in local coordinates
  Eigen::VectorXd flow;        ///< by the relative change of the period, if that is unknown
  Eigen::VectorXd by_key;      ///< derivative of the residual with respect to the key, if there is one
  /// d(q, v, z)/du of the state, one list for each column of EndState::columns
  std::vector<std::vector<double>> starts;
  double greatest = 0;  ///< Orbit::residual
  /// Component of P(x) − x along the shift, in multiples of it; 0 without one.
  double shift = 0;
  std::string failure;
};

/// A key of the scene on which the map depends.
struct MapKey {
  std::string name;
  /// s, N T in a scene with another value; without it N T does not depend on the key.
  std::function<double(const Scene&, const System&)> length = {};
};

class ReturnMap {
 public:
  /// `length`: N T (s); `autonomous`: whether T is unknown.
  ReturnMap(const Scene& scene, const System& system, double length, bool autonomous, StopToken stop,
            Family family = Family::nonsmooth);

  bool autonomous() const { return autonomous_; }
  double length() const { return length_; }
  void set_length(double length) { length_ = length; }
  /// From the next chart() on, the motion returns up to a multiple of these displacements of q.
  void set_shift(Eigen::VectorXd shift) { shift_ = std::move(shift); }
  /// Removes the component of a difference of (q, v, z) along the shift. Returns its multiple.
  double remove_shift(std::vector<double>& difference) const;
  /// The contacts that count as closed at the section.
  const std::vector<int>& closed() const { return closed_; }
  /// Takes them, and those that retain data, from another map.
  void take_closed(const ReturnMap& from) {
    closed_ = from.closed_;
    renewed_ = from.renewed_;
    constants_ = from.constants_;
    retained_ = from.retained_;
  }
  /// The contacts that are closed at a state, to rounding and to the errors of the method. In penalty runs:
  /// the closed contacts whose retained data the motion from there renews. Returns the reason if it fails.
  std::string take_closed(const SectionState& s);
  /// Closed contacts of the section that retain their data in a penalty run.
  const std::vector<int>& constants() const { return constants_; }
  /// Sets the local coordinates at a state: columns of the basis are directions of (q, v, z).
  void chart(const State& s);
  /// Number of local coordinates.
  Eigen::Index size() const;
  /// Local coordinates of a difference of (q, v, z).
  Eigen::VectorXd local(const std::vector<double>& difference) const;
  /// B u, a difference of (q, v, z).
  std::vector<double> displacement(const Eigen::VectorXd& u) const;
  /// Adds a difference, as list_of(), to a state and projects it; a failure if it cannot be assembled or a
  /// contact overlaps.
  std::string shift(const std::vector<double>& difference, SectionState& s) const;
  /// The state at local coordinates u; failures likewise.
  std::string move(const Eigen::VectorXd& u, SectionState& s) const { return shift(displacement(u), s); }
  /// The map at a state. `steps`: least number of steps; `key`: may be null.
  ReturnPoint at(const SectionState& s, int steps = fewest_map_steps, const MapKey* key = nullptr) const;
  /// Greatest residual with which a motion counts as periodic.
  double accepted(const ReturnPoint& p) const;
  /// The map at a state without its derivative.
  ReturnPoint value(const SectionState& s, int steps) const;
  /// The motion to another time `end` (s). `steps`: least number of steps in the length of the map; 0: the
  /// scheme chooses them.
  EndState motion(const SectionState& s, double end, int steps, std::vector<VariedKey> keys = {}) const;
  /// The motion to another time t (s) of the section, whose columns carry a tangent of a branch along.
  ReturnPoint until(const SectionState& s, double t, int steps, const MapKey* key) const;

 private:
  /// Residual of an exact motion by rounding errors, as ReturnPoint::greatest: rounded coordinates and times,
  /// carried through the derivative of the map.
  double rounding(const ReturnPoint& p) const;
  ReturnPoint run(const SectionState& s, double length, int steps, const MapKey* key, bool to_return) const;
  double time_unit() const;
  VariedKey direction(const SectionState& s, Eigen::Index c) const;
  std::string take_retained(const SectionState& s);
  std::size_t list_size() const;
  std::size_t place_of_retained(std::size_t i) const;
  std::string compare_contacts(const ReturnPoint& p) const;
  void compare_states(ReturnPoint& p) const;
  void compare(ReturnPoint& p, bool with_key) const;

  /// Kept for all runs of the system, also of copies of this map.
  struct Kept {
    DisplacedScenes displaced;
    TracedEquations equations;
  };

  const Scene& scene_;
  const System& system_;
  std::shared_ptr<Kept> kept_ = std::make_shared<Kept>();
  StopToken stop_;
  bool autonomous_;
  double length_;  // s, of all periods
  Family family_;
  Eigen::MatrixXd basis_;  // M^(1/2) Z
  Eigen::MatrixXd shape_;  // the same without the shift
  Eigen::VectorXd shift_;  // empty: none
  Eigen::VectorXd roots_;  // diagonal of M^(1/2)
  std::vector<int> closed_;
  std::vector<int> renewed_, constants_;  // closed contacts of a penalty run
  std::vector<double> retained_;          // (v₀, mass) of the renewed ones in take_closed()
  double curved_ = 1;                     // m, length over which the constraints are curved
};

/// Evaluates the map with more steps, from `steps` on, until its derivative no longer depends on them;
/// `steps` is then their number. Returns the reason if it always does.
std::string refine(const ReturnMap& map, ReturnPoint& p, int& steps, const MapKey* key = nullptr);

/// Floquet multipliers, the greatest modulus first, and whether they show a stable motion. Without a drive,
/// one multiplier belongs to a shift along the motion and is left out of the decision.
struct Multipliers {
  std::vector<std::complex<double>> values;
  bool stable = true;
};
Multipliers multipliers_of(const ReturnPoint& p, bool autonomous);

struct OrbitRequest;
struct Orbit;
/// orbit() (analysis/orbit.hpp), which also returns the state of the section with the modes of contacts.
Orbit orbit(const Scene& scene, const OrbitRequest& request, SectionState& section);

}  // namespace freeplay
