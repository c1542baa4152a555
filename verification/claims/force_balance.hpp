// Balance of the forces of a run: m a = m g + Σ ±F and J α = Σ M of every body, evaluated
// independently of the model's code. The inputs are the data of the scene, states, and the force F
// and moment m of each element on its second body. ForceBalance evaluates one state, BalanceWatch a
// whole run.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mechanism/mechanism.hpp"
#include "simulation/trajectory.hpp"
#include "verification/support/texts.hpp"

namespace freeplay::verification {

/// Greatest residual of m a = m g + Σ ±F and J α = Σ M over all bodies. Each residual is relative
/// to the greatest term of its equation.
struct Balance {
  double own = 0;   ///< with the moments reported for both bodies
  double anew = 0;  ///< with moments computed from F, m and the lever arms of the scene
  /// Replaces each residual by that of `b` if it is greater.
  void take(const Balance& b);
};

class ForceBalance {
 public:
  ForceBalance(const Mechanism& mechanism, const Layout& layout);
  /// Duration that the impulses belong to. The default means that the balance is one of forces.
  struct Over {
    double seconds = 1;
    std::span<const double> v = {};  ///< velocities; residuals within their rounding are ignored
  };
  /// Residuals of forces at positions q, with the geometry `gaps` of the contacts. For impulses,
  /// forces.acceleration is the change of velocity.
  Balance residual(std::span<const double> q, const Forces& forces,
                   std::span<const ContactPlace> gaps) const {
    return residual(q, forces, gaps, Over());
  }
  Balance residual(std::span<const double> q, const Forces& forces, std::span<const ContactPlace> gaps,
                   const Over& over) const;
  /// Balance::anew of residual(); `acceleration` in the order of State::v.
  double residual_anew(std::span<const double> q, std::span<const ElementForce> elements,
                       std::span<const double> acceleration, std::span<const ContactPlace> gaps,
                       const Over& over) const;
  /// Difference between the change of momentum and the sum of impulses, for each coordinate, with
  /// the moments reported for both bodies.
  std::vector<double> momentum_left(const Forces& impulses, std::span<const double> change,
                                    double seconds) const;
  const Mechanism& mechanism() const { return mechanism_; }
  const std::vector<ForceElement>& elements() const { return elements_; }

 private:
  struct Sum {
    double fx = 0, fy = 0, m = 0, force = 0, moment = 0;  // sums, and their greatest terms
  };
  double worst(const std::vector<Sum>& sums, std::span<const double> acceleration, const Over& over) const;
  std::vector<Sum> own(std::span<const ElementForce> elements) const;

  Mechanism mechanism_;
  std::vector<ForceElement> elements_;
  std::vector<Vec2> at_;  // the point of each element on its second body
  // ±1: sign of the moment that friction adds on the first body, since it acts on two round
  // surfaces that are a gap apart; 0 for other elements
  std::vector<double> overlap_;
  /// m, the longest piece of a beam. Straight beams have moments of zero: the rounding of force times arm, 1e-16, is
  /// no residual, which is significant from 1e-6 of the greatest term.
  double arm_ = 0;
  double couple_ = 0;  // N m, the rounding of beams' forces, 1e-16 EA, at that arm
};

/// Evaluates the balance during a run, in every `every`-th step: of forces at three instants of the
/// step or, with `whole`, of the impulses of the step (time stepping). It also compares the change
/// of momentum of each body with the impulses, over intervals of `interval` seconds.
class BalanceWatch final : public Observer {
 public:
  BalanceWatch(const Mechanism& mechanism, bool whole, double interval, int every = 1)
      : mechanism_(mechanism), whole_(whole), interval_(interval), every_(every) {}
  Wants wants() const override { return {.forces = true}; }
  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;

  Balance worst;
  long checked = 0;  ///< number of evaluated balances
  /// Greatest difference between change of momentum and impulses in an interval, relative to the
  /// greatest momentum or impulse of the body in the run.
  double linear() const { return left(false); }
  double angular() const { return left(true); }
  const std::vector<ForceElement>& elements() const { return balance_->elements(); }
  /// Impulses since the start; the power of each element is integrated to its work (J).
  Forces total;

 private:
  double left(bool angular) const;
  void add(const Forces& impulses);
  const Mechanism& mechanism_;
  bool whole_;
  double interval_;
  int every_;
  long steps_ = 0;
  std::unique_ptr<ForceBalance> balance_;
  Grid grid_;
  double since_ = 0;
  std::vector<double> v_last_, q_, v_, left_, scale_;
  std::vector<ContactPlace> gaps_;
  Forces sum_, piece_;
};

/// Reads m and F on the second body of all elements from one row of forces.csv. The suffix "_mean"
/// selects the columns of means.
std::vector<ElementForce> elements_of(const test::Columns& forces, std::size_t row,
                                      const std::vector<ForceElement>& list, const std::string& suffix = "");

}  // namespace freeplay::verification
