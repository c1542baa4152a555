#include "formulations/nonsmooth/impact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace freeplay {

/// Along P_N the rates are piecewise linear,
///
///     du_N/dP = D_NN + c D_NT,   du_T/dP = D_NT + c D_TT,
///     c = −μ sgn u_T while slipping,   c = −D_NT/D_TT while sticking,
///
/// and sticking needs |c| ≤ μ; else slip starts anew the way D_NT drives.
void routh_impact(double Dnn, double Dnt, double Dtt, double u_n, double u_t, double mu, double e, double& P,
                  double& T) {
  P = T = 0;
  if (!(u_n < 0)) return;
  double work = 0, wanted = INFINITY;  // of the normal impulse; `wanted` once compression is over
  const double stick = Dtt > 0 ? -Dnt / Dtt : 0;
  for (int phase = 0; phase < 12; ++phase) {
    double c = 0;
    if (Dtt > 0) {
      if (u_t != 0)
        c = u_t > 0 ? -mu : mu;
      else
        c = std::abs(stick) <= mu ? stick : std::copysign(mu, stick);
    }
    const double rise_n = Dnn + c * Dnt, rise_t = Dtt > 0 ? Dnt + c * Dtt : 0;
    const bool compressing = std::isinf(wanted);
    // Length of this piece in P: until slip stops, compression ends, or the work of expansion is done.
    double length = INFINITY;
    bool slip_stops = false;
    if (u_t != 0 && u_t * rise_t < 0) {
      length = -u_t / rise_t;
      slip_stops = true;
    }
    if (compressing) {
      if (rise_n > 0 && -u_n / rise_n <= length) {
        length = -u_n / rise_n;
        slip_stops = false;
      }
    } else {
      // u_N x + ½ rise x² = what is left.
      const double left = wanted - work, root = u_n * u_n + 2 * rise_n * left;
      const double x = 2 * left / (u_n + std::sqrt(std::max(0.0, root)));
      if (root >= 0 && x <= length) {
        length = x;
        slip_stops = false;
      }
    }
    if (!std::isfinite(length)) return;
    work += u_n * length + 0.5 * rise_n * length * length;
    P += length;
    T += c * length;
    u_n += rise_n * length;
    u_t = slip_stops || (u_t == 0 && std::abs(stick) <= mu) ? 0 : u_t + rise_t * length;
    if (slip_stops) continue;
    if (!compressing) return;
    u_n = 0;
    if (e == 0) return;
    wanted = work - e * e * work;  // work is negative: compression took it
  }
}

void ImpactProblem::prepare(const std::vector<ImpactContact>& contacts) {
  problem_.unknowns.clear();
  for (const auto& c : contacts) {
    ContactUnknown x;
    x.normal = c.normal;
    x.tangent = c.tangent;
    x.friction = c.friction;
    problem_.unknowns.push_back(x);
  }
}

bool ImpactProblem::newton(const Eigen::VectorXd& u, std::vector<ImpactContact>& contacts) {
  prepare(contacts);
  problem_.b.head(problem_.rows) = u.head(problem_.rows);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    auto& x = problem_.unknowns[i];
    const auto& c = contacts[i];
    if (u[c.normal] >= 0) continue;
    x.target_n = -c.restitution * u[c.normal];
    if (c.tangent >= 0) x.target_t = -c.tangential_restitution * u[c.tangent];
  }
  solution_ = problem_.solve();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    contacts[i].impulse_n = problem_.unknowns[i].impulse_n;
    contacts[i].impulse_t = problem_.unknowns[i].impulse_t;
  }
  return solution_.solved;
}

/// Compression, then expansion with the given ratios of impulses.
bool ImpactProblem::phases(const Eigen::VectorXd& u, std::vector<ImpactContact>& contacts,
                           const std::vector<double>& expansion) {
  const int m = problem_.rows;
  prepare(contacts);
  problem_.b.head(m) = u.head(m);
  solution_ = problem_.solve();
  if (!solution_.solved) return false;
  after_compression_ = u;
  for (const auto& x : problem_.unknowns) {
    after_compression_.head(m) += x.impulse_n * problem_.D.col(x.normal).head(m);
    if (x.tangent >= 0) after_compression_.head(m) += x.impulse_t * problem_.D.col(x.tangent).head(m);
  }
  compression_n_.clear();
  compression_t_.clear();
  for (const auto& x : problem_.unknowns) {
    compression_n_.push_back(x.impulse_n);
    compression_t_.push_back(x.impulse_t);
  }
  prepare(contacts);
  problem_.b.head(m) = after_compression_.head(m);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const double given = expansion[i] * compression_n_[i];
    problem_.b.head(m) += given * problem_.D.col(contacts[i].normal).head(m);
    problem_.unknowns[i].bound = contacts[i].friction * given;
  }
  solution_ = problem_.solve();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    contacts[i].impulse_n =
        compression_n_[i] + expansion[i] * compression_n_[i] + problem_.unknowns[i].impulse_n;
    contacts[i].impulse_t = compression_t_[i] + problem_.unknowns[i].impulse_t;
  }
  return solution_.solved;
}

/// Poisson's phases with the ratios of expansion iterated until each contact's works stand as −e² : 1, works
/// taken with the mean rates of a phase.
bool ImpactProblem::energetic(const Eigen::VectorXd& u, std::vector<ImpactContact>& contacts) {
  const int m = problem_.rows;
  if (contacts.size() == 1) {
    auto& c = contacts.front();
    const auto& D = problem_.D;
    const bool rough = c.tangent >= 0;
    solution_ = {};
    routh_impact(D(c.normal, c.normal), rough ? D(c.normal, c.tangent) : 0,
                 rough ? D(c.tangent, c.tangent) : 0, u[c.normal], rough ? u[c.tangent] : 0, c.friction,
                 c.restitution, c.impulse_n, c.impulse_t);
    return true;
  }
  std::vector<double> ratio;
  for (const auto& c : contacts) ratio.push_back(c.restitution);
  for (int i = 0; i < 200; ++i) {
    if (!phases(u, contacts, ratio)) return false;
    Eigen::VectorXd end = u;
    for (const auto& c : contacts) {
      end.head(m) += c.impulse_n * problem_.D.col(c.normal).head(m);
      if (c.tangent >= 0) end.head(m) += c.impulse_t * problem_.D.col(c.tangent).head(m);
    }
    double change = 0;
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      const int n = contacts[k].normal;
      const double compressed = 0.5 * compression_n_[k] * (u[n] + after_compression_[n]);
      if (!(compressed < 0) || contacts[k].restitution == 0) continue;
      const double mean = 0.5 * (after_compression_[n] + end[n]);
      if (!(mean > 0)) continue;
      const double next =
          contacts[k].restitution * contacts[k].restitution * -compressed / (mean * compression_n_[k]);
      change = std::max(change, std::abs(next - ratio[k]));
      ratio[k] = 0.5 * (ratio[k] + next);
    }
    if (change <= 1e-13) return true;
  }
  return false;
}

bool ImpactProblem::by_law(const Eigen::VectorXd& u, std::vector<ImpactContact>& contacts) {
  switch (law_) {
    case ImpactLaw::newton:
      return newton(u, contacts);
    case ImpactLaw::poisson: {
      std::vector<double> ratio;
      for (const auto& c : contacts) ratio.push_back(c.restitution);
      return phases(u, contacts, ratio);
    }
    case ImpactLaw::energetic:
      return energetic(u, contacts);
  }
  throw std::logic_error("no such impact law");
}

std::string ImpactProblem::solve(const Eigen::MatrixXd& D, const Eigen::VectorXd& u, int rows,
                                 std::vector<ImpactContact>& contacts) {
  problem_.reserve(rows);
  problem_.rows = rows;
  problem_.D.topLeftCorner(rows, rows) = D.topLeftCorner(rows, rows);
  inelastic_ = false;
  if (!by_law(u, contacts)) {
    if (solution_.solved) return "the works of simultaneous impacts do not converge to their ratios";
    // Without restitution there always is a solution (see by_copositive_lemke).
    auto soft = contacts;
    for (auto& c : soft) c.restitution = c.tangential_restitution = 0;
    inelastic_ = contacts.size() > 1 && newton(u, soft);
    if (!inelastic_)
      return fmt::format(
          "the impact of {} contacts was not solved by any solver, nor without restitution (residual {:.2g} of the "
          "greatest rate); whether it has a solution is not known",
          contacts.size(), solution_.residual);
    for (std::size_t i = 0; i < soft.size(); ++i) {
      contacts[i].impulse_n = soft[i].impulse_n;
      contacts[i].impulse_t = soft[i].impulse_t;
    }
  }
  normal_work_ = tangential_work_ = 0;
  for (const auto& c : contacts) {
    const auto mean = [&](int row) {
      double change = 0;
      for (const auto& o : contacts) {
        change += D(row, o.normal) * o.impulse_n;
        if (o.tangent >= 0) change += D(row, o.tangent) * o.impulse_t;
      }
      return u[row] + 0.5 * change;
    };
    normal_work_ += c.impulse_n * mean(c.normal);
    if (c.tangent >= 0) tangential_work_ += c.impulse_t * mean(c.tangent);
  }
  return "";
}

}  // namespace freeplay
