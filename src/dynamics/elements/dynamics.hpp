// What an element of a mechanism does in a System. Its facts and keys stand in mechanism/elements/NAME.hpp, and this in
// dynamics/elements/NAME.hpp:
//
//     build(b)                 composes constraint rows and contact pairs (dynamics/builder.hpp)
//     act(m, link, z, out)     applies a force, with its power; flow() is the rate of its state z
//     potential(m, link)       the energy that it stores
//
// System alone reads it. A Dynamics is made of the facts, and holds besides what is laid flat of them once.
#pragma once

#include "dynamics/kinematics.hpp"

namespace freeplay {

template <class Facts>
struct Dynamics;

}  // namespace freeplay
