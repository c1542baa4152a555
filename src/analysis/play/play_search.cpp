#include "analysis/play/play_search.hpp"

#include <coin/IpIpoptApplication.hpp>
#include <coin/IpTNLP.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "dynamics/assembly/closing.hpp"

namespace freeplay {
namespace {

/// Influences below this share of the greatest do not count in a direction.
constexpr double no_influence = 1e-14;
/// Relative changes of an output that count as rounding.
constexpr double rounding = 1e-14;

/// Sets u to the point of U at which a·u is greatest; entries without influence keep their values.
void go_to_vertex(const LooseMechanism& mechanism, const Eigen::VectorXd& a, Eigen::VectorXd& u) {
  const double least = no_influence * a.cwiseAbs().maxCoeff();
  for (const auto& c : mechanism.components()) {
    const double size = a.segment(c.first, c.size()).norm();
    if (size > least) u.segment(c.first, c.size()) = a.segment(c.first, c.size()) / size;
  }
}

/// max h(u) subject to |u_k|² ≤ 1, with closure at each u.
class Maximum : public Ipopt::TNLP {
 public:
  using Index = Ipopt::Index;
  using Number = Ipopt::Number;

  Maximum(PlayOutput& h, PlayExtreme& x, double scale) : h_(h), x_(x), scale_(scale) {
    for (const auto& c : h.mechanism.components())
      if (c.disc) discs_.push_back(c.first);
  }
  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override {
    n = h_.mechanism.size();
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
    value = -h_.value / scale_;
    return true;
  }
  bool eval_grad_f(Index n, const Number* u, bool, Number* gradient) override {
    if (!evaluate(n, u)) return false;
    for (Index i = 0; i < n; ++i) gradient[i] = -h_.a[i] / scale_;
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
    Eigen::MatrixXd H = (-factor / scale_) * h_.second(u_);
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
    for (const auto& c : h_.mechanism.components()) {
      auto part = x_.u.segment(c.first, c.size());
      if (part.norm() > 1 - near) part.normalize();
    }
  }

 private:
  bool evaluate(Index n, const Number* u) {
    if (u_.size() == n && std::equal(u, u + n, u_.data())) return closed_;
    u_ = Eigen::Map<const Eigen::VectorXd>(u, n);
    return closed_ = h_.evaluate(u_);
  }

  PlayOutput& h_;
  PlayExtreme& x_;
  double scale_;
  std::vector<int> discs_;
  Eigen::VectorXd u_;
  bool closed_ = false;
};

}  // namespace

void ascend(PlayOutput& h, PlayExtreme& x) {
  constexpr int most = 25;
  Eigen::VectorXd u = x.u, q = x.q;
  x.settled = false;
  x.value = -INFINITY;
  double last = INFINITY;
  for (int i = 0; i < most; ++i) {
    if (!h.evaluate(u, q)) return;
    // A later iterate counts as better within rounding: its direction is more accurate.
    if (!(h.value < x.value - rounding * std::abs(h.value))) x.value = h.value, x.u = u, x.q = q, x.a = h.a;
    Eigen::VectorXd next = u;
    go_to_vertex(h.mechanism, h.a, next);
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

void search_from_starts(PlayOutput& h, PlayExtreme& best) {
  const auto lock = ipopt_lock();
  std::minstd_rand random(1);  // the same starts in each search
  std::uniform_real_distribution<double> share(-1, 1);
  constexpr int starts = 6;
  if (!h.evaluate(best.u, best.q)) return;
  best.a = h.a;
  const double scale = best.a.lpNorm<1>() + h.second(best.u).cwiseAbs().sum();
  if (!(scale > 0)) return;
  for (int s = 0; s < starts; ++s) {
    PlayExtreme x = best;
    if (s > 0)
      for (const auto& c : h.mechanism.components()) {
        auto part = x.u.segment(c.first, c.size());
        for (int i = 0; i < c.size(); ++i) part[i] = share(random);
        part.normalize();
      }
    Ipopt::SmartPtr<Ipopt::TNLP> problem = new Maximum(h, x, scale);
    Ipopt::SmartPtr<Ipopt::IpoptApplication> ipopt = IpoptApplicationFactory();
    ipopt->Options()->SetIntegerValue("print_level", 0);
    ipopt->Options()->SetStringValue("sb", "yes");
    ipopt->Options()->SetNumericValue("tol", 1e-11);
    ipopt->Options()->SetIntegerValue("max_iter", 100);
    ipopt->Options()->SetStringValue("mu_strategy", "adaptive");
    if (ipopt->Initialize("") != Ipopt::Solve_Succeeded) return;
    ipopt->OptimizeTNLP(problem);
    x.q = h.region.q + h.region.slope * x.u;
    if (!h.evaluate(x.u, x.q)) continue;
    x.value = h.value, x.a = h.a;
    // A better value, or the same one at a place that the search has confirmed.
    const double same = 1e-12 * scale;
    if (x.value > best.value + same || (x.settled && !best.settled && x.value > best.value - same)) best = x;
  }
}

}  // namespace freeplay
