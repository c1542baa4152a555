// Periodic motions along a branch: Newton's method for the state of the section x, the key p and, without a
// drive, the period T,
//
//     P(x, p) − x = 0,     τ_x · (x − x_k) + τ_p (p − p_k) = s,
//
// with the tangent τ of the branch at its last motion k and the arclength s from there (pseudo-arclength
// continuation: Keller, in Applications of Bifurcation Theory, 1977, 359). The derivatives of P by x and p
// are those of the variational equations (analysis/return_map.hpp). At a fold this system is regular.
//
// Lengths along a branch are measured in (u/σ, ξ): local coordinates u of the section, with the constant
// scale σ, and ξ = p/|to − from|.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/return_map.hpp"
#include "dynamics/system.hpp"
#include "io/scene/scene_text.hpp"
#include "mechanism/scene.hpp"
#include "numerics/dense.hpp"

namespace freeplay {

/// What is constant along all branches of a request.
struct BranchSetup {
  std::string key;
  double from = 0, to = 0;       ///< SI, range of the key
  std::optional<double> period;  ///< s, as given by the user
  bool autonomous = false;       ///< whether T is unknown
  Family family = Family::nonsmooth;
  StopToken stop;
  double range() const { return std::abs(to - from); }
};

/// The mechanism at one value of the key.
struct BranchModel {
  /// Throws ModelError or SceneError if the value is not possible.
  BranchModel(const Parameter& key, const BranchSetup& setup, int periods, double value);
  Scene scene;
  System system;
  ReturnMap map;
};

/// A periodic motion of a branch.
struct BranchMotion {
  double parameter = 0;                ///< SI
  std::shared_ptr<BranchModel> model;  ///< its map has the local coordinates of the section
  ReturnPoint point;
  Multipliers multipliers;
  /// (u/σ, relative change of T if that is unknown, ξ), of unit length without T
  Eigen::VectorXd tangent;
  int iterations = 0;  ///< of Newton's method
  /// Contacts in the order of their onsets.
  std::vector<int> sequence() const;
  double tangent_key() const { return tangent[tangent.size() - 1]; }
};

/// A condition on a motion, τ · (x − x_k) = s.
struct BranchCondition {
  const BranchMotion& base;  ///< k
  Eigen::VectorXd tangent;   ///< τ, as BranchMotion::tangent
  double distance = 0;       ///< s
};

/// A first guess for Newton's method.
struct BranchGuess {
  SectionState state;
  double parameter = 0;
  double length = 0;  ///< s, N T; of no effect if the drives determine it
};

/// Steps along a branch, and along a curve of bifurcations.
struct BranchStep {
  static constexpr double greatest = 0.02;  ///< default, over the range of a key
  static constexpr double reduction = 0.5;  ///< factor after a failure
  /// Cosine of the greatest angle between tangents of successive motions, or between successive chords.
  static constexpr double least_cosine = 0.9;
  /// Least share of an approach speed or of the least force of a lasting contact that remains after a step,
  /// so that a grazing impact or lift-off is approached in geometric steps.
  static constexpr double remaining_share = 0.4;
  /// The step after one whose motion needed `iterations` of Newton's method.
  static double after(double step, int iterations) {
    return iterations <= 2 ? 1.5 * step : iterations >= 4 ? reduction * step : step;
  }
};

class BranchSolver {
 public:
  /// `periods`: N.
  BranchSolver(const Scene& given, BranchSetup setup, int periods);

  const BranchSetup& setup() const { return setup_; }
  int periods() const { return periods_; }
  double scale() const { return scale_; }
  void set_scale(double scale) { scale_ = scale; }
  /// Least number of steps of a motion; see refine().
  void set_steps(int steps) { steps_ = steps; }
  int steps() const { return steps_; }

  /// The mechanism at a value of the key. `like`: with the same closed contacts; null: none. `length`: as
  /// BranchGuess::length.
  std::shared_ptr<BranchModel> model(double parameter, const ReturnMap* like, double length) const;
  /// The first motion of a branch near a state, with the section moved to the middle of the longest interval
  /// without a contact onset. Its tangent points to increasing values of the key if `rising`; the scale σ is
  /// set such that both parts of the tangent have equal lengths. Returns nullopt and the reason if there is
  /// none.
  std::optional<BranchMotion> begin(const SectionState& near, double parameter, double length, bool rising,
                                    std::string& reason);
  /// Arclength of a motion from another one, along the tangent of the latter.
  double distance(const BranchMotion& from, const BranchMotion& to) const {
    return excess({from, from.tangent, 0}, to.point.state, to.parameter);
  }
  /// On the tangent of a motion, at the arclength `distance`.
  BranchGuess guess(const BranchMotion& base, double distance) const;
  /// The motion at the arclength `distance` from a motion.
  std::optional<BranchMotion> along(const BranchMotion& base, double distance, std::string& reason) const;
  /// The motion at another value of the key near a guess.
  std::optional<BranchMotion> at_key(const BranchMotion& base, const BranchGuess& guess,
                                     std::string& reason) const;
  std::optional<BranchMotion> solve(const BranchCondition& condition, const BranchGuess& guess,
                                    std::string& reason) const;
  /// The end of a run that begins beside a motion, by u/σ and ξ, without derivatives; nullopt if it cannot
  /// begin or stops.
  std::optional<EndState> beside(const BranchMotion& m, const Eigen::VectorXd& u, double xi) const;
  /// The matrix of Newton's method for the next motion along the tangent of a motion.
  Eigen::MatrixXd equations(const BranchMotion& m) const {
    return system_at({m, m.tangent, 0}, *m.model, m.point);
  }
  /// Evaluates the map with more steps until its derivative is settled.
  std::string refine_motion(BranchMotion& m);
  /// Least distance in time of a contact onset from the section, over N T; ½ without onsets.
  static double margin(const BranchMotion& m);
  /// Moves the section to the middle of the longest interval without a contact onset, with the tangent.
  /// Returns the reason if the map cannot be evaluated there; the motion is then unchanged.
  std::string recentre(BranchMotion& m) const;

 private:
  /// A run from a guess without derivatives.
  struct Residual {
    SectionState start;     // projected onto the constraints
    Eigen::VectorXd value;  // of the map, in coordinates of another motion, over σ, then of the condition
    double greatest = 0;    // as Orbit::residual
  };
  std::optional<Residual> residual(const BranchCondition& c, const BranchMotion& near,
                                   const BranchGuess& at) const;
  BranchGuess moved(const BranchMotion& near, BranchGuess from, const Eigen::VectorXd& step) const;
  double excess(const BranchCondition& c, const SectionState& s, double parameter) const;
  Eigen::MatrixXd system_at(const BranchCondition& c, const BranchModel& model, const ReturnPoint& p) const;
  MapKey key() const;

  Parameter varied_;  // the key
  BranchSetup setup_;
  int periods_;
  double scale_ = 1;  // σ
  int steps_ = fewest_map_steps;
};

/// Length of a tangent (state, period, key) without the part of the period; `local`: size of the state.
double length_of(const Eigen::VectorXd& tangent, Eigen::Index local);

}  // namespace freeplay
