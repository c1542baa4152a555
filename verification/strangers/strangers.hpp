// Scenes that nobody designed: drawn by a seed, run by every way, judged without a reference of their own. A run is
// held to other runs that must say the same (a finer tolerance, another method, the scene in a mirror, in other units,
// in another order, backwards in time), to conservation, and to what its own notes tell.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "values/family.hpp"
#include "verification/extremes/extremes.hpp"

namespace freeplay::verification::strangers {

struct Sight;

/// A scene that the seed and the index alone decide.
struct Stranger {
  std::uint64_t seed = 0;
  int index = 0;
  std::string kind;
  std::string text;  ///< in TOML
};
Stranger draw(std::uint64_t seed, int index);
std::vector<std::string> kinds();

/// A way of running a scene: a formulation or one of its schemes. Another is one more row of the table.
struct Way {
  const char* name;
  Family family;
  void (*choose)(Scene&);
  bool stepped = false;  ///< a touch acts somewhere within a step of fixed length
  bool means = false;    ///< forces are means over steps
};
std::span<const Way> ways();
/// Whether the scene asks for what the way has a model of: no restitution of 0 with penalty.
bool has_model(const Scene& scene, const Way& way);

/// A check, as it stands in docs/strangers.md.
struct CheckFacts {
  const char* name;
  const char* asks;   ///< what is compared with what
  const char* bound;  ///< how far off is right
  const char* why;
};
std::vector<CheckFacts> checks();

/// What a scene by a way amounts to: right, degraded (told), refused, wrong (silent), hung or crashed.
struct Verdict {
  Outcome outcome = Outcome::right;
  std::string check;   ///< that was not met; empty: none
  std::string detail;  ///< what was off, or the reason of a refusal
  double cpu = 0;      ///< s, of the run itself
  int touches = 0;     ///< that the run was held to, 0 to 3
};
const char* word_for(Outcome outcome);

/// Judges in this process. `falsify` changes what was seen of the run before it is judged (for tests of the judge).
Verdict judge(const Stranger& stranger, const Way& way, const std::function<void(Sight&)>& falsify = {});

/// s of CPU that one run may take before it counts as hung: ten times what a stranger is drawn for.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr double run_limit = 100;
#else
inline constexpr double run_limit = 10;
#endif

struct Row {
  int index = 0;
  std::string kind, way;
  Verdict verdict;
};
/// Strangers 0 to count − 1 of a seed by every way, each judged in a process of its own, on all cores. `seen` is told
/// the share that is done. In the order of index and way.
std::vector<Row> judge_all(std::uint64_t seed, int count, const std::function<void(double)>& seen = {});
/// One of them.
std::vector<Row> judge_one(const Stranger& stranger);

/// The reason of a refusal without its numbers and names, so that equal ones can be counted.
std::string kind_of_refusal(const std::string& reason);
/// The same in one line that justifies it; empty for one that nobody has looked at.
std::string justification(const std::string& kind);

/// Outcomes by way as a table in Markdown, which a terminal shows as well; refusals by kind, and what was told.
std::string table_of(const std::vector<Row>& rows);
std::string refusals_of(const std::vector<Row>& rows);
std::string told_of(const std::vector<Row>& rows);
/// docs/strangers.md.
std::string page_of(const std::vector<Row>& rows, std::uint64_t seed, int count, double seconds);

}  // namespace freeplay::verification::strangers
