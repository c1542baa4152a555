#include "study/ensemble/ensemble_store.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "facade/identify.hpp"
#include "io/files/digest.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

using Statement = Database::Statement;

const StoreForm form{
    3,
    {"CREATE TABLE runs (run TEXT PRIMARY KEY, start INTEGER, failure TEXT, steps INTEGER, rows BLOB)",
     "CREATE TABLE numbers (run TEXT REFERENCES runs(run) ON DELETE CASCADE, name TEXT, value REAL)",
     "CREATE INDEX numbers_run ON numbers(run)"}};

}  // namespace

EnsembleStore::EnsembleStore(const std::filesystem::path& file, Database::Access access, StopToken stop)
    : RunStore(file, access, form, stop) {}

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
  database_.execute("INSERT OR REPLACE INTO runs VALUES (?, ?, ?, ?, ?)", key, static_cast<long>(start),
                    outcome.failure, outcome.steps, std::span<const double>(outcome.rows));
  Statement numbers(database_, "INSERT INTO numbers VALUES (?, ?, ?)");
  for (const auto& [name, value] : outcome.numbers) numbers.put(key, name, value);
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

}  // namespace freeplay
