#include "analysis/law_documents.hpp"

#include <nlohmann/json.hpp>

namespace freeplay {

nlohmann::json film_json(const std::string& joint, const Film& film, const SteadyFilm* running) {
  nlohmann::json document = {{"joint", joint},
                             {"film", text_of(film.kind)},
                             {"cavitation", film.cavitated ? "half-sommerfeld" : "none"},
                             {"viscosity_Pa_s", film.viscosity},
                             {"bearing_length_m", film.length},
                             {"bearing_radius_m", film.radius},
                             {"clearance_m", film.clearance}};
  if (!running) return document;
  document.update({{"load_N", running->load},
                   {"speed_rad_per_s", running->speed},
                   {"sommerfeld_number", running->sommerfeld},
                   {"eccentricity_ratio", running->ratio},
                   {"attitude_angle_rad", running->attitude},
                   {"least_thickness_m", running->thickness},
                   {"power_loss_W", running->loss},
                   {"stiffness_N_per_m", running->stiffness},
                   {"damping_N_s_per_m", running->damping},
                   {"stiffness_times_c_over_W", running->scaled_stiffness(film.clearance)},
                   {"damping_times_c_omega_over_W", running->scaled_damping(film.clearance)},
                   {"critical_mass_kg", nullptr},
                   {"whirl_frequency_ratio", nullptr}});
  if (running->critical_mass) {
    document["critical_mass_kg"] = *running->critical_mass;
    if (*running->critical_mass > 0) document["whirl_frequency_ratio"] = running->whirl_ratio;
  }
  return document;
}

std::vector<SteadyFilm> film_chart(const Film& film) {
  std::vector<SteadyFilm> chart;
  for (int i = 1; i < 100; ++i) {
    const double ratio = 0.01 * i;
    if (ratio > film.ratio(0.0)) break;
    chart.push_back(steady_film(film, ratio, 1));
  }
  return chart;
}

Table film_table(const Film& film, const std::vector<SteadyFilm>& chart) {
  Table table(
      "eccentricity_ratio,sommerfeld_number,attitude_angle,K_xx,K_xy,K_yx,K_yy,C_xx,C_xy,C_yx,C_yy,"
      "critical_mass,whirl_frequency_ratio");
  for (const auto& s : chart) {
    std::vector<Table::Cell> row{s.ratio, s.sommerfeld, s.attitude};
    for (const auto& m : {s.scaled_stiffness(film.clearance), s.scaled_damping(film.clearance)})
      for (const auto& line : m) row.insert(row.end(), line.begin(), line.end());
    if (s.critical_mass)  // m c ω²/W with ω = 1 rad/s
      row.insert(row.end(), {*s.critical_mass * film.clearance / s.load, s.whirl_ratio});
    else
      row.insert(row.end(), {"", ""});
    table.row(std::move(row));
  }
  return table;
}

nlohmann::json to_json(const LawCurves& curves, const ImpactSetting& setting) {
  auto groups = nlohmann::json::array();
  for (const auto& group : curves.groups)
    groups.push_back({{"names", group.contacts}, {"restitution_asked", group.restitution}});
  return {{"contacts", groups}, {"mass_kg", setting.mass}, {"approach_m_per_s", setting.speed}};
}

LawTables::LawTables(const LawCurves& curves)
    : impacts("contact,law,delta,force"),
      delivered("law,requested,delivered"),
      friction("law,speed,coefficient") {
  for (const auto& group : curves.groups)
    for (const auto& curve : group.impacts)
      for (const auto& [x, y] : curve.points) impacts.row(group.contacts.front(), curve.law, x, y);
  const auto fill = [](Table& table, const std::vector<LawCurve>& list) {
    for (const auto& curve : list)
      for (const auto& [x, y] : curve.points) table.row(curve.law, x, y);
  };
  fill(delivered, curves.delivered);
  fill(friction, curves.friction);
}

}  // namespace freeplay
