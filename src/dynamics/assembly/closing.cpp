#include "dynamics/assembly/closing.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/assembly_ipopt.hpp"
#include "dynamics/assembly/other_starts.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"

namespace freeplay {

double length_scale(const System& system) {
  double scale = system.longest_arm();
  for (int k = 0; k < system.contacts(); ++k)
    scale = std::max(scale, system.contact_facts(k).ring ? system.contact_facts(k).radius_bearing : 0);
  return scale > 0 ? scale : 1;
}

Closing::Closing(const Mechanism& mechanism, const System& system, const StopToken& stop, Metric metric)
    : mechanism_(mechanism),
      system_(system),
      stop_(stop),
      metric_(std::move(metric)),
      length_(length_scale(system)),
      accepted_(1e-9 * length_) {}

double Closing::open(const std::vector<double>& q) const { return worst_open_joint(system_, q).amount; }

double Closing::worst(const std::vector<double>& q) const {
  const auto list = open_joints(system_, q, length_);
  return list.empty() ? 0 : (list.front().angular ? length_ : 1) * list.front().amount;
}

std::vector<int> Closing::left_out(const std::vector<double>& q) const {
  if (metric_.held.empty()) return redundant_rows(system_, q);
  auto e = system_.make_evaluation();
  system_.place(0, q.data(), e);
  MovableRows rows(system_, metric_);
  rows.choose(e.G);
  return rows.left_out();
}

void Closing::close_exactly(std::vector<double>& q) const {
  auto e = system_.make_evaluation();
  MovableRows rows(system_, metric_, metric_.held.empty() && !redundant_rows(system_, q).empty());
  std::vector<double> dq(q.size()), r(e.phi.size());
  for (int i = 0; i < 5; ++i) {
    system_.place(0, q.data(), e);
    if (i == 0) rows.choose(e.G);
    if (!rows.factor(e.G)) return;
    std::ranges::transform(e.phi, r.begin(), std::negate{});
    rows.solve(nullptr, r, dq);
    for (std::size_t c = 0; c < q.size(); ++c) q[c] += dq[c];
  }
}

/// Newton's method for the pose nearest to `rough`: dq = W⁻¹(−Gᵀλ) + (rough − q) onto Φ + G dq = 0.
/// Its limit has W(q − rough) + Gᵀλ = 0 and Φ = 0. The neglected term, the curvature of Φ times λ,
/// is small near closure. Each step must be at most half the previous one, and the first shorter
/// than a tenth of the length and of a radian (with held coordinates: of a radian). Otherwise it
/// stops and leaves q unchanged, because farther away another branch may be nearer. Returns true
/// with a pose that is closed to `accepted`.
bool Closing::approach(const std::vector<double>& rough, std::vector<double>& q) const {
  constexpr int most = 30;
  auto e = system_.make_evaluation();
  MovableRows rows(system_, metric_);
  const auto& weight = metric_.weight;
  const bool holds = !metric_.held.empty();
  const auto n = q.size();
  std::vector<double> pose = q, dq(n), r(e.phi.size()), f(n);
  double last = INFINITY;
  for (int i = 0; i < most; ++i) {
    system_.place(0, pose.data(), e);
    if (i == 0) rows.choose(e.G);
    if (!rows.factor(e.G) || rows.singular()) return false;
    std::ranges::transform(e.phi, r.begin(), std::negate{});
    for (std::size_t c = 0; c < n; ++c) f[c] = weight[c] * (rough[c] - pose[c]);
    rows.solve(f.data(), r, dq);
    double moved = 0, size = 0;
    for (std::size_t c = 0; c < n; ++c) {
      pose[c] += dq[c];
      const bool turns = static_cast<int>(c) % planar::coordinates == 2;
      if (i == 0 && !(std::abs(dq[c]) < (turns ? 0.1 : holds ? INFINITY : 0.1 * length_))) return false;
      moved += weight[c] * dq[c] * dq[c];
      size += weight[c] * pose[c] * pose[c];
    }
    if (!(moved < 0.25 * last)) {
      // Converged to rounding, or not converging.
      if (!(last <= 1e-28 * size)) return false;
      break;
    }
    last = moved;
    if (moved == 0) break;
  }
  if (!(open(pose) <= accepted_)) return false;
  q = pose;
  return true;
}

bool Closing::close(std::vector<double>& q, std::vector<double>& best) const {
  if (open(q) <= 1e-14 * length_) return true;
  const auto rough = q;
  if (move(rough, q)) return true;
  // Start from the better of two best poses: near the rough positions and near the last iterate.
  // If it is closed, try once more.
  best = rough;
  best_pose(system_, length_, true, best, 0, metric_.held);
  best_pose(system_, length_, true, q, 0, metric_.held);
  if (worst(q) <= worst(best)) best = q;
  q = best;
  return worst(best) < 1e-6 * length_ && move(rough, q);
}

bool Closing::close_from(std::vector<double>& q) const {
  best_pose(system_, length_, true, q, 0, metric_.held);
  if (!(worst(q) < 1e-6 * length_)) return false;
  const auto start = q;
  return open(q) <= 1e-14 * length_ || move(start, q);
}

void Closing::unwind_to(const std::vector<double>& given, std::vector<double>& q) const {
  const auto before = q;
  unwind(mechanism_, given, q);
  if (q != before) close_exactly(q);
}

/// Rows that are dependent at the rough positions may be independent at the assembled ones: they
/// are selected again once.
bool Closing::move(const std::vector<double>& rough, std::vector<double>& q) const {
  if (approach(rough, q)) return true;
  for (int attempt = 0; attempt < 2 && !(open(q) <= accepted_); ++attempt) {
    least_movement(system_, rough, left_out(q), metric_, q, stop_);
    // An interior-point method keeps a distance from inactive contacts, and light bodies have
    // little weight in its tolerance.
    if (approach(rough, q)) return true;
    if (open(q) < 1e-3 * length_) close_exactly(q);
  }
  return open(q) <= accepted_;
}

}  // namespace freeplay
