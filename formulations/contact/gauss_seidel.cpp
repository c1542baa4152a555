// Gauss–Seidel with a dense D (gauss_seidel.hpp), alone or in turn with Newton's method (newton.cpp).

#include "formulations/contact/gauss_seidel.hpp"

namespace freeplay {

SolverSummary sweeps(ContactEquations& p, double accepted, SolverRoom& room, int most) {
  auto& u = room.rates;
  u.conservativeResize(std::max<Eigen::Index>(u.size(), p.rows));
  return sweep_contacts(p, accepted, u, most);
}

SolverSummary gauss_seidel(ContactEquations& p, double accepted, SolverRoom& room) {
  return sweeps(p, accepted, room, 2000);
}

/// Newton's method and Gauss–Seidel in turn. Newton's method starts from the impulses of the last
/// problem: if no contact has changed its mode, one or two steps solve the problem. Otherwise 100
/// sweeps provide a new initial guess, from which Newton's method needs few steps, whereas sweeps
/// converge slowly if many contacts share a load. If this fails, up to 2000 sweeps follow.
SolverSummary mixed_gauss_seidel(ContactEquations& p, double accepted, SolverRoom& room) {
  auto sum = newton_from_last(p, accepted, room);
  const auto add = [&](const SolverSummary& one) {
    sum.solved = one.solved;
    sum.iterations += one.iterations;
  };
  if (!sum.solved) add(sweeps(p, accepted, room, 100));
  if (!sum.solved) add(newton_from(From::given, p, accepted));
  if (!sum.solved) add(sweeps(p, accepted, room, 2000));
  return sum;
}

}  // namespace freeplay
