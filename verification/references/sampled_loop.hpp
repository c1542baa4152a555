// A mass m under a constant force F and a sampled controller with zero-order hold, in closed form from
// instant to instant. At t_k = k h
//
//     e_k = r(t_k) − y_k,    y_k the position, rounded to multiples of the resolution
//     u_k = k_p e_k + k_d (e_k − e_{k−1})/h + k_i z_k,     e_{−1} = e_0, z_0 = 0
//     z_{k+1} = z_k + h e_k − h (u_k − sat u_k)/(k_i T)
//
// and sat u_k acts from t_k + dead time on. Between instants, with the acting output s and a lag τ,
//
//     m ẍ = F + M,     τ Ṁ = s − M:     M = s + (M₀ − s) e^{−t/τ}
//
// Source: the law of sampled control as in Åström and Wittenmark, Computer-Controlled Systems, 3rd ed.
// (1997), sec. 8.5. No solver of the program is included. Units: those of x (m or rad), kg or kg m², s.
#pragma once

#include <cmath>
#include <deque>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "verification/references/one_coordinate.hpp"

namespace freeplay::reference {

struct SampledLoop {
  double mass = 1, force = 0;
  double proportional = 1, derivative = 0, integral = 0;
  std::optional<double> limit = {}, lag = {}, tracking = {}, resolution = {};
  double sampling = 1, dead = 0;  ///< s
  std::function<double(double)> target;
  double x = 0, v = 0;  ///< at t = 0

  OneCoordinate::Rows at(const std::vector<double>& instants, const Change& change = {}) const {
    OneCoordinate::Rows rows;
    double t = 0, p = x + change.x, rate = v + change.v, M = 0, acting = 0, z = 0, last = 0;
    const double scale = (1 + change.load) / mass;
    std::deque<std::pair<double, double>> waiting;  // instant and output
    long k = 0;
    const auto go = [&](double until) {
      const double h = until - t;
      t = until;
      if (!lag) {
        const double a = scale * (force + acting);
        p += h * rate + 0.5 * h * h * a, rate += h * a;
        return;
      }
      const double T = *lag, fall = -std::expm1(-h / T), off = M - acting, a = scale * (force + acting);
      p += h * rate + 0.5 * h * h * a + scale * off * T * (h - T * fall);
      rate += h * a + scale * off * T * fall;
      M -= off * fall;
    };
    const auto sample = [&] {
      const double y = resolution ? *resolution * std::round(p / *resolution) : p;
      const double e = target(t) - y, before = k == 0 ? e : last;
      const double u = proportional * e + derivative * (e - before) / sampling + integral * z;
      const double held = limit ? std::fmax(-*limit, std::fmin(*limit, u)) : u;
      z += sampling * e;
      if (integral > 0 && limit) {
        const double T = tracking.value_or(proportional / integral);
        z -= sampling * (u - held) / (integral * T);
      }
      last = e;
      waiting.emplace_back(static_cast<double>(k) * sampling + dead, held);
      ++k;
    };
    for (const double until : instants) {
      for (;;) {
        const double next = static_cast<double>(k) * sampling,
                     change_at = waiting.empty() ? INFINITY : waiting.front().first;
        if (std::fmin(next, change_at) > until) break;
        if (next <= change_at) {
          go(next), sample();
        } else {
          go(change_at);
          acting = waiting.front().second;
          waiting.pop_front();
        }
      }
      go(until);
      rows.x.push_back(p), rows.v.push_back(rate);
      ++rows.known;
    }
    return rows;
  }
};

}  // namespace freeplay::reference
