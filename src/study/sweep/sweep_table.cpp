#include "study/sweep/sweep_table.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "io/files/output_file.hpp"
#include "io/files/run_json.hpp"
#include "mechanism/scene.hpp"
#include "study/runs/turns.hpp"
#include "study/settings/study.hpp"

namespace freeplay {

std::string_view unit_of(TurnMetrics::Name name) {
  switch (name) {
    case TurnMetrics::peak_5:
    case TurnMetrics::peak_median:
    case TurnMetrics::peak_95:
    case TurnMetrics::peak_max:
    case TurnMetrics::rms:
    case TurnMetrics::deceleration:
    case TurnMetrics::lines_total:
    case TurnMetrics::line_greatest:
    case TurnMetrics::mean_turn_rms:
    case TurnMetrics::mean_turn_peak:
      return "m/s²";
    case TurnMetrics::loss_angle:
    case TurnMetrics::return_angle:
      return "°";
    case TurnMetrics::flight_duration:
      return "s";
    case TurnMetrics::energy_per_turn:
      return "J";
    default:
      return "";
  }
}

void write_sweep_document(const Study& study, const Results& results, const std::filesystem::path& folder,
                          const std::string& verdict) {
  const auto unit_of = [&](const std::string& name) {
    const auto it = std::ranges::find(study.units, name, &std::pair<std::string, std::string>::first);
    return it == study.units.end() ? nlohmann::json() : nlohmann::json(it->second);
  };
  nlohmann::json document;
  document["provenance"] = provenance(study);
  document["provenance"]["scene_file"] = study.scene.lexically_normal().string();
  auto& sweep = document["sweep"];
  for (const char* list : {"axes", "measures", "derived", "variants"}) sweep[list] = nlohmann::json::array();
  sweep["title"] = study.title;
  for (const auto& a : study.axes)
    sweep["axes"].push_back({{"name", a.name},
                             {"key", a.key},
                             {"unit", a.unit},
                             {"scale", a.scale},
                             {"drawn", a.drawn.has_value()}});
  for (const auto& m : study.measures)
    sweep["measures"].push_back(
        {{"name", m.name}, {"column", m.column}, {"reduce", text_of(m.reduce)}, {"unit", unit_of(m.name)}});
  for (const auto& d : study.derived)
    sweep["derived"].push_back({{"name", d.name}, {"unit", unit_of(d.name)}});
  for (const auto& v : study.variants)
    sweep["variants"].push_back(
        {{"name", v.name}, {"title", v.title}, {"scene", v.scene.string()}, {"overrides", v.overrides}});
  for (std::size_t m = 0; m < TurnMetrics::count; ++m)
    if (const auto unit = freeplay::unit_of(static_cast<TurnMetrics::Name>(m)); !unit.empty())
      sweep["units"][std::string(TurnMetrics::names()[m])] = unit;
  document["verdict"] = verdict;
  Database::Transaction alone(results.database());
  write_json(folder / "sweep.json", document);
  alone.commit();
}

namespace {

constexpr std::size_t terminal = 80;  ///< columns
constexpr std::size_t most_lines = 40;

std::string number(double x) { return std::isfinite(x) ? fmt::format("{:.3g}", x) : std::string("-"); }

using Place = std::pair<std::vector<double>, std::string>;  // values of the axes, formulation

/// The lines of a variant's table.
std::vector<Place> places(const Variant& variant, const std::vector<RunRow>& runs) {
  std::vector<Place> seen;
  for (const auto& r : runs)
    if (r.variant == variant.name) seen.emplace_back(r.values, r.formulation);
  std::ranges::stable_sort(seen, {}, [](const auto& x) { return x.first; });
  std::vector<Place> each;  // in the order of the formulations
  for (const auto& place : seen)
    if (std::find_if(each.rbegin(), each.rend(), [&](const auto& x) { return x == place; }) == each.rend())
      each.push_back(place);
  return each;
}

/// Keeps as many lines as fit on a terminal; returns the number of the others.
std::size_t shorten(std::vector<Place>& lines) {
  const auto left_out = lines.size() - std::min(lines.size(), most_lines);
  lines.resize(lines.size() - left_out);
  return left_out;
}
std::string more(std::size_t left_out) {
  return left_out > 0 ? fmt::format("{} more; --export FILE.csv writes all\n", left_out) : "";
}

std::string accelerations(const Study& study, const Variant& variant, const std::vector<RunRow>& runs,
                          const Cells& cells) {
  std::string out, head;
  for (const auto& a : study.axes) head += fmt::format("{:>10}", a.name);
  out += fmt::format("{}  {:<10}{:>17}{:>8}{:>8}{:>8}{:>6}\n", head, "", "peak/ideal (95%)", "95 %", "max",
                     "impacts", "lines");
  auto lines = places(variant, runs);
  const auto left_out = shorten(lines);
  for (const auto& place : lines) {
    const auto& values = place.first;
    const auto& formulation = place.second;
    std::string line;
    for (std::size_t i = 0; i < values.size(); ++i)
      line += fmt::format("{:>10}",
                          fmt::format("{:.4g} {}", values[i] * study.axes[i].scale, study.axes[i].unit));
    const auto of = [&](TurnMetrics::Name m) { return cells.of(variant.name, formulation, values, m); };
    const auto median = of(TurnMetrics::ratio_median);
    out +=
        fmt::format("{}  {:<10}{:>17}{:>8}{:>8}{:>8}{:>6}\n", line, formulation,
                    fmt::format("{} ({}..{})", number(median.mean), number(median.low), number(median.high)),
                    number(of(TurnMetrics::ratio_95).mean), number(of(TurnMetrics::ratio_max).greatest),
                    number(of(TurnMetrics::impacts_per_turn).mean), number(of(TurnMetrics::lines).mean));
  }
  return out + more(left_out);
}

/// A column of a table, and its value for a run.
struct Shown {
  std::string name;
  std::function<double(const RunRow&)> of;
};

/// Contact metrics that are shown if the study has no measures.
constexpr TurnMetrics::Name telling[] = {TurnMetrics::impacts_per_turn,
                                         TurnMetrics::flights_per_turn,
                                         TurnMetrics::flight_share,
                                         TurnMetrics::flight_duration,
                                         TurnMetrics::energy_per_turn,
                                         TurnMetrics::peak_max,
                                         TurnMetrics::rms};

std::vector<Shown> columns_of(const Study& study, const std::vector<RunRow>& runs) {
  std::vector<Shown> all;
  for (std::size_t i = 0; i < study.measures.size(); ++i)
    all.push_back({study.measures[i].name, [i](const RunRow& r) { return r.measures[i]; }});
  for (std::size_t i = 0; i < study.derived.size(); ++i)
    all.push_back(
        {study.derived[i].name, [i, derive = Deriver(study)](const RunRow& r) { return derive(r)[i]; }});
  if (!all.empty() || !study.accelerometer.empty()) return all;
  for (const auto name : telling)
    if (std::ranges::any_of(runs, [&](const RunRow& r) { return std::isfinite(r.metric[name]); }))
      all.push_back(
          {std::string(TurnMetrics::names()[name]), [name](const RunRow& r) { return r.metric[name]; }});
  return all;
}

/// Width of UTF-8 text on a terminal, columns.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}
std::string right(const std::string& text, std::size_t to) {
  return std::string(to > width(text) ? to - width(text) : 0, ' ') + text;
}

/// Columns of a table; the first text of each is its heading.
using Texts = std::vector<std::vector<std::string>>;

std::size_t width(const std::vector<std::string>& column) {
  std::size_t most = 0;
  for (const auto& text : column) most = std::max(most, width(text));
  return most + 2;
}

/// Lays out the table: the `fixed` columns with as many of the others as fit, then further tables
/// with the rest.
std::string laid_out(const Texts& fixed, const Texts& others) {
  std::string out;
  std::size_t begin = 0, room = 0;
  for (const auto& column : fixed) room += width(column);
  while (begin < others.size()) {
    std::size_t end = begin, used = room;
    while (end < others.size() && (end == begin || used + width(others[end]) <= terminal))
      used += width(others[end++]);
    for (std::size_t line = 0; line < others[begin].size(); ++line) {
      for (const auto& column : fixed) out += right(column[line], width(column));
      for (auto c = begin; c < end; ++c) out += right(others[c][line], width(others[c]));
      out += "\n";
    }
    begin = end;
    if (begin < others.size()) out += "\n";
  }
  return out;
}

std::string measures(const Study& study, const Variant& variant, const std::vector<RunRow>& runs,
                     const Cells& cells) {
  const auto shown = columns_of(study, runs);
  if (shown.empty()) return "";
  auto lines = places(variant, runs);
  const auto left_out = shorten(lines);
  Texts fixed, others;
  for (std::size_t i = 0; i < study.axes.size(); ++i) {
    const auto& a = study.axes[i];
    auto& column = fixed.emplace_back(std::vector{a.unit.empty() ? a.name : a.name + " " + a.unit});
    for (const auto& [values, formulation] : lines)
      column.push_back(fmt::format("{:.4g}", values[i] * a.scale));
  }
  auto& formulations = fixed.emplace_back(std::vector<std::string>{""});
  for (const auto& line : lines) formulations.push_back(line.second);
  for (const auto& s : shown) {
    auto& column = others.emplace_back(std::vector{s.name});
    for (const auto& [values, formulation] : lines) {
      std::vector<double> found;
      for (const auto* r : cells.at(variant.name, formulation, values)) found.push_back(s.of(*r));
      const auto of_starts = interval(found);
      const double half = 0.5 * (of_starts.high - of_starts.low);
      column.push_back(of_starts.count == 0 ? "-"
                       : std::isnan(half)   ? fmt::format("{:.5g}", of_starts.mean)
                                            : fmt::format("{:.4g} ±{:.1g}", of_starts.mean, half));
    }
  }
  return laid_out(fixed, others) + more(left_out);
}

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == text.npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::string sweep_table(const Study& study, const std::vector<RunRow>& runs) {
  std::string out;
  const Cells cells(runs);
  for (const auto& variant : study.variants) {
    out += variant.title + "\n";
    if (!study.accelerometer.empty()) out += accelerations(study, variant, runs, cells);
    const auto table = measures(study, variant, runs, cells);
    if (!study.accelerometer.empty() && !table.empty()) out += "\n";
    out += table + "\n";
  }
  return out;
}

SweepValues sweep_values(const Study& study, const std::vector<RunRow>& runs, std::size_t failed) {
  SweepValues v{runs.size() + failed, failed, "", "", {}};
  const auto shown = columns_of(study, runs);
  const auto metric = TurnMetrics::ratio_median;
  v.statistic = shown.empty() ? std::string(TurnMetrics::names()[metric]) : shown.front().name;
  for (std::size_t m = 0; m < TurnMetrics::count; ++m)
    if (v.statistic == TurnMetrics::names()[m]) v.unit = unit_of(static_cast<TurnMetrics::Name>(m));
  const Cells cells(runs);
  for (const auto& variant : study.variants)
    for (const auto& [values, formulation] : places(variant, runs)) {
      CellValue cell{"", formulation};
      for (std::size_t i = 0; i < values.size(); ++i)
        cell.place += fmt::format("{}{} = {:.4g}{}{}", i > 0 ? ", " : "", study.axes[i].name,
                                  values[i] * study.axes[i].scale, study.axes[i].unit.empty() ? "" : " ",
                                  study.axes[i].unit);
      if (study.variants.size() > 1) cell.place += (cell.place.empty() ? "" : ", ") + variant.name;
      Interval of_starts;
      if (shown.empty()) {
        of_starts = cells.of(variant.name, formulation, values, metric);
      } else {
        std::vector<double> found;
        for (const auto* r : cells.at(variant.name, formulation, values))
          found.push_back(shown.front().of(*r));
        of_starts = interval(found);
      }
      if (of_starts.count > 0)
        cell.mean = of_starts.mean, cell.low = of_starts.low, cell.high = of_starts.high;
      v.cells.push_back(std::move(cell));
    }
  return v;
}

void write_export(const Study& study, const Results& results, const std::filesystem::path& file) {
  OutputFile out(file);
  std::string order = "2, 3";  // variant, formulation, axes, start
  for (std::size_t i = 0; i < study.axes.size(); ++i) order += fmt::format(", {}", 5 + i);
  Database::Statement s(results.database(), "SELECT * FROM named ORDER BY " + order + ", 4");
  for (int c = 0; c < s.columns(); ++c) out.write((c > 0 ? "," : "") + csv_text(s.name(c)));
  out.write("\n");
  while (s.step()) {
    for (int c = 0; c < s.columns(); ++c) {
      if (c > 0) out.write(",");
      if (s.absent(c)) continue;
      if (s.is_text(c))
        out.write(csv_text(s.text(c)));
      else
        out.number(s.number(c));
    }
    out.write("\n");
  }
  out.commit();
}

namespace {

/// The runs that the study names and that have a row in this view.
std::vector<std::string> named_in(const Results& results, const char* view) {
  return results.database().texts(
      fmt::format("SELECT run FROM named WHERE run IN (SELECT run FROM {}) ORDER BY run", view));
}

}  // namespace

void write_spectra(const Results& results, const std::filesystem::path& file) {
  OutputFile out(file);
  out.write("run,harmonic,amplitude\n");
  for (const auto& run : named_in(results, "spectra")) {
    int harmonic = 0;
    for (const double amplitude : results.spectrum(run)) {
      out.write(fmt::format("{},{},", run, ++harmonic));
      out.number(amplitude);
      out.write("\n");
    }
  }
  out.commit();
}

void write_traces(const Results& results, const std::filesystem::path& file) {
  OutputFile out(file);
  out.write("run,angle,acceleration,position\n");
  for (const auto& run : named_in(results, "traces"))
    for (const auto& p : results.trace(run)) {
      out.write(run);
      for (const double x : {p.angle, p.acceleration, p.position}) {
        out.write(",");
        if (std::isfinite(x)) out.number(x);
      }
      out.write("\n");
    }
  out.commit();
}

void write_tables(const Study& study, const Results& results, const Conduct& conduct,
                  const std::filesystem::path& folder) {
  std::string axes;
  for (const auto& a : study.axes) axes += "," + a.name;
  OutputFile cells(folder / "cells.csv"), traces(folder / "traces.csv"), spectra(folder / "spectra.csv");
  cells.write(fmt::format("variant,formulation{},statistic,mean,low,high,least,greatest,starts\n", axes));
  traces.write(fmt::format("variant,formulation{},angle,acceleration,position\n", axes));
  spectra.write(fmt::format("variant,formulation{},harmonic,amplitude\n", axes));
  const auto rows = results.runs();
  const Cells every(rows);
  std::set<std::pair<std::string, std::vector<double>>> ideals;
  for (const auto& one : cases(study)) {
    if (one.start != 0) continue;
    std::string head;
    for (double x : one.values) head += fmt::format(",{}", x);
    const auto line = [&](const std::string& formulation) {
      return fmt::format("{},{}{}", one.variant, formulation, head);
    };
    std::vector<double> mean;
    int starts = 0;
    for (const auto* row : every.at(one.variant, one.formulation, one.values)) {
      if (row->start == 0)
        for (const auto& p : results.trace(row->key))
          traces.write(
              fmt::format("{},{},{},{}\n", line(one.formulation), p.angle, p.acceleration, p.position));
      const auto spectrum = results.spectrum(row->key);
      mean.resize(std::max(mean.size(), spectrum.size()));
      for (std::size_t h = 0; h < spectrum.size(); ++h) mean[h] += spectrum[h];
      ++starts;
    }
    for (std::size_t h = 0; h < mean.size(); ++h)
      spectra.write(fmt::format("{},{},{}\n", line(one.formulation), h + 1, mean[h] / starts));
    for (int m = 0; m < TurnMetrics::count; ++m) {
      const auto s = every.of(one.variant, one.formulation, one.values, static_cast<TurnMetrics::Name>(m));
      cells.write(fmt::format("{},{},{},{},{},{},{},{}\n", line(one.formulation), TurnMetrics::names()[m],
                              s.mean, s.low, s.high, s.least, s.greatest, s.count));
    }
    if (!ideals.emplace(one.variant, one.values).second) continue;
    const auto ideal = ideal_metrics(study, scene_of(study, one, conduct), "penalty", conduct);
    for (const auto& p : ideal.last_turn)
      traces.write(fmt::format("{},{},{},{}\n", line("ideal"), p.angle, p.acceleration, p.position));
  }
  for (auto* file : {&cells, &traces, &spectra}) file->commit();
}

}  // namespace freeplay
