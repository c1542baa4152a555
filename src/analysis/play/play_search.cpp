#include "analysis/play/play_search.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {
namespace {

/// Influences below this share of the greatest do not count in a direction.
constexpr double no_influence = 1e-14;
/// Relative changes of an output that count as rounding.
constexpr double rounding = 1e-14;

/// Sets u to the position of the part at which a·u is greatest; components without influence keep theirs.
void go_farthest(const LooseMechanism& mechanism, const PlayPart& part, const Eigen::VectorXd& a,
                 Eigen::VectorXd& u) {
  const double least = no_influence * a.cwiseAbs().maxCoeff();
  for (const auto& c : mechanism.components())
    if (const auto direction = a.segment(c.first, c.size()); direction.norm() > least)
      u.segment(c.first, c.size()) = part.farthest(c, direction);
}

/// A local maximum in the part of the quadratic model of h about u.
Eigen::VectorXd greatest_of_model(const LooseMechanism& mechanism, const PlayPart& part,
                                  const Eigen::VectorXd& a, const Eigen::MatrixXd& H,
                                  const Eigen::VectorXd& u) {
  constexpr int most = 1000;
  constexpr double reached = 1e-15;
  const double least = no_influence * (a.lpNorm<Eigen::Infinity>() + H.lpNorm<Eigen::Infinity>());
  Eigen::VectorXd v = u;
  for (int i = 0; i < most; ++i) {
    double change = 0;
    for (const auto& c : mechanism.components()) {
      const int size = c.size();
      const Eigen::VectorXd g = a.segment(c.first, size) + H.middleRows(c.first, size) * (v - u);
      if (!(g.norm() > least)) continue;
      const double bend = std::max(H.block(c.first, c.first, size, size).norm(), 1e-9 * g.norm());
      const Eigen::VectorXd next = part.nearest(c, v.segment(c.first, size) + g / bend);
      change = std::max(change, (next - v.segment(c.first, size)).cwiseAbs().maxCoeff());
      v.segment(c.first, size) = next;
    }
    if (change <= reached) break;
  }
  return v;
}

}  // namespace

void ascend(OutputFunction& h, const PlayPart& part, PlayExtreme& x) {
  constexpr int most = 25;
  Eigen::VectorXd u = x.u, q = x.q;
  x.settled = false;
  x.value = -INFINITY;
  double last = INFINITY;
  for (int i = 0; i < most; ++i) {
    if (!h.evaluate(u, q)) return;
    // A later iterate counts as better within rounding: its direction is more accurate.
    if (!(h.value < x.value - rounding * std::abs(h.value))) x.value = h.value, x.u = u, x.q = q, x.a = h.a;
    Eigen::VectorXd next = u;
    go_farthest(h.mechanism, part, h.a, next);
    const double change = (next - u).cwiseAbs().maxCoeff();
    if (change < 1e-13 || (change < 1e-9 && change >= last)) {
      x.settled = true;
      return;
    }
    if (i > 6 && change > 0.5 * last) return;
    last = change;
    u = next;
  }
}

void climb(OutputFunction& h, const PlayPart& part, PlayExtreme& x) {
  constexpr int most = 30;
  constexpr double shortest = 1e-3;
  x.settled = false;
  if (!h.evaluate(x.u, x.q)) return;
  x.value = h.value, x.a = h.a;
  for (int i = 0; i < most; ++i) {
    const Eigen::VectorXd step = greatest_of_model(h.mechanism, part, x.a, h.second(x.u), x.u) - x.u;
    double length = 1;
    for (;; length /= 2) {
      Eigen::VectorXd u = x.u + length * step, q = x.q;
      if (h.evaluate(u, q) && !(h.value < x.value - rounding * std::abs(x.value))) {
        x.value = h.value, x.u = u, x.q = q, x.a = h.a;
        break;
      }
      if (length < shortest) return;
    }
    if (length == 1 && step.cwiseAbs().maxCoeff() < 1e-12) {
      x.settled = true;
      return;
    }
  }
}

}  // namespace freeplay
