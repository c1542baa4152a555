#include "formulations/contact/impact_phases.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {
namespace {

constexpr double stopped = 1e-13;  // relative to the greatest rate
constexpr int most_pieces = 16;    // per contact; beyond this the rest is one piece

}  // namespace

/// Solves for the impulses of λ from `from` to `to`, starting from these rates; writes the problem,
/// piece_ and trial_.
bool ImpactPhases::piece(const Course& course, double from, double to, const Eigen::VectorXd& rates) {
  const int m = course.island.problem.rows;
  course.island.pose(piece_);
  course.island.problem.b.head(m) = rates.head(m);
  for (std::size_t i = 0; i < piece_.size(); ++i) {
    auto& c = piece_[i];
    auto& x = course.island.problem.unknowns[i];
    c.impulse_n = c.impulse_t = 0;
    if (course.phase == Phase::compression) {
      x.target_n = std::min(0.0, (1 - to) * course.island.before[c.normal]);
    } else {
      c.impulse_n = (to - from) * (course.ratio[i] * compression_[i].impulse_n);
      course.island.problem.b.head(m) += c.impulse_n * course.island.problem.D.col(c.normal).head(m);
      x.bound = c.friction * c.impulse_n;
    }
  }
  if (!course.island.solve()) return false;
  trial_ = rates;
  for (std::size_t i = 0; i < piece_.size(); ++i) {
    piece_[i].impulse_n += course.island.problem.unknowns[i].impulse_n;
    piece_[i].impulse_t = course.island.problem.unknowns[i].impulse_t;
    course.island.act(trial_, piece_[i]);
  }
  return true;
}

/// Difference (m/s) between a contact's rate and the lowest rate that the phase admits at λ; zero
/// for a pressed contact.
double ImpactPhases::ahead(const Course& course, const ImpactContact& c, double at,
                           const Eigen::VectorXd& rates) {
  return rates[c.normal] -
         (course.phase == Phase::compression ? std::min(0.0, (1 - at) * course.island.before[c.normal]) : 0);
}

/// Whether the modes are constant within the last piece: contacts that slide at its beginning slide
/// in the same direction to its end, or stop there by sliding friction alone, and contacts above
/// their lowest rate have no impulse.
bool ImpactPhases::goes_on(const Course& course, double from, const Eigen::VectorXd& rates) const {
  const double none = course.none;
  for (std::size_t i = 0; i < piece_.size(); ++i) {
    const auto& c = piece_[i];
    if (ahead(course, c, from, rates) > none &&
        course.island.problem.unknowns[i].impulse_n * course.island.problem.D(c.normal, c.normal) > none)
      return false;
    if (c.tangent < 0 || rates[c.tangent] == 0) continue;
    const double way = std::copysign(1.0, rates[c.tangent]), end = way * trial_[c.tangent];
    if (end > none) continue;
    if (end < -none || -way * c.impulse_t < c.friction * c.impulse_n * (1 - 1e-9)) return false;
  }
  return true;
}

/// The λ of the first change, extrapolated linearly from two values of λ before it; the present λ
/// if the change is now.
double ImpactPhases::first_change(const Course& course, double from, const Eigen::VectorXd& rates,
                                  double early, double late) const {
  const double none = course.none;
  double first = INFINITY;
  const auto reaches = [&](double was, double is) {
    if (std::abs(is) <= none) first = late;
    if ((was - is) * is > 0) first = std::min(first, late + (late - early) * is / (was - is));
  };
  for (const auto& c : piece_) {
    if (ahead(course, c, from, rates) > none)
      reaches(ahead(course, c, early, early_), ahead(course, c, late, late_));
    if (c.tangent >= 0 && rates[c.tangent] != 0) reaches(early_[c.tangent], late_[c.tangent]);
  }
  return first;
}

/// Solves the piece from `from` to the first change and returns its end; nothing if no problem was
/// solved.
std::optional<double> ImpactPhases::piece_until_change(const Course& course, double from,
                                                       const Eigen::VectorXd& rates) {
  double early = from, late = from, high = 1, solved = 1;
  early_ = late_ = rates;
  for (int i = 0; i < 80 && high - late > 1e-16; ++i) {
    double to = late > from && i < 20 ? first_change(course, from, rates, early, late) : INFINITY;
    if (to == late) break;
    if (!(to > late && to < high)) to = 0.5 * (late + high);
    if (!piece(course, from, to, rates)) return {};
    solved = to;
    if (!goes_on(course, from, rates)) {
      high = to;
      continue;
    }
    early = late;
    late = to;
    std::swap(early_, late_);
    late_ = trial_;
  }
  if (late == from) late = high;
  if (late > 1 - 1000 * stopped) late = 1;  // contacts that stop at the end of the phase
  if (solved != late && !piece(course, from, late, rates)) return {};
  return late;
}

/// Integrates `rates` through a phase; `done` gets the sums of impulses and works.
bool ImpactPhases::follow(const Course& course, Eigen::VectorXd& rates, std::vector<ImpactContact>& done) {
  piece_ = done;
  for (auto& c : done) c.impulse_n = c.impulse_t = c.work_n = c.work_t = 0;
  const double none = course.none;
  double at = 0;
  for (std::size_t pieces = 0; at < 1; ++pieces) {
    if (!piece(course, at, 1, rates)) return false;
    double to = 1;
    if (pieces < most_pieces * done.size() && !goes_on(course, at, rates)) {
      const auto end = piece_until_change(course, at, rates);
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
      if (std::abs(trial_[c.tangent]) <= none) trial_[c.tangent] = 0;  // sliding has stopped
    }
    rates = trial_;
    at = to;
  }
  return true;
}

bool ImpactPhases::compress(ImpactIsland& island, const std::vector<ImpactContact>& contacts) {
  compression_ = contacts;
  after_compression_ = island.before;
  const std::vector<double> no_ratio;
  const Course course{island, Phase::compression, no_ratio, stopped * island.greatest_rate()};
  if (!follow(course, after_compression_, compression_)) return false;
  // Rates at the level of rounding are set to zero: the expansion would take them as motion.
  const double none = 1e-10 * island.greatest_rate();
  for (double& rate : after_compression_)
    if (std::abs(rate) <= none) rate = 0;
  return true;
}

bool ImpactPhases::expand(ImpactIsland& island, std::vector<ImpactContact>& contacts,
                          const std::vector<double>& ratio) {
  expansion_ = contacts;
  after_ = after_compression_;
  const Course course{island, Phase::expansion, ratio, stopped * island.greatest_rate()};
  if (!follow(course, after_, expansion_)) return false;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    contacts[i].impulse_n = compression_[i].impulse_n + expansion_[i].impulse_n;
    contacts[i].impulse_t = compression_[i].impulse_t + expansion_[i].impulse_t;
  }
  return true;
}

void ImpactPhases::add_works(ImpactIsland& island) const {
  for (const auto* phase : {&compression_, &expansion_})
    for (const auto& c : *phase) {
      island.normal_work += c.work_n;
      island.tangential_work += c.work_t;
    }
}

}  // namespace freeplay
