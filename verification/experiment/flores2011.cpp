#include "verification/experiment/flores2011.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "verification/references/slider_crank.hpp"

namespace freeplay::verification {
namespace {

constexpr double r = 0.05, l = 0.3;  // m, crank and rod

double degrees(double x) {
  const double d = std::fmod(x, 360);
  return d < 0 ? d + 360 : d;
}

struct Assessment {
  const Study& study;
  const Results& results;
  const std::vector<RunRow>& runs;
  const std::string &variant, &formulation;
  TurnMetrics::Name statistic;
  std::vector<Finding> list = {};

  Interval at(double clearance, double speed, TurnMetrics::Name m) const {
    return cell(runs, variant, formulation, {clearance, speed}, m);
  }
  void add(const char* id, std::string claim, std::string measured, std::string bound, bool holds,
           bool assessed = true) {
    list.push_back(
        {id, std::move(claim), std::move(measured), std::move(bound), assessed && holds, assessed});
  }
  template <class Visit>
  void each(double clearance, double speed, const Visit& visit) const {
    for (const auto& run : runs)
      if (run.variant == variant && run.formulation == formulation &&
          run.values == std::vector<double>{clearance, speed})
        visit(run);
  }

  double revolutions() const {
    const auto it = std::ranges::find(study.variants, variant, &Variant::name);
    return it == study.variants.end() ? study.length.revolutions : it->revolutions;
  }

  /// Greatest deviation of the slider from the ideal mechanism, in the traces of start 0 (m).
  double displacement(double clearance, double speed) const {
    double worst = std::nan("");
    each(clearance, speed, [&](const RunRow& run) {
      if (run.start != 0) return;
      for (const auto& p : results.trace(run.key)) {
        const auto ideal = reference::slider_crank(r, l, p.angle * std::numbers::pi / 180, 1.0);
        if (std::isfinite(p.position)) worst = std::fmax(worst, std::abs(p.position - ideal.x));
      }
    });
    return worst;
  }

  void gross_motion() {
    const double x2 = displacement(0.25e-3, 200);
    add("X2",
        "0.25 mm, 200 rpm: the slider's position differs from the ideal by at most the width of a drawn "
        "line",
        fmt::format("{:.3g} mm", 1e3 * x2), "≤ 1 mm of 100 mm stroke", x2 <= 1e-3, std::isfinite(x2));
    const double speed = study.axes[1].values.front();
    double squares = 0;
    constexpr int points = 720;
    for (int i = 0; i < points; ++i)
      squares += std::pow(
          reference::slider_crank(r, l, 2 * std::numbers::pi * i / points, speed * 2 * std::numbers::pi / 60)
              .acceleration,
          2);
    const auto rms = at(0.25e-3, speed, TurnMetrics::rms);
    const double ratio = rms.mean / std::sqrt(squares / points);
    add("X13",
        fmt::format("0.25 mm, {:.0f} rpm: overall motion as the ideal (ratio of RMS accelerations)", speed),
        fmt::format("{:.3g}", ratio), "≤ √2: half of the signal's power", ratio <= std::numbers::sqrt2,
        rms.count > 0);
  }

  /// X3 to X5, at 0.25 mm and 200 rpm: flights of 5° or more, and the contacts after them. The
  /// paper's datum of the crank angle is unknown: its 43° are set to the model's angle of
  /// separation, the mean over the flights of that half revolution with the greatest total flight.
  void flights() {
    double turns = 0;
    std::vector<Flight> all;
    each(0.25e-3, 200, [&](const RunRow& run) {
      turns += revolutions();
      for (const auto& f : results.flights(run.key))
        if (f.angle >= 5) all.push_back(f);
    });
    double from = 0, most = -1;
    for (int a = 0; a < 360; ++a) {
      double sum = 0;
      for (const auto& f : all) sum += degrees(f.loss - a) < 180 ? f.angle : 0;
      if (sum > most) most = sum, from = a;
    }
    std::vector<double> losses;
    for (const auto& f : all)
      if (degrees(f.loss - from) < 180) losses.push_back(f.loss);
    const double datum = mean_angle(losses), main = static_cast<double>(losses.size());
    const double per_turn = main / turns, length = main > 0 ? most / main : std::nan("");
    add("X3",
        "0.25 mm, 200 rpm: contact is lost once per revolution in one half of it (flights of 5° or "
        "more)",
        fmt::format("{:.2f} a turn", per_turn), "0.8 to 1.2", per_turn >= 0.8 && per_turn <= 1.2, turns > 0);
    add("X3", "this flight lasts about 20° of crank angle", fmt::format("{:.1f}°", length),
        "13° to 30° (a factor of 1.5)", length >= 20 / 1.5 && length <= 30, main > 0);
    add("X3", "angle of the loss of contact after top dead centre (the datum of the paper's 43° is unknown)",
        fmt::format("{:.0f}°", datum), "–", false, false);

    // In the paper's datum: zones 43° to 123°, and 230° to 330°.
    const auto first = [](double a) { return a >= 40 && a <= 130; };
    const auto second = [](double a) { return a >= 225 && a <= 335; };
    const auto shifted = [&](double angle) { return degrees(angle - datum + 43); };
    std::vector<double> tails, ratios;
    double flying = 0, degrees_outside = 0;
    each(0.25e-3, 200, [&](const RunRow& run) {
      std::vector<double> zones[2];
      for (const auto& i : results.impacts(run.key)) {
        const double angle = shifted(i.angle);
        if (first(angle)) zones[0].push_back(i.approach);
        if (second(angle)) zones[1].push_back(i.approach);
        if (angle >= 43 && angle <= 180) tails.push_back(angle);
      }
      for (auto& z : zones) std::ranges::sort(z);
      ratios.push_back(quantile(zones[1], 0.5) / quantile(zones[0], 0.5));
      for (const auto& f : results.flights(run.key))
        for (double a = 0.5; a < f.angle; ++a) {
          const double angle = shifted(f.loss + a);
          flying += !first(angle) && !second(angle);
        }
      degrees_outside += revolutions() * (360 - 90 - 110);
    });
    std::ranges::sort(tails);
    const double last = quantile(tails, 0.95) - 43 - length;
    add("X4", "impacts follow for about 60° after the return of contact (95 % of them)",
        fmt::format("{:.0f}°", last), "40° to 90°", last >= 40 && last <= 90, !tails.empty());
    const auto ratio = interval(ratios);
    add("X5", "impacts between 230° and 330° are weaker (median approach speed relative to the first zone)",
        fmt::format("{:.2f} ({:.2f}..{:.2f})", ratio.mean, ratio.low, ratio.high),
        "< 1, including its interval", ratio.high<1, ratio.count> 1);
    const double share = flying / degrees_outside;
    add("X5", "contact is sustained outside both zones (share of that angle in flights of 2° or more)",
        fmt::format("{:.3f}", share), "≤ 0.1", share <= 0.1, turns > 0);
  }

  void peak(const char* id, double clearance, double expected, double factor, const char* words) {
    const auto s = at(clearance, 200, statistic);
    add(id, fmt::format("{:.2f} mm, 200 rpm: greatest acceleration {} the ideal's", 1e3 * clearance, words),
        s.count > 0 ? fmt::format("{:.3g} ({:.3g}..{:.3g})", s.mean, s.low, s.high) : "–",
        fmt::format("{:.3g} within a factor of {}", expected, factor),
        s.mean <= expected * factor && s.mean >= expected / factor, s.count > 0);
  }

  /// Number of the steps along both axes with an increase.
  void grows(const char* id, const char* what, TurnMetrics::Name m, bool absolute) {
    int steps[2] = {0, 0}, growing[2] = {0, 0};
    const auto &c = study.axes[0].values, &n = study.axes[1].values;
    const auto value = [&](double clearance, double speed) {
      const double scale =
          absolute ? std::pow(speed, 2) : 1;  // of a ratio to the ideal: m/s² up to a constant
      return at(clearance, speed, m).mean * scale;
    };
    for (std::size_t i = 0; i < c.size(); ++i)
      for (std::size_t j = 0; j < n.size(); ++j) {
        if (i + 1 < c.size()) ++steps[0], growing[0] += value(c[i + 1], n[j]) > value(c[i], n[j]);
        if (j + 1 < n.size()) ++steps[1], growing[1] += value(c[i], n[j + 1]) > value(c[i], n[j]);
      }
    for (int axis : {0, 1})
      add(id, fmt::format("{} grows with {}", what, axis ? "speed" : "clearance"),
          fmt::format("{} of {} steps", growing[axis], steps[axis]), "all", growing[axis] == steps[axis],
          at(c[0], n[0], m).count > 0);
  }

  /// The same band contains fewer harmonics of a faster crank: the span of the dominant ones is
  /// compared, not their number.
  void lines_in_hertz() {
    const auto& n = study.axes[1].values;
    int steps = 0, growing = 0;
    for (double c : study.axes[0].values)
      for (std::size_t j = 0; j + 1 < n.size(); ++j, ++steps)
        growing +=
            at(c, n[j + 1], TurnMetrics::lines).mean * n[j + 1] > at(c, n[j], TurnMetrics::lines).mean * n[j];
    add("X11", "the number of dominant lines times their spacing (Hz) grows with speed",
        fmt::format("{} of {} steps", growing, steps), "another definition of \"number\"", false, false);
  }

  void friction_in_flight() {
    for (double c : {0.50e-3, 1.00e-3}) {
      const auto d = at(c, 200, TurnMetrics::deceleration);
      add("X12", fmt::format("{:.2f} mm: the slider decelerates without contact", 1e3 * c),
          fmt::format("{:.3g} m/s²", std::abs(d.mean) < 1e-3 ? 0 : d.mean), "> 0.1 m/s²", d.mean > 0.1,
          d.count > 0);
    }
  }
};

}  // namespace

std::vector<Finding> flores2011(const Study& study, const Results& results, const std::vector<RunRow>& runs,
                                const std::string& variant, const std::string& formulation,
                                TurnMetrics::Name statistic, const std::set<std::string>& fitted) {
  Assessment j{study, results, runs, variant, formulation, statistic};
  const double speed = 200 * 2 * std::numbers::pi / 60, closed = r * speed * speed * (1 + r / l);
  double ideal = std::nan("");
  j.each(0.25e-3, 200, [&](const RunRow& run) {
    ideal = run.metric[TurnMetrics::peak_median] / run.metric[TurnMetrics::ratio_median];
  });
  j.add("X1", "ideal joint, 200 rpm: the greatest computed acceleration equals the closed form",
        fmt::format("{:.4g} m/s²", ideal), fmt::format("{:.4g} within 2 %", closed),
        std::abs(ideal / closed - 1) <= 0.02, std::isfinite(ideal));
  j.gross_motion();
  j.flights();
  j.peak("X6", 0.25e-3, 4.0, 1.5, "300 % larger than");
  j.peak("X7", 0.10e-3, 3.5, 2.0, "3.5 times");
  j.peak("X8", 1.00e-3, 20.0, 1.5, "20 times");
  j.grows("X9", "the greatest acceleration", statistic, true);
  j.grows("X10", "the number of impacts", TurnMetrics::impacts_per_turn, false);
  j.grows("X11", "the number of dominant lines", TurnMetrics::lines, false);
  j.grows("X11", "the sum of dominant lines (m/s²)", TurnMetrics::lines_total, false);
  j.lines_in_hertz();
  j.friction_in_flight();
  std::ranges::stable_sort(j.list, {}, [](const Finding& f) { return std::stoi(f.id.substr(1)); });
  for (auto& f : j.list)
    if (fitted.contains(f.id)) f.fitted = true, f.assessed = f.holds = false;
  return j.list;
}

std::set<std::string> fitted_findings(const std::string& variant, const Study* calibration) {
  std::set<std::string> names;
  if (variant == "calibrated" && calibration)
    for (const auto& t : calibration->calibration->targets) names.insert(t.name);
  return names;
}

Cells formulations_agree(const Study& study, const std::vector<RunRow>& runs, const std::string& variant) {
  Cells cells;
  for (double c : study.axes[0].values)
    for (double n : study.axes[1].values) {
      const auto a = cell(runs, variant, "penalty", {c, n}, TurnMetrics::ratio_median);
      const auto b = cell(runs, variant, "nonsmooth", {c, n}, TurnMetrics::ratio_median);
      if (a.count == 0 || b.count == 0) continue;
      const auto inside = [](const Interval& x, const Interval& of) {
        return of.low <= x.mean && x.mean <= of.high;
      };
      ++cells.all;
      cells.overlapping += a.overlaps(b);
      cells.within += inside(a, b) && inside(b, a);
      if (!inside(a, b) && !inside(b, a))
        cells.apart.push_back(
            fmt::format("{:.2f} mm, {:.0f} rpm: penalty {:.3g} ({:.3g}..{:.3g}), nonsmooth {:.3g} "
                        "({:.3g}..{:.3g})",
                        1e3 * c, n, a.mean, a.low, a.high, b.mean, b.low, b.high));
    }
  return cells;
}

}  // namespace freeplay::verification
