#include "dynamics/assembly/closing.hpp"

#include <coin/IpIpoptApplication.hpp>
#include <coin/IpTNLP.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <utility>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/other_starts.hpp"
#include "dynamics/kinematics.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"

namespace freeplay {
namespace {

/// Whether the journal's centre is free within a circle, whose radius is the clearance.
bool is_circle(const ContactFacts& facts) { return facts.ring && !facts.out_of_round; }

/// Variables q; constraints: the chosen rows of Φ = 0, then |e_k|²/c_k² ≤ 1, or g_k ≥ 0 as 1 − g_k/c_k ≤ 1.
class Assembly : public Ipopt::TNLP {
 public:
  using Index = Ipopt::Index;
  using Number = Ipopt::Number;

  Assembly(const System& system, const std::vector<double>& start, const std::vector<int>& left_out,
           const Metric& metric, std::vector<double>& q, const StopToken& stop)
      : system_(system),
        start_(start),
        metric_(metric),
        q_(q),
        stop_(stop),
        e_(system.make_evaluation()),
        zero_(start.size(), 0.0) {
    for (int k = 0; k < system.rows(); ++k)
      if (!std::ranges::binary_search(left_out, k)) rows_.push_back(k);
    heaviest_ = *std::ranges::max_element(metric.weight);
    const auto& p = system.pattern();
    int g = 0;
    for (int k : rows_) {
      for (int i = p.begin[k]; i < p.begin[k + 1]; ++i) places_.emplace_back(g, p.column[i]);
      ++g;
    }
    for (int k = 0; k < system.contacts(); ++k, ++g)
      for (int body : system.contact_facts(k).bodies)
        if (body != ground)
          for (int c : {3 * body, 3 * body + 1, 3 * body + 2}) places_.emplace_back(g, c);
  }

  bool get_nlp_info(Index& n, Index& m, Index& nnz_jac, Index& nnz_hessian, IndexStyleEnum& style) override {
    n = system_.n();
    m = static_cast<Index>(rows_.size()) + system_.contacts();
    nnz_jac = static_cast<Index>(places_.size());
    nnz_hessian = 0;
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(Index n, Number* lower, Number* upper, Index m, Number* g_lower,
                       Number* g_upper) override {
    std::fill(lower, lower + n, -1e19);
    std::fill(upper, upper + n, 1e19);
    for (std::size_t c = 0; c < metric_.held.size(); ++c)
      if (metric_.held[c]) lower[c] = upper[c] = q_[c];
    const auto equalities = static_cast<Index>(rows_.size());
    for (Index k = 0; k < m; ++k) {
      g_lower[k] = k < equalities ? 0 : -1e19;
      g_upper[k] = k < equalities ? 0 : 1;
    }
    return true;
  }
  bool get_starting_point(Index n, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    std::copy(q_.begin(), q_.begin() + n, x);
    return true;
  }
  bool eval_f(Index n, const Number* x, bool, Number& value) override {
    value = 0;
    for (Index i = 0; i < n; ++i) value += 0.5 * weight(i) * (x[i] - at(start_, i)) * (x[i] - at(start_, i));
    return true;
  }
  bool eval_grad_f(Index n, const Number* x, bool, Number* gradient) override {
    for (Index i = 0; i < n; ++i) gradient[i] = weight(i) * (x[i] - at(start_, i));
    return true;
  }
  bool eval_g(Index, const Number* x, bool, Index, Number* g) override {
    system_.place(0, x, e_);
    for (int k : rows_) *g++ = at(e_.phi, k);
    for (int k = 0; k < system_.contacts(); ++k) {
      const auto& facts = system_.contact_facts(k);
      *g++ = is_circle(facts) ? system_.eccentricity(k, x, e_).squared_norm() / square(facts.clearance)
                              : 1 - system_.gap(k, x, e_) / facts.clearance;
    }
    return true;
  }
  bool eval_jac_g(Index, const Number* x, bool, Index, Index, Index* row, Index* column,
                  Number* values) override {
    if (!values) {
      for (auto [r, c] : places_) {
        *row++ = r;
        *column++ = c;
      }
      return true;
    }
    system_.place(0, x, e_);
    const auto& p = system_.pattern();
    for (int k : rows_)
      for (int i = p.begin[k]; i < p.begin[k + 1]; ++i) *values++ = at(e_.G, i);
    ContactRow contact;
    for (int k = 0; k < system_.contacts(); ++k) {
      // Rings: ∂|e|²/∂q = −2|e| W_N, which is smooth and zero where a concentric journal has no
      // normal.
      const auto& facts = system_.contact_facts(k);
      system_.contact(k, x, zero_.data(), e_, contact);
      const double factor = is_circle(facts) ? -2 * (facts.clearance - contact.gap) / square(facts.clearance)
                                             : -1 / facts.clearance;
      int i = 0;
      for (int body : facts.bodies)
        if (body != ground)
          for (int c = 0; c < 3; ++c, ++i)
            *values++ = contact.normal.size == 0 ? 0 : factor * contact.normal.value[i];
    }
    return true;
  }
  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* x, const Number*, const Number*, Index,
                         const Number*, const Number*, Number, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    q_.assign(x, x + n);
  }
  bool intermediate_callback(Ipopt::AlgorithmMode, Index, Number, Number, Number, Number, Number, Number,
                             Number, Number, Index, const Ipopt::IpoptData*,
                             Ipopt::IpoptCalculatedQuantities*) override {
    return !stop_();
  }

 private:
  static double square(double x) { return x * x; }
  static double at(const std::vector<double>& x, int i) { return x[i]; }
  double weight(int i) const { return at(metric_.weight, i) / heaviest_; }

  const System& system_;
  const std::vector<double>& start_;
  const Metric& metric_;
  std::vector<double>& q_;
  const StopToken& stop_;
  Evaluation e_;
  std::vector<double> zero_;
  std::vector<int> rows_;
  std::vector<std::pair<int, int>> places_;  // (constraint, column) of the Jacobian's entries
  double heaviest_ = 1;
};

/// Moves q to the solution of the program of assembly.hpp, without the rows `left_out` (ascending).
/// On failure q is Ipopt's last iterate, the point nearest to closure that it found. Polls `stop`
/// at each iteration and throws Interrupted if it is set.
void least_movement(const System& system, const std::vector<double>& start, const std::vector<int>& left_out,
                    const Metric& metric, std::vector<double>& q, const StopToken& stop) {
  const auto lock = ipopt_lock();
  Ipopt::SmartPtr<Ipopt::TNLP> problem = new Assembly(system, start, left_out, metric, q, stop);
  Ipopt::SmartPtr<Ipopt::IpoptApplication> ipopt = IpoptApplicationFactory();
  ipopt->Options()->SetIntegerValue("print_level", 0);
  ipopt->Options()->SetStringValue("sb", "yes");
  ipopt->Options()->SetStringValue("hessian_approximation", "limited-memory");
  ipopt->Options()->SetNumericValue("tol", 1e-10);
  ipopt->Options()->SetNumericValue("constr_viol_tol", 1e-11);
  ipopt->Options()->SetIntegerValue("max_iter", 500);
  ipopt->Options()->SetStringValue("fixed_variable_treatment", "make_parameter");
  if (ipopt->Initialize("") != Ipopt::Solve_Succeeded) return;
  ipopt->OptimizeTNLP(problem);
  if (stop()) throw Interrupted();
}

}  // namespace

std::unique_lock<std::mutex> ipopt_lock() {
  static std::mutex one_at_a_time;
  return std::unique_lock(one_at_a_time);
}

double length_scale(const System& system) {
  double scale = system.longest_arm();
  for (int k = 0; k < system.contacts(); ++k)
    scale = std::max(scale, system.contact_facts(k).ring ? system.contact_facts(k).radius_bearing : 0);
  return scale > 0 ? scale : 1;
}

Closing::Closing(const Mechanism& mechanism, const System& system, const StopToken& stop, Metric metric)
    : mechanism_(mechanism),
      system_(system),
      stop_(stop),
      metric_(std::move(metric)),
      length_(length_scale(system)),
      accepted_(1e-9 * length_) {}

double Closing::open(const std::vector<double>& q) const { return worst_open_joint(system_, q).amount; }

double Closing::worst(const std::vector<double>& q) const {
  const auto list = open_joints(system_, q, length_);
  return list.empty() ? 0 : (list.front().angular ? length_ : 1) * list.front().amount;
}

std::vector<int> Closing::left_out(const std::vector<double>& q) const {
  if (metric_.held.empty()) return redundant_rows(system_, q);
  auto e = system_.make_evaluation();
  system_.place(0, q.data(), e);
  MovableRows rows(system_, metric_);
  rows.choose(e.G);
  return rows.left_out();
}

void Closing::close_exactly(std::vector<double>& q) const {
  auto e = system_.make_evaluation();
  MovableRows rows(system_, metric_, metric_.held.empty() && !redundant_rows(system_, q).empty());
  std::vector<double> dq(q.size()), r(e.phi.size());
  for (int i = 0; i < 5; ++i) {
    system_.place(0, q.data(), e);
    if (i == 0) rows.choose(e.G);
    if (!rows.factor(e.G)) return;
    std::ranges::transform(e.phi, r.begin(), std::negate{});
    rows.solve(nullptr, r, dq);
    for (std::size_t c = 0; c < q.size(); ++c) q[c] += dq[c];
  }
}

/// Newton's method for the pose nearest to `rough`: dq = W⁻¹(−Gᵀλ) + (rough − q) onto Φ + G dq = 0.
/// Its limit has W(q − rough) + Gᵀλ = 0 and Φ = 0. The neglected term, the curvature of Φ times λ,
/// is small near closure. Each step must be at most half the previous one, and the first shorter
/// than a tenth of the length and of a radian (with held coordinates: of a radian). Otherwise it
/// stops and leaves q unchanged, because farther away another branch may be nearer. Returns true
/// with a pose that is closed to `accepted`.
bool Closing::approach(const std::vector<double>& rough, std::vector<double>& q) const {
  constexpr int most = 30;
  auto e = system_.make_evaluation();
  MovableRows rows(system_, metric_);
  const auto& weight = metric_.weight;
  const bool holds = !metric_.held.empty();
  const auto n = q.size();
  std::vector<double> pose = q, dq(n), r(e.phi.size()), f(n);
  double last = INFINITY;
  for (int i = 0; i < most; ++i) {
    system_.place(0, pose.data(), e);
    if (i == 0) rows.choose(e.G);
    if (!rows.factor(e.G) || rows.singular()) return false;
    std::ranges::transform(e.phi, r.begin(), std::negate{});
    for (std::size_t c = 0; c < n; ++c) f[c] = weight[c] * (rough[c] - pose[c]);
    rows.solve(f.data(), r, dq);
    double moved = 0, size = 0;
    for (std::size_t c = 0; c < n; ++c) {
      pose[c] += dq[c];
      const bool turns = static_cast<int>(c) % planar::coordinates == 2;
      if (i == 0 && !(std::abs(dq[c]) < (turns ? 0.1 : holds ? INFINITY : 0.1 * length_))) return false;
      moved += weight[c] * dq[c] * dq[c];
      size += weight[c] * pose[c] * pose[c];
    }
    if (!(moved < 0.25 * last)) {
      // Converged to rounding, or not converging.
      if (!(last <= 1e-28 * size)) return false;
      break;
    }
    last = moved;
    if (moved == 0) break;
  }
  if (!(open(pose) <= accepted_)) return false;
  q = pose;
  return true;
}

bool Closing::close(std::vector<double>& q, std::vector<double>& best) const {
  if (open(q) <= 1e-14 * length_) return true;
  const auto rough = q;
  if (move(rough, q)) return true;
  // Start from the better of two best poses: near the rough positions and near the last iterate.
  // If it is closed, try once more.
  best = rough;
  best_pose(system_, length_, true, best, 0, metric_.held);
  best_pose(system_, length_, true, q, 0, metric_.held);
  if (worst(q) <= worst(best)) best = q;
  q = best;
  return worst(best) < 1e-6 * length_ && move(rough, q);
}

bool Closing::close_from(std::vector<double>& q) const {
  best_pose(system_, length_, true, q, 0, metric_.held);
  if (!(worst(q) < 1e-6 * length_)) return false;
  const auto start = q;
  return open(q) <= 1e-14 * length_ || move(start, q);
}

void Closing::unwind_to(const std::vector<double>& given, std::vector<double>& q) const {
  const auto before = q;
  unwind(mechanism_, given, q);
  if (q != before) close_exactly(q);
}

/// Rows that are dependent at the rough positions may be independent at the assembled ones: they
/// are selected again once.
bool Closing::move(const std::vector<double>& rough, std::vector<double>& q) const {
  if (approach(rough, q)) return true;
  for (int attempt = 0; attempt < 2 && !(open(q) <= accepted_); ++attempt) {
    least_movement(system_, rough, left_out(q), metric_, q, stop_);
    // An interior-point method keeps a distance from inactive contacts, and light bodies have
    // little weight in its tolerance.
    if (approach(rough, q)) return true;
    if (open(q) < 1e-3 * length_) close_exactly(q);
  }
  return open(q) <= accepted_;
}

}  // namespace freeplay
