#include "dynamics/assembly/closure.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "dynamics/system.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

/// Weight of a drive's residual relative to a joint's.
constexpr double held = 1e4;

/// Residuals, as lengths, and their derivatives at one q.
class Residuals {
 public:
  Residuals(const System& system, double length, bool hold_drives, double t, const std::vector<char>& fixed)
      : system_(system),
        length_(length),
        t_(t),
        held_(fixed),
        drive_(hold_drives ? held : 0),
        e_(system.make_evaluation()),
        rest_(system.n(), 0.0) {}

  double cost(const std::vector<double>& q) {
    double sum = 0;
    visit(q, [&](int, double r, double weight, auto&&) { sum += weight * weight * r * r; });
    return sum / 2;
  }
  /// Computes Jᵀr and JᵀJ at q.
  void linearise(const std::vector<double>& q) {
    const int n = system_.n();
    const bool dense = n <= most_dense;
    gradient_.setZero(n);
    if (dense) normal_.setZero(n, n);
    std::vector<Eigen::Triplet<double>> entries;
    visit(q, [&](int row, double residual, double weight, auto&& each) {
      row_.clear();
      each([&](int column, double value) {
        if (!held_.empty() && held_[static_cast<std::size_t>(column)]) return;
        row_.emplace_back(column, weight * value);
        gradient_[column] += weight * value * weight * residual;
      });
      for (const auto& [c, x] : row_) {
        if (!dense) entries.emplace_back(row, c, x);
        for (const auto& [d, y] : row_)
          if (dense) normal_(c, d) += x * y;
      }
    });
    if (dense) return;
    Eigen::SparseMatrix<double> J(system_.rows() + system_.contacts(), n);
    J.setFromTriplets(entries.begin(), entries.end());
    sparse_normal_ = J.transpose() * J;
  }
  /// Solves (JᵀJ + μ D) step = −Jᵀr, where D is the diagonal of the squared lengths of the coordinates.
  bool solve(double damping, Eigen::VectorXd& step) {
    const int n = system_.n();
    const auto damp = [&](auto& A) -> auto& {
      for (int c = 0; c < n; ++c) A.coeffRef(c, c) += damping * (system_.is_angle(c) ? length_ * length_ : 1);
      return A;
    };
    if (n <= most_dense) {
      dense_ = normal_;
      dense_factors_.compute(damp(dense_));
      step = -dense_factors_.solve(gradient_);
      return dense_factors_.info() == Eigen::Success;
    }
    auto A = sparse_normal_;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(damp(A));
    if (factors.info() != Eigen::Success) return false;
    step = -factors.solve(gradient_);
    return true;
  }
  /// Greatest change of a coordinate, as a length, over the mechanism's length.
  double size_of(const Eigen::VectorXd& step) const {
    double most = 0;
    for (int c = 0; c < system_.n(); ++c)
      most = std::max(most, std::abs(step[c]) * (system_.is_angle(c) ? 1 : 1 / length_));
    return most;
  }

 private:
  /// Calls see(row, residual, weight, function over the entries of its derivative).
  template <class See>
  void visit(const std::vector<double>& q, See see) {
    system_.place(t_, q.data(), e_);
    const auto& p = system_.pattern();
    for (int k = 0; k < system_.rows(); ++k) {
      const bool drives = k >= system_.rows() - system_.drive_rows();
      see(k, e_.phi[k], (system_.is_angle_row(k) ? length_ : 1) * (drives ? drive_ : 1), [&](auto&& put) {
        for (int i = p.begin[k]; i < p.begin[k + 1]; ++i) put(p.column[i], e_.G[i]);
      });
    }
    for (int k = 0; k < system_.contacts(); ++k) {
      system_.contact(k, q.data(), rest_.data(), e_, contact_);
      if (!(contact_.gap < 0)) continue;
      see(system_.rows() + k, contact_.gap, 1.0, [&](auto&& put) {
        for (int i = 0; i < contact_.normal.size; ++i)
          put(contact_.normal.column[i], contact_.normal.value[i]);
      });
    }
  }

  const System& system_;
  double length_, t_;
  const std::vector<char>& held_;
  double drive_;
  Evaluation e_;
  std::vector<double> rest_;
  ContactRow contact_;
  static constexpr int most_dense = 30;  // unknowns; more are factorised as a sparse matrix
  std::vector<std::pair<int, double>> row_;
  Eigen::VectorXd gradient_;
  Eigen::MatrixXd normal_;  // JᵀJ
  Eigen::SparseMatrix<double> sparse_normal_;
  Eigen::MatrixXd dense_;
  Eigen::LDLT<Eigen::MatrixXd> dense_factors_;
};

}  // namespace

void best_pose(const System& system, double length, bool hold_drives, std::vector<double>& q, double t,
               const std::vector<char>& held) {
  Residuals residuals(system, length, hold_drives, t, held);
  constexpr double rounding = 1e-14;  // of a step, relative; the next one would be its square
  Eigen::VectorXd step;
  std::vector<double> trial(q.size());
  double cost = residuals.cost(q);
  bool moved = true;
  double damping = 1e-3;  // Levenberg-Marquardt, relative to the squared lengths of the coordinates
  for (int i = 0; i < 200 && cost > 0 && damping < 1e12; ++i) {
    if (moved) residuals.linearise(q);
    moved = false;
    if (!residuals.solve(damping, step)) {
      damping *= 10;
      continue;
    }
    for (std::size_t c = 0; c < q.size(); ++c) trial[c] = q[c] + step[static_cast<Eigen::Index>(c)];
    const double less = residuals.cost(trial);
    const bool small = residuals.size_of(step) < rounding;
    if (!(less < cost)) {
      if (small) break;
      damping *= 10;
      continue;
    }
    const bool done = small || cost - less < 1e-14 * cost;
    std::swap(q, trial);
    cost = less;
    moved = true;
    damping = std::max(damping / 5, 1e-12);
    if (done) break;
  }
}

std::vector<OpenJoint> open_joints(const System& system, const std::vector<double>& q, double length,
                                   double t) {
  auto e = system.make_evaluation();
  system.place(t, q.data(), e);
  std::vector<OpenJoint> list;
  for (int k = 0; k < system.rows(); ++k) {
    const OpenJoint own{system.row_name(k), std::abs(e.phi[k]), system.is_angle_row(k), false,
                        k >= system.rows() - system.drive_rows()};
    const auto same = std::ranges::find_if(list, [&](const OpenJoint& o) {
      return o.name == own.name && o.angular == own.angular && o.drive == own.drive;
    });
    if (same == list.end())
      list.push_back(own);
    else
      same->amount = std::hypot(same->amount, own.amount);
  }
  for (int k = 0; k < system.contacts(); ++k)
    if (const double inside = -system.gap(k, q.data(), e); inside > 0)
      list.push_back({system.contact_facts(k).name, inside, false, true, false});
  const auto size = [&](const OpenJoint& o) { return o.angular ? length * o.amount : o.amount; };
  double worst = 0;
  for (const auto& o : list) worst = std::max(worst, size(o));
  if (!(worst > 0) || !std::isfinite(worst)) return list;
  std::erase_if(list, [&](const OpenJoint& o) { return size(o) < worst / 100; });
  // Gaps that are equal up to rounding are sorted in the mechanism's order.
  std::ranges::stable_sort(list, std::ranges::greater{},
                           [&](const OpenJoint& o) { return std::round(1e4 * size(o) / worst); });
  return list;
}

std::string describe(const OpenJoint& open) {
  return fmt::format("{} by {:.4g} {}", open.overlap ? "overlaps" : "stays open", open.amount,
                     open.angular ? "rad" : "m");
}

std::string key_of(const Mechanism& mechanism, const OpenJoint& open) {
  if (open.drive) return "drives." + open.name;
  const bool joint =
      std::ranges::any_of(mechanism.joints, [&](const Joint& j) { return name_of(j) == open.name; });
  return (joint ? "joints." : "contacts.") + open.name;
}

}  // namespace freeplay
