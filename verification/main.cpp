// The test program: Catch2's main, the kinds of tests, and the closing line that scripts/check
// promises.
//
// Each test has one of four kinds, given by a tag: [unit], [property] (a property for many inputs,
// compared with another method or another step), [process] (starts programs) or [long]
// (scripts/nightly runs it). A long test has its tag in its file; the kinds of the others are in
// the table below.
#define CATCH_CONFIG_RUNNER
#include <sys/resource.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace {

/// A kind, and the tags, folders of verification/ and files that have it; the first match decides.
/// A test that starts programs and is in none of these files has the tag [program].
struct Kind {
  std::string_view name, of;
};
constexpr Kind kinds[] = {
    {"long", " long "},
    {"process",
     " program killed extremes "
     "animate_test bounded_test child_test claims-compiled equilibrium_test figure_script_test "
     "force_figures_test help_test hostile_database_test hostile_folders_test hostile_test "
     "large_check_test library_test "
     "mistakes_test name_length_test new_test plain_words_test planted_test plot_test "
     "point_bodies_test point_bodies_use_test repeat_test report_test scaling_test section_test "
     "shards_test slurm_test style_test study_test submit_test walk_test written_test "},
    {"property", " claims cross invariants order random_scenes strangers "},
    {"unit", " analytic timing unit "}};

bool has_tag(const Catch::TestCaseInfo& test, std::string_view tag) {
  return std::ranges::find(test.tags, tag) != test.tags.end();
}

std::string kind_of(const Catch::TestCaseInfo& test) {
  const std::filesystem::path file(test.lineInfo.file);
  auto names = test.tags;
  names.push_back(file.stem().string());
  names.push_back(file.parent_path().filename().string());
  for (const auto& kind : kinds)
    for (const auto& name : names)
      if (kind.of.find(" " + name + " ") != kind.of.npos) return std::string(kind.name);
  throw std::runtime_error("the test \"" + test.name +
                           "\" has no kind: name its folder in verification/main.cpp");
}

/// As Catch2 itself does for the option --filenames-as-tags.
void tag_with_kinds(const Catch::IConfig& config) {
  for (auto& test : const_cast<std::vector<Catch::TestCase>&>(Catch::getAllTestCasesSorted(config))) {
    auto tags = test.tags;
    const auto kind = kind_of(test);
    if (!has_tag(test, kind)) tags.push_back(kind);
    setTags(test, tags);
    if (std::ranges::count_if(kinds, [&](const Kind& k) { return has_tag(test, k.name); }) != 1)
      throw std::runtime_error("the test \"" + test.name +
                               "\" has more than one kind: " + test.tagsAsString());
  }
}

/// Memory pages touched by child programs that have ended.
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
    // A failed test with [!mayfail] (the reason is beside it) is reported as a known failure, and
    // not counted as failed.
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
  // A long run would start the C compiler in a test that starts no programs.
  setenv("FREEPLAY_COMPILE", "never", 1);
  const int status = session.run();
  if (ClosingLine::known > 0)
    std::printf("%ld known failures among those that count as passed, shown above\n", ClosingLine::known);
  std::printf("%ld passed, %ld failed\n", ClosingLine::passed, ClosingLine::failed);
  return status != 0 || ClosingLine::passed == 0 || ClosingLine::wrong_kinds > 0;
}
