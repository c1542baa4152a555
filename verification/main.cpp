// The test program: Catch2's main, the kinds of tests, and the closing line of scripts/check.
//
// The folder of a test below verification/ is its kind: unit, property (a property for many inputs,
// compared with another method or another step) or process (starts programs). Kind and folder are
// tags, as [process] and [process/study]. A test with the tag [long] has no kind; scripts/nightly
// runs it.
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

constexpr std::string_view kinds[] = {"unit", "property", "process"};

bool has_tag(const Catch::TestCaseInfo& test, std::string_view tag) {
  return std::ranges::find(test.tags, tag) != test.tags.end();
}

/// The folder below verification/, such as process/study.
std::string folder_of(const Catch::TestCaseInfo& test) {
  const std::string file = std::filesystem::path(test.lineInfo.file).parent_path().generic_string();
  constexpr std::string_view top = "verification/";
  return file.substr(file.rfind(top) + top.size());
}

/// As Catch2 itself does for the option --filenames-as-tags.
void tag_with_folders(const Catch::IConfig& config) {
  for (auto& test : const_cast<std::vector<Catch::TestCase>&>(Catch::getAllTestCasesSorted(config))) {
    auto tags = test.tags;
    const auto folder = folder_of(test);
    const auto kind = has_tag(test, "program") ? "process" : folder.substr(0, folder.find('/'));
    if (std::ranges::find(kinds, kind) == std::end(kinds))
      throw std::runtime_error("the test \"" + test.name + "\" in " + folder +
                               " has no kind: move it below verification/unit, property or process");
    tags.push_back(folder);
    if (!has_tag(test, "long")) tags.push_back(kind);
    setTags(test, tags);
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
    std::printf("the test \"%s\" starts programs: move it to verification/process\n",
                stats.testInfo.name.c_str());
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
    tag_with_folders(session.config());
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
