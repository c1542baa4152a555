#include "study/settings/design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/random/sobol.hpp>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>

#include "study/settings/expression.hpp"

namespace freeplay {
namespace {

/// Uniform in [0, 1), with equal results on all machines (the standard does not specify the
/// algorithm of its distributions).
double uniform(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-53; }

/// Keeps a position that rounds up to 1 inside the half-open cube.
double within(double share) { return std::min(share, 1 - 0x1p-53); }

double at(const Axis::Drawn& d, double u) {
  if (d.logarithmic) return std::clamp(d.low * std::pow(d.high / d.low, u), d.low, d.high);
  return std::clamp(d.low + u * (d.high - d.low), d.low, d.high);
}

/// Adds one value of an axis. `place`: its index in the list of values; none if the value is drawn.
void add(Cell& cell, const Axis& axis, double value, std::optional<std::size_t> place) {
  cell.values.push_back(value);
  cell.overrides.push_back(fmt::format("{}={}", axis.key, value));
  for (std::size_t k = 0; k < axis.others.size(); ++k)
    cell.overrides.push_back(
        fmt::format("{}={}", axis.others[k], place ? axis.other_values[k][*place] : value));
}

}  // namespace

std::vector<std::vector<double>> unit_points(DrawMethod how, std::size_t dimensions, int count,
                                             std::uint64_t seed) {
  std::vector<std::vector<double>> points(static_cast<std::size_t>(count), std::vector<double>(dimensions));
  if (dimensions == 0) return points;
  std::mt19937_64 engine(seed);
  engine.discard(8);
  switch (how) {
    case DrawMethod::random:
      for (auto& p : points)
        for (auto& x : p) x = uniform(engine);
      break;
    case DrawMethod::latin_hypercube:
      for (std::size_t d = 0; d < dimensions; ++d) {
        std::vector<std::size_t> stratum(points.size());
        std::iota(stratum.begin(), stratum.end(), std::size_t{0});
        for (std::size_t i = stratum.size(); i > 1; --i)  // Fisher and Yates
          std::swap(stratum[i - 1],
                    stratum[static_cast<std::size_t>(uniform(engine) * static_cast<double>(i))]);
        for (std::size_t i = 0; i < points.size(); ++i)
          points[i][d] =
              within((static_cast<double>(stratum[i]) + uniform(engine)) / static_cast<double>(count));
      }
      break;
    case DrawMethod::sobol: {
      boost::random::sobol sequence(dimensions);
      for (auto& p : points)
        for (auto& x : p) x = static_cast<double>(sequence() >> 11) * 0x1p-53;
      break;
    }
  }
  return points;
}

std::size_t unfiltered(const Study& study) {
  auto count = study.sampling ? static_cast<std::size_t>(study.samples) : 1;
  for (const auto& axis : study.axes)
    if (!axis.drawn) count *= axis.values.size();
  return count;
}

std::vector<Cell> cells(const Study& study) {
  const auto drawn = static_cast<std::size_t>(
      std::ranges::count_if(study.axes, [](const Axis& a) { return a.drawn.has_value(); }));
  // If no axis is drawn, there is one point without coordinates.
  const auto points = unit_points(study.sampling.value_or(DrawMethod::random), drawn,
                                  drawn > 0 ? study.samples : 1, study.seed);
  std::optional<Expression> where;
  if (!study.where.empty() && !study.axes.empty()) where.emplace(study.where, names_of(study, false));
  std::vector<Cell> all;
  for (const auto& point : points) {
    std::vector<std::size_t> place(study.axes.size(), 0);
    for (bool more = true; more;) {
      Cell cell;
      for (std::size_t a = 0, d = 0; a < study.axes.size(); ++a) {
        const auto& axis = study.axes[a];
        if (axis.drawn)
          add(cell, axis, at(*axis.drawn, point[d++]), std::nullopt);
        else
          add(cell, axis, axis.values[place[a]], place[a]);
      }
      if (!where || where->holds(cell.values)) all.push_back(std::move(cell));
      more = false;
      for (std::size_t a = 0; a < place.size() && !more; ++a) {
        if (study.axes[a].drawn) continue;
        more = ++place[a] < study.axes[a].values.size();
        if (!more) place[a] = 0;
      }
    }
  }
  if (all.empty()) throw error_at(study, {"where"}, "selects no cell of the axes");
  return all;
}

}  // namespace freeplay
