#include "formulations/time_stepping/step_pair.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {

StepPair::StepPair(const System& system, const ErrorNorm& norm, double speed_scale)
    : system_(system), norm_(norm), speed_scale_(speed_scale) {
  const auto n = static_cast<std::size_t>(system.n());
  for (auto* x : {&middle_q, &middle_v, &start.q, &start.v}) x->resize(n);
  for (auto* place : {&start, &whole_})
    place->log = ContactLog(system.contacts());  // with room for its events
  for (auto* pulls : {&pulls_whole_, &pulls_first_, &pulls_second_})
    pulls->reserve(static_cast<std::size_t>(system.contacts()));
}

bool StepPair::take(MoreauStepper& moreau, double h) {
  const double t = start.t + h;
  middle_t = start.t + 0.5 * h;
  const auto note = [&](std::vector<signed char>& modes) {
    list_modes(moreau.contacts(), moreau.problem(), modes);
    return turned_round(moreau.data(), moreau.contacts(), moreau.problem());
  };
  const auto add_to = [&](Forces& sum) {
    if (!watching_) return;
    sum.add(1, moreau.smooth());
    sum.add(1, moreau.within());
  };
  if (!moreau.advance(t, StepReach::closed)) return false;
  turned_ = note(modes_whole_);
  list_pulls(moreau.data(), moreau.contacts(), moreau.problem(), pulls_whole_);
  moreau.keep(whole_);
  for (auto* sum : {&smooth, &whole_smooth_, &within}) sum->clear();
  add_to(whole_smooth_);
  moreau.go_back(start);
  if (!moreau.advance(middle_t, StepReach::closed)) return false;
  list_pulls(moreau.data(), moreau.contacts(), moreau.problem(), pulls_first_);
  turned_ = std::max(turned_, note(modes_first_));
  std::copy_n(moreau.q(), system_.n(), middle_q.begin());
  std::copy_n(moreau.v(), system_.n(), middle_v.begin());
  add_to(smooth);
  if (!moreau.advance(t, StepReach::closed)) return false;
  list_pulls(moreau.data(), moreau.contacts(), moreau.problem(), pulls_second_);
  misjudged_ = misjudged(pulls_whole_, pulls_first_, pulls_second_);
  turned_ = std::max(turned_, note(modes_second_));
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
/// take as reversed throughout, and the rate of a contact that separates or closes within a step.
double StepPair::error(const MoreauStepper& moreau) const {
  return std::max({difference(moreau) / (alike() ? 3 : 1), path_error(moreau),
                   unseen(std::max(turned_, misjudged_.rate))});
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
  return worst < 1e10 ? worst : 1e10;
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
  return worst < 1e10 ? worst : 1e10;
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
