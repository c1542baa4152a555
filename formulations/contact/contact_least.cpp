// Choice of impulses where the laws admit several. This happens if D is singular, because contacts
// share their loads or depend on fewer freedoms than they have rows (a lever on a stop has one
// freedom); and if friction admits several motions. The impulses taken minimise
//
//     Σ D_NN P_N² + η² Σ D_TT P_T²,   η = 1e-3,
//
// over all impulses that the laws admit. For each motion these form a convex set, so the minimum is
// unique and does not depend on the solver or on mirroring the scene. If two motions have equal
// minima, as mirror images of each other, one of them is taken. Normal impulses have the greater
// weight: friction that can help to stop the contact does so, as it does along the impact while the
// contact slides, and in the direction that dissipates.
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "formulations/contact/contact_least.hpp"
#include "numerics/complementarity.hpp"

namespace freeplay {
namespace {

/// Mode of a contact: pressed or not, and its tangential mode; right: it slides with u_T > 0. A
/// contact without normal impulse still has friction if it has an additional bound, as in
/// expansion.
struct Doing {
  bool pressed;
  enum class Slide { none, stick, right, left } slide;
};
using Slide = Doing::Slide;

std::vector<Doing> choices(const ContactUnknown& c) {
  std::vector<Doing> list;
  const auto rub = [&](bool pressed) {
    for (const auto slide : {Slide::stick, Slide::right, Slide::left}) list.push_back({pressed, slide});
  };
  if (c.normal < 0 || (c.tangent >= 0 && c.bound > 0))
    rub(false);
  else
    list.push_back({false, Slide::none});
  if (c.normal < 0) return list;
  if (c.tangent >= 0)
    rub(true);
  else
    list.push_back({true, Slide::none});
  return list;
}

/// The problem in dimensionless form: rows and impulses are scaled by √D_rr, and all of them by the
/// greatest rate.
struct Scaled {
  struct Contact {
    int normal, tangent;
    double friction, bound, target_n, target_t;
  };
  std::vector<Contact> contacts;
  Eigen::MatrixXd D;
  Eigen::VectorXd b, root, weight;
  double unit = 0;

  explicit Scaled(const ContactEquations& p) {
    const int m = p.rows;
    root = p.D.diagonal().head(m).cwiseAbs();
    // A row that no impulse can move has a constant rate.
    root = root.cwiseMax(1e-14 * root.maxCoeff()).cwiseSqrt();
    D = p.D.topLeftCorner(m, m);
    for (int r = 0; r < m; ++r)
      for (int s = 0; s < m; ++s) D(r, s) /= root[r] * root[s];
    b = p.b.head(m).cwiseQuotient(root);
    weight.setOnes(m);
    unit = b.cwiseAbs().maxCoeff();
    for (const auto& u : p.unknowns) {
      const double n = u.normal >= 0 ? root[u.normal] : 1, t = u.tangent >= 0 ? root[u.tangent] : 1;
      contacts.push_back(
          {u.normal, u.tangent, u.friction * t / n, u.bound * t, u.target_n / n, u.target_t / t});
      unit = std::max({unit, std::abs(u.target_n / n), u.tangent >= 0 ? std::abs(u.target_t / t) : 0});
      if (u.tangent >= 0) weight[u.tangent] = 1e-3;
    }
    if (!(unit > 0)) unit = 1;
    b /= unit;
    for (auto& c : contacts) {
      c.bound /= unit;
      c.target_n /= unit;
      c.target_t /= unit;
    }
  }
};

constexpr double rounding = 1e-11;  // of rates and impulses of order one

// Islands for which the least impulses are computed have two rows per contact and up to four
// conditions. Fixed sizes avoid allocations, because thousands of modes may be tried.
constexpr int most_rows = 2 * most_for_least_of_mode, most_conditions = 2 * most_rows;
using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_rows, 1>;
using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_rows, most_rows>;
using Row = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, most_rows>;

/// Conditions `rows` P + `constants` ≥ 0 of a mode, where P = E x + f with the unknowns x of the
/// mode.
struct Mode {
  const Scaled& p;
  Block D, E, K0;  // K0 P are the rates that have to equal `zero_at`
  Column f, zero_at;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, most_conditions, most_rows>
      rows;  // in P
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_conditions, 1> constants;
  Eigen::Index conditions = 0, zeros = 0;

  explicit Mode(const Scaled& problem) : p(problem), D(problem.D) {}

  void at_least(const Row& row, double constant) {
    rows.row(conditions) = row;
    constants[conditions++] = constant;
  }
  /// The rate of this row equals `at`.
  void held(int row, double at) {
    K0.row(zeros) = D.row(row);
    zero_at[zeros++] = at - p.b[row];
  }

  void pose(const std::vector<Doing>& ways) {
    const auto m = p.b.size();
    conditions = zeros = 0;
    rows.resize(2 * m + 2, m);
    constants.resize(2 * m + 2);
    K0.resize(m, m);
    zero_at.resize(m);
    f.setZero(m);
    E.setZero(m, m);
    Eigen::Index x = 0;
    for (std::size_t i = 0; i < ways.size(); ++i) {
      const auto& c = p.contacts[i];
      const auto [pressed, slide] = ways[i];
      // sign of the friction impulse
      const double side = slide == Slide::right ? -1 : slide == Slide::left ? 1 : 0;
      if (pressed) {
        held(c.normal, c.target_n);
        E(c.normal, x) = 1;
        if (side != 0) E(c.tangent, x) = side * c.friction;
        ++x;
        at_least(unit(c.normal), 0);
      } else if (c.normal >= 0) {
        at_least(D.row(c.normal), p.b[c.normal] - c.target_n);
      }
      if (side != 0) {
        f[c.tangent] = side * c.bound;
        at_least(-side * D.row(c.tangent), -side * (p.b[c.tangent] - c.target_t));
      } else if (slide == Slide::stick) {
        held(c.tangent, c.target_t);
        E(c.tangent, x++) = 1;
        for (const double sign : {1.0, -1.0}) {
          Row row = sign * unit(c.tangent);
          if (c.normal >= 0) row[c.normal] = c.friction;
          at_least(row, c.bound);
        }
      }
    }
    E.conservativeResize(m, x);
  }

  Row unit(int row) const { return Row::Unit(p.b.size(), row); }

  /// Computes the least impulses of the mode; returns false if it admits none.
  bool least(Column& P) const {
    Column x(E.cols());
    Block free;  // directions of x that do not change these rates
    if (zeros > 0) {
      const Block K = K0.topRows(zeros) * E;
      const Column y = zero_at.head(zeros) - K0.topRows(zeros) * f;
      Eigen::CompleteOrthogonalDecomposition<Block> solver;
      solver.setThreshold(1e-10);
      solver.compute(K);
      x = solver.solve(y);
      if (!((K * x - y).cwiseAbs().maxCoeff() <= rounding * (1 + x.cwiseAbs().maxCoeff()))) return false;
      const auto rank = solver.rank();
      if (rank < x.size()) free = solver.matrixZ().adjoint().rightCols(x.size() - rank);
      if (rank < x.size()) free = solver.colsPermutation() * free;
    }
    P = E * x + f;
    const double none = rounding * (1 + P.cwiseAbs().maxCoeff());
    const auto n = conditions;
    const auto short_by = [&] { return n > 0 ? -(rows.topRows(n) * P + constants.head(n)).minCoeff() : 0; };
    if (free.size() == 0) return !(short_by() > none);
    // Minimise |W(P + E free s)|. With W E free = Q R and r = R s + QᵀWP this is the least r with G
    // r ≥ h.
    const Eigen::MatrixXd move = E * free;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(p.weight.asDiagonal() * move);
    const auto d = free.cols();
    const Eigen::MatrixXd R = qr.matrixQR().topLeftCorner(d, d).triangularView<Eigen::Upper>();
    const Eigen::MatrixXd Q = qr.householderQ() * Eigen::MatrixXd::Identity(P.size(), d);
    const Eigen::VectorXd offset = Q.transpose() * p.weight.cwiseProduct(P);
    // P = P₀ + step (r − offset)
    const Eigen::MatrixXd step = R.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(move);
    const Eigen::VectorXd base = P - step * offset;
    Eigen::MatrixXd G(n, d);
    Eigen::VectorXd h(n), r;
    for (Eigen::Index i = 0; i < n; ++i) {
      G.row(i) = rows.row(i) * step;
      h[i] = -constants[i] - rows.row(i).dot(base);
      const double length = G.row(i).norm();
      if (length <= 1e-10 * rows.row(i).norm()) {  // the impulses do not change this row
        if (h[i] > none) return false;
        G.row(i).setZero();
        h[i] = -1;
        continue;
      }
      G.row(i) /= length;
      h[i] /= length;
    }
    if (!least_distance(G, h, none, r)) return false;
    P = base + step * r;
    return !(short_by() > 10 * none);
  }
};

/// Least impulses of an island over all its modes or, if there are too many, over the mode of the
/// present impulses.
bool use_least_impulses_of_island(ContactEquations& p) {
  auto& unknowns = p.unknowns;
  const Scaled scaled(p);
  Mode mode(scaled);
  const auto n = unknowns.size();
  std::vector<std::vector<Doing>> all(n);
  for (std::size_t i = 0; i < n; ++i) all[i] = choices(unknowns[i]);
  if (n > most_for_least) {  // modes of the motion that was found
    const double none = 1e-8 * p.scale();
    for (std::size_t i = 0; i < n; ++i) {
      const auto& c = unknowns[i];
      const bool pressed = c.normal >= 0 && p.rate(c.normal) - c.target_n <= none;
      const double u = c.tangent >= 0 ? p.rate(c.tangent) - c.target_t : 0;
      const auto slide = c.tangent < 0 ? Slide::none
                         : u > none    ? Slide::right
                         : u < -none   ? Slide::left
                                       : Slide::stick;
      std::erase_if(all[i], [&](const Doing& doing) {
        return doing.pressed != pressed || (doing.slide != Slide::none && doing.slide != slide);
      });
      if (all[i].empty()) return false;
    }
  }
  std::vector<Doing> ways(n);
  std::vector<std::size_t> at(n, 0);
  Column P, best;
  double least = INFINITY;
  for (std::size_t i = 0; i < n;) {
    for (std::size_t k = 0; k < n; ++k) ways[k] = all[k][at[k]];
    mode.pose(ways);
    if (mode.least(P))
      if (const double length = scaled.weight.cwiseProduct(P).norm(); length < least * (1 - 1e-9)) {
        least = length;
        best = P;
      }
    for (i = 0; i < n && ++at[i] == all[i].size(); ++i) at[i] = 0;
  }
  if (best.size() == 0) return false;
  best = scaled.unit * best.cwiseQuotient(scaled.root);
  for (auto& c : unknowns) {
    c.impulse_n = c.normal >= 0 ? std::max(0.0, best[c.normal]) : 0;
    c.impulse_t = c.tangent >= 0 ? best[c.tangent] : 0;
  }
  return true;
}

/// Whether D is positive definite beyond rounding and the friction too low to admit a second
/// motion.
bool regular(const ContactEquations& p, SolverRoom& room) {
  const auto& D = p.D;
  const int rows = p.rows;
  auto& factor = room.factor;
  if (factor.rows() < rows) factor.setZero(D.rows(), D.rows());
  for (const auto& c : p.unknowns)
    if (c.normal >= 0 && c.tangent >= 0 &&
        D(c.normal, c.normal) <= c.friction * std::abs(D(c.normal, c.tangent)))
      return false;
  for (int r = 0; r < rows; ++r)
    for (int s = 0; s <= r; ++s) {
      double sum = D(r, s);
      for (int k = 0; k < s; ++k) sum -= factor(r, k) * factor(s, k);
      if (r > s)
        factor(r, s) = sum / factor(s, s);
      else if (sum > 1e-10 * D(r, r))
        factor(r, r) = std::sqrt(sum);
      else
        return false;
    }
  return true;
}

}  // namespace

bool wants_least(Least least, const ContactEquations& p, SolverRoom& room) {
  const auto& unknowns = p.unknowns;
  if (least == Least::never) return false;
  const bool alone = unknowns.size() == 1;
  if (least == Least::where_singular) return !alone && !regular(p, room);
  // A single contact, or contacts without friction, have one solution if D is regular.
  const bool smooth = std::ranges::all_of(unknowns, [](const ContactUnknown& c) { return c.tangent < 0; });
  return !((alone || smooth) && regular(p, room));
}

bool use_least_impulses(ContactEquations& p, double accepted, bool solved) {
  std::vector<int> label, members;
  const int islands = p.label_islands(label);
  bool found = true;
  for (int k = 0; k < islands; ++k) {
    auto part = p.island(label, k, members);
    const double left = solved ? part.residual() : INFINITY;
    // With rounding, the least impulses may have a greater residual than the solver's; the solver's
    // are then kept.
    if (members.size() > most_for_least_of_mode || !use_least_impulses_of_island(part) ||
        !(part.residual() <= std::max({accepted, part.attainable(), left}))) {
      found = false;
      continue;
    }
    p.take_impulses(part, members);
  }
  return found;
}

}  // namespace freeplay
