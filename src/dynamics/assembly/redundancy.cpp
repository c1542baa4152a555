#include "dynamics/assembly/redundancy.hpp"

#include <fmt/format.h>

#include <cmath>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "numerics/dense.hpp"

namespace freeplay {

std::vector<int> undetermined_elements(const System& system, const State& state) {
  std::vector<int> found;
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
  for (const auto& [element, begin, end] : system.reaction_rows())
    if (free.middleRows(begin, end - begin).cwiseAbs().maxCoeff() > 1e-9) found.push_back(element);
  return found;
}

void refuse_undetermined_friction(const System& system, const State& state) {
  if (system.reactive_frictions().empty()) return;
  for (const int element : undetermined_elements(system, state))
    for (const int k : system.reactive_frictions()) {
      const auto& facts = system.friction_facts(k);
      const auto& joint = system.force_elements()[static_cast<std::size_t>(element)];
      if (joint.kind == ForceElement::Kind::joint && joint.joint == facts.reaction->element)
        throw ModelError(
            fmt::format("loads.{}.joint", facts.name),
            fmt::format("the reaction of {} bounds this friction but is statically indeterminate (dependent "
                        "constraint rows); remove the redundant support, or give a fixed force",
                        joint.name));
    }
}

}  // namespace freeplay
