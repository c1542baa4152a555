// freeplay laws: lists the contact laws, evaluates them for a scene and writes their curves, or
// reports the steady running of a lubricated joint.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <numbers>
#include <optional>
#include <string>

#include "analysis/law_documents.hpp"
#include "cli/command_line.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "dynamics/system.hpp"
#include "formulations/contact/contact_law.hpp"
#include "formulations/contact/film.hpp"
#include "formulations/contact/friction_law.hpp"
#include "formulations/contact/law_curves.hpp"
#include "formulations/contact/steady_film.hpp"
#include "formulations/make.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/error.hpp"
#include "mechanism/laws.hpp"
#include "mechanism/scene.hpp"
#include "plots/drawing/figure.hpp"

namespace freeplay::cli {
namespace {

constexpr double degrees = 180 / std::numbers::pi;

struct FilmRequest {
  std::string joint;
  std::optional<double> load;  ///< N
  std::optional<double> rpm;   ///< of the journal, in a bearing at rest
  std::string output;          ///< result folder; empty: no files
};

Film film_of(const Scene& scene, const std::string& joint) {
  const System system(scene.mechanism);
  std::string lubricated;
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& facts = system.contact_facts(k);
    const auto film = make_film(facts);
    if (film && facts.name == joint) return *film;
    if (film) lubricated += (lubricated.empty() ? "" : ", ") + facts.name;
  }
  throw SceneError(fmt::format("--film {}: is no lubricated joint of {}; {}", joint, scene.file.string(),
                               lubricated.empty() ? "the scene has none" : "use one of: " + lubricated));
}

void say_bearing(const std::string& joint, const Film& film) {
  fmt::print("{}: {} bearing, {}, L/D = {:.4g}, R/c = {:.5g}, {:.4g} Pa s\n\n", joint,
             film.kind == Film::Kind::finite_length ? "finite-length" : text_of(film.kind),
             film.cavitated ? "half-Sommerfeld film" : "full film", film.length / (2 * film.radius),
             film.radius / film.clearance, film.viscosity);
  if (const auto note = range_note(joint, film)) fmt::print("{}", wrapped(*note + "\n\n"));
}

std::string threshold(const SteadyFilm& s, const char* unit) {
  if (!s.critical_mass) return "none: a rigid rotor of any mass is stable";
  if (*s.critical_mass == 0) return "0: a rigid rotor of any mass is unstable";
  return fmt::format("{:.5g} {}, whirl at {:.4g} of the speed", *s.critical_mass, unit, s.whirl_ratio);
}

/// Writes film.json, and film.csv with its figure if there is a table.
void write_film(const Scene& scene, const FilmRequest& request, const nlohmann::json& document,
                const std::string& csv) {
  if (request.output.empty()) return;
  const auto folder = real_folder(request.output);
  ResultSet set(folder, "film");
  write_json(set.place() / "film.json", document, provenance(scene));
  if (!csv.empty()) write_file(set.place() / "film.csv", csv);
  set.commit();
  fmt::print("all digits in {}\n", (folder / (csv.empty() ? "film.json" : "film.csv")).string());
  if (csv.empty()) return;
  fmt::print("figures:\n");
  for (const auto& path : plots::all(folder)) fmt::print("  {}\n", path.string());
}

/// Table over the eccentricity ratio.
void print_chart(const Scene& scene, const FilmRequest& request, const Film& film) {
  say_bearing(request.joint, film);
  fmt::print("{:>5}{:>10}{:>7}{:>8}{:>7}{:>7}{:>7}{:>7}{:>7}{:>7}{:>7}\n", "ε", "S", "φ, °", "K_xx", "K_xy",
             "K_yx", "K_yy", "C_xx", "C_xy", "C_yx", "C_yy");
  const auto chart = film_chart(film);
  for (std::size_t i = 0; i < chart.size(); ++i) {
    if ((i + 1) % 10 != 0 && i + 1 != 95) continue;
    const auto& s = chart[i];
    const auto K = s.scaled_stiffness(film.clearance), C = s.scaled_damping(film.clearance);
    fmt::print("{:5.2f}{:10.4g}{:7.2f}{:8.3f}{:7.3f}{:7.3f}{:7.3f}{:7.3f}{:7.3f}{:7.3f}{:7.3f}\n", s.ratio,
               s.sommerfeld, s.attitude * degrees, K[0][0], K[0][1], K[1][0], K[1][1], C[0][0], C[0][1],
               C[1][0], C[1][1]);
  }
  fmt::print(
      "\nK in units of W/c, C in W/(cω); x along the load, y at 90° from x in the\ndirection of rotation. "
      "Use --load and --rpm for values in SI units.\n");
  write_film(scene, request, film_json(request.joint, film), film_table(film, chart).csv());
}

void print_point(const Scene& scene, const FilmRequest& request, const Film& film) {
  if (!(*request.load > 0) || !(*request.rpm > 0))
    throw SceneError("--load and --rpm must be greater than 0");
  const double speed = *request.rpm * std::numbers::pi / 30;
  const auto ratio = steady_ratio(film, *request.load, speed);
  if (!ratio)
    throw SceneError(fmt::format(
        "--load {:.6g}: the film carries at most {:.4g} N at {:.6g} rpm, at its hand-over thickness of "
        "{:.3g} m; use a smaller load or a higher speed",
        *request.load, steady_film(film, film.ratio(0.0), speed).load, *request.rpm, film.hand_over));
  const auto s = steady_film(film, *ratio, speed);
  say_bearing(request.joint, film);
  const auto line = [](const char* what, const std::string& value) { fmt::print("{:<26}{}\n", what, value); };
  line("Sommerfeld number", fmt::format("{:.6g}", s.sommerfeld));
  line("eccentricity ratio", fmt::format("{:.6g}", s.ratio));
  line("attitude angle", fmt::format("{:.5g}°", s.attitude * degrees));
  line("least film thickness", fmt::format("{:.5g} m", s.thickness));
  line("power loss", fmt::format("{:.5g} W", s.loss));
  const auto rows = [](const char* what, const SteadyFilm::Matrix& si, const SteadyFilm::Matrix& scaled) {
    constexpr const char* names[] = {"xx", "xy", "yx", "yy"};
    for (int i = 0; i < 4; ++i)
      fmt::print("{}_{:<24}{:>14.6g}{:>14.6g}\n", what, names[i], si[i / 2][i % 2], scaled[i / 2][i % 2]);
  };
  fmt::print("\n{:<26}{:>14}{:>14}\n", "stiffness", "N/m", "times c/W");
  rows("K", s.stiffness, s.scaled_stiffness(film.clearance));
  fmt::print("{:<26}{:>14}{:>14}\n", "damping", "N s/m", "times cω/W");
  rows("C", s.damping, s.scaled_damping(film.clearance));
  fmt::print("\n");
  line("critical mass per bearing", threshold(s, "kg"));
  fmt::print("\nx along the load, y at 90° from x in the direction of rotation.\n");
  write_film(scene, request, film_json(request.joint, film, &s), "");
}

/// Prints the equilibrium and the linear coefficients at a load and a speed, or without them a table
/// over the eccentricity ratio. With an output folder, film.csv or film.json has all digits.
/// Throws SceneError if the joint has no film or the film cannot carry the load.
void report_film(const Scene& scene, const FilmRequest& request) {
  if (request.load.has_value() != request.rpm.has_value())
    throw SceneError("--load and --rpm must be given together");
  const auto film = film_of(scene, request.joint);
  request.load ? print_point(scene, request, film) : print_chart(scene, request, film);
}

constexpr std::string_view choice_page = "Which law: docs/how-to/contact-law.md";

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

/// Prints what each law makes of one free impact, for each kind of contact.
void print_impacts(const LawCurves& curves, const ImpactSetting& setting) {
  for (const auto& group : curves.groups) {
    fmt::print(
        "{}\n{:<22}{:>10}{:>11}{:>12}{:>10}\n",
        wrapped(fmt::format("Free impact of {:.4g} kg at {:.4g} m/s in contact{} {}, input restitution "
                            "{:.4g}\n",
                            setting.mass, setting.speed, group.contacts.size() > 1 ? "s" : "",
                            fmt::join(group.contacts, ", "), group.restitution),
                2),
        "law", "force, N", "depth, m", "duration, s", "delivers");
    for (const auto& r : group.results)
      fmt::print("{:<22}{:>10.4g}{:>11.3e}{:>12.3e}{:>10.4f}{}\n", r.law, r.force, r.depth, r.duration,
                 r.restitution, r.outside ? "  outside" : "");
    fmt::print("\n");
  }
  fmt::print(
      "Force and depth are the greatest; outside: beyond the range of the law, "
      "see\n`freeplay laws`. {}\n\n",
      choice_page);
}

/// Writes impact_loops.csv, delivered.csv, friction.csv and laws.json.
void write_curves(const Scene& scene, const LawCurves& curves, const ImpactSetting& setting,
                  const std::filesystem::path& folder) {
  const LawTables tables(curves);
  write_file(folder / "impact_loops.csv", tables.impacts.csv());
  write_file(folder / "delivered.csv", tables.delivered.csv());
  write_file(folder / "friction.csv", tables.friction.csv());
  write_json(folder / "laws.json", to_json(curves, setting), provenance(scene));
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
  const auto curves = located_in(*scene, [&] { return law_curves(*scene, setting); });
  write_curves(*scene, curves, setting, set.place());
  set.commit();
  print_impacts(curves, setting);
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
      "prints the effective restitution of each law.\n{}\n",
      choice_page);
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
  const auto drawn = options.add("scene", request.scene, "plot the laws for the contacts of this scene");
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
