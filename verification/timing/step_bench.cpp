// Cost of one step and of one right-hand side (target freeplay-bench). The figures belong to a machine;
// ratios of interleaved runs and instruction counts are what may be compared.
#include <benchmark/benchmark.h>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "formulations/contact/contact_law.hpp"
#include "formulations/penalty/dynamics.hpp"
#include "formulations/time_stepping/moreau.hpp"
#include "mechanism/scene.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;

namespace {

struct Setup {
  Scene scene = read_scene(FREEPLAY_SOURCE_DIR "/cases/flores2011/scene.toml");
  State start = assemble(scene.mechanism, scene.run.start);
  System system{scene.mechanism};
};

/// Steps of the reference scene as they come: flights, impacts, mostly lasting contact.
void nonsmooth_step(benchmark::State& state) {
  const Setup s;
  MoreauStepper stepper(s.system, s.scene.nonsmooth, 1e-5, {0.46}, RowFacts{});
  ContactLog log(1);
  stepper.start(s.start, log);
  while (stepper.t() < 0.05) benchmark::DoNotOptimize(stepper.step(1e9));
  for (auto _ : state) {
    benchmark::DoNotOptimize(stepper.step(1e9));
    log.advance(stepper.t());
    if (log.has_pending()) log.drain([](const ContactEvent&) {});
  }
}
BENCHMARK(nonsmooth_step);

/// Right-hand side with the contact open and closed.
void penalty_rhs(benchmark::State& state) {
  const Setup s;
  const bool closed = state.range(0) != 0;
  PenaltyContact contact;
  contact.law.elastic.stiffness = 1.055e11;
  contact.law.chi = 1.66;
  contact.friction = make_friction(s.scene.penalty, 0.01);
  contact.zone = contact.friction->zone(0.05);
  contact.closed = closed;
  PenaltyDynamics f(s.system, s.scene.penalty, {contact}, RowFacts{});
  std::vector<double> x(f.size(), 0.0), dxdt(f.size());
  std::copy(s.start.q.begin(), s.start.q.end(), x.begin());
  std::copy(s.start.v.begin(), s.start.v.end(), x.begin() + s.system.n());
  x[6] += closed ? 0.251e-3 : 0.1e-3;  // the slider against the wall, or in flight
  double t = 0;
  for (auto _ : state) {
    f(x, dxdt, t);
    benchmark::DoNotOptimize(dxdt.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(penalty_rhs)->Arg(0)->Arg(1)->ArgName("closed");

}  // namespace

BENCHMARK_MAIN();
