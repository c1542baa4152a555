// Scenes of a special kind: singular positions, redundancy, no motion, long runs, Painlevé.
#include "verification/random_scenes/extremes/extremes.hpp"
#include "verification/references/slider_crank.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::random_scenes {

Scene ideal_rig() {
  auto scene = read_scene(test::flores());
  scene.mechanism = idealised(scene.mechanism);
  scene.instruments.clear();
  scene.run.discard = 0;
  return scene;
}

namespace {

/// A formulation, or a scheme of one.
struct Way {
  const char* name;
  Family family;
  Scheme scheme = Scheme::moreau_jean;
};
constexpr Way ways[] = {{"penalty", Family::penalty},
                        {"moreau-jean", Family::nonsmooth},
                        {"event-driven", Family::nonsmooth, Scheme::event_driven}};

Result simulate(Scene scene, const Way& way) {
  scene.nonsmooth.scheme = way.scheme;
  return test::simulate(scene, way.family);
}

/// Slider-crank with l = r: at 90° the slider is above the shaft and may stay there.
Verdict equal_lengths(const Way& way) {
  auto scene = ideal_rig();
  std::get<RevoluteJoint>(scene.mechanism.joints[1]).at[1] = {-0.025, 0};
  std::get<RevoluteJoint>(scene.mechanism.joints[2]).at[0] = {0.025, 0};
  scene.run.duration = 0.2;  // two thirds of a revolution: through 90°
  const auto run = simulate(scene, way);
  return within(run, std::abs(run.final_state.q[6] - 0.1 * std::cos(run.final_state.q[2])), 1e-4,
                "slider off 2r cos φ (m)");
}

/// A parallelogram driven through its change points: the coupler stays parallel to the ground. Or
/// one started at a change point.
Verdict parallelogram(const Way& way, bool at_change) {
  const double x = at_change ? 0.05 : 0.0, y = at_change ? 0.0 : 0.05,
               turn = at_change ? 0.0 : std::numbers::pi / 2;
  const auto text =
      test::body("crank", 1.0, 0.01, fmt::format("position = [{}, {}]\nangle = {}\n", x, y, turn)) +
      test::body("coupler", 1.0, 0.01, fmt::format("position = [{}, {}]\n", 2 * x + 0.15, 2 * y)) +
      test::body("rocker", 1.0, 0.01, fmt::format("position = [{}, {}]\nangle = {}\n", x + 0.3, y, turn)) +
      test::pin("a", "ground", "crank", {}, {-0.05, 0.0}) +
      test::pin("b", "crank", "coupler", {0.05, 0.0}, {-0.15, 0.0}) +
      test::pin("c", "coupler", "rocker", {0.15, 0.0}, {0.05, 0.0}) +
      test::pin("d", "ground", "rocker", {0.3, 0.0}, {-0.05, 0.0}) +
      "[drives.motor]\njoint = \"a\"\nspeed_rpm = 60.0\n" + test::run_for(1.6);
  auto scene = parse_scene(text, "parallelogram.toml");
  const auto run = simulate(scene, way);
  return within(run, std::abs(run.final_state.q[5]), 1e-4, "coupler turned (rad)");
}

/// A triangle of three bars on two fixed pins: it cannot move.
Verdict locked(const Way& way) {
  const std::string text = "gravity = [0.0, -9.81]\n" +
                           test::body("a", 1.0, 0.01, "position = [0.5, 0.5]\n") +
                           test::body("b", 1.0, 0.01, "position = [1.5, 0.5]\n") +
                           test::pin("a", "ground", "a", {}, {-0.5, -0.5}) +
                           test::pin("b", "ground", "b", {2.0, 0.0}, {0.5, -0.5}) +
                           test::pin("top", "a", "b", {0.5, 0.5}, {-0.5, 0.5}) + test::run_for(1.0);
  const auto scene = parse_scene(text, "truss.toml");
  const auto run = simulate(scene, way);
  return within(run, std::abs(run.final_state.q[0] - 0.5) + std::abs(run.final_state.v[0]), 1e-9,
                "moved (m, m/s)");
}

/// A block that falls in two parallel guides, of which one is redundant.
Verdict redundant(const Way& way) {
  const std::string text = "gravity = [0.0, -9.81]\n" + test::body("block", 2.0, 0.01) +
                           test::guide("left", "ground", "block", {0.0, 1.0}, {-0.1, 0.0}, {-0.1, 0.0}) +
                           test::guide("right", "ground", "block", {0.0, 1.0}, {0.1, 0.0}, {0.1, 0.0}) +
                           test::run_for(1.0);
  const auto scene = parse_scene(text, "guides.toml");
  const auto run = simulate(scene, way);
  const double t = run.final_state.t;
  return within(run, std::abs(run.final_state.q[1] + 0.5 * 9.81 * t * t), 1e-5, "fall off ½gt² (m)");
}

/// A journal at rest, exactly centred in a fixed bearing: it falls by c. Or one resting on the wall
/// from the first instant.
Verdict journal(const Way& way, bool centred, std::optional<Integrator> integrator = {}) {
  const double c = 1e-3, g = 9.81;
  std::vector<std::string> changes;
  if (centred) changes = {"bodies.disc.position=[0.0, 0.0]", "run.duration=0.02"};
  auto scene = read_scene(test::scene_file("resting_journal"), changes);
  if (integrator) scene.penalty.integrator = *integrator;
  const auto run = simulate(scene, way);
  if (!centred)
    return within(run, std::abs(run.final_state.q[1] + c) / c, 2e-3, "left its place, of the clearance");
  if (test::touches(run).empty() && run.t_end < std::sqrt(2 * c / g))
    return {Outcome::refused, run.ending.reason};
  const auto touch = test::touch(run, 0);
  const bool stepped = way.family == Family::nonsmooth && way.scheme == Scheme::moreau_jean;
  return within(run, std::abs(touch.t / std::sqrt(2 * c / g) - 1), stepped ? 1e-3 : 1e-7,
                "time of the first contact onset against √(2c/g), relative error");
}

Verdict long_run(const Way& way) {
  auto scene = ideal_rig();
  scene.run.duration = 10000 * 0.3 + 0.1;
  scene.nonsmooth.step = 1e-3;
  scene.penalty.tolerance = scene.nonsmooth.tolerance = 1e-6;
  const auto run = simulate(scene, way);
  const double omega = 20 * std::numbers::pi / 3;
  const auto exact = reference::slider_crank(0.05, 0.3, omega * std::fmod(run.final_state.t, 0.3), omega);
  return within(run, std::abs(run.final_state.q[6] - exact.x), 1e-6,
                "slider off the closed form after 10,000 turns (m)");
}

Verdict painleve(bool events) {
  auto scene = read_scene(test::scene_file("painleve_rod"));
  scene.nonsmooth.scheme = events ? Scheme::event_driven : Scheme::moreau_jean;
  const auto run = test::simulate(scene, Family::nonsmooth);
  if (run.ending.status != Ending::Status::finished) return {Outcome::refused, run.ending.reason};
  // There is no right answer: the program must report that.
  for (const auto& note : run.notes)
    if (note.find("Painlev") != note.npos) return {Outcome::doubted, note};
  return {Outcome::silent, "passed Painlevé's configuration without a word"};
}

}  // namespace

std::vector<Cell> special_cells() {
  std::vector<Cell> cells;
  const auto all = [&](const char* name, auto assess) {
    for (const auto& way : ways) cells.push_back({"scene", name, 0, way.name, [=] { return assess(way); }});
  };
  all("crank as long as the rod", equal_lengths);
  all("parallelogram four-bar", [](const Way& w) { return parallelogram(w, false); });
  all("the same from a change point", [](const Way& w) { return parallelogram(w, true); });
  all("locked truss", locked);
  all("redundant guides", redundant);
  all("journal exactly centred", [](const Way& w) { return journal(w, true); });
  all("contact from the first instant", [](const Way& w) { return journal(w, false); });
  cells.push_back({"scene", "the same, rosenbrock4", 0, "penalty",
                   [] { return journal(ways[0], false, Integrator::rosenbrock4); }});
  all("10,000 revolutions", long_run);
  for (auto& c : loose_cells()) cells.push_back(std::move(c));
  for (const bool events : {false, true})
    cells.push_back({"scene", "Painlevé's rod", 0, events ? "event-driven" : "moreau-jean",
                     [=] { return painleve(events); }});
  return cells;
}

}  // namespace freeplay::verification::random_scenes
