// Scenes that the event-driven scheme cannot finish, and the balances of a run with hand-overs
// between schemes, shared by tests and claims.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "verification/claims/force_balance.hpp"
#include "verification/support/scene_text.hpp"

namespace freeplay::verification {

/// A four-bar with clearance in three joints, its crank at 28,000 rad/s: the event-driven scheme
/// reaches a state from which it accepts no step.
inline const std::string loop =
    "gravity = [0, -9.81]\n" +
    test::body("crank", 0.00993849079612, 4.58349671345e-08,
               "position = [-0.000135001975712, -0.00373930507292]\nangle = -1.60688414586\n") +
    test::body("rod", 0.00529047996927, 1.91982846489e-07,
               "position = [0.00212334996309, 0.00289107591905]\nangle = 1.34396548478\n") +
    test::body("rocker", 5.49543814665, 0.000262957289556,
               "position = [0.0128411606134, 0.00663038099198]\nangle = 2.46899309098\n") +
    test::pin("j0", "ground", "crank", {}, {-0.00374174130076, 0}) +
    test::pin("j1", "crank", "rod", {0.00374174130076, 0}, {-0.0106422991898, 0},
              test::loose(7.82046015402e-06, 5.09613867729e-05)) +
    test::pin("j2", "rod", "rocker", {0.0106422991898, 0}, {0.0106422991898, 0},
              test::loose(7.82046015402e-06, 5.09613867729e-05)) +
    test::pin("j3", "ground", "rocker", {0.0211656173492, 0}, {-0.0106422991898, 0},
              test::loose(7.82046015402e-06, 5.09613867729e-05)) +
    test::motor("d0", "j0", -28263.3592747) +
    test::surface("s", 0.487575891412,
                  "young = 1.87291937294e+20\npoisson = 0.3\nfriction = 0.5883674586\n") +
    test::run_for(1.46593092926e-05, "start = \"assembled\"\n") + R"([nonsmooth]
step = 1.32096132348e-08
[penalty]
friction_v0 = 0.00966956211246
friction_v1 = 0.0966956211246
v0_floor = 0.00966956211246
alpha = 68216.0380167
beta = 68216.0380167
)";

/// A disc that falls without restitution between two steep walls, friction 1: it jams.
inline const std::string wedge =
    "gravity = [0, -9.81]\n" +
    test::body("d", 1.0, 0.00125, "position = [0.001, 0.13423855596804396]\nvelocity = [0, -0.5]\n") +
    test::plane("l", "ground", "d", 0.05, "s", "axis = [0.7023723340926309, -0.7118097388356455]\n") +
    test::plane("r", "ground", "d", 0.05, "s", "axis = [0.7023723340926309, 0.7118097388356455]\n") +
    test::surface("s", 0.0, 1.0) + test::run_for(1.5, "start = \"given\"\n");

/// The normal impulses of contacts, as the steps report them.
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
  double momentum, moment;  // residual, relative
  double impulses;          // of events minus those of steps, over the greatest sum
  int out_of_turn = 0;      // number of events
};

/// Runs a scene by the default scheme and records its balances.
inline Books booked(const Scene& scene) {
  Simulation simulation(scene, "nonsmooth");
  Impulses impulses;
  BalanceWatch balance(scene.mechanism, true, scene.run.duration);
  Books b{simulation.run({.observers = {&impulses, &balance}}), 0, 0, 0};
  b.momentum = balance.linear();
  b.moment = balance.angular();
  // For each contact, onsets and separations alternate: an impact is both, a lasting contact ends
  // in a separation.
  const auto contacts = b.result.contacts.size();
  std::vector<bool> lasts(contacts);
  std::vector<double> reported(contacts), last(contacts, INFINITY);
  for (const auto& e : b.result.events) {
    const auto k = static_cast<std::size_t>(e.contact);
    b.out_of_turn += lasts[k] != (e.kind == EventKind::separation);
    lasts[k] = e.kind == EventKind::contact;
    last[k] = lasts[k] ? e.t - e.t_uncertainty : INFINITY;
    if (!lasts[k]) reported[k] += e.impulse_n;
  }
  double greatest = 0, apart = 0;
  for (std::size_t k = 0; k < contacts; ++k) {
    const double sum = impulses.up_to(last[k] < INFINITY ? last[k] : impulses.at.back().t, k);
    greatest = std::max(greatest, impulses.at.back().sums[k]);
    apart = std::max(apart, std::abs(sum - reported[k]));
  }
  b.impulses = apart / greatest;
  return b;
}

}  // namespace freeplay::verification
