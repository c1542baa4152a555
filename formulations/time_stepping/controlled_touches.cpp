// Touches between chosen steps: their search on the path, the step over an impact, hops that are over. Kinks of springs are
// searched likewise.
#include <algorithm>
#include <cmath>

#include "formulations/integrators/crossing.hpp"
#include "formulations/time_stepping/controlled.hpp"

namespace freeplay {

std::optional<ControlledMoreau::Touch> ControlledMoreau::first_touch() {
  std::optional<Touch> first;
  bounded_ = true;
  step_unseen_ = 0;
  const auto take = [&](const std::optional<Touch>& touch) {
    if (touch && (!first || touch->t < first->t)) first = touch;
  };
  const auto half = [&](double a, double b, const double* qa, const double* va, const double* qb,
                        const double* vb) {
    bool enclosed = false;
    for (int k = 0; k < system_.contacts(); ++k) {
      if (moreau_.contacts()[k].closed) continue;
      if (!enclosed) enclose(b - a, qa, va, qb, vb);
      enclosed = true;
      take(touch_in(k, a, b, qa, va, qb, vb));
    }
  };
  half(start_.t, middle_t_, start_.q.data(), start_.v.data(), middle_q_.data(), middle_v_.data());
  if (!first) half(middle_t_, moreau_.t(), middle_q_.data(), middle_v_.data(), moreau_.q(), moreau_.v());
  return first;
}

std::optional<ControlledMoreau::Touch> ControlledMoreau::touch_in(int k, double a, double b, const double* qa,
                                                                  const double* va, const double* qb,
                                                                  const double* vb) {
  ContactRow row;
  const auto at = [&](double t, const double* q, const double* v) {
    system_.place(t, q, e_);
    system_.contact(k, q, v, e_, row);
    return Watched{row.gap, row.normal.dot(v)};
  };
  const auto begin = at(a, qa, va), end = at(b, qb, vb);
  const auto motion = system_.gap_motion(k, bounds_, qb, e_);
  bounded_ = bounded_ && std::isfinite(motion.bend);
  double unseen = 0;
  const double rounding = gap_rounding(system_, k, qb);
  const auto look = [&](double t) {
    interpolate(t, look_q_.data(), look_v_.data());
    return at(t, look_q_.data(), look_v_.data());
  };
  auto start = begin;
  if (start.value <= near(k) && start.rate > 0) start.value = std::max(start.value, 0.0);
  const auto t = first_loss(look, a, b, start, end, motion, rounding, unseen);
  step_unseen_ = std::max(step_unseen_, unseen / system_.contact_facts(k).clearance);
  if (!t) return std::nullopt;
  return Touch{k, *t, look(*t).rate};
}

/// The first time in the step at which a spring's length or angle leaves the piece that it began on. Where it began within the
/// tolerance of a kink, that is the piece that it goes to.
std::optional<double> ControlledMoreau::first_kink() {
  std::optional<double> first;
  const double near = 10 * norm_.tolerance * scales_.length;
  const auto half = [&](double a, double b, const double* qa, const double* va, const double* qb,
                        const double* vb) {
    enclose(b - a, qa, va, qb, vb);
    for (int k = 0; k < system_.phases(); ++k) {
      const auto& phase = system_.phase(k);
      if (phase.swept) continue;
      const double rounding = phase.of == Phase::Of::angle ? 10 * norm_.tolerance : near;
      const auto now = phase.at(start_.q.data(), start_.v.data());
      const auto piece = phase.piece(now.value, now.rate >= 0, rounding);
      for (const bool up : {false, true}) {
        const double end = up ? piece.high : piece.low;
        if (!std::isfinite(end)) continue;
        // A length that dips to zero is no longer than its own kink below it.
        const double least = phase.of == Phase::Of::distance && end < near ? 0.1 * end : rounding;
        const auto left = [&](const double* q, const double* v) {
          const auto x = phase.at(q, v);
          return up ? Watched{end - x.value, -x.rate} : Watched{x.value - end, x.rate};
        };
        double unseen = 0;
        const auto t = first_loss(
            [&](double s) {
              interpolate(s, look_q_.data(), look_v_.data());
              return left(look_q_.data(), look_v_.data());
            },
            a, b, left(qa, va), left(qb, vb), phase.motion(bounds_, piece, up, qb), least, unseen);
        if (t && (!first || *t < *first)) first = t;
      }
    }
  };
  half(start_.t, middle_t_, start_.q.data(), start_.v.data(), middle_q_.data(), middle_v_.data());
  if (!first) half(middle_t_, moreau_.t(), middle_q_.data(), middle_v_.data(), moreau_.q(), moreau_.v());
  return first;
}

/// Of Hermite's cubic, whose accelerations are linear.
void ControlledMoreau::enclose(double h, const double* qa, const double* va, const double* qb,
                               const double* vb) {
  const auto n = static_cast<std::size_t>(system_.n());
  bounds_.duration = h;
  for (std::size_t i = 0; i < n; ++i) {
    const double mean = (qb[i] - qa[i]) / h, a0 = (6 * mean - 4 * va[i] - 2 * vb[i]) / h,
                 a1 = (2 * va[i] + 4 * vb[i] - 6 * mean) / h;
    const auto of = cubic_bounds(h, qa[i], va[i], a0, qb[i], vb[i], a1);
    bounds_.speed[i] = of.speed;
    bounds_.acceleration[i] = of.acceleration;
  }
}

/// Whether the flight of a contact that touches again was a hop that is over.
bool ControlledMoreau::hop_over(const Touch& touch) const {
  const auto& c = moreau_.contacts()[touch.contact];
  const double duration = touch.t - c.t_left;
  if (!(c.t_left > -INFINITY)) return false;  // it has not been struck yet
  const bool low = 0.25 * std::abs(touch.rate) * duration <=
                   norm_.tolerance * system_.contact_facts(touch.contact).clearance;
  return c.restitution < 1 && (low || duration <= 2 * floor_);
}

/// One step over the impact of what is at its touch.
bool ControlledMoreau::strike(double t_end) {
  double approach = scales_.speed;
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = moreau_.contacts()[k];
    if (c.row.normal.size > 0 && c.gap <= near(k))
      approach = std::max(approach, -c.row.normal.dot(moreau_.v()));
  }
  // A raised floor is of the fastest body's pace: a slow touch must not take what moves fast through its walls.
  double h = norm_.tolerance * scales_.length / approach;
  h = std::max(h, std::min({h * raised(), floor_, curve_limit()}));
  h = std::max(h, 16 * 2.3e-16 * std::abs(start_.t));
  smooth_step_ = false;
  for (int tries = 0;; ++tries) {
    const double t = start_.t + h >= t_end ? t_end : start_.t + h;
    if (moreau_.advance(t, MoreauStepper::Reach::all)) break;
    if (tries == 3) return fail();
    ++moreau_.work().rejected;
    moreau_.go_back(start_);
    h *= 10;
  }
  if (const int inside = found_inside(); inside >= 0) return fail_inside(inside);
  if (watching_) {
    smooth_.clear();
    smooth_.add(1, moreau_.smooth());
    within_.clear();
    within_.add(1, moreau_.within());
  }
  striking_ = false;
  ++strikes_;
  const double none = norm_.tolerance * scales_.speed;
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = moreau_.contacts()[k];
    if (c.row.normal.size == 0 || (c.unknown < 0 && !c.closed)) continue;
    const double rate = c.row.normal.dot(moreau_.v()) - 0.5 * (moreau_.t() - start_.t) * c.row.gamma_n;
    if (c.soft && c.unknown >= 0) {
      ++ended_;
      if (c.t_left > -INFINITY) ended_time_ = std::max(ended_time_, moreau_.t() - c.t_left);
    }
    // What was pressed without rebound stays: rates at the impact and at the step's end differ by how its row turns.
    const bool stays = c.last_n > 0 && (c.soft || c.restitution == 0);
    c.soft = false;
    c.closed = (stays || std::abs(rate) <= none) &&
               c.gap <= 2 * near(k) + norm_.tolerance * system_.contact_facts(k).clearance;
    if (!c.closed) c.t_left = moreau_.t();
    calm_since_ = moreau_.t();
  }
  settle();
  keep_pace();
  return true;
}

/// What is left of the step: closed contacts that stand off open, open ones at their touch are struck next.
void ControlledMoreau::settle() {
  moreau_.work().steps = ++steps_;
  if (const double speed = greatest_speed(system_, moreau_.v()); speed > 1.01 * fastest_) {
    fastest_ = speed;
    find_pace();
  }
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = moreau_.contacts()[k];
    if (c.row.normal.size == 0) continue;
    if (c.closed && c.gap <= near(k)) {  // it touches still
      c.t_pressed = moreau_.t();
      if (c.steps == 1) c.steps = 2;
    }
    if (c.closed && c.t_pressed < moreau_.t()) c.closed = false;
    if (!c.closed && c.gap <= near(k) && c.row.normal.dot(moreau_.v()) < 0) striking_ = true;
  }
}

}  // namespace freeplay
