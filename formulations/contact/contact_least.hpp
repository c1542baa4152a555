// Choice of impulses where the contact and friction laws admit several solutions: the least in a
// weighted norm. contact_least.cpp defines the norm.
#pragma once

#include "formulations/contact/solvers.hpp"

namespace freeplay {

constexpr int most_for_least = 4;  // 6⁴ cases in expansion
constexpr int most_for_least_of_mode = 16;

/// Where the least admissible impulses are taken: never; in time steps whose solution is not
/// unique; in every problem of an impact.
enum class Least { never, where_singular, always };

bool wants_least(Least least, const ContactEquations& p, SolverRoom& room);
/// Replaces the impulses by the least ones: over all motions for islands of up to most_for_least
/// unknowns, and within the motion that the solver found (`solved`: there is one) for islands of up
/// to most_for_least_of_mode. Larger islands keep the solver's impulses. Returns true if all
/// islands have their least impulses.
bool use_least_impulses(ContactEquations& p, double accepted, bool solved);

}  // namespace freeplay
