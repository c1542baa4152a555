#include <freeplay.hpp>
#include <cstdio>
int main() {
  auto scene = freeplay::read_scene("scene.toml");
  scene.set("joints.gudgeon.clearance", "1e-3");
  freeplay::Simulation simulation(scene, "nonsmooth");
  freeplay::Trajectory path;
  const auto result = simulation.run({.until = 1.0, .observers = {&path}});
  for (const auto& e : result.events) std::printf("%.12g %s %g\n", e.t, e.joint.c_str(), e.impulse_n);
  const auto here = simulation.snapshot();
}
