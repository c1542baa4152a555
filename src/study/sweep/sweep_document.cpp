#include "study/sweep/sweep_document.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "io/files/run_json.hpp"
#include "study/settings/provenance.hpp"
#include "study/settings/study.hpp"

namespace freeplay {

std::string_view unit_of(TurnMetrics::Name name) {
  switch (name) {
    case TurnMetrics::peak_5:
    case TurnMetrics::peak_median:
    case TurnMetrics::peak_95:
    case TurnMetrics::peak_max:
    case TurnMetrics::rms:
    case TurnMetrics::deceleration:
    case TurnMetrics::lines_total:
    case TurnMetrics::line_greatest:
    case TurnMetrics::mean_turn_rms:
    case TurnMetrics::mean_turn_peak:
      return "m/s²";
    case TurnMetrics::loss_angle:
    case TurnMetrics::return_angle:
      return "°";
    case TurnMetrics::flight_duration:
      return "s";
    case TurnMetrics::energy_per_turn:
      return "J";
    default:
      return "";
  }
}

void write_sweep_document(const Study& study, const Results& results, const std::filesystem::path& folder,
                          const std::string& verdict) {
  const auto unit_of = [&](const std::string& name) {
    const auto it = std::ranges::find(study.units, name, &std::pair<std::string, std::string>::first);
    return it == study.units.end() ? nlohmann::json() : nlohmann::json(it->second);
  };
  nlohmann::json document;
  document["provenance"] = provenance(study);
  document["provenance"]["scene_file"] = study.scene.lexically_normal().string();
  auto& sweep = document["sweep"];
  for (const char* list : {"axes", "measures", "derived", "variants"}) sweep[list] = nlohmann::json::array();
  sweep["title"] = study.title;
  for (const auto& a : study.axes)
    sweep["axes"].push_back({{"name", a.name},
                             {"key", a.key},
                             {"unit", a.unit},
                             {"scale", a.scale},
                             {"drawn", a.drawn.has_value()}});
  for (const auto& m : study.measures)
    sweep["measures"].push_back(
        {{"name", m.name}, {"column", m.column}, {"reduce", text_of(m.reduce)}, {"unit", unit_of(m.name)}});
  for (const auto& d : study.derived)
    sweep["derived"].push_back({{"name", d.name}, {"unit", unit_of(d.name)}});
  for (const auto& v : study.variants)
    sweep["variants"].push_back(
        {{"name", v.name}, {"title", v.title}, {"scene", v.scene.string()}, {"overrides", v.overrides}});
  for (std::size_t m = 0; m < TurnMetrics::count; ++m)
    if (const auto unit = freeplay::unit_of(static_cast<TurnMetrics::Name>(m)); !unit.empty())
      sweep["units"][std::string(TurnMetrics::names()[m])] = unit;
  document["verdict"] = verdict;
  Database::Transaction alone(results.database());
  write_json(folder / "sweep.json", document);
  alone.commit();
}

}  // namespace freeplay
