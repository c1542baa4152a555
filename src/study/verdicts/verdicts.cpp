#include "study/verdicts/verdicts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

namespace freeplay {
namespace {

using Outcome = SignalAgreement::Outcome;

constexpr double significant = 3;  // standard errors
constexpr double notable = 0.01;   // relative difference
// CPU times measured once scatter by about this share on a busy machine.
constexpr double alike = 0.2;

std::string percent(double x) { return fmt::format("{:.2g} %", 100 * x); }

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
std::string listed(const std::vector<std::string>& names, std::size_t most = 4) {
  if (names.size() > most)
    return fmt::format("{} and {} more",
                       fmt::join(names.begin(), names.begin() + static_cast<long>(most), ", "),
                       names.size() - most);
  if (names.size() < 2) return names.empty() ? "" : names.front();
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

std::string events_in_words(const EventAgreement& e) {
  if (!e.contacts) return "The scene has no contacts, so there are no single events to compare";
  if (e.pairs == 0)
    return e.to_the_end ? "Neither run has a contact event"
                        : "No single contact event of the two runs agrees";
  auto text = fmt::format("Single contact events agree {} ({}: times within {}, approach speeds within {}",
                          e.to_the_end ? "to the end of the run" : "up to t = " + seconds(e.horizon),
                          plural(e.pairs, "pair"), seconds(e.time), percent(e.speed));
  if (std::isfinite(e.impulse)) text += ", impulses within " + percent(e.impulse);
  return text + (e.cut ? "); later events were not stored" : ")");
}

std::string statistics_in_words(const ComparisonValues& v) {
  const auto& list = v.statistics;
  if (list.empty()) return "";
  const auto values = [](const StatisticPair& s) {
    return fmt::format("{}: {:.3g} and {:.3g}", s.name, s.penalty, s.nonsmooth);
  };
  const auto most = std::ranges::max_element(list, {}, &StatisticPair::relative);
  if (std::ranges::any_of(list, [](const auto& s) { return std::isnan(s.error); }))
    return fmt::format(
        "whether the statistics agree is unknown without standard errors (greatest difference {}, {})",
        percent(most->relative()), values(*most));
  const auto worst =
      std::ranges::max_element(list, {}, [](const auto& s) { return s.differs() ? s.relative() : -1; });
  if (worst->differs())
    return fmt::format("the statistics differ by more than {:g} standard errors, most in {} ({})",
                       significant, values(*worst), percent(worst->relative()));
  return fmt::format("the statistics agree within {:g} standard errors or {} (greatest difference {}, {})",
                     significant, percent(notable), percent(most->relative()), values(*most));
}

/// The cheaper of two runs, if their errors support a statement.
std::string cost_in_words(const CostAndError& p, const CostAndError& n) {
  auto text = fmt::format("CPU time: penalty {:.2g} s, nonsmooth {:.2g} s; ", p.cpu, n.cpu);
  std::vector<std::string> unknown;
  for (const auto& [run, name] : {std::pair{&p, "penalty"}, {&n, "nonsmooth"}})
    if (std::isnan(run->error)) unknown.emplace_back(name);
  if (!unknown.empty())
    return text +
           fmt::format("which is cheaper for the same accuracy is unknown, since the accuracy of {} is",
                       unknown.size() == 2 ? "both" : unknown.front());
  const auto errors = fmt::format("(errors {} and {})", percent(p.error), percent(n.error));
  if (std::abs(p.cpu - n.cpu) <= alike * std::max(p.cpu, n.cpu))
    return text + "they cost about the same " + errors;
  const bool first = p.cpu < n.cpu;
  if ((first ? p : n).error <= (first ? n : p).error)
    return text +
           fmt::format("{} is cheaper for the same accuracy {}", first ? "penalty" : "nonsmooth", errors);
  return text +
         "the faster run is also the less accurate, so which is cheaper for the same accuracy is unknown " +
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

double StatisticPair::relative() const {
  const double size = 0.5 * (std::abs(penalty) + std::abs(nonsmooth));
  return size > 0 ? std::abs(penalty - nonsmooth) / size : 0;
}

bool StatisticPair::differs() const {
  return std::abs(penalty - nonsmooth) > significant * error && relative() > notable;
}

std::string verdict(const ComparisonValues& v) {
  if (!v.stopped.empty())
    return fmt::format(
        "{}, so statistics and costs cannot be compared; {}. Resolve the reason above first, or "
        "shorten run.duration.",
        capital(v.stopped),
        v.events.pairs > 0 ? "before that, s" + events_in_words(v.events).substr(1)
                           : "no contact events agree before that");
  auto text = events_in_words(v.events);
  if (const auto statistics = statistics_in_words(v); !statistics.empty())
    text += (v.events.to_the_end || v.events.pairs == 0 ? "; " : "; beyond, ") + statistics;
  text += ". " + cost_in_words(v.penalty, v.nonsmooth);
  std::vector<std::string> next;
  if (std::isnan(v.penalty.error) || std::isnan(v.nonsmooth.error))
    next.push_back(fmt::format("`freeplay advise {}` measures it", v.scene));
  if (v.revolutions_needed > 0 &&
      std::ranges::any_of(v.statistics, [](const auto& s) { return std::isnan(s.error); }))
    next.push_back(fmt::format("a run of at least {:g} revolutions gives the standard errors",
                               std::ceil(v.revolutions_needed)));
  return text + (next.empty() ? "" : "; " + listed(next)) + ".";
}

std::string verdict(const std::vector<SignalAgreement>& models) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  if (const auto names = with(models, Outcome::stopped, &SignalAgreement::formulation); !names.empty())
    add(listed(names) + " stopped early and cannot be compared");
  for (const auto& m : models)
    if (m.outcome == Outcome::differs)
      add(fmt::format("{} differs from the measurement: {}", m.formulation, m.finding));
  for (const auto& m : models)
    if (m.outcome == Outcome::agrees)
      add(
          fmt::format("{} agrees with the measured mean revolution (difference {:.3g} m/s², uncertainty and "
                      "scatter {:.3g} m/s²)",
                      m.formulation, m.difference, m.expected));
  if (const auto names = with(models, Outcome::undecided, &SignalAgreement::formulation); !names.empty())
    add("whether " + listed(names) +
        " agrees is unknown, since the file has one revolution and no column uncertainty");
  text = capital(text) + ".";
  std::vector<std::string> ratios;
  bool off = false;
  for (const auto& m : models)
    if (std::isfinite(m.peak_ratio)) {
      ratios.push_back(fmt::format("{:.3g} ({})", m.peak_ratio, m.formulation));
      off = off || std::abs(m.peak_ratio - 1) > 0.1;
    }
  if (!ratios.empty())
    text += fmt::format(
        " Peaks are not part of this verdict: the models' median peak is {} of the measured one{}.",
        listed(ratios), off ? "; fit the unknown parameters with `freeplay calibrate`" : "");
  return text;
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
    return s.whole ? std::string("over the whole run") : "up to t = " + seconds(s.until);
  };
  const auto rate = [](const ChosenSetting& s) { return s.cpu / s.until; };
  std::string text;
  if (found.size() == 1) {
    text = fmt::format("Within {}, only {} has a setting: {}, {}.", percent(error), found[0]->formulation,
                       found[0]->label, until(*found[0]));
  } else {
    const bool swap = rate(*found[1]) < rate(*found[0]);
    const auto &cheap = *found[swap ? 1 : 0], &dear = *found[swap ? 0 : 1];
    const auto costs =
        fmt::format("CPU time per simulated second: {} {}, {:.2g} s; {} {}, {:.2g} s", cheap.formulation,
                    cheap.label, rate(cheap), dear.formulation, dear.label, rate(dear));
    text = rate(cheap) >= (1 - alike) * rate(dear)
               ? fmt::format("Within {} both formulations cost about the same ({}).", percent(error), costs)
               : fmt::format("Within {} {} is cheaper ({}).", percent(error), cheap.formulation, costs);
  }
  std::vector<std::string> open;
  for (const auto* s : found)
    if (!s->whole)
      open.push_back(fmt::format("{}: single events are predictable {}, {}", s->formulation, until(*s),
                                 std::isfinite(s->later)
                                     ? "statistics to " + percent(s->later)
                                     : std::string("the accuracy of later statistics is unknown")));
  return text +
         fmt::format(
             " {}{}he error excludes the difference of the formulations, which `freeplay compare {}` shows.",
             open.empty() ? "" : capital(fmt::format("{}; ", fmt::join(open, "; "))),
             open.empty() ? "T" : "t", scene);
}

std::string verdict(const CalibrationValues& v) {
  if (v.rejected)
    return "Calibration rejected: no values of the unknowns meet all targets within their uncertainties. Check the "
           "targets' tolerances and the model's assumptions.";
  if (!v.contradicted.empty())
    return fmt::format(
        "Calibration rejected: runs at the optimum disagree with the response surface of {}. Use more points or "
        "narrower ranges.",
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
  if (v.predictions > 0)
    text += fmt::format(" Predicted from the others, {} of {} targets {} inside their 95 % interval.",
                        v.predicted, v.predictions, v.predicted == 1 ? "lies" : "lie");
  else
    text += " No target was predicted from the others, so the fit is not tested.";
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
    ++pairs;
    if (std::isfinite(a.low) && std::isfinite(b.low)) ++known, apart += a.low > b.high || b.low > a.high;
    if (const StatisticPair pair{place, a.mean, b.mean}; pairs == 1 || pair.relative() > greatest.relative())
      greatest = pair;
  }
  if (pairs == 0) return text;
  const auto size = fmt::format("at most {} apart{}", percent(greatest.relative()),
                                greatest.name.empty() ? "" : " (" + greatest.name + ")");
  if (known < pairs)
    return text + fmt::format(
                      " The formulations are {}; whether that exceeds the scatter of starts is unknown, "
                      "since {} one start (study.starts).",
                      size, known == 0 ? "each cell has" : "some cells have");
  return text + fmt::format(" The formulations are {}; their 95 % intervals overlap in {} of {} cells.", size,
                            pairs - apart, pairs);
}

}  // namespace freeplay
