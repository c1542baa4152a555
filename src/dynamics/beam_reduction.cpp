#include "dynamics/beam_reduction.hpp"

#include <cmath>

#include "dynamics/elements/beam_element.hpp"
#include "mechanism/beam.hpp"
#include "mechanism/error.hpp"
#include "numerics/dense.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

/// Stiffness of displacements y and rotations of n pieces, in this order, and then of the rotations of both ends.
MatrixXd stiffness(const Beam& beam) {
  const int n = beam.elements;
  MatrixXd K = MatrixXd::Zero(2 * n + 2, 2 * n + 2);
  for (int e = 0; e <= n; ++e) {
    const Dynamics<BeamElement> element(beam.element(e));
    VectorXd chord = VectorXd::Zero(2 * n + 2);  // its rotation
    if (e > 0) chord[e - 1] = -1 / element.length;
    if (e < n) chord[e] = 1 / element.length;
    VectorXd a = -chord, b = -chord;
    a[e > 0 ? n + e - 1 : 2 * n] += 1;
    b[e < n ? n + e : 2 * n + 1] += 1;
    K += element.own * (a * a.transpose() + b * b.transpose()) +
         element.other * (a * b.transpose() + b * a.transpose());
  }
  return K;
}

}  // namespace

BeamReduction::BeamReduction(const Beam& beam) {
  const int n = beam.elements, kept = beam.modes.value_or(0);
  const MatrixXd K = stiffness(beam), inner = K.topLeftCorner(2 * n, 2 * n);
  DenseLu solver;
  solver.compute(inner);
  const MatrixXd by_ends = -solve_columns(solver, K.topRightCorner(2 * n, 2));
  deflection = by_ends.topRows(n);
  rotation = by_ends.bottomRows(n);

  const auto piece = beam.body(0);
  VectorXd scale(2 * n);
  scale.head(n).setConstant(1 / std::sqrt(piece.mass));
  scale.tail(n).setConstant(1 / std::sqrt(piece.inertia));
  const auto [values, vectors] = symmetric_eigen(scale.asDiagonal() * inner * scale.asDiagonal());
  const MatrixXd modes = scale.asDiagonal() * vectors.leftCols(kept);
  shapes = modes.topRows(n);
  turns = modes.bottomRows(n);
  frequency = values.head(kept).cwiseSqrt();
  amplitudes = MatrixXd::Zero(0, n);
  others = MatrixXd::Identity(n, n);
  if (kept == 0) return;
  // Shares of displacements in the kinetic energy. Some modes of short, thick pieces are rotations alone.
  constexpr double least_share = 1e-3;
  const MatrixXd product = shapes.transpose() * shapes;
  if (piece.mass * symmetric_eigen(product).values[0] < least_share)
    throw ModelError(
        "beams." + beam.name + ".modes",
        "its pieces hardly move in some of these modes, which are rotations of short, thick pieces; "
        "keep fewer modes or use fewer elements");
  amplitudes = *solve_regular(product, shapes.transpose());
  others = orthogonal_complement(shapes);
}

}  // namespace freeplay
