// Phases: angles and distances at which tables and one-way forces have kinks. It keeps the present
// piece of each, and finds the first crossing of a kink in a step. A method that samples a table
// only at its stages may pass over whole pulses. Each table is therefore restricted to its present
// piece, on which it is linear, and every kink is an event, located like a contact onset.
#pragma once

#include <optional>
#include <vector>

#include "formulations/integrators/crossing.hpp"
#include "values/memory.hpp"

namespace freeplay {

class Phases {
 public:
  struct Crossing {
    int phase = -1;
    bool up = false;  ///< whether the upper end of the piece is reached, else the lower
    double t = 0;     ///< s
  };

  void start(const System& system, const double* q, const double* v) {
    pieces_.resize(static_cast<std::size_t>(system.phases()));
    for (std::size_t k = 0; k < pieces_.size(); ++k) {
      const auto& phase = system.phase(static_cast<int>(k));
      const auto now = phase.at(q, v);
      pieces_[k] = phase.piece(now.value, now.rate >= 0);
    }
  }
  bool any() const { return !pieces_.empty(); }

  /// The first crossing in a step from t0 to t1 from state x0 to x1 (q, v, ...) with these bounds,
  /// and before `before` (s). `at`: the state at a time within the step.
  template <class State, class At>
  Crossing first(const System& system, double t0, double t1, const State& x0, const State& x1,
                 const MotionBounds& bounds, double before, double& unseen, At at) const {
    Crossing found{-1, false, before};
    for (int k = 0; k < static_cast<int>(pieces_.size()); ++k) {
      const auto& piece = pieces_[static_cast<std::size_t>(k)];
      for (const bool up : {false, true}) {
        if (!std::isfinite(up ? piece.high : piece.low)) continue;
        const auto motion = system.phase(k).motion(bounds, piece, up, x1.data());
        const auto left = [&](const State& x) { return rest(system, k, up, x); };
        const auto t = first_loss([&](double s) { return left(at(s)); }, t0, t1, left(x0), left(x1), motion,
                                  rounding(k), unseen);
        if (t && *t < found.t) found = {k, up, *t};
      }
    }
    return found;
  }
  /// Ends the last step of `method` at a crossing.
  template <class Method, class F>
  void land(const System& system, Method& method, F& f, Crossing& c) const {
    land_on_gap(method, f, c.t, rounding(c.phase), [&] { return rest(system, c.phase, c.up, method.x); });
  }
  /// The pieces, for Reading::pieces.
  const Piece* pieces() const { return pieces_.data(); }
  /// Distance to the end of phase k's piece at a state, upwards or downwards, and its rate (rad,
  /// rad/s).
  template <class State>
  Watched rest(const System& system, int k, bool up, const State& x) const {
    const auto now = system.phase(k).at(x.data(), x.data() + system.n());
    const auto& piece = pieces_[static_cast<std::size_t>(k)];
    return up ? Watched{piece.high - now.value, -now.rate} : Watched{now.value - piece.low, now.rate};
  }
  double rounding(int k) const { return rounding(pieces_[static_cast<std::size_t>(k)]); }
  void cross(const System& system, const Crossing& c) {
    auto& piece = pieces_[static_cast<std::size_t>(c.phase)];
    piece = system.phase(c.phase).piece(c.up ? piece.high : piece.low, c.up);
  }

  template <class M>
  void serialize(M& m) {
    const auto size = pieces_.size();
    m(pieces_);
    if constexpr (M::reading)
      if (pieces_.size() != size) throw MemoryError("the snapshot has other torque tables");
  }

 private:
  static double rounding(const Piece& piece) {
    const auto size = [](double x) { return std::isfinite(x) ? std::abs(x) : 0; };
    return 1e-15 * std::max({1.0, size(piece.low), size(piece.high)});
  }
  std::vector<Piece> pieces_;
};

}  // namespace freeplay
