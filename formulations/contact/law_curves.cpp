#include "formulations/contact/law_curves.hpp"

#include <algorithm>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <cmath>

#include "dynamics/system.hpp"
#include "formulations/contact/contact_law.hpp"
#include "formulations/contact/friction_comparison.hpp"
#include "formulations/contact/friction_law.hpp"
#include "mechanism/laws.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

using Pair = std::array<double, 2>;  // δ, δ̇

/// Integrates m δ̈ = −F(δ, δ̇) from contact onset to separation, in about 2000 steps.
std::vector<Pair> impact(const ContactForce& law, const ImpactSetting& s) {
  const double h = elastic_duration(law.elastic, s.mass, s.speed) / 500;
  const auto force = [&](const Pair& y) {
    return y[0] > 0 ? law.force(y[0], law.elastic.force(y[0]), y[1], s.speed) : 0;
  };
  const auto side = [&](const Pair& y, Pair& d, double) {
    d[0] = y[1];
    d[1] = -force(y) / s.mass;
  };
  boost::numeric::odeint::runge_kutta4<Pair> stepper;
  Pair y{0, s.speed};
  std::vector<Pair> points{{0, law.viscous * s.speed}};
  for (int i = 0; i < 20000; ++i) {
    stepper.do_step(side, y, i * h, h);
    if (!(y[0] > 0)) break;
    points.push_back({y[0], force(y)});
  }
  points.push_back({0, 0});
  return points;
}

/// If the scene has no spring and damper: the spring that stores the impact energy at Hertz's
/// depth, with the damper that delivers e for an unclamped force.
void choose_spring_damper(Scene& scene, const ContactFacts& contact, const ImpactSetting& s) {
  auto& o = scene.penalty;
  if (o.kelvin_stiffness && o.kelvin_damping) return;
  Scene hertz = scene;
  hertz.penalty.contact = ContactLaw::hertz;
  const double K = make_contact_force(hertz, contact).elastic.stiffness;
  const double depth = std::pow(1.25 * s.mass * s.speed * s.speed / K, 0.4);
  o.kelvin_stiffness = s.mass * s.speed * s.speed / (depth * depth);
  const double log_e = std::log(std::max(1e-3, contact.surface.restitution.value_or(1)));
  const double zeta = -log_e / std::hypot(3.14159265358979, log_e);
  o.kelvin_damping = 2 * zeta * std::sqrt(*o.kelvin_stiffness * s.mass);
}

LawCurve delivered(const ContactLawFacts& law) {
  LawCurve curve{law.text, {}};
  for (int i = 1; i <= 50; ++i)
    curve.points.push_back({0.02 * i, delivered_restitution(damping_factor(law.law, 0.02 * i))});
  return curve;
}

/// c/μ from −5 to 5 times `scale` (m/s).
LawCurve friction(const FrictionLawFacts& facts, PenaltyOptions options, double scale) {
  options.friction = facts.law;
  const auto law = make_friction(options, 1);  // μ = 1, so that the curve is c/μ
  LawCurve curve{facts.text, {}};
  for (int k = -200; k <= 200; ++k) {
    const double v = 5e-2 * scale * k / 2;
    curve.points.push_back({v, law.steady(v)});
  }
  return curve;
}

}  // namespace

LawCurves law_curves(const Scene& scene, const ImpactSetting& setting) {
  const System system(scene.mechanism);
  if (system.contacts() == 0) throw ModelError("", "has no joint with clearance and thus no contact law");
  const auto& contact = system.contact_facts(0);

  LawCurves curves;
  curves.contact = contact.name;
  curves.restitution = contact.surface.restitution.value_or(1);
  for (const auto& law : contact_laws()) {
    if (law.kind == ContactKind::line && !contact.bearing_length) continue;
    Scene one = scene;
    one.penalty.contact = law.law;
    if (law.kind == ContactKind::spring_damper) choose_spring_damper(one, contact, setting);
    curves.impacts.push_back({law.text, impact(make_contact_force(one, contact), setting)});
    if (law.kind == ContactKind::point) curves.delivered.push_back(delivered(law));
  }
  const auto& given = scene.penalty;
  for (const auto& law : friction_laws()) {
    const auto& speed = setting.regularisation;
    const auto options = speed ? regularised(law, given, *speed) : given;
    if (options)
      curves.friction.push_back(
          friction(law, *options, speed ? *speed : std::max(given.friction_v1, given.friction_v0)));
  }
  return curves;
}

}  // namespace freeplay
