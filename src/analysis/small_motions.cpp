#include "analysis/small_motions.hpp"

#include <nlohmann/json.hpp>
#include <vector>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "formulations/make.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

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

}  // namespace

SmallMotions small_motions(const Scene& scene, const System& system, Family family, bool about_start,
                           const StopToken& stop) {
  using Start = RunOptions::Start;
  const auto elastic = compliances(family, scene, system);
  const bool rests = scene.run.start == Start::equilibrium;
  const auto from = assemble(scene.mechanism, rests ? Start::assembled : scene.run.start, nullptr, stop);
  SmallMotions found{.family = family, .about_start = about_start, .at = {}, .modes = {}};
  found.at = about_start ? as_it_stands(system, from, elastic, found.left)
                         : find_equilibrium(scene.mechanism, system, from.q, elastic, stop);
  found.modes = find_modes(system, found.at, elastic);
  return found;
}

std::string coordinate_name(const Scene& scene, int i) {
  return scene.mechanism.bodies[planar::body_of(i)].name + "." + planar::name(i);
}

SmallMotionTables::SmallMotionTables(const Scene& scene, const System& system, const SmallMotions& found)
    : modes("mode,kind,s_re,s_im,natural_hz,swing_hz,damping_ratio"),
      positions("body,x,y,theta"),
      forces("element,fx,fy,m,fn") {
  for (int i = 0; i < system.n(); ++i)
    for (const char* part : {".re", ".im"}) modes.column(coordinate_name(scene, i) + part);
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
  const double* q = found.at.state.q.data();
  for (std::size_t b = 0; b < scene.mechanism.bodies.size(); ++b) {
    const auto at = planar::position(q, b);
    positions.row(scene.mechanism.bodies[b].name, at.x(), at.y(), planar::angle(q, b));
  }
  const auto all = static_forces(system, found.at);
  for (std::size_t i = 0; i < all.elements.size(); ++i) {
    const auto& f = all.elements[i];
    forces.row(system.report().elements[i].name, f.fx, f.fy, f.m, f.fn);
  }
}

nlohmann::json to_json(const SmallMotions& found) {
  return {{"formulation", name_of(found.family)},
          {"about", found.about_start ? "start" : "equilibrium"},
          {"stability", found.about_start ? "not judged" : describe(found.at)},
          {"unanswered_N", found.left},
          {"steps", found.at.steps},
          {"arm_m", found.modes.length}};
}

}  // namespace freeplay
