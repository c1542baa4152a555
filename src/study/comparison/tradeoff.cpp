#include "study/comparison/tradeoff.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

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

nlohmann::json to_json(const TradeoffScene& t) {
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
          {"reference_penalty", reference(t.penalty)},
          {"reference_nonsmooth", reference(t.nonsmooth)},
          {"model_error_of_penalty", t.model_error},
          {"sampling_error_of_dissipated", t.sampling_error},
          {"settings", list}};
}

}  // namespace freeplay
