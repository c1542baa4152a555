#include "formulations/contact/contact_law.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

#include "formulations/contact/contact_parts.hpp"
#include "generated/contact_laws.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

constexpr double pi = std::numbers::pi;

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
  if (!surface.young)
    missing(surface_key(contact, "young"), "a penalty contact computes its stiffness from it");
  if (!contact.ring)
    throw ModelError("penalty.contact",
                     fmt::format("\"{}\" is a law for journal bearings, and \"{}\" is not one; use a point "
                                 "law such as \"exact\"",
                                 facts_of(law).text, contact.name));
  if (!contact.bearing_length)
    missing(fmt::format("joints.{}.bearing_length", contact.name), "a line contact's force grows with it");
  const double modulus = *surface.young / (2 * (1 - *surface.poisson * *surface.poisson));
  const LineContact line{modulus, *contact.bearing_length, contact.clearance};
  return visit_law(law, [&](auto l) -> ElasticLaw {
    if constexpr (l.kind == ContactKind::line) return l.elastic(line);
    return {};
  });
}

/// The point law from which a contact law takes its χ.
ContactLaw damping_of(const PenaltyOptions& o) {
  const auto& own = facts_of(o.contact).damping;
  return own ? o.damping.value_or(*own) : o.contact;
}

/// χ of a point or line contact.
double damping(const PenaltyOptions& o, const ContactFacts& contact) {
  const auto law = damping_of(o);
  if (!facts_of(law).takes_restitution) return 0;
  const auto& restitution = contact.surface.restitution;
  if (!restitution)
    missing(surface_key(contact, "restitution"), "a penalty contact computes its damping from it");
  return damping_factor(law, *restitution);
}

}  // namespace

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
  law.chi = damping(o, contact);
  return law;
}

double elastic_duration(const ElasticLaw& law, double mass, double speed) {
  // The greatest depth follows from U(δ) = ½ m v². With F ∝ δⁿ the duration is √π Γ(1 +
  // 1/(n+1))/Γ(½ + 1/(n+1)) · 2 δ/v; the local exponent is n = δ F/U − 1.
  const double kinetic = 0.5 * mass * speed * speed;
  double hi = std::min(1e-9, 0.5 * law.limit());
  while (law.energy(hi) < kinetic && 2 * hi < law.limit()) hi *= 2;
  if (!(law.energy(hi) >= kinetic)) return 2 * hi / speed;
  std::uintmax_t most = 60;
  const auto [a, b] =
      boost::math::tools::toms748_solve([&](double d) { return law.energy(d) - kinetic; }, 0.0, hi,
                                        boost::math::tools::eps_tolerance<double>(40), most);
  const double depth = 0.5 * (a + b), p = depth * law.force(depth) / kinetic;  // p = n + 1
  return 2 * depth / speed * std::sqrt(pi) * std::tgamma(1 + 1 / p) / std::tgamma(0.5 + 1 / p);
}

}  // namespace freeplay
