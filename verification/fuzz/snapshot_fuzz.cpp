// A fuzz target for snapshots: bytes as a file, bytes under a correct checksum, and bytes as the
// serialized state of a simulation. Each is accepted or refused with one SnapshotError. An accepted
// snapshot runs on for a while or stops with a reason; a refused one leaves the simulation
// unchanged.
#include <atomic>

#include "facade/simulation.hpp"
#include "io/files/sealed.hpp"
#include "mechanism/scene.hpp"
#include "verification/fuzz/judged.hpp"

using namespace freeplay;

namespace {

const char* const text = R"([bodies.a]
mass = 1
inertia = 0.1
position = [0.0002, 0]
velocity = [1, 0]
[joints.j]
type = "revolute"
between = ["ground", "a"]
clearance = 1e-3
bearing_radius = 1e-2
surface = "s"
[surfaces.s]
young = 2e11
poisson = 0.3
restitution = 0.5
friction = 0.1
[instruments.i]
body = "a"
bandwidth = 100
sampling = 1000
[run]
duration = 0.02
start = "given"
)";

Simulation make(const char* formulation, double until) {
  Simulation simulation(parse_scene(text, "fuzz"), formulation);
  simulation.run({.until = until});
  return simulation;
}

}  // namespace

/// Seeds: a folder to write them to.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  for (int i = 1; i + 1 < *argc; ++i)
    if (std::string((*argv)[i]) == "-seeds") {
      const std::filesystem::path folder = (*argv)[i + 1];
      for (const auto* formulation : {"penalty", "nonsmooth"})
        for (const double until : {0.0, 1e-3, 5e-3}) {
          const auto name = formulation + std::to_string(until);
          const auto snapshot = make(formulation, until).snapshot();
          snapshot.write(folder / (name + ".snapshot"));
          std::ofstream out(folder / (name + ".memory"), std::ios::binary);
          out.put(formulation[0] == 'p' ? 2 : 3);
          out.write(reinterpret_cast<const char*>(snapshot.memory.data()),
                    static_cast<std::streamsize>(snapshot.memory.size()));
        }
      std::exit(0);
    }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  try {
    if (data[0] == 1) {
      const auto file = fuzz::file_of(data, 0, "sealed.snapshot");
      write_sealed(file, "snapshot", 1, {bytes + 1, bytes + size});
      Snapshot::read(file);
    } else if (data[0] == 2 || data[0] == 3) {
      static auto penalty = make("penalty", 0), nonsmooth = make("nonsmooth", 0);
      static const auto penalty_start = penalty.snapshot(), nonsmooth_start = nonsmooth.snapshot();
      auto& simulation = data[0] == 2 ? penalty : nonsmooth;
      const auto& start = data[0] == 2 ? penalty_start : nonsmooth_start;
      simulation.restore(start);
      auto changed = start;
      changed.memory.assign(bytes + 1, bytes + size);
      try {
        simulation.restore(changed);
      } catch (const SnapshotError&) {
        if (simulation.snapshot().memory != start.memory) std::abort();
        throw;
      }
      // Like Ctrl-C: a long run obeys the stop request.
      static std::atomic<bool> stop{false};
      stop = false;
      std::size_t steps = 0;
      struct Count final : Observer {
        std::size_t& steps;
        explicit Count(std::size_t& counted) : steps(counted) {}
        void step(const Step&) override {
          if (++steps > 200) stop = true;
        }
      } count(steps);
      simulation.run({.until = simulation.t() + 1e-3, .observers = {&count}, .stop = StopToken(stop)});
    } else {
      Snapshot::read(fuzz::file_of(data, size, "file.snapshot"));
    }
  } catch (const SnapshotError& e) {
    fuzz::assess(e, fuzz::text_of(data, size));
  }
  return 0;
}
