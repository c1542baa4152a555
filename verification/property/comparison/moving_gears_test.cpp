// Gears whose centres move, in scenes without positions of bodies: assembly, Willis' equation,
// balances of energy and torque, and backlash against an independent program.
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/turn_survey.hpp"
#include "io/scene/write_scene.hpp"
#include "verification/claims/gear_claims.hpp"
#include "verification/references/gears.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

constexpr double pi = std::numbers::pi;

std::string gear(const std::string& name, const std::string& i, const std::string& j, int z_i, int z_j,
                 const std::string& more = "") {
  return fmt::format(
      "[joints.{}]\ntype = \"gear\"\nbetween = [\"{}\", \"{}\"]\nteeth = [{}, {}]\nmodule = 5e-3\n{}", name,
      i, j, z_i, z_j, more);
}

/// Sun of 20 teeth, planet of 20 on a carrier, ring of 60; `drives`: [drives] and [loads].
std::string epicyclic(const std::string& drives, const std::string& ring = "ground",
                      const std::string& carrier = "") {
  return "format = 2\n" + test::body("sun", 1.0, 1e-3) + test::body("carrier", 1.0, 1e-2, carrier) +
         test::body("planet", 0.5, 5e-4) + (ring == "ground" ? "" : test::body(ring, 2.0, 2e-2)) +
         test::pin("sun_pin", "ground", "sun") + test::pin("carrier_pin", "ground", "carrier") +
         (ring == "ground" ? "" : test::pin("ring_pin", "ground", ring)) +
         test::pin("planet_pin", "carrier", "planet", {0.1, 0.0}) + gear("inner", "sun", "planet", 20, 20) +
         gear("outer", ring, "planet", 60, 20, "internal = true\n") + drives;
}

std::vector<test::Way> both() { return {test::penalty, test::event_driven, test::fixed_steps(1e-4)}; }

}  // namespace

TEST_CASE("gears without positions are placed by the other joints", "[gears][assembly]") {
  const auto scene = parse_scene(epicyclic("[drives.m]\njoint = \"carrier_pin\"\nspeed = 1.0\n"
                                           "initial_angle = 0.7\n" +
                                           test::run_for(1.0)),
                                 "e.toml");
  const auto start = assemble(scene.mechanism, RunOptions::Start::assembled);
  // The carrier's pin is at 0.1 m, the centre distance of 20 + 20 teeth of 5 mm.
  CHECK(start.q[6] == Approx(0.1 * std::cos(0.7)).margin(1e-13));
  CHECK(start.q[7] == Approx(0.1 * std::sin(0.7)).margin(1e-13));
  CHECK(start.q[2] == Approx(0).margin(1e-13));  // gears that nothing turns keep their angles
  CHECK(start.q[8] == Approx(0).margin(1e-13));
  // The canonical text keeps the teeth: it assembles to the same pose.
  const auto again = parse_scene(to_toml(scene), "again.toml");
  CHECK(assemble(again.mechanism, RunOptions::Start::assembled).q == start.q);
  // Positions that are given mean the same teeth.
  auto placed = scene.mechanism;
  start_from(placed, start);
  const auto given = assemble(placed, RunOptions::Start::given).q;
  for (std::size_t c = 0; c < given.size(); ++c) CHECK(given[c] == Approx(start.q[c]).margin(1e-13));
}

TEST_CASE("gears that the other joints hold too far apart are refused with both distances",
          "[gears][assembly]") {
  auto text = epicyclic(test::run_for(1.0));
  const auto at = text.find("[[0.1,");
  REQUIRE(at != text.npos);
  text.replace(at, 6, "[[0.2,");
  const auto said = test::refusal(text);
  CHECK_THAT(said, Contains("joints.inner: phase follows from the bodies' positions"));
  CHECK_THAT(said, Contains("0.2 m instead of 0.1 m"));
}

TEST_CASE("gears whose default centre is not where their body turns are refused by at", "[gears][assembly]") {
  // Wheels of 20 teeth of 5 mm, pinned 0.1 m apart; the second turns about a point 20 mm from its origin.
  const auto text = [](const std::string& at) {
    return "format = 2\n" + test::body("a", 1.0, 1e-3) +
           test::body("b", 1.0, 1e-3, "position = [0.08, 0.0]\n") + test::pin("pin_a", "ground", "a") +
           test::pin("pin_b", "ground", "b", {0.1, 0.0}, {0.02, 0.0}) + gear("mesh", "a", "b", 20, 20, at) +
           test::run_for(1.0);
  };
  CHECK_NOTHROW(parse_scene(text("at = [[0.0, 0.0], [0.02, 0.0]]\n"), "at.toml"));
  const auto said = test::refusal(text(""));
  CHECK_THAT(said, Contains("joints.mesh.at: is [0, 0] on b (the default), where no revolute"));
  CHECK_THAT(said, Contains("0.08 m instead of 0.1 m"));
  CHECK_THAT(said, !Contains("phase"));
}

TEST_CASE("epicyclic trains of two degrees of freedom follow Willis' equation", "[gears]") {
  // (ω_r − ω_c)/(ω_s − ω_c) = −z_s/z_r, thus ω_r = ω_c (1 + z_s/z_r) − ω_s z_s/z_r; the planet
  // rolls in the ring: (ω_p − ω_c) z_p = (ω_r − ω_c) z_r.
  const double ws = 20, wc = -6, T = 1, wr = wc * (1 + 20.0 / 60) - ws * 20.0 / 60;
  const double wp = wc + 3 * (wr - wc);
  const auto text = epicyclic(test::motor("s", "sun_pin", ws) + test::motor("c", "carrier_pin", wc) +
                                  test::run_for(T, "start = \"assembled\"\n"),
                              "ring");
  for (const auto& way : both()) {
    CAPTURE(way.name, way.fixed());
    const auto end = test::finished(way, text).final_state;
    // Penalty: drift at α = β = 5, 1e-8 m over 0.05 m; others project positions to rounding.
    const double bound = way.penalty() ? 1e-7 : 1e-10;
    CHECK(end.q[11] == Approx(wr * T).margin(bound));
    CHECK(end.q[8] == Approx(wp * T).margin(bound));
  }
}

TEST_CASE("a turn of the drive turns epicyclic gears in the ratio of Willis, fast ones too",
          "[gears][whole-turn]") {
  // Sun driven, ring fixed: ω_c/ω_s = z_s/(z_s + z_r); carrier driven: the inverse. The teeth of a
  // 5 degree interval of the carrier are 1.1 pitches of the sun.
  for (const bool inverse : {false, true}) {
    const auto scene = parse_scene(epicyclic(fmt::format("[drives.m]\njoint = \"{}\"\nspeed = -2.0\n",
                                                         inverse ? "carrier_pin" : "sun_pin") +
                                             test::run_for(1.0)),
                                   "e.toml");
    const auto s = survey_turn(scene.mechanism, assemble(scene.mechanism, RunOptions::Start::ideal).q);
    REQUIRE(s);
    CHECK(s->full);
    REQUIRE(s->outputs.size() == 1);
    CHECK(s->outputs[0].dead_centres.empty());
    CHECK(s->outputs[0].turns == Approx(inverse ? 4 : 0.25).epsilon(1e-9));
  }
}

TEST_CASE("a sun-and-planet gear turns its shaft twice in a stroke of the beam", "[gears][assembly]") {
  // Watt's gear: the planet is fixed to the rod and circles the equal sun; the rod returns to its
  // angle after a turn of the arm, thus θ_s = (1 + z_p/z_s) 2π.
  const auto text = test::file_text(test::scene_file("tests/sun_and_planet"));
  for (const auto& way : both()) {
    CAPTURE(way.name, way.fixed());
    const auto scene = test::scene_by(way, text);
    const auto start = assemble(scene.mechanism, RunOptions::Start::assembled);
    const auto end = test::finished(scene, way.family).final_state;
    const double bound = way.penalty() ? 1e-6 : 1e-10;
    CHECK(end.q[5] - start.q[5] == Approx(4 * pi).margin(bound));
    CHECK(end.q[8] == Approx(start.q[8]).margin(bound));
  }
}

TEST_CASE("an epicyclic gear under torques has the reduced inertia and the torques of power balance",
          "[gears]") {
  // ω_c = ω_s/4 and ω_p = −ω_s/2. J = J_s + (J_c + m_p a²)/16 + J_p/4; J ω̇_s = M_s + M_c/4.
  const double J = 1e-3 + (1e-2 + 0.5 * 0.1 * 0.1) / 16 + 5e-4 / 4, Ms = 0.4, Mc = -0.6, T = 0.2;
  const auto torque = [](const char* body, double M) {
    return fmt::format("[loads.{0}]\ntype = \"torque\"\nbody = \"{0}\"\ntorque = {1}\n", body, M);
  };
  const auto free =
      epicyclic(torque("sun", Ms) + torque("carrier", Mc) + test::run_for(T, "start = \"assembled\"\n"));
  const auto driven = epicyclic("[drives.m]\njoint = \"sun_pin\"\nspeed = 30.0\n" + torque("carrier", Mc) +
                                test::run_for(0.01, "start = \"assembled\"\n"));
  for (const auto& way : both()) {
    CAPTURE(way.name, way.fixed());
    const auto run = test::finished(way, free);
    const double w = (Ms + Mc / 4) / J * T;
    // Penalty: drift of velocities at α = β = 5. Fixed steps h: the midpoint rule turns a body by
    // (ωh)²/4 of its step too little or too much; ω = 24 rad/s of the sun.
    const double bound = way.penalty() ? 1e-6 : way.fixed() ? 1.5e-6 : 1e-9;
    CHECK(run.final_state.v[2] == Approx(w).epsilon(bound));
    CHECK(run.final_state.v[5] == Approx(w / 4).epsilon(bound));
    CHECK(run.ledger.kinetic == Approx(0.5 * J * w * w).epsilon(2 * bound));
    const auto scene = test::scene_by(way, driven);
    const auto m = verification::gear_claims::force_of(scene, way.family, "m");
    CHECK(std::abs(m.m) == Approx(-Mc / 4).epsilon(way.fixed() ? 1e-6 : 1e-8));
  }
}

TEST_CASE("the lost motion of an epicyclic gear is that of both backlashes", "[gears][event-driven]") {
  // |θ_c − θ_s/4| ≤ b/(4r): the sum of the bounds of both gaps; r = 46.985 mm, b = 0.1 mm. The
  // reversing load reaches both limits.
  const double most = 1e-4 / (4 * 0.05 * std::cos(20 * pi / 180));
  for (const auto& way : {test::event_driven, test::penalty}) {
    CAPTURE(way.name);
    const auto scene =
        test::scene_by(way, test::file_text(test::source_folder() / "cases/epicyclic-gear/scene.toml"));
    double low = 0, high = 0;
    std::vector<double> q(9), v(9);
    test::Listener listener;
    listener.on_step = [&](const Step& step) {
      step.state(step.t1, q, v);
      low = std::min(low, q[5] - q[2] / 4), high = std::max(high, q[5] - q[2] / 4);
    };
    Simulation simulation(scene, test::name_of(way.family));
    test::finished(simulation, {&listener});
    // Penalty: a mesh that closes at u deflects by u √(m/k) besides. The load accelerates the carrier
    // by at most 2 N m/0.015 kg m² over 1e-3 rad: u < 0.06 m/s, with m < 0.3 kg and k = 2e8 N/m
    // 2.3e-6 m each, which is 5 % of the backlash' half.
    const double over = way.penalty() ? 0.05 : 1e-9;
    CHECK(high == Approx(most).epsilon(over));
    CHECK(low == Approx(-most).epsilon(over));
  }
}

TEST_CASE("backlash between two gears on a swinging arm agrees with an independent program",
          "[gears][event-driven]") {
  // 20 and 30 teeth of 5 mm: 0.125 m between the centres. Approach speed of the first impact 0.5
  // m/s; the arm's fall changes the closing speed by 3 m/s².
  const long double alpha = 20 * std::numbers::pi_v<long double> / 180;
  const reference::GearsOnArm m{.arm_mass = 1,
                                .arm_inertia = 8e-3L,
                                .arm_centre = 0.1L,
                                .gear_mass = {0.3L, 0.5L},
                                .inertia = {2e-4L, 9e-4L},
                                .base = {0.05L * std::cos(alpha), 0.075L * std::cos(alpha)},
                                .place = {0.06L, 0.185L},
                                .backlash = 1e-3L,
                                .gravity = 9.81L,
                                .centred = 0.3L,
                                .restitution = {0.8L, 0.8L}};
  reference::ContactEvents motion(m, {m.centred, 0, 0}, {0, -10, 0}, 1e-5L);
  while (motion.impacts.size() < 8) motion.run(motion.t + 1e-5L);
  const auto& exact = motion.impacts;
  for (const auto& way : {test::event_driven, test::automatic, test::penalty}) {
    CAPTURE(way.name);
    auto scene = test::scene_by(way, test::file_text(test::scene_file("tests/gears_on_arm")));
    scene.run.duration = static_cast<double>(exact.back().t) + 1e-4;
    scene.penalty.contact = ContactLaw::exact;
    scene.penalty.tolerance = 1e-10;
    const auto found = test::touches(test::finished(scene, way.family));
    REQUIRE(found.size() == exact.size());
    for (std::size_t k = 0; k < exact.size(); ++k) {
      CAPTURE(k);
      const auto& one = exact[k];
      // Event-driven: the tolerance of the integrator, 1e-9 of 0.1 m/s, over eight impacts. Penalty:
      // a contact lasts 20 µs, in which the arm gains 6e-5 m/s of 0.1 m/s; eight contacts.
      const double bound = way.penalty() ? 5e-3 : 1e-7;
      CHECK(found[k].contact == static_cast<int>(one.contact));  // mesh.forward, mesh.backward
      CHECK(found[k].t == Approx(static_cast<double>(one.t)).epsilon(bound));
      CHECK(found[k].v_n_minus == Approx(static_cast<double>(one.v_n_minus)).epsilon(bound));
      CHECK(found[k].impulse_n == Approx(static_cast<double>(one.impulse_n)).epsilon(bound));
    }
  }
}
