// freeplay laws: lists the contact laws, evaluates them for a scene and writes their curves, or
// reports the steady running of a lubricated joint.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/default_folder.hpp"
#include "cli/film_report.hpp"
#include "cli/verb.hpp"
#include "formulations/contact/contact_law.hpp"
#include "formulations/contact/friction_comparison.hpp"
#include "formulations/contact/friction_law.hpp"
#include "formulations/contact/law_curves.hpp"
#include "formulations/make.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/open_scene.hpp"
#include "mechanism/error.hpp"
#include "mechanism/laws.hpp"
#include "mechanism/scene.hpp"
#include "plots/drawing/figure.hpp"
#include "values/table.hpp"

namespace freeplay::cli {
namespace {

struct LawsRequest : Request {
  std::string scene;
  std::optional<double> restitution;
  std::vector<std::string> overrides;
  double mass = 1;                       ///< kg, effective mass of the impact that is drawn
  double speed = 0.1;                    ///< m/s, its approach speed
  bool friction = false;                 ///< compare friction laws at one regularisation speed
  std::optional<double> regularisation;  ///< m/s, that speed
  FilmRequest film;                      ///< of a lubricated joint
  std::string output;                    ///< result folder
};

std::string csv(const char* header, const std::vector<LawCurve>& curves) {
  Table table(header);
  for (const auto& curve : curves)
    for (const auto& [x, y] : curve.points) table.row(curve.law, x, y);
  return table.csv();
}

/// Writes impact_loops.csv (law,delta,force), delivered.csv (law,requested,delivered), friction.csv
/// (law,speed,coefficient) and laws.json (settings and provenance).
void write_curves(const Scene& scene, const ImpactSetting& setting, const std::filesystem::path& folder) {
  const auto curves = law_curves(scene, setting);
  write_file(folder / "impact_loops.csv", csv("law,delta,force", curves.impacts));
  write_file(folder / "delivered.csv", csv("law,requested,delivered", curves.delivered));
  write_file(folder / "friction.csv", csv("law,speed,coefficient", curves.friction));
  const nlohmann::json document = {{"contact", curves.contact},
                                   {"mass_kg", setting.mass},
                                   {"approach_m_per_s", setting.speed},
                                   {"restitution_asked", curves.restitution},
                                   {"provenance", provenance(scene)}};
  write_json(folder / "laws.json", document);
}

/// The requested regularisation speed, or that of the law in force; else 1 mm/s.
double regularisation_of(const LawsRequest& request, const PenaltyOptions& options) {
  if (request.regularisation) {
    if (!(*request.regularisation > 0)) throw SceneError("--regularisation must be greater than 0");
    return *request.regularisation;
  }
  return regularisation_speed(facts_of(options.friction), options).value_or(1e-3);
}

/// Prints each friction law at the regularisation speed v (m/s).
void print_friction(double v, const PenaltyOptions& options) {
  fmt::print(
      "Friction laws at the same regularisation speed v = {:.4g} m/s, at which\neach has 95 % of its "
      "kinetic friction. Columns: friction over kinetic\nfriction at sliding speeds, and the creep speed "
      "(m/s) under half of the kinetic\nfriction.\n\n{:<14}{:<24}{:>8}{:>8}{:>8}{:>8}{:>10}\n",
      v, "law", "key", "0.1 v", "0.5 v", "v", "2 v", "creep");
  for (const auto& law : friction_laws()) {
    const auto o = regularised(law, options, v);
    if (!o) {
      fmt::print("{:<14}sticks by a spring: no regularisation speed\n", law.text);
      continue;
    }
    const bool second = law.v1_above_v0;
    fmt::print(
        "{:<14}{:<24}", law.text,
        fmt::format("friction_v{} = {:.4g}", second ? 1 : 0, second ? o->friction_v1 : o->friction_v0));
    for (const double at : {0.1, 0.5, 1.0, 2.0}) fmt::print("{:>8.4f}", make_friction(*o, 1).steady(at * v));
    fmt::print("{:>10.3g}\n", creep_speed(law, *o, 0.5));
  }
  fmt::print("\nAmbrósio's law has friction_v0 = 0 here; other keys are as given, else defaults.\n");
}

int print_curves(const LawsRequest& request) {
  const auto scene = open_scene(request.scene, request.overrides);
  const auto folder = result_folder(request.output, "out/laws");
  if (!(request.mass > 0) || !(request.speed > 0))
    throw SceneError("--mass and --speed must be greater than 0");
  ResultSet set(folder, "laws");
  ImpactSetting setting{.mass = request.mass, .speed = request.speed};
  if (request.friction) setting.regularisation = regularisation_of(request, scene->penalty);
  write_curves(*scene, setting, set.place());
  set.commit();
  if (request.friction) print_friction(*setting.regularisation, scene->penalty);
  fmt::print("curves in {}\nfigures:\n", folder.string());
  for (const auto& path : plots::all(folder)) fmt::print("  {}\n", path.string());
  return 0;
}

int print_delivered(double e) {
  if (!(e >= 0 && e <= 1)) throw SceneError(fmt::format("--restitution must be between 0 and 1, is {}", e));
  fmt::print("Effective restitution of a free impact with input {:.6g}\n\n{:<22}{:>10}{:>12}\n", e, "law",
             "chi", "delivers");
  for (const auto& law : contact_laws()) {
    if (law.kind != ContactKind::point) continue;
    if (law.positive_restitution && e == 0) {
      fmt::print("{:<22}{:>10}{:>12}\n", law.text, "infinite", "-");
      continue;
    }
    const double chi = damping_factor(law.law, e);
    fmt::print("{:<22}{:>10.5f}{:>12.5f}\n", law.text, chi, delivered_restitution(chi));
  }
  fmt::print(
      "\nLine contacts use the damping factor of penalty.damping, exact by default, and\nhave its "
      "effective restitution. That of Kelvin-Voigt depends on the mass.\n");
  return 0;
}

void print_law(const auto& law) {
  fmt::print("{0:<22}{2}\n{1:22}{3}\n{1:22}range: {4}\n", law.text, "", law.formula, law.source, law.range);
}

int print_list() {
  fmt::print(
      "Contact laws (penalty.contact). Point contacts: F = K δ^1.5 (1 + χ δ̇/v₀) ≥ 0,\n"
      "K = (4/3) E* √(R_i R_j/ΔR). Line contacts: f = F/(π E* L); ΔR the clearance.\n\n");
  for (const auto kind : {ContactKind::point, ContactKind::spring_damper, ContactKind::line})
    for (const auto& law : contact_laws())
      if (law.kind == kind) print_law(law);
  fmt::print(
      "\nFriction laws (penalty.friction): |F_T| over F_N at the sliding speed v, with\n"
      "v₀ = friction_v0, v₁ = friction_v1, μ_s = friction_static μ; docs/theory/friction.md.\n\n");
  for (const auto& law : friction_laws()) {
    print_law(law);
    fmt::print("{:22}keys: {}\n", "", law.keys);
  }
  fmt::print(
      "\nGoldsmith's and Dubowsky-Freudenstein's laws are not provided: the argument of\ntheir logarithm "
      "has a dimension, so the force depends on the units chosen.\n\nfreeplay laws --restitution 0.46 "
      "prints the effective restitution of each law.\n");
  return 0;
}

int print_film(const LawsRequest& request) {
  const auto scene = open_scene(request.scene, request.overrides);
  auto film = request.film;
  film.output = request.output;
  report_film(*scene, film);
  return 0;
}

int laws(const LawsRequest& request) {
  if (!request.film.joint.empty()) return print_film(request);
  if (!request.scene.empty()) return print_curves(request);
  if (request.restitution) return print_delivered(*request.restitution);
  if (request.friction) {
    const PenaltyOptions defaults;
    print_friction(request.regularisation ? regularisation_of(request, defaults) : 1e-3, defaults);
    return 0;
  }
  return print_list();
}

}  // namespace

void laws_verb(Program& program) {
  auto [options, request] =
      program.verb("laws", "list contact laws and their restitution, or report a film", laws);
  const auto drawn = options.add("scene", request.scene, "plot the laws for the first contact of this scene");
  options.add("--restitution", request.restitution, "input restitution: print the effective one of each law")
      .excludes(drawn);
  const auto friction = options.flag(
      "--friction", request.friction,
      "compare the friction laws at the same regularisation speed, at which each has 95 % of its "
      "kinetic friction");
  options
      .add("--regularisation", request.regularisation,
           "that speed, m/s; default: of the scene's law, else 1e-3")
      .quantity("m/s")
      .needs(friction);
  options.set(request.overrides).needs(drawn);
  options.add("--mass", request.mass, "mass of the plotted impact, kg").quantity("kg").needs(drawn);
  options.add("--speed", request.speed, "its approach speed, m/s").quantity("m/s").needs(drawn);
  const auto film = options
                        .add("--film", request.film.joint,
                             "lubricated joint: print Sommerfeld number, eccentricity, attitude angle, "
                             "stiffness and damping in steady running")
                        .takes("JOINT")
                        .needs(drawn);
  options
      .add("--load", request.film.load,
           "its load, N, or with a unit (\"0.8 kN\"); without load: a table over the eccentricity ratio")
      .quantity("N")
      .needs(film);
  options
      .add("--rpm", request.film.rpm,
           "speed of its journal, the bearing at rest, rpm, or with a unit (\"300 rad/s\")")
      .quantity("rpm")
      .needs(film);
  options.output(request.output, "result folder; default out/laws, with --film none").needs(drawn);
}

}  // namespace freeplay::cli
