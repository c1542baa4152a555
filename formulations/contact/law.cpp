#include "formulations/contact/law.hpp"

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/math/tools/roots.hpp>

#include "generated/contact_laws.hpp"
#include "generated/friction_laws.hpp"
#include "simulation/bearing_pressure.hpp"

namespace freeplay {

// Elastic laws of contacts: force, stiffness and energy as functions of the penetration δ.
// law.hpp has the equations.

namespace {

/// Placed after a switch that handles every case.
[[noreturn]] inline void unreachable() { __builtin_unreachable(); }

/// Solves δ = f [ln(A/f) + B] for f on its rising branch, f < A e^(B − 1), by Newton's method
/// within a bracket.
double logarithmic_root(double delta, double A, double B) {
  if (delta == 0) return 0;
  const double top = A * std::exp(B - 1);
  const auto g = [&](double f) {
    const double bracket = std::log(A / f) + B;
    return std::pair{f * bracket - delta, bracket - 1};
  };
  const double guess = delta / std::max(1.5, std::log(A / delta) + B);
  std::uintmax_t most = 100;
  return boost::math::tools::newton_raphson_iterate(g, std::min(guess, 0.5 * top), guess * 1e-6, top, 52,
                                                    most);
}

}  // namespace

bool ElasticLaw::is_power() const {
  switch (kind) {
    case Kind::hertz:
    case Kind::power:
    case Kind::linear:
      return true;
    case Kind::logarithmic:
    case Kind::liu:
    case Kind::persson:
    case Kind::foundation:
    case Kind::own:
      return false;
  }
  unreachable();
}

double ElasticLaw::limit() const {
  switch (kind) {
    case Kind::hertz:
    case Kind::power:
    case Kind::linear:
    case Kind::liu:
    case Kind::foundation:
    case Kind::own:
      return std::numeric_limits<double>::infinity();
    case Kind::logarithmic:
      return 4 * clearance * std::exp(offset - 1);  // maximum of δ(f): dδ/df = 0, δ = f
    case Kind::persson: {
      // The denominator 2 − ln(b² + 1) − 2b⁴ vanishes at b² = 0.83462…, the limit of full conformal
      // contact, where the force is infinite.
      constexpr double b2 = 0.834615245477657;
      return 2 * clearance * b2 / (1 - b2);
    }
  }
  unreachable();
}

double ElasticLaw::other_force(double delta) const {
  switch (kind) {
    case Kind::hertz:
      return stiffness * delta * std::sqrt(delta);
    case Kind::power:
      return stiffness * std::pow(delta, exponent);
    case Kind::linear:
      return stiffness * delta;
    case Kind::logarithmic:
      if (!(delta < limit())) return std::numeric_limits<double>::quiet_NaN();
      return stiffness * logarithmic_root(delta, 4 * clearance, offset);
    case Kind::liu:
      return stiffness * delta * std::sqrt(delta / (2 * (clearance + delta)));
    case Kind::persson: {
      if (!(delta < limit())) return std::numeric_limits<double>::quiet_NaN();
      const double b2 = delta / (2 * clearance + delta);
      return stiffness * clearance * b2 * (b2 + 1) / (2 - std::log1p(b2) - 2 * b2 * b2);
    }
    case Kind::foundation:
      return stiffness * RoundFoundation::force(delta / clearance);
    case Kind::own:
      return delta > 0 ? own_force(delta, 0, 1) : 0;
  }
  unreachable();
}

double ElasticLaw::own_force(double delta, double rate, double v0) const {
  const double f = outside->force(outside->context.get(), contact, delta, rate, v0);
  return f < 0 ? 0 : f;  // a NaN stays NaN
}

double ElasticLaw::slope(double delta) const {
  switch (kind) {
    case Kind::hertz:
      return 1.5 * stiffness * std::sqrt(delta);
    case Kind::power:
      return exponent * stiffness * std::pow(delta, exponent - 1);
    case Kind::linear:
      return stiffness;
    case Kind::logarithmic: {
      // dF/dδ = K/(dδ/df) with dδ/df = ln(A/f) + B − 1. At δ = 0, dδ/df is infinite and the slope
      // is zero.
      if (!(delta > 0 && delta < limit())) return delta == 0 ? 0 : std::numeric_limits<double>::quiet_NaN();
      const double f = logarithmic_root(delta, 4 * clearance, offset);
      return stiffness / (std::log(4 * clearance / f) + offset - 1);
    }
    case Kind::liu: {
      const double s = clearance + delta;
      return stiffness * std::sqrt(delta / (2 * s)) * (1 + 0.5 * clearance / s);
    }
    case Kind::persson: {
      if (!(delta < limit())) return std::numeric_limits<double>::quiet_NaN();
      const double s = 2 * clearance + delta, b2 = delta / s;
      const double top = b2 * (b2 + 1), bottom = 2 - std::log1p(b2) - 2 * b2 * b2;
      const double by_b2 = ((2 * b2 + 1) * bottom + top * (1 / (1 + b2) + 4 * b2)) / (bottom * bottom);
      return stiffness * clearance * by_b2 * 2 * clearance / (s * s);
    }
    case Kind::foundation:
      return stiffness / clearance * RoundFoundation::slope(delta / clearance);
    case Kind::own: {
      const double h = 6e-6 * delta;
      return delta > 0 ? (force(delta + h) - force(delta - h)) / (2 * h) : 0;
    }
  }
  unreachable();
}

double ElasticLaw::energy(double delta) const {
  if (!(delta > 0)) return 0;
  switch (kind) {
    case Kind::hertz:
      return 0.4 * force(delta) * delta;
    case Kind::power:
      return force(delta) * delta / (exponent + 1);
    case Kind::linear:
      return 0.5 * force(delta) * delta;
    case Kind::logarithmic: {
      // ∫ F (dδ/df) df with dδ/df = ln(A/f) + B − 1.
      const double f = force(delta) / stiffness;
      return stiffness * f * f * (0.5 * (std::log(4 * clearance / f) + offset - 1) + 0.25);
    }
    case Kind::foundation:
      return stiffness * clearance * RoundFoundation::energy(delta / clearance);
    case Kind::liu:
    case Kind::persson:
    case Kind::own: {
      // With δ = s² the integrand is smooth at zero.
      const auto g = [&](double s) { return 2 * s * force(s * s); };
      return boost::math::quadrature::gauss_kronrod<double, 31>::integrate(g, 0.0, std::sqrt(delta), 5,
                                                                           1e-13);
    }
  }
  unreachable();
}

// Tables of all laws, generated from the enumerators; the file of each law has its row.

namespace {

template <ScopedEnum E, class Facts, class F>
constexpr auto table(F row) {
  return each_enumerator<E, std::array<Facts, static_cast<std::size_t>(enumerators<E>())>>(row);
}

constexpr auto all_contact_laws = table<ContactLaw, ContactLawFacts>([](auto law) {
  using L = Law<law()>;
  return ContactLawFacts{.law = law(),
                         .text = L::text,
                         .formula = L::formula,
                         .source = L::source,
                         .range = L::range,
                         .kind = L::kind,
                         .takes_restitution = L::takes_restitution,
                         .positive_restitution = L::positive_restitution,
                         .damping = L::damping,
                         .least_clearance = L::least_clearance,
                         .clearance_end = L::clearance_end,
                         .layered = L::layered};
});

constexpr auto all_friction_laws = table<FrictionLaw, FrictionLawFacts>([](auto law) {
  using L = Law<law()>;
  return FrictionLawFacts{.law = law(),
                          .text = L::text,
                          .formula = L::formula,
                          .source = L::source,
                          .range = L::range,
                          .keys = L::keys,
                          .bristle = L::bristle,
                          .compliant = L::compliant,
                          .positive_v0 = L::positive_v0,
                          .v1_above_v0 = L::v1_above_v0,
                          .stribeck = L::stribeck != nullptr};
});

/// Law names are unique.
constexpr bool distinct(const auto& laws) {
  for (std::size_t i = 0; i < laws.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (laws[i].text == laws[j].text) return false;
  return true;
}
static_assert(distinct(all_contact_laws) && distinct(all_friction_laws));

/// A line law takes its damping factor from a point law.
constexpr bool damped_by_point_laws() {
  for (const auto& l : all_contact_laws)
    if (l.damping && all_contact_laws[static_cast<std::size_t>(*l.damping)].kind != ContactKind::point)
      return false;
  return true;
}
static_assert(damped_by_point_laws());

}  // namespace

std::span<const ContactLawFacts> contact_laws() { return all_contact_laws; }
const ContactLawFacts& facts_of(ContactLaw law) { return all_contact_laws[static_cast<std::size_t>(law)]; }

std::span<const FrictionLawFacts> friction_laws() { return all_friction_laws; }
const FrictionLawFacts& facts_of(FrictionLaw law) { return all_friction_laws[static_cast<std::size_t>(law)]; }

}  // namespace freeplay
