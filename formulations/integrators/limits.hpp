// Limits of controllers: finds the first time in a step at which the demand of a controller reaches
// its limit, so that the step can end there. With w the demand over the limit, the torque or force
// is min(max(w, −1), 1) times the limit: it has a kink at w = ±1.
//
// The search looks at w at eight equal parts of the step, on its dense output. A demand that
// crosses the limit and returns within a part is not found. The evaluated torque is limited in any
// case, so that such a kink adds to the error of the step, which error control bounds. Values
// within `margin` of ±1 belong to neither side: a step that begins at the limit begins on the side
// that the motion enters. There is therefore no state beyond that of the motion.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "formulations/integrators/crossing.hpp"

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
    const auto side = [&](double w) {
      if (std::abs(std::abs(w) - 1) <= margin || std::isnan(w)) return none;
      return w > 1 ? 1 : w < -1 ? -1 : 0;
    };
    last_.assign(n, {});
    found.t = before;
    constexpr int parts = 8;
    for (int k = 0; k <= parts; ++k) {
      const double t = k < parts ? step.t_old + (step.t - step.t_old) * k / parts : step.t;
      if (found.found() || !(t - (step.t - step.t_old) / parts < found.t)) break;
      evaluate(system, offset, t, at(t));
      now_ = w_;
      for (std::size_t i = 0; i < n; ++i) {
        const int here = side(now_[i]);
        if (here == none) continue;
        auto& was = last_[i];
        if (was.side != none && was.side != here) {
          const double border = was.side != 0 ? was.side : here;
          const auto value = [&](double s) {
            evaluate(system, offset, s, at(s));
            return w_[i] - border;
          };
          const double root = bracketed_root(value, was.t, t, was.w - border, now_[i] - border);
          if (root < found.t) found = {static_cast<int>(i), border, root};
        }
        was = {here, t, now_[i]};
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
      const double w = w_[i], ahead = 1e-3 * (method.t - method.t_old);
      moved_ = method.x;
      for (std::size_t k = 0; k < moved_.size(); ++k) moved_[k] += ahead * method.dxdt[k];
      evaluate(system, offset, method.t + ahead, moved_);
      return Watched{w - c.border, (w_[i] - w) / ahead};
    });
  }

 private:
  static constexpr int none = 2;
  struct Seen {
    int side = none;
    double t = 0, w = 0;
  };
  void evaluate(const System& system, int offset, double t, const std::vector<double>& x) {
    w_.resize(static_cast<std::size_t>(system.limiters()));
    system.saturations(t, x.data(), x.data() + system.n(), x.data() + offset, w_.data());
  }
  std::vector<double> w_, now_, moved_;
  std::vector<Seen> last_;
};

}  // namespace freeplay
