// The cost of merging a million synthetic runs: freeplay-tests "[.merge]". The runs are copies of
// one real run, with their own digests, impacts and costs, in 64 shards.
#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <chrono>
#include <cstdlib>
#include <fstream>

#include "study/partition/divided.hpp"
#include "study/partition/division.hpp"
#include "study/partition/merge.hpp"
#include "study/partition/shard.hpp"
#include "verification/support/ball_study.hpp"

using namespace freeplay;

namespace {

/// MB, the greatest so far of this process.
double peak_memory() {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
  return 0;
}

}  // namespace

TEST_CASE("a million runs are merged within two gigabytes", "[.merge]") {
  const char* requested = std::getenv("FREEPLAY_RUNS");
  const long runs = requested ? std::atol(requested) : 1'000'000;
  constexpr long shards = 64;
  const test::BallStudy place("values = [0.5]", "formulations = [\"nonsmooth\"]\n");
  const auto& folder = place.folder;
  const auto study = read_study(place.study);
  const auto division = divided_sweep(study, {}, "sweep", {}, subject_of(study));
  make_plan(division, folder.path() / "out", 1);
  make_shard(division, folder.path() / "out", {.shard = 1, .scratch = folder.path() / "scratch"});
  const auto one = folder.path() / "out/shards" / read_seal(folder.path() / "out", 1)->file;
  std::vector<std::filesystem::path> files;
  for (long k = 0; k < shards; ++k) {
    files.push_back(folder.path() / fmt::format("{}.db", k));
    copy_database(one, files.back());
    test::execute(files.back(), fmt::format(R"(
PRAGMA synchronous = OFF; PRAGMA foreign_keys = OFF; BEGIN;
CREATE TEMP TABLE n AS WITH RECURSIVE n(i) AS (SELECT 2 UNION ALL SELECT i + 1 FROM n WHERE i <= {})
  SELECT i FROM n;
CREATE TEMP TABLE new AS SELECT * FROM runs;
UPDATE new SET run = NULL;
INSERT INTO impact_rows SELECT n.i, r.angle, r.approach, r.impulse, r.contact
  FROM n, impact_rows AS r WHERE r.id = 1;
INSERT INTO cost_rows SELECT n.i, r.cpu_s, r.steps, r.right_hand_sides, r.pivots
  FROM n, cost_rows AS r WHERE r.id = 1;
CREATE TEMP TABLE many AS SELECT new.*, n.i AS number FROM n, new;
UPDATE many SET "run id" = number, run = lower(hex(randomblob(16)));
ALTER TABLE many DROP COLUMN number;
INSERT INTO runs SELECT * FROM many;
INSERT INTO work SELECT run, 'done', NULL FROM many;
DELETE FROM work WHERE run = (SELECT run FROM runs WHERE "run id" = 1);
DELETE FROM runs WHERE "run id" = 1; DELETE FROM impact_rows WHERE id = 1; DELETE FROM cost_rows WHERE id = 1;
DELETE FROM trace_blobs; DELETE FROM spectrum_blobs; COMMIT;)",
                                            runs / shards));
  }
  const auto began = std::chrono::steady_clock::now();
  merge_files(files, folder.path() / "all.db");
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  const double size = static_cast<double>(std::filesystem::file_size(folder.path() / "all.db")) * 1e-6,
               memory = peak_memory();
  fmt::print("{} runs of {} shards merged in {:.1f} s; {:.0f} MB of memory at most, {:.0f} MB of file\n",
             runs, shards, seconds, memory, size);
  CHECK(memory < 2000);
  CHECK(size > 100e-6 * static_cast<double>(runs));
}
