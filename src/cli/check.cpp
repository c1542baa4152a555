#include "analysis/reduced_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cli/command_line.hpp"
#include "cli/folders.hpp"
#include "cli/scene_report.hpp"
#include "cli/terminal.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/meshing.hpp"
#include "dynamics/beam_reduction.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "formulations/contact/steady_film.hpp"
#include "formulations/make.hpp"
#include "io/files/output_estimate.hpp"
#include "io/files/result_set.hpp"
#include "io/scene/beam_line.hpp"
#include "io/scene/bearing_line.hpp"
#include "io/scene/pose_file.hpp"
#include "io/scene/quantity.hpp"
#include "io/scene/read_scene.hpp"
#include "io/scene/schema.hpp"
#include "mechanism/magnitude.hpp"
#include "mechanism/scene.hpp"
#include "numerics/saddle_point.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/style.hpp"
#include "study/settings/study.hpp"

namespace freeplay::cli {

namespace {

/// Prints a line of the table; long lists continue below their first item.
void line(const char* name, const std::string& value) {
  fmt::print("{}", wrapped(fmt::format("  {:<28}{}\n", name, value), 30));
}

/// Prints the equations and unknowns of each element.
void burdens(const System& system) {
  fmt::print("  contribution of each element\n");
  for (const auto& c : system.carried()) {
    std::string what;
    const auto say = [&](int count, const char* one, const char* many) {
      if (count > 0) what += fmt::format("{}{} {}", what.empty() ? "" : ", ", count, count == 1 ? one : many);
    };
    say(c.rows, "constraint row", "constraint rows");
    say(c.contacts, "contact", "contacts");
    say(c.families, "family of pairs", "families of pairs");
    say(c.frictions, "friction row", "friction rows");
    say(c.states, "state", "states");
    say(c.force, "applied force", "applied forces");
    fmt::print("{}", wrapped(fmt::format("      {} ({}): {}\n", c.name, c.kind, what), 6));
  }
}

/// Prints all keys of scenes, studies and styles in the form of docs/reference/scene.md.
int list_keys() {
  for (const auto* schema : {&scene_schema(), &study_schema(), &plots::style_schema()})
    for (const auto& k : schema->keys())
      fmt::print("| `{}` | {} | {} | {} | {} |\n", k.path, k.type, k.unit, k.fallback, k.meaning);
  return 0;
}

/// Prints the plausible range of each unit in that form.
int list_bounds() {
  for (const auto& m : magnitudes) fmt::print("{}", row_of(m));
  return 0;
}

/// Prints which parts of the equations are eliminated, and with `why` the reasons.
void economies(const Scene& scene, const System& system, const SaddlePoint& saddle,
               const std::vector<int>& redundant, bool why) {
  const auto say = [why](const std::string& what, const char* reason) {
    line("eliminated", what);
    if (why) fmt::print("{}", wrapped(fmt::format("      {}\n", reason), 6));
  };
  std::string names;
  for (const int c : saddle.eliminated()) {
    const auto& body = scene.mechanism.bodies[planar::body_of(c)];
    if (!body.point || !system.is_angle(c))
      names += (names.empty() ? "" : ", ") + body.name + "." + planar::name(c);
  }
  if (!names.empty())
    say(names,
        "each is fixed by a single constraint row: a ground pivot at the centre of mass, a guide, a drive");
  else if (!scene.run.eliminate)
    say("nothing", "run.eliminate = false keeps the full DAE in absolute coordinates");
  else if (!redundant.empty())
    say("nothing", "constraint rows are linearly dependent and are solved together");
  else
    say("nothing", "no coordinate is fixed by a single constraint row");

  std::vector<std::pair<std::string, std::string>> left;
  if (system.reported() == 0) {
    left.emplace_back(
        "contacts",
        "no joint has clearance and there are no [contacts]: there are no gaps and no complementarity "
        "problem");
  } else {
    for (int k = 0; k < system.contacts(); ++k) {
      const auto& facts = system.contact_facts(k);
      if (!system.has_friction(k))
        left.emplace_back("tangent row of " + facts.name, "its surface has no friction");
      if (!facts.lubricant && facts.ring)
        left.emplace_back("film of " + facts.name, "no lubricant is given: the gap is dry");
    }
  }
  if (scene.mechanism.gravity.is_zero()) left.emplace_back("gravity", "it is zero");
  if (!system.has_loads())
    left.emplace_back("work of loads", "no force, torque, damper or torque drive acts");
  if (system.frictions() == 0)
    left.emplace_back("friction of joints", "no load of type joint-friction or freewheel");
  if (scene.instruments.empty()) left.emplace_back("filters", "the scene has no instruments");
  std::string list;
  for (const auto& [what, reason] : left) list += (list.empty() ? "" : ", ") + what;
  line("not used in this model", list.empty() ? "nothing" : list);
  if (why)
    for (const auto& [what, reason] : left)
      fmt::print("{}", wrapped(fmt::format("      {}: {}\n", what, reason), 6));
}

struct CheckRequest : Request {
  std::string scene;
  std::vector<std::string> overrides;
  Reach reach = Reach::beside;
  bool why = false;     ///< print the reasons of eliminations
  bool keys = false;    ///< list the keys of scenes instead
  bool bounds = false;  ///< list the plausible ranges of numbers instead
  bool units = false;   ///< list the units of numbers instead
  bool modes = false;   ///< compare the frequencies of reduced and of full beams
  std::string output;   ///< folder for the figure of the pose
  double magnify = 1;   ///< factor of the deflection of beams and of clearance and deviations in the figure
};

/// Prints all units in the form of docs/reference/scene.md.
int list_units() {
  for (const auto& u : named_units()) fmt::print("{}", row_of(u));
  return 0;
}

/// Prints the division of each beam and the frequencies that it resolves and adds.
void beams(const Mechanism& m) {
  for (const auto& beam : m.beams) {
    const double hertz = 1 / (2 * std::numbers::pi);
    double least = INFINITY, most = 0;
    for (int n = 0; n < beam.elements; ++n)
      least = std::min(least, beam.body(n).mass), most = std::max(most, beam.body(n).mass);
    fmt::print("{}", wrapped(fmt::format("\n  beam {}: {} pieces of {:.4g} mm and {:.4g}{} kg\n", beam.name,
                                         beam.elements, 1e3 * beam.piece(), least,
                                         most > least ? fmt::format(" to {:.4g}", most) : ""),
                             4));
    fmt::print("    bending: up to {:.4g} Hz with an error of at most 1 % of the frequency\n",
               hertz * beam.resolved());
    if (!beam.is_reduced()) {
      fmt::print("    axial vibration: up to {:.4g} Hz, which explicit steps resolve\n",
                 hertz * beam.highest());
      continue;
    }
    if (*beam.modes == 0) {
      fmt::print("    reduced to its static deflection\n");
      continue;
    }
    const auto omega = BeamReduction(beam).frequency;
    const double greatest = omega[omega.size() - 1];
    fmt::print("    reduced to {} of its modes with clamped ends, {:.4g} Hz to {:.4g} Hz\n", omega.size(),
               hertz * omega[0], hertz * greatest);
    if (greatest > beam.resolved())
      fmt::print("{}", wrapped("    warning: the pieces do not resolve the highest of these modes; use more "
                               "elements or fewer modes\n",
                               6));
  }
}

/// Prints the lowest frequencies of the mechanism with reduced beams, and their errors.
void reduction_errors(const Mechanism& m, const State& start) {
  constexpr std::size_t most = 10;
  fmt::print("\n  natural frequencies about the start, Hz\n  {:>14} {:>14} {:>12}\n", "reduced beams",
             "full beams", "error");
  const auto all = reduced_frequencies(m, start);
  for (std::size_t i = 0; i < std::min(most, all.size()); ++i)
    fmt::print("  {:>14.6g} {:>14.6g} {:>12.2g}\n", all[i].reduced, all[i].full, all[i].error());
}

/// Prints the film of a joint, and a note if its bearing has a length for which the film is inaccurate.
void film_range(const ContactFacts& facts) {
  const auto film = make_film(facts);
  if (!film) return;
  fmt::print("    film: {}, L/D = {:.4g}\n", text_of(film->kind), film->length / (2 * film->radius));
  if (const auto note = range_note(facts.name, *film)) fmt::print("{}", wrapped("    " + *note + "\n", 6));
}

void draw_pose(const Scene& scene, const State& start, const std::string& output, double magnify) {
  const auto folder = result_folder(output, output);
  ResultSet set(folder, "check");
  write_pose(scene, start, set.place(), magnify);
  set.commit();
  fmt::print("\nfigures:\n");
  for (const auto& path : plots::all(folder)) fmt::print("  {}\n", path.string());
}

int check(const CheckRequest& request) {
  if (request.keys) return list_keys();
  if (request.bounds) return list_bounds();
  if (request.units) return list_units();
  if (request.scene.empty()) throw SceneError("scene is required");
  const Scene scene = read_scene(request.scene, request.overrides, request.reach == Reach::anywhere);
  if (request.magnify != 1 && beam_lines(scene.mechanism).empty() && !has_profiles(scene.mechanism))
    throw SceneError(
        "--magnify: the scene has neither beams nor profiles, whose deflection and deviations it magnifies");
  if (request.modes && std::ranges::none_of(scene.mechanism.beams, &Beam::is_reduced))
    throw SceneError(
        "--modes: the scene has no reduced beams; it compares their frequencies with those of full "
        "beams (beams.NAME.modes)");
  std::optional<IdealStart> ideal;
  ask(scene, &ideal);
  const System system(scene.mechanism);
  if (!ideal || scene.run.start != RunOptions::Start::ideal) {
    ideal.emplace();
    ideal->state =
        located_in(scene, [&] { return assemble(scene.mechanism, scene.run.start, &ideal->assumed); });
  }
  const State& start = ideal->state;
  located_in(scene, [&] { require_mesh(scene.mechanism, start.q); });
  const auto redundant = redundant_rows(system, start.q);
  int tangents = 0;
  for (int k = 0; k < system.contacts(); ++k) tangents += system.has_friction(k);

  fmt::print("{}\n\n", scene.mechanism.title.empty() ? scene.file.string() : scene.mechanism.title);
  if (!scene.format) line("format", fmt::format("{} (not stated in the scene)", newest_format));
  // The angle of a point body, and the row that holds it, are none of the mechanism's.
  const int points = system.points();
  line("bodies", fmt::format("{}{}", system.bodies(),
                             points > 0 ? fmt::format(", {} of them without rotation", points) : ""));
  line("coordinates", fmt::format("{}", system.n() - points));
  line("constraint rows", fmt::format("{} ({} of drives)", system.rows() - points, system.drive_rows()));
  std::string names;
  for (int row : redundant) names += (names.empty() ? "" : ", ") + system.row_name(row);
  line("  of them redundant", redundant.empty() ? "0" : fmt::format("{}: {}", redundant.size(), names));
  line("degrees of freedom",
       fmt::format("{}", system.n() - system.rows() + static_cast<int>(redundant.size())));
  line("contacts", fmt::format("{}", system.contacts()));
  for (const auto& family : system.families())
    line("", fmt::format("{}: {} pairs, detected by proximity", family.name, family.pairs()));
  line("friction rows", fmt::format("{} of contacts, {} of joints", tangents, system.frictions()));
  line("instruments", fmt::format("{}", scene.instruments.size()));
  const SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic,
                           {!redundant.empty(), scene.run.eliminate});
  line("linear systems",
       saddle.blocks() == 0
           ? "none"
           : fmt::format("{} ({}, {}{} rows)", saddle.blocks(), saddle.dense() ? "dense" : "sparse",
                         saddle.blocks() > 1 ? "at most " : "", saddle.largest_block()));
  economies(scene, system, saddle, redundant, request.why);
  if (request.why) burdens(system);
  line("duration",
       fmt::format("{:.6g} s; statistics exclude the first {:.6g} s", scene.run.duration, scene.run.discard));

  const auto output = estimate_output(scene, start);
  line("estimated output", output.text());
  if (output.event_bytes > 0)
    line("", fmt::format("and events.csv, {:.0f} bytes per event; the number of events cannot be predicted",
                         output.event_bytes));
  if (!ideal->assumed.empty()) line("start", ideal->assumed);
  for (const auto& [what, said] : assembly_report(scene, start)) line(what.c_str(), said);

  beams(scene.mechanism);
  if (request.modes) reduction_errors(scene.mechanism, start);
  const auto teeth = teeth_at(scene.mechanism, start.q);
  for (int k = 0; k < system.reported(); ++k) {
    const auto& facts = system.contact_facts(k);
    fmt::print("\n  contact {}: ", facts.name);
    if (facts.has_clearance) fmt::print("clearance {:.4g} mm, ", 1e3 * facts.clearance);
    for (const auto& t : teeth)
      if (facts.name.starts_with(t.name + ".")) fmt::print("here {:.4g} mm, ", 0.5e3 * t.play);
    if (facts.stiffness)
      fmt::print("stiffness {:.5g} N/m\n", *facts.stiffness);
    else if (facts.radius > 0)
      fmt::print("radius of curvature {:.5g} mm\n", 1e3 * facts.radius);
    else
      fmt::print("a sharp corner\n");
    if (const auto e = facts.surface.slow_restitution())
      fmt::print("    restitution: input {:.4g}{}\n", *e,
                 facts.surface.restitution_by_speed() ? " at low approach speeds" : "");
    if (facts.surface.friction_by_speed())
      fmt::print("    friction: {:.4g} at rest, {:.4g} far beyond the sliding speed of {:.4g} m/s\n",
                 facts.surface.friction_at_rest(), *facts.surface.friction,
                 *facts.surface.peak.stribeck_speed);
    film_range(facts);
  }
  if (system.reported() > 0) fmt::print("  which contact law: docs/how-to/contact-law.md\n");
  int available = 0;
  for (const auto& [family, name] : families) {
    try {
      const auto formulation = make(family, scene, system, start);
      const auto models = formulation->contact_models();
      for (int k = 0; k < system.reported(); ++k) {
        const auto& m = models[k];
        const auto& facts = system.contact_facts(k);
        fmt::print("  {:<10} {}: effective restitution {:.4g}{}", name, facts.name, m.restitution_delivered,
                   facts.surface.restitution_by_speed() ? " at low approach speeds" : "");
        if (m.stiffness > 0)
          fmt::print("\n  {:<10}   K = {:.5g} N/m^{}, chi = {:.4g}", "", m.stiffness, m.exponent, m.chi);
        fmt::print("\n");
      }
      ++available;
    } catch (const ModelError& e) {
      fmt::print("{}", wrapped(fmt::format("  {:<10} not available: {}\n", name, e.what()), 13));
    }
  }
  if (!request.output.empty()) draw_pose(scene, start, request.output, request.magnify);
  return available > 0 ? 0 : 2;
}

}  // namespace

void check_verb(Program& program) {
  auto [options, request] =
      program.verb("check",
                   "read and validate a scene; report degrees of freedom, constraints and problem "
                   "size",
                   check);
  options.scene(request.scene);
  options.set(request.overrides);
  options.allow_outside(request.reach);
  options.flag("--why", request.why,
               "explain the contribution of each element, and why parts are eliminated or not used");
  options.flag("--keys", request.keys, "list all keys of scenes instead");
  options.flag("--bounds", request.bounds, "list the bounds of values by unit instead");
  options.flag("--units", request.units, "list the accepted units instead");
  options.flag("--modes", request.modes, "compare frequencies of reduced beams with those of full beams");
  auto output =
      options.output(request.output, "folder for a figure of the assembled pose; default: no figure");
  options
      .add("--magnify", request.magnify,
           "factor of the deflection of beams, and of clearance and deviations of "
           "joints with profiles, in the figure; default 1")
      .number([](double x) { return x > 0 && x <= 1e9; }, "must be a number greater than 0, at most 1e9")
      .takes("FACTOR")
      .needs(output);
}

}  // namespace freeplay::cli
