#include "verification/experiment/flores2011.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace freeplay::verification {
namespace {

std::string show(const Interval& i) { return verification::show(i.mean, i.low, i.high); }

std::string verdict(const Finding& f) {
  return !f.assessed ? "not evaluated" : f.holds ? "holds" : "**fails**";
}

std::vector<Finding> findings(const Evidence& e, const Variant& v, const std::string& formulation,
                              TurnMetrics::Name statistic = TurnMetrics::ratio_95) {
  return flores2011(e.study, e.results, e.runs, v.name, formulation, statistic,
                    fitted_findings(v.name, e.calibration));
}

bool in_full(const Evidence& e, const Variant& v) {
  return v.formulations.size() >= 2 && v.starts >= e.study.starts.count;
}

/// The verdict on a statement of the paper, of all its claims: it holds if all of them hold.
std::string verdict(const std::vector<Finding>& list, std::string_view id) {
  bool assessed = false, holds = true, fitted = false;
  for (const auto& f : list) {
    if (f.id != id) continue;
    fitted = fitted || f.fitted;
    assessed = assessed || f.assessed;
    holds = holds && (f.holds || !f.assessed);
  }
  return fitted ? "fitted" : !assessed ? "–" : holds ? "holds" : "**fails**";
}

constexpr std::pair<const char*, const char*> statements[] = {
    {"X1", "ideal joint: acceleration as computed"},
    {"X2", "0.25 mm: position as with the ideal joint"},
    {"X3", "0.25 mm: one loss of contact per revolution, for 20°"},
    {"X4", "0.25 mm: impacts for 60° after the return of contact"},
    {"X5", "0.25 mm: weak impacts in a second zone, contact elsewhere"},
    {"X6", "0.25 mm: maximum 4 times the ideal one"},
    {"X7", "0.10 mm: maximum 3.5 times the ideal one"},
    {"X8", "1.00 mm: maximum 20 times the ideal one"},
    {"X9", "maximum grows with clearance and speed"},
    {"X10", "number of impacts grows with clearance and speed"},
    {"X11", "dominant lines grow with clearance and speed"},
    {"X12", "slider decelerates without contact"},
    {"X13", "100 rpm: overall motion as with the ideal joint"}};

/// The values by which variants are compared; " ✗" marks a failed claim.
struct Influence {
  std::string peaks[3];    ///< X7, X6, X8
  std::string flights[2];  ///< X3: number and length
  std::string after;       ///< X4
  std::string steps[3];    ///< X9 to X11: steps of the matrix with growth
  std::string slows;       ///< X12
};

Influence influence(const Evidence& e, const Variant& v, const std::string& formulation) {
  Influence out;
  const char* ids[] = {"X7", "X6", "X8"};
  int grows[3] = {0, 0, 0}, steps[3] = {0, 0, 0}, x3 = 0;
  for (const auto& f : findings(e, v, formulation)) {
    const auto mark = f.assessed && !f.holds ? " ✗" : f.fitted ? " fitted" : "";
    for (int k = 0; k < 3; ++k) {
      if (f.id == ids[k]) out.peaks[k] = f.measured + mark;
      if (f.id == fmt::format("X{}", 9 + k) && f.assessed) {
        grows[k] += std::stoi(f.measured);
        steps[k] += std::stoi(f.measured.substr(f.measured.find("of") + 2));
      }
    }
    if (f.id == "X3" && x3 < 2) out.flights[x3++] = f.measured + mark;
    if (f.id == "X4") out.after = f.measured + mark;
    if (f.id == "X12") out.slows = f.assessed ? (f.holds ? "slows" : "no ✗") : "–";
  }
  for (int k = 0; k < 3; ++k)
    out.steps[k] = fmt::format("{} of {}{}", grows[k], steps[k], grows[k] < steps[k] ? " ✗" : "");
  return out;
}

/// A quantity, an assumption that can make it fail, and the variant that changes this assumption;
/// null: none does.
struct Suspect {
  const char *quantity, *assumption, *variant;
  std::string (*value)(const Influence&);
};
constexpr Suspect suspects[] = {
    {"X3 flights per revolution: 1", "friction of the guide", "guide",
     [](const Influence& i) { return i.flights[0]; }},
    {"X3 flights per revolution: 1", "clearance of the other joints", "bearings",
     [](const Influence& i) { return i.flights[0]; }},
    {"X3 length of the flight: 20°", "friction of the guide", "guide",
     [](const Influence& i) { return i.flights[1]; }},
    {"X4 impacts after the return: 60°", "compliance of crank and rod, play of the guide", nullptr,
     [](const Influence& i) { return i.after; }},
    {"X6 maximum: 4", "finite drive", "drive", [](const Influence& i) { return i.peaks[1]; }},
    {"X6 maximum: 4", "bandwidth of the accelerometer", "paper",
     [](const Influence& i) { return i.peaks[1]; }},
    {"X6 maximum: 4", "friction of the guide", "guide", [](const Influence& i) { return i.peaks[1]; }},
    {"X8 maximum: 20", "finite drive", "drive", [](const Influence& i) { return i.peaks[2]; }},
    {"X10 steps: all", "centre of mass of the rod", "rod", [](const Influence& i) { return i.steps[1]; }},
    {"X10 steps: all", "finite drive", "drive", [](const Influence& i) { return i.steps[1]; }},
    {"X10 steps: all", "compliance of crank and rod", nullptr, [](const Influence& i) { return i.steps[1]; }},
    {"X11 steps: all", "bandwidth of the accelerometer", "paper",
     [](const Influence& i) { return i.steps[2]; }},
    {"X11 steps: all", "resonance of the accelerometer", nullptr,
     [](const Influence& i) { return i.steps[2]; }},
    {"X12 deceleration", "friction of the guide", "guide", [](const Influence& i) { return i.slows; }}};

}  // namespace

std::string number(double x) {
  if (!std::isfinite(x)) return "–";
  return std::abs(x) >= 1000 && std::abs(x) < 1e6 ? fmt::format("{:.0f}", x) : fmt::format("{:.3g}", x);
}
std::string show(double value, double low, double high) {
  return fmt::format("{} ({}..{})", number(value), number(low), number(high));
}

std::string summary_table(const Evidence& e) {
  Table table("id,statement");
  std::string counts;
  std::vector<std::vector<Finding>> columns;
  for (const auto& v : e.study.variants) {
    if (!in_full(e, v)) continue;
    const auto first = columns.size();
    for (const auto& formulation : v.formulations) {
      columns.push_back(findings(e, v, formulation));
      table.column(fmt::format("{} {}", v.name, formulation));
    }
    std::vector<std::string> hold, fail, differ;
    for (const auto& [id, text] : statements) {
      std::size_t holds = 0, fails = 0;
      for (auto k = first; k < columns.size(); ++k) {
        const auto word = verdict(columns[k], id);
        holds += word == "holds", fails += word == "**fails**";
      }
      if (holds == columns.size() - first) hold.emplace_back(id);
      if (fails == columns.size() - first) fail.emplace_back(id);
      if (holds > 0 && fails > 0) differ.emplace_back(id);
    }
    const auto list = [](const auto& ids) {
      return ids.empty() ? "none" : fmt::format("{}", fmt::join(ids, ", "));
    };
    counts += fmt::format("- {}, {}: {} hold in both formulations ({}); {} fail in both ({}); differ: {}.\n",
                          v.name, v.title, hold.size(), list(hold), fail.size(), list(fail), list(differ));
  }
  for (const auto& [id, text] : statements) {
    std::vector<Table::Cell> row{id, text};
    for (const auto& column : columns) row.emplace_back(verdict(column, id));
    table.row(std::move(row));
  }
  return table.markdown() + "\n" + counts;
}

std::string failures_table(const Evidence& e) {
  const auto& base = e.study.variants.front();
  std::vector<Influence> here;
  Table table("quantity: measured");
  for (const auto& formulation : base.formulations) {
    here.push_back(influence(e, base, formulation));
    table.column(fmt::format("{} {}", base.name, formulation));
  }
  table.column("assumption");
  table.column("its scene");
  for (const auto& formulation : base.formulations) table.column("there " + formulation);
  table.column("shown");
  const auto failed = [](const std::string& value) { return value.ends_with("✗"); };
  for (const auto& s : suspects) {
    const auto v = std::ranges::find_if(
        e.study.variants, [&](const Variant& one) { return s.variant && one.name == s.variant; });
    std::vector<Table::Cell> row{s.quantity}, there;
    std::vector<std::string> mended;
    std::size_t fails = 0;
    for (std::size_t k = 0; k < here.size(); ++k) {
      const auto& formulation = base.formulations[k];
      const auto value = s.value(here[k]);
      row.emplace_back(value);
      fails += failed(value);
      std::string changed = "–";
      if (v != e.study.variants.end() &&
          std::ranges::find(v->formulations, formulation) != v->formulations.end()) {
        changed = s.value(influence(e, *v, formulation));
        if (failed(value) && !failed(changed)) mended.push_back(formulation);
      }
      there.emplace_back(changed);
    }
    const bool tested = v != e.study.variants.end();
    const auto shown = !tested                 ? "no run"
                       : mended.empty()        ? "no"
                       : mended.size() < fails ? fmt::format("by {} only", fmt::join(mended, ", "))
                                               : "yes";
    row.insert(row.end(), {s.assumption, tested ? s.variant : "–"});
    row.insert(row.end(), there.begin(), there.end());
    row.emplace_back(shown);
    table.row(std::move(row));
  }
  return table.markdown();
}

std::string claims_table(const Evidence& e, const Variant& v) {
  Table table("id,claim"), fitted("id,claim");
  std::vector<std::vector<Finding>> columns;
  for (const auto& formulation : v.formulations) {
    columns.push_back(findings(e, v, formulation));
    table.column(formulation);
    table.column("verdict");
    fitted.column(formulation);
  }
  table.column("bound");
  for (std::size_t i = 0; i < columns[0].size(); ++i) {
    const auto& f = columns[0][i];
    std::vector<Table::Cell> row{f.id, f.claim};
    for (const auto& column : columns) {
      row.emplace_back(column[i].measured);
      if (!f.fitted) row.emplace_back(verdict(column[i]));
    }
    if (!f.fitted) row.emplace_back(f.bound);
    (f.fitted ? fitted : table).row(std::move(row));
  }
  if (fitted.rows().empty()) return table.markdown();
  return fmt::format(
      "{}\n**Fitted**, therefore without a verdict: {} was fitted to these; the other formulation uses its "
      "values.\n\n{}",
      table.markdown(), e.calibration->calibration->formulation, fitted.markdown());
}

std::string readings_table(const Evidence& e) {
  const std::pair<const char*, TurnMetrics::Name> readings[] = {
      {"median of turns", TurnMetrics::ratio_median},
      {"95 % of turns below", TurnMetrics::ratio_95},
      {"greatest of the run", TurnMetrics::ratio_max}};
  Table table("scene,formulation,\"maximum\" is,X7: 3.5,X6: 4,X8: 20,X9 steps");
  for (const auto& v : e.study.variants) {
    if (!in_full(e, v)) continue;
    for (const auto& formulation : v.formulations)
      for (const auto& [name, statistic] : readings) {
        std::string peaks[3];
        int grows = 0;
        for (const auto& f : findings(e, v, formulation, statistic)) {
          const auto text = f.measured + (f.assessed && !f.holds ? " ✗" : f.fitted ? " fitted" : "");
          if (f.id == "X7") peaks[0] = text;
          if (f.id == "X6") peaks[1] = text;
          if (f.id == "X8") peaks[2] = text;
          if (f.id == "X9") grows += std::stoi(f.measured);
        }
        table.row(v.name, formulation, name, peaks[0], peaks[1], peaks[2], fmt::format("{} of 24", grows));
      }
  }
  return table.markdown();
}

std::string influences_table(const Evidence& e) {
  std::string out =
      "| scene | formulation | X7, 0.10 mm | X6, 0.25 mm | X8, 1.00 mm | X3 flights per revolution | "
      "length | X9 steps | X10 steps | X11 steps | X12 | runs, with warnings, failed |\n| --- | --- | --- "
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n| *measured* | | 3.5 | 4 | 20 | 1 | 20° | "
      "24 of 24 | 24 of 24 | 48 of 48 | slows | |\n";
  const double clearances[] = {0.10e-3, 0.25e-3, 1.00e-3};
  const char* ids[] = {"X7", "X6", "X8"};
  std::string sentences;
  const auto failures = e.results.failures();
  for (const auto& v : e.study.variants) {
    std::string moved;
    for (const auto& formulation : v.formulations) {
      const auto i = influence(e, v, formulation);
      int doubtful = 0, runs = 0;
      for (const auto& r : e.runs)
        if (r.variant == v.name && r.formulation == formulation) ++runs, doubtful += !r.doubt.empty();
      const auto failed = std::ranges::count_if(
          failures, [&](const auto& f) { return f[0] == v.name && f[1] == formulation; });
      out += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {}, {}, {} |\n", v.name,
                         formulation, i.peaks[0], i.peaks[1], i.peaks[2], i.flights[0], i.flights[1],
                         i.steps[0], i.steps[1], i.steps[2], i.slows, runs + failed, doubtful, failed);
      for (int k = 0; k < 3; ++k) {
        const auto at = [&](const std::string& variant) {
          return cell(e.runs, variant, formulation, {clearances[k], 200}, TurnMetrics::ratio_95);
        };
        const auto here = at(v.name), first = at(e.study.variants.front().name);
        if (here.count > 1 && first.count > 1 && !here.overlaps(first))
          moved += fmt::format("{}{} by {:.2f} ({})", moved.empty() ? "" : ", ", ids[k],
                               here.mean / first.mean, formulation);
      }
    }
    if (&v != &e.study.variants.front())
      sentences += fmt::format(
          "- {}: {}.\n", v.name,
          moved.empty() ? "no peak changes beyond its interval"
                        : "multiplies " + moved + "; the other peaks do not change beyond their intervals");
  }
  return out + "\nAgainst " + e.study.variants.front().name +
         ", where the 95 % intervals do not overlap:\n\n" + sentences;
}

std::string matrix_table(const Evidence& e, const Variant& v) {
  Table peaks({"clearance", "speed", "formulation", "median peak / ideal", "5 % of turns below", "95 %",
               "greatest", "loss of contact", "return", "flight, ms"});
  Table counts({"clearance", "speed", "formulation", "impacts a turn", "flights a turn", "lines",
                "their sum, m/s²", "energy lost, mJ a turn", "slowing in flight, m/s²"});
  using T = TurnMetrics;
  for (double c : e.study.axes[0].values)
    for (double n : e.study.axes[1].values)
      for (const auto& formulation : v.formulations) {
        const auto of = [&](T::Name m) { return cell(e.runs, v.name, formulation, {c, n}, m); };
        const auto scaled = [&](T::Name m, double factor) {
          const auto s = of(m);
          return verification::show(factor * s.mean, factor * s.low, factor * s.high);
        };
        const auto five = of(T::peak_5), median = of(T::peak_median), ratio = of(T::ratio_median);
        const auto clearance = fmt::format("{:.2f} mm", 1e3 * c), speed = fmt::format("{:.0f} rpm", n);
        peaks.row(clearance, speed, formulation, show(ratio), number(five.mean * ratio.mean / median.mean),
                  show(of(T::ratio_95)), number(of(T::ratio_max).greatest),
                  fmt::format("{:.0f}°", of(T::loss_angle).mean),
                  fmt::format("{:.0f}°", of(T::return_angle).mean), scaled(T::flight_duration, 1e3));
        counts.row(clearance, speed, formulation, show(of(T::impacts_per_turn)),
                   show(of(T::flights_per_turn)), show(of(T::lines)), show(of(T::lines_total)),
                   scaled(T::energy_per_turn, 1e3),
                   std::abs(of(T::deceleration).mean) < 1e-3 ? "0" : show(of(T::deceleration)));
      }
  return peaks.markdown() + "\n" + counts.markdown();
}

}  // namespace freeplay::verification
