// The test program: Catch2's main, the kinds of tests, and the closing line that scripts/check promises.
//
// Each test has one of four kinds, which is a tag of it: [unit], [property] (what holds for many inputs, by another way or at
// another step), [process] (starts programs) or [long] (scripts/nightly runs it). A test that takes long says so itself; the
// others have their kind from the table below.
#define CATCH_CONFIG_RUNNER
#include <sys/resource.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace {

constexpr std::array<std::string_view, 4> kinds{"unit", "property", "process", "long"};

/// Files, without _test.cpp, whose tests start programs; tests of other files that do have the tag [program].
constexpr std::string_view starts_programs[] = {"animate",
                                                "bounded",
                                                "equilibrium",
                                                "figure_script",
                                                "force_figures",
                                                "help",
                                                "hostile_database",
                                                "hostile_folders",
                                                "hostile",
                                                "large_check",
                                                "library",
                                                "mistakes",
                                                "name_length",
                                                "new",
                                                "plain_words",
                                                "planted",
                                                "plot",
                                                "point_bodies",
                                                "point_bodies_use",
                                                "repeat",
                                                "report",
                                                "scaling",
                                                "section",
                                                "shards",
                                                "slurm",
                                                "style",
                                                "study",
                                                "submit",
                                                "walk",
                                                "written"};
/// From a tag or a folder of verification/ to the kind; the first line that fits decides.
constexpr std::pair<std::string_view, std::string_view> kind_by_name[] = {{"long", "long"},
                                                                          {"program", "process"},
                                                                          {"killed", "process"},
                                                                          {"extremes", "process"},
                                                                          {"claims", "property"},
                                                                          {"cross", "property"},
                                                                          {"invariants", "property"},
                                                                          {"order", "property"},
                                                                          {"random_scenes", "property"},
                                                                          {"strangers", "property"},
                                                                          {"analytic", "unit"},
                                                                          {"timing", "unit"},
                                                                          {"unit", "unit"}};

bool has_tag(const Catch::TestCaseInfo& test, std::string_view tag) {
  return std::ranges::find(test.tags, tag) != test.tags.end();
}

std::string kind_of(const Catch::TestCaseInfo& test) {
  const std::filesystem::path path(test.lineInfo.file);
  const auto file = path.stem().string(), folder = path.parent_path().filename().string();
  if (!has_tag(test, "long"))
    for (const auto name : starts_programs)
      if (file == std::string(name) + "_test") return "process";
  for (const auto& [name, kind] : kind_by_name)
    if (has_tag(test, name) || folder == name) return std::string(kind);
  throw std::runtime_error("the test \"" + test.name + "\" in the folder " + folder +
                           " has no kind: name the folder in verification/main.cpp");
}

/// As Catch2 itself does for the option --filenames-as-tags.
void tag_with_kinds(const Catch::IConfig& config) {
  for (auto& test : const_cast<std::vector<Catch::TestCase>&>(Catch::getAllTestCasesSorted(config))) {
    auto tags = test.tags;
    const auto kind = kind_of(test);
    if (!has_tag(test, kind)) tags.push_back(kind);
    setTags(test, tags);
    if (std::ranges::count_if(kinds, [&](std::string_view k) { return has_tag(test, k); }) != 1)
      throw std::runtime_error("the test \"" + test.name +
                               "\" has more than one kind: " + test.tagsAsString());
  }
}

/// Pages that programs which were started and have ended have touched.
long pages_of_children() {
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  return used.ru_minflt;
}

struct ClosingLine : Catch::TestEventListenerBase {
  using TestEventListenerBase::TestEventListenerBase;
  void testCaseStarting(const Catch::TestCaseInfo&) override { pages = pages_of_children(); }
  void testCaseEnded(const Catch::TestCaseStats& stats) override {
    if (pages_of_children() == pages || has_tag(stats.testInfo, "process") || has_tag(stats.testInfo, "long"))
      return;
    std::printf("the test \"%s\" starts programs: it needs the tag [program]\n", stats.testInfo.name.c_str());
    if (stats.totals.testCases.allPassed()) ++wrong_kinds;
  }
  void testRunEnded(const Catch::TestRunStats& stats) override {
    // A test that may fail ([!mayfail], its reason beside it) and did is named as a known failure, and not counted as failed.
    known = static_cast<long>(stats.totals.testCases.failedButOk);
    passed = static_cast<long>(stats.totals.testCases.passed) + known;
    failed = static_cast<long>(stats.totals.testCases.failed);
    passed -= wrong_kinds, failed += wrong_kinds;
  }
  long pages = 0;
  static inline long passed = 0, failed = 0, known = 0;
  static inline long wrong_kinds = 0;
};
CATCH_REGISTER_LISTENER(ClosingLine)

}  // namespace

int main(int argc, char** argv) {
  Catch::Session session;
  if (const int status = session.applyCommandLine(argc, argv); status != 0) return status;
  try {
    tag_with_kinds(session.config());
  } catch (const std::runtime_error& wrong) {
    std::fprintf(stderr, "%s\n", wrong.what());
    return 1;
  }
  const int status = session.run();
  if (ClosingLine::known > 0)
    std::printf("%ld known failures among those that count as passed, shown above\n", ClosingLine::known);
  std::printf("%ld passed, %ld failed\n", ClosingLine::passed, ClosingLine::failed);
  return status != 0 || ClosingLine::passed == 0 || ClosingLine::wrong_kinds > 0;
}
