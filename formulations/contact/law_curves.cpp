#include "formulations/contact/law_curves.hpp"

#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>

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

/// Whether all laws have the same curves in both contacts.
bool alike(const ContactFacts& a, const ContactFacts& b) {
  const auto facts = [](const ContactFacts& c) {
    return std::tie(c.has_clearance, c.clearance, c.radius, c.radius_bearing, c.radius_journal, c.stiffness,
                    c.bearing_length, c.surface.name);
  };
  return facts(a) == facts(b);
}

ContactImpacts impacts_in(const Scene& scene, const ContactFacts& contact, const ImpactSetting& setting) {
  ContactImpacts found{.contacts = {contact.name},
                       .restitution = contact.surface.slow_restitution().value_or(1)};
  for (const auto& law : contact_laws()) {
    if (law.kind == ContactKind::line && !contact.bearing_length) continue;
    if (law.layered && !contact.surface.layer_modulus) continue;
    if (law.kind == ContactKind::spring_damper &&
        !(scene.penalty.kelvin_stiffness && scene.penalty.kelvin_damping))
      continue;
    Scene one = scene;
    one.penalty.contact = law.law;
    const auto force = make_contact_force(one, contact);
    LawImpact result{.law = law.text};
    found.impacts.push_back({law.text, impact(force, setting, result)});
    result.outside = result.depth > 0.5 * force.elastic.limit() ||
                     (contact.has_clearance &&
                      (contact.clearance < law.least_clearance || contact.clearance >= law.clearance_end));
    found.results.push_back(result);
  }
  return found;
}

}  // namespace

LawCurves law_curves(const Scene& scene, const ImpactSetting& setting) {
  const System system(scene.mechanism);
  if (system.reported() == 0)
    throw ModelError(
        "", "has no contact and thus no contact law: no joint has clearance, and there are no [contacts]");
  LawCurves curves;
  std::vector<int> first;  // contact of each group
  for (int k = 0; k < system.reported(); ++k) {
    const auto& contact = system.contact_facts(k);
    const auto same =
        std::ranges::find_if(first, [&](int other) { return alike(system.contact_facts(other), contact); });
    if (same != first.end()) {
      curves.groups[static_cast<std::size_t>(same - first.begin())].contacts.push_back(contact.name);
      continue;
    }
    first.push_back(k);
    curves.groups.push_back(impacts_in(scene, contact, setting));
  }
  for (const auto& law : contact_laws())
    if (law.kind == ContactKind::point) curves.delivered.push_back(delivered(law));
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
