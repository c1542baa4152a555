// The contact law of an elastic foundation: its resultant against quadrature of the pressure and against its
// limit at small penetrations, its free impact, and scenes that it refuses.
#include <boost/math/quadrature/gauss_kronrod.hpp>

#include "formulations/contact/contact_law.hpp"
#include "simulation/bearing_pressure.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// ∫ f(p, φ) dφ over the contact for c = 1, with p = (1 + δ) cos φ − 1 without cancellation.
template <class F>
double over_contact(double depth, const F& f) {
  // 1 − cos α = δ/(1 + δ)
  const double alpha = 2 * std::asin(std::sqrt(0.5 * depth / (1 + depth)));
  const auto at = [&](double phi) {
    return f(depth * std::cos(phi) - 2 * std::sin(0.5 * phi) * std::sin(0.5 * phi), phi);
  };
  return boost::math::quadrature::gauss_kronrod<double, 61>::integrate(at, -alpha, alpha, 10, 1e-15);
}

/// The ring with a layer, and its contact law.
Scene layered_ring() {
  auto scene = read_scene(test::scene_file("ring"));
  scene.penalty.contact = ContactLaw::elastic_foundation;
  std::get<RevoluteJoint>(scene.mechanism.joints[0]).clearance->bearing_length = 0.02;
  auto& s = scene.mechanism.surfaces[0];
  s.layer_modulus = 2e9, s.layer_poisson = 0.4, s.layer_thickness = 1e-3;
  return scene;
}

}  // namespace

TEST_CASE("the elastic foundation's force, slope and energy equal integrals of the pressure", "[laws]") {
  // On both sides of the change from the series to the closed form, tan α = 0.5 at δ = 0.118.
  for (const double depth : {1e-9, 1e-6, 1e-3, 0.05, 0.117, 0.119, 0.5, 2.0, 30.0}) {
    CAPTURE(depth);
    // Rounding: up to 180 ε in the closed form of the energy at the change, 4e-14.
    CHECK(RoundFoundation::force(depth) ==
          Approx(over_contact(depth, [](double p, double phi) { return p * std::cos(phi); })).epsilon(1e-12));
    CHECK(RoundFoundation::slope(depth) == Approx(over_contact(depth, [](double, double phi) {
                                             return std::cos(phi) * std::cos(phi);
                                           })).epsilon(1e-12));
    CHECK(RoundFoundation::energy(depth) ==
          Approx(over_contact(depth, [](double p, double) { return 0.5 * p * p; })).epsilon(1e-12));
  }
  CHECK(RoundFoundation::force(0) == 0);
  CHECK(RoundFoundation::energy(0) == 0);
}

TEST_CASE("the elastic foundation approaches a parabola's resultant with an error of first order", "[laws]") {
  // δ − c φ²/2 has the resultant (2/3) (2δ/c)^(3/2) in units of K L R_b c. Of the next order, by hand:
  // −0.65 δ/c.
  const auto error = [](double depth) {
    return std::abs(RoundFoundation::force(depth) / (2.0 / 3 * std::pow(2 * depth, 1.5)) - 1);
  };
  test::check_order({1e-2, 3e-3, 1e-3, 3e-4, 1e-4}, error, 0.97, 1.03);
  CHECK(error(1e-5) == Approx(0.65e-5).epsilon(1e-3));
}

TEST_CASE("the law of the elastic foundation takes its stiffness from the layer", "[laws]") {
  auto scene = layered_ring();
  const auto law = make_contact_force(scene, test::first_contact(scene)).elastic;
  // K = (1 − ν) E/[(1 + ν)(1 − 2ν) t] in plane strain, with c = 1 mm, R_b = 20 mm, L = 20 mm.
  const double K = 0.6 * 2e9 / (1.4 * 0.2 * 1e-3), scale = K * 0.02 * 0.02;
  const double c = 1e-3;
  for (const double depth : {1e-6, 1e-4, 3e-3}) {
    CHECK(law.force(depth) ==
          Approx(scale * c * over_contact(depth / c, [](double p, double phi) { return p * std::cos(phi); }))
              .epsilon(1e-12));
    // central differences: h² F‴/F ~ 1e-10, rounding 1e-11
    const double h = 1e-5 * depth;
    CHECK(law.slope(depth) == Approx((law.force(depth + h) - law.force(depth - h)) / (2 * h)).epsilon(1e-8));
  }
  CHECK(std::isinf(law.limit()));
}

TEST_CASE("a free impact on an elastic foundation delivers its restitution", "[laws]") {
  auto scene = layered_ring();
  scene.mechanism.surfaces[0].friction.reset();
  scene.mechanism.surfaces[0].restitution = 0.46;
  scene.mechanism.bodies[0].angular_velocity = 0;
  scene.mechanism.bodies[1].position = {0, 0};
  scene.mechanism.bodies[1].velocity = {0.3, 0};
  scene.mechanism.bodies[1].angular_velocity = 0;
  scene.run.duration = 0.01;
  scene.penalty.integrator = Integrator::dopri5;
  scene.penalty.tolerance = 1e-12;
  const auto run = test::simulate(scene, Family::penalty);
  const auto touch = test::touch(run, 0);
  // of a tolerance of 1e-12 a step, as of the other laws
  CHECK(-touch.v_n_plus / touch.v_n_minus == Approx(0.46).epsilon(0).margin(1e-7));
  CHECK(std::abs(run.ledger.closure()) < 1e-8 * run.ledger.scale());
}

TEST_CASE("the elastic foundation is refused where it has no bearing or no layer", "[laws]") {
  const auto said = [](const std::vector<std::string>& sets) {
    auto all = sets;
    all.emplace_back("penalty.contact=elastic-foundation");
    return test::refusal_of([&] { test::simulate(read_scene(test::flores(), all), Family::penalty); });
  };
  CHECK_THAT(said({}), Contains("joints.gudgeon.bearing_length: is missing"));
  CHECK_THAT(said({"joints.gudgeon.bearing_length=0.02"}),
             Contains("surfaces.steel.layer_modulus: is missing"));
  CHECK_THAT(said({"surfaces.steel.layer_modulus=2e9"}),
             Contains("surfaces.steel.layer_modulus: layer_modulus, "));
  CHECK_THAT(said({"surfaces.steel.layer_poisson=0.5"}),
             Contains("surfaces.steel.layer_poisson: must be less than"));
  CHECK_THAT(said({"joints.gudgeon.bearing_length=0.02", "surfaces.steel.layer_modulus=2e9",
                   "surfaces.steel.layer_poisson=0.4", "surfaces.steel.layer_thickness=1e-3",
                   "joints.guide.clearance=1e-4", "joints.guide.slider_length=0.1",
                   "joints.guide.slider_height=0.05", "joints.guide.surface=steel"}),
             Contains("\"elastic-foundation\" is a law for journal bearings, and \"guide"));
}
