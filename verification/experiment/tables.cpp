#include "verification/experiment/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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
  return v.formulations.size() >= 2 && v.starts >= e.study.starts;
}

}  // namespace

std::string number(double x) {
  if (!std::isfinite(x)) return "–";
  return std::abs(x) >= 1000 && std::abs(x) < 1e6 ? fmt::format("{:.0f}", x) : fmt::format("{:.3g}", x);
}
std::string show(double value, double low, double high) {
  return fmt::format("{} ({}..{})", number(value), number(low), number(high));
}

std::string claims_table(const Evidence& e, const Variant& v) {
  std::string out = "| id | claim |", rule = "| --- | --- |";
  std::vector<std::vector<Finding>> columns;
  for (const auto& formulation : v.formulations) {
    columns.push_back(findings(e, v, formulation));
    out += fmt::format(" {} | verdict |", formulation);
    rule += " --- | --- |";
  }
  out += " bound |\n" + rule + " --- |\n";
  std::string fitted;
  for (std::size_t i = 0; i < columns[0].size(); ++i) {
    const auto& f = columns[0][i];
    auto& to = f.fitted ? fitted : out;
    to += fmt::format("| {} | {} |", f.id, f.claim);
    for (const auto& column : columns)
      to += f.fitted ? fmt::format(" {} |", column[i].measured)
                     : fmt::format(" {} | {} |", column[i].measured, verdict(column[i]));
    to += f.fitted ? "\n" : fmt::format(" {} |\n", f.bound);
  }
  if (!fitted.empty())
    out += fmt::format(
        "\n**Fitted**, therefore without a verdict: {} was fitted to these; the other formulation uses its "
        "values.\n\n| id | claim | {} |\n| --- | --- |{}\n{}",
        e.calibration->calibration->formulation, fmt::join(v.formulations, " | "),
        v.formulations.size() == 2 ? " --- | --- |" : " --- |", fitted);
  return out;
}

std::string readings_table(const Evidence& e) {
  const std::pair<const char*, TurnMetrics::Name> readings[] = {
      {"median of turns", TurnMetrics::ratio_median},
      {"95 % of turns below", TurnMetrics::ratio_95},
      {"greatest of the run", TurnMetrics::ratio_max}};
  std::string out =
      "| scene | formulation | \"maximum\" is | X7: 3.5 | X6: 4 | X8: 20 | X9 steps |\n"
      "| --- | --- | --- | --- | --- | --- | --- |\n";
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
        out += fmt::format("| {} | {} | {} | {} | {} | {} | {} of 24 |\n", v.name, formulation, name,
                           peaks[0], peaks[1], peaks[2], grows);
      }
  }
  return out;
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
      std::string peaks[3], flights[2], slows;
      int grows[3] = {0, 0, 0}, steps[3] = {0, 0, 0}, x3 = 0, doubtful = 0, runs = 0;
      for (const auto& f : findings(e, v, formulation)) {
        const auto mark = f.assessed && !f.holds ? " ✗" : f.fitted ? " fitted" : "";
        for (int k = 0; k < 3; ++k) {
          if (f.id == ids[k]) peaks[k] = f.measured + mark;
          if (f.id == fmt::format("X{}", 9 + k) && f.assessed) {
            grows[k] += std::stoi(f.measured);
            steps[k] += std::stoi(f.measured.substr(f.measured.find("of") + 2));
          }
        }
        if (f.id == "X3" && x3 < 2) flights[x3++] = f.measured + mark;
        if (f.id == "X12") slows = f.assessed ? (f.holds ? "slows" : "no ✗") : "–";
      }
      for (const auto& r : e.runs)
        if (r.variant == v.name && r.formulation == formulation) ++runs, doubtful += !r.doubt.empty();
      const auto failed = std::ranges::count_if(
          failures, [&](const auto& f) { return f[0] == v.name && f[1] == formulation; });
      out += fmt::format(
          "| {} | {} | {} | {} | {} | {} | {} | {} of {} | {} of {} | {} of {} | {} | {}, {}, {} |\n", v.name,
          formulation, peaks[0], peaks[1], peaks[2], flights[0], flights[1], grows[0], steps[0], grows[1],
          steps[1], grows[2], steps[2], slows, runs + failed, doubtful, failed);
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
  std::string peaks =
      "| clearance | speed | formulation | median peak / ideal | 5 % of turns below | 95 % | greatest | "
      "loss of contact | return | flight, ms |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- "
      "|\n";
  std::string counts =
      "| clearance | speed | formulation | impacts a turn | flights a turn | lines | their sum, m/s² | "
      "energy lost, mJ a turn | slowing in flight, m/s² |\n| --- | --- | --- | --- | --- | --- | --- | --- "
      "| --- |\n";
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
        const auto head = fmt::format("| {:.2f} mm | {:.0f} rpm | {} |", 1e3 * c, n, formulation);
        peaks += fmt::format("{} {} | {} | {} | {} | {:.0f}° | {:.0f}° | {} |\n", head, show(ratio),
                             number(five.mean * ratio.mean / median.mean), show(of(T::ratio_95)),
                             number(of(T::ratio_max).greatest), of(T::loss_angle).mean,
                             of(T::return_angle).mean, scaled(T::flight_duration, 1e3));
        counts += fmt::format("{} {} | {} | {} | {} | {} | {} |\n", head, show(of(T::impacts_per_turn)),
                              show(of(T::flights_per_turn)), show(of(T::lines)), show(of(T::lines_total)),
                              scaled(T::energy_per_turn, 1e3),
                              std::abs(of(T::deceleration).mean) < 1e-3 ? "0" : show(of(T::deceleration)));
      }
  return peaks + "\n" + counts;
}

}  // namespace freeplay::verification
