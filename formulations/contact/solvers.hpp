// Interface of the solvers of contact problems (contact_equations.hpp); each solver has its own
// file. A solver gets the equations with an initial guess of the impulses, the accepted residual (a
// rate) and work space; it writes impulses, zero for open contacts, and returns a summary. To add a
// solver: its enumerator and word (LcpSolver) in src/mechanism/options.hpp, its file, its function
// here and its case in named_solver().
#pragma once

#include <Eigen/Core>

#include <array>
#include <vector>

#include "formulations/contact/contact_equations.hpp"
#include "mechanism/options.hpp"
#include "numerics/complementarity.hpp"

namespace freeplay {

struct SolverSummary {
  bool solved = false;
  int iterations = 0;  ///< cases, pivots of Lemke, sweeps, or Newton steps
};

/// Work space of solvers, kept from one solve to the next. No result depends on its size.
struct SolverRoom {
  SolverRoom() : lemke(0) {}
  /// Makes room for a complementarity problem of n unknowns.
  void reserve_lemke(int n);

  Lemke lemke;
  int lemke_size = 0;
  Eigen::MatrixXd A;
  Eigen::VectorXd q, z;
  std::vector<std::array<double, 2>> last;  // impulses of the last problem
  Eigen::VectorXd rates;
  Eigen::MatrixXd factor;  // of D
};

/// @name A single unknown, in closed form
///@{
/// b includes the effect of all other unknowns. Returns false if friction admits no impulse.
bool solve_one(ContactUnknown& c, double bn, double bt, double Dnn, double Dnt, double Dtt);
/// Whether both rows of a contact depend on one freedom (or the tangential row on none).
bool singular_pair(const ContactEquations& p, const ContactUnknown& c);
SolverSummary closed_form(ContactEquations& p, double accepted, SolverRoom& room);
///@}

constexpr int most_for_enumeration = 6;  // 4⁶ cases
/// Tries all modes of a small problem.
SolverSummary enumeration(ContactEquations& p, double accepted, SolverRoom& room);

/// @name Lemke's method on the problem in standard form, and in a copositive form
///@{
SolverSummary lemke(ContactEquations& p, double accepted, SolverRoom& room);
SolverSummary copositive_lemke(ContactEquations& p, double accepted, SolverRoom& room);
///@}

/// @name Newton's method on the projections (newton.cpp)
///@{
/// Initial guess: no impulses, the given impulses, or the impulses of the last problem (with few
/// steps, and only where forces are unique).
enum class From { nothing, given, last };
SolverSummary newton_from(From from, ContactEquations& p, double accepted);
SolverSummary newton(ContactEquations& p, double accepted, SolverRoom& room);
/// A few Newton steps from the impulses of the last problem, which are kept if it fails.
SolverSummary newton_from_last(ContactEquations& p, double accepted, SolverRoom& room);
///@}

/// @name Gauss–Seidel over contacts, from the given impulses (gauss_seidel.cpp)
///@{
SolverSummary sweeps(ContactEquations& p, double accepted, SolverRoom& room, int most);
SolverSummary gauss_seidel(ContactEquations& p, double accepted, SolverRoom& room);
/// Newton steps from the impulses of the last problem, sweeps, Newton steps from their result, and
/// sweeps again.
SolverSummary mixed_gauss_seidel(ContactEquations& p, double accepted, SolverRoom& room);
///@}

/// Proximal-point iteration, for contacts that share their loads.
SolverSummary proximal(ContactEquations& p, double accepted, SolverRoom& room);

using Solver = SolverSummary(ContactEquations& p, double accepted, SolverRoom& room);

/// The solver that nonsmooth.solver names; null for automatic.
inline Solver* named_solver(LcpSolver name) {
  switch (name) {
    case LcpSolver::automatic:
      return nullptr;
    case LcpSolver::enumeration:
      return enumeration;
    case LcpSolver::lemke:
      return lemke;
    case LcpSolver::gauss_seidel:
      return gauss_seidel;
    case LcpSolver::newton:
      return newton;
  }
  return nullptr;
}

}  // namespace freeplay
