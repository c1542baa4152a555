// Impacts on beams: what restitution means on a flexible body, against closed forms and independent solutions.
#include "mechanism/beam.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// Momentum of all bodies along x or y (axis 0 or 1).
double momentum(const Scene& scene, const test::MotionRow& row, std::size_t axis) {
  double sum = 0;
  for (std::size_t i = 0; i < scene.mechanism.bodies.size(); ++i)
    sum += scene.mechanism.bodies[i].mass * row.v[3 * i + axis];
  return sum;
}

}  // namespace

TEST_CASE("an elastic rod leaves a wall after two passages of the wave", "[beams]") {
  // St Venant: ρA c V acts for 2L/c, then the rod leaves with V, although its end has the restitution 0. A chain of n
  // pieces disperses the front over n^{1/3} pieces: independent event-driven chains with the same pieces have the
  // restitutions and contact times below (relative to 2L/c), for a contact mass of 1 % of a piece.
  struct Known {
    int pieces;
    double restitution, time;
  };
  // L = 1 m, ρA = 1 kg/m, c = 100 m/s; V = 0.1 m/s, strain 1e-3.
  const double speed = 0.1, time = 2 / 100.0;
  for (const auto& known :
       {Known{8, 0.93126, 1.04463}, Known{16, 0.95888, 1.02566}, Known{32, 0.97403, 1.01291}}) {
    CAPTURE(known.pieces);
    const auto text =
        test::body("nose", 0.01 / known.pieces, 1e-6,
                   fmt::format("position = [1e-4, 0.0]\nangle = 0.0\nvelocity = [{}, 0.0]\n", -speed)) +
        fmt::format(
            "[beams.rod]\nbetween = [\"nose\", \"free\"]\nlength = 1.0\nelements = {}\nyoung = 1e4\n"
            "density = 1\narea = 1\nsecond_moment = 1e-3\n",
            known.pieces) +
        test::plane("wall", "ground", "nose", 0, "s", "axis = [0.0, -1.0]\n") + test::surface("s", 0.0) +
        test::run_for(2.5 * time);
    const auto scene = test::scene_by(test::event_driven, text);
    const auto motion = test::motion_rows(scene, Family::nonsmooth, 2.4 * time);
    const double before = momentum(scene, motion.rows.front(), 0);
    CHECK(-momentum(scene, motion.rows.back(), 0) / before == Approx(known.restitution).epsilon(2e-3));
    const auto& events = motion.run.events;
    const auto end = std::ranges::find(events, EventKind::separation, &ContactEvent::kind);
    REQUIRE(end != events.end());
    CHECK(end->duration / time == Approx(known.time).epsilon(5e-3));
  }
}

TEST_CASE("fixed steps give a rod its restitution as they become short", "[beams]") {
  // The impact acts on the part of the rod that waves reach in a step. Steps of an eighth of a piece's passage agree with
  // the chain to 2 %, in the penalty formulation a stiff contact likewise.
  const double speed = 0.1, time = 2 / 100.0;
  const auto text =
      test::body("nose", 0.01 / 16, 1e-6, "position = [1e-4, 0.0]\nangle = 0.0\nvelocity = [-0.1, 0.0]\n") +
      "[beams.rod]\nbetween = [\"nose\", \"free\"]\nlength = 1.0\nelements = 16\nyoung = 1e4\n"
      "density = 1\narea = 1\nsecond_moment = 1e-3\n" +
      test::plane("wall", "ground", "nose", 0, "s", "axis = [0.0, -1.0]\nstiffness = 1e8\n") +
      test::surface("s", 0.1) + test::run_for(2.5 * time);
  for (const auto& way : {test::fixed_steps(1.0 / 100 / 16 / 8), test::chosen_steps,
                          test::Way{"penalty", Family::penalty, {}, 0, {"penalty.contact=\"exact\""}}}) {
    CAPTURE(way.name);
    const auto scene = test::scene_by(way, text);
    const auto motion = test::motion_rows(scene, way.family, 2.4 * time);
    CHECK(-momentum(scene, motion.rows.back(), 0) / (-speed * 1.000625) == Approx(0.95888).epsilon(0.02));
  }
}

TEST_CASE("a sphere on a supported beam has the contact of Timoshenko's problem", "[beams]") {
  // S. Timoshenko, ZAMP 62 (1913) 198: a steel sphere of 1 cm radius at 0.01 m/s meets the middle of a beam of 1 cm ×
  // 1 cm × 15.35 cm on two supports, E = 2.2e6 kg/cm². His integral equation with 40 modes and rotary inertia has the
  // peak 4.98292 N, the end of contact at 156.692 µs and the sphere's speed −3.02543 mm/s; an independent solution of
  // the beam of n pieces tends to it with second order, with the values below.
  const double E = 2.2e6 * 9.80665e4, rho = 7960, R = 0.01, mass = rho * 4 / 3 * std::numbers::pi * R * R * R;
  const auto run = [&](int pieces) {
    const auto light = [](const std::string& name, double x) {
      return test::body(name, 1e-6, 1e-12, fmt::format("position = [{}, 0.0]\nangle = 0.0\n", x));
    };
    const auto text =
        light("a", 0) + light("b", 0.1535) + test::pin("A", "ground", "a") +
        test::pin("B", "ground", "b", {0.1535, 0}) +
        test::body(
            "sphere", mass, 0.4 * mass * R * R,
            fmt::format("position = [{}, {}]\nangle = 0.0\nvelocity = [0.0, -0.01]\n", 0.5 * 0.1535, R)) +
        fmt::format(
            "[beams.beam]\nbetween = [\"a\", \"b\"]\nlength = 0.1535\nelements = {}\nyoung = {}\n"
            "density = {}\nsection = \"rectangle\"\nwidth = 0.01\nheight = 0.01\n",
            pieces, E, rho) +
        test::plane("top", fmt::format("beam-{}", (pieces + 1) / 2), "sphere", R, "s") +
        fmt::format("[surfaces.s]\nyoung = {}\npoisson = 0.3\nrestitution = 1.0\n", E) + test::run_for(3e-4);
    const auto scene = test::scene_by(
        {"penalty", Family::penalty, {}, 0, {"penalty.contact=\"exact\"", "penalty.tolerance=1e-10"}}, text);
    Simulation simulation(scene, test::name_of(Family::penalty));
    const auto& elements = simulation.layout().forces;
    const auto contact = static_cast<std::size_t>(
        std::ranges::find(elements, ForceElement::Kind::contact, &ForceElement::kind) - elements.begin());
    double peak = 0;
    Forces now;
    const auto result = test::watch_steps(simulation, [&](const Step& step) {
      step.forces(step.t1, now);
      peak = std::max(peak, now.elements[contact].fn);
    });
    const auto& bodies = scene.mechanism.bodies;
    const auto at =
        static_cast<std::size_t>(std::ranges::find(bodies, "sphere", &Body::name) - bodies.begin());
    return std::array{peak, test::touch(result, 0).duration, simulation.state().v[3 * at + 1]};
  };
  struct Known {
    int pieces;
    std::array<double, 3> values;  // N, s, m/s
  };
  for (const auto& known : {Known{9, {5.00279883, 157.4944e-6, 3.0271197e-3}},
                            Known{17, {4.98764222, 156.9295e-6, 3.02661946e-3}}}) {
    CAPTURE(known.pieces);
    const auto found = run(known.pieces);
    for (const std::size_t i : {0, 1, 2}) {
      CAPTURE(i);
      CHECK(found[i] == Approx(known.values[i]).epsilon(3e-4));
    }
  }
}
