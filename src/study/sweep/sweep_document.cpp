#include "study/sweep/sweep_document.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "io/files/run_json.hpp"
#include "study/settings/provenance.hpp"
#include "study/settings/study.hpp"

namespace freeplay {

void write_sweep_document(const Study& study, const std::filesystem::path& folder) {
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
    sweep["measures"].push_back({{"name", m.name},
                                 {"column", m.column},
                                 {"reduce", reduce_names[static_cast<std::size_t>(m.reduce)].text},
                                 {"unit", unit_of(m.name)}});
  for (const auto& d : study.derived)
    sweep["derived"].push_back({{"name", d.name}, {"unit", unit_of(d.name)}});
  for (const auto& v : study.variants) sweep["variants"].push_back({{"name", v.name}, {"title", v.title}});
  write_json(folder / "sweep.json", document);
}

}  // namespace freeplay
