// The tangent vectors are replaced by an orthonormal basis after every few steps (QR), from their last
// components to the first. With r_ii the stretching factors,
//
//     λ_i = (1/τ) Σ ln r_ii
//
// over the time τ after the transient (Benettin, Galgani, Giorgilli and Strelcyn, Meccanica 15 (1980) 9
// and 21). The standard error follows from the means of batches of equal length.
#include "analysis/lyapunov.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <vector>

#include "analysis/periodicity.hpp"
#include "dynamics/system.hpp"
#include "facade/identify.hpp"
#include "facade/simulation.hpp"
#include "formulations/variation/tangent_run.hpp"
#include "mechanism/duration.hpp"
#include "mechanism/scene.hpp"
#include "numerics/dense.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

/// Steps between two orthonormalisations, unless contacts close; in explicit steps a factor of stretching
/// is about e at most.
constexpr int steps_between = 8;
/// Points of the course of the means, for each batch.
constexpr int samples_of_batch = 10;
/// Share of the transient without tangent vectors, until the motion is near its attractor.
constexpr double plain_share = 0.5;
/// Tangent vectors begin where TangentRun::may_vary() holds, or at this share of the transient.
constexpr double latest_share = 0.8;
/// Multipliers below this are the errors of the differences at events (1e-12) and of nearly equal zeros.
constexpr double vanished_multiplier = 1e-6;

double batch_error(const std::vector<double>& means) {
  const auto count = static_cast<double>(means.size());
  const double mean = std::accumulate(means.begin(), means.end(), 0.0) / count;
  double squares = 0;
  for (const double x : means) squares += (x - mean) * (x - mean);
  return std::sqrt(squares / (count * (count - 1)));
}

/// Sums of logarithms up to a time.
struct Sums {
  double t = 0;
  std::vector<double> logs;
  double flow = 0, impacts = 0;
  long onsets = 0;
  double predicted() const { return flow + impacts; }
};

class Spectrum {
 public:
  /// `count`: number of vectors; 0: all.
  Spectrum(TangentRun& run, int count) : run_(run), count_(static_cast<std::size_t>(count)) {}

  void begin() {
    run_.vary(vectors());
    sums_.logs.assign(run_.collapsed().size(), 0);
    run_.orthonormalise();
  }
  /// To t (s), where the vectors are orthonormal. Returns false if the run ends before, with a failure.
  bool advance(double t) {
    int steps = 0;
    long onsets = run_.onsets();
    while (run_.t() < t) {
      if (!run_.step(t)) return false;
      run_.forget_onsets();
      if (++steps < steps_between && run_.onsets() == onsets && run_.t() < t) continue;
      steps = 0;
      onsets = run_.onsets();
      const auto logs = run_.orthonormalise();
      for (std::size_t i = 0; i < logs.size(); ++i) sums_.logs[i] += logs[i];
    }
    return true;
  }
  Sums sums() const {
    auto s = sums_;
    s.t = run_.t();
    const auto predicted = run_.predicted();
    s.flow = predicted.flow;
    s.impacts = predicted.impacts;
    s.onsets = run_.onsets();
    return s;
  }

 private:
  /// A basis, or vectors in general position: those of the greatest exponents grow fastest in any.
  std::vector<std::vector<double>> vectors() const {
    const auto all = run_.full();
    if (count_ == 0 || count_ >= all.size()) return all;
    std::vector<std::vector<double>> list(count_, std::vector<double>(all.front().size()));
    for (std::size_t j = 0; j < count_; ++j)
      for (std::size_t i = 0; i < all.size(); ++i) {
        const double part = std::cos(static_cast<double>((i + 1) * (j + 1)));
        for (std::size_t k = 0; k < all[i].size(); ++k) list[j][k] += part * all[i][k];
      }
    return list;
  }

  TangentRun& run_;
  std::size_t count_;
  Sums sums_;
};

/// The mean growth from one sum to another; −∞ from the collapse of the vector on.
double mean_growth(double from, double to, double time) {
  return std::isfinite(to) ? (to - from) / time : -INFINITY;
}

double total(const std::vector<double>& logs) { return std::accumulate(logs.begin(), logs.end(), 0.0); }

/// The exponents from the sums at the ends of the batches; `order`: their places among the vectors.
std::vector<std::size_t> take_exponents(const std::vector<Sums>& ends, const TangentRun& run,
                                        Lyapunov& found) {
  const auto& first = ends.front();
  const auto& last = ends.back();
  const double length = last.t - first.t;
  std::vector<LyapunovExponent> list(first.logs.size());
  const auto means = [&](auto value) {
    std::vector<double> all;
    for (std::size_t b = 1; b < ends.size(); ++b)
      all.push_back((value(ends[b]) - value(ends[b - 1])) / (ends[b].t - ends[b - 1].t));
    return all;
  };
  for (std::size_t i = 0; i < list.size(); ++i) {
    list[i].reason = run.collapsed()[i];
    if (!list[i].reason.empty()) {
      list[i].value = -INFINITY;
      continue;
    }
    list[i].value = (last.logs[i] - first.logs[i]) / length;
    list[i].error = batch_error(means([i](const Sums& s) { return s.logs[i]; }));
  }
  std::vector<std::size_t> order(list.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](auto a, auto b) { return list[a].value > list[b].value; });
  for (const auto i : order) found.exponents.push_back(list[i]);
  found.duration = length;
  found.batches = static_cast<int>(ends.size()) - 1;
  found.impacts = last.onsets - first.onsets;
  found.sum = mean_growth(total(first.logs), total(last.logs), length);
  if (std::isfinite(found.sum))
    found.sum_error = batch_error(means([](const Sums& s) { return total(s.logs); }));
  found.unpredicted = run.predicted().unknown;
  if (found.unpredicted.empty()) {
    found.divergence = (last.flow - first.flow) / length;
    found.impact_part = (last.impacts - first.impacts) / length;
    found.predicted = found.divergence + found.impact_part;
  }
  return order;
}

void check(const Scene& scene, const LyapunovRequest& request) {
  require_exponents(scene, request.formulation);
  if (request.exponents < 0) throw ModelError("exponents", "must be 0 or greater");
  if (request.batches < fewest_batches)
    throw ModelError("batches", fmt::format("must be {} or greater", fewest_batches));
  if (request.transient && !(*request.transient >= 0 && *request.transient < scene.run.duration))
    throw ModelError("transient",
                     fmt::format("must be at least 0 and less than the duration of the run, {:.9g} s",
                                 scene.run.duration));
  require_duration("transient", request.transient.value_or(0));
}

/// To the end of the transient at `until` (s), where the vectors have aligned. Returns false if the run ends
/// before.
bool pass_transient(TangentRun& run, Spectrum& spectrum, double until, double first_step) {
  const double begin = run.t();
  const double plain = begin + plain_share * (until - begin), latest = begin + latest_share * (until - begin);
  // The first step determines the mode: contacts that are closed there have no own coordinates.
  if (!run.step(std::max(plain, begin + first_step))) return false;
  while (run.t() < plain)
    if (!run.step(plain)) return false;
  while (!run.may_vary() && run.t() < latest)
    if (!run.step(latest)) return false;
  spectrum.begin();
  return spectrum.advance(until);
}

/// ln|μ| of the multipliers μ of a cycle from here, the greatest first; empty if the run or a vector ends.
std::vector<double> cycle_logs(TangentRun& run, double cycle) {
  const double end = run.t() + cycle;
  const auto Z = run.directions();
  run.vary(run.full());
  while (run.t() < end) {
    if (!run.step(end)) return {};
    run.forget_onsets();
  }
  const auto values = general_eigen(run.coordinates(Z)).values;
  std::vector<double> logs;
  for (const auto& multiplier : values)
    logs.push_back(std::abs(multiplier) > vanished_multiplier ? std::log(std::abs(multiplier)) : -INFINITY);
  std::ranges::sort(logs, std::greater());
  return logs;
}

/// The exponents of a motion that repeats after request.cycle.
void find_cycle_exponents(TangentRun& run, const LyapunovRequest& request, Lyapunov& found) {
  const double latest = found.transient + request.cycle;
  while (run.t() < found.transient || (!run.may_vary() && run.t() < latest))
    if (!run.step(run.t() < found.transient ? found.transient : latest)) {
      found.failure = run.failure();
      return;
    }
  std::vector<std::vector<double>> all;
  for (int b = 0; b < request.batches; ++b) {
    const long before = run.onsets();
    all.push_back(cycle_logs(run, request.cycle));
    if (all.back().empty()) {
      found.failure = run.failure();
      return;
    }
    found.impacts += run.onsets() - before;
  }
  found.batches = request.batches;
  found.duration = request.batches * request.cycle;
  found.unpredicted = "the motion is taken as periodic";
  auto count = all.front().size();
  if (request.exponents > 0) count = std::min(count, static_cast<std::size_t>(request.exponents));
  for (std::size_t i = 0; i < count; ++i) {
    auto& exponent = found.exponents.emplace_back();
    std::vector<double> means;
    for (const auto& logs : all) means.push_back(logs[i] / request.cycle);
    exponent.value = std::accumulate(means.begin(), means.end(), 0.0) / request.batches;
    if (std::isfinite(exponent.value))
      exponent.error = batch_error(means);
    else
      exponent.reason =
          "perturbations vanish within a cycle, to 1e-6 or less: a lasting contact, sticking or an impact "
          "without rebound";
  }
  found.cost = run.cost();
}

void find_exponents(TangentRun& run, const LyapunovRequest& request, double end, Lyapunov& found) {
  if (run.full().empty())
    throw ModelError("", "the drives determine the motion of all bodies: it has no degrees of freedom");
  if (request.cycle > 0) {
    find_cycle_exponents(run, request, found);
    return;
  }
  Spectrum spectrum(run, request.exponents);
  if (!pass_transient(run, spectrum, found.transient, 1e-6 * end)) {
    found.failure = run.failure();
    return;
  }
  std::vector<Sums> ends{spectrum.sums()}, samples;
  const double begin = run.t(), length = (end - begin) / request.batches;
  for (int b = 0; b < request.batches && found.stopped.empty(); ++b) {
    for (int s = 1; s <= samples_of_batch && found.stopped.empty(); ++s) {
      const bool last = b + 1 == request.batches && s == samples_of_batch;
      if (spectrum.advance(last ? end : begin + (b + static_cast<double>(s) / samples_of_batch) * length))
        samples.push_back(spectrum.sums());
      else
        found.stopped = run.failure();
    }
    if (found.stopped.empty()) ends.push_back(samples.back());
  }
  if (static_cast<int>(ends.size()) <= fewest_batches) {
    found.failure = fmt::format("{}; only {} of {} batches are complete", found.stopped, ends.size() - 1,
                                request.batches);
    return;
  }
  const auto order = take_exponents(ends, run, found);
  for (const auto& s : samples) {
    if (s.t > ends.back().t) break;
    auto& point = found.course.emplace_back();
    point.t = s.t;
    for (const auto i : order)
      point.exponents.push_back(mean_growth(ends.front().logs[i], s.logs[i], s.t - begin));
    point.sum = mean_growth(total(ends.front().logs), total(s.logs), s.t - begin);
    if (found.unpredicted.empty())
      point.predicted = (s.predicted() - ends.front().predicted()) / (s.t - begin);
  }
  found.cost = run.cost();
}

}  // namespace

void require_exponents(const Scene& scene, const std::string& formulation) {
  if (family_of(formulation) == Family::nonsmooth && scene.nonsmooth.scheme_in_force() == Scheme::moreau_jean)
    throw ModelError(
        "nonsmooth.scheme",
        "exponents of time stepping are not available; set it to \"event-driven\" or \"automatic\"");
}

Lyapunov lyapunov(const Scene& scene, const LyapunovRequest& request) {
  check(scene, request);
  Simulation simulation(scene, request.formulation, {.start = request.start, .stop = request.stop});
  const auto& given = simulation.scene();
  const System system(given.mechanism);
  const double end = given.run.duration;
  Lyapunov found;
  found.transient = request.transient.value_or(std::max(given.run.discard, 0.1 * end));
  found.period = excitation_of(given.mechanism, system).period;
  TangentRun run(
      {.scene = given, .system = system, .start = simulation.state(), .end = end, .stop = request.stop},
      family_of(request.formulation), {.predict = request.exponents == 0});
  find_exponents(run, request, end, found);
  return found;
}

}  // namespace freeplay
