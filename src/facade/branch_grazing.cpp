#include "facade/branch_grazing.hpp"

#include <algorithm>

#include "facade/branch_events.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

/// Distances of the runs beside a motion, in units of σ and of the range.
constexpr double displaced[] = {1e-5, 1e-4};
/// Approach speeds of the first motion with an impact, over the greatest speed.
constexpr double first_speeds[] = {2e-2, 5e-2, 1e-1};
/// A contact is just touched if its approach speed is below this share of the greatest speed.
constexpr double grazing_speed = 0.05;

/// The onset of `longer` without which both lists are equal.
std::optional<std::size_t> added(const std::vector<int>& shorter, const std::vector<int>& longer) {
  if (longer.size() != shorter.size() + 1) return {};
  const auto [a, b] = std::ranges::mismatch(shorter, longer);
  const auto at = b - longer.begin();
  return std::equal(a, shorter.end(), b + 1) ? std::optional(static_cast<std::size_t>(at)) : std::nullopt;
}

std::optional<NewContact> new_contact_of(const BranchMotion& m, const EndState& end) {
  std::vector<int> sequence;
  for (const auto& onset : end.onsets) sequence.push_back(onset.contact);
  const auto at = added(m.sequence(), sequence);
  if (!at) return {};
  return NewContact{*at, sequence[*at], -end.onsets[*at].rate};
}

}  // namespace

std::optional<NewContact> new_contact_ahead(const BranchSolver& solver, const BranchMotion& m,
                                            double distance) {
  const auto f = m.model->map.size();
  for (const double factor : {1.0, 4.0, 16.0, 64.0, 256.0, 4096.0}) {
    const auto end =
        solver.beside(m, factor * distance * m.tangent.head(f), factor * distance * m.tangent_key());
    if (!end) continue;
    if (const auto grazed = new_contact_of(m, *end);
        grazed && grazed->speed < grazing_speed * greatest_speed(m))
      return grazed;
  }
  return {};
}

std::optional<BranchMotion> first_with_impact(const BranchSolver& solver, const BranchMotion& m,
                                              const NewContact& grazed, std::string& reason) {
  const auto& map = m.model->map;
  const auto f = map.size();
  const double range = solver.setup().range(), scale = solver.scale();
  VectorXd kappa = VectorXd::Zero(f + 1), c = VectorXd::Zero(f);
  double fastest = 0;  // of the impacts in these runs; the slowest ones know c best
  for (Eigen::Index k = 0; k <= f; ++k)
    for (const double sign : {1.0, -1.0})
      for (const double size : displaced) {
        if (kappa[k] != 0) break;
        VectorXd u = VectorXd::Zero(f);
        double xi = 0;
        (k < f ? u[k] : xi) = sign * size;
        const auto end = solver.beside(m, u, xi);
        const auto found = end ? new_contact_of(m, *end) : std::nullopt;
        if (!found || found->contact != grazed.contact) continue;
        kappa[k] = found->speed * found->speed / (sign * size);
        if (fastest > 0 && found->speed > fastest) continue;
        fastest = found->speed;
        auto list = list_of({end->state, end->contacts});
        const auto from = list_of({m.point.end.state, m.point.end.contacts});
        for (std::size_t i = 0; i < list.size(); ++i) list[i] -= from[i];
        const VectorXd smooth = m.point.map * u + m.point.by_key * (xi * range / scale);
        c = (map.local(list) / scale - smooth) / found->speed;
      }
  if (fastest == 0) {
    reason = "no motion beside it touches the contact";
    return {};
  }
  MatrixXd A(f + 1, f + 1);
  A.topLeftCorner(f, f) = MatrixXd::Identity(f, f) - m.point.map;
  A.topRightCorner(f, 1) = -m.point.by_key * (range / scale);
  A.bottomRows(1) = kappa.transpose();
  VectorXd rest(f + 1);
  rest << c, 0;
  const VectorXd slope = MinimumNorm(A).solve(rest);
  for (const double share : first_speeds) {
    const double distance = share * greatest_speed(m) * slope.norm();
    BranchMotion base = m;
    base.tangent = VectorXd::Zero(m.tangent.size());
    base.tangent.head(f) = slope.head(f) / slope.norm();
    base.tangent[m.tangent.size() - 1] = slope[f] / slope.norm();
    auto motion = solver.along(base, distance, reason);
    if (motion && added(m.sequence(), motion->sequence())) return motion;
    if (motion) reason = "Newton's method finds motions without the impact only";
  }
  return {};
}

}  // namespace freeplay
