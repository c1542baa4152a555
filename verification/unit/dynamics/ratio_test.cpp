// Ratios between two joints: rows and gaps against differences, motions against closed forms, and
// refusals of the reader. With a torque M on the first of two flywheels and y = r θ, its acceleration is
// M/(J_1 + r² J_2).
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "io/scene/write_scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

constexpr double J1 = 0.1, J2 = 0.05, mass = 2.0;

std::string ratio(const std::string& name, const std::string& joint, const std::string& of, double r,
                  const std::string& keys = "") {
  return fmt::format("[joints.{}]\ntype = \"ratio\"\njoint = \"{}\"\nof = \"{}\"\nratio = {}\n{}", name,
                     joint, of, r, keys);
}
std::string elastic(const std::string& joint, const std::string& of, double r, const std::string& keys) {
  return fmt::format("[loads.belt]\ntype = \"elastic-ratio\"\njoint = \"{}\"\nof = \"{}\"\nratio = {}\n{}",
                     joint, of, r, keys);
}
std::string torque(const std::string& on, double size) {
  return fmt::format("[loads.engine]\ntype = \"torque\"\nbody = \"{}\"\ntorque = {}\n", on, size);
}

/// Two flywheels on pins of the ground; the pins' bodies in one order or the other.
std::string flywheels(bool ground_first = true, bool ground_second = false, const std::string& first = "",
                      const std::string& second = "") {
  const auto pin = [](const char* name, const char* on, double x, bool swapped) {
    return swapped ? test::pin(name, on, "ground", {}, {x, 0.0})
                   : test::pin(name, "ground", on, {x, 0.0}, {});
  };
  return "format = 2\n" + test::body("one", 1, J1, first) +
         test::body("two", mass, J2, "position = [0.5, 0]\n" + second) +
         pin("lead", "one", 0, !ground_first) + pin("follow", "two", 0.5, ground_second);
}
/// A flywheel, and a slider on an inclined guide of the ground.
std::string finger(const std::string& first = "", const std::string& second = "") {
  return "format = 2\n" + test::body("one", 1, J1, first) +
         test::body("two", mass, J2, "position = [0.5, 0.1]\n" + second) +
         test::pin("lead", "ground", "one") +
         test::guide("follow", "ground", "two", {0.6, 0.8}, {0.5, 0.1}, {0.0, 0.0});
}

std::string backlash(double play, bool turns = true) {
  return fmt::format("backlash = {}\n{}mesh_stiffness = 1e10\nsurface = \"hard\"\n", play,
                     turns ? "radius = 0.05\n" : "");
}

/// Position of the slider along its axis from [0.5, 0.1].
double along(const std::vector<double>& q) { return 0.6 * (q[3] - 0.5) + 0.8 * (q[4] - 0.1); }

const std::vector<test::Way> ways{test::penalty, test::event_driven, test::automatic,
                                  test::fixed_steps(1e-4)};

}  // namespace

TEST_CASE("rows and gaps of ratios are consistent with their derivatives", "[ratio]") {
  using namespace test;
  // c slides on b, b turns on a, a and d turn on the ground; each of the ratios couples up to four bodies.
  const auto scene = parse_scene(
      "format = 2\n" + body("a", 1, 0.02) + body("b", 1, 0.02) + body("c", 1, 0.02) + body("d", 1, 0.02) +
          surface("hard", 0.5) + pin("shoulder", "ground", "a") +
          pin("elbow", "b", "a", {0.1, 0.2}, {0.3, 0.0}) +
          guide("slide", "b", "c", {0.6, 0.8}, {0.1, 0.0}, {0.05, 0.02}) + pin("axle", "d", "ground") +
          guide("rail", "ground", "c", {0.8, 0.6}, {0.2, 0.1}, {0.03, -0.04}) +
          ratio("turns", "elbow", "axle", -2.5, "offset = 0.3\n") +
          ratio("four", "slide", "axle", 0.2, "offset = 0.1\n") + ratio("shared", "slide", "elbow", -0.3) +
          ratio("loose", "axle", "shoulder", 1.5, "offset = -0.2\n" + backlash(0.2)) +
          ratio("loose_rail", "rail", "shoulder", -0.4, "offset = 0.05\n" + backlash(0.01, false)) +
          run_for(1),
      "ratios");
  const System system(scene.mechanism);
  REQUIRE(system.contacts() == 4);
  auto e = system.make_evaluation();
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> u(-1, 1);
  const double h = 1e-4;
  const auto slope = [&](auto f) {  // of fourth order
    return (4 * (f(0.5 * h) - f(-0.5 * h)) / h - (f(h) - f(-h)) / (2 * h)) / 3;
  };
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> q0(12), v0(12), a0(12);
    for (int i = 0; i < 12; ++i)
      q0[i] = (i % 3 == 2 ? 8 : 0.3) * u(engine), v0[i] = u(engine), a0[i] = 3 * u(engine);
    const auto q = [&](double t) {
      auto x = q0;
      for (int i = 0; i < 12; ++i) x[i] += t * v0[i] + 0.5 * t * t * a0[i];
      return x;
    };
    const auto v = [&](double t) {
      auto x = v0;
      for (int i = 0; i < 12; ++i) x[i] += t * a0[i];
      return x;
    };
    // Differences of fourth order of functions that change in times of 0.1, and rounding of 40 rad over h.
    for (int k = 0; k < system.rows(); ++k) {
      CAPTURE(trial, system.row_name(k), k);
      const auto phi = [&](double t) {
        system.place(0, q(t).data(), e);
        return e.phi[k];
      };
      const auto rate = [&](double t) {
        system.place(0, q(t).data(), e);
        return row_dot(system.pattern(), e.G.data(), k, v(t).data());
      };
      const double now = rate(0);
      system.rate(q0.data(), v0.data(), e);
      const double bend = row_dot(system.pattern(), e.G.data(), k, a0.data()) - e.gamma[k];
      CHECK(now == Approx(slope(phi)).margin(1e-8));
      CHECK(bend == Approx(slope(rate)).margin(1e-6));
    }
    MotionBounds bounds;
    const double H = 0.05;
    const auto end = q(H), v_end = v(H);
    bounds.enclose(H, 12, q0.data(), v0.data(), a0.data(), end.data(), v_end.data(), a0.data());
    ContactRow row;
    for (int k = 0; k < system.contacts(); ++k) {
      CAPTURE(trial, system.contact_facts(k).name);
      const auto gap = [&](double t) {
        system.place(0, q(t).data(), e);
        return system.gap(k, q(t).data(), e);
      };
      const auto look = [&](double t) {
        system.place(0, q(t).data(), e);
        system.contact(k, q(t).data(), v(t).data(), e, row);
        return row.normal.dot(v(t).data());
      };
      const double rate = look(0), bend = row.normal.dot(a0.data()) - row.gamma_n;
      CHECK(row.gap == gap(0));
      CHECK(row.normal.size == 6);
      CHECK(rate == Approx(slope(gap)).margin(1e-8));
      CHECK(bend == Approx(slope(look)).margin(1e-6));
      system.place(0, end.data(), e);
      const auto motion = system.gap_motion(k, bounds, end.data(), e);
      for (int i = 0; i <= 20; ++i) {
        look(H * i / 20);
        CHECK(std::abs(row.normal.dot(a0.data()) - row.gamma_n) <= motion.acceleration * (1 + 1e-12));
      }
    }
  }
  CHECK(to_toml(parse_scene(to_toml(scene), "again")) == to_toml(scene));
}

TEST_CASE("an ideal ratio adds the reduced inertia over many turns", "[ratio]") {
  const double r = -2.5, M = 2, T = 5, alpha = M / (J1 + r * r * J2);  // 9.6 and 24 turns
  for (const auto& way : ways)
    for (const auto& [first, second] :
         {std::pair{true, false}, std::pair{true, true}, std::pair{false, false}}) {
      CAPTURE(way.name, first, second);
      // The angle of a joint whose second body is the ground is minus that of its first body.
      const double sign = first == second ? -1 : 1;
      const auto run =
          test::finished(way, flywheels(first, second, "", "angle = 0.3\n") +
                                  ratio("belt", "follow", "lead", r) + torque("one", M) + test::run_for(T));
      const auto& s = run.final_state;
      // A constant acceleration is integrated exactly; rounding of 150 rad and 5e4 steps.
      CHECK(s.v[2] == Approx(alpha * T).epsilon(1e-9));
      CHECK(s.q[2] == Approx(0.5 * alpha * T * T).epsilon(1e-8));
      CHECK(s.v[5] == Approx(sign * r * s.v[2]).epsilon(1e-10));
      CHECK(s.q[5] - 0.3 == Approx(sign * r * s.q[2]).epsilon(1e-10));
      CHECK(std::abs(run.ledger.closure()) < 1e-7 * run.ledger.scale());
      CHECK(std::abs(run.ledger.stabilisation) < 1e-7 * run.ledger.scale());  // it does no work
    }
}

TEST_CASE("the reaction of a ratio is the couple on either body", "[ratio]") {
  const double r = 3, M = 2, alpha = M / (J1 + r * r * J2);
  for (const auto& way : {test::penalty, test::event_driven, test::fixed_steps(1e-3)}) {
    CAPTURE(way.name);
    test::LastForces forces;
    const auto scene = test::scene_by(
        way, flywheels() + ratio("belt", "follow", "lead", r) + torque("one", M) + test::run_for(0.1));
    Simulation simulation(scene, test::name_of(way.family));
    test::finished(simulation, {&forces});
    bool found = false;
    for (std::size_t i = 0; i < forces.elements.size(); ++i) {
      if (forces.elements[i].name != "belt") continue;
      found = true;
      CHECK(forces.now.elements[i].m == Approx(J2 * r * alpha).epsilon(1e-6));
      CHECK(forces.now.elements[i].m_first == Approx(J1 * alpha - M).epsilon(1e-6));
    }
    CHECK(found);
  }
}

TEST_CASE("a slider follows an angle by a ratio in metres per radian", "[ratio]") {
  const double p = -0.2, M = 1.5, T = 1, alpha = M / (J1 + p * p * mass);
  for (const auto& way : ways) {
    CAPTURE(way.name);
    const auto run = test::finished(way, finger("angle = 1.0\n") + ratio("mimic", "follow", "lead", p) +
                                             torque("one", M) + test::run_for(T));
    const auto& q = run.final_state.q;
    CHECK(q[2] == Approx(1 + 0.5 * alpha * T * T).epsilon(1e-8));
    CHECK(along(q) == Approx(p * (q[2] - 1)).epsilon(1e-8));
    CHECK(std::abs(q[5]) < 1e-9);
    CHECK(std::abs(run.ledger.closure()) < 1e-7 * run.ledger.scale());
  }
}

TEST_CASE("a belt from the ground to a wheel on a turning arm turns the wheel by 1 - r", "[ratio]") {
  // θ_wheel − θ_arm = −r θ_arm with the arm's inertia J_a about the pivot, the wheel's mass at R, and its
  // spin (1 − r) α: α = M/(J_a + m R² + (1 − r)² J). With r = 1 the wheel keeps its orientation.
  const double Ja = 0.3, R = 0.4, J = 0.02, m = 1.5, M = 0.8, T = 2;
  for (const auto& way : ways)
    for (const double r : {1.0, -0.5}) {
      CAPTURE(way.name, r);
      const double alpha = M / (Ja + m * R * R + (1 - r) * (1 - r) * J);
      const auto run = test::finished(
          way, "format = 2\n" + test::body("arm", 1, Ja) +
                   test::body("wheel", m, J, "position = [0.4, 0]\n") + test::pin("pivot", "arm", "ground") +
                   test::pin("axle", "arm", "wheel", {R, 0}, {}) + ratio("belt", "axle", "pivot", r) +
                   torque("arm", M) + test::run_for(T));
      const auto& s = run.final_state;
      // The wheel's path is bent: errors of the integrators' tolerances, and (h ω)² = 1e-7 of time stepping.
      CHECK(s.q[2] == Approx(0.5 * alpha * T * T).epsilon(1e-6));
      CHECK(s.q[5] == Approx((1 - r) * s.q[2]).margin(1e-8));
      CHECK(std::abs(run.ledger.closure()) < 1e-5 * run.ledger.scale());
    }
}

TEST_CASE("an elastic ratio oscillates at its natural frequency", "[ratio]") {
  // x = y − r θ − offset from x_0 at rest, with 1/μ = 1/J_2 + r²/J_1 and δ = c/(2 μ):
  // x = x_0 exp(−δ t) (cos ν t + δ/ν sin ν t), ν² = k/μ − δ², and r J_2 ẏ + J_1 θ̇ = 0.
  const double r = -1.5, x0 = 0.5, T = 0.5, k = 20;
  for (const auto& way : ways)
    for (const bool turns : {true, false})
      for (const double c : {0.0, 0.04}) {
        CAPTURE(way.name, turns, c);
        const double second = turns ? J2 : mass, mu = 1 / (1 / second + r * r / J1), delta = 0.5 * c / mu;
        const double nu = std::sqrt(k / mu - delta * delta);
        const auto keys = fmt::format("stiffness = {}\ndamping = {}\noffset = {}\n", k, c, -x0);
        const auto run = test::finished(
            way, (turns ? flywheels() : finger()) + elastic("follow", "lead", r, keys) + test::run_for(T));
        const auto& s = run.final_state;
        const double y = turns ? s.q[5] : along(s.q);
        const double expected =
            x0 * std::exp(-delta * T) * (std::cos(nu * T) + delta / nu * std::sin(nu * T));
        // Errors of the integrators' tolerances over two to three periods; of time stepping: a phase of
        // (ν h)²/24 ν T.
        CHECK(y - r * s.q[2] + x0 == Approx(expected).margin(1e-4 * x0));
        CHECK(r * second * y + J1 * s.q[2] == Approx(0).margin(1e-8 * J1));
        CHECK(run.ledger.initial == Approx(0.5 * k * x0 * x0).epsilon(1e-12));
        CHECK(std::abs(run.ledger.closure()) < 1e-5 * run.ledger.scale());
        CHECK((run.ledger.damping > 0) == (c > 0));
      }
}

namespace {

/// Flights and impacts of a flywheel of speed w and a body at rest behind the backlash b: by hand.
struct Impacts {
  double first, again;    ///< s, times of the first two impacts
  double w1, y1, w2, y2;  ///< speeds after either
  Impacts(double r, double second, double b, double w, double e) {
    const double mu = 1 / (1 / second + r * r / J1);
    const auto hit = [&](double& lead, double& follow) {
      const double P = -(1 + e) * mu * (follow - r * lead);
      lead -= r * P / J1, follow += P / second;
    };
    first = 0.5 * b / std::abs(r * w);
    w1 = w, y1 = 0;
    hit(w1, y1);
    again = first + b / (e * std::abs(r * w));
    w2 = w1, y2 = y1;
    hit(w2, y2);
  }
};

}  // namespace

TEST_CASE("flywheels with backlash in their ratio hit its ends as by hand", "[ratio]") {
  const double b = 0.02, w = 3, e = 0.6;
  const struct {
    bool ground_first, ground_second, turns;
    double r;
    const char* hit;
  } rows[] = {{true, false, true, 2, "belt.forward"},    {true, false, true, -0.5, "belt.backward"},
              {false, false, true, 2, "belt.backward"},  {true, true, true, 2, "belt.forward"},
              {false, true, true, 0.5, "belt.backward"}, {true, false, false, 0.4, "belt.forward"}};
  for (const auto& row : rows) {
    CAPTURE(row.ground_first, row.ground_second, row.turns, row.r);
    // With signs of the angles in the joints, in place of the bodies' own.
    const double lead = row.ground_first ? 1 : -1, follow = row.ground_second ? -1 : 1;
    const Impacts by_hand(row.r, row.turns ? J2 : mass, b, lead * w, e);
    const auto spin = fmt::format("angular_velocity = {}\n", w);
    const double more = by_hand.again - by_hand.first, T = by_hand.again + 0.3 * more;
    // The play is centred at the bodies' positions, also far from 0.
    const auto text = (row.turns ? flywheels(row.ground_first, row.ground_second, "angle = 40\n" + spin)
                                 : finger("angle = 40\n" + spin)) +
                      test::surface("hard", e) +
                      ratio("belt", "follow", "lead", row.r, backlash(b, row.turns)) + test::run_for(T);
    const auto speed = [&](const Result& run) {
      const auto& v = run.final_state.v;
      return row.turns ? follow * v[5] : 0.6 * v[3] + 0.8 * v[4];
    };
    for (const auto& way : {test::event_driven, test::automatic}) {
      CAPTURE(way.name);
      const auto run = test::finished(way, text);
      const auto list = test::touches(run);
      REQUIRE(list.size() == 2);
      CHECK(list[0].t == Approx(by_hand.first).epsilon(1e-9));
      CHECK(list[1].t == Approx(by_hand.again).epsilon(1e-9));
      const System system(parse_scene(text, "s").mechanism);
      CHECK(system.contact_facts(list[0].contact).name == row.hit);
      CHECK(list[0].contact != list[1].contact);
      CHECK(lead * run.final_state.v[2] == Approx(by_hand.w2).epsilon(1e-9));
      CHECK(speed(run) == Approx(by_hand.y2).epsilon(1e-9));
      CHECK(std::abs(run.ledger.closure()) < 1e-9 * run.ledger.scale());
    }
    const auto stepped = test::finished(test::fixed_steps(more / 1000), text);
    // Impacts are those of the law; only their times have errors of a step.
    CHECK(lead * stepped.final_state.v[2] == Approx(by_hand.w2).epsilon(1e-9));
    CHECK(speed(stepped) == Approx(by_hand.y2).epsilon(1e-9));
    // Penalty: the moment about the reduced shaft is kept, and the law returns the restitution to 1 %.
    const auto pressed = test::finished(test::penalty, text);
    const double second = row.turns ? J2 : mass;
    CHECK(J1 * lead * pressed.final_state.v[2] + row.r * second * speed(pressed) ==
          Approx(J1 * lead * w).epsilon(1e-6));
    CHECK(lead * pressed.final_state.v[2] == Approx(by_hand.w2).margin(0.03 * w));
  }
}

TEST_CASE("a ratio starts at its full turns", "[ratio]") {
  // The motor states 10 rad, and no body an angle: 2 · 10 − 7 rad, not the same less two turns.
  for (const auto& play : {std::string(), backlash(0.01)}) {
    const auto scene =
        parse_scene(flywheels() + test::surface("hard", 0.5) +
                        ratio("belt", "follow", "lead", 2, "offset = -7\n" + play) +
                        test::motor("motor", "lead", 1, "initial_angle = 10\n") + test::run_for(1),
                    "turns");
    const auto q = assemble(scene.mechanism, scene.run.start).q;
    CHECK(q[2] == Approx(10).margin(1e-12));
    CHECK(q[5] == Approx(13).margin(1e-9));
  }
}

TEST_CASE("invalid ratios are refused", "[ratio][scene]") {
  const auto good = flywheels() + test::surface("hard", 0.5) + test::surface("rough", 0.5, 0.2) +
                    test::pin("hinge", "one", "two", {0.5, 0}, {}) + test::guide("rail", "two", "ground") +
                    ratio("belt", "follow", "lead", 2, backlash(0.01)) + test::run_for(1);
  REQUIRE(test::refusal(good) == "accepted");
  const test::Edit edits[] = {
      {"ratio = 2\n", "ratio = 0\n", "joints.belt.ratio: must be a number other than 0"},
      {"ratio = 2\n", "", "joints.belt.ratio: is missing"},
      {"of = \"lead\"", "of = \"follow\"", "joints.belt.of: is the joint itself"},
      {"of = \"lead\"", "of = \"rail\"",
       "joints.belt.of: must be a revolute joint, whose angle enters the row; if a revolute joint follows a "
       "translational one, exchange `joint` and `of` and state 1/ratio"},
      {"joint = \"follow\"", "joint = \"belt\"", "joints.belt.joint: there is no joint \"belt\""},
      {"of = \"lead\"", "of = \"hinge\"", "joints.belt.of: \"hinge\" must have the ground as a body"},
      {"joint = \"follow\"", "joint = \"hinge\"",
       "joints.belt.joint: \"hinge\" must have the ground as a body"},
      {"joint = \"follow\"", "joint = \"rail\"", "joints.belt.radius: belongs to revolute joints"},
      {"radius = 0.05\n", "", "joints.belt.radius: is missing"},
      // The meaning of the key in this kind of joint alone.
      {"surface = \"hard\"\n", "", "joints.belt.surface: is missing: the surface of its contacts"},
      {"backlash = 0.01", "backlash = 0.0", "joints.belt.backlash: must be greater than 0"},
      {"mesh_stiffness = 1e10\nsurface = \"hard\"", "surface = \"rough\"",
       "joints.belt.surface: must be without friction"},
  };
  for (const auto& edit : edits) {
    CAPTURE(edit.from, edit.to);
    CHECK_THAT(test::refusal(test::replaced(good, edit.from, edit.to)), Contains(edit.words));
  }
  // A ratio may stand before the joints that it names.
  CHECK(test::refusal(test::replaced(good, "[joints.lead]",
                                     "[joints.a]\ntype = \"ratio\"\njoint = \"follow\"\n"
                                     "of = \"lead\"\nratio = 1\n[joints.lead]")) == "accepted");
  const auto soft = test::replaced(flywheels() + test::surface("hard", 0.5) +
                                       ratio("belt", "follow", "lead", 2, backlash(0.01)) + test::run_for(1),
                                   "mesh_stiffness = 1e10\n", "");
  CHECK_THAT(test::refusal_of([&] { test::finished(test::penalty, soft); }),
             Contains("joints.belt.mesh_stiffness"));
}
