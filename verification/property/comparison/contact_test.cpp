// Penalty contacts in a mechanism: prediction of a free impact with the effective mass, contacts
// that begin at rest, grazing contacts, and a start inside the wall.
#include "formulations/contact/contact_law.hpp"
#include "verification/references/delivered_restitution.hpp"
#include "verification/references/impact_tables.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {
/// A pendulum at rest on a pivot with clearance, its pin at the lowest point of the bearing,
/// displaced by `lift` upwards.
Scene hanging(double lift) {
  auto scene = read_scene(test::scene_file("pendulum"));
  auto& body = scene.mechanism.bodies[0];
  body.angle = -1.5707963267948966;
  // The pin is 0.15 m above the centre of mass; the bearing's centre is the origin, its clearance
  // 0.5 mm.
  body.position = Vec2(0, -0.15 - 0.5e-3 + lift);
  scene.run.start = RunOptions::Start::given;
  scene.run.duration = 0.05;
  scene.run.discard = 0;
  return scene;
}
}  // namespace

TEST_CASE("a contact that begins at rest settles, in both formulations", "[contact]") {
  auto scene = hanging(0);
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    CAPTURE(family == Family::penalty);
    const auto run = test::finished(scene, family);
    // The weight compresses the contact by (mg/K)^(2/3) = 1e-7 m; no displacement exceeds a few
    // times that.
    CHECK(run.contacts[0].penetration < 1e-6);
    CHECK(run.ledger.kinetic < 1e-6);
    CHECK(run.contacts[0].lasting_fraction > 0.95);
  }
}

TEST_CASE("a start inside the wall is a contact from the first instant", "[contact]") {
  // 2 µm inside: Hertz's energy 0.4 K δ^2.5 accelerates the journal upwards; its energy must not
  // exceed that.
  auto scene = hanging(-2e-6);
  const auto run = test::finished(scene, Family::penalty);
  const double K = hertz_stiffness(207e9, 0.3, 10e-3 * 9.5e-3 / 0.5e-3),
               stored = 0.4 * K * std::pow(2e-6, 2.5);
  CHECK(run.ledger.initial - 0.471 * 9.81 * (-0.15 - 0.5e-3 - 2e-6) == Approx(stored).epsilon(1e-6));
  CHECK(run.ledger.kinetic < stored);
  CHECK(std::abs(run.ledger.closure()) < 1e-6 * stored);
}

TEST_CASE("a journal that only grazes the wall is handled", "[contact]") {
  // Started upwards from the bottom so that it just reaches the top: v² = 2 g (2c), a little less,
  // exactly that, and a little more.
  for (double factor : {1 - 1e-9, 1.0, 1 + 1e-12, 1 + 1e-9, 1 + 1e-6}) {
    auto scene = hanging(1e-9);
    scene.mechanism.bodies[0].velocity = Vec2(0, std::sqrt(2 * 9.81 * (1e-3 - 1e-9) * factor));
    scene.mechanism.surfaces[0].friction.reset();
    CAPTURE(factor);
    const auto run = test::finished(scene, Family::penalty);
    CHECK(std::abs(run.ledger.closure()) < 1e-6 * run.ledger.scale());
  }
}
