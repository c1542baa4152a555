#include "formulations/contact/contact_law.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

#include "generated/contact_laws.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "numerics/bracketed_root.hpp"
#include "simulation/bearing_pressure.hpp"

namespace freeplay {
namespace {

[[noreturn]] void missing(const std::string& key, std::string_view why) {
  throw ModelError(key, fmt::format("is missing: {}", why));
}

ContactForce spring_damper(const PenaltyOptions& o, const ContactFacts& contact) {
  const auto name = facts_of(o.contact).text;
  if (!o.kelvin_stiffness)
    missing("penalty.kelvin_stiffness", fmt::format("\"{}\" needs it as K (N/m)", name));
  if (!o.kelvin_damping) missing("penalty.kelvin_damping", fmt::format("\"{}\" needs it as D (N s/m)", name));
  ContactForce law;
  law.elastic = visit_law(o.contact, [&](auto l) -> ElasticLaw {
    if constexpr (l.kind == ContactKind::spring_damper)
      return l.elastic(*o.kelvin_stiffness, contact.clearance);
    return {};
  });
  law.viscous = *o.kelvin_damping;
  return law;
}

std::string surface_key(const ContactFacts& contact, const char* name) {
  return fmt::format("surfaces.{}.{}", contact.surface.name, name);
}

/// Law of a contact with a given stiffness, such as bending teeth and end stops.
ElasticLaw linear_elastic(double stiffness) {
  ElasticLaw elastic;
  elastic.kind = ElasticLaw::Kind::linear;
  elastic.stiffness = stiffness;
  elastic.exponent = 1;
  return elastic;
}

/// The key from which a contact without stiffness could take one. A contact's name is that of a
/// joint or contact, with its part after a dot.
std::string curvature_key(const Scene& scene, const std::string& contact) {
  const auto name = contact.substr(0, contact.find('.'));
  for (const auto& joint : scene.mechanism.joints)
    if (name_of(joint) == name) return fmt::format("joints.{}.corner_radius", name);
  for (const auto& c : scene.mechanism.contacts)
    if (name_of(c) == name) return fmt::format("contacts.{}.stiffness", name);
  return contact;
}

ElasticLaw point_elastic(const Scene& scene, const ContactFacts& contact) {
  if (contact.stiffness) return linear_elastic(*contact.stiffness);
  for (const auto& joint : scene.mechanism.joints)  // a ratio has no geometry from which it follows
    if (std::holds_alternative<RatioJoint>(joint) && contact.name.starts_with(name_of(joint) + "."))
      missing(fmt::format("joints.{}.mesh_stiffness", name_of(joint)),
              "a penalty contact of a ratio computes its force from it");
  const auto& surface = contact.surface;
  if (!surface.young)
    missing(surface_key(contact, "young"), "a penalty contact computes its stiffness from it");
  if (!(contact.radius > 0))
    missing(curvature_key(scene, contact.name),
            "a penalty contact of a sharp corner needs it as stiffness (N/m)");
  ElasticLaw elastic;
  elastic.stiffness = hertz_stiffness(*surface.young, *surface.poisson, contact.radius);
  return elastic;
}

ElasticLaw line_elastic(ContactLaw law, const ContactFacts& contact) {
  if (contact.stiffness) return linear_elastic(*contact.stiffness);
  const auto& surface = contact.surface;
  const bool layered = facts_of(law).layered;
  if (!layered && !surface.young)
    missing(surface_key(contact, "young"), "a penalty contact computes its stiffness from it");
  if (!contact.ring)
    throw ModelError("penalty.contact",
                     fmt::format("\"{}\" is a law for journal bearings, and \"{}\" is not one; use a point "
                                 "law such as \"exact\"",
                                 facts_of(law).text, contact.name));
  if (!contact.bearing_length)
    missing(fmt::format("joints.{}.bearing_length", contact.name.substr(0, contact.name.find('.'))),
            "a line contact's force grows with it");
  if (layered && !surface.layer_modulus)
    missing(surface_key(contact, "layer_modulus"),
            fmt::format("\"{}\" needs it, layer_poisson and layer_thickness as the stiffness of the layer",
                        facts_of(law).text));
  const double modulus = layered ? 0 : *surface.young / (2 * (1 - *surface.poisson * *surface.poisson));
  const LineContact line{modulus, *contact.bearing_length, contact.clearance, contact.radius_bearing,
                         layer_stiffness(surface)};
  return visit_law(law, [&](auto l) -> ElasticLaw {
    if constexpr (l.kind == ContactKind::line) return l.elastic(line);
    return {};
  });
}

/// Sets χ of a point or line contact.
void set_damping(ContactForce& force, const PenaltyOptions& o, const ContactFacts& contact) {
  const auto law = damping_of(o);
  if (!facts_of(law).takes_restitution) return;
  const auto restitution = contact.surface.slow_restitution();
  if (!restitution)
    missing(surface_key(contact, "restitution"), "a penalty contact computes its damping from it");
  force.chi = damping_factor(law, *restitution);
  if (contact.surface.restitution_by_speed()) force.by_speed.emplace(law, contact.surface);
}

}  // namespace

ContactLaw damping_of(const PenaltyOptions& o) {
  const auto& own = facts_of(o.contact).damping;
  return own ? o.damping.value_or(*own) : o.contact;
}

DampingBySpeed::DampingBySpeed(ContactLaw law, const Surface& surface) : law_(law), surface_(&surface) {
  for (const auto& [speed, e] : surface.restitution_table) damping_factor(law, e);
}

double DampingBySpeed::operator()(double v0) const {
  if (v0 != v0_) {
    chi_ = damping_factor(law_, surface_->restitution_at(v0));
    v0_ = v0;
  }
  return chi_;
}

/// dχ/dv₀, by a difference of ∛ε within 0 ≤ e ≤ 1.
double DampingBySpeed::slope(double v0) const {
  const double by_speed = surface_->restitution_slope(v0);
  if (by_speed == 0) return 0;
  const double e = surface_->restitution_at(v0), h = 6e-6 * std::max(e, 0.01);
  const double low = e - std::min(h, 0.5 * e), high = std::min(1.0, e + h);
  return (damping_factor(law_, high) - damping_factor(law_, low)) / (high - low) * by_speed;
}

double hertz_stiffness(double young, double poisson, double radius) {
  return 4.0 / 3.0 * young / (2 * (1 - poisson * poisson)) * std::sqrt(radius);
}

double stiffness_ratio(const Surface& surface) {
  if (surface.stiffness_ratio) return *surface.stiffness_ratio;
  if (!surface.poisson)
    missing(fmt::format("surfaces.{}.stiffness_ratio", surface.name),
            "a law of tangential compliance needs it, or young and poisson");
  return 2 * (1 - *surface.poisson) / (2 - *surface.poisson);
}

ContactForce make_contact_force(const Scene& scene, const ContactFacts& contact) {
  const auto& o = scene.penalty;
  ContactForce law;
  if (o.own) {
    law.elastic.kind = ElasticLaw::Kind::own;
    law.elastic.outside = o.own.get();
    law.elastic.contact = contact.name.c_str();
    return law;
  }
  switch (facts_of(o.contact).kind) {
    case ContactKind::spring_damper:
      return spring_damper(o, contact);
    case ContactKind::point:
      law.elastic = point_elastic(scene, contact);
      break;
    case ContactKind::line:
      law.elastic = line_elastic(o.contact, contact);
      break;
  }
  set_damping(law, o, contact);
  return law;
}

double elastic_duration(const ElasticLaw& law, double mass, double speed) {
  // The greatest depth follows from U(δ) = ½ m v². With F ∝ δⁿ the duration is √π Γ(1 +
  // 1/(n+1))/Γ(½ + 1/(n+1)) · 2 δ/v; the local exponent is n = δ F/U − 1.
  const double kinetic = 0.5 * mass * speed * speed;
  double hi = std::min(1e-9, 0.5 * law.limit());
  while (law.energy(hi) < kinetic && 2 * hi < law.limit()) hi *= 2;
  if (!(law.energy(hi) >= kinetic)) return 2 * hi / speed;
  const double depth = bracketed_root([&](double d) { return law.energy(d) - kinetic; }, 0.0, hi, {40, 60}),
               p = depth * law.force(depth) / kinetic;  // p = n + 1
  return 2 * depth / speed * std::sqrt(std::numbers::pi) * std::tgamma(1 + 1 / p) / std::tgamma(0.5 + 1 / p);
}

// Damping factors χ(e) and the restitution that they deliver; contact_law.hpp has the equation.

namespace {

/// Near e = 1 the terms of the equation cancel. The series of the equation, divided by χ²,
///     (1 − e²)/2 − χ(1 + e³)/3 + χ²(1 − e⁴)/4 − χ³(1 + e⁵)/5 + χ⁴(1 − e⁶)/6 = 0,
/// is used there. For 1 − e or χ below 1e-3 the truncation error is 1e-15 of the leading term.
constexpr double series_below = 1e-3;
double series(double chi, double e) {
  const double e2 = e * e, e3 = e2 * e;
  return (1 - e) * (1 + e) / 2 -
         chi * ((1 + e3) / 3 - chi * ((1 - e) * (1 + e) * (1 + e2) / 4 -
                                      chi * ((1 + e3 * e2) / 5 - chi * (1 - e3) * (1 + e3) / 6)));
}
/// Newton's method with the series' leading derivatives: ∂/∂χ ≈ −(1 + e³)/3, ∂/∂e ≈ −e.
double chi_by_series(double e) {
  double chi = 1.5 * (1 - e) * (1 + e) / (1 + e * e * e);
  for (int i = 0; i < 6; ++i) chi += 3 * series(chi, e) / (1 + e * e * e);
  return chi;
}
double restitution_by_series(double chi) {
  double e = 1 - 2 * chi / 3;
  for (int i = 0; i < 12; ++i) e += series(chi, e) / e;
  return e;
}

}  // namespace

double delivered_restitution(double chi) {
  if (chi == 0) return 1;
  if (chi < series_below) return restitution_by_series(chi);
  // With y = ln(1 − χê) the equation is (1 − e^y) + χ + y = ln(1 + χ), monotone in y < 0 and well
  // conditioned for any χ.
  const double log_chi = std::log1p(chi);
  const auto f = [&](double y) { return chi - std::expm1(y) + y - log_chi; };
  // f < 0 at y = ln(1 + χ) − χ − 2 and f > 0 at 0; near χ = 0 the root tends to −χ.
  const double y = bracketed_root(f, log_chi - chi - 2, 0, {52, 200});
  return -std::expm1(y) / chi;
}

double exact_damping_factor(double restitution) {
  const double e = restitution;
  if (e >= 1) return 0;
  if (1 - e < series_below) return chi_by_series(e);
  // With y = ln(1 − χe), χ = (1 − e^y)/e. The bracket excludes the trivial root y = 0.
  const auto f = [&](double y) {
    const double chi = -std::expm1(y) / e;
    return chi * (1 + e) - std::log1p(chi) + y;
  };
  // Near y = 0, χ ≈ −y/e and f ≈ χ²(1 − e²)/2 > 0; for large −y, y dominates and f < 0.
  double near = -e * (1 - e);
  while (f(near) <= 0) near *= 0.5;
  double far = -(1 + 1 / e) * 2;
  while (f(far) >= 0) far *= 2;
  return -std::expm1(bracketed_root(f, far, near, {52, 200})) / e;
}

double damping_factor(ContactLaw law, double restitution) {
  const auto& facts = facts_of(law);
  if (facts.positive_restitution && !(restitution > 0))
    throw ModelError(
        "penalty.contact",
        fmt::format("\"{}\" needs a restitution greater than 0: its damping factor is infinite at 0",
                    facts.text));
  return visit_law(law, [&](auto l) -> double {
    if constexpr (l.kind == ContactKind::point) return l.chi(restitution);
    throw ModelError("penalty.damping", fmt::format("\"{}\" has no damping factor of its own", facts.text));
  });
}

}  // namespace freeplay
