// Limits of controllers: finds the first time in a step at which the demand of a controller reaches
// its limit, so that the step can end there. With w the demand over the limit, the torque or force
// is min(max(w, −1), 1) times the limit: it has a kink at w = ±1.
//
// The search represents w on the dense output of the step by a polynomial (step_course.hpp), whose
// bounds exclude that a demand crosses a limit and returns unseen. Values within `margin` of ±1, or
// within rounding, belong to neither side: a step that begins at the limit begins on the side that
// the motion enters. There is therefore no state beyond that of the motion. Where the motion on both
// sides leads back to the limit (an integral that stops there), the demand slides along it: a return
// within a thousandth of the step is no crossing, and error control bounds the steps.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "formulations/integrators/crossing.hpp"
#include "formulations/integrators/step_course.hpp"

namespace freeplay {

class Limits {
 public:
  /// Of w, where integrators restart at the crossing.
  static constexpr double rounding = 1e-12;
  struct Crossing {
    int limiter = -1;
    double border = 0;  ///< ±1
    double t = 0;       ///< s
    bool found() const { return limiter >= 0; }
  };
  struct Interval {
    double t_old, t;  ///< s
  };

  /// The first crossing within the last step of `step`, before `before` (s). at(t): the state (q, v,
  /// ..., with the first-order states from `offset` on).
  template <class Step, class At>
  Crossing first(const System& system, int offset, const Step& step, double before, double margin, At at) {
    Crossing found;
    const auto n = static_cast<std::size_t>(system.limiters());
    if (n == 0 || !(step.t > step.t_old)) return found;
    found.t = before;
    samples_.resize(n);
    for (std::size_t k = 0; k <= StepCourse::degree; ++k) {
      const double t = StepCourse::time(step.t_old, step.t, k);
      evaluate(system, offset, t, at(t));
      for (std::size_t i = 0; i < n; ++i) samples_[i][k] = w_[i].share;
    }
    for (std::size_t i = 0; i < n; ++i) {
      const StepCourse course(step.t_old, step.t, samples_[i]);
      if (!std::isfinite(course.bend())) continue;
      const double start = samples_[i].back(), rate = course.rate(step.t_old);
      const double slack = std::max({margin, rounding * course.largest(), noise(w_[i], step.t, rate)});
      for (const auto& end : ends(start, rate, slack)) {
        if (!end.finite()) continue;
        const auto left = [&](double w, double t) {
          return Watched{end.sign * (w - end.border), end.sign * course.rate(t)};
        };
        const auto look = [&](double t) {
          evaluate(system, offset, t, at(t));
          return left(w_[i].share, t);
        };
        auto from = left(start, step.t_old);
        const bool at_limit = std::abs(from.value) <= slack;
        if (at_limit) from.value = 0;
        double unseen = 0;
        const auto t = first_loss(look, step.t_old, step.t, from, left(samples_[i].front(), step.t),
                                  {GapMotion::Shape::straight, 0, course.bend(), 0}, slack, unseen);
        if (!t || (at_limit && *t - step.t_old <= 1e-3 * (step.t - step.t_old))) continue;
        if (*t < found.t) found = {static_cast<int>(i), end.border, *t};
      }
    }
    if (!found.found()) found.t = 0;
    return found;
  }

  /// Ends the last step of `method` at a crossing.
  template <class Method, class F>
  void land(const System& system, int offset, Method& method, F& f, Crossing& c) {
    land_on_gap(method, f, c.t, rounding, [&] {
      const auto i = static_cast<std::size_t>(c.limiter);
      evaluate(system, offset, method.t, method.x);
      const double w = w_[i].share, ahead = 1e-3 * (method.t - method.t_old);
      moved_ = method.x;
      for (std::size_t k = 0; k < moved_.size(); ++k) moved_[k] += ahead * method.dxdt[k];
      evaluate(system, offset, method.t + ahead, moved_);
      return Watched{w - c.border, (w_[i].share - w) / ahead};
    });
  }

 private:
  /// An end of the range of w on one side of a limit.
  struct End {
    int sign;       ///< 1: the lower end, −1: the upper end
    double border;  ///< infinite: none
    bool finite() const { return std::isfinite(border); }
  };
  static std::array<End, 2> ends(double start, double rate, double slack) {
    const bool at_limit = std::abs(std::abs(start) - 1) <= slack;
    if (at_limit ? start * rate <= 0 : std::abs(start) <= 1) return {End{1, -1}, End{-1, 1}};
    const int side = start > 0 ? 1 : -1;
    return {End{side, static_cast<double>(side)}, End{-side, side * std::numeric_limits<double>::infinity()}};
  }
  /// Rounding of w: of its terms, and of the time.
  static double noise(const Saturation& w, double t, double rate) {
    return 8e-16 * (w.terms + std::abs(t * rate));
  }
  void evaluate(const System& system, int offset, double t, const std::vector<double>& x) {
    w_.resize(static_cast<std::size_t>(system.limiters()));
    system.saturations(t, x.data(), x.data() + system.n(), x.data() + offset, w_.data());
  }
  std::vector<Saturation> w_;
  std::vector<double> moved_;
  std::vector<std::array<double, StepCourse::degree + 1>> samples_;
};

}  // namespace freeplay
