// Random scenes whose motion is known without the program at every row of the trajectory: prescribed coordinates by the
// curve itself, one coordinate between moving walls by a small integrator of its own (references/one_coordinate.hpp), rows
// of touching bodies by hand (references/touching_row.hpp), energy where nothing takes or gives any. Coordinates of which
// none of these is known are compared with event-driven integration at a tight tolerance.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "values/family.hpp"
#include "verification/references/one_coordinate.hpp"
#include "verification/references/touching_row.hpp"

namespace freeplay::verification::random_scenes {

using Coordinates = std::span<const double>;

/// A coordinate that a curve alone decides, from the instant or from other coordinates of the same row.
struct Prescribed {
  std::size_t coordinate = 0;  ///< of q
  std::function<reference::CurvePoint(double t, Coordinates q, Coordinates v)> motion;
  double
      size = 1,
      rate =
          0;  ///< the greatest departure and rate of the motion, m and m/s or rad and rad/s; rate 0: not compared
  double bend = 0;  ///< m/s² or rad/s², its greatest second derivative
};

/// A coordinate that a small reference integration knows, q = x.
struct Moving {
  std::size_t coordinate = 0;
  reference::OneCoordinate rigid, compliant;
};

/// Bodies on one line: coordinate 3 i + along of body first + i.
struct Row {
  std::size_t first = 0, along = 1;
  reference::TouchingRow row;
  double compliant_step = 0;  ///< s
};

struct RandomScene {
  std::uint64_t seed = 0;
  int index = 0;
  std::string kind;
  std::string text;         ///< in TOML, without the tables that a way adds
  double duration = 1;      ///< s
  double step = 1e-3;       ///< s, of time stepping with fixed steps: 1/200 of the shortest of its times
  double shortest = 1;      ///< s, the shortest of its times
  double contact_step = 0;  ///< s, of rk4 in the penalty formulation
  double speed = 1;         ///< m/s, of contacts
  bool penalty = true;      ///< the penalty formulation has a model of it
  std::vector<Prescribed> prescribed = {};
  std::vector<Moving> moving = {};
  std::optional<Row> row = {};
  std::vector<std::size_t> others =
      {};  ///< coordinates that event-driven integration at a tight tolerance judges
  /// Energy that stays what it is (J), where nothing takes or gives any; `nonsmooth_only`: contacts store none.
  std::function<double(Coordinates q, Coordinates v)> energy = {};
  bool energy_of_rigid_only = false;
};

/// Names of kinds that can be asked for: each alone, or "new" for all.
std::vector<std::string> kinds();
/// The scene that a seed, an index and a selection of kinds decide.
RandomScene draw(std::uint64_t seed, int index, const std::string& selection);

/// A formulation with a scheme or an integrator.
struct Way {
  const char* name;
  Family family;
  std::string (*options)(const RandomScene&);  ///< its tables in TOML
  bool fixed = false;                          ///< steps of fixed length
};
std::span<const Way> ways();

enum class Outcome {
  right,            ///< all rows within their bounds, no doubt said
  doubted,          ///< off, and the run says DOUBTFUL; or not known to be right, and doubted
  falsely_doubted,  ///< known to be right in all rows, and the run says DOUBTFUL
  refused,          ///< ended before the scene's end with a reason although its motion is known
  slow,             ///< longer than the limit of CPU time
  silent,           ///< off, and nothing said
  crashed
};
const char* name_of(Outcome outcome);
inline bool is_defect(Outcome o) { return o != Outcome::right && o != Outcome::doubted; }

struct Verdict {
  Outcome outcome = Outcome::right;
  std::string what;  ///< is off, or the reason, or the doubt
  double known = 0;  ///< share of the rows that a reference knows
  double cpu = 0;    ///< s
};

struct Judgement {
  int index = 0;
  std::string kind, way;
  Verdict verdict;
};

/// s of CPU that one run may take.
inline constexpr double run_limit = 5;
/// Rows of a trajectory beside the start.
inline constexpr int rows = 1000;

/// The scene as a way runs it: a file that reproduces a run.
std::string text_for(const RandomScene& scene, const Way& way);

/// Judges a scene by each way that has a model of it, in this process; `seen` after each.
void judge(const RandomScene& scene, const std::string& only_way,
           const std::function<void(const Way&, const Verdict&)>& seen);

struct Request {
  std::uint64_t seed = 1;
  int first = 0, count = 0;
  std::string kinds = "new";
  std::string way = {};  ///< only this one; empty: all
  bool quiet = true;
};
/// Judges scenes first to first + count − 1 on all cores, each in a process of its own. What is judged is appended to
/// judgements.csv of the folder as it comes; those that stand there already are not judged again. A failing scene is
/// written to failing/KIND-INDEX-WAY.toml.
std::vector<Judgement> judge_all(const Request& request, const std::filesystem::path& folder,
                                 const std::function<void(double)>& seen = {});

/// Counts by way, and defects by kind and way, as tables in Markdown.
std::string tables(const std::vector<Judgement>& judgements);

}  // namespace freeplay::verification::random_scenes
