#include "analysis/play/play_part.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace freeplay {

bool PlayPart::has_positions(const std::vector<LooseComponent>& components) const {
  return std::ranges::all_of(components, [&](const auto& c) {
    const Eigen::VectorXd lowest = low.segment(c.first, c.size()), highest = high.segment(c.first, c.size());
    return Eigen::VectorXd::Zero(c.size()).cwiseMax(lowest).cwiseMin(highest).norm() <= 1;
  });
}

Eigen::VectorXd PlayPart::nearest(const LooseComponent& c, const Eigen::VectorXd& target) const {
  // Karush, Kuhn and Tucker: u is t · target clamped to the box, with t = 1, or t < 1 and |u| = 1.
  const Eigen::VectorXd lowest = low.segment(c.first, c.size()), highest = high.segment(c.first, c.size());
  const auto clamped = [&](double t) -> Eigen::VectorXd {
    return (t * target).cwiseMax(lowest).cwiseMin(highest);
  };
  Eigen::VectorXd u = clamped(1);
  if (!c.disc || u.squaredNorm() <= 1) return u;
  if (u = target / target.norm(); (u.array() >= lowest.array() && u.array() <= highest.array()).all())
    return u;
  double inside = 0, outside = 1;
  constexpr int halvings = 200;  // of t, which may be tiny
  for (int i = 0; i < halvings && inside < outside; ++i) {
    const double t = 0.5 * (inside + outside);
    if (t == inside || t == outside) break;
    (clamped(t).squaredNorm() <= 1 ? inside : outside) = t;
  }
  return clamped(inside);
}

Eigen::VectorXd PlayPart::farthest(const LooseComponent& c, const Eigen::VectorXd& a) const {
  constexpr double far = 1e20;
  return nearest(c, far / a.norm() * a);
}

void PlayPart::restrict_to_farthest(const LooseComponent& c, const Eigen::VectorXd& a, double error) {
  const double size = a.norm();
  if (!(error < size)) return;
  if (!c.disc) {
    (a[0] > 0 ? low : high)[c.first] = (a[0] > 0 ? high : low)[c.first];
    return;
  }
  // Both entries of the farthest position are monotonic in the angle of the direction, between the axes.
  constexpr double beside = 1e-9, rounding_of_ends = 1e-13;
  const double middle = std::atan2(a[1], a[0]), half = std::asin(error / size) + beside;
  const PlayPart part = *this;
  Eigen::Vector2d least = Eigen::Vector2d::Constant(1), most = -least;
  const auto include = [&](double angle) {
    const Eigen::Vector2d u = part.farthest(c, Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    least = least.cwiseMin(u), most = most.cwiseMax(u);
  };
  include(middle - half), include(middle + half);
  for (int quarter = -4; quarter <= 4; ++quarter)
    if (const double axis = 0.5 * std::numbers::pi * quarter; std::abs(axis - middle) < half)
      include(axis - beside), include(axis + beside);
  for (int i = 0; i < 2; ++i) {
    low[c.first + i] = std::max(low[c.first + i], least[i] - rounding_of_ends);
    high[c.first + i] = std::min(high[c.first + i], most[i] + rounding_of_ends);
  }
}

std::pair<PlayPart, PlayPart> PlayPart::halves(int i) const {
  std::pair<PlayPart, PlayPart> parts{*this, *this};
  parts.first.high[i] = parts.second.low[i] = 0.5 * (low[i] + high[i]);
  return parts;
}

}  // namespace freeplay
