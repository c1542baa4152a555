#include "study/store/results_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "study/store/work_list.hpp"

namespace freeplay {
namespace {

std::string table_of_runs(const Study& study) {
  std::string columns;
  for (const auto& axis : study.axes) columns += fmt::format("\"{}\" REAL, ", axis.name);
  for (const auto& name : TurnMetrics::names()) columns += fmt::format("{} REAL, ", name);
  for (const auto& measure : study.measures) columns += fmt::format("\"{}\" REAL, ", measure.name);
  return fmt::format(
      "CREATE TABLE runs (run TEXT UNIQUE, variant TEXT, formulation TEXT, start INTEGER, {}"
      "status TEXT, reason TEXT, \"run id\" INTEGER PRIMARY KEY)",
      columns);
}

}  // namespace

StoreForm results_form(const Study& study) {
  StoreForm form{3, {table_of_runs(study)}};
  for (const auto& [rows, view, columns] : lists_of_runs) {
    const bool single = std::string_view(columns).find("BLOB") != std::string_view::npos;
    form.definitions.push_back(
        fmt::format("CREATE TABLE {} (id INTEGER {}REFERENCES runs(\"run id\") ON DELETE CASCADE, {})", rows,
                    single ? "PRIMARY KEY " : "", columns));
    if (!single) form.definitions.push_back(fmt::format("CREATE INDEX {0}_id ON {0}(id)", rows));
  }
  form.definitions.insert(form.definitions.end(), WorkList::definitions.begin(), WorkList::definitions.end());
  return form;
}

PackedTrace packed(const std::vector<TracePoint>& trace) {
  PackedTrace out;
  const auto n = trace.size();
  if (n == 0) return out;
  const double first = trace.front().angle,
               step = n > 1 ? (trace.back().angle - first) / static_cast<double>(n - 1) : 0;
  bool even = n > 2, placed = false;
  for (std::size_t i = 0; i < n; ++i) {
    even = even && std::abs(trace[i].angle - first - static_cast<double>(i) * step) <= 1e-6 * step;
    placed = placed || !std::isnan(trace[i].position);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!even || i == 0 || i == n - 1) out.angle.push_back(static_cast<float>(trace[i].angle));
    out.acceleration.push_back(static_cast<float>(trace[i].acceleration));
    if (placed) out.position.push_back(static_cast<float>(trace[i].position));
  }
  return out;
}

std::vector<TracePoint> unpacked(const PackedTrace& trace) {
  const auto n = trace.acceleration.size();
  const bool even = trace.angle.size() != n;
  // The file may be of unknown origin: inconsistent blobs count as no trace.
  if ((even && (trace.angle.size() != 2 || n < 2)) || (!trace.position.empty() && trace.position.size() != n))
    return {};
  std::vector<TracePoint> out(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(std::max<std::size_t>(n - 1, 1));
    out[i].angle = even ? trace.angle[0] + share * (double(trace.angle[1]) - trace.angle[0]) : trace.angle[i];
    out[i].acceleration = trace.acceleration[i];
    out[i].position = trace.position.empty() ? std::nan("") : trace.position[i];
  }
  return out;
}

}  // namespace freeplay
