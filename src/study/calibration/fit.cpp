// Minimum of the calibration misfit, its profile likelihood and a sample of the likelihood: bounded
// problems of few unknowns.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <stdexcept>

#include "numerics/bracketed_root.hpp"
#include "numerics/quantiles.hpp"
#include "study/calibration/calibrate.hpp"

namespace freeplay {
namespace {

using Vector = Eigen::VectorXd;

/// Minimises f in [−1, 1]ⁿ, with some unknowns fixed, by Newton's method with Levenberg damping and
/// active bounds. f is smooth and inexpensive, so gradient and Hessian are central differences.
class Minimiser {
 public:
  explicit Minimiser(std::function<double(const Vector&)> f) : f_(std::move(f)) {}
  double operator()(const Vector& xi) const { return f_(xi); }
  /// A minimum from this start; its value does not exceed that at the start.
  Place from(const Vector& start, std::initializer_list<Eigen::Index> held = {}) const {
    Place here{start, f_(start)};
    double damping = 1e-3;
    for (int i = 0; i < 60 && damping < 1e12; ++i) {
      const auto [g, H] = derivatives(here);
      std::vector<Eigen::Index> free;
      for (Eigen::Index j = 0; j < g.size(); ++j)
        if (std::ranges::count(held, j) == 0 && !(std::abs(here.xi[j]) >= 1 && g[j] * here.xi[j] < 0))
          free.push_back(j);
      if (free.empty() || Vector(g(free)).lpNorm<Eigen::Infinity>() < 1e-7) break;
      bool better = false;
      while (!better && damping < 1e12) {
        Eigen::MatrixXd damped = H(free, free);
        damped.diagonal().array() += damping;
        const Eigen::LLT<Eigen::MatrixXd> factors(damped);
        damping *= 8;
        if (factors.info() != Eigen::Success) continue;
        Vector next = here.xi;
        next(free) -= factors.solve(Vector(g(free)));
        next = next.cwiseMax(-1).cwiseMin(1);
        const double moved = (next - here.xi).lpNorm<Eigen::Infinity>(), value = f_(next);
        if (moved < 1e-10) return here;
        better = value < here.value;
        if (better) here = {std::move(next), value};
      }
      damping = std::max(damping / 64, 1e-9);
    }
    return here;
  }

 private:
  struct Derivatives {
    Vector gradient;
    Eigen::MatrixXd hessian;
  };
  Derivatives derivatives(const Place& here) const {
    constexpr double step = 1e-4;
    const auto n = here.xi.size();
    Derivatives d{Vector(n), Eigen::MatrixXd(n, n)};
    const auto at = [&](Eigen::Index i, double di, Eigen::Index j, double dj) {
      Vector xi = here.xi;
      xi[i] += di;
      xi[j] += dj;
      return f_(xi);
    };
    for (Eigen::Index i = 0; i < n; ++i) {
      const double above = at(i, step, i, 0), below = at(i, -step, i, 0);
      d.gradient[i] = (above - below) / (2 * step);
      d.hessian(i, i) = (above - 2 * here.value + below) / (step * step);
      for (Eigen::Index j = 0; j < i; ++j)
        d.hessian(i, j) = d.hessian(j, i) =
            (at(i, step, j, step) - at(i, step, j, -step) - at(i, -step, j, step) + at(i, -step, j, -step)) /
            (4 * step * step);
    }
    return d;
  }
  std::function<double(const Vector&)> f_;
};

/// Standard normal deviates, equal on all machines (std::normal_distribution differs between libraries).
class Normal {
 public:
  double uniform() { return (static_cast<double>(generator_() >> 11) + 0.5) * 0x1p-53; }
  double operator()() { return normal_quantile(uniform()); }

 private:
  std::mt19937_64 generator_{1};
};

/// Points in the whole range, denser where f is small, sorted by f, because f may have several minima and
/// narrow ridges. `near`: points of runs, one a row.
std::vector<Place> overview(const Minimiser& f, Eigen::Index n, const Eigen::MatrixXd& near) {
  std::vector<Place> list;
  const auto look = [&](const Vector& xi) {
    if (const double value = f(xi); std::isfinite(value)) list.push_back({xi, value});
  };
  const auto points = space_filling(static_cast<int>(n), 128 * static_cast<int>(n));
  for (Eigen::Index i = 0; i < points.rows(); ++i) look(points.row(i).transpose());
  for (Eigen::Index i = 0; i < near.rows(); ++i) look(near.row(i).transpose());
  look(Vector::Zero(n));
  std::ranges::sort(list, {}, &Place::value);
  Normal normal;
  const std::size_t most = 48 * static_cast<std::size_t>(n);
  for (const double width : {0.15, 0.08, 0.04, 0.02}) {
    const auto kept = std::min(list.size(), most);
    for (std::size_t k = 0; k < kept && list[k].value < list.front().value + 60; ++k)
      look((list[k].xi + width * Vector::NullaryExpr(n, [&] { return normal(); })).cwiseMax(-1).cwiseMin(1));
    std::ranges::sort(list, {}, &Place::value);
  }
  return list;
}

/// The least minimum from starts that are apart. Adds all minima found to `places`, so that narrow ones,
/// which a grid misses, are known to the profiles.
Place global(const Minimiser& f, std::vector<Place>& places) {
  constexpr std::size_t most = 24;
  constexpr double apart = 0.1, above = 100;
  Place best;
  std::vector<Place> minima;
  std::vector<Vector> starts;
  for (const auto& p : places) {
    if (starts.size() == most || p.value > best.value + above) break;
    if (std::ranges::any_of(starts, [&](const Vector& s) { return (s - p.xi).norm() < apart; })) continue;
    starts.push_back(p.xi);
    minima.push_back(f.from(p.xi));
    if (minima.back().value < best.value) best = minima.back();
  }
  if (!std::isfinite(best.value))
    throw std::runtime_error(
        "calibration: the fit found no minimum; widen the ranges of the unknowns or use more points");
  std::ranges::copy_if(minima, std::back_inserter(places),
                       [](const Place& p) { return std::isfinite(p.value); });
  std::ranges::sort(places, {}, &Place::value);
  return best;
}

constexpr int grid = 32;  // steps of a profile over the range

/// The profile of one unknown: its interval, the hull of all values where f is within `most` of the minimum.
/// An end of the range inside this interval is open. `known`: places sorted by f.
class LikelihoodProfile {
 public:
  LikelihoodProfile(const Minimiser& f, const std::vector<Place>& known, const Place& best,
                    Eigen::Index unknown, double most)
      : f_(f), known_(known), best_(best), j_(unknown), most_(most), lowest_(best) {
    for (const int way : {-1, 1}) follow(way, best);
  }
  /// Extends the interval to known places within the level, and follows the profile from them: a second
  /// minimum may be narrower than the steps of the profile.
  void extend(const std::vector<Place>& known) {
    for (const int way : {-1, 1}) {
      const std::size_t end = way < 0 ? 0 : 1;
      for (int again = 0; again < 4; ++again) {
        const Place* farthest = nullptr;
        for (const auto& place : known) {
          if (place.value > best_.value + most_ || way * (place.xi[j_] - ends_[end]) < 1e-6) continue;
          if (!farthest || way * (place.xi[j_] - farthest->xi[j_]) > 0) farthest = &place;
        }
        if (!farthest) break;
        follow(way, *farthest);
      }
    }
  }
  double low() const { return ends_[0]; }
  double high() const { return ends_[1]; }
  bool open_low() const { return open_[0]; }
  bool open_high() const { return open_[1]; }
  /// The places where the profile meets the level, or the ends of the range.
  const std::array<Vector, 2>& places() const { return places_; }
  /// The least value found on the profile.
  const Place& lowest() const { return lowest_; }

 private:
  Place at(double x, const Vector& near) {
    Vector start = near;
    start[j_] = x;
    auto least = f_.from(start, {j_});
    // Also start from the best known places of this slice, which may lead to other minima.
    std::vector<const Place*> others;
    for (const auto& place : known_) {
      if (others.size() == 3) break;
      if (std::abs(place.xi[j_] - x) > 2.0 / grid ||
          std::ranges::any_of(others, [&](const Place* o) { return (o->xi - place.xi).norm() < 0.2; }))
        continue;
      others.push_back(&place);
      start = place.xi;
      start[j_] = x;
      if (auto found = f_.from(start, {j_}); found.value < least.value) least = std::move(found);
    }
    if (least.value < lowest_.value) lowest_ = least;
    return least;
  }
  void follow(int way, const Place& from) {
    const std::size_t end = way < 0 ? 0 : 1;
    Place here = from, inside = from, outside;
    bool crossed = false;
    while (way * here.xi[j_] < 1) {
      const double x = std::clamp(here.xi[j_] + way * 2.0 / grid, -1.0, 1.0);
      auto next = at(x, here.xi);
      if (next.value <= best_.value + most_) {
        inside = next;
        crossed = false;
      } else if (!crossed) {
        outside = next;
        crossed = true;
      }
      here = std::move(next);
    }
    open_[end] = !crossed;
    places_[end] = here.xi;
    ends_[end] = crossed ? between(inside, outside, places_[end]) : static_cast<double>(way);
  }
  /// Intersection of the profile with the level. `place`: there.
  double between(Place inside, const Place& outside, Vector& place) {
    const double level = best_.value + most_;
    Place low = inside, high = outside;
    if (low.xi[j_] > high.xi[j_]) std::swap(low, high);
    const auto excess = [&](double x) {
      auto middle = at(x, inside.xi);
      place = middle.xi;
      const double found = middle.value - level;
      if (found <= 0) inside = std::move(middle);
      return std::abs(found) < 1e-6 ? 0 : found;
    };
    return bracketed_root(excess, low.xi[j_], high.xi[j_], low.value - level, high.value - level, {20, 40});
  }

  const Minimiser& f_;
  const std::vector<Place>& known_;
  Place best_;
  Eigen::Index j_;
  double most_;
  Place lowest_;
  std::array<double, 2> ends_{};
  std::array<Vector, 2> places_;
  std::array<bool, 2> open_{};
};

/// t_ν(0.975).
double student(double freedom) {
  return freedom < 1e6 ? student_quantile(std::max(freedom, 1.0), 0.975) : normal_quantile(0.975);
}

/// Covariance by Laplace's approximation, (JᵀV⁻¹J + w)⁻¹.
Eigen::MatrixXd laplace(const Misfit& misfit, const Vector& xi, const std::vector<bool>& used) {
  Eigen::MatrixXd information = Misfit::pull * Eigen::MatrixXd::Identity(xi.size(), xi.size());
  if (std::ranges::any_of(used, std::identity{})) {
    const auto J = misfit.jacobian(xi, used);
    information += J.transpose() * misfit.at(xi, used).covariance.ldlt().solve(J);
  }
  return information.inverse();
}

}  // namespace

double unscaled(const Unknown& u, double xi) {
  const double s = 0.5 * (xi + 1);
  return u.logarithmic ? u.low * std::pow(u.high / u.low, s) : u.low + s * (u.high - u.low);
}

Search search(const Misfit& misfit, const std::vector<bool>& used, const Eigen::MatrixXd& near) {
  const Minimiser f([&](const Vector& xi) { return misfit.at(xi, used).value; });
  Search found;
  found.places = overview(f, near.cols(), near);
  found.best = global(f, found.places);
  return found;
}

Fit fit(const Misfit& misfit, const std::vector<bool>& used, const std::vector<Unknown>& unknowns,
        const Eigen::MatrixXd& near) {
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  const Minimiser f([&](const Vector& xi) { return misfit.at(xi, used).value; });
  auto [best, known] = search(misfit, used, near.rows() > 0 ? near : Eigen::MatrixXd::Zero(1, n));
  Fit found;
  found.used = used;
  found.ends.resize(2 * n, n);
  // If a profile finds a lower value than the optimum, continue from there.
  for (int again = 0; again < 3; ++again) {
    const double t = student(misfit.freedom(best.xi, used));
    found.level = t * t;
    Place lowest = best;
    std::vector<LikelihoodProfile> profiles;
    for (Eigen::Index j = 0; j < n; ++j) profiles.emplace_back(f, known, best, j, t * t);
    // The ends of one profile are places for the others.
    auto places = known;
    for (const auto& p : profiles)
      for (const auto& xi : p.places())
        if (const double value = f(xi); value <= best.value + t * t + 1e-3)
          places.push_back({xi, std::min(value, best.value + t * t)});
    found.unknowns.clear();
    for (Eigen::Index j = 0; j < n; ++j) {
      auto& p = profiles[static_cast<std::size_t>(j)];
      p.extend(places);
      const auto at = [&](double xi) { return unscaled(unknowns[static_cast<std::size_t>(j)], xi); };
      found.unknowns.push_back({at(best.xi[j]), at(p.low()), at(p.high()), p.open_low(), p.open_high()});
      for (Eigen::Index end : {0, 1})
        found.ends.row(2 * j + end) = p.places()[static_cast<std::size_t>(end)].transpose();
      if (p.lowest().value < lowest.value) lowest = p.lowest();
    }
    if (lowest.value > best.value - 1e-3) break;
    best = f.from(lowest.xi);
  }
  found.xi = best.xi;
  found.least = best.value;
  const auto at = misfit.at(best.xi, used);
  found.squares = at.squares;
  found.objective = at.squares + Misfit::pull * best.xi.squaredNorm();
  found.degrees = std::max(1, static_cast<int>(std::ranges::count(used, true)) - static_cast<int>(n));
  found.rejected = found.squares > chi_squared_quantile(found.degrees, 0.99);

  const auto covariance = laplace(misfit, best.xi, used);
  const Vector scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  found.correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  for (const auto& target : misfit.targets()) {
    const Vector g = target.surface.gradient(best.xi);
    const double y = target.surface(best.xi);
    const double half = 1.96 * std::sqrt(g.dot(covariance * g) + target.surface.variance(best.xi));
    found.on_surface.push_back({std::exp(y), std::exp(y - half), std::exp(y + half)});
  }
  found.draws = sample(misfit, found, draws);
  return found;
}

std::optional<Ridge> ridge_of(const Misfit& misfit, const Fit& fit, const std::vector<Unknown>& unknowns) {
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  if (n < 2) return {};
  const auto width = [&](Eigen::Index j) { return fit.ends(2 * j + 1, j) - fit.ends(2 * j, j); };
  Ridge r;
  for (Eigen::Index j = 1; j < n; ++j)
    if (width(j) > width(static_cast<Eigen::Index>(r.along))) r.along = static_cast<std::size_t>(j);
  const auto a = static_cast<Eigen::Index>(r.along);
  if (width(a) < 0.1) return {};
  r.powers_of = std::ranges::all_of(unknowns, [](const Unknown& u) { return u.low > 0; });
  const auto covariance = laplace(misfit, fit.xi, fit.used);
  const auto value = [&](Eigen::Index k, Eigen::Index end) {
    return unscaled(unknowns[static_cast<std::size_t>(k)], fit.ends(2 * a + end, k));
  };
  const auto scale = [&](double x) { return r.powers_of ? std::log(x) : x; };
  bool any = false;
  for (Eigen::Index k = 0; k < n; ++k) {
    r.ends.push_back({value(k, 0), value(k, 1)});
    r.slope.push_back((scale(value(k, 1)) - scale(value(k, 0))) / (scale(value(a, 1)) - scale(value(a, 0))));
    // Of ξ_k for a given ξ_along, the others free.
    const double of_k = covariance(k, k) - covariance(k, a) * covariance(k, a) / covariance(a, a);
    const double half = 1.96 * std::sqrt(std::max(of_k, 0.0)), here = fit.xi[k];
    const auto& u = unknowns[static_cast<std::size_t>(k)];
    const double up = unscaled(u, here + half), down = unscaled(u, here - half);
    r.within.push_back(r.powers_of && down > 0 ? std::sqrt(up / down) - 1 : 0.5 * (up - down));
    const double moved = std::abs(fit.ends(2 * a + 1, k) - fit.ends(2 * a, k));
    r.follows.push_back(k != a && moved > (ridge_ratio - 1) * 2 * half && moved > 0.05);
    any = any || r.follows.back();
  }
  return any ? std::optional(r) : std::nullopt;
}

std::vector<MisfitPoint> misfit_map(const Misfit& misfit, const Fit& fit, Eigen::Index x, Eigen::Index y) {
  constexpr int steps = 30;
  const Minimiser f([&](const Vector& xi) { return misfit.at(xi, fit.used).value; });
  std::vector<MisfitPoint> map;
  Vector row = fit.xi;  // start of the previous row
  for (int i = 0; i <= steps; ++i) {
    Vector here = row;
    here[x] = -1 + 2.0 * i / steps;
    for (int j = 0; j <= steps; ++j) {
      here[y] = -1 + 2.0 * j / steps;
      const auto least = f.from(here, {x, y});
      here = least.xi;
      if (j == 0) row = here;
      map.push_back({here[x], here[y], least.value - fit.least});
    }
  }
  return map;
}

Eigen::MatrixXd sample(const Misfit& misfit, const Fit& fit, int count, double width) {
  constexpr int between = 25;  // steps between two points of the sample
  const auto n = fit.xi.size();
  Normal normal;
  // Optimal step for a normal distribution (Roberts, Gelman and Gilks, Ann. Appl. Probab. 7 (1997)
  // 110), limited to the ranges.
  Eigen::MatrixXd covariance = width * width * laplace(misfit, fit.xi, fit.used);
  const Vector limit = covariance.diagonal().cwiseSqrt().cwiseMax(0.6).cwiseInverse() * 0.6;
  covariance = limit.asDiagonal() * covariance * limit.asDiagonal();
  const Eigen::MatrixXd L =
      2.4 / std::sqrt(static_cast<double>(n)) * Eigen::MatrixXd(covariance.llt().matrixL());
  Eigen::MatrixXd points(count, n);
  Vector here = fit.xi;
  double value = fit.least;
  for (int k = 0; k < count * between; ++k) {
    const Vector next = here + L * Vector::NullaryExpr(n, [&] { return normal(); });
    const double u = normal.uniform();
    if (next.lpNorm<Eigen::Infinity>() <= 1) {
      const double there = misfit.at(next, fit.used).value;
      if (there - value < -2 * width * width * std::log(u)) {
        here = next;
        value = there;
      }
    }
    if (k % between == between - 1) points.row(k / between) = here.transpose();
  }
  return points;
}

}  // namespace freeplay
