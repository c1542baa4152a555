// Dynamics of a reduced beam (mechanism/beam.hpp, beam_reduction.hpp): its constraint rows, and the forces of its modes,
// U = ½ Σ ω_m² η_m² with η = P (y − S_y φ). Damping τ adds τ η̇ to η in the forces. The element from end to end is a
// load of its own.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "dynamics/beam_chord.hpp"
#include "dynamics/beam_reduction.hpp"
#include "dynamics/elements/dynamics.hpp"
#include "mechanism/beam.hpp"

namespace freeplay {

template <>
struct Dynamics<Beam> : Beam {
  BeamChord chord;
  std::vector<double> amplitude;  ///< combinations η_m (beam_chord.hpp)
  std::vector<double> square;     ///< ω_m², 1/s²

  explicit Dynamics(const Beam& facts) : Dynamics(facts, BeamReduction(facts)) {}

  void build(auto& b) const { b.reduced_beam(chord, rows_, static_cast<int>(square.size()), name); }
  auto link(auto& b) const { return b.link(between, at); }
  bool does_work() const { return damping > 0 && !square.empty(); }
  bool needs_velocity() const { return does_work(); }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    if (square.empty()) return;
    const auto arm = m.arms(link);
    const ChordShape<T> s(chord, m.q, arm, m.e);
    std::array<T, most_reduced> force;
    for (int k = 0; k < elements; ++k) force[k] = 0;
    T on_i = 0, on_j = 0;
    std::optional<ChordRates<T>> rates;
    if (damping > 0) rates.emplace(s, arm, m.v);
    const double* w = amplitude.data();
    for (const double k : square) {
      T eta = s.combination(w);
      if (rates) {
        const T rate = rates->combination(w);
        eta += damping * rate;
        out.power.damping -= damping * k * (rate * rate);
      }
      const T f = -k * eta;
      on_i += w[0] * f, on_j += w[1] * f;
      for (int p = 0; p < elements; ++p) force[p] += w[p + 2] * f;
      w += chord.weights();
    }
    // A force on a piece acts back on the beam's ends by the rotation of the chord.
    T across = -on_i - on_j;
    for (int p = 0; p < elements; ++p) {
      across -= s.x[p] * force[p];
      out.pull(Link{link.i, first + p, link.si, {}}, Arms<T>{arm.ri, {T(0), T(0)}, {}},
               Vec2Of<T>{force[p] * s.left.x(), force[p] * s.left.y()});
    }
    across /= s.length;
    out.pull(link, arm, Vec2Of<T>{across * s.left.x(), across * s.left.y()});
    out.couples(link, on_i, on_j);
  }

  /// Stiffness of the amplitudes, ω² for unit masses.
  const std::vector<double>& stiffness() const { return square; }
  /// Bodies in the order of the entries of strain_rows(), with the number of their coordinates there.
  std::vector<std::array<int, 2>> strain_columns() const {
    std::vector<std::array<int, 2>> list{{between[0], 3}, {between[1], 3}};
    for (int k = 0; k < elements; ++k) list.push_back({first + k, 2});
    return list;
  }
  double* strain_rows(const auto& m, const Link& link, double* values) const {
    if (square.empty()) return values;
    const auto arm = m.arms(link);
    const ChordShape<double> s(chord, m.q, arm, m.e);
    for (std::size_t k = 0; k < square.size(); ++k)
      values = s.row(arm, amplitude.data() + k * chord.weights(), 0, values);
    return values;
  }

  double potential(const auto& at_rest, const auto& link) const {
    if (square.empty()) return 0;
    const auto from = at_rest.point(link.i, link.si), to = at_rest.point(link.j, link.sj);
    const ChordShape<double> s(chord, at_rest.q, from, to - from,
                               at_rest.point(link.i, link.si + chord.tangent[0]) - from,
                               at_rest.point(link.j, link.sj + chord.tangent[1]) - to);
    double sum = 0;
    for (std::size_t k = 0; k < square.size(); ++k) {
      const double eta = s.combination(amplitude.data() + k * chord.weights());
      sum += 0.5 * square[k] * eta * eta;
    }
    return sum;
  }

 private:
  Dynamics(const Beam& facts, const BeamReduction& reduced) : Beam(facts), chord(facts) {
    const auto append = [](std::vector<double>& list, const Eigen::RowVectorXd& on_y,
                           const Eigen::RowVector2d& on_ends) {
      list.insert(list.end(), {on_ends[0], on_ends[1]});
      list.insert(list.end(), on_y.begin(), on_y.end());
    };
    const Eigen::MatrixXd C = reduced.others.transpose(), P = reduced.amplitudes;
    for (int k = 0; k < P.rows(); ++k) {
      append(amplitude, P.row(k), -P.row(k) * reduced.deflection);
      square.push_back(reduced.frequency[k] * reduced.frequency[k]);
    }
    for (int k = 0; k < C.rows(); ++k) append(rows_, C.row(k), -C.row(k) * reduced.deflection);
    for (int k = 0; k < elements; ++k) {
      const Eigen::RowVectorXd on_y = -reduced.turns.row(k) * P;
      append(rows_, on_y, -on_y * reduced.deflection - reduced.rotation.row(k));
    }
  }

  std::vector<double> rows_;  // weights of ReducedBeamRows
};

}  // namespace freeplay
