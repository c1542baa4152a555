#include "analysis/play/play_extremes.hpp"

#include "analysis/play/play_bound.hpp"

namespace freeplay {
namespace {

/// Sets the value, gradient and bound of x.
void set_bound(PlayOutput& h, PlayExtreme& x) {
  h.evaluate(x.u, x.q);
  x.value = h.value, x.a = h.a;
  x.bound = x.value + excess(h, x);
}

}  // namespace

const PlayRegion& PlayExtremes::enclose(const Eigen::VectorXd& q, double t) {
  return region_ = enclosed_poses(mechanism_, q, t);
}

double PlayExtremes::ideal(int k, Eigen::VectorXd& a) {
  PlayOutput h(mechanism_, region_, k, 1);
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
  PlayOutput h(mechanism_, region_, k, sign);
  PlayExtreme x;
  x.u = start.size() == mechanism_.size() ? start : Eigen::VectorXd::Zero(mechanism_.size());
  x.q = region_.q + region_.slope * x.u;
  ascend(h, x);
  set_bound(h, x);
  // What the bound confirms needs no further search.
  constexpr double confirmed = 1e-10;
  if (x.settled && x.bound - x.value <= confirmed * x.a.lpNorm<1>()) return x;
  search_from_starts(h, x);
  set_bound(h, x);
  return x;
}

}  // namespace freeplay
