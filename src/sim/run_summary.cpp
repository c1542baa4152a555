#include "sim/run_summary.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>
#include <numbers>

#include "sim/recorder.hpp"
#include "version.hpp"

namespace freeplay {
namespace {

const char* name_of(Ending::Status status) {
  switch (status) {
    case Ending::Status::finished:
      return "finished";
    case Ending::Status::interrupted:
      return "interrupted";
    default:
      return "failed";
  }
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

long peak_memory_kib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

/// Says what makes a result doubtful: a journal deep in its wall, an energy balance that does not close.
void warn(RunSummary& s) {
  const bool impact_law = s.formulation == "nonsmooth";
  for (const auto& c : s.contacts)
    if (c.penetration_ratio > (impact_law ? 1e-3 : 0.1))
      s.notes.push_back(fmt::format(
          "DOUBTFUL: {} lay up to {:.3g} clearances inside its wall; {}", c.name, c.penetration_ratio,
          impact_law ? "take a shorter nonsmooth.step" : "the contact is too soft for this load"));
  const double scale = s.ledger.scale();
  if (std::abs(s.ledger.closure()) > 1e-3 * scale || std::abs(s.ledger.stabilisation) > 1e-3 * scale)
    s.notes.push_back(fmt::format(
        "DOUBTFUL: of {:.3g} J the energy balance misses {:.2g} J and stabilisation did {:.2g} J; "
        "tighten the tolerance or shorten the step, or the motion passed a singular position",
        scale, s.ledger.closure(), s.ledger.stabilisation));
}

}  // namespace

double EnergyLedger::scale() const {
  return std::max({std::abs(kinetic), std::abs(initial), std::abs(drive), std::abs(load), std::abs(contact),
                   std::abs(friction), std::abs(damping), std::abs(kinetic + potential + elastic - initial)});
}

void refuse_not_finite(const RunSummary& s, Ending& ending) {
  const auto fail = [&](const char* what) {
    if (ending.status == Ending::Status::finished)
      ending = {Ending::Status::failed, fmt::format("{} at t = {:.9g} s", what, s.t_end)};
  };
  for (const auto* list : {&s.final_state.q, &s.final_state.v})
    for (double x : *list)
      if (!std::isfinite(x)) fail("the state is not finite");
  if (!std::isfinite(s.ledger.scale()) || !std::isfinite(s.ledger.closure()))
    fail("the energy balance is not finite");
}

RunSummary summarise(const Scene& scene, const System& system, const Formulation& formulation) {
  RunSummary s;
  s.formulation = formulation.name();
  s.final_state = formulation.state();
  s.t_end = s.final_state.t;
  s.ledger = formulation.ledger();
  s.work = formulation.work();
  s.extremes = formulation.extremes();
  s.notes = formulation.notes();
  const double observed = std::max(0.0, s.t_end - scene.run.discard);
  if (const auto* drive = main_drive(scene.mechanism))
    s.revolutions = observed * std::abs(drive->speed) / (2 * std::numbers::pi);
  const auto models = formulation.contact_models();
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& tally = formulation.log().tally(k);
    ContactSummary c;
    c.name = system.contact_facts(k).name;
    c.model = models[k];
    if (tally.time > 0) {
      c.impact_fraction = tally.impact_time / tally.time;
      c.lasting_fraction = tally.lasting_time / tally.time;
      c.flight_fraction = 1 - c.impact_fraction - c.lasting_fraction;
    }
    c.impacts = tally.approach.total();
    c.counted_impacts = tally.approach.at_least(0.1 * tally.approach.greatest());
    const double per = s.revolutions > 0 ? s.revolutions : observed;
    c.impacts_per_revolution = per > 0 ? static_cast<double>(c.counted_impacts) / per : 0;
    c.fastest_approach = tally.approach.greatest();
    c.median_approach = tally.approach.quantile(0.5);
    c.median_impulse = tally.impulse.quantile(0.5);
    c.greatest_impulse = tally.impulse.greatest();
    c.penetration = s.extremes.penetration[k];
    c.penetration_ratio = c.penetration / system.contact_facts(k).clearance;
    s.contacts.push_back(c);
  }
  warn(s);
  return s;
}

nlohmann::json to_json(const RunSummary& s) {
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
  return {{"formulation", s.formulation},
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

RunSummary run_scene(const Scene& scene, const MakeFormulation& make,
                     const std::optional<std::filesystem::path>& folder,
                     const std::function<void(double)>& on_progress) {
  const State start = assemble(scene.mechanism, scene.run.start);
  const System system(scene.mechanism);
  auto formulation = make(scene, system, start);
  if (folder) make_folder(*folder);
  Recorder recorder(scene, system, folder);
  recorder.on_progress = on_progress;
  recorder.begin(start);

  const auto wall = std::chrono::steady_clock::now();
  const double cpu = cpu_seconds();
  auto ending = formulation->run(scene.run.duration, recorder);
  auto summary = summarise(scene, system, *formulation);
  refuse_not_finite(summary, ending);
  summary.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count();
  summary.cpu_seconds = cpu_seconds() - cpu;
  summary.peak_memory_kib = peak_memory_kib();
  summary.ending = std::move(ending);
  summary.events = recorder.events();
  if (folder) {
    recorder.commit();
    auto document = to_json(summary);
    document["provenance"] = provenance(scene);
    write_file(*folder / "run.json",
               document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  }
  return summary;
}

}  // namespace freeplay
