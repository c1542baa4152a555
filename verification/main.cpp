// The test program: Catch2's main, and the closing line that scripts/check promises.
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

#include <cstdio>

namespace {

struct ClosingLine : Catch::TestEventListenerBase {
  using TestEventListenerBase::TestEventListenerBase;
  void testRunEnded(const Catch::TestRunStats& stats) override {
    // A test that may fail ([!mayfail], with its reason) and did is no failure of the whole; its checks are printed.
    passed = static_cast<long>(stats.totals.testCases.passed + stats.totals.testCases.failedButOk);
    failed = static_cast<long>(stats.totals.testCases.failed);
  }
  static inline long passed = 0, failed = 0;
};
CATCH_REGISTER_LISTENER(ClosingLine)

}  // namespace

int main(int argc, char** argv) {
  const int status = Catch::Session().run(argc, argv);
  std::printf("%ld passed, %ld failed\n", ClosingLine::passed, ClosingLine::failed);
  return status != 0 || ClosingLine::passed == 0;
}
