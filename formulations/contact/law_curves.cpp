#include "formulations/contact/law_curves.hpp"

#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>

#include <algorithm>
#include <cmath>

#include "dynamics/system.hpp"
#include "formulations/contact/contact_law.hpp"
#include "formulations/contact/friction_law.hpp"
#include "mechanism/options.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

/// c/μ of steady sliding.
double share_at(const FrictionLawFacts& law, PenaltyOptions o, double speed) {
  o.friction = law.law;
  return make_friction(o, 1).steady(speed);
}

/// The least x > 0 with f(x) ≥ `level`, from 2⁻⁶⁰ to 2⁶⁰ times `scale`, on a grid of 32 points an
/// octave that bisection refines to rounding; infinite if there is none.
double first_reach(const auto& f, double scale, double level) {
  constexpr int octaves = 60, points = 32;
  const auto x = [&](int n) { return scale * std::exp2(static_cast<double>(n) / points); };
  for (int n = -octaves * points; n <= octaves * points; ++n) {
    if (!(f(x(n)) >= level)) continue;
    double low = x(n - 1), high = x(n);
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (f(middle) >= level ? high : low) = middle;
    }
    return high;
  }
  return INFINITY;
}

}  // namespace

std::optional<PenaltyOptions> regularised(const FrictionLawFacts& law, const PenaltyOptions& options,
                                          double speed) {
  if (law.bristle || law.compliant) return {};
  auto o = options;
  o.friction = law.law;
  o.friction_viscous = 0;  // not part of the regularisation
  if (law.v1_above_v0) o.friction_v0 = 0;
  double& key = law.v1_above_v0 ? o.friction_v1 : o.friction_v0;
  // The steeper the law, the smaller its speed: the least 1/key that reaches the share.
  const double inverse = first_reach(
      [&](double x) {
        key = 1 / x;
        return share_at(law, o, speed);
      },
      1 / speed, regularised_share);
  if (!std::isfinite(inverse)) return {};
  key = 1 / inverse;
  o.friction_viscous = options.friction_viscous;
  return o;
}

std::optional<double> regularisation_speed(const FrictionLawFacts& law, const PenaltyOptions& options) {
  if (law.bristle || law.compliant) return {};
  auto o = options;
  o.friction_viscous = 0;
  const double scale = std::max(o.friction_v0, law.v1_above_v0 ? o.friction_v1 : 0);
  const double speed = first_reach([&](double v) { return share_at(law, o, v); }, scale, regularised_share);
  return std::isfinite(speed) ? std::optional(speed) : std::nullopt;
}

double creep_speed(const FrictionLawFacts& law, const PenaltyOptions& options, double share) {
  if (law.bristle || law.compliant) return 0;
  const double scale = std::max(options.friction_v0, law.v1_above_v0 ? options.friction_v1 : 0);
  return first_reach([&](double v) { return share_at(law, options, v); }, scale, share);
}

namespace {

using Pair = std::array<double, 2>;  // δ, δ̇

/// Integrates m δ̈ = −F(δ, δ̇) from contact onset to separation, in about 2000 steps.
std::vector<Pair> impact(const ContactForce& law, const ImpactSetting& s, LawImpact& result) {
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
    result.duration = (i + 1) * h;
    result.restitution = -y[1] / s.speed;
    if (!(y[0] > 0)) {
      if (y[1] < 0) result.duration -= y[0] / y[1];  // beyond separation
      break;
    }
    points.push_back({y[0], force(y)});
  }
  for (const auto& [depth, f] : points) {
    result.depth = std::max(result.depth, depth);
    result.force = std::max(result.force, f);
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
  const double log_e = std::log(std::max(1e-3, contact.surface.slow_restitution().value_or(1)));
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
  curves.restitution = contact.surface.slow_restitution().value_or(1);
  for (const auto& law : contact_laws()) {
    if (law.kind == ContactKind::line && !contact.bearing_length) continue;
    Scene one = scene;
    one.penalty.contact = law.law;
    if (law.kind == ContactKind::spring_damper) choose_spring_damper(one, contact, setting);
    const auto force = make_contact_force(one, contact);
    LawImpact result{.law = law.text};
    curves.impacts.push_back({law.text, impact(force, setting, result)});
    result.outside = result.depth > 0.5 * force.elastic.limit() ||
                     (contact.has_clearance &&
                      (contact.clearance < law.least_clearance || contact.clearance >= law.clearance_end));
    curves.results.push_back(result);
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
