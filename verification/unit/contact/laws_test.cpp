// Every contact and friction law: delivered restitution against the bisection of the reference,
// line contacts against each other and their definitions, friction laws at the ends of their zones.
#include "mechanism/laws.hpp"
#include "formulations/contact/contact_law.hpp"
#include "formulations/contact/friction_law.hpp"
#include "formulations/contact/law_curves.hpp"
#include "verification/references/delivered_restitution.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

constexpr double modulus = 207e9 / (2 * (1 - 0.3 * 0.3)), length = 0.02, c = 0.25e-3;

Scene steel(ContactLaw law) {
  auto scene = read_scene(test::flores());
  scene.penalty.contact = law;
  std::get<RevoluteJoint>(scene.mechanism.joints[2]).clearance->bearing_length = length;
  auto& surface = scene.mechanism.surfaces[0];
  surface.layer_modulus = 2e9, surface.layer_poisson = 0.4, surface.layer_thickness = 1e-3;
  return scene;
}
ContactForce force_of(ContactLaw law) {
  const auto scene = steel(law);
  return make_contact_force(scene, test::first_contact(scene));
}

}  // namespace

TEST_CASE("contact laws have the damping factors of the reference, e = 0.1 ... 0.9", "[laws]") {
  for (const auto& row : reference::delivered_table) {
    const auto law = std::ranges::find(contact_laws(), std::string_view(row.name), &ContactLawFacts::text);
    REQUIRE(law != contact_laws().end());
    for (int i = 1; i <= 9; ++i) {
      const double e = 0.1 * i, chi = damping_factor(law->law, e);
      CAPTURE(row.name, e);
      REQUIRE(chi == Approx(row.chi(e)).epsilon(1e-14));
    }
  }
  for (int i = 1; i <= 9; ++i)
    REQUIRE(exact_damping_factor(0.1 * i) ==
            Approx(static_cast<double>(reference::exact_chi(0.1 * i))).epsilon(1e-10));
}

TEST_CASE("the exact law delivers the required restitution, also near 0 and 1", "[laws]") {
  for (double e : {1e-3, 0.01, 0.05, 0.2, 0.46, 0.8, 0.99, 0.9985, 0.999, 0.9995, 0.9999, 0.999999, 1 - 1e-11,
                   1 - 1e-15}) {
    CAPTURE(e);
    const double chi = exact_damping_factor(e);
    // For χ → 0 the equation's root has a condition number of 1/χ: the bound is rounding over χ.
    REQUIRE(delivered_restitution(chi) == Approx(e).epsilon(1e-12 + 1e-15 / chi));
  }
  REQUIRE(exact_damping_factor(1) == 0);
  REQUIRE(delivered_restitution(0) == 1);
  REQUIRE_THROWS_AS(damping_factor(ContactLaw::exact, 0), ModelError);
  REQUIRE_THROWS_AS(damping_factor(ContactLaw::flores, 0), ModelError);
}

TEST_CASE("the stiffness is that of equation (4) of the paper", "[laws]") {
  // Flores et al. 2011, equation (4) with E = 207 GPa, ν = 0.3, R_i = 11.125 mm: five printed
  // digits.
  const double c[] = {0.10e-3, 0.25e-3, 0.50e-3, 1.00e-3};
  const double K[] = {1.6795e11, 1.0550e11, 7.373e10, 5.090e10};
  for (int i = 0; i < 4; ++i)
    REQUIRE(hertz_stiffness(207e9, 0.3, 11.125e-3 * (11.125e-3 - c[i]) / c[i]) == Approx(K[i]).epsilon(1e-4));
}

TEST_CASE("preloaded friction is regularised", "[laws]") {
  REQUIRE(preloaded_friction(10, 1e-3, 5e-4) == Approx(-5));
  REQUIRE(preloaded_friction(10, 1e-3, -1.0) == 10);
}

TEST_CASE("every point contact law delivers the first integral of its damping factor", "[laws]") {
  // A free impact on the ring, with χ of the law derived from the run: integration at 1e-12 a step
  // of a ratio of speeds.
  auto scene = read_scene(test::scene_file("ring"));
  scene.mechanism.surfaces[0].friction.reset();
  scene.mechanism.surfaces[0].restitution = 0.46;
  scene.mechanism.bodies[0].angular_velocity = 0;
  scene.mechanism.bodies[1].position = {0, 0};
  scene.mechanism.bodies[1].velocity = {0.3, 0};
  scene.mechanism.bodies[1].angular_velocity = 0;
  scene.run.duration = 0.005;
  scene.penalty.integrator = Integrator::dopri5;
  scene.penalty.tolerance = 1e-12;
  for (const auto& law : contact_laws()) {
    CAPTURE(law.text);
    if (law.kind != ContactKind::point) {
      CHECK_THROWS_AS(damping_factor(law.law, 0.5), ModelError);
      continue;
    }
    for (int i = 1; i <= 10; ++i) {
      const double chi = damping_factor(law.law, 0.1 * i);
      REQUIRE(chi >= 0);
      REQUIRE(delivered_restitution(chi) ==
              Approx(static_cast<double>(reference::delivered_restitution(chi))).margin(1e-9).epsilon(0));
    }
    if (law.positive_restitution)
      CHECK_THROWS_AS(damping_factor(law.law, 0), ModelError);
    else
      CHECK(std::isfinite(damping_factor(law.law, 0)));
    scene.penalty.contact = law.law;
    const auto run = test::simulate(scene, Family::penalty);
    const auto touch = test::touch(run, 0);
    const double e = static_cast<double>(reference::delivered_restitution(damping_factor(law.law, 0.46)));
    CHECK(-touch.v_n_plus / touch.v_n_minus == Approx(e).margin(1e-7));
    CHECK(run.contacts[0].model.restitution_delivered == Approx(e).margin(1e-9));
  }
}

TEST_CASE("the laws of Johnson and ESDU differ by the sign of the one", "[laws]") {
  const auto johnson = force_of(ContactLaw::johnson).elastic, esdu = force_of(ContactLaw::esdu).elastic;
  const double line = 3.14159265358979323846 * modulus * length;
  for (double F : {1.0, 1e2, 1e4, 5e5}) {  // Johnson ends at 9.7e5 N here
    const double f = F / line, logarithm = std::log(4 * c / f);
    // δ from the definition, then F back through the law: rounding times the condition of the
    // logarithm.
    CHECK(johnson.force(f * (logarithm - 1)) == Approx(F).epsilon(1e-12));
    CHECK(esdu.force(f * (logarithm + 1)) == Approx(F).epsilon(1e-12));
  }
  // Radzimovsky: ⅔ + ln(4R_i/b) + ln(4R_j/b) with b = 2√(4FR/(πE*L)), R = R_i R_j/ΔR.
  const double Ri = 11.125e-3, Rj = Ri - c, F = 1e4;
  const double b = 2 * std::sqrt(4 * F * Ri * Rj / c / line);
  const double delta = F / line * (2.0 / 3 + std::log(4 * Ri / b) + std::log(4 * Rj / b));
  CHECK(force_of(ContactLaw::radzimovsky).elastic.force(delta) == Approx(F).epsilon(1e-12));
}

// Hertz's line contact with the half width a = R ε has F = π E* L a²/(4 R_eff), R_eff = R²/ΔR, thus
// π E* L ΔR ε²/4. Persson's load differs from it by terms of order ε².
TEST_CASE("persson has Hertz's load at small contact angles", "[laws]") {
  const auto law = force_of(ContactLaw::persson);
  for (const double angle : {0.02, 0.04}) {
    const double depth = c * (1 / std::cos(angle) - 1);
    const double hertz = std::numbers::pi * modulus * length * c * angle * angle / 4;
    CAPTURE(angle);
    CHECK(std::abs(law.elastic.force(depth) / hertz - 1) < angle * angle);
  }
}

TEST_CASE("line contacts: monotonic force, stated limit, and energy as the integral of the force", "[laws]") {
  for (const auto& law : contact_laws()) {
    if (law.kind == ContactKind::spring_damper) continue;
    const auto elastic = force_of(law.law).elastic;
    CAPTURE(law.text);
    const double top = std::min(elastic.limit(), 4 * c);
    double before = 0;
    for (double x = 1e-6; x < 0.8; x += 0.0499) {  // at the limit the slope is infinite
      const double d = x * top, F = elastic.force(d);
      REQUIRE(F > before);
      before = F;
      // Central difference of the energy: h² F''/F ~ (h/d)², h/d = 1e-4; rounding ε d/h = 1e-12.
      const double h = 1e-4 * d;
      REQUIRE((elastic.energy(d + h) - elastic.energy(d - h)) / (2 * h) == Approx(F).epsilon(1e-6));
    }
    if (std::isfinite(elastic.limit())) REQUIRE(std::isnan(elastic.force(elastic.limit() * 1.001)));
  }
}

TEST_CASE("Pereira's exponent is continuous at its transition, and its limits are reported", "[laws]") {
  const auto at = [](double mm) {
    auto scene = steel(ContactLaw::pereira);
    std::get<RevoluteJoint>(scene.mechanism.joints[2]).clearance->radial = 1e-3 * mm;
    return make_contact_force(scene, test::first_contact(scene)).elastic.exponent;
  };
  // The source gives 1.1563 on both sides (five digits, times ΔR^−0.005 = 1.00527).
  REQUIRE(at(0.349539) == Approx(1.1563 * std::pow(0.34954, -0.005)).epsilon(1e-4));
  REQUIRE(at(0.349541) == Approx(at(0.349539)).epsilon(1e-4));
  auto scene = steel(ContactLaw::pereira);
  scene.run.duration = 1e-4;
  scene.run.discard = 0;
  std::get<RevoluteJoint>(scene.mechanism.joints[2]).clearance->radial = 2e-6;
  const auto run = test::simulate(scene, Family::penalty);
  REQUIRE_FALSE(run.notes.empty());
  CHECK_THAT(run.notes.back(), Contains("outside its valid range"));
}

TEST_CASE("friction laws are odd, and continuous at the ends of their zones", "[laws]") {
  PenaltyOptions o;
  o.friction_static = 1.4;
  o.friction_viscous = 2;
  for (const auto& law : friction_laws()) {
    if (law.bristle || law.compliant) continue;
    o.friction = law.law;
    const auto f = make_friction(o, 0.2);
    for (double v : {1e-5, 1e-4, 5e-4, 1e-3, 5e-3, 0.1}) {
      CHECK(f.coefficient(v, f.zone(v), 0) == Approx(-f.coefficient(-v, f.zone(-v), 0)).margin(1e-15));
      CHECK(f.coefficient(v, f.zone(v), 0) >= 0);
      const auto [low, high] = f.ends(f.zone(v));
      CHECK(v >= low);
      CHECK(v <= high);
    }
    for (int zone : {-2, -1, 0, 1}) {
      const double end = f.ends(zone).high;
      if (!std::isfinite(end) || f.zone(end - 1e-9) != zone) continue;
      CAPTURE(law.text, zone);
      CHECK(f.coefficient(end, zone, 0) == Approx(f.coefficient(end, f.zone(end + 1e-12), 0)).margin(1e-12));
    }
  }
  // Steady sliding of LuGre: ż = 0 gives c = μ + (μ_s − μ) e^(−(v/v₀)²) + σ₂ v.
  o.friction = FrictionLaw::lugre;
  const auto f = make_friction(o, 0.2);
  const double v = 3e-4, g = (0.2 + 0.08 * std::exp(-9.0)) / 1e5;
  CHECK(f.bristle_rate(v, 1, g) == Approx(0).margin(1e-18));
  CHECK(f.coefficient(v, 1, g) == Approx(1e5 * g + 2 * v));
}

TEST_CASE("friction laws agree in the mechanism at fast sliding", "[laws][friction]") {
  // First impact of the reference scene: sliding at 0.03 to 0.04 m/s throughout, far above every
  // regularising speed, so that each law gives μ F_N. LuGre's bristles need a distance of
  // g = μ/σ₀ = 1e-7 m, of a sliding distance of 8e-6 m, to build up.
  auto scene = test::read_short(test::flores(), 0.006);
  for (const auto& law : friction_laws()) {
    scene.penalty.friction = law.law;
    const auto run = test::simulate(scene, Family::penalty);
    const auto e = test::touch(run, 0);
    CAPTURE(law.text);
    const double mu = law.law == FrictionLaw::threlfall ? 0.01 * (1 - std::exp(-3.0)) : 0.01;
    CHECK(-e.impulse_t / e.impulse_n == Approx(mu).epsilon(law.bristle ? 0.05 : 1e-6));
    CHECK(std::abs(run.ledger.closure()) < 1e-7 * run.ledger.scale());
  }
}

// Friction laws at the same regularisation speed, against the inverse of each law's formula.

TEST_CASE("each friction law reaches 95 % of kinetic friction at the regularisation speed", "[laws]") {
  const double v = 3e-3;
  const PenaltyOptions o;
  // c(v) = 0.95 μ solved for v₀, or for v₁ with v₀ = 0; bisection to rounding.
  const auto v0 = [&](FrictionLaw law) {
    const auto found = regularised(facts_of(law), o, v);
    REQUIRE(found);
    CHECK(make_friction(*found, 1).steady(v) == Approx(0.95).epsilon(1e-12));
    CHECK(regularisation_speed(facts_of(law), *found).value_or(0) == Approx(v).epsilon(1e-12));
    return law == FrictionLaw::ambrosio ? found->friction_v1 : found->friction_v0;
  };
  CHECK(v0(FrictionLaw::ambrosio) == Approx(v / 0.95));
  CHECK(v0(FrictionLaw::threlfall) == Approx(3 * v / std::log(20)));
  CHECK(v0(FrictionLaw::bengisu_akay) == Approx(v / (1 - std::sqrt(0.05))));
  CHECK(v0(FrictionLaw::brown_mcphee) == Approx(4 * v / std::atanh(0.95)));
  CHECK(v0(FrictionLaw::andersson) == Approx(v / std::atanh(0.95)));
  for (const auto law : {FrictionLaw::lugre, FrictionLaw::mindlin}) {
    CHECK_FALSE(regularised(facts_of(law), o, v));
    CHECK_FALSE(regularisation_speed(facts_of(law), o));
  }
  // Creep under half of the kinetic friction.
  const auto creep = [&](FrictionLaw law) {
    return creep_speed(facts_of(law), regularised(facts_of(law), o, v).value_or(o), 0.5);
  };
  CHECK(creep(FrictionLaw::ambrosio) == Approx(0.5 / 0.95 * v));
  CHECK(creep(FrictionLaw::threlfall) == Approx(std::log(2) / std::log(20) * v));
  CHECK(creep(FrictionLaw::andersson) == Approx(std::atanh(0.5) / std::atanh(0.95) * v));
}

TEST_CASE("with static friction the regularisation speed is the first at which 95 % are reached", "[laws]") {
  PenaltyOptions o;
  o.friction_static = 1.5;
  // 1.5 [1 − (x − 1)²] = 0.95 with x < 1.
  const auto found = regularised(facts_of(FrictionLaw::bengisu_akay), o, 1e-3);
  REQUIRE(found);
  CHECK(found->friction_v0 == Approx(1e-3 / (1 - std::sqrt(1 - 0.95 / 1.5))));
}
