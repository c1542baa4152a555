// Stated properties of result files and comparisons: complete output rows, no false pairs of impacts,
// and a correct report of matched restitution.
#include <nlohmann/json.hpp>

#include "simulation/trajectory.hpp"
#include "study/comparison/compare.hpp"
#include "verification/claims/claim.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

/// The number of durations for which a trajectory lacks its 20001 rows, or its last row is not at
/// the end.
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

/// The number of false pairs in four comparisons whose second impacts belong to different motions.
int false_pairs() {
  int pairs = 0;
  for (const double apart : {0.05, 0.1, 0.487, 0.9})
    pairs +=
        static_cast<int>(pair_impacts({impact(1, 1), impact(3, 1)}, {impact(1, 1), impact(3 + apart, 1)}, 1)
                             .pairs.size()) -
        1;
  return pairs;
}

/// Whether comparison.json reports equal restitution of both formulations.
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

void rows_pairs_and_matching(Findings& f) {
  f.within(
      "trajectory of a spinning rod: runs of 40 (0.01 to 0.4 s) without 20001 rows, "
      "the last at the end [event-driven]",
      "", lost_rows(), 0, 0, "default output step: duration/20000", "exact");
  f.within("pairing of impacts 50 to 900 ms apart after 2 s of flight: false pairs in 4 comparisons", "",
           false_pairs(), 0, 0, "none: the distance exceeds that of probable pairs", "exact");
  f.within("comparison of the paper's slider-crank: restitution_matched for laws of equal restitution", "",
           called_matched(0), 1, 0, "true (1)", "exact");
  f.within("comparison of the paper's slider-crank: restitution_matched for a tangential restitution of 0.9",
           "", called_matched(0.9), 0, 0, "false (0): the contact law has no tangential restitution",
           "exact");
}

}  // namespace

Parts stated_error_bounds() { return {rows_pairs_and_matching}; }

}  // namespace freeplay::verification
