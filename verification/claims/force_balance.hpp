// Balance of the forces of a run: m a = m g + Σ ±F and J α = Σ M of every body, evaluated
// independently of the model's code from the data of the scene, from states, and from the force F
// and moment m of each element on its second body.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mechanism/mechanism.hpp"
#include "simulation/trajectory.hpp"
#include "verification/support/columns.hpp"

namespace freeplay::verification {

/// Residuals of m a = m g + Σ ±F and J α = Σ M, each over the greatest of its terms: the greatest
/// of all bodies.
struct Balance {
  double own = 0;   ///< with the moments reported for both bodies
  double anew = 0;  ///< with moments from F, m and the lever arms of the scene
  void take(const Balance& b);
};

class ForceBalance {
 public:
  ForceBalance(const Mechanism& mechanism, const Layout& layout);
  /// The step of impulses; for forces the default.
  struct Over {
    double seconds = 1;
    std::span<const double> v = {};  ///< velocities, whose rounding the changes of velocity contain
  };
  /// Residuals of forces at positions q. For impulses, forces.acceleration is the change of
  /// velocity. `gaps`: places of the contacts.
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
  /// Change of momentum less impulses for each coordinate, with the moments reported for both
  /// bodies.
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
  std::vector<Vec2> at_;         // the point of each element on its second body
  std::vector<double> overlap_;  // ±1: friction acts on two round surfaces a gap apart; else 0
};

/// Observes the balance of a run: at instants within its steps, or, with `whole`, for the impulses
/// of each step (time stepping). Also the change of momentum of each body between rows of
/// `interval` seconds.
class BalanceWatch final : public Observer {
 public:
  BalanceWatch(const Mechanism& mechanism, bool whole, double interval, int every = 1)
      : mechanism_(mechanism), whole_(whole), interval_(interval), every_(every) {}
  Wants wants() const override { return {.forces = true}; }
  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;

  Balance worst;
  long checked = 0;  ///< number of evaluated balances
  /// Change of momentum between rows less impulses, over the greatest momentum or impulse of the
  /// body in the run.
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

/// The elements of one row of forces.csv, m and F on the second body; `suffix` "_mean" for the
/// means.
std::vector<ElementForce> elements_of(const test::Columns& forces, std::size_t row,
                                      const std::vector<ForceElement>& list, const std::string& suffix = "");

}  // namespace freeplay::verification
