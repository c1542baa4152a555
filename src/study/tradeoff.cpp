#include "study/tradeoff.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/recorder.hpp"

namespace freeplay {
namespace {

/// Relative standard deviation of the energy lost over four perturbed starts, by the balanced setting.
double sampling_error(const Scene& scene, const Makers& makers) {
  if (System(scene.mechanism).contacts() == 0) return 0;
  std::vector<double> lost;
  for (int start = 0; start < 4; ++start) {
    try {
      auto moved = perturbed(scene, makers.penalty, 1, start, {0, 0.5});
      setting_for("nonsmooth", Accuracy::balanced).apply(moved);
      moved.instruments.clear();
      const auto run = run_scene(moved, makers.matched, std::nullopt);
      if (run.ending.status == Ending::Status::finished)
        lost.push_back(run.ledger.contact + run.ledger.friction);
    } catch (const SceneError&) {
      // A scene that closes only thanks to its play has no perturbed starts.
    }
  }
  double mean = 0, squares = 0;
  for (double x : lost) mean += x / static_cast<double>(lost.size());
  for (double x : lost) squares += (x - mean) * (x - mean);
  return lost.size() > 1 && mean != 0 ? std::sqrt(squares / static_cast<double>(lost.size() - 1)) / mean
                                      : std::nan("");
}

}  // namespace

TradeoffScene trade_off(const Scene& scene, const Makers& makers, int repeats,
                        const std::function<void(double)>& on_progress) {
  TradeoffScene t;
  t.title = scene.mechanism.title;
  t.penalty = make_reference(scene, "penalty", makers);
  t.nonsmooth = make_reference(scene, "nonsmooth", makers);
  const auto n = std::min({t.penalty.touches.size(), t.nonsmooth.touches.size(), std::size_t{2}});
  t.model_error =
      n == 0 ? std::nan("")
             : touch_error({t.penalty.touches.begin(), t.penalty.touches.begin() + static_cast<long>(n)},
                           {t.nonsmooth.touches.begin(), t.nonsmooth.touches.begin() + static_cast<long>(n)});
  t.sampling_error = sampling_error(scene, makers);
  std::vector<Setting> settings;
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    const auto& reference = formulation[0] == 'p' ? t.penalty : t.nonsmooth;
    if (reference.ending.status == Ending::Status::finished)
      for (const auto& s : all_settings(formulation)) settings.push_back(s);
  }
  std::vector<std::vector<double>> seconds(settings.size());
  double done = 0;
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (std::size_t i = 0; i < settings.size(); ++i) {
      if (stop_requested) return t;
      const auto& reference = settings[i].formulation == "penalty" ? t.penalty : t.nonsmooth;
      auto m = measure(scene, settings[i], reference, makers);
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
  return t;
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
    list.push_back({{"formulation", m.setting.formulation},
                    {"method", m.setting.method()},
                    {"fineness", m.setting.fineness},
                    {"ending", m.ending.reason},
                    {"error_events", m.errors.events},
                    {"error_state", m.errors.state},
                    {"error_energy", m.errors.energy},
                    {"difference_dissipated", m.errors.dissipated},
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

Advice advise(const Scene& given, const std::string& formulation, double error, const Makers& makers,
              const std::function<void(double)>& on_progress) {
  Advice advice;
  Scene scene = given;
  advice.reference = make_reference(scene, formulation, makers, 4);
  if (advice.reference.ending.status != Ending::Status::finished) return advice;
  advice.by_events = !advice.reference.touches.empty();
  // A little beyond the last touch, so that a late one is a late one and not a missing one.
  if (advice.by_events)
    scene.run.duration = std::min(scene.run.duration,
                                  1.05 * advice.reference.horizon + advice.reference.touches.back().duration);
  advice.simulated = scene.run.duration;
  const auto settings = all_settings(formulation);
  for (std::size_t i = 0; i < settings.size(); ++i) {
    if (stop_requested) return advice;
    advice.tried.push_back(measure(scene, settings[i], advice.reference, makers));
    if (on_progress) on_progress(static_cast<double>(i + 1) / static_cast<double>(settings.size()));
  }
  // By right-hand sides and pivots, which do not depend on the machine's mood.
  const auto cost = [](const Measured& m) { return m.work.rhs + 10 * m.work.jacobians; };
  std::ranges::stable_sort(advice.tried, {}, cost);
  for (std::size_t i = 0; i < advice.tried.size() && advice.chosen < 0; ++i) {
    const auto& m = advice.tried[i];
    const double found = advice.by_events ? m.errors.events : m.errors.state;
    if (m.ending.status == Ending::Status::finished && found <= 0.5 * error)
      advice.chosen = static_cast<int>(i);
  }
  return advice;
}

}  // namespace freeplay
