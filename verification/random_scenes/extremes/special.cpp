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

// Joints with clearance where the first two contacts of the test rig are not sufficient: two joints
// in one chain, and a thousand revolutions.

namespace {

/// Greatest error of three contacts, relative to the permitted errors. An impact acts `delay` s
/// late and changes the speed of the joint by a·delay, a being the gap's acceleration; the bounce
/// of duration 2u/a that follows changes by 2·delay. So it shifts later contacts by up to 3·delay;
/// at the end of a flight f at v ≈ ½ a f … a f, a shift of s changes the approach speed by up to
/// 2s/f of itself.
double onset_error_of_three(const Result& run, const Result& exact, const std::array<double, 3>& delays,
                            double found_to) {
  double worst = 0, shift = found_to;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto a = test::touch(run, i), b = test::touch(exact, i);
    if (a.contact != b.contact) return INFINITY;
    double since = 0;  // last contact of this joint, or the start
    for (std::size_t j = 0; j < i; ++j)
      if (const auto before = test::touch(exact, j); before.contact == b.contact) since = before.t;
    const double may = shift + 1e-6 * b.t;
    worst = std::max({worst, std::abs(a.t - b.t) / may,
                      std::abs(a.v_n_minus / b.v_n_minus - 1) / (1e-4 + 2 * may / (b.t - since))});
    shift += 3 * delays[i];
  }
  return worst;
}

/// Two pins with clearance in one chain, up to the third contact, the first of the other pin. The
/// event-driven scheme is compared with penalty at two stiffnesses, by the exponent of the contact
/// duration of Hertz, K^(−2/5), and with time stepping at two step sizes.
Verdict two_loose(Family family) {
  auto scene = read_scene(test::scene_file("four_bar_two"));
  scene.run.duration = 0.0105;  // between the third contact and the fourth
  scene.run.discard = 0;
  scene.penalty.contact = ContactLaw::exact;
  scene.nonsmooth.scheme = Scheme::event_driven;
  scene.nonsmooth.tolerance = 1e-12;
  const auto exact = test::simulate(scene, Family::nonsmooth);
  const double third = test::touch(exact, 2).t;
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  const double young = *scene.mechanism.surfaces[0].young;
  double worst = 0;
  Result run;
  std::array<double, 2> late{};
  for (const int i : {0, 1}) {
    *scene.mechanism.surfaces[0].young = young * std::array{1e2, 1e4}[i];
    const double h = std::array{1e-5, 1e-6}[i];
    scene.nonsmooth.step = h;
    run = test::simulate(scene, family);
    if (run.ending.status != Ending::Status::finished && test::touches(run).size() < 3)
      return {Outcome::refused, run.ending.reason};
    std::array<double, 3> delays{h, h, h};
    if (family == Family::penalty)
      for (std::size_t k = 0; k < 3; ++k) delays[k] = test::touch(run, k).duration;
    worst = std::max(worst, onset_error_of_three(run, exact, delays, family == Family::penalty ? 0 : h));
    late[i] = std::abs(test::touch(run, 2).t - third);
  }
  // The leading term alone gives a factor of 100^(2/5) for a hundredfold stiffness: half as much
  // again for the next terms.
  if (family == Family::penalty)
    worst = std::max(worst, std::abs(std::log(late[0] / late[1] / std::pow(100, 0.4))) / std::log(1.5));
  return within(run, worst, 1,
                "first three contact onsets against the event-driven scheme, error over its bound");
}

/// The clearance of the rig over a thousand revolutions. The motion is not known for that long.
/// Every run must keep positions to a thousandth of the clearance, the energy to the fifth digit of
/// the loss, and the wall. The penetration is at most Hertz's depth for the slider's whole mass (no
/// effective mass is greater) at the fastest approach, twice that under a lasting load; in time
/// stepping the distance of one step, between events rounding.
Verdict long_loose(Family family, Scheme scheme) {
  auto scene = read_scene(test::flores());
  scene.instruments.clear();
  scene.run.discard = 0;
  scene.run.duration = 1000 * 0.3;
  scene.run.output_step = 1;
  scene.penalty.contact = ContactLaw::exact;
  scene.nonsmooth.scheme = scheme;
  const double c = std::get<RevoluteJoint>(scene.mechanism.joints[2]).clearance->radial;
  const auto run = test::simulate(scene, family);
  const auto& contact = run.contacts.at(0);
  const double v = contact.fastest_approach, mass = scene.mechanism.bodies[2].mass;
  const double lost = run.ledger.contact + run.ledger.friction;
  const double yields = family == Family::penalty
                            ? 2 * std::pow(5 * mass * v * v / (4 * contact.model.stiffness), 0.4)
                        : scheme == Scheme::moreau_jean ? *scene.nonsmooth.step * v
                                                        : 1e-6 * c;
  const double position = run.extremes.constraint_length / (1e-3 * c),
               energy = std::abs(run.ledger.closure()) / (1e-5 * lost), wall = contact.penetration / yields;
  auto assessed =
      within(run, std::max({position, energy, wall}), 1, "of the bounds on Φ, energy, penetration");
  assessed.detail += fmt::format(" (Φ {:.1g}, energy {:.1g}, penetration {:.1g})", position, energy, wall);
  return assessed;
}

}  // namespace

std::vector<Cell> loose_cells() {
  std::vector<Cell> cells;
  for (const auto family : {Family::penalty, Family::nonsmooth})
    cells.push_back({"scene", "two loose joints in one chain", 0,
                     family == Family::penalty ? "penalty" : "moreau-jean",
                     [=] { return two_loose(family); }});
  for (const auto& [name, family, scheme] : {std::tuple{"penalty", Family::penalty, Scheme::moreau_jean},
                                             {"moreau-jean", Family::nonsmooth, Scheme::moreau_jean},
                                             {"event-driven", Family::nonsmooth, Scheme::event_driven}})
    cells.push_back({"scene", "1,000 loose revolutions", 0, name,
                     [family = family, scheme = scheme] { return long_loose(family, scheme); }});
  return cells;
}

}  // namespace freeplay::verification::random_scenes
