#include "analysis/orbit_shooting.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "analysis/varied_key.hpp"
#include "dynamics/system.hpp"
#include "mechanism/scene.hpp"
#include "numerics/dense.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

/// The search has arrived where the states agree to this multiple of nonsmooth.tolerance; the map of all
/// periods does the rest.
constexpr double near_enough = 10;

/// A period with the local coordinates of its beginning.
struct Period {
  ReturnMap map;
  ReturnPoint point;
};

class PeriodsOfMotion {
 public:
  PeriodsOfMotion(const Scene& scene, const System& system, double period, StopToken stop)
      : scene_(scene), system_(system), period_(period), stop_(stop) {}

  /// The motion from a state on; false if it stops or has no derivative.
  bool follow(const SectionState& start, int periods) {
    const ReturnMap map(scene_, system_, period_, false, stop_);
    SectionState s = start;
    for (int k = 0; k < periods; ++k) {
      auto& one = all_.emplace_back(Period{map, {}});
      if (!evaluate(one, s)) return false;
      s = one.point.end.state;
    }
    close();
    return true;
  }
  double greatest() const { return greatest_; }
  const SectionState& first() const { return all_.front().point.state; }

  /// A Newton step, shortened until the greatest difference falls; false if there is none.
  bool advance() {
    const auto step = newton_step();
    for (double share = 1; share >= least_newton_share; share *= 0.5) {
      PeriodsOfMotion next(scene_, system_, period_, stop_);
      if (!next.move_from(*this, share * step) || !(next.greatest_ < greatest_)) continue;
      all_ = std::move(next.all_);
      greatest_ = next.greatest_;
      return true;
    }
    return false;
  }

 private:
  const Period& after(std::size_t k) const { return all_[(k + 1) % all_.size()]; }

  bool evaluate(Period& one, SectionState s) const {
    if (!one.map.take_closed(s).empty()) return false;
    one.map.chart(s);
    if (!one.map.move(VectorXd::Zero(one.map.size()), s).empty()) return false;
    one.map.chart(s);
    one.point = one.map.at(s);
    return one.point.failure.empty();
  }

  /// The differences between the end of each period and the beginning of the next.
  void close() {
    greatest_ = 0;
    for (std::size_t k = 0; k < all_.size(); ++k) {
      const auto change = difference(k);
      const auto& scales = all_[k].point.end.scales;
      for (std::size_t i = 0; i < change.size(); ++i)
        greatest_ = std::max(greatest_, std::abs(change[i]) / scales[i]);
    }
  }
  std::vector<double> difference(std::size_t k) const {
    auto list = all_of(all_[k].point.end.state);
    const auto to = all_of(after(k).point.state);
    for (std::size_t i = 0; i < list.size(); ++i) list[i] -= to[i];
    for (int i = 2; i < system_.n(); i += 3) {
      auto& angle = list[static_cast<std::size_t>(i)];
      angle = std::remainder(angle, 2 * std::numbers::pi);
    }
    return list;
  }

  /// Solves D_k u_k − u_{k+1} = −r_k.
  VectorXd newton_step() const {
    Eigen::Index size = 0;
    std::vector<Eigen::Index> begin;
    for (const auto& one : all_) {
      begin.push_back(size);
      size += one.map.size();
    }
    MatrixXd A = MatrixXd::Zero(size, size);
    VectorXd b = VectorXd::Zero(size);
    for (std::size_t k = 0; k < all_.size(); ++k) {
      const auto& next = after(k).map;
      const auto row = begin[(k + 1) % all_.size()], rows = next.size();
      b.segment(row, rows) = -next.local(difference(k));
      for (Eigen::Index c = 0; c < all_[k].map.size(); ++c)
        A.block(row, begin[k] + c, rows, 1) +=
            next.local(all_[k].point.end.columns[static_cast<std::size_t>(c)]);
      A.block(row, row, rows, rows) -= MatrixXd::Identity(rows, rows);
    }
    return MinimumNorm(A, neutral_direction).solve(b);
  }

  bool move_from(const PeriodsOfMotion& from, const VectorXd& u) {
    Eigen::Index begin = 0;
    for (const auto& one : from.all_) {
      auto s = one.point.state;
      if (!one.map.move(u.segment(begin, one.map.size()), s).empty()) return false;
      begin += one.map.size();
      auto& next = all_.emplace_back(Period{one.map, {}});
      next.map.chart(s);
      next.point = next.map.at(s);
      if (!next.point.failure.empty()) return false;
    }
    close();
    return true;
  }

  const Scene& scene_;
  const System& system_;
  double period_;
  StopToken stop_;
  std::vector<Period> all_;
  double greatest_ = INFINITY;
};

}  // namespace

std::optional<Shooting> shoot_periods(const Scene& scene, const System& system, double period, int periods,
                                      const SectionState& start, StopToken stop) {
  PeriodsOfMotion motion(scene, system, period, stop);
  if (!motion.follow(start, periods)) return {};
  Shooting found;
  while (motion.greatest() > near_enough * scene.nonsmooth.tolerance) {
    if (found.iterations == most_newton_steps || !motion.advance()) return {};
    ++found.iterations;
  }
  found.first = motion.first();
  return found;
}

}  // namespace freeplay
