// events SCENE FORMULATION UNTIL [KEY=VALUE]...: the events of a run as they come, all columns of
// events.csv and all digits.
#include <freeplay.hpp>

#include <cstdio>
#include <cstdlib>

namespace {

/// Writes each event once it is final; nothing is stored.
class Printer final : public freeplay::Observer {
 public:
  void event(const freeplay::Event& e) override {
    std::printf("%.17g,%s,%s", e.t, e.joint.c_str(), freeplay::name_of(e.kind));
    for (const double x : {e.crank_angle, e.v_n_minus, e.v_n_plus, e.v_t_minus, e.v_t_plus, e.impulse_n,
                           e.impulse_t, e.duration, e.t_uncertainty})
      std::printf(",%.17g", x);
    std::printf("\n");
  }
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 4) return 2;
  auto scene = freeplay::read_scene(argv[1], {argv + 4, argv + argc});
  freeplay::Simulation simulation(scene, argv[2]);
  Printer printer;
  const auto result =
      simulation.run({.until = std::atof(argv[3]), .observers = {&printer}, .keep_events = false});
  if (result.ending.status == freeplay::Ending::Status::finished) return 0;
  std::fprintf(stderr, "%s\n", result.ending.reason.c_str());
  return 1;
} catch (const freeplay::ModelError& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 2;
}
