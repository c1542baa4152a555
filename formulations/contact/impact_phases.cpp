// Compression and expansion of several contacts that D couples, with Coulomb's friction along each. λ runs through a phase
// from 0 to 1: in compression what approaches is slowed down together, u_N ≥ (1 − λ) u_N⁻, in expansion the impulses
// r P_C grow together, λ r P_C. Within a piece of it in which nothing that slides stops, and nothing that bore no impulse begins to, all
// impulses and rates are linear in λ and one contact problem has them; where that happens a new piece begins. So friction always opposes the sliding of
// its instant, and never drives. The path is an assumption, as of any law for impacts at once; a single contact has the one that
// its normal impulse goes (routh.hpp), and this is the same.
#include <algorithm>
#include <cmath>

#include "formulations/contact/impact.hpp"

namespace freeplay {
namespace {

constexpr double stopped = 1e-13;  // of the greatest rate
constexpr int most_pieces = 16;    // a contact's; beyond, what is left is one piece

}  // namespace

/// Solves for the impulses of λ from `from` to `to`, from these rates on, into problem_ and trial_.
bool ImpactProblem::piece(Phase phase, const std::vector<double>& ratio, double from, double to,
                          const Eigen::VectorXd& rates) {
  const int m = problem_.rows;
  prepare(piece_);
  problem_.b.head(m) = rates.head(m);
  for (std::size_t i = 0; i < piece_.size(); ++i) {
    auto& c = piece_[i];
    auto& x = problem_.unknowns[i];
    c.impulse_n = c.impulse_t = 0;
    if (phase == Phase::compression) {
      x.target_n = std::min(0.0, (1 - to) * before_[c.normal]);
    } else {
      c.impulse_n = (to - from) * (ratio[i] * compression_[i].impulse_n);
      problem_.b.head(m) += c.impulse_n * problem_.D.col(c.normal).head(m);
      x.bound = c.friction * c.impulse_n;
    }
  }
  if (!solve_problem()) return false;
  trial_ = rates;
  for (std::size_t i = 0; i < piece_.size(); ++i) {
    piece_[i].impulse_n += problem_.unknowns[i].impulse_n;
    piece_[i].impulse_t = problem_.unknowns[i].impulse_t;
    act(trial_, piece_[i]);
  }
  return true;
}

/// What a contact's approach lies above the least that the phase asks of it at λ: m/s; zero where it bears.
double ImpactProblem::ahead(Phase phase, const ImpactContact& c, double at,
                            const Eigen::VectorXd& rates) const {
  return rates[c.normal] - (phase == Phase::compression ? std::min(0.0, (1 - at) * before_[c.normal]) : 0);
}

/// Whether nothing has changed within the piece solved last: what slides at its begin slides the same way to its end, or stops there
/// by sliding friction alone; what is ahead bears nothing.
bool ImpactProblem::goes_on(Phase phase, double from, const Eigen::VectorXd& rates) const {
  const double none = stopped * before_.cwiseAbs().maxCoeff();
  for (std::size_t i = 0; i < piece_.size(); ++i) {
    const auto& c = piece_[i];
    if (ahead(phase, c, from, rates) > none &&
        problem_.unknowns[i].impulse_n * problem_.D(c.normal, c.normal) > none)
      return false;
    if (c.tangent < 0 || rates[c.tangent] == 0) continue;
    const double way = std::copysign(1.0, rates[c.tangent]), end = way * trial_[c.tangent];
    if (end > none) continue;
    if (end < -none || -way * c.impulse_t < c.friction * c.impulse_n * (1 - 1e-9)) return false;
  }
  return true;
}

/// Where something changes first, by the line through two instants before that: λ. At once where it changes now.
double ImpactProblem::first_change(Phase phase, double from, const Eigen::VectorXd& rates, double early,
                                   double late) const {
  const double none = stopped * before_.cwiseAbs().maxCoeff();
  double first = INFINITY;
  const auto reaches = [&](double was, double is) {
    if (std::abs(is) <= none) first = late;
    if ((was - is) * is > 0) first = std::min(first, late + (late - early) * is / (was - is));
  };
  for (const auto& c : piece_) {
    if (ahead(phase, c, from, rates) > none)
      reaches(ahead(phase, c, early, early_), ahead(phase, c, late, late_));
    if (c.tangent >= 0 && rates[c.tangent] != 0) reaches(early_[c.tangent], late_[c.tangent]);
  }
  return first;
}

/// The piece from `from` to where something changes first: its end, or nothing where no problem was solved.
std::optional<double> ImpactProblem::piece_until_change(Phase phase, const std::vector<double>& ratio,
                                                        double from, const Eigen::VectorXd& rates) {
  double early = from, late = from, high = 1, solved = 1;
  early_ = late_ = rates;
  for (int i = 0; i < 80 && high - late > 1e-16; ++i) {
    double to = late > from && i < 20 ? first_change(phase, from, rates, early, late) : INFINITY;
    if (to == late) break;
    if (!(to > late && to < high)) to = 0.5 * (late + high);
    if (!piece(phase, ratio, from, to, rates)) return {};
    solved = to;
    if (!goes_on(phase, from, rates)) {
      high = to;
      continue;
    }
    early = late;
    late = to;
    std::swap(early_, late_);
    late_ = trial_;
  }
  if (late == from) late = high;
  if (late > 1 - 1000 * stopped) late = 1;  // what stops with the phase
  if (solved != late && !piece(phase, ratio, from, late, rates)) return {};
  return late;
}

/// Takes `rates` through a phase; `done` gets what it adds up to.
bool ImpactProblem::follow(Phase phase, const std::vector<double>& ratio, Eigen::VectorXd& rates,
                           std::vector<ImpactContact>& done) {
  piece_ = done;
  for (auto& c : done) c.impulse_n = c.impulse_t = c.work_n = c.work_t = 0;
  const double none = stopped * before_.cwiseAbs().maxCoeff();
  double at = 0;
  for (std::size_t pieces = 0; at < 1; ++pieces) {
    if (!piece(phase, ratio, at, 1, rates)) return false;
    double to = 1;
    if (pieces < most_pieces * done.size() && !goes_on(phase, at, rates)) {
      const auto end = piece_until_change(phase, ratio, at, rates);
      if (!end) return false;
      to = *end;
    }
    for (std::size_t i = 0; i < done.size(); ++i) {
      auto& c = done[i];
      const auto& p = piece_[i];
      c.impulse_n += p.impulse_n;
      c.impulse_t += p.impulse_t;
      c.work_n += 0.5 * p.impulse_n * (rates[c.normal] + trial_[c.normal]);
      if (c.tangent < 0) continue;
      c.work_t += 0.5 * p.impulse_t * (rates[c.tangent] + trial_[c.tangent]);
      if (std::abs(trial_[c.tangent]) <= none) trial_[c.tangent] = 0;  // it has stopped
    }
    rates = trial_;
    at = to;
  }
  return true;
}

bool ImpactProblem::compress(const std::vector<ImpactContact>& contacts) {
  compression_ = contacts;
  after_compression_ = before_;
  if (!follow(Phase::compression, {}, after_compression_, compression_)) return false;
  // What has stopped has stopped: rounding left of it would be a motion of its own to expansion.
  const double none = 1e-10 * before_.cwiseAbs().maxCoeff();
  for (double& rate : after_compression_)
    if (std::abs(rate) <= none) rate = 0;
  return true;
}

/// Expansion with the given ratios of impulses, after compress().
bool ImpactProblem::expand(std::vector<ImpactContact>& contacts, const std::vector<double>& ratio) {
  expansion_ = contacts;
  after_ = after_compression_;
  if (!follow(Phase::expansion, ratio, after_, expansion_)) return false;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    contacts[i].impulse_n = compression_[i].impulse_n + expansion_[i].impulse_n;
    contacts[i].impulse_t = compression_[i].impulse_t + expansion_[i].impulse_t;
  }
  return true;
}

}  // namespace freeplay
