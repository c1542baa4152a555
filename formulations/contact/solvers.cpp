#include "formulations/contact/solvers.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/contact/single_contact.hpp"

namespace freeplay {

// A single contact or joint with friction, in closed form. The cases are separation, stick, then
// slip in either direction.

/// Returns false if no case is consistent (Painlevé).
bool solve_one(ContactUnknown& c, double bn, double bt, double Dnn, double Dnt, double Dtt) {
  const SingleContact<double> x{Dnn, Dnt, Dtt, bn, bt, c.target_n, c.target_t, c.friction, c.bound};
  bt -= c.target_t;
  c.impulse_n = c.impulse_t = 0;
  if (c.normal < 0) {
    c.impulse_t = friction_impulse(Dtt, bt, c.bound);
    return true;
  }
  bn -= c.target_n;
  if (c.tangent < 0) {
    c.impulse_n = std::max(0.0, -bn / Dnn);
    return true;
  }
  if (c.bound > 0) {  // friction without normal force, if the contact stays open
    c.impulse_t = friction_impulse(Dtt, bt, c.bound);
    if (bn + Dnt * c.impulse_t >= 0) return true;
  } else if (bn >= 0) {
    return true;
  }
  const double determinant = x.determinant();
  if (determinant > same_freedom * Dnn * Dtt) {
    const auto found = pressed(x, determinant);
    if (!found.holds) return false;
    c.impulse_n = found.P.normal;
    c.impulse_t = found.P.tangent;
    return true;
  }
  // If both rows depend on one freedom, sticking is a limit of sliding: take the end with the
  // smaller impulse.
  bool found = false;
  for (double s : {1.0, -1.0}) {
    const auto [P, slope, rate] = sliding(x, s);
    const double none = same_freedom * (std::abs(bt) + std::abs(Dnt * P.normal) + std::abs(Dtt * P.tangent));
    if (!(slope > same_freedom * Dnn) || P.normal < 0 || rate < -none) continue;
    if (found && P.normal > c.impulse_n * (1 - same_freedom)) {
      // friction has no effect on the motion
      if (P.normal < c.impulse_n * (1 + same_freedom)) c.impulse_t = 0;
      continue;
    }
    c.impulse_n = P.normal;
    c.impulse_t = P.tangent;
    found = true;
  }
  return found;
}

bool singular_pair(const ContactEquations& p, const ContactUnknown& c) {
  if (c.normal < 0 || c.tangent < 0) return false;
  const double nn = p.D(c.normal, c.normal), tt = p.D(c.tangent, c.tangent), nt = p.D(c.normal, c.tangent);
  return nn * tt - nt * nt <= same_freedom * nn * tt;
}

SolverSummary closed_form(ContactEquations& p, double, SolverRoom&) {
  auto& c = p.unknowns.front();
  const int n = c.normal, t = c.tangent;
  return {solve_one(c, n >= 0 ? p.b[n] : 0, t >= 0 ? p.b[t] : 0, n >= 0 ? p.D(n, n) : 0,
                    n >= 0 && t >= 0 ? p.D(n, t) : 0, t >= 0 ? p.D(t, t) : 0)};
}

// Enumeration of the modes of a small contact problem.

/// Tries all combinations of open, stick, slip right and slip left. Each gives a small linear
/// system, whose solution is accepted if its residual is small enough. The mode of the initial
/// impulses comes first, because it rarely changes from step to step. Of the other modes the first
/// consistent one is taken; sticking precedes slipping.
SolverSummary enumeration(ContactEquations& p, double accepted, SolverRoom&) {
  auto& unknowns = p.unknowns;
  const auto& D = p.D;
  const auto& b = p.b;
  int cases = 0;
  constexpr int most = 2 * most_for_enumeration;
  const int n = static_cast<int>(unknowns.size());
  if (n > most_for_enumeration) return {false, cases};
  enum { open, stick, right, left };  // a preloaded joint has no open case
  std::array<int, most_for_enumeration> state{};
  const auto first = [&](int i) { return unknowns[i].normal < 0 ? stick : open; };
  const auto last = [&](int i) { return unknowns[i].tangent < 0 ? stick : left; };
  bool given = true;
  for (int i = 0; i < n; ++i) {
    const auto& c = unknowns[i];
    const double bound = (c.bound + c.friction * c.impulse_n) * (1 - 1e-9);
    if (c.normal >= 0 && c.impulse_n <= 0)
      state[i] = open;
    else if (c.tangent < 0 || std::abs(c.impulse_t) < bound)
      state[i] = stick;
    else
      state[i] = c.impulse_t < 0 ? right : left;
  }
  Eigen::Matrix<double, -1, -1, 0, most, most> K;
  Eigen::Matrix<double, -1, 1, 0, most, 1> x;
  std::array<int, most> equation{};

  for (;;) {
    ++cases;
    // Rows whose rates vanish, and their unknown impulses in the same order.
    int m = 0;
    for (int i = 0; i < n; ++i) {
      if (unknowns[i].normal >= 0 && state[i] != open) equation[m++] = unknowns[i].normal;
      if (unknowns[i].tangent >= 0 && state[i] == stick) equation[m++] = unknowns[i].tangent;
    }
    K.resize(m, m);
    x.resize(m);
    for (int r = 0; r < m; ++r) {
      const int row = equation[r];
      double rest = b[row];
      int column = 0;
      for (int i = 0; i < n; ++i) {
        const auto& c = unknowns[i];
        if (row == c.normal) rest -= c.target_n;
        if (row == c.tangent) rest -= c.target_t;
        // sign of the friction impulse
        const double side = state[i] == right ? -1 : state[i] == left ? 1 : 0;
        if (c.tangent >= 0 && side != 0) rest += D(row, c.tangent) * side * c.bound;
        if (c.normal >= 0 && state[i] != open)
          K(r, column++) = D(row, c.normal) + (side != 0 ? side * c.friction * D(row, c.tangent) : 0);
        if (c.tangent >= 0 && state[i] == stick) K(r, column++) = D(row, c.tangent);
      }
      x[r] = -rest;
    }
    if (m > 0) x = K.partialPivLu().solve(x).eval();
    int column = 0;
    for (int i = 0; i < n; ++i) {
      auto& c = unknowns[i];
      const double side = state[i] == right ? -1 : state[i] == left ? 1 : 0;
      c.impulse_n = c.normal >= 0 && state[i] != open ? x[column++] : 0;
      if (c.tangent >= 0)
        c.impulse_t = state[i] == stick ? x[column++] : side * (c.bound + c.friction * c.impulse_n);
    }
    if (p.residual() <= accepted) return {true, cases};
    if (given) {
      given = false;
      for (int j = 0; j < n; ++j) state[j] = first(j);
      continue;
    }
    int i = 0;
    for (; i < n; ++i) {
      if (state[i] < last(i)) {
        ++state[i];
        break;
      }
      state[i] = first(i);
    }
    if (i == n) return {false, cases};
  }
}

// Lemke's method (numerics/complementarity.hpp) on contact problems. The standard form as a linear
// complementarity problem (Glocker, Set-Valued Force Laws, 2001): with P_T = P_R − μP_N and
// u_T = u_R − u_L, the unknowns are z = (P_N, P_R, u_L) and w = (u_N⁺ + e u_N⁻, u_R, P_L = 2μP_N −
// P_R).

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
  const auto size = begin(p, 2, room);
  const int normals = size.normals, tangents = size.tangents, n = size.unknowns;
  const double scale = size.scale;
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
  const auto size = begin(p, 3, room);
  const int normals = size.normals, tangents = size.tangents, n = size.unknowns;
  const double scale = size.scale;
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

/// Proximal-point iteration: each iterate solves the problem with D + ε and b − εP of the last
/// iterate. Lemke's method solves these problems where contacts share their loads and D is
/// singular. Newton steps on the original problem follow each iterate.
SolverSummary proximal(ContactEquations& p, double accepted, SolverRoom& room) {
  auto& unknowns = p.unknowns;
  auto& D = p.D;
  auto& b = p.b;
  const int rows = p.rows;
  int pivots = 0;
  constexpr int most = 30;
  const Eigen::MatrixXd kept = D.topLeftCorner(rows, rows);
  const Eigen::VectorXd base = b.head(rows);
  Eigen::VectorXd last = Eigen::VectorXd::Zero(rows), weight(rows);
  const double greatest = kept.diagonal().cwiseAbs().maxCoeff();
  for (int r = 0; r < rows; ++r) weight[r] = std::max(kept(r, r), 1e-3 * greatest);
  for (const double epsilon : {1e-4, 1e-2, 1.0})
    for (int i = 0; i < most; ++i) {
      D.topLeftCorner(rows, rows).diagonal() += epsilon * weight;
      b.head(rows) -= epsilon * weight.cwiseProduct(last);
      const auto found = lemke(p, accepted, room);
      pivots += found.iterations;
      D.topLeftCorner(rows, rows) = kept;
      b.head(rows) = base;
      if (!found.solved) break;
      double moved = 0;
      for (const auto& c : unknowns) {
        if (c.normal >= 0)
          moved = std::max(
              moved, weight[c.normal] * std::abs(c.impulse_n - std::exchange(last[c.normal], c.impulse_n)));
        if (c.tangent >= 0)
          moved = std::max(
              moved, weight[c.tangent] * std::abs(c.impulse_t - std::exchange(last[c.tangent], c.impulse_t)));
      }
      const auto refined = newton_from(From::given, p, accepted);
      pivots += refined.iterations;
      if (refined.solved) return {true, pivots};
      for (auto& c : unknowns) {
        if (c.normal >= 0) c.impulse_n = last[c.normal];
        if (c.tangent >= 0) c.impulse_t = last[c.tangent];
      }
      if (p.residual() <= std::max(accepted, p.attainable())) return {true, pivots};
      if (epsilon * moved <= 1e-3 * accepted) break;
    }
  return {false, pivots};
}

}  // namespace freeplay
