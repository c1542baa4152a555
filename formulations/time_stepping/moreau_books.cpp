// What a step of Moreau's leaves in the books: touches and losses of contact, energies, forces.
#include <algorithm>
#include <cmath>

#include "formulations/time_stepping/moreau.hpp"

namespace freeplay {
namespace {

/// How far a curve departs, by its knots between a and b, from the straight line that a step of Δx = |b − a| takes it for: with [y′] the
/// jump of its slope at a knot |[y′]| Δx/4, and of a jump of the value the share of the shorter piece beside it, |[y]| Δx/(2w).
double departure_at_knots(const CurveReader& reader, double a, double b) {
  constexpr int most = 64;  // more are not resolved anyway
  if (reader.place.kinks.empty()) return 0;
  const bool up = b > a;
  const double path = std::abs(b - a);
  double sum = 0;
  auto piece = reader.place.piece(a, up);
  for (int passed = 0; passed < most; ++passed) {
    const double knot = up ? piece.high : piece.low;
    if (!(up ? knot < b : knot > b)) break;
    const auto next = reader.place.piece(knot, up);
    const double width = std::min(piece.high - piece.low, next.high - next.low);
    const auto jump = reader.course.jump(knot);
    sum += jump.slope * path / 4 + jump.value * path / (2 * width);
    piece = next;
  }
  return sum;
}

}  // namespace

template <class Self, class P, class Copy>
void MoreauStepper::each_kept(Self& s, P& p, Copy copy) {
  copy(s.q_, p.q);
  copy(s.v_, p.v);
  copy(s.z_, p.z);
  copy(s.slide_last_, p.slide_last);
  copy(s.contacts_, p.contacts);
  copy(*s.log_, p.log);
  copy(s.integrals_, p.integrals);
  copy(s.extremes_, p.extremes);
  copy(s.t_, p.t);
  copy(s.work_.events, p.events);
  copy(s.jams_, p.jams);
  copy(s.undecided_, p.undecided);
  copy(s.unswept_, p.unswept);
  copy(s.inelastic_, p.inelastic);
  copy(s.locked_, p.locked);
  copy(s.locked_since_, p.locked_since);
  copy(s.slide_scale_, p.slide_scale);
  copy(s.motions_, p.motions);
  copy(s.jam_, p.jam);
}

void MoreauStepper::keep(Place& p) const {
  each_kept(*this, p, [](const auto& own, auto& kept) { kept = own; });
}

void MoreauStepper::go_back(const Place& p) {
  each_kept(*this, p, [](auto& own, const auto& kept) { own = kept; });
  failure_.clear();
}

void MoreauStepper::extrapolate(const Place& whole) {
  const auto beyond = [](double& half, double one) { half += (half - one) / 3; };
  for (int i = 0; i < system_.n(); ++i) {
    beyond(q_[i], whole.q[i]);
    beyond(v_[i], whole.v[i]);
  }
  for (std::size_t k = 0; k < z_.size(); ++k) beyond(z_[k], whole.z[k]);
  for (const auto term :
       {&EnergyLedger::drive, &EnergyLedger::load, &EnergyLedger::damping, &EnergyLedger::contact,
        &EnergyLedger::friction, &EnergyLedger::film, &EnergyLedger::stabilisation})
    beyond(integrals_.*term, whole.integrals.*term);
  system_.place(t_, q_.data(), end_);
  for (int k = 0; k < system_.contacts(); ++k) contacts_[k].gap = system_.gap(k, q_.data(), end_);
}

void MoreauStepper::modes(std::vector<signed char>& list) const {
  list.clear();
  const auto way = [](double impulse, double bound) {
    return static_cast<signed char>(std::abs(impulse) < bound * (1 - 1e-9) ? 1 : impulse < 0 ? 2 : 3);
  };
  for (const auto& c : contacts_) {
    const auto* u = c.unknown >= 0 ? &problem_.unknowns[c.unknown] : nullptr;
    const bool rough = u && u->tangent >= 0;
    list.push_back(!u || !(u->impulse_n > 0) ? 0 : rough ? way(u->impulse_t, u->friction * u->impulse_n) : 1);
  }
  const auto preloaded = problem_.unknowns.size() - slides_.size();
  for (std::size_t k = 0; k < slides_.size(); ++k)
    list.push_back(way(problem_.unknowns[preloaded + k].impulse_t, problem_.unknowns[preloaded + k].bound));
}

double MoreauStepper::turned_round() const {
  double rate = 0;
  const auto take = [&](const SparseRow& row, const ContactUnknown& u, double bound) {
    const double before = row.dot(v_old_.data());
    if (bound <= 0 || before == 0) return;
    if (std::abs(u.impulse_t) >= bound * (1 - 1e-9)) {
      if (before * u.impulse_t > 0)
        rate = std::max(rate, std::abs(before));  // friction that drives what slid
      return;
    }
    if (std::abs(rate_of(u.tangent)) > 1e-3 * std::abs(before)) return;  // hardly pressed, it slides on
    // It was stopped. What holds it there, the impulse less what took its speed, may be more than friction bears.
    const double d = delassus(u.tangent, u.tangent), held = std::abs(u.impulse_t + before / d);
    if (held > bound) rate = std::max(rate, (held - bound) * d);
  };
  for (const auto& c : contacts_)
    if (c.unknown >= 0 && c.row.tangent.size > 0) {
      const auto& u = problem_.unknowns[c.unknown];
      take(c.row.tangent, u, u.friction * u.impulse_n);
    }
  const auto preloaded = problem_.unknowns.size() - slides_.size();
  for (std::size_t k = 0; k < slides_.size(); ++k) {
    const auto& u = problem_.unknowns[preloaded + k];
    take(slides_[k], u, u.bound);
  }
  return rate;
}

double MoreauStepper::lifted(const std::vector<double>& first) const {
  double rate = 0;
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const auto& c = contacts_[k];
    if (!c.closed || c.unknown < 0) continue;
    const auto& u = problem_.unknowns[c.unknown];
    // Forces at a quarter and three quarters of the two half steps, in impulses over both.
    const double early = 2 * first[k], late = 2 * u.impulse_n, slope = 2 * (late - early);
    const double least = std::min(early, late) - 0.25 * std::abs(slope);
    if (!(early > 0) || !(late > 0) || !(least < 0)) continue;
    rate = std::max(rate, 0.5 * least * least / std::abs(slope) * delassus(u.normal, u.normal));
  }
  return rate;
}

void MoreauStepper::account(double h) {
  const int n = system_.n();
  const int first_driven = system_.rows() - (system_.has_motions() ? system_.drive_rows() : 0);
  // Where velocities meet the rates at both ends (meet_rates()), what all rows do at their mean is the drives' alone: ideal joints do
  // nothing, and that their rows turn within the step is the step's error, of an order that would add up turn by turn.
  const bool met = reach_ == Reach::closed && system_.drive_rows() > 0;
  const auto& G = system_.pattern();
  const int* column = G.column.data();
  for (int i = 0; i < n; ++i) v_mean_[i] = 0.5 * (v_old_[i] + v_[i]);
  const double *value = e_.G.data(), *mean = v_mean_.data();
  double drive = integrals_.drive, stabilisation = integrals_.stabilisation;
  for (int k = 0, e = 0; k < G.rows; ++k) {
    const double impulse = lambda_[k], driven = e_.phi_t[k];
    drive += impulse * driven;
    double rate = 0;
    for (const int end = G.begin[k + 1]; e < end; ++e) rate += value[e] * mean[column[e]];
    const double work = impulse * (rate + driven);
    // What follows a curve has its own rates at both ends of the step: it is driven at their mean, not at that of its curve.
    if (met || (k >= first_driven && driven != 0))
      drive -= work;
    else
      stabilisation -= work;
  }
  integrals_.drive = drive;
  integrals_.stabilisation = stabilisation;
  if (films_.any()) integrals_.film += films_.loss(v_old_.data(), v_.data());
  double gain = 0, approach = 0;  // approach: Σ P_N |u_N⁻|
  for (const int k : live_)
    if (const auto& c = contacts_[k]; c.unknown >= 0)
      approach += problem_.unknowns[c.unknown].impulse_n * std::max(0.0, -c.u_n_minus);
  for (const auto& c : problem_.unknowns) {
    const auto mean_rate = [&](int row) { return row_of(row).dot(mean); };
    double work = 0;
    if (c.normal >= 0) {
      const double normal = c.impulse_n * mean_rate(c.normal);
      integrals_.contact -= normal;
      work += normal;
    }
    if (c.tangent >= 0) {
      const double tangential = c.impulse_t * mean_rate(c.tangent);
      integrals_.friction -= tangential;
      work += tangential;
    }
    gain += work;
  }
  // A step's share of lasting contact may add h² times forces; more is an impact that raised the energy. Chosen steps over
  // impacts are the least.
  if (struck_)
    extremes_.count_gain(gain > (step_ > 0 ? 1e-3 : 1e-5) * approach ? gain : 0,
                         system_.kinetic(v_old_.data()), 1e-9);
  if (!system_.has_loads()) return;
  const Sweep sweep{h, v_old_.data(), v_mean_.data()};
  system_.forces(t_old_ + 0.5 * h, q_mid_.data(), v_mean_.data(), z_mid_.data(), e_, {&sweep});
  integrals_.drive += h * e_.power.drive;
  integrals_.load += h * e_.power.load;
  integrals_.damping -= h * e_.power.damping;
}

/// A loss of contact at the end of the last step with an impulse.
void MoreauStepper::log_leave(int k) {
  auto& c = contacts_[k];
  const double t = c.steps > 1 ? c.t_pressed : c.t_touch;
  log_->leave(k, t, system_.crank_angle(q_old_.data()), c.u_n_plus, c.u_t_plus, c.impulse_n, c.impulse_t,
              t - c.t_touch);
  c.steps = 0;
  c.t_left = c.t_pressed;
}

void MoreauStepper::leave_all_open() {
  for (int k = 0; k < system_.contacts(); ++k)
    if (!contacts_[k].closed && log_->is_open(k)) log_leave(k);
}

/// How long (s) the hops after this touch would last that are left out: of a flight D those that follow last D (e + e² + …).
double MoreauStepper::left_out(const Contact& c) {
  if (!c.soft || !(c.t_left > -INFINITY)) return 0;
  const double flight = c.t_touch - c.t_left;
  return c.restitution < 1 ? flight * c.restitution / (1 - c.restitution) : flight;
}

/// Whether a contact that a step of h did not press has left. What stands off by rounding is pressed again within a fixed
/// step; one cut short by the run's end is too brief for that, so it is decided over the whole of one.
bool MoreauStepper::leaves(const Contact& c, double h) const {
  if (!(h < step_ * (1 - 1e-9)) || c.row.normal.size == 0) return true;
  const double begin = c.row.normal.dot(v_old_.data()) + 0.5 * h * c.row.gamma_n,
               end = c.row.normal.dot(v_.data()) - 0.5 * h * c.row.gamma_n;
  return c.gap + step_ * (begin + 0.5 * step_ * (end - begin) / h) > 0;
}

void MoreauStepper::log_contacts(double h) {
  struck_ = false;
  const auto preloaded = problem_.unknowns.size() - slide_last_.size();
  for (std::size_t k = 0; k < slide_last_.size(); ++k)
    slide_last_[k] = problem_.unknowns[preloaded + k].impulse_t;
  for (const int k : live_) {
    auto& c = contacts_[k];
    const auto* u = c.unknown >= 0 ? &problem_.unknowns[c.unknown] : nullptr;
    const bool pressed = u && u->impulse_n > 0;
    c.last_n = pressed ? u->impulse_n : 0;
    c.last_t = pressed ? u->impulse_t : 0;
    if (!pressed) {
      if (log_->is_open(k) && !(reach_ == Reach::closed && c.closed) && leaves(c, h)) log_leave(k);
      continue;
    }
    const double tangent_minus = c.row.tangent.size > 0 ? c.row.tangent.dot(v_old_.data()) + c.bias_t : 0;
    if (c.steps++ == 0) {
      struck_ = true;
      // First touch where the gap at the step's beginning closes at its rate there.
      const double closing = c.row.normal.dot(v_old_.data()) + 0.5 * h * c.row.gamma_n;
      c.t_touch = t_old_ + (closing < 0 ? std::clamp(-c.gap / closing, 0.0, h) : 0);
      c.impulse_n = c.impulse_t = 0;
      if (c.u_n_minus < 0 && step_ > 0) keep_flight(-c.u_n_minus, (c.t_touch - c.t_left) / step_);
      log_->touch(k, c.t_touch, system_.crank_angle(q_old_.data()), c.u_n_minus, tangent_minus,
                  std::max(h, left_out(c)), 1.5 * h);
      if (seated(k)) log_->name(k, told_as(k), {pair_of(k).i, pair_of(k).j});
      ++work_.events;
    }
    c.t_pressed = t_;
    c.impulse_n += u->impulse_n;
    c.impulse_t += u->impulse_t;
    c.u_n_plus = c.row.normal.dot(v_.data()) - c.bias_n;
    c.u_t_plus = c.row.tangent.size > 0 ? c.row.tangent.dot(v_.data()) - c.bias_t : 0;
  }
}

/// What sensors feel as impulses: the responses to the struck contacts alone.
void MoreauStepper::keep_struck() {
  std::ranges::fill(struck_v_, 0.0);
  double sum = 0, moment = 0;
  for (const int k : live_) {
    const auto& c = contacts_[k];
    if (c.unknown < 0 || c.steps != 1) continue;
    const auto& u = problem_.unknowns[c.unknown];
    if (!(u.impulse_n > 0)) continue;
    sum += u.impulse_n;
    moment += u.impulse_n * (c.t_touch - t_old_);
    for (const auto& [row, impulse] : {std::pair{u.normal, u.impulse_n}, std::pair{u.tangent, u.impulse_t}})
      if (row >= 0) push(place_of(row), impulse, struck_v_.data());
  }
  struck_t_ = sum > 0 ? std::clamp(t_old_ + moment / sum, t_old_, t_) : t_;
}

/// The shortest flight before any of the fastest impacts: which they are, from a quarter to a half of the
/// fastest up, shows as the run goes on.
void MoreauStepper::keep_flight(double approach, double steps) {
  auto& shortest = flights_[std::clamp(std::ilogb(approach) + 96, 1, 127)];
  shortest = std::min(shortest, steps);
  auto fastest = flights_.size() - 1;
  while (!(flights_[fastest] < INFINITY) && fastest > 1) --fastest;
  extremes_.shortest_flight = std::min(flights_[fastest], flights_[fastest - 1]);
}

/// What moves far in a step may come and go between two of them.
void MoreauStepper::keep_passage(double h) {
  for (const int k : passing_)
    for (const auto* v : {&v_old_, &v_})
      if (const double share = system_.passage(k, v->data(), h); share > passage_.share)
        passage_ = {share, k};
  for (std::size_t n = static_cast<std::size_t>(system_.contacts()); n < live_.size(); ++n) {
    const auto& shape = near_->seats[static_cast<std::size_t>(live_[n] - system_.contacts())].shape;
    for (const auto* v : {&v_old_, &v_})
      if (const double share = System::passage(shape, v->data(), h); share > passage_.share)
        passage_ = {share, told_as(live_[n])};
  }
}

/// A fixed step takes what it reads for straight between its ends: of a sine of N steps a period it misses (2π/N)²/8. Two places
/// within, so that no period that divides the step is missed.
void MoreauStepper::keep_bend() {
  const auto& readers = system_.curve_readers();
  const auto take = [&](double share, double most, std::size_t i) {
    if (share > most * bend_.over) bend_ = {share, share / most, static_cast<int>(i)};
  };
  for (std::size_t i = 0; i < readers.size(); ++i) {
    const auto& reader = readers[i];
    const double a = reader.argument(t_old_, q_old_.data(), v_old_.data()).value,
                 b = reader.argument(t_, q_.data(), v_.data()).value;
    if (a == b || !(greatest_[i] > 0)) continue;
    // A sine or a row of kinks at equal distances, each met by one step of five: 20 and more steps a period.
    if (reader.of != CurveReader::Of::time) take(departure_at_knots(reader, a, b) / greatest_[i], 0.1, i);
    if (!std::isfinite(reader.variation(a, b > a))) continue;
    const auto y = [&](double s) { return reader.course.value(a + s * (b - a)); };
    const double from = y(0), to = y(1);
    for (const double s : {0.37, 0.5})
      take(std::abs(y(s) - (from + s * (to - from))) / greatest_[i], 0.01, i);
  }
}

void MoreauStepper::watch_forces(bool on) {
  watching_ = on;
  if (!on || !smooth_.elements.empty()) return;
  nothing_ = smooth_ = within_ = system_.make_forces();
  struck_lambda_.resize(system_.rows());
  smooth_lambda_.resize(system_.rows());
}

/// The step's impulses: those of contacts that it struck, with what the joints answered, apart from the rest.
void MoreauStepper::book(double h) {
  const int n = system_.n(), m = system_.rows();
  const double* q = q_mid_.data();
  smooth_.clear();
  within_.clear();
  std::ranges::fill(struck_lambda_, 0.0);
  if (many_) std::ranges::fill(force_, 0.0);
  const auto take = [&](int row, double impulse) {
    if (row < 0 || impulse == 0) return;
    push(place_of(row), impulse, within_.acceleration.data());
    if (many_) {
      row_of(row).add_to(force_.data(), impulse);
      return;
    }
    if (late_multipliers_) saddle_.finish(rows_[row], response(row), reaction(row));
    for (int k = 0; k < m; ++k) struck_lambda_[k] += impulse * reaction(row)[k];
  };
  for (const int k : live_) {
    const auto& c = contacts_[k];
    if (c.unknown < 0) continue;
    const auto& u = problem_.unknowns[c.unknown];
    const bool struck = c.steps == 1 && u.impulse_n > 0;
    if (struck) {
      take(u.normal, u.impulse_n);
      take(u.tangent, u.impulse_t);
    }
    auto& out = struck ? within_ : smooth_;
    if (seated(k))
      system_.report_contact(told_as(k), System::link_of(near_->seats[k - system_.contacts()].shape), q, e_,
                             c.row, u.impulse_n, u.impulse_t, 1, out);
    else
      system_.report_contact(k, q, e_, c.row, u.impulse_n, u.impulse_t, 1, out);
  }
  if (many_ && struck_) saddle_.solve(force_.data(), nullptr, dq_.data(), struck_lambda_.data());
  if (films_.any()) films_.report(system_, q, e_, within_.acceleration.data(), smooth_, within_);
  for (int k = 0; k < m; ++k) smooth_lambda_[k] = lambda_[k] - struck_lambda_[k];
  system_.report_rows(q, e_, smooth_lambda_.data(), 1, smooth_);
  system_.report_rows(q, e_, struck_lambda_.data(), 1, within_);
  for (int i = 0; i < n; ++i) {
    smooth_.acceleration[i] = v_[i] - v_old_[i] - within_.acceleration[i];
    v_mean_[i] = 0.5 * (v_old_[i] + v_[i]);
  }
  const auto preloaded = problem_.unknowns.size() - slides_.size();
  for (std::size_t k = 0; k < slides_.size(); ++k)
    system_.report_friction(static_cast<int>(k), q, v_mean_.data(), e_, slides_[k],
                            problem_.unknowns[preloaded + k].impulse_t, 1, smooth_);
  const Sweep sweep{h, v_old_.data(), v_mean_.data()};
  system_.report_loads(t_old_ + 0.5 * h, q, v_mean_.data(), z_mid_.data(), e_, h, smooth_, {&sweep});
}

void MoreauStepper::forces(double, Forces& out) {
  out.clear();
  if (t_ > t_old_) out.add(1 / (t_ - t_old_), smooth_);
}

void MoreauStepper::add_impulse(double a, double b, Forces& sum) const {
  if (b > a) sum.add((b - a) / (t_ - t_old_), smooth_);
}

}  // namespace freeplay
