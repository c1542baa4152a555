// ContactProblem: a contact problem (contact_equations.hpp) together with the solvers that are
// tried on it (solvers.hpp), in an order that depends on its size and on nonsmooth.solver. It
// chooses the least impulses where several solutions exist (contact_least.hpp) and checks
// uniqueness (find_modes()).
//
// Usage: fill `rows`, D, b and `unknowns`, then call solve(), which writes the impulses to
// `unknowns` and returns a ContactSolution.
#pragma once

#include <Eigen/Core>

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "formulations/contact/contact_equations.hpp"
#include "formulations/contact/contact_least.hpp"
#include "formulations/contact/solvers.hpp"
#include "mechanism/options.hpp"
#include "values/ledger.hpp"

namespace freeplay {

// Existence and uniqueness of the solution of a contact problem, by enumeration of all consistent
// modes. With friction, a problem can have several motions or none (Painlevé) where a pressed
// contact has D_NN ≤ μ|D_NT|. find_modes() enumerates one problem, doubtful_motions() the islands
// of a problem in which this condition is met.

constexpr int most_for_modes = 8;  // 4⁸ cases at most

/// One consistent mode.
struct ContactMode {
  enum class Way { open, stick, right, left };  ///< right: it slides with u_T > 0
  /// of each unknown; stick for a frictionless contact that is pressed
  std::vector<Way> ways;
  Eigen::VectorXd impulses, rates;  ///< of each row; one of several possible choices of impulses
};

/// Result of the enumeration: one mode for each motion.
struct ContactModes {
  bool decided = false;  ///< false: too many contacts or modes, nothing was tried
  long tried = 0;
  std::vector<ContactMode> motions;
};

/// Number of modes to try.
long number_of_modes(const ContactEquations& problem);
/// Finds all consistent modes of up to most_for_modes unknowns, one for each motion, up to `most`
/// of them; tries no more than `left` modes. Motions differ in the rates of their rows, because
/// shared contact forces are never unique. The force of each contact is sought in the cone of its
/// mode by nonnegative least squares, so that shared forces are found wherever they exist.
ContactModes find_modes(const ContactEquations& problem, int most, long left);
/// Finds the modes of each island (unknowns coupled by D) that has a pressed contact with D_NN ≤
/// μ|D_NT|; `members` gets the unknowns of each island.
std::vector<ContactModes> doubtful_motions(const ContactEquations& problem, long left,
                                           std::vector<std::vector<int>>& members);

/// Describes the motions of these islands, for example "tip: open, or sliding to the right with 12
/// N". `name` returns the name of an unknown; `unit` is the unit of its impulses.
std::string describe_motions(const ContactEquations& problem, const std::function<std::string(int)>& name,
                             const char* unit = "N");

struct ContactSolution {
  bool solved = true;
  double residual = 0;       ///< relative to the greatest |b|
  double residual_rate = 0;  ///< in the units of b
  /// iterations of all solvers: pivots of Lemke, cases, sweeps, Newton steps or modes
  int pivots = 0;
  int retries = 0;  ///< number of solvers that failed
  /// The solution is not unique: a pressed contact has D_NN ≤ μ|D_NT| (Painlevé), and the
  /// enumeration of all modes found other motions.
  bool ambiguous = false;
  /// Uniqueness is not known: a pressed contact has D_NN ≤ μ|D_NT|, but the modes were not
  /// enumerated, because too many contacts are coupled with it or modes_left is used up.
  bool undecided = false;
  /// No solution exists: the enumeration of all modes found no consistent one. False if the solvers
  /// failed without such a proof.
  bool impossible = false;

  /// Adds this solution to the counts and extremes of a run.
  void count(Work& work, Extremes& extremes) const;
};

/// The only data that influence a later solve are `unknowns` (if the caller keeps them; their
/// impulses are the initial guess) and `modes_left`. D, b and the solvers' room grow, but a solve
/// reads only entries that the caller or the solve itself has filled, and no result depends on
/// their size. A snapshot therefore needs no data of this class; a caller that starts from the last
/// impulses serializes those.
class ContactProblem : public ContactEquations {
 public:
  using Least = freeplay::Least;
  static constexpr int most_for_lemke = 6;

  explicit ContactProblem(LcpSolver solver = LcpSolver::automatic, double tolerance = 1e-10)
      : solver_(solver), tolerance_(tolerance) {}

  void reserve(int size);
  void reserve_rates(int size);
  /// Solves for the impulses of `unknowns` to the tolerance, with the chosen solver or the next one
  /// that succeeds.
  ContactSolution solve();
  ContactModes modes(int most) const { return find_modes(*this, most, modes_left); }

  /// Number of modes that may still be enumerated in this run, for all its problems together. The
  /// initial value limits the enumeration to some seconds of CPU time. It is serialized with the
  /// run, because the run's diagnostics depend on it.
  long modes_left = 200'000;
  Least least = Least::never;

 private:
  std::array<Solver*, 4> order() const;
  bool alone(ContactSolution& s, double size);
  bool by_islands(ContactSolution& s);
  bool by_modes(ContactSolution& s);
  void finish(ContactSolution& s, double size) const;
  void look_for_others(ContactSolution& s);

  LcpSolver solver_;
  double tolerance_;
  SolverRoom room_;
};

}  // namespace freeplay
