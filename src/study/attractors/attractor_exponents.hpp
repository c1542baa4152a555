// The largest Lyapunov exponent of each attractor of a bifurcation diagram or basin (analysis/lyapunov.hpp;
// docs/how-to/attractors.md). The first run of an attractor, in the order of the chains, continues from its
// end, where it has settled. On a periodic attractor the exponent is
//
//     λ = ln|μ|/(n T)
//
// with μ the greatest multiplier of a cycle; otherwise it is an average over batches of whole periods. Stored
// exponents are not repeated.
#pragma once

#include <vector>

#include "study/attractors/attractor_table.hpp"

namespace freeplay {

/// Completes SettledRun::exponent of all runs that have an attractor. Attractors are computed in parallel on
/// `threads` threads (0: all cores). `on_progress` receives numbers of attractors. Throws SceneError.
void add_exponents(const Study& study, const AttractorPlan& plan, const std::vector<Chain>& chains,
                   const Classified& classified, AttractorStore& store, int threads, StopToken stop,
                   const OnProgress& on_progress, SettledRuns& runs);

}  // namespace freeplay
