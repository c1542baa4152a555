#include "analysis/play/play_extremes.hpp"

#include <coin/IpIpoptApplication.hpp>
#include <coin/IpTNLP.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "dynamics/assembly/closing.hpp"

namespace freeplay {
namespace {

/// Influences below this share of the greatest do not count in a direction.
constexpr double no_influence = 1e-14;
/// Relative changes of an output that count as rounding.
constexpr double rounding = 1e-14;

/// |A| B for a matrix B ≥ 0.
Eigen::MatrixXd magnitude_times(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  return A.cwiseAbs() * B;
}

/// Upper bound of Σ σ_k over shifts σ ≥ 0 of the components that make C + R negative semidefinite, R ≥ 0 being
/// the radius of an enclosure.
///
/// Rows that their diagonal dominates need none, and of the others it suffices to shift (weak rows w)
///
///     C_ww + R_ww + Σ_s N (|C_sw| + R_sw)²/m_s,   m_s: what dominates in row s,   N: number of weak rows,
///
/// because 2 x y ≤ N x²/m + m y²/N. Its greatest eigenvalue is bounded by that of the centre and row sums of R.
double shift(const Eigen::MatrixXd& C, const Eigen::MatrixXd& R,
             const std::vector<LooseComponent>& components) {
  const Eigen::MatrixXd size = C.cwiseAbs() + R;
  const auto excess = [&](int i, const std::vector<int>& rows) {
    double sum = C(i, i) + R(i, i);
    for (const int j : rows)
      if (j != i) sum += size(i, j);
    return sum;
  };
  std::vector<int> all(static_cast<std::size_t>(C.rows())), weak, strong;
  std::iota(all.begin(), all.end(), 0);
  double by_discs = 0;
  int shifted = 0;
  for (const auto& component : components) {
    double most = 0;
    for (int i = component.first; i < component.first + component.size(); ++i)
      most = std::max(most, excess(i, all));
    by_discs += most;
    shifted += most > 0;
    for (int i = component.first; i < component.first + component.size(); ++i)
      (most > 0 ? weak : strong).push_back(i);
  }
  if (weak.empty()) return 0;
  const auto count = static_cast<Eigen::Index>(weak.size());
  Eigen::MatrixXd centre(count, count);
  double radius = 0;
  for (Eigen::Index a = 0; a < count; ++a) {
    const int i = weak[static_cast<std::size_t>(a)];
    double row = 0;
    for (Eigen::Index b = 0; b < count; ++b) {
      const int j = weak[static_cast<std::size_t>(b)];
      centre(a, b) = C(i, j);
      row += R(i, j);
    }
    radius = std::max(radius, row);
    for (const int j : strong) {
      const double margin = -excess(j, strong);  // positive: row j dominates in all columns
      centre(a, a) += static_cast<double>(count) * size(i, j) * size(i, j) / margin;
    }
  }
  const double by_eigenvalue = std::max(0.0, symmetric_eigen(centre).values.maxCoeff() + radius);
  return std::min(by_discs, by_eigenvalue * shifted);
}

}  // namespace

Eigen::MatrixXd PlayExtremes::inverse() const {
  const int n = mechanism_.n();
  Eigen::MatrixXd A(n, n);
  Eigen::VectorXd column(n);
  for (int i = 0; i < n; ++i) {
    factors_.solve(Eigen::VectorXd::Unit(n, i), column);
    A.col(i) = column;
  }
  return A;
}

double PlayExtremes::spread(const Eigen::RowVectorXd& row, const Eigen::RowVectorXd& radius,
                            const Eigen::MatrixXd& A, const Eigen::VectorXd& eta) const {
  const Eigen::RowVectorXd along = row * region_.slope, around = radius * region_.slope.cwiseAbs();
  double sum = (row * A).cwiseAbs().dot(eta.transpose()) + (radius * A.cwiseAbs()).dot(eta.transpose());
  for (const auto& c : mechanism_.components())
    sum += along.segment(c.first, c.size()).norm() + around.segment(c.first, c.size()).norm();
  return sum;
}

const PlayRegion& PlayExtremes::enclose(const Eigen::VectorXd& q, double t) {
  const int n = mechanism_.n(), m = mechanism_.size();
  const auto& components = mechanism_.components();
  const auto count = static_cast<Eigen::Index>(components.size());
  region_ = {};
  region_.t = t, region_.q = q;
  if (!mechanism_.close(Eigen::VectorXd::Zero(m), t, region_.q, f_, factors_)) {
    region_.refusal = "the ideal mechanism does not close here, or is at a dead centre";
    return region_;
  }
  const Eigen::MatrixXd A = inverse();
  region_.slope = -(A * f_.by_u);
  region_.width.setZero(count), region_.width_change.setZero(count);
  // s, and rounding
  Eigen::VectorXd first = 4e-16 * (region_.q.cwiseAbs().array() + mechanism_.length()).matrix();
  for (const auto& c : components)
    for (int i = 0; i < n; ++i) first[i] += region_.slope.row(i).segment(c.first, c.size()).norm();
  Eigen::VectorXd eta = Eigen::VectorXd::Constant(n, 4e-16 * mechanism_.length()), needed(n);
  for (const auto& c : components) eta.segment(c.row, c.size()).array() += 0.02 * c.clearance;
  constexpr int most = 25;
  for (int i = 0; i < most; ++i) {
    region_.beyond = magnitude_times(A, eta);
    region_.radius = first + region_.beyond;
    if (!mechanism_.enclose(region_, t, box_)) break;
    const Eigen::MatrixXd change = f_.by_q - box_.by_q;
    for (int row = 0; row < n; ++row)
      needed[row] = spread(change.row(row), box_.by_q_radius.row(row), A, eta);
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto& c = components[static_cast<std::size_t>(k)];
      if (c.disc) continue;
      region_.width[k] = -f_.by_u(c.row, c.first);
      region_.width_change[k] = spread(box_.width_by_q.row(k), box_.width_by_q_radius.row(k), A, eta);
      needed[c.row] += region_.width_change[k];
    }
    if ((needed.array() <= eta.array()).all()) {
      for (Eigen::Index k = 0; k < count; ++k)
        if (const auto& c = components[static_cast<std::size_t>(k)];
            !c.disc && region_.width_change[k] >= region_.width[k])
          region_.refusal = c.joint +
                            " may close on both sides at once within the other clearances and then "
                            "limits them, which is not described";
      return region_;
    }
    eta = (1.05 * needed).cwiseMax(eta);
    if (!eta.allFinite() || (region_.beyond.array() > 20 * first.array()).all()) break;
  }
  region_.refusal = no_bound;
  return region_;
}

double PlayExtremes::ideal(int k, Eigen::VectorXd& a) {
  double value = 0;
  Eigen::VectorXd q = region_.q;
  if (!at(k, 1, Eigen::VectorXd::Zero(mechanism_.size()), q, value, a)) a.setZero(mechanism_.size());
  return value;
}

bool PlayExtremes::at(int k, double sign, const Eigen::VectorXd& u, Eigen::VectorXd& q, double& value,
                      Eigen::VectorXd& a) {
  if (!mechanism_.close(u, region_.t, q, f_, factors_)) return false;
  value = sign * mechanism_.output(k, gradient_);
  gradient_ *= sign;
  // F_qᵀ λ = ∇y
  DenseLu transposed;
  transposed.compute(f_.by_q.transpose());
  transposed.solve(gradient_, lambda_);
  a = -(f_.by_u.transpose() * lambda_);
  return true;
}

void PlayExtremes::vertex(const Eigen::VectorXd& a, Eigen::VectorXd& u) const {
  const double least = no_influence * a.cwiseAbs().maxCoeff();
  for (const auto& c : mechanism_.components()) {
    const double size = a.segment(c.first, c.size()).norm();
    if (size > least) u.segment(c.first, c.size()) = a.segment(c.first, c.size()) / size;
  }
}

void PlayExtremes::ascend(int k, double sign, PlayExtreme& x) {
  constexpr int most = 25;
  Eigen::VectorXd u = x.u, q = x.q, a;
  double value = 0;
  x.settled = false;
  x.value = -INFINITY;
  double last = INFINITY;
  for (int i = 0; i < most; ++i) {
    if (!at(k, sign, u, q, value, a)) return;
    // A later iterate counts as better within rounding: its direction is more accurate.
    if (!(value < x.value - rounding * std::abs(value))) x.value = value, x.u = u, x.q = q, x.a = a;
    Eigen::VectorXd next = u;
    vertex(a, next);
    const double change = (next - u).cwiseAbs().maxCoeff();
    if (change < 1e-13 || (change < 1e-9 && change >= last)) {
      x.settled = true;
      return;
    }
    if (i > 6 && change > 0.5 * last) return;
    last = change;
    u = next;
  }
}

double PlayExtremes::excess(int k, double sign, const PlayExtreme& x) {
  const int n = mechanism_.n(), m = mechanism_.size();
  // lambda_ belongs to x; p(q*) − y(q*) = −λᵀF is rounding.
  double more = std::abs(lambda_.dot(f_.F));
  Eigen::VectorXd alpha = Eigen::VectorXd::Zero(m);
  for (const auto& c : mechanism_.components()) {
    const auto u = x.u.segment(c.first, c.size()), a = x.a.segment(c.first, c.size());
    const double along = a.dot(u) / std::max(u.squaredNorm(), 1e-300), full = std::abs(u.norm() - 1);
    if (full > 1e-12 || along < 0) {
      more += 2 * a.norm();
      continue;
    }
    alpha.segment(c.first, c.size()).setConstant(along);
    more += 2 * (a - along * u).norm();
  }
  // δq = S δu: (v_q − u* w_q) δq = (c or w) δu over the box; |A B − I| ≤ N gives |δq − S₀ δu| ≤ T |δu| with
  // T = |A| rad + N (|S₀| + T), a series in N.
  Eigen::MatrixXd by_q = box_.by_q, by_q_radius = box_.by_q_radius, by_u = f_.by_u;
  Eigen::MatrixXd by_u_radius = Eigen::MatrixXd::Zero(n, m);
  for (std::size_t i = 0; i < mechanism_.components().size(); ++i) {
    const auto& c = mechanism_.components()[i];
    const auto row = static_cast<Eigen::Index>(i);
    if (c.disc) continue;
    by_q.row(c.row) -= x.u[c.first] * box_.width_by_q.row(row);
    by_q_radius.row(c.row) += std::abs(x.u[c.first]) * box_.width_by_q_radius.row(row);
    by_u(c.row, c.first) = -region_.width[row];
    by_u_radius(c.row, c.first) = region_.width_change[row];
  }
  const Eigen::MatrixXd A = inverse(), S = -(A * by_u);
  const Eigen::MatrixXd N =
      (Eigen::MatrixXd::Identity(n, n) - A * by_q).cwiseAbs() + magnitude_times(A, by_q_radius);
  Eigen::MatrixXd power = magnitude_times(A, by_u_radius) + N * S.cwiseAbs(), T = power;
  constexpr int terms = 60;
  for (int i = 0; i < terms && power.maxCoeff() > 1e-17 * T.maxCoeff(); ++i) {
    power = N * power;
    T += power;
  }
  if (power.maxCoeff() > 1e-10 * T.maxCoeff()) return INFINITY;
  T *= 1 + 1e-9;
  mechanism_.enclose_second(k, sign, lambda_, x.u, second_, second_radius_);
  const Eigen::MatrixXd P = second_.topLeftCorner(n, n), P_radius = second_radius_.topLeftCorner(n, n);
  const Eigen::MatrixXd X = second_.topRightCorner(n, m), X_radius = second_radius_.topRightCorner(n, m);
  Eigen::MatrixXd C = S.transpose() * P * S + S.transpose() * X + X.transpose() * S;
  const Eigen::MatrixXd size = S.cwiseAbs() + T, P_size = P.cwiseAbs() + P_radius,
                        X_size = X.cwiseAbs() + X_radius;
  const Eigen::MatrixXd error = T.transpose() * P_size * size;
  const Eigen::MatrixXd cross = T.transpose() * X_size + S.cwiseAbs().transpose() * X_radius;
  Eigen::MatrixXd R = S.cwiseAbs().transpose() * P_radius * S.cwiseAbs() + error + error.transpose() + cross +
                      cross.transpose();
  C = 0.5 * (C + C.transpose()).eval();
  R = 0.5 * (R + R.transpose()).eval();
  C.diagonal() -= alpha;
  more += 2 * shift(C, R, mechanism_.components());
  // Rounding of y and of its terms.
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  return more + 4 * epsilon * std::abs(x.value);
}

/// max h(u) subject to |u_k|² ≤ 1, with closure at each u.
class PlayExtremes::Maximum : public Ipopt::TNLP {
 public:
  using Index = Ipopt::Index;
  using Number = Ipopt::Number;

  Maximum(PlayExtremes& play, int k, double sign, PlayExtreme& x, double scale)
      : play_(play), k_(k), sign_(sign), x_(x), scale_(scale) {
    for (const auto& c : play.mechanism_.components())
      if (c.disc) discs_.push_back(c.first);
  }
  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override {
    n = play_.mechanism_.size();
    m = static_cast<Index>(discs_.size());
    jacobian = 2 * m;
    hessian = n * (n + 1) / 2;
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(Index n, Number* lower, Number* upper, Index m, Number* least, Number* most) override {
    std::fill(lower, lower + n, -1), std::fill(upper, upper + n, 1);
    std::fill(least, least + m, -1e19), std::fill(most, most + m, 1);
    return true;
  }
  bool get_starting_point(Index n, bool, Number* u, bool, Number*, Number*, Index, bool, Number*) override {
    for (Index i = 0; i < n; ++i) u[i] = 0.98 * x_.u[i];
    return true;
  }
  bool eval_f(Index n, const Number* u, bool, Number& value) override {
    if (!evaluate(n, u)) return false;
    value = -value_ / scale_;
    return true;
  }
  bool eval_grad_f(Index n, const Number* u, bool, Number* gradient) override {
    if (!evaluate(n, u)) return false;
    for (Index i = 0; i < n; ++i) gradient[i] = -a_[i] / scale_;
    return true;
  }
  bool eval_g(Index, const Number* u, bool, Index, Number* g) override {
    for (const int d : discs_) *g++ = u[d] * u[d] + u[d + 1] * u[d + 1];
    return true;
  }
  bool eval_jac_g(Index, const Number* u, bool, Index, Index, Index* row, Index* column,
                  Number* values) override {
    for (std::size_t i = 0; i < discs_.size(); ++i)
      for (const int c : {discs_[i], discs_[i] + 1})
        if (values)
          *values++ = 2 * u[c];
        else
          *row++ = static_cast<Index>(i), *column++ = c;
    return true;
  }
  bool eval_h(Index n, const Number* u, bool, Number factor, Index, const Number* lambda, bool, Index,
              Index* row, Index* column, Number* values) override {
    if (!values) {
      for (Index i = 0; i < n; ++i)
        for (Index c = 0; c <= i; ++c) *row++ = i, *column++ = c;
      return true;
    }
    if (!evaluate(n, u)) return false;
    Eigen::MatrixXd H = (-factor / scale_) * play_.second_by_u(k_, sign_, u_);
    for (std::size_t i = 0; i < discs_.size(); ++i)
      for (const int c : {discs_[i], discs_[i] + 1}) H(c, c) += 2 * lambda[i];
    for (Index i = 0; i < n; ++i)
      for (Index c = 0; c <= i; ++c) *values++ = H(i, c);
    return true;
  }
  void finalize_solution(Ipopt::SolverReturn status, Index n, const Number* u, const Number*, const Number*,
                         Index, const Number*, const Number*, Number, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    x_.settled = status == Ipopt::SUCCESS || status == Ipopt::STOP_AT_ACCEPTABLE_POINT;
    x_.u = Eigen::Map<const Eigen::VectorXd>(u, n);
    // The barrier leaves a small distance from the bounds.
    constexpr double near = 1e-6;
    for (const auto& c : play_.mechanism_.components()) {
      auto part = x_.u.segment(c.first, c.size());
      if (part.norm() > 1 - near) part.normalize();
    }
  }

 private:
  bool evaluate(Index n, const Number* u) {
    if (u_.size() == n && std::equal(u, u + n, u_.data())) return closed_;
    u_ = Eigen::Map<const Eigen::VectorXd>(u, n);
    Eigen::VectorXd q = play_.region_.q + play_.region_.slope * u_;
    return closed_ = play_.at(k_, sign_, u_, q, value_, a_);
  }

  PlayExtremes& play_;
  int k_;
  double sign_;
  PlayExtreme& x_;
  double scale_, value_ = 0;
  std::vector<int> discs_;
  Eigen::VectorXd u_, a_;
  bool closed_ = false;
};

Eigen::MatrixXd PlayExtremes::second_by_u(int k, double sign, const Eigen::VectorXd& u) {
  const int n = mechanism_.n(), m = mechanism_.size();
  Eigen::MatrixXd S(n, m), H;
  Eigen::VectorXd column(n);
  for (int i = 0; i < m; ++i) {
    factors_.solve(f_.by_u.col(i), column);
    S.col(i) = -column;
  }
  mechanism_.second(k, sign, lambda_, u, H);
  const Eigen::MatrixXd cross = S.transpose() * H.topRightCorner(n, m);
  return S.transpose() * H.topLeftCorner(n, n) * S + cross + cross.transpose();
}

void PlayExtremes::search(int k, double sign, PlayExtreme& best) {
  const auto lock = ipopt_lock();
  std::minstd_rand random(1);  // the same starts in each search
  std::uniform_real_distribution<double> share(-1, 1);
  constexpr int starts = 6;
  double value = 0;
  if (!at(k, sign, best.u, best.q, value, best.a)) return;
  const double scale = best.a.lpNorm<1>() + second_by_u(k, sign, best.u).cwiseAbs().sum();
  if (!(scale > 0)) return;
  for (int s = 0; s < starts; ++s) {
    PlayExtreme x = best;
    if (s > 0)
      for (const auto& c : mechanism_.components()) {
        auto part = x.u.segment(c.first, c.size());
        for (int i = 0; i < c.size(); ++i) part[i] = share(random);
        part.normalize();
      }
    Ipopt::SmartPtr<Ipopt::TNLP> problem = new Maximum(*this, k, sign, x, scale);
    Ipopt::SmartPtr<Ipopt::IpoptApplication> ipopt = IpoptApplicationFactory();
    ipopt->Options()->SetIntegerValue("print_level", 0);
    ipopt->Options()->SetStringValue("sb", "yes");
    ipopt->Options()->SetNumericValue("tol", 1e-11);
    ipopt->Options()->SetIntegerValue("max_iter", 100);
    ipopt->Options()->SetStringValue("mu_strategy", "adaptive");
    if (ipopt->Initialize("") != Ipopt::Solve_Succeeded) return;
    ipopt->OptimizeTNLP(problem);
    x.q = region_.q + region_.slope * x.u;
    if (!at(k, sign, x.u, x.q, value, x.a)) continue;
    x.value = value;
    // A better value, or the same one at a place that the search has confirmed.
    const double same = 1e-12 * scale;
    if (x.value > best.value + same || (x.settled && !best.settled && x.value > best.value - same)) best = x;
  }
}

std::optional<double> PlayExtremes::value(int k, const Eigen::VectorXd& u) {
  Eigen::VectorXd q = region_.q + region_.slope * u;
  if (!mechanism_.close(u, region_.t, q, f_, factors_)) return {};
  return mechanism_.output(k, gradient_);
}

void PlayExtremes::bound(int k, double sign, PlayExtreme& x) {
  double value = 0;
  at(k, sign, x.u, x.q, value, x.a);  // sets λ and F
  x.value = value;
  x.bound = x.value + excess(k, sign, x);
}

PlayExtreme PlayExtremes::greatest(int k, double sign, const Eigen::VectorXd& start) {
  PlayExtreme x;
  x.u = start.size() == mechanism_.size() ? start : Eigen::VectorXd::Zero(mechanism_.size());
  x.q = region_.q + region_.slope * x.u;
  ascend(k, sign, x);
  bound(k, sign, x);
  // What the bound confirms needs no further search.
  constexpr double confirmed = 1e-10;
  if (x.settled && x.bound - x.value <= confirmed * x.a.lpNorm<1>()) return x;
  search(k, sign, x);
  bound(k, sign, x);
  return x;
}

}  // namespace freeplay
