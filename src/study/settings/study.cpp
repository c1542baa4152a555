#include "study/settings/study.hpp"

#include <fmt/format.h>
#include <boost/random/sobol.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <concepts>
#include <map>
#include <numeric>
#include <random>
#include <string_view>

#include "io/files/digest.hpp"
#include "io/files/escaping.hpp"
#include "io/files/identity.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/read_scene.hpp"
#include "io/scene/section.hpp"
#include "io/scene/toml_text.hpp"
#include "io/scene/write_scene.hpp"
#include "study/settings/expression.hpp"
#include "study/settings/study_reader.hpp"

namespace freeplay {
namespace {

/// Limit of the runs of one study, which are planned at once and stored in one database.
constexpr double most_runs = 1e6;

/// SettingsWriter: the visitor that states the settings that affect the results of single runs.
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
  if (study.length.period) text += fmt::format("period = {}\n", toml_number(*study.length.period));
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
  set_in("wear", study.wear);
  for (const auto& axis : study.axes) {
    look({"axes"}, axis.name, axis.key + "=");
    for (const auto& key : axis.others) look({"axes"}, axis.name, key + "=");
  }
  for (const auto& variant : study.variants) sets({"variants"}, variant);
  if (study.rows) {
    for (const auto& set : study.rows->overrides) look({}, "rows", set.substr(0, set.find('=') + 1));
    for (const auto& x : study.rows->unknowns) look({"rows", "unknowns"}, x.name, x.key + "=");
  }
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
  study.length.revolutions = 50;
  study.length.discard = 2;
  study.starts.count = 8;
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
  if (study.design.method) runs *= study.design.samples;
  if (runs > most_runs)
    throw SceneError(fmt::format(
        "{}: has {:.3g} runs, above the limit of {:.0f}: give its axes fewer values, or divide it into "
        "several studies",
        file.string(), runs, most_runs));
  return study;
}

namespace {

/// Uniform in [0, 1), with equal results on all machines (the standard does not specify the
/// algorithm of its distributions).
double uniform(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-53; }

/// Keeps a position that rounds up to 1 inside the half-open cube.
double within(double share) { return std::min(share, 1 - 0x1p-53); }

double at(const Axis::Drawn& d, double u) {
  if (d.logarithmic) return std::clamp(d.low * std::pow(d.high / d.low, u), d.low, d.high);
  return std::clamp(d.low + u * (d.high - d.low), d.low, d.high);
}

/// Adds one value of an axis. `place`: its index in the list of values; none if the value is drawn.
void add(Cell& cell, const Axis& axis, double value, std::optional<std::size_t> place) {
  cell.values.push_back(value);
  cell.overrides.push_back(fmt::format("{}={}", axis.key, value));
  for (std::size_t k = 0; k < axis.others.size(); ++k)
    cell.overrides.push_back(
        fmt::format("{}={}", axis.others[k], place ? axis.other_values[k][*place] : value));
}

}  // namespace

std::vector<std::vector<double>> unit_points(DrawMethod how, std::size_t dimensions, int count,
                                             std::uint64_t seed) {
  std::vector<std::vector<double>> points(static_cast<std::size_t>(count), std::vector<double>(dimensions));
  if (dimensions == 0) return points;
  std::mt19937_64 engine(seed);
  engine.discard(8);
  switch (how) {
    case DrawMethod::random:
      for (auto& p : points)
        for (auto& x : p) x = uniform(engine);
      break;
    case DrawMethod::latin_hypercube:
      for (std::size_t d = 0; d < dimensions; ++d) {
        std::vector<std::size_t> stratum(points.size());
        std::iota(stratum.begin(), stratum.end(), std::size_t{0});
        for (std::size_t i = stratum.size(); i > 1; --i)  // Fisher and Yates
          std::swap(stratum[i - 1],
                    stratum[static_cast<std::size_t>(uniform(engine) * static_cast<double>(i))]);
        for (std::size_t i = 0; i < points.size(); ++i)
          points[i][d] =
              within((static_cast<double>(stratum[i]) + uniform(engine)) / static_cast<double>(count));
      }
      break;
    case DrawMethod::sobol: {
      boost::random::sobol sequence(dimensions);
      for (auto& p : points)
        for (auto& x : p) x = static_cast<double>(sequence() >> 11) * 0x1p-53;
      break;
    }
  }
  return points;
}

std::size_t unfiltered(const Study& study) {
  auto count = study.design.method ? static_cast<std::size_t>(study.design.samples) : 1;
  for (const auto& axis : study.axes)
    if (!axis.drawn) count *= axis.values.size();
  return count;
}

std::vector<Cell> cells(const Study& study) {
  const auto drawn = static_cast<std::size_t>(
      std::ranges::count_if(study.axes, [](const Axis& a) { return a.drawn.has_value(); }));
  // If no axis is drawn, there is one point without coordinates.
  const auto points = unit_points(study.design.method.value_or(DrawMethod::random), drawn,
                                  drawn > 0 ? study.design.samples : 1, study.starts.seed);
  std::optional<Expression> where;
  if (!study.design.where.empty() && !study.axes.empty())
    where.emplace(study.design.where, names_of(study, false));
  std::vector<Cell> all;
  for (const auto& point : points) {
    std::vector<std::size_t> place(study.axes.size(), 0);
    for (bool more = true; more;) {
      Cell cell;
      for (std::size_t a = 0, d = 0; a < study.axes.size(); ++a) {
        const auto& axis = study.axes[a];
        if (axis.drawn)
          add(cell, axis, at(*axis.drawn, point[d++]), std::nullopt);
        else
          add(cell, axis, axis.values[place[a]], place[a]);
      }
      if (!where || where->holds(cell.values)) all.push_back(std::move(cell));
      more = false;
      for (std::size_t a = 0; a < place.size() && !more; ++a) {
        if (study.axes[a].drawn) continue;
        more = ++place[a] < study.axes[a].values.size();
        if (!more) place[a] = 0;
      }
    }
  }
  if (all.empty()) throw error_at(study, {"where"}, "selects no cell of the axes");
  return all;
}

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
  if (study.rows) files[study.rows->file] = digest(read_text(study.rows->file));
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
