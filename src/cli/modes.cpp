// freeplay modes: equilibrium of a mechanism, its stability, and its natural frequencies.
#include "analysis/small_motions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "cli/command_line.hpp"
#include "cli/scene_report.hpp"
#include "cli/terminal.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/scene.hpp"

namespace freeplay::cli {
namespace {

struct ModesRequest : Request {
  std::string scene, formulation = "nonsmooth", about = "equilibrium";
  std::vector<std::string> overrides;
  Reach reach = Reach::beside;  ///< permitted files of the scene
  std::string output;           ///< result folder; empty: no files
};

/// The coordinates that move most in a mode; angles are multiplied by a length.
std::string shape(const Scene& scene, const Mode& m, double length) {
  const auto size = [&](int i) { return std::abs(m.shape[i]) * (i % planar::coordinates == 2 ? length : 1); };
  std::vector<int> order(m.shape.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  std::ranges::stable_sort(order, [&](int a, int b) { return size(a) > size(b) * (1 + 1e-9); });
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(4, order.size()) && size(order[i]) > 1e-3; ++i) {
    const auto x = m.shape[order[i]];
    const bool turned = std::abs(x.imag()) > 1e-6 * std::abs(x);
    text += (i > 0 ? ", " : "") + coordinate_name(scene, order[i]) +
            fmt::format(" {:.4g}", turned ? std::abs(x) : x.real());
    if (turned) text += fmt::format(" at {:.0f}°", std::arg(x) * 180 / std::numbers::pi);
  }
  return text;
}

void print_mode(const Scene& scene, std::size_t number, const Mode& m, double length) {
  std::string what;
  switch (m.kind) {
    case Mode::Kind::swing:
      what = fmt::format("{:>14.7g} Hz   damping ratio {:.4g}", m.swinging(), m.damping());
      break;
    case Mode::Kind::decay:
      what = fmt::format("{:>14} Hz   decays by {:.6g} 1/s", "-", -m.s.real());
      break;
    case Mode::Kind::growth:
      what = fmt::format("{:>14.7g} Hz   UNSTABLE: grows by {:.6g} 1/s", m.swinging(), m.s.real());
      break;
    case Mode::Kind::free:
      what = fmt::format("{:>14} Hz   free: no stiffness", 0);
      break;
  }
  fmt::print("{:>4} {}\n{}", number, what, wrapped("       " + shape(scene, m, length) + "\n", 9));
}

/// Properties of this scene that the linearisation neglects.
std::vector<std::string> left_out(const Scene& scene, const System& system, const Equilibrium& at) {
  std::vector<std::string> list;
  for (int k = 0; k < system.phases(); ++k) {
    const auto& phase = system.phase(k);
    if (phase.contact) continue;
    const double place = phase.at(at.state.q.data(), at.state.v.data()).value;
    if (phase.piece(place, true).low != phase.piece(place, false).low)
      list.emplace_back(
          "the other side of a kink of a table or a one-way force, where the stiffness differs");
  }
  bool friction = system.frictions() > 0, film = false, turns = false;
  for (int k = 0; k < system.contacts(); ++k) {
    friction |= system.has_friction(k);
    film |= system.contact_facts(k).lubricant.has_value();
  }
  for (const auto& d : scene.mechanism.drives)
    if (const auto* speed = std::get_if<SpeedDrive>(&d)) turns |= speed->speed != 0;
  if (friction) list.emplace_back("friction, which would allow a range of equilibria");
  if (film) list.emplace_back("films, which carry no load at rest");
  if (system.contacts() > 0) list.emplace_back("contact damping, which depends on the impact speed");
  if (turns) list.emplace_back("the speeds of drives: their joints are fixed at the initial angles");
  return list;
}

void print(const Scene& scene, const System& system, const SmallMotions& found) {
  const auto& at = found.at;
  fmt::print("{}\n\n", scene.mechanism.title.empty() ? scene.file.string() : scene.mechanism.title);
  if (!found.about_start)
    fmt::print("{}", wrapped(fmt::format("equilibrium, {}; reached by descent in {} steps\n", describe(at),
                                         at.steps)));
  else
    fmt::print("{}",
               wrapped(fmt::format("about the initial state; {:.3g} N are not balanced\n", found.left)));
  for (int k = 0; k < system.contacts(); ++k)
    fmt::print("  contact {}: {}\n", system.contact_facts(k).name,
               at.normal[k] > 0 ? fmt::format("contact force {:.6g} N", at.normal[k]) : "open");
  fmt::print("{}", wrapped(fmt::format(
                       "{} small motion{}, {} formulation; mode shapes scaled to 1 m, angles in rad times "
                       "{:.4g} m\n\n",
                       found.modes.modes.size(), found.modes.modes.size() == 1 ? "" : "s",
                       name_of(found.family), found.modes.length)));
  for (std::size_t i = 0; i < found.modes.modes.size(); ++i)
    print_mode(scene, i + 1, found.modes.modes[i], found.modes.length);
  const auto out = left_out(scene, system, found.at);
  if (!out.empty()) fmt::print("\nnot included:\n");
  for (const auto& what : out) fmt::print("{}", wrapped("  " + what + "\n", 4));
}

int modes(const ModesRequest& request) {
  const Scene scene = read_scene(request.scene, request.overrides, request.reach == Reach::anywhere);
  ask(scene);
  const System system(scene.mechanism);
  const auto family = family_named(request.formulation).value();
  const auto found = located_in(
      scene, [&] { return small_motions(scene, system, family, request.about == "start", request.stop); });
  print(scene, system, found);
  if (!request.output.empty()) {
    const auto folder = real_folder(request.output);
    ResultSet set(folder, "modes");
    const SmallMotionTables tables(scene, system, found);
    write_file(set.place() / "modes.csv", tables.modes.csv());
    write_file(set.place() / "equilibrium.csv", tables.positions.csv());
    write_file(set.place() / "static_forces.csv", tables.forces.csv());
    write_json(set.place() / "modes.json", to_json(found), provenance(scene));
    set.commit();
    fmt::print("\nresults in {}\n", folder.string());
  }
  return 0;
}

}  // namespace

void modes_verb(Program& program) {
  auto [options, request] =
      program.verb("modes", "compute equilibrium, stability and natural frequencies", modes);
  options.scene(request.scene).required();
  options.set(request.overrides);
  options.allow_outside(request.reach);
  options.formulation(request.formulation, "penalty: compliant contacts; nonsmooth: rigid contacts");
  options.add("--about", request.about, "equilibrium, or the initial state")
      .one_of({"equilibrium", "start"})
      .shows_default();
  options.output(request.output, "result folder; default: no files");
}

}  // namespace freeplay::cli
