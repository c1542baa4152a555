#include "formulations/contact/newton.hpp"

#include <Eigen/LU>
#include <Eigen/QR>

#include <cmath>
#include <functional>

namespace freeplay {

namespace {

/// The projections of a dense problem. `room`: greatest number of rows of matrices on the stack, or
/// Eigen::Dynamic.
template <int room>
class DenseProjections {
 public:
  DenseProjections(ContactEquations& p, double accepted, From from)
      : p_(p),
        accepted_(accepted),
        from_(from),
        F_(p.rows),
        P_(p.rows),
        now_(p.rows),
        step_(p.rows),
        J_(p.rows, p.rows) {}

  double evaluate(bool with_derivative) {
    for (const auto& c : p_.unknowns) {
      if (c.normal >= 0) now_[c.normal] = c.impulse_n;
      if (c.tangent >= 0) now_[c.tangent] = c.impulse_t;
    }
    project_on_laws(p_.unknowns, *this, with_derivative);
    return F_.squaredNorm();
  }
  bool solved() const { return p_.residual() <= accepted_; }
  bool find_step() {
    P_ = now_;
    const Eigen::PartialPivLU<Matrix> lu(J_);
    const auto pivots = lu.matrixLU().diagonal().cwiseAbs();
    if (pivots.minCoeff() > 1e-12 * pivots.maxCoeff()) {
      step_ = -lu.solve(F_);
    } else if (from_ == From::last) {
      return false;
    } else {  // forces are not unique: take the least change
      Eigen::CompleteOrthogonalDecomposition<Matrix> decomposition;
      decomposition.setThreshold(1e-11);
      step_ = -decomposition.compute(J_).solve(F_);
    }
    return true;
  }
  void move(double share) {
    now_ = P_ + share * step_;
    for (auto& c : p_.unknowns) {
      if (c.normal >= 0) c.impulse_n = now_[c.normal];
      if (c.tangent >= 0) c.impulse_t = now_[c.tangent];
    }
  }

  // rows of the projections
  double rate(int r) const { return p_.rate(r); }
  double impulse(int r) const { return now_[r]; }
  double rho(int r) const { return 1 / p_.D(r, r); }
  void value(int r, double f) { F_[r] = f; }
  void follows(int r, double rho) { J_.row(r) = rho * p_.D.row(r).head(p_.rows); }
  void free(int r) {
    J_.row(r).setZero();
    J_(r, r) = 1;
  }
  double& entry(int r, int n) { return J_(r, n); }

 private:
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, room, 1>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, room, room>;
  ContactEquations& p_;
  double accepted_;
  From from_;
  Vector F_, P_, now_, step_;
  Matrix J_;
};

}  // namespace

SolverSummary newton_from(From from, ContactEquations& p, double accepted) {
  const int most = from == From::nothing ? 100 : from == From::given ? 20 : 4;
  if (from == From::nothing)
    for (auto& c : p.unknowns) c.impulse_n = c.impulse_t = 0;
  // up to this many rows, matrices are on the stack: steps of a small mechanism allocate no memory
  constexpr int few = 24, halvings = 12;
  if (p.rows <= few) {
    DenseProjections<few> projections(p, accepted, from);
    return newton_steps(projections, most, halvings);
  }
  DenseProjections<Eigen::Dynamic> projections(p, accepted, from);
  return newton_steps(projections, most, halvings);
}

SolverSummary newton(ContactEquations& p, double accepted, SolverRoom&) {
  return newton_from(From::nothing, p, accepted);
}

SolverSummary newton_from_last(ContactEquations& p, double accepted, SolverRoom& room) {
  auto& unknowns = p.unknowns;
  if (std::ranges::none_of(unknowns, [](const auto& c) { return c.impulse_n > 0 || c.impulse_t != 0; }))
    return {};
  auto& last = room.last;
  last.clear();
  for (const auto& c : unknowns) last.push_back({c.impulse_n, c.impulse_t});
  const auto result = newton_from(From::last, p, accepted);
  for (std::size_t i = 0; !result.solved && i < last.size(); ++i) {
    unknowns[i].impulse_n = last[i][0];
    unknowns[i].impulse_t = last[i][1];
  }
  return result;
}

/// Computes the pattern of the Jacobian: that of D, with the diagonal and both rows of a contact.
void SparseNewton::analyse(const SparseIsland& x) {
  begin_.assign(1, 0);
  column_.clear();
  const auto add_row = [&](int r, int other) {
    const int own = x.begin[r], end = x.begin[r + 1], first = static_cast<int>(column_.size());
    column_.insert(column_.end(), x.column.begin() + own, x.column.begin() + end);
    for (const int s : {r, other})
      if (s >= 0 && std::find(column_.begin() + first, column_.end(), s) == column_.end())
        column_.push_back(s);
    begin_.push_back(static_cast<int>(column_.size()));
  };
  normal_of_.assign(x.slots.size(), -1);
  for (const auto& c : x.unknowns)
    if (c.tangent >= 0) normal_of_[c.tangent] = c.normal;
  for (std::size_t r = 0; r < x.slots.size(); ++r) add_row(static_cast<int>(r), normal_of_[r]);
  pattern_begin_ = begin_;
  pattern_column_ = column_;
  jacobian_.analyse(pattern_begin_, pattern_column_);
}

double& SparseNewton::at(int row, int column) {
  int e = begin_[row];
  while (column_[e] != column) ++e;
  return jacobian_.values()[e];
}

/// Sets row r of the Jacobian to ρ times the row of D.
void SparseNewton::follow(const SparseIsland& x, int r, double rho) {
  for (int e = x.begin[r]; e < x.begin[r + 1]; ++e)
    jacobian_.values()[begin_[r] + e - x.begin[r]] = rho * x.value[e];
}

/// Factorises the Jacobian; for the least change of shared contact forces with an addition to its
/// diagonal. Returns false if it is singular nevertheless.
bool SparseNewton::factor(Shared shared) {
  if (jacobian_.factor(1e-11)) return true;
  if (shared == Shared::fail) return false;
  for (const double proximal : {1e-9, 1e-6}) {
    for (std::size_t r = 0; r + 1 < begin_.size(); ++r)
      at(static_cast<int>(r), static_cast<int>(r)) += proximal;
    if (jacobian_.factor(1e-11)) return true;
  }
  return false;
}

/// The projections of an island with D by rows.
class SparseNewton::Projections {
 public:
  Projections(SparseNewton& in, SparseIsland& x, double accepted, Shared shared)
      : in_(in), x_(x), accepted_(accepted), shared_(shared) {}

  double evaluate(bool with_derivative) {
    if (with_derivative) std::ranges::fill(in_.jacobian_.values(), 0.0);
    sum_ = 0;
    project_on_laws(x_.unknowns, *this, with_derivative);
    return sum_;
  }
  bool solved() const { return std::isfinite(sum_) && x_.residual() <= std::max(accepted_, x_.attainable()); }
  bool find_step() {
    in_.P_ = x_.impulse;
    if (!in_.factor(shared_) && shared_ == Shared::fail) return false;
    std::ranges::transform(in_.F_, in_.step_.begin(), std::negate());
    in_.jacobian_.solve(in_.step_.data());
    return true;
  }
  void move(double share) {
    for (std::size_t r = 0; r < in_.P_.size(); ++r) x_.impulse[r] = in_.P_[r] + share * in_.step_[r];
  }

  // rows of the projections
  double rate(int r) const { return x_.rate(r); }
  double impulse(int r) const { return x_.impulse[r]; }
  double rho(int r) const { return x_.rho(r); }
  void value(int r, double f) {
    in_.F_[r] = f;
    sum_ += f * f;
  }
  void follows(int r, double rho) { in_.follow(x_, r, rho); }
  void free(int r) { in_.at(r, r) = 1; }
  double& entry(int r, int n) { return in_.at(r, n); }

 private:
  SparseNewton& in_;
  SparseIsland& x_;
  double accepted_, sum_ = 0;
  Shared shared_;
};

SolverSummary SparseNewton::solve(SparseIsland& x, double accepted, int most, Shared shared) {
  analyse(x);
  F_.resize(x.slots.size());
  step_.resize(x.slots.size());
  Projections projections(*this, x, accepted, shared);
  const auto found = newton_steps(projections, most, 12);
  return {found.solved || projections.solved(), found.iterations};
}

bool SparseNewton::hold(SparseIsland& x) {
  analyse(x);
  x.impulse.resize(x.slots.size());
  std::ranges::fill(jacobian_.values(), 0.0);
  for (int r = 0; r < static_cast<int>(x.slots.size()); ++r) {
    const double rho = x.rho(r);
    follow(x, r, rho);
    if (rho == 0) at(r, r) = 1;
    x.impulse[r] = -rho * x.b[r];
  }
  if (!factor(Shared::least_change)) return false;
  jacobian_.solve(x.impulse.data());
  return std::ranges::all_of(x.impulse, [](double impulse) { return std::isfinite(impulse); });
}

}  // namespace freeplay
