// The cost ladder from a pendulum to the test rig of the paper with all elements: the cost that
// each rung adds. With two arguments, RUNG and FORMULATION, it runs only that rung (for counting
// instructions, scripts/benchmark ladder); with "loose" and COUNT it runs a row of COUNT four-bars
// with clearance by penalty; without arguments it prints the table of times.
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "facade/simulation.hpp"
#include "formulations/contact/contact_law.hpp"
#include "formulations/penalty/dynamics.hpp"
#include "mechanism/scene.hpp"
#include "numerics/saddle_point.hpp"
#include "simulation/statistics.hpp"
#include "verification/references/slider_crank_oracle.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;

namespace {

struct Rung {
  std::string name;
  Scene scene;
};

std::vector<Rung> ladder() {
  std::vector<Rung> rungs;
  auto pendulum = read_scene(test::scene_file("pendulum"));
  pendulum.mechanism = idealised(pendulum.mechanism);
  rungs.push_back({"pendulum", pendulum});
  auto rig = read_scene(test::flores());
  const auto instruments = rig.instruments;
  rig.instruments.clear();
  rig.penalty.contact = ContactLaw::exact;
  auto ideal = rig;
  ideal.mechanism = idealised(rig.mechanism);
  rungs.push_back({"rig, ideal", ideal});
  ideal.run.eliminate = false;
  rungs.push_back({"rig, ideal, not eliminated", ideal});
  auto smooth = rig;
  smooth.mechanism.surfaces[0].friction.reset();
  rungs.push_back({"rig, loose, frictionless", smooth});
  rungs.push_back({"rig, loose, friction", rig});
  auto whole = rig;
  whole.run.eliminate = false;
  rungs.push_back({"the same, not eliminated", whole});
  auto watched = rig;
  watched.instruments = instruments;
  rungs.push_back({"with accelerometer", watched});
  auto guided = read_scene(test::source_folder() / "cases/flores2011-experiment/guide.toml");
  guided.penalty.contact = ContactLaw::exact;
  rungs.push_back({"with guide friction and LVDT", guided});
  return rungs;
}

Result go(Scene scene, Family family, double duration) {
  scene.run.duration = duration;
  scene.run.discard = 0;
  // Instruments are inactive while no observer requests their samples.
  ContactStatistics statistics(0);
  test::Listener samples;
  std::vector<Observer*> observers{&statistics};
  if (!scene.instruments.empty()) {
    samples.on_sample = [](std::size_t, double, double) {};
    observers.push_back(&samples);
  }
  return Simulation(scene, test::name_of(family)).run({.observers = observers});
}

double seconds(const auto& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// One call of the penalty formulation's right-hand side with the contact, if any, closed (µs).
double right_hand_side(const Scene& scene, double& sum) {
  const System system(scene.mechanism);
  const auto start = assemble(scene.mechanism, scene.run.start);
  std::vector<PenaltyContact> contacts(static_cast<std::size_t>(system.contacts()));
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    contacts[k].law.elastic.stiffness = 1.055e11;
    contacts[k].law.chi = 1.66;
    if (system.has_friction(static_cast<int>(k))) {
      contacts[k].friction = make_friction(scene.penalty, 0.01);
      contacts[k].zone = contacts[k].friction->zone(0.05);
    }
    contacts[k].closed = true;
  }
  PenaltyDynamics f(system, scene.penalty, contacts, {false, scene.run.eliminate});
  std::vector<double> x(f.size(), 0.0), dxdt(f.size());
  std::ranges::copy(start.q, x.begin());
  std::ranges::copy(start.v, x.begin() + system.n());
  if (!contacts.empty()) x[6] += 0.251e-3;  // the slider against the wall
  const int calls = 300000;
  return 1e6 / calls * seconds([&] {
           for (int i = 0; i < calls; ++i) {
             f(x, dxdt, 1e-7 * i);
             sum += dxdt[0];
           }
         });
}

/// The same for the oracle: two coordinates derived by hand, in double.
double oracle_side(double& sum) {
  reference::LooseSliderCrank<double> m;
  auto y = reference::ideal_start(m);
  y[2] += 2e-4;
  const int calls = 2000000;
  return 1e6 / calls * seconds([&] {
           for (int i = 0; i < calls; ++i) {
             const double t = 1e-7 * i;
             const auto k = reference::gudgeon_contact(m, t, y);
             const auto r = reference::loose_rates(m, t, y, k.w_n[0], k.w_n[1]);
             sum += r[1] + k.u_n + k.u_t;
           }
         });
}

}  // namespace

int main(int argc, char** argv) {
  const auto rungs = ladder();
  if (argc == 4 &&
      // RUNG FORMULATION DURATION: prints steps and right-hand sides
      std::string_view(argv[1]) != "loose") {
    const auto& rung = rungs.at(static_cast<std::size_t>(std::atoi(argv[1])));
    const auto run =
        go(rung.scene, argv[2][0] == 'p' ? Family::penalty : Family::nonsmooth, std::atof(argv[3]));
    fmt::print("{} {} {}\n", run.work.steps, run.work.rhs, rung.name);
    return 0;
  }
  if (argc == 4) {
    auto row = test::row_of_four_bars(std::atoi(argv[2]), 1e-3);
    row.penalty.contact = ContactLaw::exact;
    double best = INFINITY;
    Result run;
    for (int i = 0; i < 3; ++i) {
      run = go(row, Family::penalty, std::atof(argv[3]));
      best = std::min(best, run.cpu_seconds);
    }
    fmt::print("{} steps, {} right-hand sides, {:.3f} us each\n", run.work.steps, run.work.rhs,
               1e6 * best / static_cast<double>(run.work.rhs));
    return 0;
  }
  double sum = 0;
  fmt::print("{:<30}{:>5}{:>6}{:>8}{:>8}{:>9}{:>9}{:>7}{:>8}{:>7}\n", "", "rows", "elim.", "contact",
             "tangent", "us/step", "run/rhs", "rhs", "oracle", "ratio");
  for (const auto& rung : rungs) {
    const System system(rung.scene.mechanism);
    const SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic,
                             {false, rung.scene.run.eliminate});
    int tangents = 0;
    for (int k = 0; k < system.contacts(); ++k) tangents += system.has_friction(k);
    std::vector<double> step, rhs, alone, oracle, ratio;
    for (int repeat = 0; repeat < 5; ++repeat) {
      alone.push_back(right_hand_side(rung.scene, sum));
      oracle.push_back(oracle_side(sum));
      ratio.push_back(alone.back() / oracle.back());
      const auto a = go(rung.scene, Family::nonsmooth, 1);
      step.push_back(1e6 * a.cpu_seconds / static_cast<double>(a.work.steps));
      try {
        const auto b = go(rung.scene, Family::penalty, 1);
        rhs.push_back(1e6 * b.cpu_seconds / static_cast<double>(b.work.rhs));
      } catch (const ModelError&) {
        rhs.push_back(std::nan(""));
      }
    }
    for (auto* times : {&step, &rhs, &alone, &oracle, &ratio}) std::ranges::sort(*times);
    fmt::print("{:<30}{:>5}{:>6}{:>8}{:>8}{:>9.2f}{:>9.2f}{:>7.3f}{:>8.3f}{:>7.1f}\n", rung.name,
               system.rows(), saddle.eliminated().size(), system.contacts(), tangents, step[2], rhs[2],
               alone[2], oracle[2], ratio[2]);
  }
  fmt::print(
      "us; run/rhs: a penalty run's time over its right-hand sides; rhs: one alone, its contact closed;\n"
      "oracle: the same by hand in two coordinates, measured in turn with it; medians of five ({:.0g})\n",
      sum);
}
