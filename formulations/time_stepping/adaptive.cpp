#include "formulations/time_stepping/adaptive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/planar.hpp"
#include "formulations/integrators/crossing.hpp"
#include "formulations/integrators/curve_limit.hpp"
#include "simulation/force_integral.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {

AdaptiveMoreau::AdaptiveMoreau(const System& system, MoreauStepper moreau, const ErrorNorm& norm,
                               const Scales& scales,
                               std::function<std::unique_ptr<EventDynamics>()> equations)
    : system_(system),
      moreau_(std::move(moreau)),
      tolerance_(norm.tolerance),
      scales_(scales),
      pair_(system, norm, scales.speed),
      peaks_(system),
      search_(system, norm.tolerance, scales.length),
      pace_(norm.tolerance, scales),
      h_(first_step()),
      equations_(std::move(equations)) {
  moreau_.contacts().slack = 0.1 * norm.tolerance * scales.length;
}

void AdaptiveMoreau::start(const State& state, ContactLog& log) {
  moreau_.start(state, log);
  pair_.start.t = state.t;
  double film_rate = 0;
  for (int k = 0; scales_.guessed && k < system_.contacts(); ++k)
    for (const int body : system_.contact_facts(k).bodies)
      if (system_.contact_facts(k).lubricant && body != ground)
        film_rate = std::max(film_rate, std::abs(planar::rate(state.v.data(), body)));
  pace_.start(state.t, greatest_speed(system_, state.v.data()), film_rate, moreau_.extremes().gains);
  calm_since_ = state.t;
  auto e = system_.make_evaluation();
  system_.place(state.t, state.q.data(), e);
  impacting_ = false;
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = contact(k);
    c.t_left = -INFINITY;
    system_.contact(k, state.q.data(), state.v.data(), e, c.row);
    if (c.row.normal.size == 0 || c.gap > near(k)) continue;
    const double rate = c.row.normal.dot(state.v.data()), none = tolerance_ * scales_.speed;
    impacting_ = impacting_ || rate < -none;
    c.closed = std::abs(rate) <= none;
  }
}

void AdaptiveMoreau::take_over(const Handover& from, ContactLog& log) {
  start(from.state, log);
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = contact(k);
    const auto& was = from.contacts[static_cast<std::size_t>(k)];
    c.closed = was.closed && c.row.normal.size > 0;
    c.steps = was.logged ? 2 : 0;
    c.t_onset = was.t_onset;
    c.t_pressed = from.state.t;
    c.impulse_n = was.impulse_n;
    c.impulse_t = was.impulse_t;
    c.u_n_plus = c.row.normal.dot(from.state.v.data());
    c.u_t_plus = c.row.tangent.dot(from.state.v.data());
  }
  auto& totals = moreau_.totals();
  totals.integrals = from.integrals;
  totals.extremes = from.extremes;
  totals.work = from.work;
  steps_ = from.work.steps;
  h_ = first_step();
  pace_.floor = pace_.least_floor;
}

Handover AdaptiveMoreau::hand_over() {
  Handover to;
  to.state = {t(), {q(), q() + system_.n()}, {v(), v() + system_.n()}, {z().begin(), z().end()}};
  moreau_.leave_all_open();
  for (const auto& c : moreau_.contacts().all()) {
    Handover::Contact was{c.closed, c.steps > 0};
    if (was.logged) {  // otherwise the impulses are of a contact that has ended
      was.t_onset = c.t_onset;
      was.impulse_n = c.impulse_n;
      was.impulse_t = c.impulse_t;
    }
    to.contacts.push_back(was);
  }
  to.integrals = integrals();
  to.extremes = extremes();
  to.work = work();
  return to;
}

void AdaptiveMoreau::interpolate(double t, double* q, double* v) const {
  if (smooth_step_) return pair_.interpolate(moreau_, t, q, v);
  const auto& start = pair_.start;
  const double h = moreau_.t() - start.t, s = h > 0 ? (t - start.t) / h : 1;
  for (int i = 0; i < system_.n(); ++i) {
    q[i] = start.q[i] + s * (moreau_.q()[i] - start.q[i]);
    v[i] = start.v[i] + s * (moreau_.v()[i] - start.v[i]);
  }
}

void AdaptiveMoreau::watch_forces(bool on) {
  pair_.watch_forces(on);
  moreau_.watch_forces(on);
  if (!on || shown_) return;
  shown_ = equations_();
  x_.resize(static_cast<std::size_t>(shown_->size()));
  scratch_ = integrated_ = system_.make_forces();
  // With all rows in use, which allocates their memory.
  std::copy_n(q(), system_.n(), x_.begin());
  std::copy_n(v(), system_.n(), x_.begin() + system_.n());
  std::ranges::copy(z(), x_.begin() + shown_->state_offset());
  shown_->take_mode(x_, std::vector<signed char>(shown_->contacts.size() + shown_->preloaded.size(), 1));
  shown_->report(x_, t(), scratch_);
}

/// Forces of a smooth step in its mode at t. Returns false if the equations of the mode have no solution.
bool AdaptiveMoreau::report(double t, Forces& out) {
  auto& d = *shown_;
  if (pair_.modes(t).size() != d.contacts.size() + d.preloaded.size())
    return false;  // no step since a restart
  const double h = this->t() - t_old(), share = h > 0 ? (t - t_old()) / h : 1;
  interpolate(t, x_.data(), x_.data() + system_.n());
  for (std::size_t k = 0; k < pair_.start.z.size(); ++k)
    x_[static_cast<std::size_t>(d.state_offset()) + k] =
        pair_.start.z[k] + share * (z()[k] - pair_.start.z[k]);
  d.take_mode(x_, pair_.modes(t));
  // A jump of a prescribed acceleration at the end belongs to the next step.
  if (system_.has_motions()) d.knot = std::nextafter(this->t(), t_old());
  const long unsolved = d.counts.unreported;
  d.report(x_, t, out);
  return d.counts.unreported == unsolved;
}

void AdaptiveMoreau::forces(double t, Forces& out) {
  if (shown_ && smooth_step_ && report(t, out)) return;
  out.clear();
  if (this->t() > t_old()) out.add(1 / (this->t() - t_old()), pair_.smooth);
}

void AdaptiveMoreau::add_impulse(double a, double b, Forces& sum) {
  if (!(b > a)) return;
  const double share = (b - a) / (t() - t_old());
  sum.add(share, pair_.smooth);
  if (!shown_ || !smooth_step_ || !(share < 1 - 1e-12)) return;
  // The impulse of the whole step is that of its contact problem; the forces distribute it.
  const auto integrate = [&](double from, double to, Forces& out) {
    const double middle = std::clamp(pair_.middle_t, from, to);
    integrate_forces(*this, from, middle, scratch_, out);
    integrate_forces(*this, middle, to, scratch_, out);
  };
  if (integrated_at_ != t()) {
    integrated_.clear();
    integrate(t_old(), t(), integrated_);
    integrated_at_ = t();
  }
  sum.add(-share, integrated_);
  integrate(a, b, sum);
}

/// Returns a contact that penetrates too deep, and did not at the beginning of the step; −1: none.
int AdaptiveMoreau::found_inside() const {
  for (int k = 0; k < system_.contacts(); ++k) {
    const double most = -too_deep * system_.contact_facts(k).clearance;
    if (moreau_.contacts()[k].gap < most && pair_.start.contacts[static_cast<std::size_t>(k)].gap >= most)
      return k;
  }
  return -1;
}

bool AdaptiveMoreau::fail_inside(int contact) {
  return fail(fmt::format(
      "t = {:.9g} s: penetration at {} reaches {:.2g} clearances in any step, however short; use a smaller "
      "nonsmooth.step_tolerance",
      moreau_.t(), system_.contact_facts(contact).name,
      -moreau_.contacts()[contact].gap / system_.contact_facts(contact).clearance));
}

/// s: upper limit of a step from here, for the curves that it reads.
double AdaptiveMoreau::curve_limit() const {
  const auto& start = pair_.start;
  return curve_step_limit(system_, start.t, start.q.data(), start.v.data(), Knots::passed);
}

bool AdaptiveMoreau::step(double t_end) {
  auto& start = pair_.start;
  integrated_at_ = NAN;
  moreau_.keep(start);
  const double usual = pace_.far_exceeded();
  const auto gains = moreau_.extremes().gains;
  if (pace_.runs_away(gains) || (usual > 0 && gains > 0))
    return fail(fmt::format(
        "t = {:.9g} s: impacts increased a speed from {:.2g} m/s to {:.2g} m/s: Newton's impact law with "
        "friction can increase energy; try nonsmooth.impact_law = \"energetic\"",
        start.t, usual > 0 ? usual : pace_.calm_speed, pace_.fastest));
  if (usual > 0)
    return fail(fmt::format(
        "t = {:.9g} s: a speed reaches {:.2g} m/s in a mechanism that moves at {:.2g} m/s: a drive moves it "
        "beyond the configuration in which it locks (see freeplay check)",
        start.t, pace_.fastest, usual));
  // If only rounding separates the state from the next kink or end, time advances without a step.
  const double rounding = std::max(16 * 2.3e-16 * std::abs(start.t), 1e-14 * first_step());
  if (t_end - start.t <= rounding) {
    start.t = t_end;
    moreau_.go_back(start);
    smooth_step_ = false;
    return true;
  }
  return impacting_ ? impact_step(t_end) : smooth_step(t_end, rounding);
}

bool AdaptiveMoreau::smooth_step(double t_end, double rounding) {
  const double from = pair_.start.t;
  // No step crosses a kink of a curve in time or passes over a feature of a curve.
  const double end = std::min({t_end, system_.next_knot(from + rounding),
                               from + longest_step(system_, moreau_.v()), from + curve_limit()});
  Attempt a{end, rounding, std::min(h_, end - from)};
  if (!(a.h > 1e-14 * first_step()) && end < t_end)
    return fail(fmt::format(
        "t = {:.9g} s: the steps have shrunk to {:.2g} s: the motion is singular there, or too fast to be "
        "resolved",
        from, a.h));
  smooth_step_ = true;
  for (int tries = 0; tries <= 200; ++tries)
    if (const auto outcome = attempt(a, t_end); outcome != Outcome::again)
      return outcome == Outcome::accepted;
  return fail(
      fmt::format("t = {:.9g} s: every step is rejected, however small: the motion may be singular there, "
                  "or nonsmooth.step_tolerance is below rounding error",
                  from));
}

/// Rejects the attempt, for a new one of `shorter` (s).
void AdaptiveMoreau::refuse(Attempt& a, double shorter) {
  moreau_.go_back(pair_.start);
  ++moreau_.totals().work.rejected;
  a.h = std::min(shorter, a.end - pair_.start.t);
}

AdaptiveMoreau::Outcome AdaptiveMoreau::attempt(Attempt& a, double t_end) {
  const auto& start = pair_.start;
  const double h = a.h;
  const bool last = h >= a.end - start.t;
  double floor = std::max(pace_.floor, a.least);
  const auto shorten = [&](double shorter) {
    refuse(a, shorter);
    h_ = a.h;
    return Outcome::again;
  };
  if (!pair_.take(moreau_, h)) {
    if (h < 1e-3 * floor) {
      failure_ = moreau_.failure();
      return Outcome::failed;
    }
    return shorten(0.25 * h);
  }
  if (const double over = std::max(
          curve_overreach(system_, start.t, start.q.data(), start.v.data(), moreau_.t(), moreau_.q(),
                          moreau_.v(), Knots::passed),
          peaks_.overreach(start.t, start.q.data(), start.v.data(), moreau_.t(), moreau_.q(), moreau_.v()));
      over > 1 && h > std::max(1e-3 * floor, a.least)) {
    a.landings = 0;
    return shorten(h / over);
  }
  const bool alike = pair_.alike();
  const double error = pair_.error(moreau_);
  const double factor = std::clamp(0.9 * std::pow(std::max(error, 1e-10), alike ? -1.0 / 3 : -0.5), 0.1, 4.0);
  // A slow motion may have become fast within this step.
  if (error > 1 && h <= floor)
    floor =
        std::min(floor, tolerance_ * scales_.length / greatest_speed(system_, moreau_.v()) * pace_.raised());
  if (error > 1 && h > floor) {
    a.landings = 0;
    return shorten(std::max(h * std::min(factor, 0.7), floor));
  }
  if (alike && error <= 1) pair_.extrapolate(moreau_);
  const auto onset = search_.first_onset(moreau_, pair_);
  const int inside = onset ? -1 : found_inside();
  const bool shortens = h > std::max(1e-3 * floor, a.least);  // otherwise time would not advance
  if (inside >= 0 && !shortens) {
    fail_inside(inside);
    return Outcome::failed;
  }
  const bool open = search_.unseen() > seen_depth && a.halvings < most_halvings;
  if ((inside >= 0 || !search_.bounded() || open) && shortens) {
    a.halvings += open;
    a.landings = 0;
    return shorten(0.5 * h);
  }
  found_.unseen = std::max(found_.unseen, search_.unseen());
  if (onset) {
    auto& soft = pair_.start.contacts[static_cast<std::size_t>(onset->contact)].soft;
    if (bounce_is_over(*onset)) soft = true;
    if (onset->t <= start.t) {  // the onset is at the beginning of the step
      moreau_.go_back(start);
      return impact_step(t_end) ? Outcome::accepted : Outcome::failed;
    }
    if (land_on_onset(a, *onset)) return Outcome::again;
    contact(onset->contact).soft = soft;
    impacting_ = true;
  } else if (land_on_change(a, floor) || land_on_kink(a, floor)) {
    return Outcome::again;
  }
  if (error > 1) {
    ++found_.floored;
    found_.most_floored = std::max(found_.most_floored, error);
    found_.longest_floor = std::max(found_.longest_floor, h);
  }
  h_ = a.landings > 0 || last ? std::max(h_, h * factor) : h * factor;
  h_ = std::max(h_, 2 * floor);  // the reason for the short step lies behind
  settle();
  return Outcome::accepted;
}

/// Whether the step is repeated to end at a contact onset.
bool AdaptiveMoreau::land_on_onset(Attempt& a, const OnsetSearch::Onset& onset) {
  const double rest = pair_.start.t + a.h - onset.t;
  const double deep = std::max(std::abs(onset.rate) * rest, -contact(onset.contact).gap);
  if (a.landings >= 8 || !(rest > 0) || !(deep > near(onset.contact))) return false;
  refuse(a, onset.t - pair_.start.t);
  ++a.landings;
  return true;
}

/// Whether the step is repeated to end where a spring begins to act or changes its slope, so that
/// no step passes over a short action, or where the demand of a controller reaches its limit.
bool AdaptiveMoreau::land_on_kink(Attempt& a, double floor) {
  if ((!system_.curves().spring_kinks && system_.limiters() == 0) || a.landings >= 8) return false;
  const double from = pair_.start.t;
  auto t = system_.curves().spring_kinks ? search_.first_kink(moreau_, pair_) : std::nullopt;
  if (const auto limit = search_.first_limit(moreau_, pair_); limit && (!t || *limit < *t)) t = limit;
  if (!t || !(*t - from > floor) || !(*t < from + (1 - 1e-3) * a.h)) return false;
  refuse(a, *t - from);
  ++a.landings;
  return true;
}

/// Whether the step is repeated to end where a contact separates or friction begins to slip.
bool AdaptiveMoreau::land_on_change(Attempt& a, double floor) {
  const double share = pair_.first_change();
  if (a.landings >= 8 || !(share * a.h > floor) || !(share < 1 - 1e-3)) return false;
  refuse(a, share * a.h);
  ++a.landings;
  return true;
}

/// Whether the flight of a contact before this onset was the last bounce.
bool AdaptiveMoreau::bounce_is_over(const OnsetSearch::Onset& onset) const {
  const auto& c = moreau_.contacts()[onset.contact];
  const double duration = onset.t - c.t_left;
  if (!(c.t_left > -INFINITY)) return false;  // it has had no impact yet
  const bool low =
      0.25 * std::abs(onset.rate) * duration <= tolerance_ * system_.contact_facts(onset.contact).clearance;
  return c.restitution_at(std::abs(onset.rate)) < 1 && (low || duration <= 2 * pace_.floor);
}

/// One step over the impact of the contacts at their onset.
bool AdaptiveMoreau::impact_step(double t_end) {
  const double from = pair_.start.t;
  double approach = scales_.speed;
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = contact(k);
    if (c.row.normal.size > 0 && c.gap <= near(k))
      approach = std::max(approach, -c.row.normal.dot(moreau_.v()));
  }
  // A raised floor belongs to the pace of the fastest body: the step over a slow impact must not
  // move fast bodies through their walls.
  double h = tolerance_ * scales_.length / approach;
  h = std::max(h, std::min({h * pace_.raised(), pace_.floor, curve_limit()}));
  h = std::max(h, 16 * 2.3e-16 * std::abs(from));
  smooth_step_ = false;
  for (int tries = 0;; ++tries) {
    const double t = from + h >= t_end ? t_end : from + h;
    if (moreau_.advance(t, StepReach::all)) break;
    if (tries == 3) return fail(moreau_.failure());
    ++moreau_.totals().work.rejected;
    moreau_.go_back(pair_.start);
    h *= 10;
  }
  if (const int inside = found_inside(); inside >= 0) return fail_inside(inside);
  pair_.take_forces(moreau_);
  impacting_ = false;
  ++pace_.impacts_now;
  close_after_impact();
  settle();
  return true;
}

/// Determines which contacts of an impact stay closed, without restitution or a rate.
void AdaptiveMoreau::close_after_impact() {
  const double none = tolerance_ * scales_.speed;
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = contact(k);
    if (c.row.normal.size == 0 || (c.unknown < 0 && !c.closed)) continue;
    const double rate = c.row.normal.dot(moreau_.v()) - 0.5 * (moreau_.t() - pair_.start.t) * c.row.gamma_n;
    if (c.soft && c.unknown >= 0) {
      ++found_.ended;
      if (c.t_left > -INFINITY) found_.ended_time = std::max(found_.ended_time, moreau_.t() - c.t_left);
    }
    // A contact pressed without rebound stays closed: its rates at the impact and at the step's end
    // differ by the rotation of its row.
    const bool stays = c.last_n > 0 && (c.soft || c.restitution_at(-c.u_n_minus) == 0);
    c.soft = false;
    c.closed = (stays || std::abs(rate) <= none) &&
               c.gap <= 2 * near(k) + tolerance_ * system_.contact_facts(k).clearance;
    if (!c.closed) c.t_left = moreau_.t();
    calm_since_ = moreau_.t();
  }
}

/// After each step: closed contacts with a gap are opened, and open contacts at their onset are in
/// impact next.
void AdaptiveMoreau::settle() {
  work().steps = ++steps_;
  pace_.note_speed(greatest_speed(system_, moreau_.v()));
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = contact(k);
    if (c.row.normal.size == 0) continue;
    const bool at_onset = c.gap <= near(k);
    if (c.closed && at_onset) {  // the contact lasts
      c.t_pressed = moreau_.t();
      if (c.steps == 1) c.steps = 2;
    }
    if (c.closed && c.t_pressed < moreau_.t()) c.closed = false;
    if (!c.closed && at_onset && c.row.normal.dot(moreau_.v()) < 0) impacting_ = true;
  }
  pace_.note_step(moreau_.t(), moreau_.extremes().gains);
}

void AdaptiveMoreau::add_notes(std::vector<std::string>& notes) const {
  moreau_.add_notes(notes);
  const auto& f = found_;
  if (f.floored > 0)
    notes.push_back(diagnostic<Diagnostic::shortest_step>(f.floored, f.longest_floor, f.most_floored));
  if (f.ended > 0 && f.ended_time > 2.01 * pace_.least_floor)
    notes.push_back(diagnostic<Diagnostic::omitted_bounces>(f.ended, f.ended_time));
}

}  // namespace freeplay
