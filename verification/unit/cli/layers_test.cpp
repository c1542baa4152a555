// The layers of the source tree: each file includes only its own layer and those below. A planted
// wrong include shows that the check can fail.
#include "verification/support/rig.hpp"

using namespace freeplay;
namespace fs = std::filesystem;

namespace {

// From the bottom up (docs/development/contributing.md, docs/development/decisions/036-layers.md).
constexpr std::array layers{"src/values/",     "src/numerics/", "src/mechanism/", "src/dynamics/",
                            "src/simulation/", "formulations/", "src/io/",        "src/compile/",
                            "src/facade/",     "src/analysis/", "src/measure/",   "src/study/",
                            "plots/",          "verification/", "src/cli/"};

std::optional<std::size_t> layer_of(const std::string& file) {
  for (std::size_t i = 0; i < layers.size(); ++i)
    if (file.starts_with(layers[i])) return i;
  return {};
}

/// The project's file that `name` in an include line refers to, from the top of the tree; empty:
/// one of another package.
std::string project_file(const fs::path& root, const std::string& name) {
  for (const char* base : {"", "src/"})
    if (fs::is_regular_file(root / (base + name))) return base + name;
  return {};
}

struct Include {
  std::string from, to;
};

std::vector<Include> includes_of(const fs::path& root) {
  std::vector<Include> list;
  for (const char* top : {"src", "formulations", "plots", "verification"})
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const auto extension = entry.path().extension();
      if (extension != ".cpp" && extension != ".hpp") continue;
      std::ifstream in(entry.path());
      for (std::string line; std::getline(in, line);) {
        constexpr std::string_view word = "#include \"";
        if (!line.starts_with(word)) continue;
        const auto name = line.substr(word.size(), line.find('"', word.size()) - word.size());
        if (auto to = project_file(root, name); !to.empty())
          list.push_back({fs::relative(entry.path(), root).generic_string(), std::move(to)});
      }
    }
  return list;
}

/// The reason why an include is not allowed; empty if it is.
std::string objection(const Include& i) {
  const auto from = layer_of(i.from), to = layer_of(i.to);
  const auto in = [](const std::string& file, std::string_view folder) { return file.starts_with(folder); };
  // Tests include headers of the program that they test.
  const bool test = i.from.ends_with("_test.cpp") || in(i.from, "verification/process/");
  if (from && to && *to > *from && !test) return "a layer above it";
  if (in(i.from, "src/numerics/") && !in(i.to, "src/numerics/") && !in(i.to, "src/values/"))
    return "numerics know no mechanics";
  const bool knows = in(i.from, "src/compile/") || in(i.from, "src/facade/") || in(i.from, "src/analysis/") ||
                     in(i.from, "src/cli/");
  if (in(i.from, "src/") && in(i.to, "formulations/") && !knows)
    return "compile, facade, analysis and cli alone know formulations";
  if (in(i.from, "verification/references/") && !in(i.to, "verification/references/"))
    return "references solve by hand and include no solver";
  return {};
}

std::vector<std::string> wrong(const std::vector<Include>& list) {
  std::vector<std::string> found;
  for (const auto& i : list)
    if (const auto why = objection(i); !why.empty())
      found.push_back(fmt::format("{} includes {}: {}", i.from, i.to, why));
  return found;
}

}  // namespace

TEST_CASE("each file includes only its own layer and those below", "[layers]") {
  const auto list = includes_of(test::source_folder());
  CHECK(list.size() > 2000);
  for (const auto& one : wrong(list)) FAIL_CHECK(one);
}

TEST_CASE("an include that violates the layers is found", "[layers]") {
  for (const auto& [from, to] : {std::pair{"src/values/state.hpp", "src/numerics/complementarity.hpp"},
                                 {"src/mechanism/curve.hpp", "src/dynamics/phase.hpp"},
                                 {"src/dynamics/system.hpp", "src/simulation/observer.hpp"},
                                 {"src/study/sweep/sweep.cpp", "plots/tables/table.hpp"},
                                 {"src/io/files/csv.cpp", "formulations/make.hpp"},
                                 {"src/facade/simulation.cpp", "src/analysis/orbit.hpp"},
                                 {"plots/report/page.cpp", "verification/support/support.hpp"},
                                 {"verification/references/slider_crank.hpp", "src/dynamics/system.hpp"}}) {
    CAPTURE(from, to);
    CHECK(wrong({{from, to}}).size() == 1);
  }
  CHECK(wrong({{"plots/report/page.cpp", "plots/tables/table.hpp"},
               {"src/facade/simulation.cpp", "formulations/make.hpp"}})
            .empty());
}
