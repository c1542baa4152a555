#include "formulations/nonsmooth/contact_problem.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {

void ContactProblem::reserve(int size) {
  if (size <= D.rows()) return;
  D.setZero(size, size);
  b.setZero(size);
  unknowns.reserve(size);
}

LcpResult ContactProblem::solve() {
  if (unknowns.empty()) return {};
  if (unknowns.size() == 1 && !lemke_always_) {
    auto& c = unknowns.front();
    LcpResult result;
    if (c.normal < 0) {
      one_preloaded(c);
      result.residual = residual(c);
      return result;
    }
    if (one_contact(c)) {
      result.residual = residual(c);
      return result;
    }
  }
  return by_lemke();
}

void ContactProblem::one_preloaded(ContactUnknown& c) const {
  c.impulse_t = std::clamp(-b[c.tangent] / D(c.tangent, c.tangent), -c.bound, c.bound);
}

/// Separation, stick, then slip either way. False where no case is consistent (Painlevé).
bool ContactProblem::one_contact(ContactUnknown& c) const {
  c.impulse_n = c.impulse_t = 0;
  const double bn = b[c.normal] - c.target_n, Dnn = D(c.normal, c.normal);
  if (bn >= 0) return true;
  if (c.tangent < 0) {
    c.impulse_n = -bn / Dnn;
    return true;
  }
  const double bt = b[c.tangent], Dnt = D(c.normal, c.tangent), Dtt = D(c.tangent, c.tangent);
  const double determinant = Dnn * Dtt - Dnt * Dnt;
  const double Pn = (-bn * Dtt + bt * Dnt) / determinant, Pt = (-bt * Dnn + bn * Dnt) / determinant;
  if (determinant > 0 && Pn >= 0 && std::abs(Pt) <= c.friction * Pn) {
    c.impulse_n = Pn;
    c.impulse_t = Pt;
    return true;
  }
  for (double s : {1.0, -1.0}) {
    const double slope = Dnn - s * c.friction * Dnt;
    if (!(slope > 0)) continue;
    const double P = -bn / slope;
    if (s * (bt + (Dnt - s * c.friction * Dtt) * P) < 0) continue;
    c.impulse_n = P;
    c.impulse_t = -s * c.friction * P;
    return true;
  }
  return false;
}

/// What a closed form leaves of the laws, as velocities relative to the greatest |b|: max(0, ·) of each
/// violation.
double ContactProblem::residual(const ContactUnknown& c) const {
  const auto rate = [&](int row) {
    double u = b[row];
    if (c.normal >= 0) u += D(row, c.normal) * c.impulse_n;
    if (c.tangent >= 0) u += D(row, c.tangent) * c.impulse_t;
    return u;
  };
  double worst = 0, scale = 0, bound = c.bound;
  if (c.normal >= 0) {
    worst = std::abs(std::min(D(c.normal, c.normal) * c.impulse_n, rate(c.normal) - c.target_n));
    scale = std::max(std::abs(b[c.normal]), std::abs(c.target_n));
    bound = c.friction * c.impulse_n;
  }
  if (c.tangent >= 0) {
    // −P_T ∈ bound·Sgn(u) is u = 0 or P_T at the bound against u: min over both of the distance to it.
    const double u = rate(c.tangent), Dtt = D(c.tangent, c.tangent);
    const double to_bound = Dtt * std::abs(c.impulse_t + std::copysign(bound, u));
    const double beyond = Dtt * std::max(0.0, std::abs(c.impulse_t) - bound);
    worst = std::max({worst, std::min(std::abs(u), to_bound), beyond});
    scale = std::max(scale, std::abs(b[c.tangent]));
  }
  return scale > 0 ? worst / scale : worst;
}

LcpResult ContactProblem::by_lemke() {
  int normals = 0, tangents = 0;
  for (const auto& c : unknowns) {
    normals += c.normal >= 0;
    tangents += c.tangent >= 0;
  }
  const int n = normals + 2 * tangents;
  if (n > lemke_size_) {
    lemke_size_ = std::max(n, 2 * lemke_size_);
    lemke_ = Lemke(lemke_size_);
    A_.setZero(lemke_size_, lemke_size_);
    q_.setZero(lemke_size_);
    z_.setZero(lemke_size_);
  }
  // Impulses are scaled by the greatest diagonal entry of D, so that every row and unknown is a velocity.
  const double scale = 1 / D.diagonal().head(rows).maxCoeff();
  A_.topLeftCorner(n, n).setZero();
  // Place of each unknown among (P_N ..., P_R ..., u_L ...), counted in the order of `unknowns`.
  const auto fill_row = [&](int place, int row, double base) {
    q_[place] = base;
    int i = 0, j = 0;
    for (const auto& c : unknowns) {
      const double Dt = c.tangent >= 0 ? D(row, c.tangent) * scale : 0;
      if (c.normal >= 0) A_(place, i++) += D(row, c.normal) * scale - c.friction * Dt;
      if (c.tangent < 0) continue;
      if (c.normal < 0) q_[place] -= D(row, c.tangent) * c.bound;
      A_(place, normals + j++) += Dt;
    }
  };
  int i = 0, j = 0;
  for (const auto& c : unknowns) {
    if (c.normal >= 0) fill_row(i, c.normal, b[c.normal] - c.target_n);
    if (c.tangent >= 0) {
      const int R = normals + j, L = normals + tangents + j;
      fill_row(R, c.tangent, b[c.tangent]);
      A_(R, L) = 1;
      A_(L, R) = -1;
      q_[L] = 2 * c.bound / scale;
      if (c.normal >= 0) A_(L, i) = 2 * c.friction;
      ++j;
    }
    i += c.normal >= 0;
  }
  const auto result = lemke_.solve(n, A_.data(), static_cast<int>(A_.rows()), q_.data(), z_.data());
  i = j = 0;
  for (auto& c : unknowns) {
    c.impulse_n = c.normal >= 0 ? z_[i] * scale : 0;
    if (c.tangent >= 0)
      c.impulse_t = z_[normals + j++] * scale - (c.normal >= 0 ? c.friction * c.impulse_n : c.bound);
    else
      c.impulse_t = 0;
    i += c.normal >= 0;
  }
  return result;
}

}  // namespace freeplay
