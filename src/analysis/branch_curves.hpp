// Curves of bifurcations over two keys p₁, p₂ (docs/theory/continuation.md#curves-over-two-keys).
//
// A curve is followed in the plane of (p₁/R₁, p₂/R₂) with the ranges R of the keys. From a point, the key
// that changes more along the curve takes a step; at its new value the bifurcation is located along the
// branch over the other key, as on a branch over one key: by the zero of a test function, or by motions with
// small values of a positive quantity (branch_events.hpp). So each point costs a few motions, and a curve can
// turn in either key.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "analysis/branch_events.hpp"
#include "analysis/branch_solver.hpp"
#include "analysis/continuation.hpp"
#include "values/branch.hpp"

namespace freeplay {

/// A bifurcation from which a curve begins.
struct CurveStart {
  BifurcationKind kind = BifurcationKind::fold;
  BranchSolver solver;     ///< over the first key
  BranchMotion motion;     ///< at the bifurcation; of a positive quantity, with a small value
  Positive quantity = {};  ///< of a grazing impact or lift-off
  double parameter = 0;    ///< of the first key
  double slope = 0;        ///< of the share of the quantity, by arclength
};

class BifurcationCurve {
 public:
  /// `scene`: with the value of the second key at the start.
  BifurcationCurve(const Scene& scene, const SecondKey& second, CurveStart start, int number);
  /// Whether a curve of the list passes through the start.
  bool begins_on(const std::vector<CurvePoint>& list) const;
  /// Finds the next point: the start, then those to the side of lower values of the second key, then those to
  /// the other side. False: the curve is complete.
  bool advance();
  /// The point that was found last.
  CurvePoint point() const;
  /// Of the points found so far.
  const CurveEnds& ends() const { return ends_; }
  int points_of_first_side() const { return first_side_; }  ///< with the start

 private:
  using Plane = std::array<double, 2>;  // p/R
  struct Located {
    Plane at{};
    BranchMotion motion;
    BranchMotion base;   // from which the next one is predicted
    BranchGuess level;   // beside it, of an equal value of a positive quantity for all points
    Plane base_at{};     // of `level`
    int iterations = 0;  // for the first motion
    double residual = 0;
    int free = 0;      // the key along which it was located
    double slope = 0;  // of the test function or positive quantity, by arclength
  };

  bool begin();
  double greatest_step() const { return second_.step ? *second_.step / range_[1] : BranchStep::greatest; }
  bool advance_on_side(std::string& reason);
  BranchSolver solver(int free, double fixed) const;
  std::optional<Located> locate(const std::vector<Located>& points, int free, const Plane& near,
                                std::string& reason) const;
  bool zero(const BranchSolver& solver, Located& p, std::string& reason) const;
  struct Predicted {
    State state;
    double at = 0;      // of the other key, over its range
    double length = 0;  // s, N T
  };

  void set_base(Located& p, BranchMotion m, BranchGuess level) const;
  Predicted predicted(const std::vector<Located>& points, std::size_t key, double x) const;
  std::optional<BranchMotion> at_level(const BranchSolver& solver, BranchMotion m, double level,
                                       double& slope, std::string& reason) const;
  bool vanishing(const BranchSolver& solver, Located& p, std::string& reason) const;
  std::optional<BranchMotion> along(const BranchSolver& solver, const BranchMotion& m, double distance,
                                    std::string& reason) const;
  double test(const BranchSolver& solver, const BranchMotion& m) const;
  bool is_positive() const {
    return start_.kind == BifurcationKind::grazing || start_.kind == BifurcationKind::liftoff;
  }

  const Scene& scene_;
  const SecondKey& second_;
  CurveStart start_;
  CurveEnds ends_;
  int side_ = 0, first_side_ = 0;
  std::vector<Located> points_;  // of the present side, from the start on
  Plane direction_{};
  double step_ = 0;      // in the plane
  bool at_end_ = false;  // of the range
  std::array<std::string, 2> keys_;
  std::array<double, 2> low_{},
      high_{};  // SI, bounds of the curve: of the first key beyond the branch's range
  Plane range_{};
};

}  // namespace freeplay
