#include "io/scene/read_scene.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dynamics/assembly/meshing.hpp"
#include "dynamics/instruments.hpp"
#include "io/scene/check_scene.hpp"
#include "io/scene/keys_reader.hpp"
#include "io/scene/read_mechanism.hpp"
#include "io/scene/scene_text.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

/// Whether any text in a table or its subtables equals `word`.
bool names_it(const toml::table& table, const std::string& word) {
  return std::ranges::any_of(table, [&](const auto& item) {
    const auto& node = item.second;
    if (const auto* below = node.as_table()) return names_it(*below, word);
    return node.template value_exact<std::string>() == word;
  });
}

/// Refuses surfaces, lubricants and profiles that exist in options only and that nothing names: they would
/// have no effect.
void refuse_made_in_vain(const toml::table& document, const SceneSource& source) {
  for (const auto& [path, beside] : source.made)
    if ((path.starts_with("surfaces.") || path.starts_with("lubricants.") || path.starts_with("profiles.")) &&
        !names_it(document, path.substr(path.find('.') + 1)))
      source.refuse_made(path);
}

std::optional<int> read_format(Section& root) {
  constexpr Range known{[](double x) { return x >= 1 && x <= newest_format && x == static_cast<int>(x); },
                        "1 or 2 (later versions may know more)"};
  if (!root.has("format")) return std::nullopt;
  return static_cast<int>(root.number("format", known));
}

/// Applies the defaults of an older format to absent keys.
void take_old_defaults(int format, bool step_given, NonsmoothOptions& o) {
  if (format >= 2) return;
  if (!o.scheme) o.scheme = Scheme::moreau_jean;
  if (!step_given) o.step = 1e-5;
}

/// Limit of the samples of one channel in a run: 60 GB of signals.csv, far below the number at
/// which consecutive times would round to the same double.
constexpr double most_samples = 1e9;

Instrument read_instrument(const Mechanism& mechanism, double duration, const std::string& name, Section& s) {
  Instrument i;
  i.name = name;
  SectionReader(s).choose({"type", "", ""}, i.kind);
  with_kind(i.kind, [&](auto kind) {
    const Ground nameless;  // instruments cannot name points of the ground
    KeysReader reader(s, mechanism, nameless);
    kind.keys(reader, i);
    reader.check(i.sampling * duration <= most_samples, "sampling", "must be at most ",
                 most_samples / duration, " Hz, for a run of ", duration, " s: ", most_samples, " samples");
    s.done(std::string(kind.what));
  });
  return i;
}

}  // namespace

Scene SceneText::read() const {
  Scene scene;
  scene.file = source_.name;
  scene.text = text_;
  scene.overrides = options_;
  scene.outside = outside_;
  const SceneSource source = source_;  // records what is read
  refuse_unknown_keys(document_.table, "", source);
  refuse_made_in_vain(document_.table, source);

  Section root(document_.table, "", "", source);
  scene.format = read_format(root);
  scene.mechanism = read_mechanism(root);
  const auto options = [&](const char* table, auto& o, const auto& complete) {
    auto section = root.child(table);
    read_keys(section, scene.mechanism, o, {}, complete);
  };
  const auto as_read = [](const auto&) {};
  options("run", scene.run, as_read);
  options("penalty", scene.penalty, as_read);
  const bool step_given = root.child("nonsmooth").has("step");
  options("nonsmooth", scene.nonsmooth, [&](NonsmoothOptions& o) {
    take_old_defaults(scene.format.value_or(newest_format), step_given, o);
  });
  for (auto& [key, s] : root.children("instruments"))
    scene.instruments.push_back(read_instrument(scene.mechanism, scene.run.duration, key, s));
  for (auto& [key, s] : root.children("tolerances")) {
    scene.tolerances.emplace_back().name = key;
    read_keys(s, scene.mechanism, scene.tolerances.back());
  }
  root.done("a scene");
  try {
    check_elements_together(scene);
    set_phases(scene.mechanism);
  } catch (const ModelError& e) {
    if (e.key.empty()) throw located(scene, e);
    fail(e.key, e.message);
  }
  scene.idle = source.idle;
  scene.files = source.files;
  return scene;
}

Scene parse_scene(const std::string& text, const std::string& name, const std::vector<std::string>& overrides,
                  bool outside) {
  return SceneText(text, name, overrides, outside).read();
}

Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides, bool outside) {
  return parse_scene(read_text(file), file.string(), overrides, outside);
}

std::shared_ptr<const Scene> open_scene(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides, bool outside) {
  return std::make_shared<const Scene>(read_scene(file, overrides, outside));
}

}  // namespace freeplay
