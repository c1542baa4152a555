// A step and its two halves: what they differ by, what goes on, and what is shown of it.
#include <algorithm>
#include <cmath>

#include "formulations/time_stepping/controlled.hpp"

namespace freeplay {

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

}  // namespace freeplay
