#include "facade/layout.hpp"

#include "dynamics/system.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {

Layout layout_of(const Scene& scene, const System& system, const State& start) {
  Layout l;
  for (const auto& b : scene.mechanism.bodies) l.bodies.push_back(b.name);
  for (int k = 0; k < system.contacts(); ++k) l.contacts.push_back(system.contact_facts(k).name);
  for (const auto& f : system.families()) l.families.push_back(f.name);
  for (const auto& i : scene.instruments) l.channels.push_back(i.name);
  l.forces = system.force_elements();
  auto e = system.make_evaluation();
  system.place(start.t, start.q.data(), e);
  for (int k = 0; k < system.contacts(); ++k) {
    const auto eccentricity = system.eccentricity(k, start.q.data(), e);
    l.start.push_back({eccentricity.x(), eccentricity.y(), system.gap(k, start.q.data(), e)});
  }
  l.duration = l.end = scene.run.duration;
  l.output_step = scene.run.output_step.value_or(scene.run.duration / 20000);
  if (const auto* drive = main_drive(scene.mechanism)) {
    l.crank_speed = drive->speed;
    l.crank_start = drive->initial_angle;
  }
  return l;
}

}  // namespace freeplay
