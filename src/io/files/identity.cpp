#include "io/files/identity.hpp"

#include <fmt/format.h>
#include <gnu/libc-version.h>
#include <Eigen/Core>

#include "io/files/build_identity.hpp"
#include "io/files/digest.hpp"
#include "io/files/escaping.hpp"
#include "io/files/recorded_run.hpp"
#include "io/scene/section.hpp"
#include "io/scene/toml_text.hpp"
#include "io/scene/write_scene.hpp"

namespace freeplay {
namespace {

std::string line(std::string_view key, const std::string& value) {
  return fmt::format("{} = {}\n", key, value);
}
std::string force_of(const std::string& load) { return fmt::format("the force of {}", load); }
std::string text(std::string_view key, std::string_view value) { return line(key, toml_quoted(value)); }

/// Instruction set of the compiled program. It affects the last bits: a fused multiply-add rounds once,
/// two separate operations round twice.
std::string instruction_set() {
  std::string list;
  const auto add = [&](const char* name) { list += (list.empty() ? "" : " ") + std::string(name); };
#if defined(__x86_64__)
  add("x86_64");
#elif defined(__aarch64__)
  add("aarch64");
#endif
#ifdef __SSE3__
  add("sse3");
#endif
#ifdef __SSE4_2__
  add("sse4.2");
#endif
#ifdef __AVX__
  add("avx");
#endif
#ifdef __AVX2__
  add("avx2");
#endif
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
  add("fma");
#endif
#ifdef __AVX512F__
  add("avx512f");
#endif
#ifdef __FAST_MATH__
  add("fast-math");
#endif
  return list;
}

/// Features of the processor for which the mathematical library selects other code of sin, exp and
/// pow.
std::string processor() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx2") ? "fma" : "no fma";
#else
  return "as compiled";
#endif
}

/// Reader of one part of an identity.
class Part {
 public:
  explicit Part(const std::string& text) : table_(parse_toml(text, "identity")) {}
  template <class T>
  T value(const char* key) const {
    const auto* node = table_.get(key);
    const auto found = node ? node->value_exact<T>() : std::optional<T>();
    if (!found) throw SceneError(fmt::format("the identity has no {}", key));
    return *found;
  }
  std::string text_or_none(const char* key) const { return table_[key].value_or(std::string()); }
  std::vector<std::string> texts_or_none(const char* key) const {
    std::vector<std::string> x;
    if (const auto* all = table_.get_as<toml::array>(key))
      for (const auto& item : *all) x.push_back(item.value_or(std::string()));
    return x;
  }
  std::vector<double> list(const char* key) const {
    std::vector<double> x;
    const auto* all = table_.get_as<toml::array>(key);
    if (!all) throw SceneError(fmt::format("the identity has no {}", key));
    for (const auto& item : *all) x.push_back(item.value<double>().value_or(0));
    return x;
  }

 private:
  toml::table table_;
};

}  // namespace

std::string Identity::digest() const {
  std::string all;
  for (const auto* part : {&scene, &formulation, &given, &program})
    // With their sizes, so that lines cannot move from one part to the next.
    all += fmt::format("{}\n{}", part->size(), *part);
  return freeplay::digest(all);
}

std::string program_identity() {
  const auto built = build_identity();
  static const std::string once =
      text("version", built.version) + text("sources", built.sources) + text("compiler", built.compiler) +
      text("flags", built.flags) + text("build", built.build) + text("instructions", instruction_set()) +
      text("processor", processor()) +
      text("libraries", fmt::format("libc {}, Eigen {}.{}.{}", gnu_get_libc_version(), EIGEN_WORLD_VERSION,
                                    EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION));
  return once;
}

std::string program_name(const std::string& identity) {
  std::string found = "of no version";
  for (const auto& [key, value, whole] : canonical_lines(identity))
    if (key == "version" && value.size() > 2) found = value.substr(1, value.size() - 2);
  return fmt::format("{} ({})", found, digest(identity).substr(0, 10));
}

std::string formulation_identity(std::string_view formulation, bool matched,
                                 const std::vector<double>& restitution) {
  return text("formulation", formulation) + line("matched", matched ? "true" : "false") +
         (matched ? line("restitution", toml_numbers(restitution)) : "");
}

std::string outside_identity(const Outside& outside) {
  std::string lines;
  if (outside.law) lines = text("law", outside.law->name) + text("law_digest", outside.law->digest);
  std::vector<std::string> loads, names, digests;
  for (const auto& [load, force] : outside.forces) {
    loads.push_back(toml_quoted(load));
    names.push_back(toml_quoted(force->name));
    digests.push_back(toml_quoted(force->digest));
  }
  if (!loads.empty())
    for (const auto& [key, list] :
         {std::pair{"load_forces", &loads}, {"load_force_names", &names}, {"load_force_digests", &digests}})
      lines += line(key, fmt::format("[{}]", fmt::join(*list, ", ")));
  return lines;
}

std::string start_identity(const std::optional<State>& start) {
  if (!start) return "";
  return line("t", toml_number(start->t)) + line("q", toml_numbers(start->q)) +
         line("v", toml_numbers(start->v)) + line("z", toml_numbers(start->z));
}

Origin origin_of(const Scene& scene) {
  return {scene.file.string(), scene.text, scene.overrides, scene.format.has_value()};
}

namespace {

/// Parses a canonical text of this program or of an older version, which also wrote keys that the
/// scene's choices do not read.
Scene parse_recorded(std::string text) {
  for (;;) try {
      return parse_scene(text, "identity");
    } catch (const UnreadKey& e) {
      std::string rest;
      for (const auto& line : canonical_lines(text))
        if (line.key != e.key) rest += line.line + '\n';
      if (rest.size() >= text.size()) throw;
      text = std::move(rest);
    }
}

}  // namespace

Setup setup_of(const Identity& identity, const Origin& origin) {
  Setup s;
  s.scene = parse_recorded(identity.scene);
  s.scene.file = origin.file;
  s.scene.text = origin.text;
  s.scene.overrides = origin.overrides;
  if (!origin.states_format) s.scene.format.reset();
  const Part how(identity.formulation);
  s.formulation = how.value<std::string>("formulation");
  s.matched = how.value<bool>("matched");
  if (const auto digest = how.text_or_none("law_digest"); !digest.empty())
    s.outside["normal forces"] = {how.text_or_none("law"), digest};
  const auto loads = how.texts_or_none("load_forces"), names = how.texts_or_none("load_force_names"),
             digests = how.texts_or_none("load_force_digests");
  for (std::size_t i = 0; i < loads.size(); ++i)
    s.outside[force_of(loads[i])] = {i < names.size() ? names[i] : "", i < digests.size() ? digests[i] : ""};
  if (!identity.given.empty()) {
    const Part given(identity.given);
    s.start = State{given.value<double>("t"), given.list("q"), given.list("v"), given.list("z")};
  }
  return s;
}

void Setup::give(const Outside& given) {
  std::map<std::string, FromOutside> has;
  if (given.law) has["normal forces"] = {given.law->name, given.law->digest};
  for (const auto& [load, force] : given.forces) has[force_of(load)] = {force->name, force->digest};
  for (const auto& [what, is] : has)
    if (!outside.contains(what))
      throw SceneError(fmt::format("this run has no {} from outside and cannot be repeated with {}",
                                   visible_brief(what), is.name));
  for (const auto& [what, was] : outside) {
    const auto found = has.find(what);
    if (found == has.end() || found->second.digest != was.digest)
      throw SceneError(fmt::format(
          "the run uses {} of {} (digest {}){}; give it with --law-plugin", visible_brief(what),
          visible_brief(was.name), visible_brief(was.digest),
          found == has.end()
              ? ""
              : fmt::format(", not of {} (digest {})", found->second.name, found->second.digest)));
  }
  put(scene, given);
}

}  // namespace freeplay
