#include "formulations/time_stepping/onset_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace freeplay {
namespace {

template <class Half>
std::array<Half, 2> halves(const MoreauStepper& moreau, const StepPair& pair) {
  const double *q = pair.middle_q.data(), *v = pair.middle_v.data();
  return {Half{pair.start.t, pair.middle_t, pair.start.q.data(), pair.start.v.data(), q, v},
          Half{pair.middle_t, moreau.t(), q, v, moreau.q(), moreau.v()}};
}

}  // namespace

OnsetSearch::OnsetSearch(const System& system, double tolerance, double length)
    : system_(system),
      tolerance_(tolerance),
      length_(length),
      e_(system.make_evaluation()),
      q_(system.n()),
      v_(system.n()) {
  for (auto* x : {&bounds_.speed, &bounds_.acceleration}) x->resize(static_cast<std::size_t>(system.n()));
}

double OnsetSearch::near(int contact, const double* q) const {
  return std::max(0.1 * tolerance_ * system_.contact_facts(contact).clearance,
                  4 * gap_rounding(system_, contact, q));
}

std::optional<OnsetSearch::Onset> OnsetSearch::first_onset(const MoreauStepper& moreau,
                                                           const StepPair& pair) {
  std::optional<Onset> first;
  bounded_ = true;
  unseen_ = 0;
  for (const auto& half : halves<Half>(moreau, pair)) {
    bool enclosed = false;
    for (int k = 0; k < system_.contacts(); ++k) {
      if (moreau.contacts()[k].closed) continue;
      if (!enclosed) enclose(half);
      enclosed = true;
      const auto onset = onset_in(k, half, moreau, pair);
      if (onset && (!first || onset->t < first->t)) first = onset;
    }
    if (first) break;
  }
  return first;
}

std::optional<OnsetSearch::Onset> OnsetSearch::onset_in(int k, const Half& half, const MoreauStepper& moreau,
                                                        const StepPair& pair) {
  ContactRow row;
  const auto at = [&](double t, const double* q, const double* v) {
    system_.place(t, q, e_);
    system_.contact(k, q, v, e_, row);
    return Watched{row.gap, row.normal.dot(v)};
  };
  const auto begin = at(half.a, half.qa, half.va), end = at(half.b, half.qb, half.vb);
  const auto motion = system_.gap_motion(k, bounds_, half.qb, e_);
  bounded_ = bounded_ && std::isfinite(motion.acceleration);
  double unseen = 0;
  const double rounding = gap_rounding(system_, k, half.qb);
  const auto look = [&](double t) {
    pair.interpolate(moreau, t, q_.data(), v_.data());
    return at(t, q_.data(), v_.data());
  };
  auto start = begin;
  if (start.value <= near(k, moreau.q()) && start.rate > 0) start.value = std::max(start.value, 0.0);
  const auto t = first_loss(look, half.a, half.b, start, end, motion, rounding, unseen);
  unseen_ = std::max(unseen_, unseen / system_.contact_facts(k).clearance);
  if (!t) return std::nullopt;
  return Onset{k, *t, look(*t).rate};
}

std::optional<double> OnsetSearch::first_kink(const MoreauStepper& moreau, const StepPair& pair) {
  for (const auto& half : halves<Half>(moreau, pair)) {
    enclose(half);
    if (const auto t = kink_in(half, moreau, pair)) return t;
  }
  return std::nullopt;
}

std::optional<double> OnsetSearch::first_limit(const MoreauStepper& moreau, const StepPair& pair) {
  const auto n = static_cast<std::size_t>(system_.n());
  const auto z = moreau.z();
  const Limits::Interval step{pair.start.t, moreau.t()};
  x_.resize(2 * n + z.size());
  const auto at = [&](double t) -> const std::vector<double>& {
    pair.interpolate(moreau, t, x_.data(), x_.data() + n);
    const double s = (t - step.t_old) / (step.t - step.t_old);
    for (std::size_t k = 0; k < z.size(); ++k) x_[2 * n + k] = pair.start.z[k] + s * (z[k] - pair.start.z[k]);
    return x_;
  };
  const auto found = limits_.first(system_, 2 * system_.n(), step, INFINITY, 10 * tolerance_, at);
  return found.found() ? std::optional(found.t) : std::nullopt;
}

std::optional<double> OnsetSearch::kink_in(const Half& half, const MoreauStepper& moreau,
                                           const StepPair& pair) {
  std::optional<double> first;
  const double near = 10 * tolerance_ * length_;
  for (int k = 0; k < system_.phases(); ++k) {
    const auto& phase = system_.phase(k);
    if (phase.swept) continue;
    const double rounding = phase.of == Phase::Of::angle ? 10 * tolerance_ : near;
    const auto now = phase.at(pair.start.q.data(), pair.start.v.data());
    const auto piece = phase.piece(now.value, now.rate >= 0, rounding);
    for (const bool up : {false, true}) {
      const double end = up ? piece.high : piece.low;
      if (!std::isfinite(end)) continue;
      // A length cannot be below a kink by more than the kink's own length. For kinks near zero, a
      // tenth of that length replaces the tolerance.
      const double least = phase.of == Phase::Of::distance && end < near ? 0.1 * end : rounding;
      const auto left = [&](const double* q, const double* v) {
        const auto x = phase.at(q, v);
        return up ? Watched{end - x.value, -x.rate} : Watched{x.value - end, x.rate};
      };
      const auto look = [&](double t) {
        pair.interpolate(moreau, t, q_.data(), v_.data());
        return left(q_.data(), v_.data());
      };
      double unseen = 0;
      const auto t = first_loss(look, half.a, half.b, left(half.qa, half.va), left(half.qb, half.vb),
                                phase.motion(bounds_, piece, up, half.qb), least, unseen);
      if (t && (!first || *t < *first)) first = t;
    }
  }
  return first;
}

/// Bounds of a Hermite cubic, whose accelerations are linear.
void OnsetSearch::enclose(const Half& x) {
  const auto n = static_cast<std::size_t>(system_.n());
  const double h = x.b - x.a;
  bounds_.duration = h;
  for (std::size_t i = 0; i < n; ++i) {
    const double mean = (x.qb[i] - x.qa[i]) / h, a0 = (6 * mean - 4 * x.va[i] - 2 * x.vb[i]) / h,
                 a1 = (2 * x.va[i] + 4 * x.vb[i] - 6 * mean) / h;
    const auto of = cubic_bounds(h, x.qa[i], x.va[i], a0, x.qb[i], x.vb[i], a1);
    bounds_.speed[i] = of.speed;
    bounds_.acceleration[i] = of.acceleration;
  }
}

}  // namespace freeplay
