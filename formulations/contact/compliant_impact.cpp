// The law of tangential compliance, for any number of contacts that D couples. Each contact has a
// normal spring and a tangential spring of κ times its stiffness, with Coulomb friction in series.
// The configuration is constant during the impact, so the displacements x of the contacts satisfy
//
//     ẍ = D f(x),     f_N = k (δ − r),  δ = −x_N,     f_T = −κ (x_T − o)   in stick
//                                                    f_T = σ μ f_N        in slip
//
// with equal springs k = 1 in all contacts; the result does not depend on this scale. In expansion
// k is 1/e² and r = (1 − e²) δ_max: the spring returns e² of its work, so that e is energetic, and
// for a single frictionless contact also kinetic. A compression beyond δ_max continues on the first
// line. With e = 0 the contact is held in expansion: f_N takes the value that keeps u_N = 0, between
// 0 and its greatest value. For small e it oscillates about this value with a frequency that grows
// as 1/e; an e below 1e-3 is replaced by 0. Where friction drives the contact into compression
// (D_NN < μ |D_NT|), the rates for e below 0.03 are accurate to 1e-3 only.
//
// In each mode the equations are linear. They are solved by their Taylor series, whose remainder is
// below rounding at the step used, and the first change of mode within a step is located on it:
//
//     compression → expansion   u_N ≥ 0          stick → slip   σ f_T ≥ μ f_N
//     expansion → open          f_N ≤ 0          slip → stick   σ (u_T + σ μ (df_N/dt)/κ) ≥ 0
//
// For one contact and D_NT = 0 these are the two oscillators of quarter waves in normal and
// tangential direction. Friction opposes sliding and springs return at most their stored energy, so
// the impact does not add energy.
// Sources: N. Maw, J. R. Barber, J. N. Fawcett, J. Lubrication Technology 103 (1981) 74; W. J.
// Stronge, Impact Mechanics (2000), chapter 5 (springs with slip, unloading by k/e²).
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "formulations/contact/impact.hpp"
#include "formulations/integrators/crossing.hpp"
#include "numerics/dense.hpp"

namespace freeplay {
namespace {

/// A contact during the impact.
struct Springs {
  enum class Normal { compression, expansion, held, open } normal = Normal::compression;
  int slip = 0;  ///< σ of f_T = σ μ f_N; 0: stick
  double stiffness = 1, release = 0, deepest = 0, origin = 0;

  bool closed() const { return normal != Normal::open; }
};

class SpringImpact {
 public:
  SpringImpact(const ImpactIsland& island, const ImpactContacts& contacts)
      : contacts_(contacts),
        springs_(contacts.size()),
        rows_(island.problem.rows),
        D_(island.problem.D.topLeftCorner(rows_, rows_)),
        x_(Eigen::VectorXd::Zero(rows_)),
        u_(island.before.head(rows_)),
        impulse_(Eigen::VectorXd::Zero(rows_)),
        none_(1e-13 * u_.cwiseAbs().maxCoeff()) {
    series_.fill(Eigen::VectorXd::Zero(rows_));
    force_.fill(Eigen::VectorXd::Zero(rows_));
    for (std::size_t i = 0; i < springs_.size(); ++i) {
      if (!(u_n(i) < 0)) springs_[i].normal = Springs::Normal::open;  // it may close later
      begin_tangential(i);
    }
  }

  /// Integrates the impact until no contact can close again; returns false if it does not end.
  bool run() {
    const long most = 20'000 * static_cast<long>(springs_.size());
    for (long steps = 0; steps < most; ++steps) {
      const double step = next_step();
      if (step < 0) return true;
      if (!std::isfinite(step)) return false;
      expand();
      // A contact that leaves a mode and returns to it within a quarter of a step only grazes its end.
      Change first;
      for (int part = 0; part < 4 && !first.found(); ++part)
        first = first_change(0.25 * part * step, 0.25 * (part + 1) * step);
      advance(first.found() ? first.at : step);
      if (first.found()) change(first);
    }
    return false;
  }
  const Eigen::VectorXd& impulse() const { return impulse_; }
  const Eigen::VectorXd& after() const { return u_; }
  /// J, work of the normal springs, ≤ 0.
  double normal_work() const {
    double work = 0;
    for (std::size_t i = 0; i < springs_.size(); ++i) {
      const double e = restitution(i), deepest = springs_[i].deepest;
      work -= 0.5 * (1 - e * e) * deepest * deepest;
    }
    return work;
  }

 private:
  static constexpr int order = 16;
  enum class Kind { none, turn, deeper, open, close, slip_up, slip_down, stick };
  struct Change {
    Kind kind = Kind::none;
    std::size_t contact = 0;
    double at = 0;
    bool found() const { return kind != Kind::none; }
  };

  double u_n(std::size_t i) const { return u_[contacts_[i].normal]; }
  bool rough(std::size_t i) const { return contacts_[i].tangent >= 0 && contacts_[i].friction > 0; }
  double ratio(std::size_t i) const { return contacts_[i].stiffness_ratio; }
  /// e, or 0 where expansion would take too many steps.
  double restitution(std::size_t i) const {
    return contacts_[i].restitution < 1e-3 ? 0 : contacts_[i].restitution;
  }

  /// f of displacements x; `constant`: with the constant part of each spring's force.
  void forces(const Eigen::VectorXd& x, bool constant, Eigen::VectorXd& f) const {
    f.setZero();
    for (std::size_t i = 0; i < springs_.size(); ++i) {
      const auto& s = springs_[i];
      const auto& c = contacts_[i];
      if (!s.closed()) continue;
      if (s.normal != Springs::Normal::held)
        f[c.normal] = s.stiffness * (-x[c.normal] - (constant ? s.release : 0));
      if (!rough(i)) continue;
      f[c.tangent] = s.slip != 0 ? s.slip * c.friction * f[c.normal]
                                 : -ratio(i) * (x[c.tangent] - (constant ? s.origin : 0));
    }
    if (held_.empty()) return;
    Eigen::VectorXd rate(held_.size());
    for (std::size_t k = 0; k < held_.size(); ++k) rate[k] = -D_.row(contacts_[held_[k]].normal).dot(f);
    const Eigen::VectorXd holding = holding_->solve(rate);
    for (std::size_t k = 0; k < held_.size(); ++k) {
      const auto& c = contacts_[held_[k]];
      f[c.normal] += holding[k];
      if (rough(held_[k])) f[c.tangent] += springs_[held_[k]].slip * c.friction * holding[k];
    }
  }
  /// Finds held contacts, and the response of their rates to their forces, friction of slip
  /// included.
  void prepare_held() {
    held_.clear();
    for (std::size_t i = 0; i < springs_.size(); ++i)
      if (springs_[i].normal == Springs::Normal::held) held_.push_back(i);
    if (held_.empty()) return;
    Eigen::MatrixXd response(held_.size(), held_.size());
    for (std::size_t k = 0; k < held_.size(); ++k)
      for (std::size_t j = 0; j < held_.size(); ++j) {
        const auto& by = contacts_[held_[j]];
        const int row = contacts_[held_[k]].normal;
        response(k, j) = D_(row, by.normal);
        if (rough(held_[j])) response(k, j) += springs_[held_[j]].slip * by.friction * D_(row, by.tangent);
      }
    holding_.emplace(response);
  }
  /// Taylor coefficients of x and f from the present state.
  void expand() {
    prepare_held();
    series_[0] = x_;
    series_[1] = u_;
    for (int j = 0; j + 2 <= order; ++j) {
      forces(series_[j], j == 0, force_[j]);
      series_[j + 2].noalias() = D_ * force_[j] / ((j + 1.0) * (j + 2));
    }
  }
  using Series = std::span<const Eigen::VectorXd>;
  /// Value of a row's Taylor series at t, and its derivative.
  static double value_of(Series terms, int row, double t) {
    double sum = 0;
    for (std::size_t j = terms.size(); j-- > 0;) sum = sum * t + terms[j][row];
    return sum;
  }
  static double slope_of(Series terms, int row, double t) {
    double sum = 0;
    for (std::size_t j = terms.size(); j-- > 1;) sum = sum * t + static_cast<double>(j) * terms[j][row];
    return sum;
  }
  double displacement(int row, double t) const { return value_of(series_, row, t); }
  double velocity(int row, double t) const { return slope_of(series_, row, t); }
  /// A step in which the series has converged, or the free flight to the next contact; −1: the
  /// impact has ended.
  double next_step() {
    double bound = 0;
    bool any = false;
    for (std::size_t i = 0; i < springs_.size(); ++i) {
      const auto& s = springs_[i];
      if (!s.closed()) continue;
      any = true;
      const double stiffest = std::max(s.stiffness, ratio(i));
      bound += stiffest * D_.col(contacts_[i].normal).cwiseAbs().maxCoeff() * (1 + contacts_[i].friction);
      if (rough(i)) bound += (stiffest + ratio(i)) * D_.col(contacts_[i].tangent).cwiseAbs().maxCoeff();
    }
    if (any) return bound > 0 ? 0.5 / std::sqrt(bound) : INFINITY;
    double flight = INFINITY;
    for (std::size_t i = 0; i < springs_.size(); ++i)
      if (u_n(i) < -none_)
        flight = std::min(flight, std::max(0.0, x_[contacts_[i].normal] + springs_[i].release) / -u_n(i));
    if (!std::isfinite(flight)) return -1;
    return 1.5 * flight + 1e-3 * x_.cwiseAbs().maxCoeff() / u_.cwiseAbs().maxCoeff();
  }
  /// f_N of a closed contact at t, and its derivative.
  double normal_force(std::size_t i, double t) const {
    const auto& s = springs_[i];
    const int row = contacts_[i].normal;
    if (s.normal == Springs::Normal::held) return value_of(force_, row, t);
    return s.stiffness * (-displacement(row, t) - s.release);
  }
  double force_rate(std::size_t i, double t) const {
    const auto& s = springs_[i];
    const int row = contacts_[i].normal;
    return s.normal == Springs::Normal::held ? slope_of(force_, row, t) : -s.stiffness * velocity(row, t);
  }

  /// The value of a change of contact i at t, which is positive once it has occurred.
  double value(Kind kind, std::size_t i, double t) const {
    const auto& s = springs_[i];
    const auto& c = contacts_[i];
    const bool held = s.normal == Springs::Normal::held;
    const auto beyond_bound = [&](int side) {
      return -side * ratio(i) * (displacement(c.tangent, t) - s.origin) - c.friction * normal_force(i, t);
    };
    switch (kind) {
      case Kind::turn:
        return velocity(c.normal, t);
      case Kind::deeper:
        return held ? normal_force(i, t) - s.deepest : -displacement(c.normal, t) - s.deepest;
      case Kind::open:
        return (held ? 1e-12 * s.deepest : 0) - normal_force(i, t);
      case Kind::close:
        return -displacement(c.normal, t) - s.release;
      case Kind::slip_up:
        return beyond_bound(1);
      case Kind::slip_down:
        return beyond_bound(-1);
      case Kind::stick:
        return s.slip * velocity(c.tangent, t) + c.friction * force_rate(i, t) / ratio(i);
      default:
        return -1;
    }
  }
  Change first_change(double from, double to) const {
    Change first;
    const auto look = [&](Kind kind, std::size_t i) {
      const double end = value(kind, i, to);
      if (!(end > 0)) return;
      double begin = from, start = value(kind, i, from);
      // A mode that has just begun at its own end, up to rounding, lasts if the value falls first.
      for (int k = 1; start >= 0 && k < 30; ++k) {
        begin = from + std::ldexp(to - from, -k);
        start = value(kind, i, begin);
      }
      const double at =
          start >= 0 ? from
                     : bracketed_root([&](double t) { return value(kind, i, t); }, begin, to, start, end);
      if (!first.found() || at < first.at) first = {kind, i, at};
    };
    for (std::size_t i = 0; i < springs_.size(); ++i) {
      const auto& s = springs_[i];
      if (!s.closed()) {
        look(Kind::close, i);
        continue;
      }
      const bool elastic = restitution(i) == 1;
      if (s.normal == Springs::Normal::compression && !elastic) look(Kind::turn, i);
      if (s.normal == Springs::Normal::compression && elastic) look(Kind::open, i);
      if (s.normal == Springs::Normal::expansion || s.normal == Springs::Normal::held)
        look(Kind::open, i), look(Kind::deeper, i);
      if (rough(i) && s.slip != 0) look(Kind::stick, i);
      if (rough(i) && s.slip == 0) look(Kind::slip_up, i), look(Kind::slip_down, i);
    }
    return first;
  }
  void advance(double t) {
    for (int r = 0; r < rows_; ++r) {
      double sum = 0;
      for (int j = order - 2; j >= 0; --j) sum = sum * t + force_[j][r] / (j + 1);
      impulse_[r] += sum * t;
      x_[r] = displacement(r, t);
      u_[r] = velocity(r, t);
    }
  }

  /// Stick or slip of an undeformed tangential spring at contact onset.
  void begin_tangential(std::size_t i) {
    if (!rough(i)) return;
    const double u_t = u_[contacts_[i].tangent];
    springs_[i].origin = x_[contacts_[i].tangent];
    springs_[i].slip =
        ratio(i) * std::abs(u_t) <= contacts_[i].friction * springs_[i].stiffness * std::max(0.0, -u_n(i))
            ? 0
            : (u_t < 0 ? 1 : -1);
    if (std::abs(u_t) <= none_) springs_[i].slip = 0;
  }
  void change(const Change& by) {
    auto& s = springs_[by.contact];
    const auto& c = contacts_[by.contact];
    const double delta = -x_[c.normal], e = restitution(by.contact);
    switch (by.kind) {
      case Kind::turn:
        s.deepest = std::max(0.0, delta);
        s.release = (1 - e * e) * s.deepest;
        s.normal = e > 0 ? Springs::Normal::expansion : Springs::Normal::held;
        if (e > 0) s.stiffness = 1 / (e * e);
        if (e == 0) u_[c.normal] = 0;
        break;
      case Kind::deeper:
        s.normal = Springs::Normal::compression;
        s.stiffness = 1;
        s.release = 0;
        break;
      case Kind::open:
        s.normal = Springs::Normal::open;
        break;
      case Kind::close:
        s.normal = s.stiffness == 1 ? Springs::Normal::compression : Springs::Normal::expansion;
        begin_tangential(by.contact);
        if (e == 0) {  // it yields at the force of its greatest compression, without shear
          s.release = 0;
          s.slip = 0;
        }
        break;
      case Kind::slip_up:
        s.slip = 1;
        break;
      case Kind::slip_down:
        s.slip = -1;
        break;
      case Kind::stick:
        s.origin = x_[c.tangent] + s.slip * c.friction * normal_force(by.contact, by.at) / ratio(by.contact);
        s.slip = 0;
        break;
      case Kind::none:
        break;
    }
  }

  const ImpactContacts& contacts_;
  std::vector<Springs> springs_;
  int rows_;
  Eigen::MatrixXd D_;
  Eigen::VectorXd x_, u_, impulse_;
  std::array<Eigen::VectorXd, order + 1> series_;  // of x
  std::array<Eigen::VectorXd, order - 1> force_;   // of f
  double none_;                                    // m/s, rates below this are zero up to rounding
  std::vector<std::size_t> held_;
  std::optional<MinimumNorm> holding_;
};

}  // namespace

bool compliant_impact(ImpactIsland& island, ImpactPhases&, ImpactContacts& contacts) {
  SpringImpact impact(island, contacts);
  if (!impact.run()) return false;
  const int m = island.problem.rows;
  const auto& p = impact.impulse();
  for (auto& c : contacts) {
    c.impulse_n = p[c.normal];
    c.impulse_t = c.tangent >= 0 ? p[c.tangent] : 0;
  }
  const double normal = impact.normal_work();
  island.normal_work += normal;
  island.tangential_work += 0.5 * p.dot(island.before.head(m) + impact.after()) - normal;
  island.solution.solved = true;
  return true;
}

}  // namespace freeplay
