#include "dynamics/assembly/closure.hpp"

#include <fmt/format.h>

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
  /// JᵀJ + μ D and −Jᵀr, where D is the diagonal of the squared lengths of the coordinates.
  void normal_equations(const std::vector<double>& q, double damping, Eigen::SparseMatrix<double>& A,
                        Eigen::VectorXd& b) {
    std::vector<Eigen::Triplet<double>> entries;
    const int rows = system_.rows() + system_.contacts();
    Eigen::VectorXd r = Eigen::VectorXd::Zero(rows);
    visit(q, [&](int row, double residual, double weight, auto&& each) {
      r[row] = weight * residual;
      each([&](int column, double value) {
        if (held_.empty() || !held_[static_cast<std::size_t>(column)])
          entries.emplace_back(row, column, weight * value);
      });
    });
    Eigen::SparseMatrix<double> J(rows, system_.n());
    J.setFromTriplets(entries.begin(), entries.end());
    A = J.transpose() * J;
    for (int c = 0; c < system_.n(); ++c)
      A.coeffRef(c, c) += damping * (system_.is_angle(c) ? length_ * length_ : 1);
    b = -(J.transpose() * r);
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
};

}  // namespace

void best_pose(const System& system, double length, bool hold_drives, std::vector<double>& q, double t,
               const std::vector<char>& held) {
  Residuals residuals(system, length, hold_drives, t, held);
  Eigen::SparseMatrix<double> A;
  Eigen::VectorXd b;
  std::vector<double> trial(q.size());
  double cost = residuals.cost(q), damping = 1e-3;
  for (int i = 0; i < 200 && cost > 0 && damping < 1e12; ++i) {
    residuals.normal_equations(q, damping, A, b);
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(A);
    if (factors.info() != Eigen::Success) {
      damping *= 10;
      continue;
    }
    const Eigen::VectorXd step = factors.solve(b);
    for (std::size_t c = 0; c < q.size(); ++c) trial[c] = q[c] + step[static_cast<Eigen::Index>(c)];
    const double less = residuals.cost(trial);
    if (!(less < cost)) {
      damping *= 10;
      continue;
    }
    const bool done = cost - less < 1e-14 * cost;
    q = trial;
    cost = less;
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
