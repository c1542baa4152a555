// Solution of the assembly program of assembly.hpp by Ipopt's interior-point method (Wächter and
// Biegler, Math. Program. 106 (2006) 25).
#pragma once

#include <vector>

#include "values/stop.hpp"

namespace freeplay {

class System;
struct Metric;

/// Moves q to the solution of the program of assembly.hpp, without the rows `left_out` (ascending).
/// Held coordinates keep their values.
/// On failure q is Ipopt's last iterate, the point nearest to closure that it found. Polls `stop`
/// at each iteration and throws Interrupted if it is set.
void least_movement(const System& system, const std::vector<double>& start, const std::vector<int>& left_out,
                    const Metric& metric, std::vector<double>& q, const StopToken& stop);

}  // namespace freeplay
