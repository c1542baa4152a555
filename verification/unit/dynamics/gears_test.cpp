// Gears, racks, slots and end stops: rows against differences of gaps, bounds against sampled gaps,
// and refusals of the reader.
#include "verification/references/gears.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/meshing.hpp"
#include "dynamics/system.hpp"
#include "dynamics/system_tangent.hpp"
#include "io/scene/write_scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// Two free bodies, with every kind of this file between them; `play`: the backlash of the teeth.
std::string scene_text(const std::string& play) {
  using namespace test;
  return "format = 2\n" + body("a", 1.5, 0.02) + body("b", 0.7, 0.01, "position = [0.32, 0.05]\n") +
         surface("hard", 0.5) +
         joint("outer", "gear", "a", "b", {0.01, 0.02}, {-0.03, 0.01},
               "teeth = [20, 31]\nmodule = 0.01\nphase = 0.3\n" + play) +
         gear("inner", "a", "b", {0.32, 0.13},
              "at = [[0.03, -0.02], [0.02, 0.01]]\npressure_angle = 0.4\ninternal = true\nphase = 1.1\n" +
                  play) +
         joint("rack", "rack", "a", "b", {0.01, 0.0}, {-0.02, 0.04},
               "axis = [0.6, 0.8]\npitch_radius = 0.2\nphase = -0.2\n" + play) +
         joint("slot", "slot", "a", "b", {0.1, 0.0}, {-0.02, 0.01},
               "axis = [0.8, -0.6]\nclearance = 1e-3\npin_radius = 0.01\nsurface = \"hard\"\n") +
         pin("pin", "a", "b", {0.1, 0.02}, {-0.02, 0.01}, loose(1e-2, 0.03, "hard")) +
         stop("travel", "travel-stop", "slot", "lower = -0.1\nupper = 0.4\n", "hard") +
         stop("turn", "angle-stop", "pin", "lower = -1.0\nupper = 2.0\nradius = 0.05\ndirection = 0.7\n",
              "hard") +
         stop("couple", "angle-stop", "pin", "upper = 2.0\nradius = 0.05\n", "hard") + run_for(1);
}
const char* const with_backlash = "backlash = 1e-3\nsurface = \"hard\"\n";

Scene scene_of(const std::string& text) { return parse_scene(text, "gears"); }

/// A state near that of the scene, with any angles and velocities.
struct Motion6 {
  std::vector<double> q, v, a;
  explicit Motion6(std::mt19937& engine) : q(6), v(6), a(6) {
    std::uniform_real_distribution<double> u(-1, 1);
    for (int i = 0; i < 6; ++i) v[i] = u(engine), a[i] = 3 * u(engine);
    q = {0.02 * u(engine),        0.02 * u(engine), 4 * u(engine),
         0.32 + 0.02 * u(engine), 0.05 * u(engine), 4 * u(engine)};
  }
  std::vector<double> at(double t) const {
    auto x = q;
    for (int i = 0; i < 6; ++i) x[i] += t * v[i] + 0.5 * t * t * a[i];
    return x;
  }
  std::vector<double> rate(double t) const {
    auto x = v;
    for (int i = 0; i < 6; ++i) x[i] += t * a[i];
    return x;
  }
};

int find(const System& system, const std::string& name) {
  for (int k = 0; k < system.contacts(); ++k)
    if (system.contact_facts(k).name == name) return k;
  throw std::runtime_error("no contact " + name);
}

/// Of Richardson's form.
template <class F>
double slope(F f, double h) {
  const double coarse = (f(h) - f(-h)) / (2 * h), fine = (f(0.5 * h) - f(-0.5 * h)) / h;
  return (4 * fine - coarse) / 3;
}

/// Whether a gap jumps there: one tooth follows another.
bool jumps(double before, double after) { return std::abs(after - before) > 1e-3; }

}  // namespace

TEST_CASE("contact rows of teeth, slots and stops are the derivatives of their gaps", "[gears]") {
  const auto scene = scene_of(scene_text(with_backlash));
  const System system(scene.mechanism);
  REQUIRE(system.contacts() == 14);
  auto e = system.make_evaluation();
  SystemTangent tangent(system, SystemTangent::Use::penalty);
  auto motion = tangent.make_slopes();
  DirectionBlocks blocks(system, 12);
  std::vector<std::vector<double>> units(6, std::vector<double>(12));
  for (std::size_t i = 0; i < 6; ++i) units[i][i] = 1;
  const std::vector<double> still(6);
  std::mt19937 engine(7);
  const double h = 1e-4;
  for (int trial = 0; trial < 50; ++trial) {
    const Motion6 m(engine);
    const auto gap = [&](int k, double t) {
      const auto q = m.at(t);
      system.place(0, q.data(), e);
      return system.gap(k, q.data(), e);
    };
    ContactRow row;
    const auto look = [&](int k, double t) {
      const auto q = m.at(t), v = m.rate(t);
      system.place(0, q.data(), e);
      system.contact(k, q.data(), v.data(), e, row);
      return row.normal.dot(v.data());
    };
    for (int k = 0; k < system.contacts(); ++k) {
      CAPTURE(trial, system.contact_facts(k).name);
      if (jumps(gap(k, -h), gap(k, h))) continue;
      const double rate = look(k, 0), bend = row.normal.dot(m.a.data()) - row.gamma_n;
      CHECK(row.gap == gap(k, 0));
      CHECK(row.normal.size == 6);
      // Differences of fourth order in h = 1e-4 of functions that change in times of 0.1: 1e-9, and
      // rounding 1e-15/h.
      CHECK(rate == Approx(slope([&](double t) { return gap(k, t); }, h)).margin(1e-8));
      CHECK(bend == Approx(slope([&](double t) { return look(k, t); }, h)).margin(1e-6));
      // The derivatives of the gap by the traced equations are the row itself.
      look(k, 0);
      tangent.begin_contact(
          {0, m.q.data(), m.v.data(), nullptr, still.data(), nullptr, e.cosine.data(), e.sine.data()}, k, {});
      blocks.take(units, {}, 0);
      SystemTangent::ContactSlopes slopes;
      tangent.contact(k, blocks.along(-1), motion, slopes);
      for (int i = 0; i < 6; ++i) CHECK(slopes.gap[i] == Approx(row.normal.value[i]).margin(1e-12));
    }
  }
}

TEST_CASE("constraint rows of ideal gears are the derivatives of their constraints", "[gears]") {
  const auto scene = scene_of(scene_text(""));
  const System system(scene.mechanism);
  REQUIRE(system.rows() == 3);
  auto e = system.make_evaluation();
  std::mt19937 engine(8);
  const double h = 1e-4;
  for (int trial = 0; trial < 50; ++trial) {
    const Motion6 m(engine);
    for (int k = 0; k < system.rows(); ++k) {
      CAPTURE(trial, system.row_name(k));
      const auto phi = [&](double t) {
        system.place(0, m.at(t).data(), e);
        return e.phi[k];
      };
      const auto along = [&](const std::vector<double>& x) {
        return row_dot(system.pattern(), e.G.data(), k, x.data());
      };
      const auto rate = [&](double t) {
        system.place(0, m.at(t).data(), e);
        return along(m.rate(t));
      };
      if (jumps(phi(-h), phi(h))) continue;
      const double now = rate(0);
      system.rate(m.q.data(), m.v.data(), e);
      const double bend = along(m.a) - e.gamma[k];
      CHECK(now == Approx(slope(phi, h)).margin(1e-8));
      CHECK(bend == Approx(slope(rate, h)).margin(1e-6));
    }
  }
}

TEST_CASE("gap bounds of teeth and stops hold over a step", "[gears][unseen]") {
  const auto scene = scene_of(scene_text(with_backlash));
  const System system(scene.mechanism);
  auto e = system.make_evaluation();
  std::mt19937 engine(9);
  std::uniform_real_distribution<double> u(-3, -0.5);
  int bounded = 0, tight = 0;
  ContactRow row;
  for (int trial = 0; trial < 400; ++trial) {
    const Motion6 m(engine);
    const double H = std::pow(10, u(engine));
    const auto end = m.at(H), v1 = m.rate(H);
    MotionBounds bounds;
    bounds.enclose(H, 6, m.q.data(), m.v.data(), m.a.data(), end.data(), v1.data(), m.a.data());
    for (int k = 0; k < system.contacts(); ++k) {
      system.place(0, end.data(), e);
      const auto motion = system.gap_motion(k, bounds, end.data(), e);
      if (motion.shape != GapMotion::Shape::straight || !std::isfinite(motion.acceleration)) continue;
      CAPTURE(trial, system.contact_facts(k).name, H);
      double most = 0;
      for (int i = 0; i <= 20; ++i) {
        const double t = H * i / 20;
        const auto q = m.at(t), v = m.rate(t);
        system.place(0, q.data(), e);
        system.contact(k, q.data(), v.data(), e, row);
        most = std::max(most, std::abs(row.normal.dot(m.a.data()) - row.gamma_n));
      }
      CHECK(most <= motion.acceleration * (1 + 1e-12));
      ++bounded;
      tight += most > 0.05 * motion.acceleration;
    }
  }
  CHECK(bounded > 2000);  // few are too close to have a bound
  CHECK(tight > bounded / 4);
}

TEST_CASE("the gap of a tooth is periodic over many revolutions", "[gears]") {
  const auto scene = scene_of(scene_text(with_backlash));
  const System system(scene.mechanism);
  auto e = system.make_evaluation();
  std::mt19937 engine(10);
  const Motion6 m(engine);
  const double two_pi = 2 * M_PI;
  const auto gap = [&](int k, double turns_a, double turns_b) {
    auto q = m.q;
    q[2] += two_pi * turns_a;
    q[5] += two_pi * turns_b;
    system.place(0, q.data(), e);
    return system.gap(k, q.data(), e);
  };
  // For the gears with teeth, whole revolutions of either change nothing; rounding of 1e3 rad over
  // 0.3 m.
  const int forward = find(system, "outer.forward"), backward = find(system, "outer.backward");
  for (const int k : {forward, backward}) {
    CHECK(gap(k, 0, 0) == Approx(gap(k, 41, 0)).margin(1e-12));
    CHECK(gap(k, 0, 0) == Approx(gap(k, -3, 170)).margin(1e-12));
  }
  // The sum of both flanks' gaps is the backlash: b + 2 S (inv α − inv α₀), for any angles of the
  // wheels.
  system.place(0, m.q.data(), e);
  const long double S = 0.255L * std::cos(20 * M_PIl / 180);
  const double play =
      double(1e-3L + 2 * (reference::involute(S, system.eccentricity(forward, m.q.data(), e).norm()) -
                          reference::involute(S, 0.255L)));
  CHECK(gap(forward, 0, 0) + gap(backward, 0, 0) == Approx(play).margin(1e-13));
}

TEST_CASE("invalid gears, slots and stops are refused", "[gears][scene]") {
  const test::Edit edits[] = {
      {"module = 0.01\n", "", "joints.outer.teeth: teeth and module go together"},
      {"teeth = [20, 31]\n", "teeth = [20, 30.5]\n", "joints.outer.teeth: must be two whole numbers from 1"},
      {"teeth = [20, 31]\nmodule = 0.01\n", "",
       "joints.outer: needs exactly one of teeth (with module) and pitch_radii"},
      {"pitch_radii = [0.32, 0.13]", "pitch_radii = [0.12, 0.13]",
       "joints.inner.internal: makes the first gear the ring, which must be larger"},
      {"pitch_radii = [0.32, 0.13]", "pitch_radii = [-0.32, 0.13]",
       "joints.inner.pitch_radii: must be two positive"},
      {"pressure_angle = 0.4", "pressure_angle = 20.0",
       "joints.inner.pressure_angle: must be between 0 and 1.5708 rad"},
      {"backlash = 1e-3", "backlash = 0.0", "joints.outer.backlash: must be greater than 0"},
      {"backlash = 1e-3", "flank = \"backward\"\nbacklash = 1e-3",
       "joints.outer.flank: applies to pairs without backlash; with backlash either flank is loaded"},
      {"restitution = 0.5\n", "restitution = 0.5\nfriction = 0.1\n",
       "joints.outer.surface: must be without friction"},
      {"module = 0.01\nphase = 0.3\n", "module = 0.1\n",
       "joints.outer: phase follows from the bodies' positions, and there the centres are too close"},
      {"phase = 0.3\n", "", "there the centres are too close for these gears, or too far apart"},
      {"joint = \"slot\"", "joint = \"pin\"", "contacts.travel.joint: must be a translational or slot joint"},
      {"joint = \"pin\"", "joint = \"slot\"", "contacts.turn.joint: must be a revolute joint"},
      {"lower = -0.1\nupper = 0.4\n", "", "contacts.travel: needs lower or upper, or both"},
      {"lower = -0.1\nupper = 0.4\n", "lower = 0.4\nupper = 0.4\n",
       "contacts.travel.upper: must be greater than lower"},
      {"radius = 0.05\n", "", "contacts.turn.radius: is required with direction"},
      {"joint = \"pin\"\nsurface = \"hard\"\nupper = 2.0\nradius = 0.05\n",
       "joint = \"pin\"\nsurface = \"hard\"\nupper = 2.0\ncurvature_radius = 0.01\n",
       "contacts.couple.radius: is required with curvature_radius"},
      {"pin_radius = 0.01\n", "", "joints.slot.pin_radius: is missing"},
      {"lower = -0.1\n", "lower = -0.1\nstiffness = 1e5\ncurvature_radius = 0.1\n",
       "contacts.travel.curvature_radius: computes the stiffness"},
  };
  const std::string good = scene_text(with_backlash);
  REQUIRE_NOTHROW(scene_of(good));
  for (const auto& edit : edits) {
    CAPTURE(edit.from, edit.to);
    CHECK_THAT(test::refusal(test::replaced(good, edit.from, edit.to)), Contains(edit.words));
  }
}

TEST_CASE("a couple of stops needs no radius, and its impact does not depend on it", "[gears]") {
  // A rod turns about its pin at 10 rad/s and meets the stop at 0.5 rad after 0.05 s: −0.6 * 10 rad/s.
  const double e = 0.6, w = 10;
  for (const auto* radius : {"", "radius = 0.02\n", "radius = 0.5\n"})
    for (const auto& way : {test::event_driven, test::fixed_steps(1e-5)}) {
      const auto text =
          "format = 2\n" +
          test::body("rod", 1.0, 0.01,
                     "position = [0.1, 0.0]\nvelocity = [0.0, 1.0]\nangular_velocity = 10.0\n") +
          test::pin("pin", "ground", "rod", {}, {-0.1, 0.0}) +
          test::stop("stop", "angle-stop", "pin", fmt::format("upper = 0.5\n{}", radius), "steel") +
          test::surface("steel", e) + test::run_for(0.06, "start = \"given\"\n");
      CAPTURE(radius);
      // Fixed steps: the error of velocities at the end of a step, (ω h)², with a margin of 100.
      CHECK(test::finished(way, text).final_state.v[2] == Approx(-e * w).epsilon(1e-6));
    }
  const auto scene =
      scene_of(test::replaced(scene_text(with_backlash), "surface = \"hard\"\nupper = 2.0\nradius = 0.05\n",
                              "surface = \"hard\"\nupper = 2.0\n"));
  int couples = 0;
  for (const auto& contact : scene.mechanism.contacts)
    if (const auto* stop = std::get_if<AngleStop>(&contact); stop && stop->name == "couple")
      couples += !stop->radius && stop->arm() == 1;
  CHECK(couples == 1);
  CHECK(to_toml(parse_scene(to_toml(scene), "again")) == to_toml(scene));
}

TEST_CASE("an absent tooth phase is taken from the initial poses and stays in the canonical text",
          "[gears][scene]") {
  for (const std::string play : {with_backlash, ""}) {
    auto text = scene_text(play);
    for (const char* phase : {"phase = 0.3\n", "phase = 1.1\n", "phase = -0.2\n"})
      text = test::replaced(text, phase, "");
    // In the meshing position of the outer pair, 5 mm beyond its standard distance.
    text = test::replaced(text, "[0.32, 0.05]", "[0.30, 0.00]");
    text = test::replaced(text, "axis = [0.6, 0.8]", "axis = [0.0, 1.0]");
    CAPTURE(text);
    const auto scene = scene_of(text);
    const System system(scene.mechanism);
    auto e = system.make_evaluation();
    const std::vector<double> q{0, 0, 0, 0.3, 0, 0};
    system.place(0, q.data(), e);
    if (play.empty()) {
      for (const double phi : e.phi) CHECK(std::abs(phi) < 1e-14);
    } else {
      for (const std::string joint : {"outer", "inner", "rack"})
        CHECK(system.gap(find(system, joint + ".forward"), q.data(), e) ==
              Approx(system.gap(find(system, joint + ".backward"), q.data(), e)).margin(1e-14));
    }
    CHECK(to_toml(parse_scene(to_toml(scene), "again")) == to_toml(scene));
  }
}

TEST_CASE("no tooth is skipped in a long step", "[gears][unseen]") {
  // Constant forces, so that only the teeth limit a step; between contacts the gear gains more than
  // a tooth.
  const auto text =
      "format = 2\n" + test::body("pinion", 1.0, 0.001) +
      test::body("bar", 2.0, 0.004, "position = [0.0, -0.05]\n") + test::pin("front", "ground", "pinion") +
      test::guide("guide", "ground", "bar", {1, 0}, {0.0, -0.05}) +
      test::joint("mesh", "rack", "pinion", "bar", {}, {},
                  "pitch_radius = 0.05\nmodule = 5e-3\nbacklash = 1e-4\nmesh_stiffness = 2e8\n"
                  "surface = \"steel\"\n") +
      test::surface("steel", 0.6) + "[loads.engine]\ntype = \"torque\"\nbody = \"pinion\"\ntorque = 1.0\n" +
      test::run_for(0.1, "start = \"given\"\n");
  for (const auto& way : {test::event_driven, test::automatic}) {
    CAPTURE(way.name);
    const auto run = test::finished(way, text);
    CHECK(run.extremes.penetration[0] < 1e-6 * 5e-5);
    // Finally in lasting contact: a = (M/r)/(m + J/r²), from the first contact on within the
    // backlash.
    CHECK(run.final_state.q[3] == Approx(0.5 * 20 / 2.4 * 0.01).margin(1e-4));
  }
}

namespace {

/// Two gears of 20 teeth of module 5 mm on pins at this distance (m); pitch circles touch at 0.1 m.
std::string gears_at(double distance, const std::string& more = "",
                     const std::string& size = "teeth = [20, 20]\nmodule = 5e-3\n") {
  return test::body("a", 1, 0.01) + test::body("b", 1, 0.01, fmt::format("position = [{}, 0]\n", distance)) +
         test::pin("left", "ground", "a") + test::pin("right", "ground", "b", {distance, 0}) +
         test::joint("mesh", "gear", "a", "b", {}, {}, size + more) + test::surface("hard", 0.5) +
         test::motor("motor", "left", 1) + test::run_for(0.1);
}

}  // namespace

TEST_CASE("contact ratio and play of gears follow the distance of their centres", "[gears]") {
  // Path of contact over base pitch, and play 2 S (inv α' − inv α), by hand; 1.557 is in the textbooks'
  // tables for 20 teeth on 20.
  const std::string backlash = "backlash = 1e-4\nsurface = \"hard\"\n";
  const struct {
    double distance, ratio, play;
  } rows[] = {{0.1, 1.5568383, 0}, {0.101, 1.3656543, 0.7090003e-3}, {0.104, 0.8549690, 3.1017017e-3}};
  for (const auto& row : rows) {
    CAPTURE(row.distance);
    const auto scene = scene_of(gears_at(row.distance, backlash));
    const auto teeth = teeth_at(scene.mechanism, assemble(scene.mechanism, scene.run.start).q).at(0);
    CHECK(*teeth.contact_ratio == Approx(row.ratio).epsilon(1e-7));
    CHECK(teeth.play == Approx(row.play + 1e-4).epsilon(1e-6));
    CHECK(teeth.apart == Approx(row.distance - 0.11).epsilon(1e-9));
  }
}

namespace {

/// A gear of module 5 mm whose centre is at this height (m) above the pitch line of a rack.
std::string rack_at(double height, int teeth, const std::string& more) {
  return test::body("a", 1, 0.01, fmt::format("position = [0, {}]\n", height)) + test::body("bar", 1, 0.01) +
         test::pin("pin", "ground", "a", {0, height}) + test::guide("guide", "ground", "bar") +
         test::joint("mesh", "rack", "a", "bar", {}, {},
                     fmt::format("pitch_radius = {}\nmodule = 5e-3\n", 2.5e-3 * teeth) + more) +
         test::surface("hard", 0.5) + test::motor("motor", "pin", 1) + test::run_for(0.1);
}

}  // namespace

TEST_CASE("contact ratio and play of a rack follow the height of the gear", "[gears]") {
  // By hand: from the pitch point to the tip of the gear √(r_a² − r_b²) − r sin 20°, to that of the rack
  // (m − h + r)/sin 20°, over π m cos 20°. A gear of 20 teeth on one of a million has 1.768816 by the
  // formula of gears. Of 12 teeth, less than 2/sin² 20° = 17.1, the tip of the rack lies beyond the base
  // circle's point of tangency, r sin 20° from the pitch point.
  const struct {
    int teeth;
    double height, ratio, play;
  } rows[] = {{20, 0.05, 1.7688237, 0},
              {20, 0.052, 1.3726619, 1.3680806e-3},
              {20, 0.056, 0.5803382, 4.1042417e-3},
              {12, 0.03, 1.4053027, 0}};
  for (const auto& row : rows) {
    CAPTURE(row.teeth, row.height);
    const auto scene = scene_of(rack_at(row.height, row.teeth, "backlash = 1e-4\nsurface = \"hard\"\n"));
    const auto teeth = teeth_at(scene.mechanism, assemble(scene.mechanism, scene.run.start).q).at(0);
    CHECK(teeth.rack);
    CHECK(teeth.distance == Approx(row.height).epsilon(1e-12));
    CHECK(*teeth.contact_ratio == Approx(row.ratio).epsilon(1e-7));
    CHECK(teeth.play == Approx(row.play + 1e-4).epsilon(1e-6));
    CHECK(teeth.apart == Approx(row.height - 2.5e-3 * row.teeth - 0.01).epsilon(1e-9));
  }
  const auto refusal = [](const std::string& text) {
    return test::refusal_of([&] { Simulation(scene_of(text), "penalty", {}); });
  };
  CHECK(refusal(rack_at(0.0599, 20, "")) == "accepted");  // tips part at 0.06 m
  CHECK_THAT(refusal(rack_at(0.0601, 20, "")),
             Contains("joints.mesh: ") && Contains("the rack's pitch line"));
}

TEST_CASE("an ideal gear pair whose teeth do not reach each other is refused", "[gears]") {
  const auto refusal = [](const std::string& text) {
    return test::refusal_of([&] { Simulation(scene_of(text), "penalty", {}); });
  };
  const std::string circles = "pitch_radii = [0.05, 0.05]\n";
  for (const std::string phase : {"", "phase = 0\n"})
    for (const auto& size : {std::string("teeth = [20, 20]\nmodule = 5e-3\n"), circles}) {
      CAPTURE(phase, size);
      CHECK_THAT(refusal(gears_at(0.167, phase, size)), Contains("joints.mesh: "));
      CHECK(refusal(gears_at(0.1, phase, size)) == "accepted");
      CHECK(refusal(gears_at(0.109, phase, size)) == "accepted");  // tips part at 0.11 m
    }
  CHECK_THAT(refusal(gears_at(0.1101, "phase = 0\n")), Contains("too far for the tips of the teeth to meet"));
}
