// Blobs of a study's results are read back as they were stored, to single precision.
#include "study/store/results.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

std::vector<TracePoint> even_turn(int n, bool placed) {
  std::vector<TracePoint> trace;
  for (int i = 0; i < n; ++i)
    trace.push_back({0.05 + 360.0 * i / n, std::sin(0.1 * i), placed ? 0.2 + 1e-4 * i : std::nan("")});
  return trace;
}

/// Single precision: half of 2⁻²³ of a number, here twice for the greatest angle.
constexpr double rounding = 360 * 1.2e-7;

void check_equal(const std::vector<TracePoint>& a, const std::vector<TracePoint>& b) {
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(std::abs(a[i].angle - b[i].angle) <= rounding);
    CHECK(a[i].acceleration == static_cast<float>(b[i].acceleration));
    CHECK((std::isnan(b[i].position) ? std::isnan(a[i].position)
                                     : a[i].position == static_cast<float>(b[i].position)));
  }
}

}  // namespace

TEST_CASE("a trace at equally spaced angles is stored with its first and last angle only", "[study][blobs]") {
  for (const bool placed : {false, true}) {
    const auto trace = even_turn(3000, placed);
    const auto blobs = packed(trace);
    CHECK(blobs.angle.size() == 2);
    CHECK(blobs.position.size() == (placed ? 3000 : 0));
    check_equal(unpacked(blobs), trace);
  }
  auto uneven = even_turn(100, true);
  uneven[50].angle += 1;
  CHECK(packed(uneven).angle.size() == 100);
  check_equal(unpacked(packed(uneven)), uneven);
  for (const int few : {0, 1, 2}) check_equal(unpacked(packed(even_turn(few, false))), even_turn(few, false));
}

TEST_CASE("inconsistent blobs give an empty trace", "[study][blobs]") {
  CHECK(unpacked({{0, 1, 2}, {1, 2}, {}}).empty());
  CHECK(unpacked({{0, 1}, {1, 2, 3}, {1}}).empty());
  CHECK(unpacked({{}, {1, 2, 3}, {}}).empty());
}

TEST_CASE("runs stored as a batch equal runs stored one by one", "[study][blobs]") {
  test::TemporaryFolder folder;
  Study study;
  study.variants = {{"v", "v", "", {}, {"penalty"}, 2, 2}};
  const Case first{"v", "penalty", {}, 0, 2, "", {}}, second{"v", "penalty", {}, 1, 2, "", {}};
  CaseResult r;
  r.ending.status = Ending::Status::finished;
  r.metrics.value.fill(1.5);
  r.metrics.peaks = {3, 4};
  r.metrics.impacts = {{10, 0.1, 0.2}};
  r.metrics.flights = {{20, 5, 0.01, 3}};
  r.metrics.spectrum = {1, 0.5, 0.1};
  r.metrics.last_turn = even_turn(30, true);
  Results batch(folder.path() / "batch.db", study), single(folder.path() / "single.db", study);
  batch.store(std::vector<MadeRun>{{"a", &first, r}, {"b", &second, r}});
  single.store(std::vector<MadeRun>{{"a", &first, r}});
  for (int times = 0; times < 2; ++times)  // the later one replaces the one before
    single.store(std::vector<MadeRun>{{"b", &second, r}});
  for (const auto* results : {&batch, &single}) {
    CHECK(results->runs().size() == 2);
    CHECK(results->impacts("b").size() == 1);
    CHECK(results->flights("b").front().loss == 20);
    CHECK(results->spectrum("a") == std::vector<double>{1, 0.5, static_cast<double>(0.1f)});
    check_equal(results->trace("a"), r.metrics.last_turn);
    CHECK(results->trace("b").empty());
  }
}
