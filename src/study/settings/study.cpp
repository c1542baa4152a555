#include "study/settings/study.hpp"

#include <fmt/format.h>

#include <concepts>
#include <string_view>

#include "io/files/digest.hpp"
#include "io/files/visible.hpp"
#include "io/scene/toml_value.hpp"
#include "study/settings/study_reader.hpp"

namespace freeplay {
namespace {

/// Limit of the runs of one study, which are planned at once and stored in one database.
constexpr double most_runs = 1e6;

/// SettingsWriter: the visitor that states the settings that affect the digits of single runs.
class SettingsWriter {
 public:
  struct OfRuns {};
  std::string text;

  void take(const Key& key, const std::string& x) { say(key, toml_quoted(x)); }
  void take(const Key& key, double x, const Range&) { say(key, toml_number(x)); }
  void take(const Key& key, std::integral auto x, const Range&) { say(key, fmt::format("{}", x)); }
  template <class Read>
  void other(const Key& key, const char*, const std::vector<std::string>& names, const Read&) {
    std::string list;
    for (const auto& name : names) list += (list.empty() ? "" : ", ") + toml_quoted(name);
    say(key, names.size() == 1 ? list : names.empty() ? "\"\"" : fmt::format("[{}]", list));
  }
  template <class Read>
  void other(const Key& key, const char*, bool matched, const Read&) {
    say(key, matched ? "\"delivered\"" : "\"as-given\"");
  }

 private:
  void say(const Key& key, std::string_view value) { text += fmt::format("{} = {}\n", key.name, value); }
};

}  // namespace

std::string settings_text(const Study& study) {
  SettingsWriter writer;
  Study::keys(writer, study);
  auto text = std::move(writer.text);
  if (study.period) text += fmt::format("period = {}\n", toml_number(*study.period));
  for (const auto& measure : study.measures) text += said(measure);
  return text;
}

SceneError error_at(const Study& study, const std::vector<std::string>& path, const std::string& message) {
  const toml::table document = parse_toml(study.text, study.file.string());
  const toml::node* node = &document;
  for (const auto& name : path) {
    const auto* table = node->as_table();
    if (const auto* inner = table ? table->get(name) : nullptr) node = inner;
  }
  try {
    SceneSource{.name = study.file.string()}.fail(node, fmt::format("{}", fmt::join(path, ".")), message);
  } catch (const SceneError& placed) {
    return placed;
  }
}

SceneError in_study(const Study& study, const SceneError& error) {
  const std::string what = error.what();
  constexpr std::string_view option = "--set ";
  if (!what.starts_with(option)) return error;
  std::vector<std::string> tables;  // path of the table that sets the option
  std::string message;
  // `opening`: beginning of the options that an element sets. The rest of the option may contain
  // the value, then the message.
  const auto look = [&](const std::vector<std::string>& family, const std::string& name,
                        const std::string& opening) {
    const auto end = what.find(": ", option.size() + opening.size() - 1);
    if (!tables.empty() || !std::string_view(what).substr(option.size()).starts_with(opening) ||
        end == what.npos)
      return;
    tables = family;
    tables.push_back(name);
    message = what.substr(end + 2);
  };
  const auto sets = [&](const std::vector<std::string>& family, const auto& x) {
    for (const auto& set : x.overrides) look(family, x.name, visible(set) + ":");
  };
  const auto set_in = [&](const char* table, const auto& plan) {
    if (!plan) return;
    for (const auto& set : plan->overrides) look({}, table, visible(set) + ":");
  };
  set_in("bifurcation", study.bifurcation);
  set_in("basin", study.basin);
  set_in("continue", study.continuation);
  for (const auto& axis : study.axes) {
    look({"axes"}, axis.name, axis.key + "=");
    for (const auto& key : axis.others) look({"axes"}, axis.name, key + "=");
  }
  for (const auto& variant : study.variants) sets({"variants"}, variant);
  if (study.calibration) {
    for (const auto& x : study.calibration->unknowns) look({"calibrate", "unknowns"}, x.name, x.key + "=");
    for (const auto& x : study.calibration->targets) sets({"calibrate", "targets"}, x);
  }
  if (tables.empty()) return error;
  return error_at(study, tables, message);
}

Study read_study(const std::filesystem::path& file, Reach reach) {
  Study study;
  study.reach = reach;
  study.file = file;
  study.text = read_text(file);
  study.revolutions = 50;
  study.discard = 2;
  study.starts = 8;
  const SceneSource source{.name = file.string(), .reach = reach, .schema = &study_schema()};
  const toml::table document = parse_toml(study.text, file.string());
  refuse_unknown_keys(document, "study", source);
  Section root(document, "", "study", source);
  StudyReader reader(root, study);
  Study::keys(reader, study);
  reader.finish(study);
  root.done("a study");
  require_expressions(study);
  double runs = 0;
  for (const auto& v : study.variants) runs += v.starts * static_cast<double>(v.formulations.size());
  for (const auto& axis : study.axes)
    if (!axis.drawn) runs *= static_cast<double>(axis.values.size());
  if (study.sampling) runs *= study.samples;
  if (runs > most_runs)
    throw SceneError(fmt::format(
        "{}: has {:.3g} runs, above the limit of {:.0f}: give its axes fewer values, or divide it into "
        "several studies",
        file.string(), runs, most_runs));
  return study;
}

}  // namespace freeplay
