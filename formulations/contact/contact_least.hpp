// Which impulses are taken where the laws admit several: the least (contact_least.cpp).
#pragma once

#include "formulations/contact/solvers.hpp"

namespace freeplay {

constexpr int most_for_least = 4;  // 6⁴ cases in expansion
constexpr int most_for_least_of_mode = 16;

/// Where the least impulses that the laws admit are taken: in every problem of an impact, or, in time steps that have one,
/// where they are not unique.
enum class Least { never, where_singular, always };

bool wants_least(Least least, const ContactEquations& p, SolverRoom& room);
/// Of islands of up to most_for_least unknowns over all motions, of up to most_for_least_of_mode over the motion that the
/// solver found (`solved`: there is one); larger ones stay as it left them. True where all islands have their least.
bool take_least(ContactEquations& p, double accepted, bool solved);

}  // namespace freeplay
