#include "study/store/results_inserts.hpp"

#include <fmt/format.h>

#include <cmath>

#include "study/store/results_tables.hpp"
#include "study/store/work_list.hpp"

namespace freeplay {
namespace {

std::string insert(const char* into, std::size_t columns) {
  std::string marks = "?";
  for (std::size_t i = 1; i < columns; ++i) marks += ", ?";
  return fmt::format("INSERT {} VALUES ({})", into, marks);
}

double finite(double x) { return std::isfinite(x) ? x : std::nan(""); }

}  // namespace

Results::Inserts::Inserts(const Database& owner, std::size_t columns_of_runs)
    : database(owner),
      run(owner, insert("OR REPLACE INTO runs", columns_of_runs)),
      turn(owner, insert("INTO turn_rows", 3)),
      flight(owner, insert("INTO flight_rows", 6)),
      impact(owner, insert("INTO impact_rows", 5)),
      measure(owner, insert("INTO measure_rows", 5)),
      cost(owner, insert("INTO cost_rows", 5)),
      spectrum(owner, insert("INTO spectrum_blobs", 2)),
      trace(owner, insert("INTO trace_blobs", 4)),
      done(owner, WorkList::done) {}

Results::Inserts& Results::inserts() {
  // run, variant, formulation, start; status, reason; its number, which SQLite gives
  if (!inserts_)
    inserts_ =
        std::make_unique<Inserts>(database_, 4 + axes_ + TurnMetrics::count + measures_.size() + 2 + 1);
  return *inserts_;
}

void Results::store(std::span<const MadeRun> batch) {
  Database::Transaction whole(database_);
  for (const auto& made : batch) put(made.key, *made.what, made.result);
  whole.commit();
}

void Results::store(const std::string& key, const Case& one, const CaseResult& result) {
  Database::Transaction whole(database_);
  put(key, one, result);
  whole.commit();
}

void Results::put(const std::string& key, const Case& one, const CaseResult& r) {
  auto& into = inserts();
  const auto& m = r.metrics;
  const bool finished = r.ending.status == Ending::Status::finished;
  auto& s = into.run;
  s.bind(key).bind(one.variant).bind(one.formulation).bind(static_cast<long>(one.start));
  for (double x : one.values) s.bind(x);
  for (double x : m.value) s.bind(finished ? finite(x) : std::nan(""));
  for (std::size_t i = 0; i < measures_.size(); ++i)
    s.bind(finished ? finite(r.measured[i].value) : std::nan(""));
  auto reason = r.ending.reason;
  for (const auto& note : r.notes)
    if (finished && note.starts_with("DOUBTFUL")) reason += (reason.empty() ? "" : "; ") + note;
  s.bind(std::string(finished ? "finished" : "failed")).bind(reason).bind(std::nan(""));
  s.again();
  const long id = database_.last_id();

  const auto contact = [&](int k) {
    const auto i = static_cast<std::size_t>(k);
    return i < r.contacts.size() ? r.contacts[i] : std::string();
  };
  for (std::size_t i = 0; i < m.peaks.size(); ++i)
    into.turn.bind(id).bind(static_cast<long>(i + 1)).bind(m.peaks[i]).again();
  for (const auto& f : m.flights)
    into.flight.bind(id)
        .bind(f.loss)
        .bind(f.angle)
        .bind(f.duration)
        .bind(f.deceleration)
        .bind(contact(f.contact))
        .again();
  for (const auto& i : m.impacts)
    into.impact.bind(id).bind(i.angle).bind(i.approach).bind(i.impulse).bind(contact(i.contact)).again();
  for (std::size_t i = 0; i < r.measured.size(); ++i) {
    long number = 0;
    for (const auto& part : r.measured[i].parts)
      into.measure.bind(id).bind(measures_[i]).bind(++number).bind(part.t).bind(part.value).again();
  }
  const std::vector<float> amplitudes(m.spectrum.begin(), m.spectrum.end());
  if (!amplitudes.empty()) into.spectrum.bind(id).bind(amplitudes).again();
  if (one.start == 0 && !m.last_turn.empty()) {
    const auto trace = packed(m.last_turn);
    into.trace.bind(id).bind(trace.angle).bind(trace.acceleration).bind(trace.position).again();
  }
  into.cost.bind(id).bind(r.cpu_seconds).bind(r.work.steps).bind(r.work.rhs).bind(r.work.pivots).again();
  into.done.bind(key).again();
}

}  // namespace freeplay
