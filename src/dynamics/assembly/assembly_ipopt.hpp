#pragma once

#include <vector>

#include "values/stop.hpp"

namespace freeplay {

class System;

/// Moves q to the solution of the assembly program of assembly.hpp, with the rows `left_out` (ascending) not
/// imposed. On failure q holds Ipopt's last iterate, the point nearest to closure that it found. Throws Interrupted
/// when `stop` asks, heard at each iteration.
void least_movement(const System& system, const std::vector<double>& start, const std::vector<int>& left_out,
                    std::vector<double>& q, const StopToken& stop);

}  // namespace freeplay
