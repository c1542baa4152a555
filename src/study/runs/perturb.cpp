#include "study/runs/perturb.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <random>
#include <variant>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/stated.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "facade/identify.hpp"
#include "facade/simulation.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/scene.hpp"
#include "study/runs/case_run.hpp"

namespace freeplay {

std::vector<double> ideal_pose(const Scene& scene, const StopToken& stop) {
  using Start = RunOptions::Start;
  if (scene.run.start == Start::given || scene.run.start == Start::equilibrium) return {};
  try {
    auto ideal = idealised(scene.mechanism);
    ideal.assembly.approximate = true;  // stated positions may be those with clearance
    auto q = assemble(ideal, scene.run.start, nullptr, stop).q;
    const System system(ideal);
    const auto independent = static_cast<std::size_t>(system.rows()) - redundant_rows(system, q).size();
    if (independent < q.size()) return {};
    return q;
  } catch (const ModelError&) {
    // A scene that closes only with displaced joints: the caller that displaces them reports
    // errors.
    return {};
  }
}

std::vector<double> ideal_pose(const Scene& scene, const StopToken& stop, SharedResults& shared) {
  Scene ideal = scene;
  ideal.mechanism = idealised(scene.mechanism);
  ideal.instruments.clear();
  return shared.poses(identify(ideal, "penalty", false).digest(), [&] { return ideal_pose(scene, stop); });
}

namespace {

/// Uniform in [0, 1), with equal results on all machines (the standard does not specify the
/// algorithm of its distributions).
double uniform(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-53; }

/// Random offset of a joint's first point within its clearance, one overload for each kind of
/// joint.
Vec2 play(const RevoluteJoint& joint, std::mt19937_64& engine, double share) {
  if (!joint.clearance) return {};
  const double r = share * joint.clearance->radial * std::sqrt(uniform(engine));
  const double angle = 2 * std::numbers::pi * uniform(engine);
  return {r * std::cos(angle), r * std::sin(angle)};
}
Vec2 play(const TranslationalJoint& joint, std::mt19937_64& engine, double share) {
  if (!joint.clearance) return {};
  const double across = share * joint.clearance->half_play * (2 * uniform(engine) - 1);
  return across * Vec2(-joint.axis.y(), joint.axis.x());
}
Vec2 play(const SlotJoint& joint, std::mt19937_64& engine, double share) {
  if (!joint.clearance) return {};
  const double across = share * joint.clearance->half_play * (2 * uniform(engine) - 1);
  return across * perp(joint.axis);
}
/// Teeth start in the middle of their backlash, which is no distance between the centres.
Vec2 play(const GearJoint&, std::mt19937_64&, double) { return {}; }
Vec2 play(const RackJoint&, std::mt19937_64&, double) { return {}; }
Vec2 play(const RatioJoint&, std::mt19937_64&, double) { return {}; }
Vec2 play(const RigidJoint&, std::mt19937_64&, double) { return {}; }
Vec2 play(const RodJoint&, std::mt19937_64&, double) { return {}; }

/// Displaces the points of the ideal mechanism's joints where the given joint has clearance.
void offset(Mechanism& ideal, const Mechanism& given, std::mt19937_64& engine, double share) {
  for (std::size_t i = 0; i < given.joints.size(); ++i)
    std::visit(
        [&](const auto& joint) {
          std::get<std::decay_t<decltype(joint)>>(ideal.joints[i]).at[0] += play(joint, engine, share);
        },
        given.joints[i]);
}

/// Whether a joint's point differs.
bool displaced(const Mechanism& moved, const Mechanism& given) {
  for (std::size_t i = 0; i < moved.joints.size(); ++i)
    if (std::visit(
            [&](const auto& joint) {
              return joint.at[0] != std::get<std::decay_t<decltype(joint)>>(given.joints[i]).at[0];
            },
            moved.joints[i]))
      return true;
  return false;
}

}  // namespace

bool differ(const Scene& scene, const Perturbation& how) {
  if (!how.vary.empty()) return true;
  const auto* drive = main_drive(scene.mechanism);
  if (how.turn > 0 && drive && drive->speed != 0) return true;
  // A random offset differs from zero if the joint has clearance.
  std::mt19937_64 engine;
  Mechanism moved = scene.mechanism;
  offset(moved, scene.mechanism, engine, how.play);
  return displaced(moved, scene.mechanism);
}

void require_differing_starts(const Scene& scene, const Perturbation& how, const std::string& use) {
  if (!differ(scene, how))
    throw AlikeStarts(fmt::format(
        "{}: all starts are identical: {}, and no joint has clearance to vary{}", scene.file.string(),
        how.turn > 0 ? "no drive has a prescribed speed" : "all keep its angles", use));
}

void require_variable(const Scene& scene, const std::vector<double>& near, const StopToken& stop,
                      const std::vector<InitialValue>& values) {
  if (values.empty()) return;
  const auto still = perturbed(scene, near, stop, 0, 0, {.turn = 0, .play = 0});
  for (const auto& value : values)
    for (const double by : {-value.half, value.half}) {
      auto state = stated_state(still.mechanism);
      located_in(scene, [&] { displace(still.mechanism, {value}, {by}, state, stop); });
    }
}

Scene perturbed(const Scene& scene, const StopToken& stop, std::uint64_t seed, int start,
                const Perturbation& how) {
  return perturbed(scene, ideal_pose(scene, stop), stop, seed, start, how);
}

Scene perturbed(const Scene& scene, const std::vector<double>& near, const StopToken& stop,
                std::uint64_t seed, int start, const Perturbation& how) {
  std::mt19937_64 engine(seed + 0x9e3779b97f4a7c15u * static_cast<std::uint64_t>(start));
  engine.discard(8);
  Scene ideal = scene;
  ideal.mechanism = idealised(scene.mechanism);
  ideal.instruments.clear();
  ideal.run.discard = 0;
  const double turned = how.turn * uniform(engine);
  offset(ideal.mechanism, scene.mechanism, engine, how.play);
  const bool shifted = displaced(ideal.mechanism, idealised(scene.mechanism));
  for (std::size_t b = 0; !near.empty() && b < ideal.mechanism.bodies.size(); ++b) {
    ideal.mechanism.bodies[b].position = planar::position(near.data(), b);
    ideal.mechanism.bodies[b].angle = planar::angle(near.data(), b);
  }

  ideal.mechanism.assembly.approximate = true;
  // Given positions satisfy the joints with their actual clearance, not with the random offsets.
  // Assemble instead.
  const auto from =
      scene.run.start == RunOptions::Start::given ? RunOptions::Start::assembled : scene.run.start;
  State state;
  try {
    state = located_in(scene, [&] { return assemble(ideal.mechanism, from, nullptr, stop); });
  } catch (const SceneError& e) {
    if (!shifted) throw;
    throw SceneError(fmt::format(
        "{}; the random start displaced joints by up to play = {:g} of their clearance: try play = 0",
        e.what(), how.play));
  }
  double time = 0;
  if (const auto* drive = main_drive(scene.mechanism); drive && drive->speed != 0 && turned > 0) {
    for (const auto& other : scene.mechanism.drives)
      if (const auto* motion = std::get_if<MotionDrive>(&other))
        throw SceneError(fmt::format(
            "{}: drives.{}: a motion along a curve begins at t = 0 and cannot start at other crank angles; "
            "use study.turn = 0",
            scene.file.string(), motion->name));
    time = turned * 2 * std::numbers::pi / std::abs(drive->speed);
    ideal.run.duration = time;
    Simulation simulation(ideal, "penalty", {.start = state, .stop = stop, .checked = true});
    const auto ending = simulation.run({.until = time, .keep_events = false, .stop = stop}).ending;
    if (ending.status == Ending::Status::interrupted) throw Interrupted();
    if (ending.status == Ending::Status::failed)
      throw SceneError(fmt::format("{}: the ideal mechanism cannot be assembled at a start: {}",
                                   scene.file.string(), ending.reason));
    state = simulation.state();
  }
  // Joints with clearance do not bind the given velocities, as their ideal ones do.
  if (scene.run.start == RunOptions::Start::given && time == 0)
    state.v = located_in(scene, [&] { return assemble(scene.mechanism, scene.run.start, nullptr, stop); }).v;
  Scene moved = scene;
  start_from(moved.mechanism, state);
  // A rotating four-bar may alternate between its open and crossed configurations, so conditions on
  // the pose apply at the scene's own angle only.
  if (time > 0) moved.mechanism.assembly = {};
  for (auto& drive : moved.mechanism.drives)
    if (auto* speed = std::get_if<SpeedDrive>(&drive)) speed->initial_angle += speed->speed * time;
  if (!how.vary.empty()) {
    std::vector<double> by;
    for (const auto& value : how.vary) by.push_back(value.half * (2 * uniform(engine) - 1));
    located_in(scene, [&] { displace(moved.mechanism, how.vary, by, state, stop); });
    start_from(moved.mechanism, state);
  }
  moved.run.start = RunOptions::Start::given;
  return moved;
}

}  // namespace freeplay
