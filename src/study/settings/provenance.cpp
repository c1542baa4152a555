#include "study/settings/provenance.hpp"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "io/files/digest.hpp"
#include "io/files/identity.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/open_scene.hpp"
#include "io/scene/section.hpp"
#include "io/scene/toml_value.hpp"
#include "io/scene/write_scene.hpp"

namespace freeplay {
namespace {

std::string value_text(const toml::node& node) {
  if (const auto* list = node.as_array()) {
    std::string all;
    for (const auto& item : *list) all += (all.empty() ? "" : ", ") + value_text(item);
    return fmt::format("[{}]", all);
  }
  if (const auto text = node.value_exact<std::string>()) return toml_quoted(*text);
  if (const auto flag = node.value_exact<bool>()) return *flag ? "true" : "false";
  return toml_number(node.value<double>().value_or(0));
}

/// Appends a line for each key of a document, in the order of the keys, without comments and
/// independent of spelling.
void state(const toml::table& table, const std::string& path, std::string& text) {
  for (const auto& [key, node] : table) {
    const auto name = (path.empty() ? "" : path + ".") + std::string(key.str());
    if (const auto* child = node.as_table())
      state(*child, name, text);
    else
      text += fmt::format("{} = {}\n", name, value_text(node));
  }
}

/// The statements of a study, and the digests of the files it names, with paths relative to the
/// study's folder.
std::string study_text(const Study& study) {
  std::string text = settings_text(study);
  state(parse_toml(study.text, study.file.string()), "", text);
  std::map<std::filesystem::path, std::string> files;
  const bool outside = study.reach == Reach::anywhere;
  files[study.scene] = digest(to_toml(*open_scene(study.scene, {}, outside)));
  for (const auto& v : study.variants) files[v.scene] = digest(to_toml(*open_scene(v.scene, {}, outside)));
  if (!study.fit.empty()) files[study.fit] = digest(study_text(read_study(study.fit, study.reach)));
  if (!study.points.empty()) files[study.points] = digest(read_text(study.points));
  if (study.calibration)
    for (const auto& t : study.calibration->targets)
      if (!t.data.empty()) files[t.data] = digest(read_text(t.data));
  for (const auto& [file, hash] : files)
    text += fmt::format("file {} = \"{}\"\n",
                        toml_quoted(file.lexically_relative(study.file.parent_path()).string()), hash);
  return text;
}

}  // namespace

nlohmann::json provenance(const Study& study) {
  const auto scene = open_scene(study.scene, {}, study.reach == Reach::anywhere);
  auto document = provenance(*scene, {.scene = to_toml(*scene),
                                      .formulation = "",
                                      .given = study_text(study),
                                      .program = program_identity()});
  document["study"] = study.text;
  document["study_file"] = study.file.string();
  document["study_title"] = study.title;
  if (study.reach == Reach::anywhere) document["allow_outside"] = true;
  return document;
}

}  // namespace freeplay
