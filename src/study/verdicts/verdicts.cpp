#include "study/verdicts/verdicts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace freeplay {
namespace {

using Outcome = SignalAgreement::Outcome;

constexpr double significant = 3;  // standard errors
constexpr double notable = 0.01;   // relative difference
// CPU times measured once scatter by about this share on a busy machine.
constexpr double alike = 0.2;

// Differences below this share of the value are rounding.
constexpr double rounding = 1e-10;
// Energies below this share of the energy turned over do not decide.
constexpr double negligible_share = 1e-3;

std::string percent(double x) {
  return std::abs(x) >= 0.995 ? fmt::format("{:.0f} %", 100 * x) : fmt::format("{:.2g} %", 100 * x);
}

/// "within 3 %", or "to rounding".
std::string within(double relative, const std::string& size) {
  return relative < rounding ? "to rounding" : "within " + size;
}
std::string within(double relative) { return within(relative, percent(relative)); }

/// A value with an SI prefix for small times: 5.72 ms.
std::string seconds(double t) {
  const double size = std::abs(t);
  if (size == 0 || size >= 1) return fmt::format("{:.4g} s", t);
  if (size >= 1e-3) return fmt::format("{:.4g} ms", 1e3 * t);
  return fmt::format("{:.3g} us", 1e6 * t);
}

std::string plural(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// "a", "a and b", "a, b and c"; at most `most` of them.
std::string listed(const std::vector<std::string>& names, std::size_t most = 4, const char* last = "and") {
  if (names.size() > most)
    return fmt::format("{} {} {} more",
                       fmt::join(names.begin(), names.begin() + static_cast<long>(most), ", "), last,
                       names.size() - most);
  if (names.size() < 2) return names.empty() ? "" : names.front();
  return fmt::format("{} {} {}", fmt::join(names.begin(), names.end() - 1, ", "), last, names.back());
}

std::string events_in_words(const ComparisonValues& v) {
  const auto& e = v.events;
  if (!e.contacts) {
    std::string text = "No contacts were compared, since the scene has none";
    if (std::isfinite(v.final_length))
      text += fmt::format("; the final positions differ by at most {:.2g} m and {:.2g} rad", v.final_length,
                          v.final_angle);
    return text;
  }
  if (e.pairs == 0)
    return e.to_the_end ? "Neither run has a contact event"
                        : "No single contact event of the two runs agrees";
  auto text = fmt::format(
      "Single contact events agree {} ({}: times {}, approach speeds {}",
      e.to_the_end ? "to the end of the run" : "up to t = " + seconds(e.horizon), plural(e.pairs, "pair"),
      within(e.horizon > 0 ? e.time / e.horizon : e.time, seconds(e.time)), within(e.speed));
  if (std::isfinite(e.impulse)) text += ", impulses " + within(e.impulse);
  if (e.loaded > 0)
    text += fmt::format(", {} mainly of the load, whose impulses are not compared",
                        plural(static_cast<std::size_t>(e.loaded), "contact"));
  if (e.merged > 0)
    text += fmt::format(", {} that one run does not resolve",
                        plural(static_cast<std::size_t>(e.merged), "further onset"));
  return text + (e.cut ? "); later events were not stored"
                 : e.overlapping
                     ? "); impacts overlap in penalty there, so that events are not comparable one by one"
                     : ")");
}

using Statistics = std::vector<StatisticPair>;

std::string values(const StatisticPair& s) {
  return fmt::format("{}: {:.3g} and {:.3g}", s.name, s.penalty, s.nonsmooth);
}

/// "greatest difference 18 %, share of free flight of pin: 0.1 and 0.12", or equal values.
std::string greatest(const Statistics& list) {
  const auto most = std::ranges::max_element(list, {}, &StatisticPair::relative);
  return most->relative() < rounding
             ? "no difference beyond rounding"
             : fmt::format("greatest difference {}, {}", percent(most->relative()), values(*most));
}

/// Statistics with a standard error, or without any.
std::string of_batches(const Statistics& list, const char* which) {
  if (std::ranges::any_of(list, [](const auto& s) { return std::isnan(s.error); }))
    return fmt::format("whether {} agree is unknown without standard errors ({})", which, greatest(list));
  const auto worst =
      std::ranges::max_element(list, {}, [](const auto& s) { return s.differs() ? s.relative() : -1; });
  if (worst->differs())
    return fmt::format("{} differ by more than {:g} standard errors, most in {} ({})", which, significant,
                       values(*worst), percent(worst->relative()));
  return fmt::format("{} agree within {:g} standard errors or {} ({})", which, significant, percent(notable),
                     greatest(list));
}

std::string statistics_in_words(const ComparisonValues& v) {
  Statistics compared, transient;
  std::vector<std::string> parts;
  std::size_t few = 0;
  std::vector<std::string> scattered;
  for (const auto& s : v.statistics)
    if (s.negligible())
      continue;
    else if (s.transient)
      transient.push_back(s);
    else if (s.few)
      ++few;
    else if (s.weak())
      scattered.push_back(s.name);
    else
      compared.push_back(s);
  if (few > 0)
    parts.push_back(fmt::format("too few impacts to compare {}",
                                compared.empty() ? "statistics" : plural(few, "statistic")));
  if (!scattered.empty())
    parts.push_back(
        fmt::format("the standard errors of {} ({}) exceed half of the values, too large for a comparison",
                    plural(scattered.size(), "statistic"), listed(scattered)));
  if (!compared.empty())
    parts.push_back(of_batches(compared, parts.empty() ? "the statistics" : "the other statistics"));
  if (!transient.empty())
    parts.push_back(
        fmt::format("energies of this single transient have no standard error ({})", greatest(transient)));
  return fmt::format("{}", fmt::join(parts, "; "));
}

/// "the fastest approach and the greatest impulse, single values without standard error, differ by
/// 11 % and 26 %": for each quantity the contact with the greatest difference.
std::string extremes_in_words(const ComparisonValues& v) {
  std::vector<std::string> names, sizes;
  for (const auto& [name, list] : {std::pair{"the fastest approach", &v.approaches},
                                   {"the greatest impulse (in penalty with the load)", &v.impulses}}) {
    if (list->empty()) continue;
    const auto& most = *std::ranges::max_element(*list, {}, &StatisticPair::relative);
    if (most.relative() < rounding) continue;
    names.emplace_back(name);
    sizes.push_back(percent(most.relative()) + (list->size() > 1 ? fmt::format(" ({})", most.name) : ""));
  }
  if (names.empty()) return "";
  return fmt::format("{}, {} without standard error, {} by {}{}", listed(names),
                     names.size() > 1 ? "single values" : "a single value",
                     names.size() > 1 ? "differ" : "differs",
                     std::max(v.approaches.size(), v.impulses.size()) > 1 ? "at most " : "", listed(sizes));
}

/// The cheaper of two runs, if their errors support a statement.
std::string cost_in_words(const CostAndError& p, const CostAndError& n, const std::string& scene) {
  auto text = fmt::format("CPU time: penalty {:.2g} s, nonsmooth {:.2g} s; ", p.cpu, n.cpu);
  std::vector<std::string> unknown;
  for (const auto& [run, name] : {std::pair{&p, "penalty"}, {&n, "nonsmooth"}})
    if (std::isnan(run->error)) unknown.emplace_back(name);
  if (!unknown.empty())
    return text +
           fmt::format(
               "the {} unknown, so costs at equal accuracy cannot be compared; see `freeplay advise {}`",
               unknown.size() == 2 ? "errors of both are" : "error of " + unknown.front() + " is", scene);
  const auto errors = fmt::format("(errors {} and {})", percent(p.error), percent(n.error));
  if (std::abs(p.cpu - n.cpu) <= alike * std::max(p.cpu, n.cpu))
    return text + "they cost about the same " + errors;
  const bool first = p.cpu < n.cpu;
  if ((first ? p : n).error <= (first ? n : p).error)
    return text +
           fmt::format("{} is cheaper for the same accuracy {}", first ? "penalty" : "nonsmooth", errors);
  return text + "the faster run has the greater error, so costs at equal accuracy cannot be compared " +
         errors;
}

std::string capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

/// Names with this outcome.
template <class T>
std::vector<std::string> with(const std::vector<T>& list, Outcome outcome, std::string T::*name) {
  std::vector<std::string> found;
  for (const auto& x : list)
    if (x.outcome == outcome) found.push_back(x.*name);
  return found;
}

}  // namespace

double StatisticPair::difference() const { return std::abs(penalty - nonsmooth); }

double relative_difference(double a, double b) {
  const double size = 0.5 * (std::abs(a) + std::abs(b));
  return size > 0 ? std::abs(a - b) / size : 0;
}

double StatisticPair::relative() const { return relative_difference(penalty, nonsmooth); }

bool StatisticPair::differs() const { return difference() > significant * error && relative() > notable; }

bool StatisticPair::weak() const { return error > 0.5 * 0.5 * (std::abs(penalty) + std::abs(nonsmooth)); }

bool StatisticPair::negligible() const {
  return std::max(std::abs(penalty), std::abs(nonsmooth)) < negligible_share * turnover;
}

std::string verdict(const ComparisonValues& v) {
  // One statement for each formulation, on its penetration if that is too deep.
  std::string doubts;
  for (const auto* formulation : {"penalty", "nonsmooth"}) {
    const Doubt* worst = nullptr;
    for (const auto& d : v.doubts)
      if (d.formulation == formulation && (!worst || (d.too_deep && !worst->too_deep))) worst = &d;
    if (worst)
      doubts += fmt::format("{} {} ({}): see warnings. ", capital(formulation),
                            worst->too_deep ? "is not reliable here" : "may be wrong", worst->reason);
  }
  if (!v.stopped.empty())
    return doubts +
           fmt::format(
               "{}, so statistics and costs cannot be compared; {}. Resolve the reason above first, or "
               "shorten run.duration.",
               capital(v.stopped),
               v.events.pairs > 0 ? "before that, s" + events_in_words(v).substr(1)
                                  : "no contact events agree before that");
  auto text = doubts + events_in_words(v);
  if (const auto statistics = statistics_in_words(v); !statistics.empty())
    text += (v.events.to_the_end || v.events.pairs == 0 ? "; " : "; beyond, ") + statistics;
  if (const auto extremes = extremes_in_words(v); !extremes.empty()) text += "; " + extremes;
  if (!v.one_sided.empty())
    text += fmt::format("; impacts that one run has and the other has not are not compared: {}",
                        listed(v.one_sided));
  text += ". " + cost_in_words(v.penalty, v.nonsmooth, v.scene);
  if (v.revolutions_needed > 0 &&
      std::ranges::any_of(v.statistics, [](const auto& s) { return std::isnan(s.error); }))
    text += fmt::format("; a run of at least {:g} revolutions gives the standard errors",
                        std::ceil(v.revolutions_needed));
  return text + ".";
}

std::string verdict(const std::vector<SignalAgreement>& models) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ". ") + capital(part); };
  if (const auto names = with(models, Outcome::stopped, &SignalAgreement::formulation); !names.empty())
    add(listed(names) + " stopped early and cannot be compared");
  bool faulty = false, differs = false;
  for (const auto& m : models)
    if (m.outcome == Outcome::differs) {
      differs = true;
      faulty = faulty || m.faulty_signal;
      constexpr long most = 3;
      const auto shown = std::min(most, static_cast<long>(m.findings.size()));
      add(fmt::format("{} differs from the measurement: {}", m.formulation,
                      fmt::join(m.findings.begin(), m.findings.begin() + shown, "; ")));
    }
  for (const auto& m : models) {
    if (m.outcome == Outcome::agrees)
      add(
          fmt::format("{} agrees with the measurement in waveform, peaks, their angles and spectrum (mean "
                      "revolutions: difference {:.3g} m/s², {:.3g} is explained); {}",
                      m.formulation, m.difference, m.limit, m.power));
    if (m.outcome == Outcome::undecided && m.limit < m.signal)
      add(fmt::format("no verdict on {}, which does not differ from the measurement: {}", m.formulation,
                      m.power));
    if (m.outcome == Outcome::undecided && m.limit >= m.signal)
      add(fmt::format(
          "no verdict on {}: the uncertainty and scatter explain differences of {:.3g} m/s², more "
          "than the measured signal (rms {:.3g} m/s²)",
          m.formulation, m.limit, m.signal));
  }
  std::vector<std::string> open;
  for (const auto& m : models)
    if (m.outcome == Outcome::undecided && !std::isfinite(m.limit)) open.push_back(m.formulation);
  if (!open.empty())
    add("whether " + listed(open) +
        " agrees is unknown, since the file has one revolution and no column uncertainty");
  for (const auto& m : models)
    if (m.offset != 0 && m.outcome != Outcome::differs)
      add(
          fmt::format("the measured signal has a constant offset of {:.3g} m/s² from {}, which is beyond its "
                      "uncertainty and not judged (--remove-offset)",
                      m.offset, m.formulation));
  if (faulty)
    add("correct the measured signal first");
  else if (differs)
    add("fit the unknown parameters with `freeplay calibrate`");
  return text + ".";
}

std::string verdict(const std::vector<PointsAgreement>& models) {
  std::vector<std::string> parts;
  const auto agree = with(models, Outcome::agrees, &PointsAgreement::name);
  const auto differ = with(models, Outcome::differs, &PointsAgreement::name);
  const auto open = with(models, Outcome::undecided, &PointsAgreement::name);
  if (!agree.empty()) parts.push_back("with all measured points agree: " + listed(agree));
  if (!differ.empty()) parts.push_back("outside the measurement's uncertainty: " + listed(differ));
  if (!open.empty()) parts.push_back("unknown without a column uncertainty: " + listed(open));
  auto text = capital(fmt::format("{}.", fmt::join(parts, "; ")));
  const auto size = [](const PointsAgreement& m) {
    return std::isfinite(m.relative_error) ? m.relative_error : INFINITY;
  };
  if (models.size() > 1)
    if (const auto closest = std::ranges::min_element(models, {}, size); std::isfinite(size(*closest)))
      text += fmt::format(" The closest is {}, with a relative rms error of {}.", closest->name,
                          percent(closest->relative_error));
  return text;
}

std::string verdict(const FindingCount& count) {
  if (count.assessed == 0) return "No published finding is assessed by these runs.";
  if (count.failing.empty())
    return fmt::format("All {} assessed findings hold; those marked - or fitted are no evidence.",
                       count.assessed);
  return fmt::format("{} of {} assessed findings hold. Not reproduced: {}.", count.holding, count.assessed,
                     listed(count.failing, 6));
}

std::string verdict(const std::vector<ChosenSetting>& settings, double error, const std::string& scene) {
  std::vector<const ChosenSetting*> found;
  for (const auto& s : settings)
    if (!s.label.empty()) found.push_back(&s);
  if (found.empty())
    return fmt::format(
        "No setting of the formulations reaches {}: accept a greater --error, or shorten run.duration.",
        percent(error));
  const auto until = [](const ChosenSetting& s) {
    if (s.whole && !(s.until < 0.99 * s.duration)) return std::string("evaluated over the whole run");
    return "evaluated over the first " + seconds(s.until) +
           (std::isfinite(s.duration) ? " of " + seconds(s.duration) : "") +
           (s.whole ? ", which contain all compared events" : "");
  };
  const auto rate = [](const ChosenSetting& s) { return s.cpu / s.until; };
  std::string text;
  if (found.size() == 1) {
    text = fmt::format("Within {}, only {} has a setting: {}, {}.", percent(error), found[0]->formulation,
                       found[0]->label, until(*found[0]));
  } else {
    const bool swap = rate(*found[1]) < rate(*found[0]);
    const auto &cheap = *found[swap ? 1 : 0], &dear = *found[swap ? 0 : 1];
    const auto costs = fmt::format(
        "CPU time per simulated second: {} {}, {:.2g} s; {} {}, {:.2g} s; settings chosen by "
        "right-hand sides + 10 Jacobians",
        cheap.formulation, cheap.label, rate(cheap), dear.formulation, dear.label, rate(dear));
    text = rate(cheap) >= (1 - alike) * rate(dear)
               ? fmt::format("Within {} both formulations cost about the same ({}).", percent(error), costs)
               : fmt::format("Within {} {} is cheaper ({}).", percent(error), cheap.formulation, costs);
  }
  std::vector<std::string> open;
  for (const auto* s : found) {
    std::vector<std::string> of;
    if (found.size() > 1 && (!s->whole || s->until < 0.99 * s->duration)) of.push_back(until(*s));
    if (!s->whole)
      of.push_back(std::isfinite(s->later) ? "later statistics to " + percent(s->later)
                                           : std::string("the accuracy of later statistics is unknown"));
    if (!of.empty()) open.push_back(fmt::format("{}: {}", s->formulation, fmt::join(of, ", ")));
  }
  return text +
         fmt::format(
             " {}{}he error excludes the difference of the formulations, which `freeplay compare {}` shows.",
             open.empty() ? "" : capital(fmt::format("{}; ", fmt::join(open, "; "))),
             open.empty() ? "T" : "t", scene);
}

std::string verdict(const CalibrationValues& v) {
  if (v.rejected)
    return "Calibration rejected: no values of the unknowns meet all targets within their uncertainties. "
           "Check the targets' tolerances and the model's assumptions.";
  if (!v.settled)
    return "Calibration open: the response surfaces do not predict runs at new points within half of the "
           "measurement's uncertainty, so no value is excluded. Increase calibrate.refinements or narrow the "
           "ranges.";
  if (!v.contradicted.empty())
    return fmt::format(
        "Calibration rejected: runs at the optimum disagree with the response surface of {}. Use more points "
        "or narrower ranges.",
        listed(v.contradicted));
  std::vector<std::string> values, open;
  for (const auto& u : v.unknowns) {
    const auto unit = u.unit.empty() ? "" : " " + u.unit;
    values.push_back(std::isfinite(u.low) ? fmt::format("{} = {:.4g} ({:.4g} to {:.4g}){}", u.name, u.value,
                                                        u.low, u.high, unit)
                                          : fmt::format("{} = {:.4g}{}", u.name, u.value, unit));
    if (u.open) open.push_back(u.name);
  }
  auto text = fmt::format("The targets are met by {} (95 %)", listed(values));
  text += open.empty() ? "."
                       : "; the range of " + listed(open) +
                             " is not closed by these targets: add targets or widen it.";
  if (!v.ridge.empty()) text += " " + v.ridge;
  if (v.predictions > 0)
    text += fmt::format(" Predicted from the others, {} of {} targets {} inside their 95 % interval",
                        v.predicted, v.predictions, v.predicted == 1 ? "lies" : "lie");
  else
    text += " No target was predicted from the others, so the fit is not tested";
  text += v.unpredicted.empty() ? "."
                                : fmt::format("; without {} the fit does not hold and predicts nothing.",
                                              listed(v.unpredicted, 4, "or"));
  return text;
}

std::string verdict(const SweepValues& v) {
  auto text = v.failed == 0
                  ? fmt::format("{} finished", v.runs == 1 ? "The run" : fmt::format("All {} runs", v.runs))
                  : fmt::format("{} of {} runs failed", v.failed, v.runs);
  std::vector<CellValue> cells;
  for (const auto& c : v.cells)
    if (std::isfinite(c.mean)) cells.push_back(c);
  if (cells.empty()) return text + "; they have no statistic to compare.";
  const auto where = [](const CellValue& c, bool named) {
    return c.place + (c.place.empty() || !named ? "" : ", ") + (named ? c.formulation : "");
  };
  const auto unit = v.unit.empty() ? "" : " " + v.unit;
  const auto [least, most] = std::ranges::minmax_element(cells, {}, &CellValue::mean);
  if (cells.size() > 1)
    text += fmt::format("; {} ranges from {:.4g}{} ({}) to {:.4g}{} ({})", v.statistic, least->mean, unit,
                        where(*least, true), most->mean, unit, where(*most, true));
  text += ".";
  // Pairs of cells that differ in the formulation only.
  std::map<std::string, std::vector<const CellValue*>> at;
  for (const auto& c : cells) at[c.place].push_back(&c);
  std::size_t pairs = 0, apart = 0, known = 0;
  StatisticPair greatest;
  for (const auto& [place, list] : at) {
    if (list.size() != 2) continue;
    const auto &a = *list[0], &b = *list[1];
    if (a.mean == 0 && b.mean == 0) continue;
    ++pairs;
    if (std::isfinite(a.low) && std::isfinite(b.low)) ++known, apart += a.low > b.high || b.low > a.high;
    const StatisticPair pair{place, a.mean, b.mean};
    if (pairs == 1 || pair.difference() > greatest.difference()) greatest = pair;
  }
  if (pairs == 0) return text;
  auto size = fmt::format("in {} by at most {:.3g}{}", v.statistic, greatest.difference(), unit);
  if (greatest.relative() < rounding)
    size = fmt::format("in {} by rounding only", v.statistic);
  else if (greatest.penalty != 0 && greatest.nonsmooth != 0)
    size += ", " + percent(greatest.relative());
  if (!greatest.name.empty()) size += " (" + greatest.name + ")";
  if (known < pairs)
    return text + fmt::format(
                      " The formulations differ {}; whether that exceeds the scatter of starts is unknown, "
                      "since {} one start (study.starts).",
                      size, known == 0 ? "each cell has" : "some cells have");
  return text + fmt::format(" The formulations differ {}; their 95 % intervals overlap in {} of {} cells.",
                            size, pairs - apart, pairs);
}

}  // namespace freeplay
