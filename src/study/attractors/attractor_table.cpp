#include "study/attractors/attractor_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <set>

#include "values/table.hpp"

namespace freeplay {
namespace {

/// Calls f(run, number of its attractor) for each completed run, chain by chain.
void each_run(const SettledRuns& runs, const Classified& classified, auto f) {
  for (std::size_t c = 0; c < runs.chains.size(); ++c)
    for (std::size_t i = 0; i < runs.chains[c].size(); ++i)
      if (!runs.chains[c][i].values.empty()) f(runs.chains[c][i], classified.of[c][i]);
}

/// Numbers of the attractors, each in the list of its run.
Classified numbered(const SettledRuns& runs, auto list_of) {
  Classified classified;
  for (const auto& chain : runs.chains) {
    auto& numbers = classified.of.emplace_back();
    for (const auto& run : chain)
      numbers.push_back(run.values.empty() || !run.finished()
                            ? -1
                            : static_cast<int>(place_among(list_of(run), run.attractor, runs.likeness)));
  }
  return classified;
}

nlohmann::json to_json(const std::vector<NamedColumn>& columns) {
  auto list = nlohmann::json::array();
  for (const auto& c : columns) list.push_back({{"name", c.name}, {"unit", c.unit}});
  return list;
}

nlohmann::json to_json(const Axis& axis) {
  return {{"name", axis.name}, {"key", axis.key}, {"unit", axis.unit}, {"scale", axis.scale}};
}

nlohmann::json common_json(const SettledRuns& runs, const AttractorPlan& plan) {
  std::size_t all = 0, failed = 0, doubtful = 0;
  for (const auto& chain : runs.chains)
    for (const auto& run : chain) {
      all += !run.values.empty();
      failed += !run.finished();
      doubtful += !run.doubt.empty();
    }
  nlohmann::json document = {{"section", plan.section},
                             {"formulation", plan.formulation},
                             {"period_s", runs.period},
                             {"discard_periods", plan.discard},
                             {"keep_periods", plan.keep},
                             {"tolerance", plan.tolerance},
                             {"most_period", plan.most_period},
                             {"columns", to_json(runs.columns)},
                             {"runs", all},
                             {"failed", failed},
                             {"doubtful", doubtful}};
  if (plan.exponents) document["exponent_periods"] = plan.averaged();
  return document;
}

/// As the list of lyapunov.json.
nlohmann::json to_json(const AttractorExponent& e, double period) {
  return {{"per_s", e.value},
          {"standard_error_per_s", e.error},
          {"per_period", period > 0 ? e.value * period : NAN},
          {"reason", e.reason}};
}

/// A table with its own columns, those of a point, and the exponent.
Table table_of(const char* columns, const SettledRuns& runs, bool exponents) {
  Table table(columns);
  for (const auto& c : runs.columns) table.column(c.name);
  if (exponents) table.column("exponent"), table.column("exponent_error");
  return table;
}

/// Adds a row that begins with `cells`. Of an absent point or exponent, the columns are NaN.
void add_row(Table& table, std::vector<Table::Cell> cells, const SettledRuns& runs, const SettledRun& run,
             std::size_t point, bool exponents) {
  const auto width = runs.columns.size();
  for (std::size_t j = 0; j < width; ++j)
    cells.emplace_back(point < run.t.size() ? run.rows[point * width + j] : std::nan(""));
  if (exponents)
    for (const auto part : {&AttractorExponent::value, &AttractorExponent::error})
      cells.emplace_back(run.exponent ? (*run.exponent).*part : std::nan(""));
  table.row(std::move(cells));
}

/// Text "exponent 1.2 +- 0.1 1/s", in the notation of a terminal.
std::string exponent_text(const AttractorExponent& e) {
  if (std::isnan(e.value)) return "exponent unknown";
  if (!std::isfinite(e.value)) return "exponent -inf";
  return fmt::format("exponent {:.4g} +- {:.1g} 1/s", e.value, e.error);
}

/// Of each attractor of a basin.
std::vector<std::optional<AttractorExponent>> exponents_of(const SettledRuns& runs,
                                                           const Classified& classified) {
  std::vector<std::optional<AttractorExponent>> list(classified.list.size());
  each_run(runs, classified, [&](const SettledRun& run, int attractor) {
    if (attractor >= 0 && run.exponent) list[static_cast<std::size_t>(attractor)] = run.exponent;
  });
  return list;
}

std::string shown(double x) { return fmt::format("{:.6g}", x); }

/// Attractors of all branches at one value.
struct Kinds {
  std::set<int> settled;  ///< attractors other than the aperiodic one
  bool aperiodic = false;
  bool chaotic = false;  ///< a positive exponent, beyond twice its standard error
};

/// Text "WHAT: 0.3 to 0.5, 0.7 UNIT": intervals of values with this property; empty if there are
/// none.
std::string listed(const char* what, const std::string& unit, const std::map<double, Kinds>& kinds,
                   bool (*holds)(const Kinds&)) {
  std::string text;
  for (auto it = kinds.begin(); it != kinds.end();) {
    const auto first = it;
    auto last = it;
    for (; it != kinds.end() && holds(it->second); ++it) last = it;
    if (it == first) {
      ++it;
      continue;
    }
    text +=
        (text.empty() ? "" : ", ") + shown(first->first) + (last != first ? " to " + shown(last->first) : "");
  }
  return text.empty() ? "" : fmt::format("{}: {}{}{}\n", what, text, unit.empty() ? "" : " ", unit);
}

/// Text "BODY.y = 0.1, 0.2 m; ..." of one cycle, with at most four points.
std::string cycle(const Attractor& a, const std::vector<NamedColumn>& columns) {
  if (a.period <= 0) return "";
  std::string text;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    text += (j > 0 ? "; " : "") + columns[j].name + " = ";
    const auto most = std::min(a.period, 4);
    for (int i = 0; i < most; ++i)
      text += fmt::format("{}{:.4g}", i > 0 ? ", " : "",
                          a.points[static_cast<std::size_t>(i) * columns.size() + j]);
    if (a.period > most) text += ", ...";
    if (!columns[j].unit.empty()) text += " " + columns[j].unit;
  }
  return text;
}

}  // namespace

std::vector<Chain> bifurcation_chains(const Study& study) {
  const auto& plan = *study.bifurcation;
  const auto& axis = study.axes[plan.axis];
  std::vector<std::size_t> places(axis.values.size());
  std::iota(places.begin(), places.end(), 0);
  std::ranges::sort(places, {}, [&](std::size_t i) { return axis.values[i]; });
  const auto link = [&](std::size_t place, int start) {
    return ChainLink{settings_at(axis, place), {axis.values[place]}, start};
  };
  std::vector<Chain> chains;
  if (plan.up()) {
    chains.push_back({"up", {}});
    for (const auto place : places) chains.back().links.push_back(link(place, -1));
  }
  if (plan.down()) {
    chains.push_back({"down", {}});
    for (auto i = places.size(); i-- > 0;) chains.back().links.push_back(link(places[i], -1));
  }
  for (int start = 0; start < plan.starts; ++start)
    for (const auto place : places) chains.push_back({fmt::format("start {}", start), {link(place, start)}});
  return chains;
}

std::vector<Chain> basin_chains(const Study& study) {
  const auto &x = study.axes[study.basin->x], &y = study.axes[study.basin->y];
  std::vector<Chain> chains;
  for (std::size_t j = 0; j < y.values.size(); ++j)
    for (std::size_t i = 0; i < x.values.size(); ++i) {
      auto overrides = settings_at(x, i);
      const auto others = settings_at(y, j);
      overrides.insert(overrides.end(), others.begin(), others.end());
      chains.push_back({"grid", {{std::move(overrides), {x.values[i], y.values[j]}}}});
    }
  return chains;
}

Classified attractors_at_each_value(const SettledRuns& runs) {
  std::map<double, std::vector<Attractor>> at;
  auto classified = numbered(
      runs, [&](const SettledRun& run) -> auto& { return at[run.values[0]]; });
  classified.at_each_value = true;
  return classified;
}

Classified attractors_of_all(const SettledRuns& runs) {
  std::vector<Attractor> list;
  auto classified = numbered(
      runs, [&](const SettledRun&) -> auto& { return list; });
  classified.list = std::move(list);
  return classified;
}

std::string bifurcation_csv(const Study& study, const SettledRuns& runs, const Classified& classified) {
  const auto& axis = study.axes[study.bifurcation->axis];
  const bool exponents = study.bifurcation->exponents;
  auto table = table_of("branch,value,attractor,period,t", runs, exponents);
  each_run(runs, classified, [&](const SettledRun& run, int attractor) {
    // A row without points shows that it was run.
    for (std::size_t i = 0; i < std::max<std::size_t>(run.t.size(), 1); ++i)
      add_row(table,
              {run.branch, run.values[0] * axis.scale, attractor, run.attractor.period,
               run.t.empty() ? std::nan("") : run.t[i]},
              runs, run, i, exponents);
  });
  return table.csv();
}

nlohmann::json bifurcation_json(const Study& study, const SettledRuns& runs, const Classified& classified) {
  auto document = common_json(runs, *study.bifurcation);
  document["axis"] = to_json(study.axes[study.bifurcation->axis]);
  auto list = nlohmann::json::array();
  each_run(runs, classified, [&](const SettledRun& run, int attractor) {
    nlohmann::json one = {{"branch", run.branch},
                          {"value", run.values[0]},
                          {"attractor", attractor},
                          {"kind", run.finished() ? run.attractor.name() : "failed"},
                          {"points", run.t.size()}};
    if (!run.failure.empty()) one["failure"] = run.failure;
    if (!run.doubt.empty()) one["doubt"] = run.doubt;
    if (run.exponent) one["exponent"] = to_json(*run.exponent, run.period);
    list.push_back(std::move(one));
  });
  document["at"] = std::move(list);
  return document;
}

std::string bifurcation_text(const Study& study, const SettledRuns& runs, const Classified& classified) {
  const auto& axis = study.axes[study.bifurcation->axis];
  struct Stretch {
    double from, to;
    std::string kind;
  };
  std::vector<std::pair<std::string, std::vector<Stretch>>> branches;
  std::map<double, Kinds> kinds;
  each_run(runs, classified, [&](const SettledRun& run, int attractor) {
    const double x = run.values[0] * axis.scale;
    auto& at = kinds[x];
    at.chaotic |= run.exponent && run.exponent->value > 2 * run.exponent->error;
    if (run.finished() && run.attractor.period == Attractor::aperiodic) at.aperiodic = true;
    if (run.finished() && run.attractor.period != Attractor::aperiodic) at.settled.insert(attractor);
    const auto kind = run.finished() ? run.attractor.name() : "failed";
    if (branches.empty() || branches.back().first != run.branch)
      branches.emplace_back(run.branch, std::vector<Stretch>());
    auto& list = branches.back().second;
    if (list.empty() || list.back().kind != kind) list.push_back({x, x, kind});
    list.back().to = x;
  });
  std::string text = fmt::format("{:<10}{:>14}{:>14}  attractor ({})\n", "branch", "from", "to",
                                 axis.unit.empty() ? axis.name : axis.name + ", " + axis.unit);
  for (const auto& [branch, list] : branches)
    for (const auto& s : list)
      text += fmt::format("{:<10}{:>14}{:>14}  {}\n", branch, shown(s.from), shown(s.to), s.kind);
  text += listed("several attractors at one value", axis.unit, kinds,
                 [](const Kinds& k) { return k.settled.size() > 1; });
  text += listed("branches differ: coexisting attractors, or the discarded interval is too short", axis.unit,
                 kinds, [](const Kinds& k) { return k.settled.size() == 1 && k.aperiodic; });
  text += listed("positive Lyapunov exponent", axis.unit, kinds, [](const Kinds& k) { return k.chaotic; });
  return text;
}

std::string basin_csv(const Study& study, const SettledRuns& runs, const Classified& classified) {
  const auto &x = study.axes[study.basin->x], &y = study.axes[study.basin->y];
  const bool exponents = study.basin->exponents;
  auto table = table_of("x,y,attractor,period", runs, exponents);
  each_run(runs, classified, [&](const SettledRun& run, int attractor) {
    add_row(table, {run.values[0] * x.scale, run.values[1] * y.scale, attractor, run.attractor.period}, runs,
            run, run.t.empty() ? 0 : run.t.size() - 1, exponents);
  });
  return table.csv();
}

nlohmann::json basin_json(const Study& study, const SettledRuns& runs, const Classified& classified) {
  auto document = common_json(runs, *study.basin);
  document["x"] = to_json(study.axes[study.basin->x]);
  document["y"] = to_json(study.axes[study.basin->y]);
  std::vector<std::size_t> cells(classified.list.size(), 0);
  const auto exponents = exponents_of(runs, classified);
  each_run(runs, classified, [&](const SettledRun&, int attractor) {
    if (attractor >= 0) ++cells[static_cast<std::size_t>(attractor)];
  });
  auto list = nlohmann::json::array();
  for (std::size_t a = 0; a < classified.list.size(); ++a) {
    list.push_back({{"kind", classified.list[a].name()},
                    {"cycle", cycle(classified.list[a], runs.columns)},
                    {"points", classified.list[a].points},
                    {"cells", cells[a]}});
    if (exponents[a]) list.back()["exponent"] = to_json(*exponents[a], runs.period);
  }
  document["attractors"] = std::move(list);
  return document;
}

std::string basin_text(const Study&, const SettledRuns& runs, const Classified& classified) {
  std::vector<std::size_t> cells(classified.list.size(), 0);
  std::size_t all = 0;
  each_run(runs, classified, [&](const SettledRun&, int attractor) {
    ++all;
    if (attractor >= 0) ++cells[static_cast<std::size_t>(attractor)];
  });
  std::string text = fmt::format("{:<10}{:>8}{:>8}  {}\n", "attractor", "cells", "share", "kind");
  const auto exponents = exponents_of(runs, classified);
  for (std::size_t a = 0; a < classified.list.size(); ++a) {
    text += fmt::format("{:<10}{:>8}{:>7.1f}%  {}{}\n", a, cells[a],
                        100.0 * static_cast<double>(cells[a]) / static_cast<double>(all),
                        classified.list[a].name(),
                        exponents[a] ? ", " + exponent_text(*exponents[a]) : std::string());
    if (const auto points = cycle(classified.list[a], runs.columns); !points.empty())
      text += fmt::format("{:28}{}\n", "", points);
  }
  return text;
}

}  // namespace freeplay
