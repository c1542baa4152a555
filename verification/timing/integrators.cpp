// Cost and accuracy of every integrator on the paper's scene (target freeplay-integrators): one run
// each, up to ten contacts; error of the times of the second and tenth contact against dopri5 at
// 1e-13. Prints Markdown, for docs/development/decisions/005-default-integrator.md. The second
// table is for the exact law without friction over 0.3 s.
#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "mechanism/scene.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;

namespace {

struct Row {
  std::vector<ContactEvent> touches;
  Work work;
  double milliseconds = 0;
};

Row measure(const Scene& scene) {
  Row row;
  row.milliseconds = INFINITY;
  for (int i = 0; i < 3; ++i) {
    const auto run = test::simulate(scene, Family::penalty);
    row.touches = test::touches(run);
    row.work = run.work;
    row.milliseconds = std::min(row.milliseconds, 1e3 * run.wall_seconds);
    if (run.ending.status != Ending::Status::finished) row.touches.clear();
  }
  return row;
}

std::string error(const Row& row, const Row& exact, std::size_t touch) {
  if (touch >= row.touches.size() || touch >= exact.touches.size()) return "–";
  return fmt::format("{:.1e}", std::abs(row.touches[touch].t - exact.touches[touch].t));
}

void table(const char* title, Scene scene, std::size_t last) {
  const std::pair<Integrator, const char*> integrators[] = {
      {Integrator::dopri5, "dopri5"},
      {Integrator::bulirsch_stoer, "bulirsch_stoer"},
      {Integrator::adams_bashforth_moulton, "adams_bashforth_moulton"},
      {Integrator::rosenbrock4, "rosenbrock4"}};
  scene.penalty.integrator = Integrator::dopri5;
  scene.penalty.tolerance = 1e-13;
  const auto exact = measure(scene);
  fmt::print(
      "\n{}: {} contact onsets by {:.4g} s\n\n| integrator | tolerance or step | right-hand sides | ms "
      "| error of "
      "contact onset 2, s | "
      "of contact onset {}, s |\n| --- | --- | --- | --- | --- | --- |\n",
      title, exact.touches.size(), scene.run.duration, last + 1);
  const auto print = [&](const char* name, double setting) {
    const auto row = measure(scene);
    fmt::print("| {} | {:.0e} | {} | {:.1f} | {} | {} |\n", name, setting, row.work.rhs, row.milliseconds,
               error(row, exact, 1), error(row, exact, last));
  };
  for (const auto& [integrator, name] : integrators)
    for (double tolerance : {1e-5, 1e-7, 1e-9, 1e-11}) {
      scene.penalty.integrator = integrator;
      scene.penalty.tolerance = tolerance;
      print(name, tolerance);
    }
  scene.penalty.integrator = Integrator::rk4;
  for (double step : {1e-5, 1e-6}) {
    scene.penalty.step = step;
    print("rk4", step);
  }
}

}  // namespace

int main() {
  auto scene = read_scene(test::flores());
  scene.run.discard = 0;
  scene.run.duration = 0.3;
  scene.instruments.clear();
  const auto touches = test::touches(test::simulate(scene, Family::penalty));
  if (touches.size() > 9) scene.run.duration = touches[9].t + 1e-4;
  table("Paper's law (Lankarani-Nikravesh), friction 0.01", scene, 9);
  scene.run.duration = 0.3;
  scene.penalty.contact = ContactLaw::exact;
  scene.mechanism.surfaces[0].friction.reset();
  table("Exact law, frictionless", scene, 2);
}
