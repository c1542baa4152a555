// Scenes that the event-driven scheme does not finish, and the books of a run that hands over between schemes: what the tests
// and the claims of that share.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "facade/simulation.hpp"
#include "model/scene.hpp"
#include "verification/claims/force_balance.hpp"

namespace freeplay::verification {

/// A ball of e = 0.28 spinning in the corner of floor and wall at 500 rad/s, friction 0.1: once it rolls on the wall it is
/// kicked between the two, tens of thousands of times.
inline const char* corner = R"(
gravity = [0.0, -9.81]
[bodies.ball]
mass = 1.54325
inertia = 2.15082e-05
position = [-0.029709440263269583, 0.039612587017692776]
velocity = [-0.09117309399792044, 0.2074957040009306]
angular_velocity = -497.985
[surfaces.s]
restitution = 0.281436
friction = 0.1
[contacts.floor]
type = "plane"
between = ["ground", "ball"]
at = [[0, -0.06469845507030915], [0.0, 0.0]]
axis = [1, 0]
radius = 0.005279574543769977
surface = "s"
[contacts.right]
type = "plane"
between = ["ground", "ball"]
at = [[0.06469845507030915, 0], [0.0, 0.0]]
axis = [0, 1]
radius = 0.005279574543769977
surface = "s"
[run]
duration = 3.0
start = "given"
)";

/// A disc that falls without restitution between two steep walls, friction 1: it jams.
inline const char* wedge = R"(
gravity = [0, -9.81]
[bodies.d]
mass = 1.0
inertia = 0.00125
position = [0.001, 0.13423855596804396]
velocity = [0, -0.5]
[contacts.l]
type = "plane"
between = ["ground", "d"]
axis = [0.7023723340926309, -0.7118097388356455]
radius = 0.05
surface = "s"
[contacts.r]
type = "plane"
between = ["ground", "d"]
axis = [0.7023723340926309, 0.7118097388356455]
radius = 0.05
surface = "s"
[surfaces.s]
restitution = 0.0
friction = 1.0
[run]
start = "given"
duration = 1.5
)";

/// The normal impulses that contacts gave, as steps show them.
class Impulses final : public Observer {
 public:
  struct At {
    double t;
    std::vector<double> sums;  // N s, since the start
  };
  std::vector<At> at;
  Wants wants() const override { return {.forces = true}; }
  void begin(const Layout& layout, const State& state) override {
    elements_.clear();
    for (std::size_t e = 0; e < layout.forces.size(); ++e)
      if (layout.forces[e].kind == ForceElement::Kind::contact) elements_.push_back(e);
    sum_.elements.resize(layout.forces.size());
    sum_.acceleration.resize(state.v.size());
    at.push_back({state.t, std::vector<double>(elements_.size())});
  }
  void step(const Step& step) override {
    sum_.add(1, step.before());
    keep(step.t0);
    step.add_impulse(step.t0, step.t1, sum_);
    sum_.add(1, step.within());
    keep(step.t1);
  }
  /// Of contact k, up to the time t.
  double up_to(double t, std::size_t k) const {
    double sum = 0;
    for (const auto& a : at)
      if (a.t <= t) sum = a.sums[k];
    return sum;
  }

 private:
  void keep(double t) {
    at.push_back({t, {}});
    for (const auto e : elements_) at.back().sums.push_back(sum_.elements[e].fn);
  }
  std::vector<std::size_t> elements_;
  Forces sum_;
};

struct Books {
  Result result;
  double momentum, moment;  // left over, relative
  double impulses;          // of events less those of steps, over the greatest sum
  int out_of_turn = 0;      // events
};

/// Runs a scene by the default scheme and does its books.
inline Books booked(const Scene& scene) {
  Simulation simulation(scene, "nonsmooth");
  Impulses impulses;
  BalanceWatch balance(scene.mechanism, true, scene.run.duration);
  Books b{simulation.run({.observers = {&impulses, &balance}}), 0, 0, 0};
  b.momentum = balance.linear();
  b.moment = balance.angular();
  // Of each contact touches and losses take turns: an impact is both, a lasting contact ends in a separation.
  const auto contacts = b.result.contacts.size();
  std::vector<bool> lasts(contacts);
  std::vector<double> told(contacts), last(contacts, INFINITY);
  for (const auto& e : b.result.events) {
    const auto k = static_cast<std::size_t>(e.contact);
    b.out_of_turn += lasts[k] != (e.kind == EventKind::separation);
    lasts[k] = e.kind == EventKind::contact;
    last[k] = lasts[k] ? e.t - e.t_uncertainty : INFINITY;
    if (!lasts[k]) told[k] += e.impulse_n;
  }
  double greatest = 0, apart = 0;
  for (std::size_t k = 0; k < contacts; ++k) {
    const double sum = impulses.up_to(last[k] < INFINITY ? last[k] : impulses.at.back().t, k);
    greatest = std::max(greatest, impulses.at.back().sums[k]);
    apart = std::max(apart, std::abs(sum - told[k]));
  }
  b.impulses = apart / greatest;
  return b;
}

}  // namespace freeplay::verification
