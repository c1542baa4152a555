#include "formulations/nonsmooth/controlled.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formulations/integrators/crossing.hpp"
#include "model/planar.hpp"

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
  for (auto* x : {&start_.q, &start_.v}) x->resize(n);
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

/// One step of h and two of half of it, of what is closed; the two stand.
bool ControlledMoreau::pair(double h) {
  const double t = start_.t + h, middle = start_.t + 0.5 * h;
  using Reach = MoreauStepper::Reach;
  if (!moreau_.advance(t, Reach::closed)) return false;
  turned_ = moreau_.turned_round();
  moreau_.keep(whole_);
  moreau_.modes(modes_whole_);
  const auto book = [this](Forces& sum) {
    if (!watching_) return;
    sum.add(1, moreau_.smooth());
    sum.add(1, moreau_.within());
  };
  for (auto* sum : {&smooth_, &whole_smooth_, &within_}) sum->clear();
  book(whole_smooth_);
  moreau_.go_back(start_);
  if (!moreau_.advance(middle, Reach::closed)) return false;
  moreau_.modes(modes_first_);
  for (std::size_t k = 0; k < pressed_first_.size(); ++k) pressed_first_[k] = moreau_.contacts()[k].last_n;
  turned_ = std::max(turned_, moreau_.turned_round());
  middle_t_ = middle;
  std::copy_n(moreau_.q(), system_.n(), middle_q_.begin());
  std::copy_n(moreau_.v(), system_.n(), middle_v_.begin());
  book(smooth_);
  if (!moreau_.advance(t, Reach::closed)) return false;
  moreau_.modes(modes_second_);
  lifted_ = moreau_.lifted(pressed_first_);
  turned_ = std::max(turned_, moreau_.turned_round());
  book(smooth_);
  return true;
}

void ControlledMoreau::extrapolate() {
  moreau_.extrapolate(whole_);
  if (!watching_) return;
  const auto beyond = [](double& half, double one) { half += (half - one) / 3; };
  for (std::size_t i = 0; i < smooth_.acceleration.size(); ++i)
    beyond(smooth_.acceleration[i], whole_smooth_.acceleration[i]);
  for (std::size_t i = 0; i < smooth_.elements.size(); ++i) {
    ElementForce more = smooth_.elements[i];
    more.add(-1, whole_smooth_.elements[i]);
    smooth_.elements[i].add(1.0 / 3, more);
  }
}

/// Of the last pair, over what is accepted.
double ControlledMoreau::error() const {
  const auto n = static_cast<std::size_t>(system_.n());
  double worst = 0;
  const auto take = [&](std::size_t i, double x, double y) {
    const double ratio =
        std::abs(x - y) / (norm_.tolerance * (norm_.absolute[i] + norm_.relative[i] * std::abs(x)));
    if (!(ratio <= worst)) worst = ratio;
  };
  for (std::size_t i = 0; i < n; ++i) {
    take(i, moreau_.q()[i], whole_.q[i]);
    take(n + i, moreau_.v()[i], whole_.v[i]);
  }
  for (std::size_t k = 0; k < whole_.z.size(); ++k) {
    const double ratio =
        std::abs(moreau_.z()[k] - whole_.z[k]) / (norm_.tolerance * system_.state_scale(static_cast<int>(k)));
    if (!(ratio <= worst)) worst = ratio;
  }
  return worst < 1e10 ? worst : 1e10;
}

/// The same of what both a step and its halves are blind to: the speed of sliding that turned round within a step, which they take
/// for turned all along, and the rate that lifts off within one that is pressed on the whole.
double ControlledMoreau::unseen_by_halves() const {
  const double missed = std::max(turned_, lifted_);
  if (missed == 0) return 0;
  double speed = missed;
  for (int i = 0; i < system_.n(); ++i)
    if (!system_.is_angle(i)) speed = std::max(speed, std::abs(start_.v[static_cast<std::size_t>(i)]));
  return missed / (norm_.tolerance * (scales_.speed + speed));
}

/// How long (s) angles stay within a knot or so of the curves that motions follow them by: an even turning tells nothing of
/// a narrow rise ahead.
static double within_knots(const System& system, const double* q, const double* v) {
  double time = INFINITY;
  if (!system.has_motions()) return time;
  for (int k = 0; k < system.phases(); ++k) {
    const auto& phase = system.phase(k);
    const auto now = phase.at(q, v);
    if (!phase.swept || now.rate == 0) continue;
    const auto piece = phase.piece(now.value, now.rate > 0);
    const double rest = now.rate > 0 ? piece.high - now.value : now.value - piece.low,
                 width = piece.high - piece.low;
    time =
        std::min(time, std::max(1.001 * rest, std::isfinite(width) ? 0.01 * width : 0) / std::abs(now.rate));
  }
  return time;
}

bool ControlledMoreau::step(double t_end) {
  moreau_.keep(start_);
  if (striking_) return strike(t_end);
  // No step crosses a kink of a table's torque in time.
  const double end =
      std::min({t_end, system_.next_knot(start_.t), start_.t + longest_step(system_, moreau_.v()),
                start_.t + within_knots(system_, start_.q.data(), start_.v.data())});
  double h = std::min(h_, end - start_.t);
  if (!(h > 1e-14 * first_step()) && end < t_end) {
    failure_ = fmt::format(
        "t = {:.9g} s: steps of {:.2g} s lead nowhere: the motion is singular there, or too fast to be "
        "followed",
        start_.t, h);
    return false;
  }
  int landings = 0;
  smooth_step_ = true;
  for (int tries = 0;; ++tries) {
    if (tries > 200) {
      failure_ = fmt::format("t = {:.9g} s: no step is accepted any more, however small", start_.t);
      return false;
    }
    const bool last = h >= end - start_.t;
    double floor = std::max(floor_, 16 * 2.3e-16 * std::abs(start_.t));
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
    if (const auto touch = first_touch()) {
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

/// One step over the impact of what is at its touch.
bool ControlledMoreau::strike(double t_end) {
  double approach = scales_.speed;
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = moreau_.contacts()[k];
    if (c.row.normal.size > 0 && c.gap <= near(k))
      approach = std::max(approach, -c.row.normal.dot(moreau_.v()));
  }
  double h = norm_.tolerance * scales_.length / approach * raised();
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
  if (watching_) {
    smooth_.clear();
    smooth_.add(1, moreau_.smooth());
    within_.clear();
    within_.add(1, moreau_.within());
  }
  striking_ = false;
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

/// Whether the flight of a contact that touches again was a hop that is over.
bool ControlledMoreau::hop_over(const Touch& touch) const {
  const auto& c = moreau_.contacts()[touch.contact];
  const double duration = touch.t - c.t_left;
  if (!(c.t_left > -INFINITY)) return false;  // it has not been struck yet
  const bool low = 0.25 * std::abs(touch.rate) * duration <=
                   norm_.tolerance * system_.contact_facts(touch.contact).clearance;
  return c.restitution < 1 && (low || duration <= 2 * floor_);
}

/// Where many steps pass in next to no time the floor is raised; where few do it comes down again.
void ControlledMoreau::keep_pace() {
  if (++paced_ < 200) return;
  const double passed = moreau_.t() - paced_since_;
  const double slow = scales_.guessed ? pace_ : scales_.time;
  if (passed < 0.02 * slow) floor_ = std::min(4 * floor_, std::max(least_floor_, 0.2 * pace_));
  if (passed > 0.2 * slow) floor_ = std::max(0.25 * floor_, least_floor_);
  paced_ = 0;
  paced_since_ = moreau_.t();
}

std::optional<ControlledMoreau::Touch> ControlledMoreau::first_touch() {
  std::optional<Touch> first;
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

/// Of Hermite's cubic, whose accelerations are linear.
void ControlledMoreau::enclose(double h, const double* qa, const double* va, const double* qb,
                               const double* vb) {
  const auto n = static_cast<std::size_t>(system_.n());
  bounds_.duration = h;
  bounds_.speed.resize(n);
  bounds_.acceleration.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double mean = (qb[i] - qa[i]) / h, a0 = (6 * mean - 4 * va[i] - 2 * vb[i]) / h,
                 a1 = (2 * va[i] + 4 * vb[i] - 6 * mean) / h;
    const auto of = cubic_bounds(h, qa[i], va[i], a0, qb[i], vb[i], a1);
    bounds_.speed[i] = of.speed;
    bounds_.acceleration[i] = of.acceleration;
  }
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
            a, b, left(qa, va), left(qb, vb), phase.motion(bounds_, piece, up, qb), rounding, unseen);
        if (t && (!first || *t < *first)) first = t;
      }
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
  double unseen = 0;
  const double rounding = gap_rounding(system_, k, qb);
  const auto look = [&](double t) {
    interpolate(t, look_q_.data(), look_v_.data());
    return at(t, look_q_.data(), look_v_.data());
  };
  auto start = begin;
  if (start.value <= near(k) && start.rate > 0) start.value = std::max(start.value, 0.0);
  const auto t = first_loss(look, a, b, start, end, motion, rounding, unseen);
  unseen_ = std::max(unseen_, unseen / system_.contact_facts(k).clearance);
  if (!t) return std::nullopt;
  return Touch{k, *t, look(*t).rate};
}

void ControlledMoreau::interpolate(double t, double* q, double* v) const {
  if (!smooth_step_) {
    const double h = moreau_.t() - start_.t, s = h > 0 ? (t - start_.t) / h : 1;
    for (int i = 0; i < system_.n(); ++i) {
      q[i] = start_.q[i] + s * (moreau_.q()[i] - start_.q[i]);
      v[i] = start_.v[i] + s * (moreau_.v()[i] - start_.v[i]);
    }
    return;
  }
  const bool early = t < middle_t_;
  const double a = early ? start_.t : middle_t_, b = early ? middle_t_ : moreau_.t(), h = b - a;
  const double *qa = early ? start_.q.data() : middle_q_.data(),
               *va = early ? start_.v.data() : middle_v_.data();
  const double *qb = early ? middle_q_.data() : moreau_.q(), *vb = early ? middle_v_.data() : moreau_.v();
  const double s = h > 0 ? std::min((t - a) / h, 1.0) : 1, r = 1 - s;
  for (int i = 0; i < system_.n(); ++i) {
    q[i] = r * r * (1 + 2 * s) * qa[i] + s * s * (3 - 2 * s) * qb[i] + h * s * r * (r * va[i] - s * vb[i]);
    const double mean = h > 0 ? (qb[i] - qa[i]) / h : 0;
    v[i] = 6 * s * r * mean + r * (1 - 3 * s) * va[i] + s * (3 * s - 2) * vb[i];
  }
}

void ControlledMoreau::watch_forces(bool on) {
  watching_ = on;
  moreau_.watch_forces(on);
  if (on && smooth_.elements.empty()) smooth_ = whole_smooth_ = within_ = system_.make_forces();
}

void ControlledMoreau::forces(double, Forces& out) const {
  out.clear();
  if (t() > t_old()) out.add(1 / (t() - t_old()), smooth_);
}

void ControlledMoreau::add_impulse(double a, double b, Forces& sum) const {
  if (b > a) sum.add((b - a) / (t() - t_old()), smooth_);
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
