#include "study/partition/divided_ensemble.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <mutex>

#include "facade/identify.hpp"
#include "io/files/digest.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

using Statement = Database::Statement;

constexpr int kind_of_file = 3;  // user_version; 1 and 2 are of sweeps and attractors
constexpr std::size_t most_reasons = 5;

}  // namespace

EnsembleStore::EnsembleStore(const std::filesystem::path& file, Database::Access access, StopToken stop)
    : database_(file, access, stop) {
  const auto refuse = [&] {
    throw OutputError(fmt::format(
        "{}: is no file of an ensemble of this freeplay; give another folder with -o, or move it away",
        file.string()));
  };
  if (access != Database::Access::write) {
    if (database_.kind() != kind_of_file) refuse();
    return;
  }
  Database::Transaction whole(database_);
  Statement existing(database_, "SELECT count(*) FROM sqlite_master");
  existing.step();
  if (existing.whole(0) > 0 && database_.kind() != kind_of_file) refuse();
  database_.execute(fmt::format("PRAGMA user_version = {}", kind_of_file));
  database_.execute(
      "CREATE TABLE IF NOT EXISTS runs (run TEXT PRIMARY KEY, start INTEGER, failure TEXT, steps INTEGER, rows BLOB)");
  database_.execute(
      "CREATE TABLE IF NOT EXISTS numbers (run TEXT REFERENCES runs(run) ON DELETE CASCADE, name TEXT, value REAL)");
  database_.execute("CREATE INDEX IF NOT EXISTS numbers_run ON numbers(run)");
  whole.commit();
}

bool EnsembleStore::find(const std::string& key, StartOutcome& outcome) const {
  Statement s(database_, "SELECT failure, steps, rows FROM runs WHERE run = ?");
  s.bind(key);
  if (!s.step()) return false;
  outcome = {.failure = s.text(0), .steps = s.whole(1)};
  outcome.rows = s.doubles(2);
  Statement numbers(database_, "SELECT name, value FROM numbers WHERE run = ?");
  numbers.bind(key);
  while (numbers.step()) outcome.numbers[numbers.text(0)] = numbers.number(1);
  return true;
}

void EnsembleStore::store(const std::string& key, int start, const StartOutcome& outcome) const {
  Database::Transaction whole(database_);
  Statement(database_, "INSERT OR REPLACE INTO runs VALUES (?, ?, ?, ?, ?)")
      .bind(key)
      .bind(static_cast<long>(start))
      .bind(outcome.failure)
      .bind(outcome.steps)
      .bind(std::span<const double>(outcome.rows))
      .step();
  Statement numbers(database_, "INSERT INTO numbers VALUES (?, ?, ?)");
  for (const auto& [name, value] : outcome.numbers) {
    numbers.bind(key).bind(name).bind(value);
    numbers.again();
  }
  whole.commit();
}

StartKeys::StartKeys(const Scene& scene, const EnsemblePlan& plan)
    : common_(fmt::format("{}\nseed {} turn {} play {} rows {} columns {}\n",
                          identify(scene, plan.formulation, true).digest(), plan.seed, plan.how.turn,
                          plan.how.play, plan.rows, fmt::join(plan.columns, " "))),
      starts_(plan.starts) {}

std::string StartKeys::operator()(int start) const {
  return digest(common_ + fmt::format("start {}", start));
}
std::string StartKeys::subject() const { return digest(common_ + fmt::format("starts {}", starts_)); }

Division divided_ensemble(const Scene& scene, const EnsemblePlan& plan, std::vector<std::string> arguments) {
  const StartKeys keys(scene, plan);
  return {
      .verb = "ensemble",
      .arguments = std::move(arguments),
      .subject = keys.subject(),
      .units =
          [&scene, plan, keys] {
            const Starts all(scene, plan);  // refuses what cannot be
            std::vector<Unit> units;
            for (int k = 0; k < plan.starts; ++k) units.push_back({keys(k), static_cast<std::size_t>(k)});
            return units;
          },
      .make =
          [&scene, plan, keys](const FolderLock& lock, const std::vector<Unit>& units, const MakeUnits& how) {
            auto own = plan;
            own.stop = how.stop;
            const Starts starts(scene, own);
            const EnsembleStore store(lock.folder() / "ensemble.db", Database::Access::write, how.stop);
            MadeUnits made;
            std::mutex guard;
            std::size_t done = 0;
            oneapi::tbb::task_arena arena(how.threads > 0 ? how.threads : oneapi::tbb::task_arena::automatic);
            arena.execute([&] {
              oneapi::tbb::parallel_for(std::size_t{0}, units.size(), [&](std::size_t i) {
                if (how.stop()) return;
                const int k = static_cast<int>(units[i].number);
                StartOutcome outcome;
                const auto there = [&] {
                  const std::lock_guard lock(guard);
                  return store.find(units[i].key, outcome);
                };
                const bool found = there();
                if (!found) outcome = starts.make(k);
                if (outcome.interrupted) return;
                const std::lock_guard lock(guard);
                if (!found) store.store(units[i].key, k, outcome);
                if (!outcome.failure.empty() && ++made.failed <= most_reasons)
                  made.reasons.push_back(fmt::format("start {}: {}", k, outcome.failure));
                if (how.on_progress) how.on_progress(++done);
              });
            });
            made.interrupted = how.stop();
            return made;
          }};
}

}  // namespace freeplay
