#include "io/files/run_json.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "io/files/build_identity.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/recorded_run.hpp"
#include "io/scene/section.hpp"
#include "io/scene/write_scene.hpp"

namespace freeplay {
namespace {

const char* name_of(Ending::Status status) {
  switch (status) {
    case Ending::Status::finished:
      return "finished";
    case Ending::Status::interrupted:
      return "interrupted";
    case Ending::Status::failed:
      return "failed";
  }
  throw std::logic_error("no such ending");
}

/// A text as a list of its lines, so that two files can be compared line by line.
nlohmann::json lines(const std::string& text) {
  auto list = nlohmann::json::array();
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) list.push_back(line);
  return list;
}

/// Inverse of lines().
std::string joined(const std::vector<std::string>& lines) {
  std::string all;
  for (const auto& line : lines) all += line + '\n';
  return all;
}

/// The options of [run], [penalty] and [nonsmooth]. TOML and JSON spell their values alike.
nlohmann::json options(const std::string& scene) {
  nlohmann::json found;
  for (const auto& line : canonical_lines(scene))
    for (const char* table : {"run", "penalty", "nonsmooth"})
      if (line.key.starts_with(std::string(table) + "."))
        found[table][line.key.substr(line.key.find('.') + 1)] =
            nlohmann::json::parse(line.value, nullptr, false);
  // Add the defaults of options that the text does not name.
  auto& nonsmooth = found["nonsmooth"];
  nonsmooth.emplace("step", "automatic");
  nonsmooth.emplace("scheme", nonsmooth["step"].is_number() ? "moreau-jean" : "automatic");
  return found;
}

nlohmann::json film_json(const FilmSummary& s) {
  nlohmann::json j = {
      {"mean_eccentricity_ratio", s.mean_ratio}, {"greatest_eccentricity_ratio", s.greatest_ratio},
      {"mean_thickness_m", s.mean_thickness},    {"least_thickness_m", s.least_thickness},
      {"least_thickness_at_s", s.least_at},      {"mean_load_N", s.mean_load},
      {"greatest_load_N", s.greatest_load},      {"mean_speed_rad_per_s", s.mean_speed},
      {"mean_power_loss_W", s.mean_loss},        {"greatest_power_loss_W", s.greatest_loss}};
  if (s.mean_load > 0) {
    j["attitude_angle_rad"] = s.attitude;
    j["sommerfeld_number"] = s.sommerfeld;
  }
  return j;
}

nlohmann::json bearing_json(const BearingSummary& s) {
  nlohmann::json j = {{"observed_s", s.time},
                      {"sliding_m", s.sliding},
                      {"force_times_sliding_N_m", s.work},
                      {"greatest_pressure_Pa", s.greatest_pressure}};
  if (s.bearing_wear_rate) j["bearing_wear_rate_m2_per_s"] = *s.bearing_wear_rate;
  if (s.journal_wear_rate) j["journal_wear_rate_m2_per_s"] = *s.journal_wear_rate;
  return j;
}

}  // namespace

std::string format_note(const Scene& scene) {
  if (scene.format) return "";
  return fmt::format("the scene has no format key; it was read as format = {}", newest_format);
}

nlohmann::json to_json(const Result& s) {
  nlohmann::json contacts = nlohmann::json::object();
  for (const auto& c : s.contacts) {
    auto& j = contacts[c.name];
    j = {{"restitution_asked", c.model.restitution_asked},
         {"restitution_delivered", c.model.restitution_delivered},
         {"flight_fraction", c.flight_fraction},
         {"impact_fraction", c.impact_fraction},
         {"lasting_contact_fraction", c.lasting_fraction},
         {"impacts", c.impacts},
         {"impacts_above_a_tenth_of_fastest", c.counted_impacts},
         {s.revolutions > 0 ? "impacts_per_revolution" : "impacts_per_second", c.impacts_per_revolution},
         {"fastest_approach_m_per_s", c.fastest_approach},
         {"median_approach_m_per_s", c.median_approach},
         {"median_impulse_N_s", c.median_impulse},
         {"greatest_impulse_N_s", c.greatest_impulse},
         {"greatest_penetration_m", c.penetration},
         {"greatest_penetration_over_" + c.measure, c.penetration_ratio}};
    if (!c.has_clearance()) j["impact_over_flight"] = c.impact_over_flight;
    if (s.window && s.window->batches > 0)
      j["standard_errors"] = {
          {"flight_fraction", c.flight_error},
          {"impact_fraction", c.impact_error},
          {"lasting_contact_fraction", c.lasting_error},
          {s.revolutions > 0 ? "impacts_per_revolution" : "impacts_per_second", c.impacts_error}};
    if (c.film) j["film"] = film_json(*c.film);
    if (c.model.stiffness > 0) {
      j["stiffness"] = c.model.stiffness;
      j["exponent"] = c.model.exponent;
      j["damping_factor"] = c.model.chi;
    }
  }
  const auto& l = s.ledger;
  nlohmann::json document = {
      {"formulation", s.formulation},
      {"ending", {{"status", name_of(s.ending.status)}, {"reason", s.ending.reason}, {"t_s", s.t_end}}},
      {"revolutions_counted", s.revolutions},
      {"contacts", contacts},
      {"greatest_constraint_violation",
       {{"length_m", s.extremes.constraint_length}, {"angle_rad", s.extremes.constraint_angle}}},
      {"greatest_complementarity_residual", s.extremes.lcp_residual},
      {"greatest_complementarity_residual_m_per_s", s.extremes.lcp_residual_rate},
      {"impacts_that_raised_the_energy",
       {{"count", s.extremes.gains}, {"greatest_J", s.extremes.greatest_gain}}},
      {"energy_J",
       {{"initial", l.initial},
        {"kinetic", l.kinetic},
        {"potential", l.potential},
        {"elastic", l.elastic},
        {"work_of_drives", l.drive},
        {"work_of_loads", l.load},
        {"dissipated_in_dampers", l.damping},
        {"dissipated_in_contacts", l.contact},
        {"dissipated_by_friction", l.friction},
        {"dissipated_in_films", l.film},
        {"work_of_stabilisation", l.stabilisation},
        {"closure", l.closure()}}},
      {"work",
       {{"steps", s.work.steps},
        {"rejected_steps", s.work.rejected},
        {"right_hand_sides", s.work.rhs},
        {"jacobians", s.work.jacobians},
        {"factorisations", s.work.factorisations},
        {"complementarity_solves", s.work.lcp_solves},
        {"complementarity_retries", s.work.lcp_retries},
        {"pivots", s.work.pivots},
        {"events", s.work.events},
        {"handovers", s.work.handovers},
        {"time_stepped", s.work.stepped}}},
      {"cost",
       {{"wall_s", s.wall_seconds}, {"cpu_s", s.cpu_seconds}, {"peak_memory_KiB", s.peak_memory_kib}}},
      {"notes", s.notes}};
  auto& compiled = document["cost"]["compiled"];
  compiled["used"] = s.compiled.used;
  if (s.compiled.used)
    compiled.update({{"from_s", s.compiled.from}, {"refused_calls", s.compiled.refused}});
  else
    compiled["reason"] = s.compiled.reason;
  if (!s.compiled.general_parts.empty()) compiled["general_parts"] = s.compiled.general_parts;
  if (!s.assumed.empty()) document["assumed"] = s.assumed;
  if (s.window) {
    const auto& w = *s.window;
    auto& j = document["window"];
    j = {{"from_s", w.from}, {"to_s", w.to}, {"batches", w.batches}, {"batch_s", w.batch}};
    for (std::size_t i = 0; i < energy_terms.size(); ++i) {
      j["energy_J"][energy_terms[i]] = w.energy[i];
      if (w.batches > 0) j["energy_standard_error_J"][energy_terms[i]] = w.error[i];
    }
  }
  if (s.first_touches) {
    const auto& d = *s.first_touches;
    document["first_touches_may_be_off_by"] = {{"touches", d.touches},
                                               {"until_s", d.until},
                                               {"time_over_interval", d.time},
                                               {"approach_speed", d.speed},
                                               {"normal_impulse", d.impulse},
                                               {"others_in_the_companion", d.missing},
                                               {"step_s", d.step},
                                               {"companion_step_s", d.companion_step},
                                               {"factor", d.factor}};
  }
  if (s.extremes.friction_residual > 0)
    document["greatest_joint_friction_residual"] = s.extremes.friction_residual;
  for (const auto& b : s.bearings) document["bearings"][b.joint] = bearing_json(b);
  if (!s.undetermined.empty()) document["undetermined_reactions"] = s.undetermined;
  return document;
}

nlohmann::json provenance(const Scene& scene) {
  return provenance(scene,
                    {.scene = to_toml(scene), .formulation = "", .given = "", .program = program_identity()});
}

nlohmann::json provenance() { return provenance(Scene{}); }

nlohmann::json provenance(const Scene& scene, const Identity& identity) {
  nlohmann::json document = {{"program", "freeplay"},
                             {"version", build_identity().version},
                             {"commit", build_identity().commit},
                             {"scene_file", scene.file.string()},
                             {"scene", scene.text},
                             {"overrides", scene.overrides},
                             {"title", scene.mechanism.title},
                             {"format", scene.format.value_or(newest_format)},
                             {"options", options(identity.scene)},
                             {"identity",
                              {{"digest", identity.digest()},
                               {"scene", lines(identity.scene)},
                               {"formulation", lines(identity.formulation)},
                               {"given", lines(identity.given)},
                               {"program", lines(identity.program)}}}};
  for (const auto& file : scene.files)
    document["files_read"].push_back({{"file", file.name}, {"digest", file.digest}});
  if (const auto note = format_note(scene); !note.empty()) document["format_note"] = note;
  return document;
}

RecordedRun read_run(const std::filesystem::path& file) {
  const auto bad = [&](const std::string& why) {
    return SceneError(fmt::format("{}: {}", file.string(), why));
  };
  const JsonFile json(file);
  if (json.find("provenance") && !json.find("provenance.identity"))
    throw bad("has no identity of a run: an earlier version wrote it; run its scene again");
  const auto part = [&](const char* name) {
    return joined(json.texts(fmt::format("provenance.identity.{}", name)));
  };
  RecordedRun run;
  run.identity = {part("scene"), part("formulation"), part("given"), part("program")};
  if (run.identity.digest() != json.text("provenance.identity.digest"))
    throw bad("is damaged: its identity does not match the hash");
  if (run.identity.formulation.empty()) throw bad("is not of a single run; give the run.json of a run");
  const Origin origin{json.text("provenance.scene_file"), json.text("provenance.scene"),
                      json.texts("provenance.overrides"), !json.find("provenance.format_note")};
  try {
    run.setup = setup_of(run.identity, origin);
  } catch (const SceneError& e) {
    throw bad(fmt::format("cannot be repeated: {}", e.what()));
  }
  return run;
}

void write_json(const std::filesystem::path& path, const nlohmann::json& document) {
  write_file(path, document.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

void write_json(const std::filesystem::path& path, nlohmann::json document, const nlohmann::json& origin) {
  document["provenance"] = origin;
  write_json(path, document);
}

}  // namespace freeplay
