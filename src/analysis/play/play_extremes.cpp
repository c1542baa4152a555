#include "analysis/play/play_extremes.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "analysis/play/play_bound.hpp"

namespace freeplay {
namespace {

/// A part whose bound exceeds the best value found.
struct OpenPart {
  PlayPart part;
  double bound;
  int worst;  ///< entry along which it is halved
  bool operator<(const OpenPart& other) const { return bound < other.bound; }
};

/// Improves `best` and its bound by dividing the positions, of which `open` is the first part.
void branch(OutputFunction& h, OpenPart open, double accepted, PlayExtreme& best) {
  constexpr int most = 64;  // parts
  const auto& components = h.mechanism.components();
  std::priority_queue<OpenPart> parts;
  double closed = -INFINITY;  // greatest bound of the closed parts
  parts.push(std::move(open));
  for (int count = 0; count < most && !parts.empty() && parts.top().bound > best.value + accepted;
       count += 2) {
    const OpenPart top = parts.top();
    parts.pop();
    const auto halves = top.part.halves(top.worst);
    for (const auto& part : {halves.first, halves.second}) {
      if (!part.has_positions(components)) continue;
      PlayExtreme x;
      x.u = best.u;
      for (const auto& c : components)
        x.u.segment(c.first, c.size()) = part.nearest(c, best.u.segment(c.first, c.size()));
      x.q = h.region.q + h.region.slope * x.u;
      climb(h, part, x);
      if (!h.evaluate(x.u, x.q)) {
        closed = std::max(closed, top.bound);
        continue;
      }
      if (x.value > best.value + (x.settled ? 0 : accepted)) best = x;
      const auto bound = bound_on_part(h, x, part, best.value + accepted - x.value, false);
      const double limit = std::min(top.bound, x.value + bound.excess);
      if (limit > best.value + accepted)
        parts.push({bound.reach, limit, bound.worst});
      else
        closed = std::max(closed, limit);
    }
  }
  best.bound = std::max({best.value, closed, parts.empty() ? -INFINITY : parts.top().bound});
}

}  // namespace

const PlayRegion& PlayExtremes::enclose(const Eigen::VectorXd& q, double t) {
  return region_ = enclosed_poses(mechanism_, q, t);
}

double PlayExtremes::ideal(int k, Eigen::VectorXd& a) {
  OutputFunction h(mechanism_, region_, k, 1);
  if (h.evaluate(Eigen::VectorXd::Zero(mechanism_.size())))
    a = h.a;
  else
    a.setZero(mechanism_.size());
  return h.value;
}

std::optional<double> PlayExtremes::value(int k, const Eigen::VectorXd& u) {
  Eigen::VectorXd q = region_.q + region_.slope * u, gradient;
  LooseMechanism::Equations f;
  DenseLu factors;
  if (!mechanism_.close(u, region_.t, q, f, factors)) return {};
  return mechanism_.output(k, gradient);
}

PlayExtreme PlayExtremes::greatest(int k, double sign, const Eigen::VectorXd& start) {
  constexpr double confirmed = 1e-10;  // excess, as a share of the linear range
  OutputFunction h(mechanism_, region_, k, sign);
  const auto whole = PlayPart::whole(mechanism_.size());
  PlayExtreme x;
  x.u = start.size() == mechanism_.size() ? start : Eigen::VectorXd::Zero(mechanism_.size());
  x.q = region_.q + region_.slope * x.u;
  ascend(h, whole, x);
  if (!x.settled) climb(h, whole, x);
  if (!h.evaluate(x.u, x.q)) {
    // Near a dead centre rounding may keep Newton's method from converging.
    x.value = NAN, x.bound = INFINITY;
    x.a.setZero(mechanism_.size());
    x.settled = false;
    return x;
  }
  x.value = h.value, x.a = h.a;
  const double accepted = confirmed * x.a.lpNorm<1>() + 2 * h.rounding;
  LooseMechanism::Enclosures box;
  mechanism_.enclose(region_, region_.t, box);
  const auto bound = bound_on_part(h, x, whole, accepted, true);
  x.bound = x.value + bound.excess;
  if (bound.excess > accepted && std::isfinite(bound.excess))
    branch(h, {bound.reach, x.bound, bound.worst}, accepted, x);
  return x;
}

}  // namespace freeplay
