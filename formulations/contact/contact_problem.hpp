// A contact problem (contact_equations.hpp) with the solvers that are tried on it (solvers.hpp), in an order that its size and
// nonsmooth.solver choose, what is taken where there are several solutions (contact_least.hpp), and whether there are
// (contact_modes.hpp).
#pragma once

#include <array>

#include "formulations/contact/contact_least.hpp"
#include "formulations/contact/contact_modes.hpp"
#include "formulations/contact/solvers.hpp"
#include "mechanism/options.hpp"
#include "values/ledger.hpp"

namespace freeplay {

struct ContactSolution {
  bool solved = true;
  double residual = 0;       ///< relative to the greatest |b|
  double residual_rate = 0;  ///< the same in the units of b
  int pivots = 0;            ///< of Lemke; cases tried, sweeps or Newton steps of the others
  int retries = 0;           ///< solvers that failed before
  /// Some pressed contact has D_NN ≤ μ|D_NT| (Painlevé), and up to so many contacts are coupled that all modes
  /// were tried: there are other motions than this one.
  bool ambiguous = false;
  /// Some pressed contact has D_NN ≤ μ|D_NT|, but too many contacts are coupled with it, or too many modes have been
  /// tried already: whether there are other motions is not known.
  bool undecided = false;
  /// All modes were tried, and none is consistent. False where solvers failed and nothing is known.
  bool impossible = false;

  /// Adds it to a run's counts and extremes.
  void count(Work& work, Extremes& extremes) const;
};

/// From one solve to the next only `unknowns` and `modes_left` may pass, the former only if the caller leaves them: the
/// impulses given are a guess to start from. D, b and the solvers' room grow, but what a solve reads of them the
/// caller or the solve itself has filled, and no result depends on how large they are. So a snapshot needs
/// nothing of it; who starts from the last impulses remembers those.
class ContactProblem : public ContactEquations {
 public:
  using Least = freeplay::Least;
  static constexpr int most_for_lemke = 6;

  explicit ContactProblem(LcpSolver solver = LcpSolver::automatic, double tolerance = 1e-10)
      : solver_(solver), tolerance_(tolerance) {}

  void reserve(int size);
  void reserve_rates(int size);
  /// Solves for the impulses of `unknowns` to the tolerance, by the chosen solver or the next that can.
  ContactSolution solve();
  ContactModes modes(int most) const { return find_modes(*this, most, modes_left); }

  /// Modes that solves may still try, of all problems of a run together: some seconds of CPU time. Part of what a
  /// run remembers, for its reports depend on it.
  long modes_left = 200'000;
  Least least = Least::never;

 private:
  enum class Way { closed_form, enumeration, lemke, gauss_seidel, newton, none };
  std::array<Way, 4> order() const;
  SolverSummary attempt(Way way, double accepted);
  bool by_islands(ContactSolution& s);
  bool by_modes(ContactSolution& s);
  void finish(ContactSolution& s, double size) const;
  void look_for_others(ContactSolution& s);

  LcpSolver solver_;
  double tolerance_;
  SolverRoom room_;
};

}  // namespace freeplay
