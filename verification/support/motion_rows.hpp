// Rows of a motion at equal intervals, by the dense output that writes trajectory.csv.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "verification/support/support.hpp"
#include "verification/support/ways.hpp"

namespace freeplay::test {

/// t, and coordinates and velocities of all bodies.
struct MotionRow {
  double t;
  std::vector<double> q, v;
};

struct MotionRows {
  std::vector<MotionRow> rows;
  Result run;
  /// Greatest size of error(row).
  template <class Error>
  double worst(const Error& error) const {
    double most = 0;
    for (const auto& row : rows) most = std::max(most, std::abs(error(row)));
    return most;
  }
};

/// Of a run that has to finish, at intervals of `apart` seconds.
inline MotionRows motion_rows(const Scene& scene, Family family, double apart) {
  MotionRows out;
  Simulation simulation(scene, name_of(family));
  const auto size = simulation.state().q.size();
  Listener look;
  double next = 0;
  look.on_step = [&](const Step& step) {
    for (; next <= step.t1; next += apart) {
      out.rows.push_back({next, std::vector<double>(size), std::vector<double>(size)});
      step.state(next, out.rows.back().q, out.rows.back().v);
    }
  };
  out.run = finished(simulation, {&look});
  return out;
}

}  // namespace freeplay::test
