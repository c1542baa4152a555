// Contents of the result files of output play.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "analysis/play/play.hpp"
#include "values/table.hpp"

namespace freeplay {

/// play.csv: the coordinate, then for each quantity Q (PlayOutput::column) Q.ideal, Q.least, Q.greatest, Q.bound_least,
/// Q.bound_greatest, Q.linear; with samples Q.p0.135, Q.p2.5, Q.p50, Q.p97.5, Q.p99.865 (%); with loads Q.loaded_up
/// and Q.loaded_down. Cells of refused positions are empty.
Table play_table(const Play& play);
/// play_parts.csv: the coordinate, then Q.JOINT, the part of each joint in Q.greatest − Q.least.
Table play_parts_table(const Play& play);
/// play_loads.csv: the coordinate, then the reaction of each joint on its second body, JOINT.fx_up, .fy_up, .m_up
/// and likewise down.
Table play_loads_table(const Play& play);
/// play_region.csv: at (coordinate of the driven joint), point, ideal_x, ideal_y (m), and for each direction phi (rad)
/// the farthest place x, y and `bound`, the bound of its distance from the ideal place along phi (m).
Table play_region_table(const Play& play);
/// play.json, without provenance.
nlohmann::json to_json(const Play& play);

}  // namespace freeplay
