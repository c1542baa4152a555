#include "dynamics/assembly/redundancy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "numerics/dense.hpp"

namespace freeplay {

namespace {

/// Which multipliers the equations leave undetermined at this state; empty if there are none.
std::vector<bool> undetermined_rows(const System& system, const State& state) {
  std::vector<bool> found;
  if (redundant_rows(system, state.q).empty()) return found;
  auto e = system.make_evaluation();
  system.place(state.t, state.q.data(), e);
  // Gᵀ in units of energy: scaled by √m⁻¹ for each coordinate, with rows of unit length.
  Eigen::MatrixXd Gt = Eigen::MatrixXd::Zero(system.n(), system.rows());
  const auto& p = system.pattern();
  for (int k = 0; k < system.rows(); ++k) {
    for (int i = p.begin[k]; i < p.begin[k + 1]; ++i)
      Gt(p.column[i], k) = e.G[i] / std::sqrt(system.mass()[p.column[i]]);
    if (const double length = Gt.col(k).norm(); length > 0) Gt.col(k) /= length;
  }
  const Eigen::MatrixXd free = kernel(Gt, 1e-9);
  for (int k = 0; k < system.rows(); ++k) found.push_back(free.row(k).cwiseAbs().maxCoeff() > 1e-9);
  return found;
}

}  // namespace

std::vector<int> undetermined_elements(const System& system, const State& state) {
  std::vector<int> list;
  const auto found = undetermined_rows(system, state);
  if (!found.empty())
    for (const auto& [element, begin, end] : system.reaction_rows())
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
    const auto row = static_cast<std::size_t>(bound.row);
    if (!found[row] && !((bound.pin || bound.couple > 0) && found[row + 1])) continue;
    for (const auto& [element, begin, end] : system.reaction_rows())
      if (begin <= bound.row && bound.row < end)
        throw ModelError(
            fmt::format("loads.{}.joint", facts.name),
            fmt::format("the reaction of {} bounds this friction but is statically indeterminate (dependent "
                        "constraint rows); remove the redundant support, or give a fixed force",
                        system.force_elements()[static_cast<std::size_t>(element)].name));
  }
}

}  // namespace freeplay
