#include "formulations/time_stepping/step_pair.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace freeplay {
namespace {

/// Share of its bound that an impulse may lack where a contact slides: the residual of a solve.
constexpr double slip_residual = 1e-9;
/// Rate at the end of a step, over that at its beginning, up to which sliding has stopped.
constexpr double stopped_share = 1e-3;
/// Greatest estimate of an error, so that its ratios stay finite; NaN counts as this.
constexpr double greatest_error = 1e10;

}  // namespace

void list_modes(const ContactSet& contacts, const StepProblem& problem, std::vector<signed char>& list) {
  list.clear();
  const auto way = [](double impulse, double bound) -> signed char {
    if (std::abs(impulse) < bound * (1 - slip_residual)) return 1;
    return impulse < 0 ? 2 : 3;
  };
  for (const auto& c : contacts.all()) {
    const auto* u = problem.unknown_of(c);
    const bool rough = u && u->tangent >= 0;
    list.push_back(!u || !(u->impulse_n > 0) ? 0 : rough ? way(u->impulse_t, u->friction * u->impulse_n) : 1);
  }
  for (std::size_t k = 0; k < problem.slides.size(); ++k) {
    const auto& u = problem.friction(static_cast<int>(k));
    list.push_back(way(u.impulse_t, u.bound));
  }
}

double slip_reversal_error(const StepData& step, const ContactSet& contacts, const StepProblem& problem) {
  double rate = 0;
  // The bound of the step, and that of the end of sliding.
  const auto take = [&](const SparseRow& row, const ContactUnknown& u, double bound, double at_rest) {
    const double before = row.dot(step.v_old.data());
    if (bound <= 0 || before == 0) return;
    if (std::abs(u.impulse_t) >= bound * (1 - slip_residual)) {
      if (before * u.impulse_t > 0)
        rate = std::max(rate, std::abs(before));  // friction that drives the sliding
      return;
    }
    // with little normal force, it slides on
    if (std::abs(problem.rate(u.tangent)) > stopped_share * std::abs(before)) return;
    // Sliding was stopped. The impulse that then holds the contact, which is the total less the
    // impulse that stopped it, may exceed the friction limit.
    const double d = problem.D(u.tangent, u.tangent), held = std::abs(u.impulse_t + before / d);
    if (held > at_rest) rate = std::max(rate, (held - at_rest) * d);
  };
  for (int k = 0; k < static_cast<int>(contacts.all().size()); ++k)
    if (const auto* u = problem.unknown_of(contacts[k]); u && contacts[k].row.tangent.size > 0)
      take(contacts[k].row.tangent, *u, u->friction * u->impulse_n,
           contacts.facts(k).surface.friction_at_rest() * u->impulse_n);
  for (std::size_t k = 0; k < problem.slides.size(); ++k) {
    const auto& u = problem.friction(static_cast<int>(k));
    take(problem.slides[k], u, u.bound, u.bound);
    // The bound is that of the direction at the end, which may be zero: a freewheel.
    const double before = problem.slides[k].dot(step.v_old.data());
    if (before * problem.rate(u.tangent) < 0) rate = std::max(rate, std::abs(before));
  }
  return rate;
}

void list_pulls(const StepData& step, const ContactSet& contacts, const StepProblem& problem,
                std::vector<Pull>& list) {
  list.clear();
  for (const auto& c : contacts.all()) {
    auto& pull = list.emplace_back();
    if (!c.closed || c.row.normal.size == 0) continue;
    const auto* u = problem.unknown_of(c);
    pull.pressed = u && u->impulse_n > 0;
    pull.rate = pull.pressed ? -u->impulse_n * problem.D(u->normal, u->normal)
                             : c.row.normal.dot(step.v.data()) - c.row.normal.dot(step.v_old.data()) -
                                   step.length() * c.row.gamma_n;
  }
}

void list_holds(const StepData& step, const ContactSet& contacts, const StepProblem& problem,
                std::vector<Hold>& list) {
  list.clear();
  const auto take = [&](const ContactUnknown& u, const std::array<double, 2>& bound) {
    auto& hold = list.emplace_back();
    hold.held = std::abs(u.impulse_t) < bound[u.impulse_t < 0 ? 1 : 0] * (1 - slip_residual);
    const double d = problem.D(u.tangent, u.tangent);
    hold.beyond = {d * (u.impulse_t - bound[0]), d * (-u.impulse_t - bound[1])};
  };
  // A contact that slides is within its bound at rest.
  const auto below_own = [&](const ContactUnknown& u, double bound) {
    list.back().held = list.back().held && std::abs(u.impulse_t) < bound * (1 - slip_residual);
  };
  for (int k = 0; k < static_cast<int>(contacts.all().size()); ++k) {
    const auto* u = problem.unknown_of(contacts[k]);
    if (!u || u->tangent < 0) {
      list.emplace_back();
      continue;
    }
    const double bound = contacts.facts(k).surface.friction_at_rest() * u->impulse_n;
    take(*u, {bound, bound});
    below_own(*u, u->friction * u->impulse_n);
  }
  for (std::size_t k = 0; k < problem.slides.size(); ++k) {
    const int i = static_cast<int>(k);
    const auto& u = problem.friction(i);
    std::array<double, 2> bound{u.bound, u.bound};
    // The bound of an impulse that holds has not been iterated to its end.
    if (const auto& by = step.system.friction_facts(i).reaction) {
      const auto reactions = by->reactions(step.lambda.data());
      for (const std::size_t side : {0U, 1U})
        bound[side] = by->coefficient(0.0) * by->support(reactions, side == 0 ? 1 : -1, step.length());
    }
    take(u, bound);
    below_own(u, u.bound);
    if (problem.driven(i)) list.back().held = false;
  }
}

namespace {

/// The parabola middle + slope x + bend x², x from −½ to ½, of a rate in time over a whole step, from its
/// amounts in the step and its halves.
struct Parabola {
  double middle, slope, bend;
  std::array<double, 2> zeros{INFINITY, INFINITY};  // in order

  Parabola(double whole, double first, double second)
      : middle(whole), slope(4 * (second - first)), bend(16 * (first - whole + second)) {
    const double root = slope * slope - 4 * bend * middle;
    if (!(root > 0)) return;
    const double q = -0.5 * (slope + std::copysign(std::sqrt(root), slope));  // without cancellation
    zeros = {bend != 0 ? q / bend : INFINITY, q != 0 ? middle / q : INFINITY};
    if (zeros[0] > zeros[1]) std::swap(zeros[0], zeros[1]);
  }
  double total(double x) const { return x * (middle + x * (slope / 2 + x * bend / 3)); }
  /// ∫ of its parts of one sign (1 or −1), as a positive amount.
  double part(double sign, double from, double to) const {
    double sum = 0;
    for (const double end : {std::clamp(zeros[0], from, to), std::clamp(zeros[1], from, to), to}) {
      sum += std::max(sign * (total(end) - total(from)), 0.0);
      from = end;
    }
    return sum;
  }
  /// The first place where it becomes positive, as a share of the step; infinite without one.
  double rise() const {
    for (const double x : zeros)
      if (std::abs(x) < 0.5 && slope + 2 * bend * x > 0) return x + 0.5;
    return INFINITY;
  }
};

}  // namespace

MissedChanges missed_changes(const StepView& whole, const StepView& first, const StepView& second) {
  MissedChanges found;
  for (std::size_t k = 0; k < whole.pulls.size(); ++k) {
    const auto &early = first.pulls[k], &late = second.pulls[k];
    const Parabola pull(whole.pulls[k].rate, early.rate, late.rate);
    // Pulls of one sign are as they were taken; rounding may place a zero at an end.
    if (!std::isfinite(pull.zeros[0])) continue;
    found.rate = std::max(
        {found.rate, pull.part(early.pressed ? 1 : -1, -0.5, 0), pull.part(late.pressed ? 1 : -1, 0, 0.5)});
    found.first = std::min(found.first, pull.rise());
  }
  for (std::size_t k = 0; k < whole.holds.size(); ++k) {
    if (!whole.holds[k].held || !first.holds[k].held || !second.holds[k].held) continue;
    for (const std::size_t side : {0U, 1U}) {
      const Parabola beyond(whole.holds[k].beyond[side], first.holds[k].beyond[side],
                            second.holds[k].beyond[side]);
      if (!std::isfinite(beyond.zeros[0])) continue;
      found.rate = std::max(found.rate, beyond.part(1, -0.5, 0.5));
      found.first = std::min(found.first, beyond.rise());
    }
  }
  return found;
}

StepPair::StepPair(const System& system, const ErrorNorm& norm, double speed_scale)
    : system_(system), norm_(norm), speed_scale_(speed_scale) {
  const auto n = static_cast<std::size_t>(system.n());
  for (auto* x : {&middle_q, &middle_v, &start.q, &start.v}) x->resize(n);
  for (auto* place : {&start, &whole_})
    place->log = ContactLog(system.contacts());  // with room for its events
  for (auto* view : {&view_whole_, &view_first_, &view_second_})
    view->pulls.reserve(static_cast<std::size_t>(system.contacts()));
}

bool StepPair::take(MoreauStepper& moreau, double h) {
  const double t = start.t + h;
  middle_t = start.t + 0.5 * h;
  slip_reversal_ = 0;
  const auto note = [&](StepView& view) {
    list_modes(moreau.contacts(), moreau.problem(), view.modes);
    list_pulls(moreau.data(), moreau.contacts(), moreau.problem(), view.pulls);
    list_holds(moreau.data(), moreau.contacts(), moreau.problem(), view.holds);
    slip_reversal_ =
        std::max(slip_reversal_, slip_reversal_error(moreau.data(), moreau.contacts(), moreau.problem()));
  };
  const auto add_to = [&](Forces& sum) {
    if (!watching_) return;
    sum.add(1, moreau.smooth());
    sum.add(1, moreau.within());
  };
  if (!moreau.advance(t, StepReach::closed)) return false;
  note(view_whole_);
  moreau.keep(whole_);
  for (auto* sum : {&smooth, &whole_smooth_, &within}) sum->clear();
  add_to(whole_smooth_);
  moreau.go_back(start);
  if (!moreau.advance(middle_t, StepReach::closed)) return false;
  note(view_first_);
  std::copy_n(moreau.q(), system_.n(), middle_q.begin());
  std::copy_n(moreau.v(), system_.n(), middle_v.begin());
  add_to(smooth);
  if (!moreau.advance(t, StepReach::closed)) return false;
  note(view_second_);
  missed_ = missed_changes(view_whole_, view_first_, view_second_);
  add_to(smooth);
  return true;
}

void StepPair::extrapolate(MoreauStepper& moreau) {
  moreau.extrapolate(whole_);
  if (!watching_) return;
  smooth.add(1.0 / 3, smooth);
  smooth.add(-1.0 / 3, whole_smooth_);
}

/// Both the full step and its halves miss the speed of sliding that reversed within a step, which they
/// take as reversed throughout, the rate of a contact that separates or closes within a step, and that of
/// friction that slips in a part of it.
double StepPair::error(const MoreauStepper& moreau) const {
  return std::max({difference(moreau) / (alike() ? 3 : 1), path_error(moreau),
                   unseen(std::max(slip_reversal_, missed_.rate))});
}

/// Of a motion that constraints prescribe, all steps have the same ends, whatever lies between. One cubic
/// over the step differs from the middle by sixteen times the error of the two cubics of the path.
double StepPair::path_error(const MoreauStepper& moreau) const {
  const double h = moreau.t() - start.t;
  double worst = 0;
  for (std::size_t i = 0; i < middle_q.size(); ++i) {
    const double cubic = 0.5 * (start.q[i] + moreau.q()[i]) + h / 8 * (start.v[i] - moreau.v()[i]);
    const double ratio = std::abs(middle_q[i] - cubic) / (16 * norm_.tolerance * norm_.absolute[i]);
    if (!(ratio <= worst)) worst = ratio;
  }
  return worst < greatest_error ? worst : greatest_error;
}

double StepPair::difference(const MoreauStepper& moreau) const {
  const auto n = static_cast<std::size_t>(system_.n());
  double worst = 0;
  const auto take = [&](std::size_t i, double x, double y) {
    const double ratio =
        std::abs(x - y) / (norm_.tolerance * (norm_.absolute[i] + norm_.relative[i] * std::abs(x)));
    if (!(ratio <= worst)) worst = ratio;
  };
  for (std::size_t i = 0; i < n; ++i) {
    take(i, moreau.q()[i], whole_.q[i]);
    take(n + i, moreau.v()[i], whole_.v[i]);
  }
  for (std::size_t k = 0; k < whole_.z.size(); ++k) {
    const double ratio =
        std::abs(moreau.z()[k] - whole_.z[k]) / (norm_.tolerance * system_.state_scale(static_cast<int>(k)));
    if (!(ratio <= worst)) worst = ratio;
  }
  return worst < greatest_error ? worst : greatest_error;
}

/// Error estimate of a rate (m/s) that both the full step and its halves miss.
double StepPair::unseen(double rate) const {
  if (rate == 0) return 0;
  double speed = rate;
  for (int i = 0; i < system_.n(); ++i)
    if (!system_.is_angle(i)) speed = std::max(speed, std::abs(start.v[static_cast<std::size_t>(i)]));
  return rate / (norm_.tolerance * (speed_scale_ + speed));
}

void StepPair::interpolate(const MoreauStepper& moreau, double t, double* q, double* v) const {
  const bool early = t < middle_t;
  const double a = early ? start.t : middle_t, b = early ? middle_t : moreau.t(), h = b - a;
  const double *qa = early ? start.q.data() : middle_q.data(), *va = early ? start.v.data() : middle_v.data();
  const double *qb = early ? middle_q.data() : moreau.q(), *vb = early ? middle_v.data() : moreau.v();
  const double s = h > 0 ? std::min((t - a) / h, 1.0) : 1, r = 1 - s;
  for (int i = 0; i < system_.n(); ++i) {
    q[i] = r * r * (1 + 2 * s) * qa[i] + s * s * (3 - 2 * s) * qb[i] + h * s * r * (r * va[i] - s * vb[i]);
    const double mean = h > 0 ? (qb[i] - qa[i]) / h : 0;
    v[i] = 6 * s * r * mean + r * (1 - 3 * s) * va[i] + s * (3 * s - 2) * vb[i];
  }
}

void StepPair::watch_forces(bool on) {
  watching_ = on;
  if (on && smooth.elements.empty()) smooth = whole_smooth_ = within = system_.make_forces();
}

void StepPair::take_forces(const MoreauStepper& moreau) {
  if (!watching_) return;
  smooth.clear();
  smooth.add(1, moreau.smooth());
  within.clear();
  within.add(1, moreau.within());
}

}  // namespace freeplay
