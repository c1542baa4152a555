#include "study/wear/wear_cycles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

namespace freeplay {
namespace {

/// Share of the growth of a depth that the passes of WornBearing may leave undetermined.
constexpr double pass_tolerance = 0.01;
/// Classes of loads are made wider until there are no more than these.
constexpr std::size_t most_classes = 240;
/// Relative distance from a limit at which it counts as reached.
constexpr double reached = 1e-3;
constexpr int most_reductions = 80;
/// Further sets of runs, from other starts, before a joint without loads ends the wear.
constexpr int most_idle_sets = 3;
/// Cycles in a row that would have to be shorter than a run before the wear ends.
constexpr int most_short_cycles = 20;
/// Standard errors that count as explained by chance.
constexpr double by_chance = 2;

/// The classes of several starts, in bins of the same number of degrees in both bodies.
class Classes {
 public:
  explicit Classes(int degrees) : degrees_(degrees) {}
  void add(const BearingLoads& start) {
    for (const auto& load : start.loads) {
      if (!(load.work > 0)) continue;
      auto& c = found_[{bin(load.on_bearing), start.merged ? 0 : bin(load.on_journal)}];
      c.work += load.work;
      c.force += load.work * load.force;
      c.bearing.add(load.work, load.on_bearing, load.width_on_bearing);
      c.journal.add(load.work, load.on_journal, load.width_on_journal);
    }
  }
  std::size_t size() const { return found_.size(); }
  /// In the order of the directions on the bearing.
  std::vector<BearingLoad> loads() const {
    std::vector<double> works;
    double sum = 0;
    for (const auto& [key, c] : found_) works.push_back(c.work), sum += c.work;
    std::ranges::sort(works);
    double omitted = 0, least = 0;
    for (const double work : works) {
      if ((omitted += work) > omitted_share * sum) break;
      least = work;
    }
    std::vector<BearingLoad> list;
    for (const auto& [key, c] : found_) {
      if (c.work <= least) continue;
      BearingLoad load;
      load.on_bearing = c.bearing.mean();
      load.on_journal = c.journal.mean();
      load.width_on_bearing = c.bearing.width(c.work);
      load.width_on_journal = c.journal.width(c.work);
      load.force = c.force / c.work;
      load.work = c.work;
      list.push_back(load);
    }
    return list;
  }

 private:
  int bin(double angle) const { return degree_of(angle) / degrees_; }
  /// Directions in one body.
  struct Directions {
    Vec2 sum{};
    double variances = 0;  // sum of those within the classes
    void add(double weight, double angle, double width) {
      sum = sum + weight * Vec2{std::cos(angle), std::sin(angle)};
      variances += weight * width * width / 12;
    }
    double mean() const { return std::atan2(sum.y(), sum.x()); }
    double width(double weight) const { return even_width(sum.norm() / weight, variances / weight); }
  };
  struct Sums {
    Directions bearing, journal;
    double force = 0, work = 0;
  };
  int degrees_;
  std::map<std::pair<int, int>, Sums> found_;
};

/// The classes of these starts, in the narrowest bins that are not too many.
std::vector<BearingLoad> classes_of(const std::vector<const BearingLoads*>& starts) {
  for (const int degrees : {1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 18}) {
    Classes classes(degrees);
    for (const auto* start : starts) classes.add(*start);
    if (classes.size() <= most_classes || degrees == 18) return classes.loads();
  }
  return {};
}

/// Standard error of the mean; 0 for fewer than two values.
double error_of_mean(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  if (values.size() < 2) return 0;
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0;
  for (const double x : values) squares += (x - mean) * (x - mean);
  return std::sqrt(squares / (n - 1) / n);
}

/// The state of the errors of one surface.
struct ErrorSum {
  double closed = 0;         // m², of loads whose cycles have ended
  double open = 0;           // m, half of the growth of the last cycle: the share of the present loads
  double extrapolation = 0;  // m
};

class WearRun {
 public:
  WearRun(std::vector<WornBearing> joints, const WearLimits& limits, double simulated,
          const LoadsOf& loads_of, const std::function<void()>& at_work)
      : limits_(limits),
        simulated_(simulated),
        loads_of_(loads_of),
        at_work_(at_work),
        now_(std::move(joints)) {}

  WearEnd run(const std::function<void(const WearCycle&)>& done) {
    loads_ = loads_of_(now_, sets_++);
    errors_.resize(now_.size());
    squares_.assign(now_.size(), 0.0);
    done(cycle());
    std::optional<double> next;  // turns
    for (;;) {
      if (const auto end = ended()) return *end;
      for (int again = 0; idle() && again < most_idle_sets; ++again) loads_ = loads_of_(now_, sets_++);
      if (idle()) return WearEnd::no_load;
      const double left = limits_.turns - turns_;
      double length = std::min({next.value_or(first_length()), limits_.longest, left});
      // No short last cycle, whose growth would be within the deviations that the passes leave.
      if (length < left && left < 2 * length) length = 0.5 * left;
      const double change = advance(length);
      const double factor = std::clamp(0.9 * limits_.share / std::max(change, 1e-12), 0.2, 4.0);
      next = std::max(length * factor, factor < 1 ? std::min(simulated_, length) : 0.0);
      short_ = factor < 1 && length <= simulated_ && limits_.longest > simulated_ ? short_ + 1 : 0;
      if (short_ == most_short_cycles)
        throw WearStopped(fmt::format(
            "wear cannot be extrapolated after {:.4g} turns: in {} cycles in a row the loads or depths "
            "change by more than share = {:g} within the {:.4g} turns of a run; use more starts or "
            "revolutions, smaller steps of the scene, or longest = {:.4g} (no extrapolation)",
            turns_, short_, limits_.share, simulated_, std::max(1.0, simulated_)));
      if (!accepted_) continue;
      done(cycle());
    }
  }

 private:
  /// Worn by the loads of `share` turns; the loads are sums over `turns`.
  WornBearing worn_by(WornBearing bearing, const std::vector<BearingLoad>& loads, double turns,
                      double share) const {
    if (at_work_) at_work_();
    bearing.wear(loads, share / turns, pass_tolerance);
    return bearing;
  }

  /// Whether no joint is loaded while it slides.
  bool idle() const {
    return std::ranges::all_of(loads_, [](const TurnLoads& l) { return !(l.work > 0); });
  }

  std::optional<WearEnd> ended() const {
    if (turns_ >= limits_.turns * (1 - 1e-12)) return WearEnd::turns;
    for (const auto& j : now_) {
      if (std::max(j.greatest_bearing(), j.greatest_journal()) >= limits_.depth * (1 - reached))
        return WearEnd::depth;
      const double nominal = j.joint().foundation.clearance;
      if (j.measured_clearance() >= limits_.clearance - reached * (limits_.clearance - nominal))
        return WearEnd::clearance;
    }
    return {};
  }

  /// Turns after which the area is that of an arc of 1 rad with the greatest permitted depth.
  double first_length() const {
    double length = WearLimits::none;
    for (std::size_t j = 0; j < now_.size(); ++j) {
      const auto& facts = now_[j].joint();
      const auto& f = facts.foundation;
      const double rate = std::max(facts.bearing, facts.journal) * loads_[j].work / f.length;
      if (rate > 0)
        length = std::min(length, limits_.share * now_[j].greatest_clearance() * f.bearing_radius / rate);
    }
    return length;
  }

  /// Greatest permitted growth over that of `to`; at least 1 if it is permitted.
  double permitted(const std::vector<WornBearing>& to) const {
    double least = WearLimits::none;
    const auto limit = [&](double growth, double most) {
      if (growth > 0) least = std::min(least, most / growth);
    };
    for (std::size_t j = 0; j < now_.size(); ++j) {
      const double before_b = now_[j].greatest_bearing(), before_j = now_[j].greatest_journal();
      const double b = to[j].greatest_bearing() - before_b, journal = to[j].greatest_journal() - before_j;
      for (const auto& [growth, before] : {std::pair(b, before_b), std::pair(journal, before_j)}) {
        limit(growth, limits_.share * now_[j].greatest_clearance());
        limit(growth, limits_.depth - before);
      }
      const double c = now_[j].measured_clearance();
      if (limits_.clearance < WearLimits::none) limit(to[j].measured_clearance() - c, limits_.clearance - c);
    }
    return least;
  }

  /// The predictor, with fewer turns if the growth exceeds what is permitted.
  std::vector<WornBearing> predict(double& length) {
    for (int i = 0;; ++i) {
      std::vector<WornBearing> to;
      halfway_.clear();
      try {
        // In two halves, as the corrector: their difference is that of the loads.
        for (std::size_t j = 0; j < now_.size(); ++j) {
          const auto wear = [&](const WornBearing& from) {
            return worn_by(from, loads_[j].loads, loads_[j].turns, 0.5 * length);
          };
          halfway_.push_back(wear(now_[j]));
          to.push_back(wear(halfway_[j]));
        }
        const double share = permitted(to);
        if (share >= 1 - 0.5 * reached || i == most_reductions) return to;
        length *= std::clamp(share, 0.1, 1 - 0.01 * reached);
      } catch (const NoEquilibrium&) {
        if (i == most_reductions) throw;
        length *= 0.25;
      }
    }
  }

  /// Half of the relative difference of the growth of the greatest depth by even and odd starts.
  double scatter(std::size_t j, double length) const {
    const auto& l = loads_[j];
    if (l.even.empty() || l.odd.empty()) return 0;
    double difference = 0, sum = 0;
    const auto even = worn_by(now_[j], l.even, l.even_turns, length),
               odd = worn_by(now_[j], l.odd, l.odd_turns, length);
    const auto add = [&](double before, double a, double b) {
      difference = std::max(difference, std::abs(a - b));
      sum = std::max(sum, a + b - 2 * before);
    };
    add(now_[j].greatest_bearing(), even.greatest_bearing(), odd.greatest_bearing());
    add(now_[j].greatest_journal(), even.greatest_journal(), odd.greatest_journal());
    return sum > 0 ? difference / sum : 0;
  }

  /// Standard error of the growth of the greatest depth by loads of this joint, relative.
  double relative_error(std::size_t j, const TurnLoads& l) const {
    const double of_work = l.work > 0 ? l.error / l.work : 0;
    return std::max(of_work, counted_ > 0 ? std::sqrt(squares_[j] / counted_) : 0.0);
  }

  /// Makes a cycle and returns the change of the rates. Sets accepted_.
  double advance(double& length) {
    const auto predicted = predict(length);
    const auto following = loads_of_(predicted, sets_++);
    std::vector<WornBearing> corrected;
    std::vector<double> splits;
    try {
      for (std::size_t j = 0; j < now_.size(); ++j) {
        corrected.push_back(worn_by(halfway_[j], following[j].loads, following[j].turns, 0.5 * length));
        splits.push_back(scatter(j, length));
      }
    } catch (const NoEquilibrium&) {
      if (length <= simulated_) throw;
      accepted_ = false;
      return WearLimits::none;
    }
    double change = 0;
    const auto growth = [&](std::size_t j, const std::vector<WornBearing>& to,
                            double (WornBearing::*depth)()
                                const) { return (to[j].*depth)() - (now_[j].*depth)(); };
    for (std::size_t j = 0; j < now_.size(); ++j) {
      const auto &a = loads_[j], &b = following[j];
      const double mean = 0.5 * (a.work + b.work);
      if (mean > 0)
        change =
            std::max(change, (std::abs(b.work - a.work) - by_chance * std::hypot(a.error, b.error)) / mean);
      const double chance = by_chance * std::hypot(relative_error(j, a), relative_error(j, b));
      for (auto depth : {&WornBearing::greatest_bearing, &WornBearing::greatest_journal})
        if (const double grown = growth(j, corrected, depth); grown > 0)
          change = std::max(change, 2 * std::abs(grown - growth(j, predicted, depth)) / grown - chance);
    }
    accepted_ = change <= 2 * limits_.share || length <= simulated_;
    if (!accepted_) return change;
    ++counted_;
    for (std::size_t j = 0; j < now_.size(); ++j) {
      squares_[j] += splits[j] * splits[j];
      const double error = relative_error(j, loads_[j]), next = relative_error(j, following[j]);
      const auto add = [&](ErrorSum& sum, double grown, double first) {
        const double share = sum.open + 0.5 * grown;
        sum.closed += share * share * error * error;
        sum.open = 0.5 * grown;
        sum.extrapolation +=
            std::max(0.0, std::abs(grown - first) - 0.5 * by_chance * grown * std::hypot(error, next));
      };
      for (int side = 0; side < 2; ++side) {
        const auto depth = side == 0 ? &WornBearing::greatest_bearing : &WornBearing::greatest_journal;
        add(errors_[j][static_cast<std::size_t>(side)], growth(j, corrected, depth),
            growth(j, predicted, depth));
      }
    }
    now_ = std::move(corrected);
    loads_ = following;
    turns_ += length;
    length_ = length;
    ++number_;
    return change;
  }

  WearCycle cycle() const {
    WearCycle c{number_, turns_, length_, {}};
    for (std::size_t j = 0; j < now_.size(); ++j) {
      const double error = relative_error(j, loads_[j]);
      const auto depth = [&](double value, const ErrorSum& sum) {
        return WornDepth{value, std::sqrt(sum.closed + sum.open * sum.open * error * error),
                         sum.extrapolation};
      };
      c.joints.push_back({now_[j], depth(now_[j].greatest_bearing(), errors_[j][0]),
                          depth(now_[j].greatest_journal(), errors_[j][1]), loads_[j].work, loads_[j].error});
    }
    return c;
  }

  const WearLimits& limits_;
  double simulated_;
  const LoadsOf& loads_of_;
  const std::function<void()>& at_work_;
  std::vector<WornBearing> now_, halfway_;  // halfway: after half of the predictor
  std::vector<TurnLoads> loads_;
  std::vector<std::array<ErrorSum, 2>> errors_;  // of bearing and journal
  std::vector<double> squares_;                  // sums of the squares of scatter()
  int counted_ = 0, sets_ = 0, number_ = 0, short_ = 0;
  double turns_ = 0, length_ = 0;
  bool accepted_ = true;
};

}  // namespace

TurnLoads united(const std::vector<BearingLoads>& starts, double turns) {
  TurnLoads all;
  std::vector<const BearingLoads*> every, halves[2];
  std::vector<double> means, of_turns;
  double work = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    double own = 0;
    for (const auto& load : starts[i].loads) own += load.work;
    work += own;
    means.push_back(own / turns);
    of_turns.insert(of_turns.end(), starts[i].work_of_turns.begin(), starts[i].work_of_turns.end());
    every.push_back(&starts[i]);
    halves[i % 2].push_back(&starts[i]);
    (i % 2 == 0 ? all.even_turns : all.odd_turns) += turns;
  }
  all.loads = classes_of(every);
  if (starts.size() > 1) all.even = classes_of(halves[0]), all.odd = classes_of(halves[1]);
  all.turns = turns * static_cast<double>(starts.size());
  all.work = all.turns > 0 ? work / all.turns : 0;
  all.error = std::max(error_of_mean(means), error_of_mean(of_turns));
  return all;
}

WearEnd wear_cycles(std::vector<WornBearing> joints, const WearLimits& limits, double simulated,
                    const LoadsOf& loads_of, const std::function<void(const WearCycle&)>& done,
                    const std::function<void()>& at_work) {
  return WearRun(std::move(joints), limits, simulated, loads_of, at_work).run(done);
}

}  // namespace freeplay
