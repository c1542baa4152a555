// freeplay modes: equilibrium of a mechanism, its stability, and its natural frequencies.
#include "dynamics/assembly/modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "cli/command_line.hpp"
#include "cli/scene_report.hpp"
#include "cli/terminal.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "formulations/make.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/scene.hpp"
#include "values/table.hpp"

namespace freeplay::cli {
namespace {

struct ModesRequest : Request {
  std::string scene, formulation = "nonsmooth", about = "equilibrium";
  std::vector<std::string> overrides;
  Reach reach = Reach::beside;  ///< permitted files of the scene
  std::string output;           ///< result folder; empty: no files
};

/// Results of the verb.
struct Found {
  Equilibrium at;
  Modes modes;
  double left = 0;  ///< N, unbalanced force when linearised about the start
};

Found find(const Scene& scene, const System& system, Family family, bool at_start, const StopToken& stop) {
  using Start = RunOptions::Start;
  const auto elastic = compliances(family, scene, system);
  const bool rests = scene.run.start == Start::equilibrium;
  const auto from = assemble(scene.mechanism, rests ? Start::assembled : scene.run.start, nullptr, stop);
  Found found;
  found.at = at_start ? as_it_stands(system, from, elastic, found.left)
                      : find_equilibrium(scene.mechanism, system, from.q, elastic, stop);
  found.modes = find_modes(system, found.at, elastic);
  return found;
}

std::string coordinate(const Scene& scene, int i) {
  return scene.mechanism.bodies[planar::body_of(i)].name + "." + planar::name(i % planar::coordinates);
}

const char* word(Mode::Kind kind) {
  switch (kind) {
    case Mode::Kind::swing:
      return "swing";
    case Mode::Kind::decay:
      return "decay";
    case Mode::Kind::growth:
      return "growth";
    default:
      return "free";
  }
}

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
    text += (i > 0 ? ", " : "") + coordinate(scene, order[i]) +
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

void print(const Scene& scene, const System& system, const ModesRequest& request, const Found& found) {
  const auto& at = found.at;
  fmt::print("{}\n\n", scene.mechanism.title.empty() ? scene.file.string() : scene.mechanism.title);
  if (request.about == "equilibrium")
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
                       request.formulation, found.modes.length)));
  for (std::size_t i = 0; i < found.modes.modes.size(); ++i)
    print_mode(scene, i + 1, found.modes.modes[i], found.modes.length);
  const auto out = left_out(scene, system, found.at);
  if (!out.empty()) fmt::print("\nnot included:\n");
  for (const auto& what : out) fmt::print("{}", wrapped("  " + what + "\n", 4));
}

/// Writes modes.csv, equilibrium.csv and modes.json.
void write(const Scene& scene, const System& system, const ModesRequest& request, const Found& found,
           const std::filesystem::path& folder) {
  Table modes("mode,kind,s_re,s_im,natural_hz,swing_hz,damping_ratio"), places("body,x,y,theta"),
      forces("element,fx,fy,m,fn");
  for (int i = 0; i < system.n(); ++i)
    for (const char* part : {".re", ".im"}) modes.column(coordinate(scene, i) + part);
  for (std::size_t i = 0; i < found.modes.modes.size(); ++i) {
    const auto& m = found.modes.modes[i];
    std::vector<Table::Cell> row{static_cast<std::int64_t>(i + 1),
                                 word(m.kind),
                                 m.s.real(),
                                 m.s.imag(),
                                 m.natural(),
                                 m.swinging(),
                                 m.damping()};
    for (const auto& x : m.shape) row.insert(row.end(), {x.real(), x.imag()});
    modes.row(std::move(row));
  }
  for (std::size_t b = 0; b < scene.mechanism.bodies.size(); ++b) {
    const double* q = found.at.state.q.data();
    const auto at = planar::position(q, b);
    places.row(scene.mechanism.bodies[b].name, at.x(), at.y(), planar::angle(q, b));
  }
  const auto all = static_forces(system, found.at);
  for (std::size_t i = 0; i < all.elements.size(); ++i) {
    const auto& f = all.elements[i];
    forces.row(system.force_elements()[i].name, f.fx, f.fy, f.m, f.fn);
  }
  write_file(folder / "modes.csv", modes.csv());
  write_file(folder / "equilibrium.csv", places.csv());
  write_file(folder / "static_forces.csv", forces.csv());
  write_json(folder / "modes.json",
             {{"formulation", request.formulation},
              {"about", request.about},
              {"stability", request.about == "equilibrium" ? describe(found.at) : "not judged"},
              {"unanswered_N", found.left},
              {"steps", found.at.steps},
              {"arm_m", found.modes.length},
              {"provenance", provenance(scene)}});
}

int modes(const ModesRequest& request) {
  const Scene scene = read_scene(request.scene, request.overrides, request.reach == Reach::anywhere);
  ask(scene);
  const System system(scene.mechanism);
  const auto family = family_named(request.formulation).value();
  const auto found =
      located_in(scene, [&] { return find(scene, system, family, request.about == "start", request.stop); });
  print(scene, system, request, found);
  if (!request.output.empty()) {
    const auto folder = real_folder(request.output);
    ResultSet set(folder, "modes");
    write(scene, system, request, found, set.place());
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
