// Result files of a wear study and its conclusion in words. Documents are without their provenance.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "study/wear/wear_study.hpp"
#include "values/table.hpp"

namespace freeplay {

/// The life of a joint: turns until its measured clearance is `clearance`.
struct WearLife {
  double clearance = 0;       ///< m
  double turns = 0;           ///< infinite: the clearance does not grow
  double low = 0, high = 0;   ///< ends of its 95 % interval
  bool extrapolated = false;  ///< whether it lies beyond the last cycle
};

/// The life of joint j. Between and beyond the cycles the clearance grows with a power of the turns, as that of a
/// pin that wears its own form into a bearing, N^(2/3), or of even wear, N. The exponent is that between two
/// cycles, beyond the last one that of the second half of the turns. The interval contains, of this and of linear
/// growth (beyond the last cycle: with its rate), where the clearance ± its error is `clearance`; the error is 1.96
/// standard errors and the extrapolation error of both depths, and beyond the last cycle a share of the growth. After
/// a single cycle it has no upper end.
WearLife life_of(const WearHistory& history, std::size_t j, double clearance);

/// wear.csv: a row for each formulation, joint and cycle.
Table wear_table(const WearStudy& all);
/// profiles.csv: a row for each formulation, joint, cycle and angle.
Table profiles_table(const WearStudy& all);
/// A surface of a joint after the last cycle, as the profile with which the next run would begin.
struct ProfileFile {
  std::string name;  ///< profile_bearing_JOINT_FORMULATION.csv or profile_journal_…
  Table points;      ///< as profiles.*.points of a scene reads them: angle (rad), deviation (m)
};
/// Those of all joints that are worn: of each surface that is not round.
std::vector<ProfileFile> profile_files(const WearStudy& all);
/// wear.json.
nlohmann::json to_json(const WearPlan& plan, const WearStudy& all);
/// The conclusion: a few sentences for each joint.
std::string conclusion(const WearPlan& plan, const WearStudy& all);
/// wear.md: the conclusion, and the last row of each joint and formulation.
std::string wear_page(const Study& study, const WearStudy& all);

}  // namespace freeplay
