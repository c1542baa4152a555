#include "analysis/play/play_allocation.hpp"

#include <fmt/format.h>
#include <coin/IpIpoptApplication.hpp>
#include <coin/IpTNLP.hpp>

#include <algorithm>
#include <cmath>

#include "dynamics/assembly/closing.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

/// The clearance of a joint: radius of a journal's disc, half of the play of a slot or a guide, backlash. Null for
/// an ideal joint.
double* clearance_of(Joint& joint) {
  return std::visit(
      [](auto& j) -> double* {
        if constexpr (requires { j.clearance->radial; }) return j.clearance ? &j.clearance->radial : nullptr;
        if constexpr (requires { j.clearance->half_play; })
          return j.clearance ? &j.clearance->half_play : nullptr;
        if constexpr (requires { j.clearance->play; }) return j.clearance ? &j.clearance->play : nullptr;
        if constexpr (requires { j.clearance->normal; }) return j.clearance ? &j.clearance->normal : nullptr;
        return nullptr;
      },
      joint);
}

/// The convex problem with fixed parts, in the logarithms of x.
class LeastCost : public Ipopt::TNLP {
 public:
  using Index = Ipopt::Index;
  using Number = Ipopt::Number;

  LeastCost(const std::vector<ClearanceCost>& costs, const std::vector<double>& low,
            const std::vector<double>& high, const Eigen::MatrixXd& parts, const Eigen::VectorXd& room,
            std::vector<double>& x)
      : costs_(costs), low_(low), high_(high), parts_(parts), room_(room), x_(x) {}

  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override {
    n = static_cast<Index>(costs_.size()), m = static_cast<Index>(parts_.rows());
    jacobian = n * m, hessian = n;
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(Index n, Number* lower, Number* upper, Index m, Number* least, Number* most) override {
    for (Index k = 0; k < n; ++k) lower[k] = std::log(low_[at(k)]), upper[k] = std::log(high_[at(k)]);
    for (Index i = 0; i < m; ++i) least[i] = -1e19, most[i] = room_[i];
    return true;
  }
  bool get_starting_point(Index n, bool, Number* z, bool, Number*, Number*, Index, bool, Number*) override {
    for (Index k = 0; k < n; ++k) z[k] = std::log(x_[at(k)]);
    return true;
  }
  bool eval_f(Index n, const Number* z, bool, Number& value) override {
    value = 0;
    for (Index k = 0; k < n; ++k) value += cost(k, z);
    return true;
  }
  bool eval_grad_f(Index n, const Number* z, bool, Number* gradient) override {
    for (Index k = 0; k < n; ++k) gradient[k] = -costs_[at(k)].exponent * cost(k, z);
    return true;
  }
  bool eval_g(Index n, const Number* z, bool, Index m, Number* g) override {
    for (Index i = 0; i < m; ++i) {
      g[i] = 0;
      for (Index k = 0; k < n; ++k) g[i] += parts_(i, k) * std::exp(z[k]);
    }
    return true;
  }
  bool eval_jac_g(Index n, const Number* z, bool, Index m, Index, Index* row, Index* column,
                  Number* values) override {
    for (Index i = 0; i < m; ++i)
      for (Index k = 0; k < n; ++k)
        if (values)
          *values++ = parts_(i, k) * std::exp(z[k]);
        else
          *row++ = i, *column++ = k;
    return true;
  }
  bool eval_h(Index n, const Number* z, bool, Number factor, Index m, const Number* lambda, bool, Index,
              Index* row, Index* column, Number* values) override {
    for (Index k = 0; k < n; ++k) {
      if (!values) {
        *row++ = k, *column++ = k;
        continue;
      }
      double sum = factor * costs_[at(k)].exponent * costs_[at(k)].exponent * cost(k, z);
      for (Index i = 0; i < m; ++i) sum += lambda[i] * parts_(i, k) * std::exp(z[k]);
      *values++ = sum;
    }
    return true;
  }
  void finalize_solution(Ipopt::SolverReturn status, Index n, const Number* z, const Number*, const Number*,
                         Index, const Number*, const Number*, Number, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    solved = status == Ipopt::SUCCESS || status == Ipopt::STOP_AT_ACCEPTABLE_POINT;
    for (Index k = 0; k < n; ++k) x_[at(k)] = std::exp(z[k]);
  }
  bool solved = false;

 private:
  static std::size_t at(Index i) { return static_cast<std::size_t>(i); }
  double cost(Index k, const Number* z) const {
    return costs_[at(k)].cost * std::exp(-costs_[at(k)].exponent * z[k]);
  }

  const std::vector<ClearanceCost>& costs_;
  const std::vector<double>&low_, &high_;
  const Eigen::MatrixXd& parts_;
  const Eigen::VectorXd& room_;
  std::vector<double>& x_;
};

/// One round: x with the parts per unit of x, and the room that the other joints leave.
bool solve_round(const std::vector<ClearanceCost>& costs, const std::vector<double>& low,
                 const std::vector<double>& high, const Eigen::MatrixXd& parts, const Eigen::VectorXd& room,
                 std::vector<double>& x) {
  const auto lock = ipopt_lock();
  auto* problem = new LeastCost(costs, low, high, parts, room, x);
  const Ipopt::SmartPtr<Ipopt::TNLP> owner = problem;
  const Ipopt::SmartPtr<Ipopt::IpoptApplication> ipopt = IpoptApplicationFactory();
  ipopt->Options()->SetIntegerValue("print_level", 0);
  ipopt->Options()->SetStringValue("sb", "yes");
  ipopt->Options()->SetNumericValue("tol", 1e-10);
  ipopt->Options()->SetNumericValue("bound_relax_factor", 0);
  if (ipopt->Initialize("") != Ipopt::Solve_Succeeded) return false;
  ipopt->OptimizeTNLP(owner);
  return problem->solved;
}

void refuse_wrong(double target, const std::vector<ClearanceCost>& costs) {
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  if (!positive(target)) throw ModelError("--target", "must be positive");
  if (costs.empty()) throw ModelError("--cost", "at least one joint is needed");
  for (auto it = costs.begin(); it != costs.end(); ++it) {
    if (!positive(it->cost) || !positive(it->exponent) || !positive(it->least) || !positive(it->greatest))
      throw ModelError("--cost", it->joint + ": cost, exponent, least and greatest must be positive");
    if (it->least > it->greatest)
      throw ModelError("--cost", it->joint + ": least must not exceed greatest (m)");
    if (std::ranges::find(costs.begin(), it, it->joint, &ClearanceCost::joint) != it)
      throw ModelError("--cost", it->joint + " is stated twice");
  }
}

}  // namespace

Allocation allocate_clearances(const Scene& scene, const PlayOptions& options, double target,
                               const std::vector<ClearanceCost>& costs) {
  if (options.quantities.size() != 1)
    throw ModelError("--target", "needs exactly one quantity (--of), whose width it limits");
  refuse_wrong(target, costs);
  Scene trial = scene;
  std::vector<double*> clearances;
  std::vector<double> before, low, high, x(costs.size(), 1.0);
  for (const auto& cost : costs) {
    const auto it = std::ranges::find_if(trial.mechanism.joints,
                                         [&](const Joint& j) { return name_of(j) == cost.joint; });
    double* clearance = it == trial.mechanism.joints.end() ? nullptr : clearance_of(*it);
    if (!clearance) throw ModelError("--cost", fmt::format("\"{}\" is no joint with clearance", cost.joint));
    clearances.push_back(clearance);
    before.push_back(*clearance);
    low.push_back(cost.least / before.back()), high.push_back(cost.greatest / before.back());
  }
  Allocation found;
  constexpr int most = 30;
  constexpr double same = 1e-10;  // relative change of clearances and of the width
  for (found.rounds = 1; found.rounds <= most; ++found.rounds) {
    found.play = find_play(trial, options);
    const auto& positions = found.play.positions;
    Eigen::MatrixXd parts = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(positions.size()),
                                                  static_cast<Eigen::Index>(costs.size()));
    Eigen::VectorXd room = Eigen::VectorXd::Constant(parts.rows(), target);
    double widest = 0;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      if (!positions[i].refusal.empty())
        throw ModelError(
            "--target", fmt::format("no range at {:.6g}: {}", positions[i].coordinate, positions[i].refusal));
      const auto& range = positions[i].ranges.front();
      widest = std::max(widest, range.width());
      for (std::size_t p = 0; p < range.parts.size(); ++p) {
        const auto k =
            std::ranges::find(costs, found.play.components[p].joint, &ClearanceCost::joint) - costs.begin();
        if (k < static_cast<std::ptrdiff_t>(costs.size()))
          parts(row, k) += range.parts[p] / x[static_cast<std::size_t>(k)];
        else
          room[row] -= range.parts[p];
      }
    }
    const auto last = x;
    const bool solved = solve_round(costs, low, high, parts / target, room / target, x);
    if (!solved)
      throw ModelError("--target",
                       fmt::format("{:.6g} {} cannot be met within the limits of the clearances; the width "
                                   "of the scene is {:.6g}",
                                   target, found.play.quantities.front().unit(), widest));
    double change = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
      change = std::max(change, std::abs(x[k] / last[k] - 1));
      *clearances[k] = before[k] * x[k];
    }
    if (change < same) break;
  }
  using Limit = AllocatedClearance::Limit;
  for (std::size_t k = 0; k < costs.size(); ++k) {
    constexpr double near = 1e-6;
    const Limit limit = x[k] < low[k] * (1 + near)    ? Limit::least
                        : x[k] > high[k] * (1 - near) ? Limit::greatest
                                                      : Limit::none;
    const double cost = costs[k].cost * std::pow(x[k], -costs[k].exponent);
    found.clearances.push_back({costs[k].joint, before[k], before[k] * x[k], cost, limit});
    found.cost_before += costs[k].cost, found.cost += cost;
  }
  return found;
}

}  // namespace freeplay
