#include "formulations/contact/contact_problem.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace freeplay {
namespace {

/// D_NN D_TT − D_NT² over D_NN D_TT, below which the two rows of a contact see one freedom.
constexpr double same_freedom = 1e-12;

}  // namespace

void ContactSolution::count(Work& work, Extremes& extremes) const {
  work.pivots += pivots;
  work.lcp_retries += retries;
  extremes.lcp_residual = std::max(extremes.lcp_residual, residual);
  extremes.lcp_residual_rate = std::max(extremes.lcp_residual_rate, residual_rate);
  extremes.ambiguous += ambiguous;
}

void ContactProblem::reserve(int size) {
  if (size <= D.rows()) return;
  D.conservativeResizeLike(Eigen::MatrixXd::Zero(size, size));
  b.conservativeResizeLike(Eigen::VectorXd::Zero(size));
  unknowns.reserve(size);
  last_.reserve(static_cast<std::size_t>(size));
  factor_.setZero(size, size);
}

void ContactProblem::reserve_rates(int size) {
  b.setZero(std::max<Eigen::Index>(size, b.size()));
  unknowns.reserve(size);
  last_.reserve(static_cast<std::size_t>(size));
}

std::array<ContactProblem::Way, 4> ContactProblem::order() const {
  using enum Way;
  const auto n = static_cast<int>(unknowns.size());
  if (n == 1 && singular_pair())
    return {closed_form, lemke, newton, none};  // which impulses is a rule, no solver's
  switch (solver_) {
    case LcpSolver::enumeration:
      return n <= most_for_enumeration ? std::array{enumeration, lemke, newton, gauss_seidel}
                                       : std::array{lemke, newton, gauss_seidel, none};
    case LcpSolver::lemke:
      return {lemke, newton, gauss_seidel, none};
    case LcpSolver::gauss_seidel:
      return {gauss_seidel, lemke, newton, none};
    case LcpSolver::newton:
      return {newton, lemke, gauss_seidel, none};
    case LcpSolver::automatic:
      if (n == 1) return {closed_form, lemke, newton, none};
      if (n == 2) return {enumeration, lemke, newton, gauss_seidel};
      if (n <= most_for_lemke) return {lemke, newton, gauss_seidel, none};
      return {gauss_seidel, lemke, newton, none};
  }
  throw std::logic_error("no such solver of contact problems");
}

ContactSolution ContactProblem::solve_near() {
  if (unknowns.size() < 2) return solve();
  ContactSolution s;
  const double size = scale();
  s.solved = newton(tolerance_ * size, s.pivots, From::given);
  if (!s.solved) return solve();
  s.residual_rate = residual();
  s.residual = size > 0 ? s.residual_rate / size : s.residual_rate;
  return s;
}

double ContactProblem::attainable() const {
  double most = 0;
  for (const auto& c : unknowns)
    for (const int row : {c.normal, c.tangent}) {
      if (row < 0) continue;
      double sum = std::abs(b[row]);
      for (const auto& o : unknowns) {
        if (o.normal >= 0) sum += std::abs(D(row, o.normal) * o.impulse_n);
        if (o.tangent >= 0) sum += std::abs(D(row, o.tangent) * o.impulse_t);
      }
      most = std::max(most, sum);
    }
  return 1e-13 * most;
}

ContactSolution ContactProblem::solve() {
  ContactSolution s;
  if (unknowns.empty()) return s;
  const double size = std::max(scale(), least_scale_), accepted = tolerance_ * size;
  s.solved = false;
  if (static_cast<int>(unknowns.size()) > most_for_lemke && solver_ == LcpSolver::automatic &&
      by_islands(s)) {
    if (s.solved && wants_least()) take_least(accepted, true);
    s.residual_rate = residual();
    s.residual = size > 0 ? s.residual_rate / size : s.residual_rate;
    return s;
  }
  // Rounding may keep all solvers from the tolerance: the best of theirs is kept, for less is owed than nothing.
  constexpr double loose = 1e-6;
  std::vector<ContactUnknown> best;
  double best_rate = loose * size;
  bool judged = false;  // residual_rate is of the present impulses
  const auto keep = [&] {
    const double left = residual();
    if (!(left < best_rate)) return;
    best_rate = left;
    best = unknowns;
  };
  for (const Way way : order()) {
    if (way == Way::none) break;
    for (auto& c : unknowns)  // nothing is to be taken from a solver that failed
      if (s.retries > 0) c.impulse_n = c.impulse_t = 0;
    const bool found = attempt(way, accepted, s.pivots);
    s.residual_rate = residual();
    s.solved = found && std::isfinite(s.residual_rate) &&
               (s.residual_rate <= accepted || s.residual_rate <= attainable());
    if (s.solved) {
      judged = true;
      break;
    }
    keep();
    ++s.retries;
  }
  if (!s.solved && unknowns.size() > 1) {
    s.solved = by_copositive_lemke(accepted, s.pivots);
    keep();
  }
  if (!s.solved && unknowns.size() > 1) {
    s.solved = proximal(accepted, s.pivots);
    keep();
  }
  if (!s.solved && !best.empty()) {
    unknowns = best;
    s.solved = true;
  }
  s.solved = s.solved || (std::isfinite(size) && D.topLeftCorner(rows, rows).allFinite() && by_modes(s));
  if (least != Least::never && std::isfinite(size) && D.topLeftCorner(rows, rows).allFinite() &&
      wants_least()) {
    s.solved = take_least(accepted, s.solved) || s.solved;
    judged = false;
  }
  if (!judged) s.residual_rate = residual();
  s.residual = size > 0 ? s.residual_rate / size : s.residual_rate;
  if (s.solved && doubtful()) {
    std::vector<std::vector<int>> members;
    for (const auto& m : doubtful_motions(members)) {
      s.ambiguous |= m.decided && m.motions.size() > 1;
      s.undecided |= !m.decided;
      modes_left -= m.tried;
    }
  }
  return s;
}

/// Each island alone; false where there is but one.
bool ContactProblem::by_islands(ContactSolution& s) {
  std::vector<int> label, members;
  const int islands = label_islands(label);
  if (islands < 2) return false;
  s.solved = true;
  for (int k = 0; k < islands; ++k) {
    auto part = island(label, k, members);
    const auto one = part.solve();
    modes_left = part.modes_left;
    s.solved = s.solved && one.solved;
    s.ambiguous |= one.ambiguous;
    s.undecided |= one.undecided;
    s.impossible |= one.impossible;
    s.pivots += one.pivots;
    s.retries += one.retries;
    for (std::size_t i = 0; i < members.size(); ++i) {
      unknowns[members[i]].impulse_n = part.unknowns[i].impulse_n;
      unknowns[members[i]].impulse_t = part.unknowns[i].impulse_t;
    }
  }
  return true;
}

/// All modes tried, where they are few enough: the first that is consistent, or that there is none.
bool ContactProblem::by_modes(ContactSolution& s) {
  const auto all = modes(1);
  modes_left -= all.tried;
  s.pivots += static_cast<int>(all.tried);
  s.impossible = all.decided && all.motions.empty();
  if (all.motions.empty()) return false;
  for (auto& c : unknowns) {
    c.impulse_n = c.normal >= 0 ? all.motions[0].impulses[c.normal] : 0;
    c.impulse_t = c.tangent >= 0 ? all.motions[0].impulses[c.tangent] : 0;
  }
  return true;
}

bool ContactProblem::attempt(Way way, double accepted, int& pivots) {
  switch (way) {
    case Way::closed_form: {
      auto& c = unknowns.front();
      const int n = c.normal, t = c.tangent;
      return solve_one(c, n >= 0 ? b[n] : 0, t >= 0 ? b[t] : 0, n >= 0 ? D(n, n) : 0,
                       n >= 0 && t >= 0 ? D(n, t) : 0, t >= 0 ? D(t, t) : 0);
    }
    case Way::enumeration:
      return enumerate(accepted, pivots);
    case Way::gauss_seidel:
      if (solver_ == LcpSolver::gauss_seidel) return gauss_seidel(accepted, pivots);
      // Where the same contacts press, stick and slide as in the last problem a step or two of Newton's are exact. Many contacts
      // that share their loads converge slowly in sweeps: from near the solution Newton's steps are few.
      return newton_from_last(accepted, pivots) || gauss_seidel(accepted, pivots, 100) ||
             newton(accepted, pivots, From::given) || gauss_seidel(accepted, pivots);
    case Way::newton:
      return newton(accepted, pivots);
    case Way::lemke:
      return by_lemke(pivots);
    case Way::none:
      break;
  }
  return false;
}

/// One element alone, in closed form by its cases: separation, stick, then slip either way. False where none
/// is consistent (Painlevé).
bool ContactProblem::solve_one(ContactUnknown& c, double bn, double bt, double Dnn, double Dnt, double Dtt) {
  bt -= c.target_t;
  if (c.normal < 0) {
    c.impulse_n = 0;
    c.impulse_t = std::clamp(-bt / Dtt, -c.bound, c.bound);
    return true;
  }
  bn -= c.target_n;
  c.impulse_n = c.impulse_t = 0;
  if (c.tangent < 0) {
    c.impulse_n = std::max(0.0, -bn / Dnn);
    return true;
  }
  if (c.bound > 0) {  // friction without pressure, where the contact stays open
    c.impulse_t = std::clamp(-bt / Dtt, -c.bound, c.bound);
    if (bn + Dnt * c.impulse_t >= 0) return true;
  } else if (bn >= 0) {
    return true;
  }
  const double determinant = Dnn * Dtt - Dnt * Dnt;
  const bool regular = determinant > same_freedom * Dnn * Dtt;
  const double Pn = (-bn * Dtt + bt * Dnt) / determinant, Pt = (-bt * Dnn + bn * Dnt) / determinant;
  if (regular && Pn >= 0 && std::abs(Pt) <= c.bound + c.friction * Pn) {
    c.impulse_n = Pn;
    c.impulse_t = Pt;
    return true;
  }
  // Where both rows see one freedom sticking is an end of sliding: of both ends the one with the least impulse.
  bool found = false;
  for (double s : {1.0, -1.0}) {
    const double slope = Dnn - s * c.friction * Dnt;
    if (!(slope > (regular ? 0 : same_freedom * Dnn))) continue;
    const double P = (-bn + s * c.bound * Dnt) / slope, T = -s * (c.bound + c.friction * P);
    const double none = regular ? 0 : same_freedom * (std::abs(bt) + std::abs(Dnt * P) + std::abs(Dtt * T));
    if (P < 0 || s * (bt + Dnt * P + Dtt * T) < -none) continue;
    if (found && P > c.impulse_n * (1 - same_freedom)) {
      if (P < c.impulse_n * (1 + same_freedom)) c.impulse_t = 0;  // friction moves nothing
      continue;
    }
    c.impulse_n = P;
    c.impulse_t = T;
    found = true;
    if (regular) break;
  }
  return found;
}

bool ContactProblem::singular_pair() const {
  const auto& c = unknowns.front();
  if (c.normal < 0 || c.tangent < 0) return false;
  const double nn = D(c.normal, c.normal), tt = D(c.tangent, c.tangent), nt = D(c.normal, c.tangent);
  return nn * tt - nt * nt <= same_freedom * nn * tt;
}

double ContactProblem::rate(int row) const {
  double u = b[row];
  for (const auto& c : unknowns) {
    if (c.normal >= 0) u += D(row, c.normal) * c.impulse_n;
    if (c.tangent >= 0) u += D(row, c.tangent) * c.impulse_t;
  }
  return u;
}

double ContactProblem::scale() const {
  double size = 0;
  for (const auto& c : unknowns) {
    if (c.normal >= 0) size = std::max({size, std::abs(b[c.normal]), std::abs(c.target_n)});
    if (c.tangent >= 0) size = std::max({size, std::abs(b[c.tangent]), std::abs(c.target_t)});
  }
  return size;
}

double ContactProblem::residual() const {
  double worst = 0;
  const auto take = [&](double x) {
    if (!(std::abs(x) <= worst)) worst = std::isnan(x) ? INFINITY : std::abs(x);
  };
  for (const auto& c : unknowns) {
    if (!std::isfinite(c.impulse_n) || !std::isfinite(c.impulse_t)) return INFINITY;
    if (c.normal >= 0)
      take(std::min(std::abs(D(c.normal, c.normal)) * c.impulse_n, rate(c.normal) - c.target_n));
    if (c.tangent < 0) continue;
    // −P_T ∈ bound·Sgn(u) is u = 0 or P_T at the bound against u: the distance to the nearer of both.
    const double u = rate(c.tangent) - c.target_t, Dtt = D(c.tangent, c.tangent);
    const double bound = c.bound + c.friction * std::max(0.0, c.impulse_n);
    const double to_bound = Dtt * std::abs(c.impulse_t + std::copysign(bound, u));
    take(std::min(std::abs(u), to_bound));
    take(Dtt * std::max(0.0, std::abs(c.impulse_t) - bound));
  }
  return worst;
}

/// Proximal points: D + ε with b − εP of the last iterate, which Lemke's method solves where contacts share
/// their loads and D is singular; each followed by Newton's steps on the problem itself.
bool ContactProblem::proximal(double accepted, int& pivots) {
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
      const bool found = by_lemke(pivots);
      D.topLeftCorner(rows, rows) = kept;
      b.head(rows) = base;
      if (!found) break;
      double moved = 0;
      for (const auto& c : unknowns) {
        if (c.normal >= 0)
          moved = std::max(
              moved, weight[c.normal] * std::abs(c.impulse_n - std::exchange(last[c.normal], c.impulse_n)));
        if (c.tangent >= 0)
          moved = std::max(
              moved, weight[c.tangent] * std::abs(c.impulse_t - std::exchange(last[c.tangent], c.impulse_t)));
      }
      if (newton(accepted, pivots, From::given)) return true;
      for (auto& c : unknowns) {
        if (c.normal >= 0) c.impulse_n = last[c.normal];
        if (c.tangent >= 0) c.impulse_t = last[c.tangent];
      }
      if (residual() <= std::max(accepted, attainable())) return true;
      if (epsilon * moved <= 1e-3 * accepted) break;
    }
  return false;
}

void ContactProblem::make_room(int n) {
  if (n <= lemke_size_) return;
  lemke_size_ = std::max(n, 2 * lemke_size_);
  lemke_ = Lemke(lemke_size_);
  A_.setZero(lemke_size_, lemke_size_);
  q_.setZero(std::max<Eigen::Index>(lemke_size_, q_.size()));
  z_.setZero(lemke_size_);
}

/// The problem as Anitescu and Potra pose it (Nonlinear Dynamics 14 (1997) 231): z = (P_N, P_+, P_−, λ), with
/// P_T = P_+ − P_− and w = (u_N − target, u_T + λ, −u_T + λ, bound + μP_N − P_+ − P_−). Its matrix is copositive when D
/// has no negative eigenvalue, so Lemke's method ends in a solution wherever no P ≥ 0 with WP = 0 gains from the
/// targets, in inelastic problems always. Newton's steps then take out its rounding.
bool ContactProblem::by_copositive_lemke(double accepted, int& pivots) {
  int normals = 0, tangents = 0;
  for (const auto& c : unknowns) {
    normals += c.normal >= 0;
    tangents += c.tangent >= 0;
  }
  const int n = normals + 3 * tangents;
  make_room(n);
  const double scale = 1 / D.diagonal().head(rows).maxCoeff();
  A_.topLeftCorner(n, n).setZero();
  const auto fill_row = [&](int place, int row, double sign) {
    int i = 0, j = normals;
    for (const auto& c : unknowns) {
      if (c.normal >= 0) A_(place, i++) = sign * D(row, c.normal) * scale;
      if (c.tangent < 0) continue;
      A_(place, j) = sign * D(row, c.tangent) * scale;
      A_(place, tangents + j) = -A_(place, j);
      ++j;
    }
  };
  int i = 0, j = normals;
  for (const auto& c : unknowns) {
    if (c.normal >= 0) {
      fill_row(i, c.normal, 1);
      q_[i] = b[c.normal] - c.target_n;
    }
    if (c.tangent >= 0) {
      const int right = j, left = j + tangents, lambda = left + tangents;
      fill_row(right, c.tangent, 1);
      fill_row(left, c.tangent, -1);
      q_[right] = b[c.tangent] - c.target_t;
      q_[left] = -q_[right];
      q_[lambda] = c.bound / scale;
      A_(right, lambda) = A_(left, lambda) = 1;
      A_(lambda, right) = A_(lambda, left) = -1;
      if (c.normal >= 0) A_(lambda, i) = c.friction;
      ++j;
    }
    i += c.normal >= 0;
  }
  const auto result = lemke_.solve(n, A_.data(), static_cast<int>(A_.rows()), q_.data(), z_.data());
  pivots += result.pivots;
  i = 0;
  j = normals;
  for (auto& c : unknowns) {
    c.impulse_n = c.normal >= 0 ? z_[i++] * scale : 0;
    c.impulse_t = c.tangent >= 0 ? (z_[j] - z_[j + tangents]) * scale : 0;
    j += c.tangent >= 0;
  }
  if (result.status == LcpResult::Status::ray) return false;
  const auto found = unknowns;
  const double left = residual();
  if (left <= std::max(accepted, attainable()) || newton(accepted, pivots, From::given)) return true;
  if (!(residual() < left)) unknowns = found;
  return false;
}

bool ContactProblem::by_lemke(int& pivots) {
  int normals = 0, tangents = 0;
  for (const auto& c : unknowns) {
    normals += c.normal >= 0;
    tangents += c.tangent >= 0;
  }
  const int n = normals + 2 * tangents;
  make_room(n);
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
      q_[place] -= D(row, c.tangent) * c.bound;
      A_(place, normals + j++) += Dt;
    }
  };
  int i = 0, j = 0;
  for (const auto& c : unknowns) {
    if (c.normal >= 0) fill_row(i, c.normal, b[c.normal] - c.target_n);
    if (c.tangent >= 0) {
      const int R = normals + j, L = normals + tangents + j;
      fill_row(R, c.tangent, b[c.tangent] - c.target_t);
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
      c.impulse_t = z_[normals + j++] * scale - c.friction * c.impulse_n - c.bound;
    else
      c.impulse_t = 0;
    i += c.normal >= 0;
  }
  pivots += result.pivots;
  return result.status == LcpResult::Status::solved;
}

}  // namespace freeplay
