#include "simulation/section.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dynamics/phase.hpp"
#include "numerics/bracketed_root.hpp"

namespace freeplay {
namespace {

constexpr double turn = 2 * std::numbers::pi;
/// Steps for which an onset may wait to become final: four durations of the elastic impact, each of
/// some tens of steps.
constexpr std::size_t most_places = 8192;

/// Within (−π, π].
double wrapped(double angle) {
  const double x = std::remainder(angle, turn);
  return x <= -std::numbers::pi ? x + turn : x;
}

/// Phase in the period, in [0, 1).
double phase_of(double t, double period) {
  const double x = std::fmod(t, period) / period;
  return x < 0 ? x + 1 : x;
}

double difference(const StateColumn& c, std::span<const double> x) {
  const auto of = [&](int i) { return i >= 0 ? x[static_cast<std::size_t>(i)] : 0.0; };
  return of(c.first) - of(c.second);
}

/// Index of the side of the value: below or above it; for an angle, the number of the turn.
double side(const SectionRule& rule, double s) {
  if (rule.what.angle) return std::floor(s / turn);
  return s < 0 ? -1 : 0;
}

}  // namespace

double StateColumn::circle() const { return kind == Kind::phase ? 1 : angle ? turn : 0; }

double StateColumn::coordinate(std::span<const double> q, std::span<const double> v) const {
  return travel ? travel->place_at(q.data(), v.data()).value : difference(*this, q);
}
double StateColumn::rate(std::span<const double> q, std::span<const double> v) const {
  return travel ? travel->place_at(q.data(), v.data()).rate : difference(*this, v);
}

SectionPoints::SectionPoints(SectionRule rule, std::vector<StateColumn> columns, double discard)
    : rule_(std::move(rule)), columns_(std::move(columns)), discard_(discard) {
  using Kind = StateColumn::Kind;
  for (const auto& c : columns_)
    wants_contacts_ |= c.kind == Kind::ex || c.kind == Kind::ey || c.kind == Kind::gap ||
                       c.kind == Kind::ex_c || c.kind == Kind::ey_c;
}

void SectionPoints::begin(const Layout& layout, const State& state) {
  begin_ = state.t;
  q_ = state.q;
  v_ = state.v;
  contacts_.resize(layout.contacts.size());
  last_ = distance(state.q, state.v);
  newest_ = -1;
  touches_.clear();
  if (rule_.kind == SectionRule::Kind::touch && places_.empty()) places_.resize(most_places);
  if (rule_.kind == SectionRule::Kind::touch) {  // start of the first step
    auto& p = places_[0];
    p = {state.t, false, state.q, state.v};
    newest_ = 0;
  }
  if (rule_.kind != SectionRule::Kind::period) return;
  index_ = std::max(0L, static_cast<long>(std::floor((begin_ - rule_.from) / rule_.period)) - 1);
  while (rule_.from + static_cast<double>(index_) * rule_.period <= begin_) ++index_;
}

void SectionPoints::step(const Step& step) {
  switch (rule_.kind) {
    case SectionRule::Kind::period:
      return each_period(step);
    case SectionRule::Kind::crossing:
      return crossings(step);
    case SectionRule::Kind::touch:
      settle_touches(step);
      return keep_place(step);
  }
}

void SectionPoints::each_period(const Step& step) {
  for (;; ++index_) {
    const double t = rule_.from + static_cast<double>(index_) * rule_.period;
    if (t > step.t1) return;
    point(step, std::max(t, step.t0));
  }
}

double SectionPoints::distance(std::span<const double> q, std::span<const double> v) const {
  return rule_.what.coordinate(q, v) - rule_.value;
}
double SectionPoints::distance_at(const Step& step, double t) {
  step.state(t, q_, v_);
  return distance(q_, v_);
}

void SectionPoints::crossings(const Step& step) {
  const double before = last_;
  last_ = distance_at(step, step.t1);
  const double r1 = rule_.what.rate(q_, step.v1);
  if (rule_.what.travel) step.state(step.t0, q_, v_);  // its rate depends on the positions
  const double r0 = rule_.what.rate(q_, step.v0);
  // Both ends are on one side, but the rates have opposite signs: s may have crossed the value and
  // returned.
  if (side(rule_, before) == side(rule_, last_) && r0 * r1 < 0 && step.t1 > step.t0) {
    const auto rate_at = [&](double t) {
      step.state(t, q_, v_);
      return rule_.what.rate(q_, v_);
    };
    const double a = rate_at(step.t0), b = rate_at(step.t1);
    if (a * b < 0) {
      const double middle = bracketed_root(rate_at, step.t0, step.t1, a, b);
      const double s = distance_at(step, middle);
      cross(step, step.t0, middle, before, s);
      cross(step, middle, step.t1, s, last_);
      return;
    }
  }
  cross(step, step.t0, step.t1, before, last_);
}

/// The crossings between two instants of a step, between which s is monotonic.
void SectionPoints::cross(const Step& step, double a, double b, double s_a, double s_b) {
  const double from = side(rule_, s_a), to = side(rule_, s_b);
  if (from == to || !std::isfinite(from) || !std::isfinite(to)) return;
  const bool rises = to > from;
  using Direction = SectionRule::Direction;
  if (rule_.direction != Direction::either && rises != (rule_.direction == Direction::upwards)) return;
  for (double k = rises ? from + 1 : from; rises ? k <= to : k > to; k += rises ? 1 : -1) {
    const double level = rule_.what.angle ? k * turn : 0;
    const auto f = [&](double t) { return distance_at(step, t) - level; };
    const double f_a = f(a), f_b = f(b);
    double at = f_a == 0 ? a : b;
    if (f_a * f_b < 0) {
      at = bracketed_root(f, a, b, f_a, f_b, {51, 100});
    } else if (f_a * f_b > 0) {
      at = a;  // a projection between two steps moved it across
    }
    point(step, at);
  }
}

void SectionPoints::event(const Event& event) {
  if (rule_.kind != SectionRule::Kind::touch || event.kind == EventKind::separation) return;
  if (!rule_.contacts.empty() && std::ranges::find(rule_.contacts, event.contact) == rule_.contacts.end())
    return;
  if (event.t > begin_) touches_.push_back(event);
}

void SectionPoints::keep_place(const Step& step) {
  auto& p = places_[static_cast<std::size_t>(++newest_) % places_.size()];
  p.t = step.t1;
  p.in_impact = !step.in_impact().v.empty();
  p.q.resize(q_.size());
  p.v.resize(v_.size());
  step.state(step.t1, p.q, p.v);
}

/// Processes onsets up to the end of this step. Events become final before the step that makes them
/// so is shown.
void SectionPoints::settle_touches(const Step& step) {
  std::size_t done = 0;
  for (; done < touches_.size(); ++done) {
    const auto& e = touches_[done];
    if (e.t > step.t1) break;
    if (e.t <= place(newest_).t) {
      if (touched(e.t))
        keep(step, e.t, -e.v_n_minus);
      else
        ++lost_;
      continue;
    }
    // Within this step: the step contains impacts, or ends a sequence of them.
    const double share = step.t1 > step.t0 ? (e.t - step.t0) / (step.t1 - step.t0) : 0;
    step.state(step.t1, q_, v_);
    const auto& p = place(newest_);
    for (std::size_t i = 0; i < q_.size(); ++i) q_[i] = p.q[i] + share * (q_[i] - p.q[i]);
    v_.assign(step.v0.begin(), step.v0.end());
    keep(step, e.t, -e.v_n_minus);
  }
  touches_.erase(touches_.begin(), touches_.begin() + static_cast<long>(done));
}

/// Puts the state at a past time into q_ and v_; returns false if it is no longer stored.
bool SectionPoints::touched(double t) {
  const long oldest = std::max(0L, newest_ - static_cast<long>(places_.size()) + 1);
  long low = oldest, high = newest_;  // search for the first place not before t
  while (low < high) {
    const long middle = low + (high - low) / 2;
    if (place(middle).t < t)
      low = middle + 1;
    else
      high = middle;
  }
  const auto& p = place(low);
  const double rounding = 1e-12 * std::abs(t);
  if (!p.in_impact && p.t - t <= rounding) {  // a step ended at t
    q_ = p.q;
    v_ = p.v;
    return true;
  }
  if (low == oldest) return false;
  const auto& o = place(low - 1);
  const double h = p.t - o.t, s = h > 0 ? (t - o.t) / h : 0;
  v_ = o.v;
  for (std::size_t i = 0; i < q_.size(); ++i) {
    q_[i] = o.q[i] + s * (p.q[i] - o.q[i]);
    if (!p.in_impact) v_[i] += s * (p.v[i] - o.v[i]);
  }
  return true;
}

void SectionPoints::point(const Step& step, double t) {
  if (t < discard_) return;
  step.state(t, q_, v_);
  keep(step, t, std::nan(""));
}

/// Stores the columns of the state in q_ and v_.
void SectionPoints::keep(const Step& step, double t, double approach) {
  if (t < discard_) return;
  if (t_.size() == most) {
    ++beyond_;
    return;
  }
  if (wants_contacts_) step.contacts(t, q_, contacts_);
  t_.push_back(t);
  for (const auto& c : columns_) {
    const auto contact = [&]() -> const ContactPlace& {
      return contacts_[static_cast<std::size_t>(c.first)];
    };
    double x = approach;
    switch (c.kind) {
      case StateColumn::Kind::coordinate:
        x = c.coordinate(q_, v_);
        if (c.angle) x = wrapped(x);
        break;
      case StateColumn::Kind::rate:
        x = c.rate(q_, v_);
        break;
      case StateColumn::Kind::ex:
        x = contact().ex;
        break;
      case StateColumn::Kind::ey:
        x = contact().ey;
        break;
      case StateColumn::Kind::gap:
        x = contact().gap;
        break;
      case StateColumn::Kind::ex_c:
        x = contact().ex / (contact().gap + std::hypot(contact().ex, contact().ey));
        break;
      case StateColumn::Kind::ey_c:
        x = contact().ey / (contact().gap + std::hypot(contact().ex, contact().ey));
        break;
      case StateColumn::Kind::phase:
        x = phase_of(t, rule_.period);
        break;
      case StateColumn::Kind::approach:
        break;
    }
    rows_.push_back(x);
  }
}

}  // namespace freeplay
