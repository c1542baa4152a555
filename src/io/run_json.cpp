#include "io/run_json.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "version.hpp"

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

}  // namespace

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
         {"greatest_penetration_over_clearance", c.penetration_ratio}};
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
        {"events", s.work.events}}},
      {"cost",
       {{"wall_s", s.wall_seconds}, {"cpu_s", s.cpu_seconds}, {"peak_memory_KiB", s.peak_memory_kib}}},
      {"notes", s.notes}};
  if (!s.undetermined.empty()) document["undetermined_reactions"] = s.undetermined;
  return document;
}

nlohmann::json provenance(const Scene& scene) {
  const auto& p = scene.penalty;
  const auto& n = scene.nonsmooth;
  return {{"program", "freeplay"},
          {"version", version},
          {"commit", commit},
          {"scene_file", scene.file.string()},
          {"scene", scene.text},
          {"overrides", scene.overrides},
          {"title", scene.mechanism.title},
          {"options",
           {{"duration_s", scene.run.duration},
            {"discard_s", scene.run.discard},
            {"penalty",
             {{"friction_v0", p.friction_v0},
              {"friction_v1", p.friction_v1},
              {"alpha", p.alpha},
              {"beta", p.beta},
              {"tolerance", p.tolerance},
              {"step", p.step}}},
            {"nonsmooth",
             {{"scheme", n.scheme == Scheme::event_driven ? "event-driven" : "moreau-jean"},
              {"step", n.step},
              {"tolerance", n.tolerance},
              {"impact_law", std::array{"newton", "poisson", "energetic"}[static_cast<int>(n.impact_law)]},
              {"solver", std::array{"automatic", "enumeration", "lemke", "gauss-seidel",
                                    "newton"}[static_cast<int>(n.solver)]},
              {"lcp_tolerance", n.lcp_tolerance}}}}}};
}

}  // namespace freeplay
