#include <fmt/format.h>

#include "cli/commands.hpp"
#include "formulations/make.hpp"
#include "model/assembly.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay::cli {

int check(const Request& request) {
  const Scene scene = read_scene(request.scene, request.overrides);
  const System system(scene.mechanism);
  const State start = assemble(scene.mechanism, scene.run.start);
  const auto redundant = redundant_rows(system, start.q);
  int tangents = 0;
  for (int k = 0; k < system.contacts(); ++k) tangents += system.has_friction(k);

  fmt::print("{}\n\n", scene.mechanism.title.empty() ? scene.file.string() : scene.mechanism.title);
  const auto line = [](const char* name, const std::string& value) {
    fmt::print("  {:<28}{}\n", name, value);
  };
  line("bodies", fmt::format("{}", system.bodies()));
  line("coordinates", fmt::format("{}", system.n()));
  line("constraint rows", fmt::format("{} ({} of drives)", system.rows(), system.drive_rows()));
  std::string names;
  for (int row : redundant) names += (names.empty() ? "" : ", ") + system.row_name(row);
  line("  of them redundant", redundant.empty() ? "0" : fmt::format("{}: {}", redundant.size(), names));
  line("degrees of freedom",
       fmt::format("{}", system.n() - system.rows() + static_cast<int>(redundant.size())));
  line("contacts", fmt::format("{}", system.contacts()));
  line("friction rows", fmt::format("{} of contacts, {} of preloaded joints", tangents, system.frictions()));
  line("instruments", fmt::format("{}", scene.instruments.size()));
  const SaddlePoint saddle(system.mass(), system.pattern());
  line("saddle-point solves", fmt::format("{}, the largest of {} rows, {}", saddle.blocks(),
                                          saddle.largest_block(), saddle.dense() ? "dense" : "sparse"));
  line("duration",
       fmt::format("{:.6g} s, first {:.6g} s left out of statistics", scene.run.duration, scene.run.discard));

  for (int k = 0; k < system.contacts(); ++k) {
    const auto& facts = system.contact_facts(k);
    fmt::print("\n  contact {}: {} {:.4g} mm, radius of curvature {:.5g} mm\n", facts.name,
               facts.ring ? "clearance" : "measured by", 1e3 * facts.clearance, 1e3 * facts.radius);
    if (const auto e = facts.surface.restitution) fmt::print("    restitution asked for {:.4g}\n", *e);
  }
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    const char* name = family == Family::penalty ? "penalty" : "nonsmooth";
    try {
      const auto formulation = make(family, scene, system, start);
      const auto models = formulation->contact_models();
      for (int k = 0; k < system.contacts(); ++k) {
        const auto& m = models[k];
        fmt::print("  {:<10} {}: delivers restitution {:.4g}", name, system.contact_facts(k).name,
                   m.restitution_delivered);
        if (m.stiffness > 0) fmt::print(", K = {:.5g} N/m^{}, chi = {:.4g}", m.stiffness, m.exponent, m.chi);
        fmt::print("\n");
      }
    } catch (const SceneError& e) {
      fmt::print("  {:<10} not available: {}\n", name, e.what());
    }
  }
  return 0;
}

}  // namespace freeplay::cli
