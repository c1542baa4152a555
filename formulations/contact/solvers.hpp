// Solvers of contact problems (contact_equations.hpp), each in a file of its own and all called alike: a solver gets the equations,
// with impulses to start from, the residual that is accepted (a rate), and room to work in; it leaves impulses and a summary. To
// add one: a function here, its file, and a place in ContactProblem::order().
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "formulations/contact/contact_equations.hpp"
#include "numerics/lcp.hpp"

namespace freeplay {

struct SolverSummary {
  bool solved = false;
  int iterations = 0;  ///< cases, pivots of Lemke, sweeps, Newton steps
};

/// What solvers take memory for, kept from one solve to the next. No result depends on how large it is.
struct SolverRoom {
  SolverRoom() : lemke(0) {}
  /// Room for a complementarity problem of n unknowns.
  void reserve_lemke(int n);

  Lemke lemke;
  int lemke_size = 0;
  Eigen::MatrixXd A;
  Eigen::VectorXd q, z;
  std::vector<std::array<double, 2>> last;  // impulses of the last problem
  Eigen::VectorXd rates;
  Eigen::MatrixXd factor;  // of D
};

/// @name One unknown alone, in closed form (closed_form.cpp)
///@{
/// b holds what the others do to it. False where friction admits no impulse.
bool solve_one(ContactUnknown& c, double bn, double bt, double Dnn, double Dnt, double Dtt);
/// A contact whose two rows see one freedom (or none tangentially).
bool singular_pair(const ContactEquations& p, const ContactUnknown& c);
SolverSummary closed_form(ContactEquations& p, double accepted, SolverRoom& room);
///@}

constexpr int most_for_enumeration = 6;  // 4⁶ cases
/// enumeration.cpp
SolverSummary enumeration(ContactEquations& p, double accepted, SolverRoom& room);

/// @name Lemke's method on the problem in standard form, and on one that is copositive (lemke.cpp)
///@{
SolverSummary lemke(ContactEquations& p, double accepted, SolverRoom& room);
SolverSummary copositive_lemke(ContactEquations& p, double accepted, SolverRoom& room);
///@}

/// @name Newton's method on the projections (newton.cpp)
///@{
/// From no impulses, from those given, or (in a few steps, where forces are unique) from those of the last problem.
enum class From { nothing, given, last };
SolverSummary newton_from(From from, ContactEquations& p, double accepted);
SolverSummary newton(ContactEquations& p, double accepted, SolverRoom& room);
/// A few of Newton's steps from the last problem's impulses, which stay as they were where it fails.
SolverSummary newton_from_last(ContactEquations& p, double accepted, SolverRoom& room);
///@}

/// @name Gauss–Seidel over contacts, from the impulses given (gauss_seidel.cpp)
///@{
SolverSummary sweeps(ContactEquations& p, double accepted, SolverRoom& room, int most);
SolverSummary gauss_seidel(ContactEquations& p, double accepted, SolverRoom& room);
/// Newton's steps from the last problem's impulses, sweeps, Newton's steps from what they found, and sweeps again.
SolverSummary mixed_gauss_seidel(ContactEquations& p, double accepted, SolverRoom& room);
///@}

/// Proximal points, where contacts share their loads (proximal.cpp).
SolverSummary proximal(ContactEquations& p, double accepted, SolverRoom& room);

}  // namespace freeplay
