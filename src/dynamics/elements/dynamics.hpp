// Dynamics of an element in a System. The facts and keys of an element are in
// mechanism/elements/NAME.hpp, its Dynamics in dynamics/elements/NAME.hpp:
//
//     build(b)                 adds constraint rows and contact pairs (dynamics/builder.hpp)
//     act(m, link, z, out)     applies a force, with its power; flow() is the rate of its state z
//     states(), state_scale(k) number of its states and their scales, if it may have several
//     potential(m, link)       the energy that it stores
//
// Only System uses it. A Dynamics inherits the facts and also owns data that are computed from them
// once.
#pragma once

#include "dynamics/kinematics.hpp"

namespace freeplay {

template <class Facts>
struct Dynamics;

}  // namespace freeplay
