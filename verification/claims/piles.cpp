// Piles of discs by both nonsmooth schemes: contact forces at rest against weights, and random
// piles whose runs finish with a closed energy balance.
#include "verification/support/piles.hpp"

#include "mechanism/scene.hpp"
#include "verification/claims/force_claims.hpp"

namespace freeplay::verification {
namespace {

Scene scene_of(const std::string& text, Scheme scheme) {
  auto scene = parse_scene(text, "pile");
  scene.nonsmooth.scheme = scheme;
  scene.nonsmooth.step = 1e-4;
  return scene;
}

}  // namespace

void piles(Findings& f) {
  const double R = 0.05, weight = 50 * M_PI * R * R * 9.81;
  for (const auto scheme : {Scheme::event_driven, Scheme::moreau_jean}) {
    const bool events = scheme == Scheme::event_driven;
    const char* const by = events ? "event-driven" : "Moreau–Jean, h = 1e-4 s";
    const char* solved =
        "contact problems are solved to 1e-10 of the greatest rate of a step, "
        "a disc's weight is at least 0.1 of "
        "it, margin of a thousand";
    test::LastForces forces;
    force_claims::run(scene_of(test::pile({{R, R + 0.01, R}, {R, 3 * R + 0.02, R}, {R, 5 * R + 0.05, R}},
                                          2 * R, 0, 0, 0.3, 1),
                               scheme),
                      Family::nonsmooth, {&forces});
    const struct {
      const char *contact, *quantity;
      int discs;  ///< above the contact
    } loads[] = {{"floor0", "normal force on the floor", 3},
                 {"c0_1", "normal force between lower and middle disc", 2},
                 {"c1_2", "normal force between middle and upper disc", 1}};
    for (const auto& load : loads)
      f.relative(claim_name("stack of three discs in a channel one disc wide", load.quantity, by), "N",
                 forces.normal(load.contact), load.discs * weight, 1e-6, "weight of the discs above", solved);
    force_claims::run(
        scene_of(test::pile({{0.5, R, R}, {0.5 + 2 * R, R, R}, {0.5 + R, R + std::sqrt(3) * R, R}}, 2, 0, 0.5,
                            0, 0.2),
                 scheme),
        Family::nonsmooth, {&forces});
    for (const bool left : {true, false})
      f.relative(
          claim_name("pyramid of three discs, friction 0.5",
                     left ? "normal force on the floor, left" : "normal force on the floor, right", by),
          "N", forces.normal(left ? "floor0" : "floor1"), 1.5 * weight, 1e-6,
          "half of three weights: the pile is symmetric and at rest, since 0.5 > tan 15°", solved);
    const char* const random = "random piles of 4 to 6 discs";
    int stopped = 0;
    double closure = 0, inside = 0;
    for (unsigned seed = 1; seed <= 6; ++seed) {
      const auto r = test::simulate(scene_of(test::random_pile(seed), scheme), Family::nonsmooth);
      stopped += r.ending.status != Ending::Status::finished;
      closure = greatest(closure, std::abs(r.ledger.closure()) / std::abs(r.ledger.initial));
      for (const double depth : r.extremes.penetration) inside = greatest(inside, depth);
    }
    f.at_most(claim_name(random, "runs of 6 that do not finish", by), "", stopped, 0,
              "0; friction 0 to 0.3, restitution 0.1 to 0.6", "exact");
    f.at_most(claim_name(random, "greatest error of the energy balance over the initial energy", by), "",
              closure, 1e-6, "energy balance with the losses of contact, friction and projection",
              "tolerance of a step, 1e-7 at most, margin of ten");
    f.at_most(claim_name(random, "greatest penetration", by), "m", inside, events ? 1e-9 : 2e-4, "0",
              events ? "rounding, and the position correction of neighbouring contacts"
                     : "2 m/s in a step of 1e-4 s");
  }
}

}  // namespace freeplay::verification
