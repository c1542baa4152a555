// Tangential compliance of contacts: the force law "mindlin" of the penalty formulation and the
// impact law "compliant" of the event-driven scheme, on oblique impacts of a sphere.
#include "verification/references/tangential_compliance.hpp"
#include "dynamics/system.hpp"
#include "formulations/contact/contact_law.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/compliant_impact.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

/// The sphere of Kharaz et al. on its plane, with both laws of tangential compliance.
struct Sphere {
  Scene scene = read_scene(test::source_folder() / "cases/kharaz2001/scene.toml");
  double radius = 2.5e-3, speed = 3.9;

  Sphere() {
    scene.penalty.friction = FrictionLaw::mindlin;
    scene.penalty.integrator = Integrator::dopri5;
    scene.penalty.tolerance = 1e-12;
    scene.nonsmooth.scheme = Scheme::event_driven;
    scene.nonsmooth.impact_law = ImpactLaw::compliant;
  }
  const Surface& surface() const { return scene.mechanism.surfaces[0]; }
  reference::Delassus<long double> delassus() const {
    const auto& b = scene.mechanism.bodies[0];
    return {1 / b.mass, 0, 1 / b.mass + radius * radius / b.inertia};
  }
  long double normal(double degrees) const { return -speed * std::cos(degrees * M_PI / 180); }
  long double tangential(double degrees) const { return speed * std::sin(degrees * M_PI / 180); }
  /// Velocity of the contact point along the plane after an impact at this angle, over that before.
  double restitution(Family family, double degrees) {
    scene.mechanism.bodies[0].velocity = {static_cast<double>(tangential(degrees)),
                                          static_cast<double>(normal(degrees))};
    const auto v = test::simulate(scene, family).final_state.v;
    return (v[0] + radius * v[2]) / static_cast<double>(tangential(degrees));
  }
};

/// Angles of incidence (degrees): stick at the start, slip that ends, and slip throughout.
constexpr double angles[] = {1, 5, 10, 20, 30, 45, 60};

std::string name(double degrees, const char* how) {
  return claim_name("oblique impact of a sphere",
                    fmt::format("tangential velocity after over before, {:g}°", degrees), how);
}

/// Compares impacts at two restitutions with impact(sphere, e, u_n, u_t), the reference for these
/// rates.
template <class Reference>
void compare_with(Findings& f, Family family, const char* how, double bound, const char* source,
                  const char* reason, const Reference& impact) {
  Sphere sphere;
  for (const double e : {0.98, 0.5}) {
    sphere.scene.mechanism.surfaces[0].restitution = e;
    for (const double angle : angles) {
      const long double u_t = sphere.tangential(angle);
      const auto exact = impact(sphere, e, sphere.normal(angle), u_t);
      f.within(name(angle, fmt::format("{}, e = {:g}", how, e).c_str()), "",
               sphere.restitution(family, angle), static_cast<double>(exact.u_t / u_t), bound, source,
               reason);
    }
  }
}

void impulse_map(Findings& f) {
  compare_with(f, Family::nonsmooth, "event-driven, compliant law", 1e-11,
               "references/compliant_impact: slip in closed form, stick by its modes, long double",
               "rounding of a few hundred terms, over the least tangential velocity",
               [](const Sphere& sphere, double e, long double u_n, long double u_t) {
                 const auto& surface = sphere.surface();
                 return reference::compliant_impact<long double>(sphere.delassus(), u_n, u_t, e,
                                                                 *surface.friction, stiffness_ratio(surface));
               });
}

void force_law(Findings& f) {
  compare_with(f, Family::penalty, "penalty, Hertz contact", 1e-6,
               "references/tangential_compliance: long double, order 8",
               "tolerance 1e-12 of the greatest speed and force, at kinks and over the least "
               "tangential velocity",
               [](const Sphere& sphere, double, long double u_n, long double u_t) {
                 const auto& surface = sphere.surface();
                 const double chi =
                     make_contact_force(sphere.scene, System(sphere.scene.mechanism).contact_facts(0)).chi;
                 return reference::hertz_mindlin_impact<long double>(
                     sphere.delassus(), u_n, u_t, chi, *surface.friction, stiffness_ratio(surface));
               });
}

void one_contact_in_both(Findings& f) {
  // A linear contact without damping is the contact of the impulse map, and the ball alone moves:
  // its D is constant during the contact.
  Sphere sphere;
  sphere.scene.mechanism.surfaces[0].restitution = 1;
  for (auto& contact : sphere.scene.mechanism.contacts)
    if (auto* plane = std::get_if<PlaneContact>(&contact)) plane->stiffness = 1e7;
  for (const double angle : angles) {
    const long double u_t = sphere.tangential(angle);
    const auto exact = reference::compliant_impact<long double>(sphere.delassus(), sphere.normal(angle), u_t,
                                                                1, *sphere.surface().friction,
                                                                stiffness_ratio(sphere.surface()));
    for (const auto family : {Family::penalty, Family::nonsmooth}) {
      const bool penalty = family == Family::penalty;
      f.within(name(angle, penalty ? "penalty, linear contact, e = 1" : "event-driven, compliant law, e = 1"),
               "", sphere.restitution(family, angle), static_cast<double>(exact.u_t / u_t),
               penalty ? 1e-6 : 1e-11, "references/compliant_impact: both formulations have these springs",
               penalty ? "tolerance 1e-12 of the greatest speed and force, at kinks"
                       : "rounding of a few hundred terms, over the least tangential velocity");
    }
  }
}

void elastic_sphere(Findings& f) {
  // ν = 0.25 and e = 1. ψ = κ u_T/(μ u_N⁻) before and after. The laws have no slip in a part of the
  // contact area; how far this takes them from the elastic sphere is a result, not an error.
  Sphere sphere;
  auto& surface = sphere.scene.mechanism.surfaces[0];
  surface.restitution = 1;
  surface.stiffness_ratio = 2 * 0.75 / 1.75;
  const double kappa = *surface.stiffness_ratio, mu = *surface.friction, chi = 7 * kappa / 4;
  const double bound = 1e-5;
  for (const double psi : {0.5, 1.0, 2.0, 3.0, 4.0, 6.0}) {
    const double angle = std::atan(psi * mu / kappa) * 180 / M_PI;
    const double sphere_psi = reference::maw_barber_fawcett(psi, chi);
    const long double u_n = sphere.normal(angle), u_t = sphere.tangential(angle);
    const auto d = sphere.delassus();
    const auto claim = [&](Family family, const char* how, long double after) {
      f.within(claim_name("elastic sphere of Maw, Barber and Fawcett",
                          fmt::format("deviation of ψ after the impact, ψ = {:g} before", psi), how),
               "", psi * sphere.restitution(family, angle) - sphere_psi,
               psi * static_cast<double>(after / u_t) - sphere_psi, bound,
               "references of the law and maw_barber_fawcett (1000 annuli that slip one by one)",
               "error of the annuli, 2e-6, margin of five");
    };
    claim(Family::nonsmooth, "event-driven, compliant law",
          reference::compliant_impact<long double>(d, u_n, u_t, 1, mu, kappa).u_t);
    claim(Family::penalty, "penalty, one spring",
          reference::hertz_mindlin_impact<long double>(d, u_n, u_t, 0, mu, kappa).u_t);
  }
}

}  // namespace

Parts tangential_compliance() { return {impulse_map, force_law, one_contact_in_both, elastic_sphere}; }

}  // namespace freeplay::verification
