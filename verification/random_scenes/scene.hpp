// A random scene: drawn from a seed by one of the kinds, with the reference of its motion, and the
// methods that it is run by. Scenes of the first set have no separate reference: a run is compared
// with other runs that must agree with it (a finer tolerance, another method, the scene mirrored,
// in other units, in another order, backwards in time), with conservation laws, and with its own
// notes. Scenes of the second set have a reference for every row of the trajectory that does not
// use a solver of the program: prescribed coordinates follow the curve itself, one coordinate
// between moving walls a small independent integrator (references/one_coordinate.hpp), rows of
// touching bodies a closed form (references/touching_row.hpp), coordinates of single elements the
// law of the element (references/dry_coordinate.hpp, disc_on_outline.hpp, sampled_loop.hpp), and
// energy applies where no element adds or dissipates it. Coordinates without any of these references are compared with event-driven
// integration at a tight tolerance.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "values/family.hpp"
#include "verification/random_scenes/verdict.hpp"
#include "verification/references/one_coordinate.hpp"
#include "verification/references/touching_row.hpp"

namespace freeplay {
struct Scene;
}  // namespace freeplay

namespace freeplay::verification::random_scenes {

using Coordinates = std::span<const double>;

/// A coordinate that a curve alone determines, from the time or from other coordinates of the same
/// row.
struct Prescribed {
  std::size_t coordinate = 0;  ///< of q
  std::function<reference::CurvePoint(double t, Coordinates q, Coordinates v)> motion;
  double size = 1;  ///< m or rad, the greatest displacement of the motion
  double rate = 0;  ///< m/s or rad/s, its greatest rate; 0: not compared
  double bend = 0;  ///< m/s² or rad/s², its greatest second derivative
};

/// A coordinate with a small reference integration, q = x.
struct Moving {
  std::size_t coordinate = 0;
  reference::OneCoordinate rigid, compliant;
};

/// A coordinate with a law of its own, by its rows at instants under a change of the reference.
struct Derived {
  std::size_t coordinate = 0;
  std::function<reference::OneCoordinate::Rows(Family, const std::vector<double>& instants,
                                               const reference::Change&)>
      rows;
};

/// Bodies on one line: coordinate 3 i + along of body first + i.
struct BodiesInLine {
  std::size_t first = 0, along = 1;
  reference::TouchingRow row;
  double compliant_step = 0;  ///< s
};

/// A scene determined by the seed, the index and the selection of kinds alone.
struct RandomScene {
  Suite suite = Suite::agreement;
  std::uint64_t seed = 0;
  int index = 0;
  std::string kind = {};
  std::string text = {};  ///< in TOML, without the tables that a method adds

  /// @name Scenes with a reference for every row
  ///@{
  double duration = 1;  ///< s
  /// s, of time stepping with fixed steps: 1/200 of the shortest of its times
  double step = 1e-3;
  double shortest = 1;      ///< s, the shortest of its times
  double contact_step = 0;  ///< s, of rk4 in the penalty formulation
  double speed = 1;         ///< m/s, of contacts
  bool penalty = true;      ///< the penalty formulation has a model of it
  std::vector<Prescribed> prescribed = {};
  std::vector<Moving> moving = {};
  std::vector<Derived> derived = {};
  std::optional<BodiesInLine> line = {};
  /// Coordinates that are compared with event-driven integration at a tight tolerance.
  std::vector<std::size_t> others = {};
  /// Energy (J) that is conserved, where no element adds or dissipates it.
  std::function<double(Coordinates q, Coordinates v)> energy = {};
  bool energy_of_rigid_only = false;  ///< contacts store energy in the penalty formulation
  ///@}
};

/// Number of rows of a trajectory after the start, where every row is known.
inline constexpr int rows = 1000;

/// Names of the kinds of a suite.
std::vector<std::string> kinds(Suite suite);
/// A scene of the kinds of the first set, or of those that `selection` names in the second: "new" for
/// all of bodies on curves, forces and touching bodies, "elements" for all of single elements, "surfaces" for
/// all of friction of surfaces, or a list with commas.
RandomScene draw(std::uint64_t seed, int index, const std::string& selection = "");

/// A method of running a scene: a formulation with a scheme or an integrator.
struct Way {
  const char* name;
  Family family;
  void (*choose)(Scene&) = nullptr;                      ///< applied to the scene after reading
  std::string (*options)(const RandomScene&) = nullptr;  ///< its tables in TOML
  bool stepped = false;  ///< steps of fixed length: a contact acts at some instant in one
  bool means = false;    ///< forces are means over steps
};
std::span<const Way> ways(Suite suite);
/// The scene as a method runs it: a file that reproduces a run.
std::string text_for(const RandomScene& scene, const Way& way);
/// The same as a scene. Throws SceneError.
Scene scene_for(const RandomScene& scene, const Way& way);
/// Whether the method has a model of the scene: no restitution of 0 with penalty.
bool has_model(const RandomScene& scene, const Way& way);

}  // namespace freeplay::verification::random_scenes
