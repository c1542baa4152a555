#include "analysis/play/play_statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace freeplay {
namespace {

/// Draws u and d. The same numbers at every position, so that curves over the positions are smooth.
class Draw {
 public:
  Draw(const LooseMechanism& mechanism, PlayPlace place, unsigned seed)
      : mechanism_(mechanism), place_(place), random_(seed) {}
  void operator()(Eigen::VectorXd& u, Eigen::VectorXd& d) {
    const auto& tolerances = mechanism_.tolerances();
    d.resize(static_cast<Eigen::Index>(tolerances.size()));
    for (std::size_t i = 0; i < tolerances.size(); ++i)
      d[static_cast<Eigen::Index>(i)] = deviation(tolerances[i]);
    u.resize(mechanism_.size());
    for (const auto& c : mechanism_.components()) {
      if (!c.disc) {
        const double x = 2 * share_(random_) - 1;
        u[c.first] = place_ == PlayPlace::rim ? std::copysign(1, x) : x;
        continue;
      }
      const double turn = 2 * std::acos(-1.0) * share_(random_),
                   radius = place_ == PlayPlace::rim ? 1 : std::sqrt(share_(random_));
      u[c.first] = radius * std::cos(turn), u[c.first + 1] = radius * std::sin(turn);
    }
  }

 private:
  double deviation(const Tolerance& tolerance) {
    if (tolerance.distribution == Tolerance::Distribution::uniform)
      return tolerance.middle() + tolerance.half() * (2 * share_(random_) - 1);
    const bool cut = tolerance.distribution == Tolerance::Distribution::truncated;
    double x = 0;
    do x = normal_(random_) / tolerance.sigmas;
    while (cut && std::abs(x) > 1);
    return tolerance.middle() + tolerance.half() * x;
  }

  const LooseMechanism& mechanism_;
  PlayPlace place_;
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> share_{0, 1};
  std::normal_distribution<double> normal_;
};

/// Share of a sorted list that is at most y.
double share_below(const std::vector<double>& sorted, double y) {
  return static_cast<double>(std::ranges::upper_bound(sorted, y) - sorted.begin()) /
         static_cast<double>(sorted.size());
}

/// The y at which the corrected distribution function reaches `share`; all lists are sorted.
double quantile(const std::vector<double>& many, const std::vector<double>& exact,
                const std::vector<double>& linear, double share) {
  double low = std::min(many.front(), exact.front()), high = std::max(many.back(), exact.back());
  constexpr int halvings = 60;
  for (int i = 0; i < halvings; ++i) {
    const double y = 0.5 * (low + high);
    const double reached = share_below(many, y) + share_below(exact, y) - share_below(linear, y);
    (reached < share ? low : high) = y;
  }
  return 0.5 * (low + high);
}

}  // namespace

LinearOutput linear_output(LooseMechanism& mechanism, PlayExtremes& extremes, int k) {
  const auto& tolerances = mechanism.tolerances();
  LinearOutput output;
  output.value = extremes.ideal(k, output.a);
  const auto count = static_cast<Eigen::Index>(tolerances.size());
  Eigen::VectorXd d = output.b = Eigen::VectorXd::Zero(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& tolerance = tolerances[static_cast<std::size_t>(i)];
    const auto at = [&](double deviation) {
      d[i] = deviation;
      mechanism.vary(d);
      return extremes.value(k, Eigen::VectorXd::Zero(mechanism.size()));
    };
    const auto low = at(tolerance.least()), high = at(tolerance.upper);
    d[i] = 0;
    if (low && high) output.b[i] = (*high - *low) / (2 * tolerance.half());
  }
  if (count > 0) mechanism.vary(d);
  return output;
}

std::vector<double> variance_shares(const LooseMechanism& mechanism, PlayPlace place,
                                    const LinearOutput& output) {
  std::vector<double> shares;
  const double rim = place == PlayPlace::rim ? 1 : 0;
  for (const auto& c : mechanism.components())
    shares.push_back(output.a.segment(c.first, c.size()).squaredNorm() /
                     (c.disc ? 4 - 2 * rim : 3 - 2 * rim));
  const auto& tolerances = mechanism.tolerances();
  for (std::size_t i = 0; i < tolerances.size(); ++i) {
    const auto& tolerance = tolerances[i];
    const double change = output.b[static_cast<Eigen::Index>(i)] * tolerance.half();
    shares.push_back(change * change * tolerance.variance());
  }
  double sum = 0;
  for (const double share : shares) sum += share;
  for (auto& share : shares) share /= sum > 0 ? sum : 1;
  return shares;
}

PlayQuantiles play_quantiles(LooseMechanism& mechanism, PlayExtremes& extremes, int k,
                             const PlaySampling& sampling, const LinearOutput& output) {
  constexpr int cheap = 20;  // linear samples for each exact one
  constexpr std::size_t parts = 10;
  const bool varies = !mechanism.tolerances().empty();
  Eigen::VectorXd u, d;
  const auto linear_part = [&] { return output.value + output.a.dot(u) + output.b.dot(d); };
  PlayQuantiles found;
  std::vector<double> many, exact, linear;
  Draw draw(mechanism, sampling.place, 1);
  for (int i = 0; i < cheap * sampling.samples; ++i) {
    draw(u, d);
    many.push_back(linear_part());
  }
  std::ranges::sort(many);
  Draw other(mechanism, sampling.place, 2);
  for (int i = 0; i < sampling.samples; ++i) {
    other(u, d);
    if (varies) mechanism.vary(d);
    const auto value = extremes.value(k, u);
    if (!value) {
      ++found.failed;
      continue;
    }
    exact.push_back(*value);
    linear.push_back(linear_part());
  }
  if (varies) mechanism.vary(Eigen::VectorXd::Zero(output.b.size()));
  const auto of = [&](std::size_t from, std::size_t to, const std::vector<double>& cheap_ones) {
    std::vector<double> x(exact.begin() + static_cast<std::ptrdiff_t>(from),
                          exact.begin() + static_cast<std::ptrdiff_t>(to)),
        y(linear.begin() + static_cast<std::ptrdiff_t>(from),
          linear.begin() + static_cast<std::ptrdiff_t>(to));
    std::ranges::sort(x), std::ranges::sort(y);
    std::array<double, play_shares.size()> values{};
    for (std::size_t s = 0; s < play_shares.size(); ++s)
      values[s] = quantile(cheap_ones, x, y, play_shares[s]);
    return values;
  };
  if (exact.size() < parts) return found;
  found.value = of(0, exact.size(), many);
  // Parts of both kinds of samples: every tenth of the sorted cheap ones.
  std::array<double, play_shares.size()> sum{}, square{};
  for (std::size_t p = 0; p < parts; ++p) {
    std::vector<double> tenth;
    Draw again(mechanism, sampling.place, static_cast<unsigned>(3 + p));
    for (std::size_t i = 0; i < many.size() / parts; ++i) {
      again(u, d);
      tenth.push_back(linear_part());
    }
    std::ranges::sort(tenth);
    const auto values = of(exact.size() * p / parts, exact.size() * (p + 1) / parts, tenth);
    for (std::size_t s = 0; s < values.size(); ++s) {
      const double x = values[s] - found.value[s];
      sum[s] += x, square[s] += x * x;
    }
  }
  constexpr auto count = static_cast<double>(parts);
  for (std::size_t s = 0; s < sum.size(); ++s)
    found.error[s] = std::sqrt(std::max(0.0, square[s] - sum[s] * sum[s] / count) / (count * (count - 1)));
  return found;
}

}  // namespace freeplay
