// Output play under load: the equilibrium that the loads of a scene cause at each position, with rigid contacts and
// without friction (dynamics/assembly/equilibrium.hpp). It is found by descent from that at the neighbouring
// position, once in the order of the positions and once against it. Both differ where there are several: the
// difference is lost motion.
#pragma once

#include "analysis/play/loose_mechanism.hpp"
#include "analysis/play/play.hpp"

namespace freeplay {

/// Fills the loaded poses of all positions and the jumps. `over`: index of the driven joint, −1: none. `quantities`:
/// those of the play. Positions without equilibrium have the reason.
void add_loaded(const Mechanism& mechanism, int over, const std::vector<OutputQuantity>& quantities,
                Play& play, const StopToken& stop);

/// Greatest difference of quantity k between both approaches.
double lost_motion(const Play& play, std::size_t k);

}  // namespace freeplay
