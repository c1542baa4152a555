#include "dynamics/assembly/rates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/stated.hpp"
#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"
#include "numerics/dense.hpp"

namespace freeplay {

using Eigen::MatrixXd, Eigen::VectorXd;

MatrixXd null_space(const MatrixXd& C, const VectorXd& weights) {
  const VectorXd back = weights.cwiseSqrt().cwiseInverse();
  if (C.rows() == 0) return back.asDiagonal();
  const MatrixXd weighted = (C * back.asDiagonal()).transpose();
  return back.asDiagonal() * orthogonal_complement(weighted, 1e-10);
}

Curvatures curvatures(const MatrixXd& K, const MatrixXd& Z, const VectorXd& weights) {
  if (Z.cols() == 0) return {VectorXd(0), VectorXd(0), Z};
  const MatrixXd H = Z.transpose() * K * Z;
  const MatrixXd symmetric = 0.5 * (H + H.transpose());
  const auto apart = symmetric_eigen(symmetric);
  Curvatures c{apart.values, {}, Z * apart.vectors};
  const MatrixXd size = K.cwiseAbs();
  const VectorXd back = weights.cwiseSqrt().cwiseInverse();
  const double all = K.size() > 0 ? (back.asDiagonal() * size * back.asDiagonal()).maxCoeff() : 0;
  c.doubt.resize(c.value.size());
  for (int d = 0; d < c.value.size(); ++d) {
    const VectorXd x = c.direction.col(d).cwiseAbs();
    c.doubt[d] = 1e-11 * x.dot(size * x) + 1e-14 * all;
  }
  return c;
}

namespace {

/// Rates of the constraints at one position.
class Rates {
 public:
  Rates(const Mechanism& mechanism, const System& system, const State& s)
      : mechanism_(mechanism), system_(system), e_(system.make_evaluation()), r_(e_.phi.size()) {
    system.place(0, s.q.data(), e_);
    redundant_ = !redundant_rows(system, s.q).empty();
  }
  /// v += least change in the metric that satisfies the rates; two passes, the second of which
  /// removes the rounding of the first.
  void satisfy(const Metric& metric, std::vector<double>& v) {
    MovableRows rows(system_, metric, redundant_);
    rows.choose(e_.G);
    if (!rows.factor(e_.G))
      throw ModelError("",
                       "the velocities cannot be made consistent: a mass, length or speed exceeds the range "
                       "of numbers");
    std::vector<double> dv(v.size());
    for (int i = 0; i < 2; ++i) {
      worst(v);
      rows.solve(nullptr, r_, dv);
      for (std::size_t c = 0; c < v.size(); ++c) v[c] += dv[c];
    }
  }
  /// The row with the greatest violation, with its amount (m/s, rad/s) in r_.
  std::pair<double, int> worst(const std::vector<double>& v) {
    std::pair<double, int> found{0, -1};
    for (int k = 0; k < system_.rows(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      r_[i] = -e_.phi_t[i] - row_dot(system_.pattern(), e_.G.data(), k, v.data());
      if (std::abs(r_[i]) > found.first) found = {std::abs(r_[i]), k};
    }
    return found;
  }
  OpenJoint open(const std::vector<double>& v) {
    const auto [amount, row] = worst(v);
    if (row < 0) return {};
    return {system_.row_name(row), amount, system_.is_angle_row(row), false,
            row >= system_.rows() - system_.drive_rows()};
  }
  /// Scale of rounding: the size of the terms of the constraint rates.
  double terms(const std::vector<double>& v) {
    double most = worst(v).first;
    for (int k = 0; k < system_.rows(); ++k) {
      double sum = std::abs(e_.phi_t[static_cast<std::size_t>(k)]);
      for (int i = system_.pattern().begin[k]; i < system_.pattern().begin[k + 1]; ++i)
        sum += std::abs(e_.G[static_cast<std::size_t>(i)] * v[system_.pattern().column[i]]);
      most = std::max(most, sum);
    }
    return most;
  }
  void refuse_if_open(const State& s, double terms) {
    const auto [amount, row] = worst(s.v);
    if (amount > 1e-9 * terms)
      throw ModelError(
          key_of(mechanism_, open(s.v)),
          fmt::format("no velocities satisfy all constraints; this one is violated by {:.3g} {}: the drives "
                      "contradict each other, or the start is a locked position",
                      amount, system_.is_angle_row(row) ? "rad/s" : "m/s"));
  }

 private:
  const Mechanism& mechanism_;
  const System& system_;
  Evaluation e_;
  std::vector<double> r_;
  bool redundant_ = false;
};

}  // namespace

OpenJoint assemble_velocities(const Mechanism& mechanism, const System& system,
                              const std::vector<char>& stated, State& s) {
  constexpr double closed = 1e-9;  // of the terms of the rates
  Rates rates(mechanism, system, s);
  const Metric whole{system.mass()};
  double terms = rates.terms(s.v);
  OpenJoint violated;
  if (any(stated)) {
    const Metric holding{system.mass(), stated};
    const auto rough = s.v;
    rates.satisfy(holding, s.v);
    terms = std::max(terms, rates.terms(s.v));
    violated = rates.open(s.v);
    if (violated.amount > closed * terms) {
      // Each pass begins at the last one's absent velocities, whose weight then has no effect.
      for (int i = 0; i < 3; ++i) {
        for (std::size_t c = 0; c < s.v.size(); ++c)
          if (stated[c]) s.v[c] = rough[c];
        rates.satisfy(light_where_absent(system, stated), s.v);
      }
      // Absent velocities that the corrected ones leave open are nearest to the rough ones.
      auto settled = s.v;
      for (std::size_t c = 0; c < settled.size(); ++c)
        if (!stated[c]) settled[c] = rough[c];
      rates.satisfy(holding, settled);
      if (rates.worst(settled).first <= closed * terms) s.v = settled;
    }
  }
  rates.satisfy(whole, s.v);
  rates.refuse_if_open(s, terms);
  return violated;
}

}  // namespace freeplay
