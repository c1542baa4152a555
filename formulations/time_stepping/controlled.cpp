#include "formulations/time_stepping/controlled.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/planar.hpp"
#include "formulations/integrators/crossing.hpp"
#include "formulations/integrators/curve_limit.hpp"

namespace freeplay {

ControlledMoreau::ControlledMoreau(const System& system, MoreauStepper moreau, ErrorNorm norm,
                                   const Scales& scales)
    : system_(system),
      moreau_(std::move(moreau)),
      norm_(std::move(norm)),
      scales_(scales),
      e_(system.make_evaluation()) {
  const auto n = static_cast<std::size_t>(system.n());
  for (auto* x : {&middle_q_, &middle_v_, &look_q_, &look_v_}) x->resize(n);
  for (auto* x : {&start_.q, &start_.v, &bounds_.speed, &bounds_.acceleration}) x->resize(n);
  for (auto* place : {&start_, &whole_})
    place->log = ContactLog(system.contacts());  // with room for its events
  pressed_first_.resize(static_cast<std::size_t>(system.contacts()));
  h_ = first_step();
  fastest_ = scales.guessed ? 0 : scales.speed;
  find_pace();
  moreau_.set_slack(0.1 * norm_.tolerance * scales.length);
}

/// How much longer the least step is at present than it need be.
double ControlledMoreau::raised() const { return least_floor_ > 0 ? floor_ / least_floor_ : 1; }

/// The least step and what nothing happens within, from the greatest speed so far of bodies against what they may touch.
void ControlledMoreau::find_pace() {
  const double longer = raised();
  pace_ = fastest_ > 0 ? scales_.length / fastest_ : 0;
  if (film_pace_ > 0) pace_ = pace_ > 0 ? std::min(pace_, film_pace_) : film_pace_;
  least_floor_ = norm_.tolerance * pace_;
  floor_ = longer * least_floor_;
}

/// Where many impacts follow each other in next to no time the floor is raised; where few do it comes down again.
void ControlledMoreau::keep_pace() {
  if (++paced_ < 200) return;
  const double passed = moreau_.t() - paced_since_;
  const double slow = scales_.guessed ? pace_ : scales_.time;
  const long gains = moreau_.extremes().gains;
  // Else steps are short for what is smooth, and a longer floor would miss it.
  const bool crowded = strikes_ >= 40 || gains > gains_;
  if (crowded && passed < 0.02 * slow) floor_ = std::min(4 * floor_, std::max(least_floor_, 0.2 * pace_));
  if (passed > 0.2 * slow) floor_ = std::max(0.25 * floor_, least_floor_);
  if (passed > 0.02 * slow || gains == gains_) {
    calm_speed_ = fastest_;
    calm_gains_ = gains;
  }
  gains_ = gains;
  paced_ = strikes_ = 0;
  paced_since_ = moreau_.t();
}

/// A gap not greater than this (m) is at its touch.
double ControlledMoreau::near(int k) const {
  return std::max(0.1 * norm_.tolerance * system_.contact_facts(k).clearance,
                  4 * gap_rounding(system_, k, moreau_.q()));
}

void ControlledMoreau::start(const State& state, ContactLog& log) {
  moreau_.start(state, log);
  start_.t = state.t;
  fastest_ = std::max(fastest_, greatest_speed(system_, state.v.data()));
  // A film that nothing loads goes round with the journal's spin, slow as its centre may be.
  film_pace_ = 0;
  for (int k = 0; scales_.guessed && k < system_.contacts(); ++k)
    for (const int body : system_.contact_facts(k).bodies)
      if (system_.contact_facts(k).lubricant && body != ground)
        film_pace_ = std::max(film_pace_, std::abs(planar::rate(state.v.data(), body)));
  if (film_pace_ > 0) film_pace_ = 1 / film_pace_;
  find_pace();
  paced_since_ = calm_since_ = state.t;
  calm_speed_ = std::max(fastest_, scales_.speed);
  calm_gains_ = moreau_.extremes().gains;
  system_.place(state.t, state.q.data(), e_);
  striking_ = false;
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = moreau_.contacts()[k];
    c.t_left = -INFINITY;
    system_.contact(k, state.q.data(), state.v.data(), e_, c.row);
    if (c.row.normal.size == 0 || c.gap > near(k)) continue;
    const double rate = c.row.normal.dot(state.v.data()), none = norm_.tolerance * scales_.speed;
    striking_ = striking_ || rate < -none;
    c.closed = std::abs(rate) <= none;
  }
}

void ControlledMoreau::take_over(const Handover& from, ContactLog& log) {
  start(from.state, log);
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = moreau_.contacts()[k];
    const auto& was = from.contacts[static_cast<std::size_t>(k)];
    c.closed = was.closed && c.row.normal.size > 0;
    c.steps = was.logged ? 2 : 0;
    c.t_touch = was.t_touch;
    c.t_pressed = from.state.t;
    c.impulse_n = was.impulse_n;
    c.impulse_t = was.impulse_t;
    c.u_n_plus = c.row.normal.dot(from.state.v.data());
    c.u_t_plus = c.row.tangent.dot(from.state.v.data());
  }
  moreau_.integrals() = from.integrals;
  moreau_.extremes() = from.extremes;
  moreau_.work() = from.work;
  steps_ = from.work.steps;
  h_ = first_step();
  floor_ = least_floor_;
}

Handover ControlledMoreau::hand_over() {
  Handover to;
  to.state = {t(), {q(), q() + system_.n()}, {v(), v() + system_.n()}, {z().begin(), z().end()}};
  moreau_.leave_all_open();
  for (const auto& c : moreau_.contacts()) {
    Handover::Contact was{c.closed, c.steps > 0};
    if (was.logged) {  // else the impulses are of an episode that is over
      was.t_touch = c.t_touch;
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

/// A contact that lies too deep inside its wall, and did not at the beginning of the step; −1: none.
int ControlledMoreau::found_inside() const {
  for (int k = 0; k < system_.contacts(); ++k) {
    const double most = -too_deep * system_.contact_facts(k).clearance;
    if (moreau_.contacts()[k].gap < most && start_.contacts[static_cast<std::size_t>(k)].gap >= most)
      return k;
  }
  return -1;
}

bool ControlledMoreau::fail_inside(int contact) {
  return fail(fmt::format(
      "t = {:.9g} s: {} comes to lie {:.2g} clearances inside its wall in however short a step; take a smaller "
      "nonsmooth.step_tolerance",
      moreau_.t(), system_.contact_facts(contact).name,
      -moreau_.contacts()[contact].gap / system_.contact_facts(contact).clearance));
}

/// s: how long a step from here may be for the curves that it reads.
double ControlledMoreau::curve_limit() const {
  return curve_step_limit(system_, start_.t, start_.q.data(), start_.v.data(), Knots::passed);
}

bool ControlledMoreau::step(double t_end) {
  moreau_.keep(start_);
  // What impacts drive faster and faster in next to no time comes to no end that shorter steps would reach. A body that
  // springs or drives accelerate from rest gains as much speed by no impact.
  if (calm_speed_ > 0 && fastest_ > 1e3 * calm_speed_ && moreau_.extremes().gains > calm_gains_)
    return fail(fmt::format(
        "t = {:.9g} s: impacts that raise the energy drove a speed of {:.2g} m/s to {:.2g} m/s in next to no "
        "time: a restitution of rates with friction can; nonsmooth.impact_law = \"energetic\" does not",
        start_.t, calm_speed_, fastest_));
  // A kink or an end that only rounding leaves ahead lies behind: the time between is no step.
  const double rounding = std::max(16 * 2.3e-16 * std::abs(start_.t), 1e-14 * first_step());
  if (t_end - start_.t <= rounding) {
    start_.t = t_end;
    moreau_.go_back(start_);
    smooth_step_ = false;
    return true;
  }
  if (striking_) return strike(t_end);
  // No step crosses a kink of a curve in time, or jumps over what a curve does.
  const double end = std::min({t_end, system_.next_knot(start_.t + rounding),
                               start_.t + longest_step(system_, moreau_.v()), start_.t + curve_limit()});
  double h = std::min(h_, end - start_.t);
  if (!(h > 1e-14 * first_step()) && end < t_end) {
    failure_ = fmt::format(
        "t = {:.9g} s: steps of {:.2g} s lead nowhere: the motion is singular there, or too fast to be "
        "followed",
        start_.t, h);
    return false;
  }
  int landings = 0, halvings = 0;
  smooth_step_ = true;
  for (int tries = 0;; ++tries) {
    if (tries > 200) {
      failure_ = fmt::format("t = {:.9g} s: no step is accepted any more, however small", start_.t);
      return false;
    }
    const bool last = h >= end - start_.t;
    double floor = std::max(floor_, rounding);
    const auto refuse = [&](double shorter) {
      moreau_.go_back(start_);
      ++moreau_.work().rejected;
      h = std::min(shorter, end - start_.t);
    };
    if (!pair(h)) {
      if (h < 1e-3 * floor) return fail();
      refuse(0.25 * h);
      h_ = h;
      continue;
    }
    if (const double over = curve_overreach(system_, start_.t, start_.q.data(), start_.v.data(), moreau_.t(),
                                            moreau_.q(), moreau_.v(), Knots::passed);
        over > most_overreach && h > std::max(1e-3 * floor, rounding)) {
      refuse(h / over);
      h_ = h;
      landings = 0;
      continue;
    }
    const bool alike = modes_whole_ == modes_first_ && modes_first_ == modes_second_ && turned_ == 0;
    const double error = std::max(this->error() / (alike ? 3 : 1), unseen_by_halves());
    const double factor =
        std::clamp(0.9 * std::pow(std::max(error, 1e-10), alike ? -1.0 / 3 : -0.5), 0.1, 4.0);
    // What was slow so far may have come to a speed within this very step.
    if (error > 1 && h <= floor)
      floor =
          std::min(floor, norm_.tolerance * scales_.length / greatest_speed(system_, moreau_.v()) * raised());
    if (error > 1 && h > floor) {
      refuse(std::max(h * std::min(factor, 0.7), floor));
      h_ = h;
      landings = 0;
      continue;
    }
    if (alike && error <= 1) extrapolate();
    const auto touch = first_touch();
    const int inside = touch ? -1 : found_inside();
    const bool shortens = h > std::max(1e-3 * floor, rounding);  // else time would stand still
    if (inside >= 0 && !shortens) return fail_inside(inside);
    const bool open = step_unseen_ > seen_depth && halvings < most_halvings;
    if ((inside >= 0 || !bounded_ || open) && shortens) {
      halvings += open;
      refuse(0.5 * h);
      h_ = h;
      landings = 0;
      continue;
    }
    unseen_ = std::max(unseen_, step_unseen_);
    if (touch) {
      if (hop_over(*touch)) start_.contacts[static_cast<std::size_t>(touch->contact)].soft = true;
      if (touch->t <= start_.t) {  // it is there already
        moreau_.go_back(start_);
        return strike(t_end);
      }
      const double rest = start_.t + h - touch->t;
      const double deep = std::max(std::abs(touch->rate) * rest, -moreau_.contacts()[touch->contact].gap);
      if (landings < 8 && rest > 0 && deep > near(touch->contact)) {
        refuse(touch->t - start_.t);
        ++landings;
        continue;
      }
      moreau_.contacts()[touch->contact].soft =
          start_.contacts[static_cast<std::size_t>(touch->contact)].soft;
      striking_ = true;
    } else if (system_.has_spring_kinks() && landings < 8) {
      // A step ends where a spring begins to act or changes its slope: what acts for a short while is not jumped over.
      if (const auto t = first_kink(); t && *t - start_.t > floor && *t < start_.t + (1 - 1e-3) * h) {
        refuse(*t - start_.t);
        ++landings;
        continue;
      }
    }
    if (error > 1) {
      ++floored_;
      most_floored_ = std::max(most_floored_, error);
      longest_floor_ = std::max(longest_floor_, h);
    }
    h_ = landings > 0 || last ? std::max(h_, h * factor) : h * factor;
    h_ = std::max(h_, 2 * floor);  // what made the step short lies behind it
    settle();
    keep_pace();
    return true;
  }
}

void ControlledMoreau::tell(std::vector<std::string>& notes) const {
  moreau_.tell(notes);
  if (floored_ > 0)
    notes.push_back(fmt::format(
        "{} steps came down to their floor ({:.2g} s at most) with an error of up to {:.2g} times "
        "nonsmooth.step_tolerance: velocities jumped there without a touch",
        floored_, longest_floor_, most_floored_));
  if (ended_ > 0 && ended_time_ > 2.01 * least_floor_)
    notes.push_back(fmt::format(
        "{} hops, lower than nonsmooth.step_tolerance × clearance or shorter than the least step, were left "
        "out; the longest would have lasted {:.2g} s",
        ended_, ended_time_));
}

}  // namespace freeplay
