#include "dynamics/assembly/movable_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/projection.hpp"
#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "numerics/dense.hpp"
#include "numerics/sparse.hpp"

namespace freeplay {
namespace {

/// Which multipliers the equations leave undetermined at this state; empty if there are none.
std::vector<bool> undetermined_rows(const System& system, const State& state) {
  std::vector<bool> found;
  if (redundant_rows(system, state.q).empty()) return found;
  auto Gt = weighted_rows(system, {}, state);  // in units of energy, with rows of unit length
  for (int k = 0; k < system.rows(); ++k)
    if (const double length = Gt.col(k).norm(); length > 0) Gt.col(k) /= length;
  const Eigen::MatrixXd free = kernel(Gt, 1e-9);
  for (int k = 0; k < system.rows(); ++k) found.push_back(free.row(k).cwiseAbs().maxCoeff() > 1e-9);
  return found;
}

}  // namespace

std::vector<int> undetermined_elements(const System& system, const State& state) {
  std::vector<int> list;
  const auto found = undetermined_rows(system, state);
  if (!found.empty())
    for (const auto& [link, begin, end, element] : system.report().reactions)
      if (std::find(found.begin() + begin, found.begin() + end, true) != found.begin() + end)
        list.push_back(element);
  return list;
}

/// The couple of a guide without slider_length does not bound its friction, and may be undetermined.
void refuse_undetermined_friction(const System& system, const State& state) {
  if (system.reactive_frictions().empty()) return;
  const auto found = undetermined_rows(system, state);
  if (found.empty()) return;
  for (const int k : system.reactive_frictions()) {
    const auto& facts = system.friction_facts(k);
    const auto& bound = *facts.reaction;
    if (!bound.reads_reactions()) continue;
    const auto row = static_cast<std::size_t>(bound.row);
    if (!found[row] && !(bound.reads_second() && found[row + 1])) continue;
    for (const auto& [link, begin, end, element] : system.report().reactions)
      if (begin <= bound.row && bound.row < end)
        throw ModelError(
            facts.path(facts.of_mesh() ? "efficiency" : "joint"),
            fmt::format("the reaction of {} bounds this friction but is statically indeterminate (dependent "
                        "constraint rows); remove the redundant support, or give a fixed force",
                        system.report().elements[static_cast<std::size_t>(element)].name));
  }
}

MovableRows::MovableRows(const System& system, const Metric& metric, bool redundant)
    : system_(system), metric_(metric), rows_(static_cast<std::size_t>(system.rows())) {
  std::iota(rows_.begin(), rows_.end(), 0);
  for (int c = 0; c < system.n(); ++c) {
    const bool held = !metric.held.empty() && metric.held[static_cast<std::size_t>(c)];
    place_.push_back(held ? -1 : static_cast<int>(columns_.size()));
    if (held) continue;
    columns_.push_back(c);
    weight_.push_back(metric.weight[static_cast<std::size_t>(c)]);
  }
  find_entries();
  if (metric.held.empty())
    saddle_ = std::make_unique<SaddlePoint>(weight_, pattern_, SolvePath::automatic, RowFacts{redundant});
}

void MovableRows::find_entries() {
  pattern_ = {};
  pattern_.columns = static_cast<int>(columns_.size());
  entries_.clear();
  const auto& whole = system_.pattern();
  for (const int k : rows_) {
    for (int e = whole.begin[k]; e < whole.begin[k + 1]; ++e)
      if (const int c = place_[static_cast<std::size_t>(whole.column[e])]; c >= 0) {
        pattern_.column.push_back(c);
        entries_.push_back(e);
      }
    pattern_.end_row();
  }
}

std::vector<double> MovableRows::values(const std::vector<double>& G) const {
  std::vector<double> list;
  for (const int e : entries_) list.push_back(G[static_cast<std::size_t>(e)]);
  return list;
}

void MovableRows::choose(const std::vector<double>& G) {
  constexpr double vanishing = 1e-9;  // of a row's length: the rest is in held coordinates
  if (metric_.held.empty() || columns_.empty()) return;
  rows_.resize(static_cast<std::size_t>(system_.rows()));
  std::iota(rows_.begin(), rows_.end(), 0);
  find_entries();
  auto reduced = values(G);
  const auto& whole = system_.pattern();
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    double all = 0, movable = 0;
    for (int e = whole.begin[k]; e < whole.begin[k + 1]; ++e) {
      const auto c = static_cast<std::size_t>(whole.column[e]);
      const double x = G[static_cast<std::size_t>(e)] / std::sqrt(metric_.weight[c]);
      all = std::hypot(all, x);
      if (place_[c] >= 0) movable = std::hypot(movable, x);
    }
    if (movable <= vanishing * all)
      std::fill(reduced.begin() + pattern_.begin[k], reduced.begin() + pattern_.begin[k + 1], 0.0);
  }
  rows_ = independent_rows(pattern_, reduced, weight_);
  find_entries();
  saddle_ = std::make_unique<SaddlePoint>(weight_, pattern_, SolvePath::automatic, RowFacts{false, false});
}

std::vector<int> MovableRows::left_out() const {
  std::vector<int> list;
  for (int k = 0; k < system_.rows(); ++k)
    if (!std::ranges::binary_search(rows_, k)) list.push_back(k);
  return list;
}

bool MovableRows::factor(const std::vector<double>& G) {
  return !saddle_ || saddle_->factor(values(G).data());
}

void MovableRows::solve(const double* f, const std::vector<double>& r, std::vector<double>& x) {
  std::ranges::fill(x, 0.0);
  if (!saddle_) return;
  f_.clear();
  r_.clear();
  if (f)
    for (const int c : columns_) f_.push_back(f[c]);
  for (const int k : rows_) r_.push_back(r[static_cast<std::size_t>(k)]);
  x_.resize(columns_.size());
  lambda_.resize(rows_.size());
  saddle_->solve(f ? f_.data() : nullptr, r_.data(), x_.data(), lambda_.data());
  for (std::size_t i = 0; i < columns_.size(); ++i) x[static_cast<std::size_t>(columns_[i])] = x_[i];
}

}  // namespace freeplay
