#include "cli/film_report.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "dynamics/system.hpp"
#include "formulations/contact/film_force.hpp"
#include "formulations/contact/steady_film.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "plots/drawing/figure.hpp"
#include "values/table.hpp"

namespace freeplay::cli {
namespace {

constexpr double degrees = 180 / std::numbers::pi;

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
             film.kind == Film::Kind::short_bearing ? "short" : "long",
             film.cavitated ? "half-Sommerfeld film" : "full film", film.length / (2 * film.radius),
             film.radius / film.clearance, film.viscosity);
  // Ocvirk's approximation neglects the pressure flow around the journal.
  constexpr double longest = 0.5;  // L/D
  if (film.kind == Film::Kind::short_bearing && film.length / (2 * film.radius) > longest * (1 + 1e-9))
    fmt::print(
        "The short-bearing film is accurate for L/D up to 0.5; beyond, it overestimates\nthe load that the "
        "film carries, so the eccentricity is underestimated.\n\n");
}

std::string threshold(const SteadyFilm& s, const char* unit) {
  if (!s.critical_mass) return "none: a rigid rotor of any mass is stable";
  if (*s.critical_mass == 0) return "0: a rigid rotor of any mass is unstable";
  return fmt::format("{:.5g} {}, whirl at {:.4g} of the speed", *s.critical_mass, unit, s.whirl_ratio);
}

/// The bearing, and the source of its numbers.
nlohmann::json bearing_json(const Scene& scene, const std::string& joint, const Film& film) {
  return {{"joint", joint},
          {"film", film.kind == Film::Kind::short_bearing ? "short" : "long"},
          {"cavitation", film.cavitated ? "half-sommerfeld" : "none"},
          {"viscosity_Pa_s", film.viscosity},
          {"bearing_length_m", film.length},
          {"bearing_radius_m", film.radius},
          {"clearance_m", film.clearance},
          {"provenance", provenance(scene)}};
}

nlohmann::json steady_json(const SteadyFilm& s, double clearance) {
  nlohmann::json j = {{"load_N", s.load},
                      {"speed_rad_per_s", s.speed},
                      {"sommerfeld_number", s.sommerfeld},
                      {"eccentricity_ratio", s.ratio},
                      {"attitude_angle_rad", s.attitude},
                      {"least_thickness_m", s.thickness},
                      {"power_loss_W", s.loss},
                      {"stiffness_N_per_m", s.stiffness},
                      {"damping_N_s_per_m", s.damping},
                      {"stiffness_times_c_over_W", s.scaled_stiffness(clearance)},
                      {"damping_times_c_omega_over_W", s.scaled_damping(clearance)},
                      {"critical_mass_kg", nullptr},
                      {"whirl_frequency_ratio", nullptr}};
  if (s.critical_mass) {
    j["critical_mass_kg"] = *s.critical_mass;
    if (*s.critical_mass > 0) j["whirl_frequency_ratio"] = s.whirl_ratio;
  }
  return j;
}

/// Writes film.json, and film.csv with its figure if there is a table.
void write_film(const FilmRequest& request, const nlohmann::json& document, const std::string& csv) {
  if (request.output.empty()) return;
  const auto folder = real_folder(request.output);
  ResultSet set(folder, "film");
  write_json(set.place() / "film.json", document);
  if (!csv.empty()) write_file(set.place() / "film.csv", csv);
  set.commit();
  fmt::print("all digits in {}\n", (folder / (csv.empty() ? "film.json" : "film.csv")).string());
  if (csv.empty()) return;
  fmt::print("figures:\n");
  for (const auto& path : plots::all(folder)) fmt::print("  {}\n", path.string());
}

/// Table over the eccentricity ratio. The dimensionless quantities depend on the shape of the
/// bearing only, not on the speed.
void print_chart(const Scene& scene, const FilmRequest& request, const Film& film) {
  say_bearing(request.joint, film);
  fmt::print("{:>5}{:>10}{:>7}{:>8}{:>7}{:>7}{:>7}{:>7}{:>7}{:>7}{:>7}\n", "ε", "S", "φ, °", "K_xx", "K_xy",
             "K_yx", "K_yy", "C_xx", "C_xy", "C_yx", "C_yy");
  Table table(
      "eccentricity_ratio,sommerfeld_number,attitude_angle,K_xx,K_xy,K_yx,K_yy,C_xx,C_xy,C_yx,C_yy,"
      "critical_mass,whirl_frequency_ratio");
  for (int i = 1; i < 100; ++i) {
    const double ratio = 0.01 * i;
    if (ratio > film.ratio(0.0)) break;
    const auto s = steady_film(film, ratio, 1);
    const auto K = s.scaled_stiffness(film.clearance), C = s.scaled_damping(film.clearance);
    std::vector<Table::Cell> row{ratio, s.sommerfeld, s.attitude};
    for (const auto* m : {&K, &C})
      for (const auto& line : *m) row.insert(row.end(), line.begin(), line.end());
    if (s.critical_mass)  // m c ω²/W with ω = 1 rad/s
      row.insert(row.end(), {*s.critical_mass * film.clearance / s.load, s.whirl_ratio});
    else
      row.insert(row.end(), {"", ""});
    table.row(std::move(row));
    if (i % 10 != 0 && i != 95) continue;
    fmt::print("{:5.2f}{:10.4g}{:7.2f}{:8.3f}{:7.3f}{:7.3f}{:7.3f}{:7.3f}{:7.3f}{:7.3f}{:7.3f}\n", ratio,
               s.sommerfeld, s.attitude * degrees, K[0][0], K[0][1], K[1][0], K[1][1], C[0][0], C[0][1],
               C[1][0], C[1][1]);
  }
  fmt::print(
      "\nK in units of W/c, C in W/(cω); x along the load, y at 90° from x in the\ndirection of rotation. "
      "Use --load and --rpm for values in SI units.\n");
  write_film(request, bearing_json(scene, request.joint, film), table.csv());
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
  auto document = bearing_json(scene, request.joint, film);
  document.update(steady_json(s, film.clearance));
  write_film(request, document, "");
}

}  // namespace

void report_film(const Scene& scene, const FilmRequest& request) {
  if (request.load.has_value() != request.rpm.has_value())
    throw SceneError("--load and --rpm must be given together");
  const auto film = film_of(scene, request.joint);
  request.load ? print_point(scene, request, film) : print_chart(scene, request, film);
}

}  // namespace freeplay::cli
