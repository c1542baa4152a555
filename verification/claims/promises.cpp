// What runs and comparisons promise of their files and words: no row lost, no pair that is none, nothing called matched
// that is not.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "simulation/trajectory.hpp"
#include "study/comparison/compare.hpp"
#include "verification/claims/claim.hpp"
#include "verification/support/support.hpp"

namespace freeplay::verification {
namespace {

/// Durations at which a trajectory does not have its 20001 rows, the last of them at the end exactly.
int lost_rows() {
  int lost = 0;
  auto scene = read_scene(test::scene_file("spinning_rod"));
  scene.run.output_step.reset();
  scene.run.discard = 0;
  for (int k = 1; k <= 40; ++k) {
    scene.run.duration = k / 100.0;
    Simulation simulation(scene, "nonsmooth");
    Trajectory path;
    simulation.run({.observers = {&path}});
    lost += path.size() != 20001 || path.t(path.size() - 1) != scene.run.duration;
  }
  return lost;
}

ContactEvent impact(double t, double v) {
  ContactEvent e;
  e.t = t;
  e.v_n_minus = -v;
  e.v_n_plus = 0.5 * v;
  e.impulse_n = v;
  return e;
}

/// Pairs among touches of which only the first belongs to the other run's.
int pairs_of_strangers() {
  int pairs = 0;
  for (const double apart : {0.05, 0.1, 0.487, 0.9})
    pairs +=
        static_cast<int>(pair_impacts({impact(1, 1), impact(3, 1)}, {impact(1, 1), impact(3 + apart, 1)}, 1)
                             .pairs.size()) -
        1;
  return pairs;
}

/// Whether comparison.json calls a scene matched.
bool called_matched(double tangential) {
  auto scene = read_scene(test::flores());
  for (auto& s : scene.mechanism.surfaces) {
    s.friction = 0.1;
    s.tangential_restitution = tangential;
  }
  scene.run.duration = 1e-3;
  scene.run.discard = 0;
  const test::TemporaryFolder folder;
  return to_json(compare(scene, {}, folder.path())).at("restitution_matched").get<bool>();
}

}  // namespace

Findings promises() {
  Findings f;
  f.within("40 durations from 0.01 to 0.4 s: trajectories without their 20001 rows, the last at the end", "",
           lost_rows(), 0, 0, "duration over a 20000th of it", "counted");
  f.within("touches 50 to 900 ms apart after 2 s of flight: pairs", "", pairs_of_strangers(), 0, 0,
           "each is more than a tenth of what pairs that agree make probable", "counted");
  f.within("a scene whose laws deliver the same is called matched", "", called_matched(0), 1, 0,
           "the word's meaning", "");
  f.within("with a tangential restitution of 0.9, of which the contact law knows nothing, it is", "",
           called_matched(0.9), 0, 0, "the word's meaning", "");
  return f;
}

}  // namespace freeplay::verification
