// Lemke's method (numerics/lcp.hpp) on contact problems. The standard form as a linear
// complementarity problem (Glocker, Set-Valued Force Laws, 2001): with P_T = P_R − μP_N and
// u_T = u_R − u_L, the unknowns are z = (P_N, P_R, u_L) and w = (u_N⁺ + e u_N⁻, u_R, P_L = 2μP_N −
// P_R).
#include <algorithm>
#include <cmath>

#include "formulations/contact/solvers.hpp"

namespace freeplay {
namespace {

struct Size {
  int normals, tangents, unknowns;
  double scale;  // unit of impulses per rate: one over the greatest diagonal entry of D
};

/// Makes room for one unknown of each normal row and `per_tangent` of each tangential row, with a
/// zero matrix.
Size begin(const ContactEquations& p, int per_tangent, SolverRoom& room) {
  Size size{0, 0, 0, 1 / p.D.diagonal().head(p.rows).maxCoeff()};
  for (const auto& c : p.unknowns) {
    size.normals += c.normal >= 0;
    size.tangents += c.tangent >= 0;
  }
  size.unknowns = size.normals + per_tangent * size.tangents;
  room.reserve_lemke(size.unknowns);
  room.A.topLeftCorner(size.unknowns, size.unknowns).setZero();
  return size;
}

}  // namespace

void SolverRoom::reserve_lemke(int n) {
  if (n <= lemke_size) return;
  lemke_size = std::max(n, 2 * lemke_size);
  lemke = Lemke(lemke_size);
  A.setZero(lemke_size, lemke_size);
  q.setZero(std::max<Eigen::Index>(lemke_size, q.size()));
  z.setZero(lemke_size);
}

SolverSummary lemke(ContactEquations& p, double, SolverRoom& room) {
  auto& unknowns = p.unknowns;
  const auto& D = p.D;
  const auto& b = p.b;
  const auto [normals, tangents, n, scale] = begin(p, 2, room);
  auto &q = room.q, &z = room.z;
  auto& A = room.A;
  // Order of the unknowns: (P_N ..., P_R ..., u_L ...), each in the order of `unknowns`.
  const auto fill_row = [&](int place, int row, double base) {
    q[place] = base;
    int i = 0, j = 0;
    for (const auto& c : unknowns) {
      const double Dt = c.tangent >= 0 ? D(row, c.tangent) * scale : 0;
      if (c.normal >= 0) A(place, i++) += D(row, c.normal) * scale - c.friction * Dt;
      if (c.tangent < 0) continue;
      q[place] -= D(row, c.tangent) * c.bound;
      A(place, normals + j++) += Dt;
    }
  };
  int i = 0, j = 0;
  for (const auto& c : unknowns) {
    if (c.normal >= 0) fill_row(i, c.normal, b[c.normal] - c.target_n);
    if (c.tangent >= 0) {
      const int R = normals + j, L = normals + tangents + j;
      fill_row(R, c.tangent, b[c.tangent] - c.target_t);
      A(R, L) = 1;
      A(L, R) = -1;
      q[L] = 2 * c.bound / scale;
      if (c.normal >= 0) A(L, i) = 2 * c.friction;
      ++j;
    }
    i += c.normal >= 0;
  }
  const auto result = room.lemke.solve(n, A.data(), static_cast<int>(A.rows()), q.data(), z.data());
  i = j = 0;
  for (auto& c : unknowns) {
    c.impulse_n = c.normal >= 0 ? z[i] * scale : 0;
    if (c.tangent >= 0)
      c.impulse_t = z[normals + j++] * scale - c.friction * c.impulse_n - c.bound;
    else
      c.impulse_t = 0;
    i += c.normal >= 0;
  }
  return {result.status == LcpResult::Status::solved, result.pivots};
}

/// The contact problem in the form of Anitescu and Potra (Nonlinear Dynamics 14 (1997) 231):
/// z = (P_N, P_+, P_−, λ), with P_T = P_+ − P_− and w = (u_N − target, u_T + λ, −u_T + λ, bound +
/// μP_N − P_+ − P_−). Its matrix is copositive if D has no negative eigenvalue. Lemke's method then
/// ends in a solution if no P ≥ 0 with WP = 0 gains from the targets; for inelastic problems it
/// always ends in a solution. Newton steps then remove the rounding error.
SolverSummary copositive_lemke(ContactEquations& p, double accepted, SolverRoom& room) {
  auto& unknowns = p.unknowns;
  const auto& D = p.D;
  const auto& b = p.b;
  const auto [normals, tangents, n, scale] = begin(p, 3, room);
  auto &q = room.q, &z = room.z;
  auto& A = room.A;
  const auto fill_row = [&](int place, int row, double sign) {
    int i = 0, j = normals;
    for (const auto& c : unknowns) {
      if (c.normal >= 0) A(place, i++) = sign * D(row, c.normal) * scale;
      if (c.tangent < 0) continue;
      A(place, j) = sign * D(row, c.tangent) * scale;
      A(place, tangents + j) = -A(place, j);
      ++j;
    }
  };
  int i = 0, j = normals;
  for (const auto& c : unknowns) {
    if (c.normal >= 0) {
      fill_row(i, c.normal, 1);
      q[i] = b[c.normal] - c.target_n;
    }
    if (c.tangent >= 0) {
      const int right = j, left = j + tangents, lambda = left + tangents;
      fill_row(right, c.tangent, 1);
      fill_row(left, c.tangent, -1);
      q[right] = b[c.tangent] - c.target_t;
      q[left] = -q[right];
      q[lambda] = c.bound / scale;
      A(right, lambda) = A(left, lambda) = 1;
      A(lambda, right) = A(lambda, left) = -1;
      if (c.normal >= 0) A(lambda, i) = c.friction;
      ++j;
    }
    i += c.normal >= 0;
  }
  const auto result = room.lemke.solve(n, A.data(), static_cast<int>(A.rows()), q.data(), z.data());
  i = 0;
  j = normals;
  for (auto& c : unknowns) {
    c.impulse_n = c.normal >= 0 ? z[i++] * scale : 0;
    c.impulse_t = c.tangent >= 0 ? (z[j] - z[j + tangents]) * scale : 0;
    j += c.tangent >= 0;
  }
  if (result.status == LcpResult::Status::ray) return {false, result.pivots};
  const auto found = unknowns;
  const double left = p.residual();
  if (left <= std::max(accepted, p.attainable())) return {true, result.pivots};
  const auto refined = newton_from(From::given, p, accepted);
  if (!refined.solved && !(p.residual() < left)) unknowns = found;
  return {refined.solved, result.pivots + refined.iterations};
}

}  // namespace freeplay
