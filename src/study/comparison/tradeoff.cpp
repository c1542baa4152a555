#include "study/comparison/tradeoff.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

/// Compares long runs of each setting with those of a fine one from other starts.
void add_statistics(TradeoffScene& t, const Scene& scene, const Sampling& sampling, const Conduct& conduct,
                    const std::function<void(double)>& on_progress) {
  const auto others = perturbed_starts(scene, sampling, sampling.starts, conduct);
  const auto starts = perturbed_starts(scene, sampling, 0, conduct);
  if (starts.empty() || others.empty()) return;
  const std::vector<Setting> fine = {statistics_setting(Family::penalty),
                                     statistics_setting(Family::nonsmooth)};
  const auto references = long_runs(others, fine, conduct, {});
  t.sampling_error = relative_spread(references[1].lost);
  std::vector<Setting> settings;
  for (const auto& m : t.measured) settings.push_back(m.setting);
  const auto runs = long_runs(starts, settings, conduct, on_progress);
  for (std::size_t i = 0; i < settings.size(); ++i)
    t.measured[i].statistics =
        runs[i].stopped.empty()
            ? deviation(runs[i], references[settings[i].family == Family::penalty ? 0 : 1])
            : INFINITY;
}

}  // namespace

TradeoffScene trade_off(const Scene& scene, const Conduct& conduct, int repeats, const Sampling& sampling,
                        const std::function<void(double)>& on_progress) {
  TradeoffScene t;
  t.title = scene.mechanism.title;
  t.penalty = make_reference(scene, Family::penalty, conduct);
  t.nonsmooth = make_reference(scene, Family::nonsmooth, conduct);
  const auto n = std::min({t.penalty.touches.size(), t.nonsmooth.touches.size(), std::size_t{2}});
  t.model_error =
      n == 0 ? std::nan("")
             : onset_error({t.penalty.touches.begin(), t.penalty.touches.begin() + static_cast<long>(n)},
                           {t.nonsmooth.touches.begin(), t.nonsmooth.touches.begin() + static_cast<long>(n)});
  std::vector<Setting> settings;
  for (const auto& f : families)
    if (t.reference(f.value).ending.status == Ending::Status::finished)
      for (const auto& s : all_settings(f.value)) settings.push_back(s);
  std::vector<std::vector<double>> seconds(settings.size());
  double done = 0;
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (std::size_t i = 0; i < settings.size(); ++i) {
      if (conduct.stop()) return t;
      auto m = measure(scene, settings[i], t.reference(settings[i].family), conduct);
      seconds[i].push_back(m.cpu);
      if (repeat == 0) t.measured.push_back(std::move(m));
      if (on_progress) on_progress(++done / static_cast<double>(settings.size()) / repeats);
    }
  for (std::size_t i = 0; i < settings.size(); ++i) {
    std::ranges::sort(seconds[i]);
    t.measured[i].cpu_low = seconds[i].front();
    t.measured[i].cpu = seconds[i][seconds[i].size() / 2];
    t.measured[i].cpu_high = seconds[i].back();
  }
  add_statistics(t, scene, sampling, conduct, on_progress);
  return t;
}

std::vector<std::pair<std::string, double>> orders_in_work(const TradeoffScene& t) {
  struct Points {
    std::string method;
    std::vector<std::pair<double, double>> at;  // log work, log error
  };
  std::vector<Points> methods;
  for (const auto& m : t.measured) {
    const auto& reference = t.reference(m.setting.family);
    const double error = reference.touches.empty() ? m.errors.state : m.errors.events;
    if (methods.empty() || methods.back().method != m.setting.method())
      methods.push_back({m.setting.method(), {}});
    if (m.ending.status == Ending::Status::finished && error < 0.5 && error > 2 * reference.accuracy)
      methods.back().at.emplace_back(std::log(static_cast<double>(m.work.rhs)), std::log(error));
  }
  std::vector<std::pair<std::string, double>> orders;
  for (const auto& [method, at] : methods) {
    if (at.size() < 3) continue;
    double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    for (const auto& [work, error] : at)
      x += work, y += error, xx += work * work, xy += work * error, yy += error * error;
    const auto n = static_cast<double>(at.size());
    const double along = x * y - n * xy, work = n * xx - x * x, error = n * yy - y * y;
    if (along > 0.9 * std::sqrt(work * error)) orders.emplace_back(method, along / work);
  }
  return orders;
}

namespace {

nlohmann::json scene_json(const TradeoffScene& t) {
  const auto reference = [](const Reference& r) {
    return nlohmann::json{{"touches", r.touches.size()},
                          {"horizon_s", r.horizon},
                          {"known_to", r.accuracy},
                          {"ending", r.ending.reason}};
  };
  nlohmann::json list = nlohmann::json::array();
  for (const auto& m : t.measured)
    list.push_back({{"formulation", name_of(m.setting.family)},
                    {"method", m.setting.method()},
                    {"fineness", m.setting.fineness},
                    {"ending", m.ending.reason},
                    {"error_events", m.errors.events},
                    {"error_state", m.errors.state},
                    {"error_energy", m.errors.energy},
                    {"difference_dissipated", m.errors.dissipated},
                    {"statistics_in_standard_errors", m.statistics},
                    {"cpu_s", m.cpu},
                    {"cpu_least_s", m.cpu_low},
                    {"cpu_greatest_s", m.cpu_high},
                    {"steps", m.work.steps},
                    {"right_hand_sides", m.work.rhs},
                    {"factorisations", m.work.factorisations},
                    {"pivots", m.work.pivots}});
  return {{"title", t.title},
          {"scene_file", t.file.lexically_normal().string()},
          {"reference_penalty", reference(t.penalty)},
          {"reference_nonsmooth", reference(t.nonsmooth)},
          {"model_error_of_penalty", t.model_error},
          {"sampling_error_of_dissipated", t.sampling_error},
          {"settings", list}};
}

}  // namespace

nlohmann::json to_json(const std::vector<TradeoffScene>& scenes) {
  nlohmann::json document;
  for (const auto& t : scenes) document["scenes"][t.name] = scene_json(t);
  return document;
}

// The texts of `freeplay tradeoff`: the tables of its scenes, and the page docs/verification/tradeoff.md.

namespace {

/// Table of a scene's settings, for a terminal or as Markdown.
std::string settings(const TradeoffScene& t, bool markdown) {
  Table all("setting,events,state,energy,stat.,steps,rhs,pivots,CPU ms");
  Table few("setting,events,state,energy,stat.,rhs,CPU ms");  // for 80 columns
  for (const auto& m : t.measured) {
    const bool ended = m.ending.status == Ending::Status::finished;
    const bool touches = !t.reference(m.setting.family).touches.empty();
    const auto statistics = std::isnan(m.statistics)   ? "-"
                            : std::isinf(m.statistics) ? "stopped"
                                                       : fmt::format("{:.1f}", m.statistics);
    const auto label = m.setting.label();
    const auto events = !ended    ? "stopped"
                        : touches ? shown(m.errors.events)
                                  : "-",
               state = ended ? shown(m.errors.state) : "-", energy = ended ? shown(m.errors.energy) : "-";
    all.row(label, events, state, energy, statistics, m.work.steps, m.work.rhs, m.work.pivots,
            fmt::format("{:.3g} ({:.3g}..{:.3g})", 1e3 * m.cpu, 1e3 * m.cpu_low, 1e3 * m.cpu_high));
    few.row(label, events, state, energy, statistics, m.work.rhs, fmt::format("{:.3g}", 1e3 * m.cpu));
  }
  return markdown ? all.markdown() : few.terminal({29, 8, 8, 8, 8, 9, 9});
}

std::string heading(const TradeoffScene& t) {
  return fmt::format(
      "Evaluated on {} contact events up to {:.4g} s (penalty) and {} up to {:.4g} s\n(nonsmooth); "
      "references "
      "accurate to {} and {}.\nModel error of penalty (finite K, no numerics; two contact events): {}.\n"
      "Energy lost scatters by {} over starts.\n",
      t.penalty.touches.size(), t.penalty.horizon, t.nonsmooth.touches.size(), t.nonsmooth.horizon,
      shown(t.penalty.accuracy), shown(t.nonsmooth.accuracy), shown(t.model_error), shown(t.sampling_error));
}

std::string orders(const TradeoffScene& t) {
  std::vector<std::string> list;
  for (const auto& [method, order] : orders_in_work(t))
    list.push_back(fmt::format("{} {:.1f}", method, order));
  return fmt::format("Orders in work: {}.\n",
                     list.empty() ? "none" : fmt::format("{}", fmt::join(list, ", ")));
}

/// Summary: error and CPU time of the settings of `--accuracy`.
Table summary(const std::vector<TradeoffScene>& scenes) {
  Table table("scene,model error of penalty");
  for (const auto& family : families)
    for (const auto& accuracy : accuracies) table.column(fmt::format("{} *{}*", family.text, accuracy.text));
  for (const auto& t : scenes) {
    std::vector<Table::Cell> row{t.variant, shown(t.model_error)};
    for (const auto& family : families)
      for (const auto& accuracy : accuracies) {
        const auto label = setting_for(family.value, accuracy.value).label();
        const auto m = std::ranges::find_if(t.measured, [&](const Measured& one) {
          return one.setting.family == family.value && one.setting.label() == label;
        });
        const bool touches = !t.reference(family.value).touches.empty();
        row.emplace_back(m == t.measured.end() ? "-"
                         : m->ending.status != Ending::Status::finished
                             ? "stopped"
                             : fmt::format("{} in {:.3g} ms",
                                           shown(touches ? m->errors.events : m->errors.state),
                                           1e3 * m->cpu));
      }
    table.row(std::move(row));
  }
  return table;
}

/// Beginning of the document: the summary, with the figure of this name.
std::string page_summary(const Table& table, const std::string& figure) {
  auto out =
      "# Speed against accuracy\n\nThis page compares error and cost of all integrators and schemes on the "
      "scenes of a study, relative to a more accurate\nreference.\n\n## Summary\n\nError and CPU time of the "
      "settings of `--accuracy`. The error is that of contact events (time, approach speed, impulse),\nor "
      "of the "
      "velocities in scenes without contact events. The model error of penalty is due to its finite "
      "stiffness; "
      "no\nsetting reduces it.\n\n" +
      table.markdown();
  if (!figure.empty())
    out += fmt::format(
        "\n![{0}](figures/{0})\n*Error over evaluations of the right-hand side and over CPU time, for one "
        "scene; "
        "the other scenes are at the end.*\n",
        figure);
  return out;
}

/// Definitions of the errors, and the settings of `--accuracy`.
std::string page_definitions(const std::string& command, int repeats) {
  std::string text = fmt::format(
      "\n## Quantities and settings\n\nWritten by `{} --document docs/verification`. Errors: *events*, "
      "the greatest relative error of\ntimes (over the time since the last event), approach speeds and "
      "impulses of contact events up to the horizon; *state*, of the\nvelocities in the middle of the "
      "flight before the last contact event used (with fewer than two: before the first, or at the end); "
      "*energy*, the error of the energy balance over the whole run; *stat.*, the difference, in standard "
      "errors,\nof the mean energy loss or flight share (the worse of the two) over perturbed starts from "
      "that of an accurate\nsetting over other starts: 3.0 is Welch's bound at 1 % for eight starts each, "
      "so one setting in fifty exceeds it by chance. *Orders in work*: the order of an error in the number "
      "of right-hand sides, by least\nsquares over at least three settings with errors between twice the "
      "accuracy of the reference and 0.5; of events, or of the state for motions without contact events; "
      "given if the points are on a line.\nCounts do not depend on the machine; CPU is the median "
      "(least..greatest) of {} interleaved runs.\n",
      command, repeats);
  text += "\n`--accuracy` uses these rows of the tables:";
  for (const auto& [family, formulation] : families)
    text += fmt::format(
        " {} *fast* {}, *balanced* {}, *reference* {}{}", formulation,
        setting_for(family, Accuracy::fast).label(), setting_for(family, Accuracy::balanced).label(),
        setting_for(family, Accuracy::reference).label(), family == families.back().value ? ".\n" : ";");
  text +=
      "*fast* reproduces the mechanism's statistics, *balanced* is for studies, and *reference* has "
      "smaller errors than any model here.\nPenalty uses Adams-Bashforth-Moulton, which needs the fewest "
      "right-hand sides on the paper's rig, at tolerances that\nresolve the contact events. Nonsmooth uses "
      "the automatic scheme: event-driven, the cheapest at any accuracy, where events are separate,\nand "
      "time stepping with adaptive steps where they accumulate.\n";
  return text;
}

}  // namespace

std::string tradeoff_text(const TradeoffScene& t) {
  return fmt::format("{} ({})\n{}\n{}{}\n", t.variant, t.name, heading(t), settings(t, false), orders(t));
}

Table tradeoff_table(const std::vector<TradeoffScene>& scenes) {
  Table table(
      "scene,formulation,method,fineness,events,state,energy,statistics,rhs,cpu_s,cpu_least_s,"
      "cpu_greatest_s");
  for (const auto& t : scenes)
    for (const auto& m : t.measured)
      if (m.ending.status == Ending::Status::finished)
        table.row(t.name, name_of(m.setting.family), m.setting.method(), m.setting.fineness,
                  t.reference(m.setting.family).touches.empty() ? NAN : m.errors.events, m.errors.state,
                  m.errors.energy, m.statistics, m.work.rhs, m.cpu, m.cpu_low, m.cpu_high);
  return table;
}

std::string tradeoff_page(const std::vector<TradeoffScene>& scenes, std::vector<std::string> figures,
                          const std::string& first, const std::string& command, int repeats) {
  std::string text;
  for (const auto& t : scenes)
    text += fmt::format("\n## {}\n\n{}\n{}\n{}", t.variant, heading(t), settings(t, true), orders(t));
  const bool shows_first = std::erase(figures, first) > 0;
  text += "\n## Figures\n";
  for (const auto& name : figures) text += fmt::format("\n![{0}](figures/{0})\n", name);
  return page_summary(summary(scenes), shows_first ? first : "") + page_definitions(command, repeats) + text;
}

}  // namespace freeplay
