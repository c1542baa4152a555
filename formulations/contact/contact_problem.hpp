// The contact problem of one step. Of every active contact and friction element, with b the rates at the end
// of a step without their impulses and D = WᵀAW the Delassus matrix (A: forces to accelerations, constraints
// kept):
//
//     u⁺ = D P + b
//     0 ≤ u_N⁺ + e u_N⁻ ⊥ P_N ≥ 0,                      (Newton; e acts on approach only)
//     −P_T ∈ μ P_N Sgn(u_T⁺)  or, preloaded,  −P_T ∈ B Sgn(u_T⁺).
//
// As a linear complementarity problem (Glocker, Set-Valued Force Laws, 2001): with P_T = P_R − μP_N and
// u_T = u_R − u_L the unknowns are z = (P_N, P_R, u_L) and w = (u_N⁺ + e u_N⁻, u_R, P_L = 2μP_N − P_R). The
// other solvers work on the cases (open, stick, slip) directly. With tangential restitution u_T⁺ + e_T u_T⁻
// stands for u_T⁺. The same problem in accelerations chooses what contacts do next.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "mechanism/options.hpp"
#include "numerics/lcp.hpp"
#include "values/ledger.hpp"

namespace freeplay {

/// One set-valued element of the problem and, after a solve, its impulses (before: a guess to start from).
/// Rows of D and b: `normal`, `tangent`, −1 where there is none.
struct ContactUnknown {
  int normal = -1, tangent = -1;
  double friction = 0;  ///< μ of a contact
  double bound = 0;     ///< N s: |P_T| ≤ bound + μ P_N
  double target_n = 0;  ///< −e u_N⁻ for an approaching contact, else 0: u_N⁺ is to be at least this
  double target_t = 0;  ///< −e_T u_T⁻: the rate at which friction does not resist
  double impulse_n = 0, impulse_t = 0;
};

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

/// One consistent mode.
struct ContactMode {
  enum class Way { open, stick, right, left };  ///< right: it slides with u_T > 0
  std::vector<Way> ways;                        ///< of each unknown; a frictionless one that presses: stick
  Eigen::VectorXd impulses, rates;              ///< of each row; of several choices of impulses one
};

/// What trying all modes of a problem found: of each motion one mode.
struct ContactModes {
  bool decided = false;  ///< false: too many contacts or modes, nothing was tried
  long tried = 0;
  std::vector<ContactMode> motions;
};

/// From one solve to the next only `unknowns` and `modes_left` may pass, the former only if the caller leaves them: the
/// impulses given are a guess to start from. D, b and the solvers' storage grow, but what a solve reads of them the
/// caller or the solve itself has filled, and no result depends on how large they are. So a snapshot needs
/// nothing of it; who starts from the last impulses remembers those.
class ContactProblem {
 public:
  static constexpr int most_for_enumeration = 6;  // 4⁶ cases
  static constexpr int most_for_lemke = 6;
  static constexpr int most_for_modes = 8;  // 4⁸ cases, when they are needed
  static constexpr int most_for_least = 4;  // 6⁴ cases in expansion
  static constexpr int most_for_least_of_mode = 16;

  explicit ContactProblem(LcpSolver solver = LcpSolver::automatic, double tolerance = 1e-10)
      : solver_(solver), tolerance_(tolerance), lemke_(0) {}

  /// Residuals are judged by no less than this rate, where the problem is a part of a greater one.
  void judge_by(double scale) { least_scale_ = scale; }
  /// Makes room for D and b of this many rows and keeps what is there; grows, never shrinks.
  void reserve(int size);
  /// The same for b alone, where D lives elsewhere (contact_islands.hpp).
  void reserve_rates(int size);
  void clear() {
    unknowns.clear();
    rows = 0;
  }
  /// Solves for the impulses of `unknowns` to the tolerance, by the chosen solver or the next that can.
  ContactSolution solve();
  /// The same where the impulses given are near the solution: Newton's method from them first.
  ContactSolution solve_near();
  /// One unknown alone, b holding what the others do to it. False where friction admits no impulse.
  static bool solve_one(ContactUnknown& c, double bn, double bt, double Dnn, double Dnt, double Dtt);
  /// What the present impulses leave of the laws, as rates: for each row the distance to the nearest of its
  /// cases.
  double residual() const;
  /// Greatest |b| and |target|: what residuals are judged by.
  double scale() const;
  /// Of a row with the present impulses: what D and b make of them.
  double rate(int row) const;

  /// @name Painlevé
  ///@{
  /// Whether some pressed contact has D_NN ≤ μ|D_NT|. Where none has, other motions are not looked for.
  bool doubtful() const;
  /// All consistent modes of up to most_for_modes unknowns, one for each motion (rates of the rows; forces that
  /// contacts share are never unique), up to `most` of them. A contact's force is looked for in the cone of its
  /// mode by nonnegative least squares, so that shared forces are found wherever there are some.
  ContactModes modes(int most) const;
  /// Numbers the islands of unknowns that D couples, and how many they are.
  int label_islands(std::vector<int>& label) const;
  /// How many there are to try.
  long number_of_modes() const;
  /// Of each island (unknowns coupled by D) with a doubtful contact its modes, and its unknowns in `members`.
  std::vector<ContactModes> doubtful_motions(std::vector<std::vector<int>>& members) const;
  /// Modes that solves may still try, of all problems of a run together: some seconds of CPU time. Part of what a
  /// run remembers, for its reports depend on it.
  long modes_left = 200'000;
  ///@}

  /// Whether the least impulses that the laws admit are taken (contact_least.cpp): in every problem of an impact, or, in time
  /// steps that strike, where they are not unique. Of islands of up to most_for_least unknowns over all motions, of up to
  /// most_for_least_of_mode over the motion that the solver found; larger ones stay as it left them.
  enum class Least { never, where_singular, always };
  Least least = Least::never;
  std::vector<ContactUnknown> unknowns;
  int rows = 0;
  Eigen::MatrixXd D;
  Eigen::VectorXd b;

 private:
  enum class Way { closed_form, enumeration, lemke, gauss_seidel, newton, none };
  std::array<Way, 4> order() const;
  bool attempt(Way way, double accepted, int& pivots);

  bool enumerate(double accepted, int& cases);
  bool gauss_seidel(double accepted, int& sweeps, int most = 2000);
  /// What rounding leaves of the laws' rates at the present impulses, at most.
  double attainable() const;
  /// From no impulses, from those given, or (in a few steps, where forces are unique) from those of the last problem.
  enum class From { nothing, given, last };
  bool newton(double accepted, int& steps, From from = From::nothing);
  /// A few of Newton's steps from the last problem's impulses, which stay as they were where it fails.
  bool newton_from_last(double accepted, int& steps);
  bool by_lemke(int& pivots);
  bool by_copositive_lemke(double accepted, int& pivots);
  void make_room(int n);
  /// Takes one out of the islands.
  ContactProblem island(const std::vector<int>& label, int which, std::vector<int>& members) const;
  bool by_islands(ContactSolution& s);
  bool by_modes(ContactSolution& s);
  bool proximal(double accepted, int& pivots);
  bool take_least(double accepted, bool solved);
  bool take_least_of_island();
  /// Whether D is positive definite beyond rounding, and friction nowhere as much as may admit a second motion.
  bool regular();
  bool wants_least();
  /// One contact whose two rows see one freedom (or none tangentially).
  bool singular_pair() const;

  LcpSolver solver_;
  double tolerance_, least_scale_ = 0;
  Lemke lemke_;
  int lemke_size_ = 0;
  std::vector<std::array<double, 2>> last_;
  Eigen::MatrixXd A_;
  Eigen::VectorXd q_, z_;
  Eigen::MatrixXd factor_;  // of D, in regular()
};

/// The motions of the doubtful islands of a problem in words: "tip: open, or sliding to the right with 12 N".
/// `name`: of an unknown; `unit`: of its impulses.
std::string describe_motions(const ContactProblem& problem, const std::function<std::string(int)>& name,
                             const char* unit = "N");

/// The note of `count` problems whose uniqueness was not decided.
std::string undecided_note(long count);

}  // namespace freeplay
