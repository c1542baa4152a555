// freeplay new KIND: writes a commented scene to start from, src/cli/templates/KIND.toml; --list shows all
// kinds with their titles.
#include <fmt/format.h>

#include <algorithm>

#include "cli/command_line.hpp"
#include "io/files/output_file.hpp"
#include "io/scene/section.hpp"
#include "mechanism/error.hpp"

namespace freeplay::cli {
namespace {

struct Template {
  const char* kind;
  const char* text;
};
constexpr Template templates[] = {
#include "templates.inc"
};

struct NewRequest : Request {
  std::string kind;
  std::string output;  ///< file
  bool list = false;   ///< show the kinds instead
};

/// Prints each kind with the title of its scene.
int list_kinds() {
  for (const auto& one : templates)
    fmt::print("{:<14}{}\n", one.kind, parse_toml(one.text, one.kind)["title"].value_or<std::string>(""));
  fmt::print("\npictures: docs/how-to/templates.md\n");
  return 0;
}

int write_new(const NewRequest& request) {
  if (request.list) return list_kinds();
  if (request.kind.empty()) throw SceneError("kind is required; freeplay new --list shows all");
  const auto* chosen = std::ranges::find(templates, request.kind, &Template::kind);
  const std::filesystem::path named = request.output.empty() ? request.kind + ".toml" : request.output;
  if (std::filesystem::exists(std::filesystem::symlink_status(named)))
    throw SceneError(
        fmt::format("{}: already exists and is not overwritten; name another file with -o", named.string()));
  const auto folder = real_folder(named.has_parent_path() ? named.parent_path() : ".");
  if (!std::filesystem::is_directory(folder))
    throw SceneError(
        fmt::format("{}: {}", folder.string(),
                    std::filesystem::exists(folder)
                        ? "is not a folder"
                        : "there is no such folder; create it first, or name a file elsewhere with -o"));
  write_file(folder / named.filename(), chosen->text);
  fmt::print(
      "{0}\nlook at it:  freeplay check {0} -o out/pose\nrun it:      freeplay compare {0}\n"
      "edit it:     freeplay schema scene > {1}   completion in editors\n",
      named.string(), named.parent_path().append("scene.schema.json").string());
  return 0;
}

}  // namespace

void new_verb(Program& program) {
  auto [options, request] = program.verb("new", "create a ready-to-run template", write_new);
  std::vector<std::string> kinds;
  for (const auto& one : templates) kinds.emplace_back(one.kind);
  options.add("kind", request.kind, "kind of mechanism").one_of(kinds);
  options
      .add("-o,--output", request.output,
           "output file, default KIND.toml in the working folder; existing files are not overwritten")
      .takes("FILE");
  options.flag("--list", request.list, "list the kinds with their titles instead");
}

}  // namespace freeplay::cli
