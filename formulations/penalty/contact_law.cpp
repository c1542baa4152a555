#include "formulations/penalty/contact_law.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <numbers>

namespace freeplay {
namespace {

constexpr double pi = std::numbers::pi;

constexpr LawFacts facts[] = {
    {ContactLaw::hertz, "hertz", "χ = 0", "Hertz, J. reine angew. Math. 92 (1882) 156",
     "e = 1 only: no damping"},
    {ContactLaw::hunt_crossley, "hunt-crossley", "χ = 3(1 − e)/2",
     "Hunt, Crossley, J. Appl. Mech. 42 (1975) 440", "e near 1"},
    {ContactLaw::herbert_mcwhannell, "herbert-mcwhannell", "χ = 6(1 − e)/[(2e − 1)² + 3]",
     "Herbert, McWhannell, J. Eng. Ind. 99 (1977) 671", "e near 1"},
    {ContactLaw::lee_wang, "lee-wang", "χ = 3(1 − e)/4",
     "Lee, Wang, J. Mech. Transm. Autom. Des. 105 (1983) 534", "e near 1"},
    {ContactLaw::lankarani_nikravesh, "lankarani-nikravesh", "χ = 3(1 − e²)/4",
     "Lankarani, Nikravesh, J. Mech. Des. 112 (1990) 369", "e near 1; never delivers less than 0.663"},
    {ContactLaw::gonthier, "gonthier", "χ = (1 − e²)/e",
     "Gonthier et al., Multibody Syst. Dyn. 11 (2004) 209", "0 < e ≤ 1"},
    {ContactLaw::zhiying_qishao, "zhiying-qishao", "χ = ¾(1 − e²) exp[2(1 − e)]", "Zhiying, Qishao (2006)",
     "0.3 ≤ e ≤ 1"},
    {ContactLaw::flores, "flores", "χ = 8(1 − e)/(5e)", "Flores et al., Multibody Syst. Dyn. 25 (2011) 357",
     "0 < e ≤ 1"},
    {ContactLaw::hu_guo, "hu-guo", "χ = 3(1 − e)/(2e)", "Hu, Guo, Multibody Syst. Dyn. 35 (2015) 131",
     "0 < e ≤ 1"},
    {ContactLaw::carvalho_martins, "carvalho-martins", "χ = 3(1 − e)(11 − e)/[2(1 + 9e)]",
     "Carvalho, Martins, Mech. Mach. Theory 139 (2019) 174", "0 ≤ e ≤ 1"},
    {ContactLaw::exact, "exact", "χ(1 + e) = ln[(1 + χ)/(1 − χe)]", "first integral of a free impact",
     "0 < e ≤ 1"},
    {ContactLaw::kelvin_voigt, "kelvin-voigt", "F = Kδ + Dδ̇ ≥ 0", "linear spring and damper",
     "teaching contrast: force jumps at entry"},
    {ContactLaw::johnson, "johnson", "δ = f [ln(4ΔR/f) − 1]", "Johnson, Contact Mechanics (1985)",
     "δ < 0.541 ΔR"},
    {ContactLaw::esdu, "esdu-78035", "δ = f [ln(4ΔR/f) + 1]", "ESDU 78035 (1978)", "δ < 4 ΔR"},
    {ContactLaw::radzimovsky, "radzimovsky", "δ = f [⅔ + ln(4R_i/b) + ln(4R_j/b)]",
     "Radzimovsky, Univ. Illinois Bull. 408 (1953)", "δ < 0.716 ΔR; b is the full width of contact"},
    {ContactLaw::liu, "liu", "F = (π/2) L E* δ √(δ/[2(ΔR + δ)])", "Liu et al. (2005)", "all δ"},
    {ContactLaw::persson, "persson", "F = E*ΔRLπb²(b²+1)/[2−ln(b²+1)−2b⁴]",
     "Persson (1964); Ciavarella, Decuzzi (2001)", "δ < 10.09 ΔR; like materials"},
    {ContactLaw::pereira, "pereira", "F = [(0.965ΔR + 0.0965)LE*/ΔR] δⁿ (mm, N)",
     "Pereira, Ramalho, Ambrósio (2011)", "0.005 mm ≤ ΔR < 10 mm"},
};

/// Exponent of Pereira, Ramalho and Ambrósio for a clearance in mm.
double pereira_exponent(double mm) {
  const double Y = mm < 0.34954 ? 1.51 * std::pow(std::log(1000 * mm), -0.151) : 0.0151 * mm + 1.151;
  return Y * std::pow(mm, -0.005);
}

[[noreturn]] void missing(const std::string& key, const char* why) {
  throw ModelError(key, fmt::format("is missing: {}", why));
}

}  // namespace

std::span<const LawFacts> contact_laws() { return facts; }

const LawFacts& facts_of(ContactLaw law) { return *std::ranges::find(facts, law, &LawFacts::law); }

bool is_point_law(ContactLaw law) { return law <= ContactLaw::exact; }

double hertz_stiffness(double young, double poisson, double radius) {
  return 4.0 / 3.0 * young / (2 * (1 - poisson * poisson)) * std::sqrt(radius);
}

ContactForce make_contact_force(const Scene& scene, const ContactFacts& contact) {
  const auto& o = scene.penalty;
  const auto& surface = contact.surface;
  const auto key = [&](const char* name) { return fmt::format("surfaces.{}.{}", surface.name, name); };
  ContactForce law;
  if (o.contact == ContactLaw::kelvin_voigt) {
    if (!o.kelvin_stiffness) missing("penalty.kelvin_stiffness", "\"kelvin-voigt\" takes K (N/m) from it");
    if (!o.kelvin_damping) missing("penalty.kelvin_damping", "\"kelvin-voigt\" takes D (N s/m) from it");
    law.elastic = {ElasticLaw::Kind::linear, *o.kelvin_stiffness, 1, contact.clearance, 0};
    law.viscous = *o.kelvin_damping;
    return law;
  }
  if (!surface.young) missing(key("young"), "a penalty contact takes its stiffness from it");
  const double modulus = *surface.young / (2 * (1 - *surface.poisson * *surface.poisson));
  const double c = contact.clearance;
  if (is_point_law(o.contact)) {
    if (!(contact.radius > 0))
      missing(fmt::format("{} (radius or corner_radius)", contact.name),
              "a penalty contact of a sharp corner has no stiffness");
    law.elastic.stiffness = hertz_stiffness(*surface.young, *surface.poisson, contact.radius);
  } else {
    if (!contact.ring)
      throw ModelError("penalty.contact",
                       fmt::format("\"{}\" is a law of journals in bearings, \"{}\" is none; use a point law "
                                   "such as \"exact\"",
                                   facts_of(o.contact).name, contact.name));
    if (!contact.bearing_length)
      missing(fmt::format("joints.{}.bearing_length", contact.name), "a line contact's force grows with it");
    const double length = *contact.bearing_length, line = pi * modulus * length;
    using Kind = ElasticLaw::Kind;
    switch (o.contact) {
      case ContactLaw::johnson:
        law.elastic = {Kind::logarithmic, line, 1, c, -1};
        break;
      case ContactLaw::esdu:
        law.elastic = {Kind::logarithmic, line, 1, c, 1};
        break;
      case ContactLaw::radzimovsky:
        law.elastic = {Kind::logarithmic, line, 1, c, 2.0 / 3 - std::log(4)};
        break;
      case ContactLaw::liu:
        law.elastic = {Kind::liu, line / 2, 1.5, c, 0};
        break;
      case ContactLaw::persson:
        law.elastic = {Kind::persson, line, 1, c, 0};
        break;
      default: {
        // Units of the source: mm, N, MPa. K (N/mmⁿ) · (1000 δ)ⁿ.
        const double mm = 1e3 * c, n = pereira_exponent(mm);
        const double K = (0.965 * mm + 0.0965) * (1e3 * length) * (1e-6 * modulus) / mm;
        law.elastic = {Kind::power, K * std::pow(1e3, n), n, c, 0};
      }
    }
  }
  const bool needs = o.contact != ContactLaw::hertz && !(o.damping && *o.damping == ContactLaw::hertz);
  if (!needs) return law;
  if (!surface.restitution) missing(key("restitution"), "a penalty contact takes its damping from it");
  ContactLaw damping = o.contact;
  if (!is_point_law(o.contact))
    damping = o.damping.value_or(o.contact == ContactLaw::pereira ? ContactLaw::lankarani_nikravesh
                                                                  : ContactLaw::exact);
  law.chi = damping_factor(damping, *surface.restitution);
  return law;
}

double elastic_duration(const ElasticLaw& law, double mass, double speed) {
  // Greatest depth from U(δ) = ½ m v²; a force ∝ δⁿ then lasts √π Γ(1 + 1/(n+1))/Γ(½ + 1/(n+1)) · 2 δ/v… with
  // the local exponent n = δ F/U − 1.
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
