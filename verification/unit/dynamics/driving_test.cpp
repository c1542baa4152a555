// Drives along curves: files of points, refusals of the reader, the exact Jacobian of curves,
// motors and governors, and rows within long steps.
#include "dynamics/system.hpp"
#include "io/scene/write_scene.hpp"
#include "mechanism/curve.hpp"
#include "verification/support/jacobian_check.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using test::refusal;

namespace {

const std::string rotor = test::body("rotor", 2.0, 0.05) + test::pin("main", "ground", "rotor");
const std::string length = "[run]\nduration = 0.5\n";

}  // namespace

TEST_CASE("points of a curve may be read from a file beside the scene", "[driving]") {
  const test::TemporaryFolder folder;
  const auto scene_file = folder.path() / "inner" / "s.toml";
  std::filesystem::create_directory(folder.path() / "inner");
  const auto write = [&](const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file) << text;
  };
  write(folder.path() / "inner" / "m.csv", "# measured\nt,skip,torque\n0,9,1\n0.2,9,3.5\n\n0.5,9,-1\n");
  write(folder.path() / "m.csv", "t,torque\n0,1\n1,2\n");
  const auto text = [](const std::string& lines) {
    return rotor + "[curves.c]\nshape = \"table\"\n" + lines +
           "[drives.d]\njoint = \"main\"\ntorque_curve = \"c\"\n" + length;
  };
  write(scene_file, text("file = \"m.csv\"\ncolumns = [\"t\", \"torque\"]\n"));
  const auto scene = read_scene(scene_file);
  REQUIRE(scene.mechanism.curves.size() == 1);
  CHECK(scene.mechanism.curves[0].points == Curve::Points{{0, 1}, {0.2, 3.5}, {0.5, -1}});
  REQUIRE(scene.files.size() == 1);
  CHECK(scene.files[0].name == "m.csv");
  // The canonical text needs no file.
  const auto facts = to_toml(scene);
  CHECK_THAT(facts, !Contains("m.csv"));
  CHECK(to_toml(parse_scene(facts, "elsewhere/x.toml")) == facts);

  const auto in = [&](const std::string& lines) { return refusal(text(lines), {}, scene_file.string()); };
  CHECK_THAT(in("file = \"../m.csv\"\n"), Contains("is outside the scene's folder"));
  CHECK_NOTHROW(parse_scene(text("file = \"../m.csv\"\n"), scene_file.string(), {}, true));
  CHECK_THAT(in("file = \"none.csv\"\n"), Contains("curves.c.file"));
  CHECK_THAT(in("file = \"m.csv\"\ncolumns = [\"t\", \"force\"]\n"),
             Contains("has no column \"force\"; there are: \"t\""));
  CHECK_THAT(in("file = \"m.csv\"\ncolumns = [\"t\"]\n"), Contains("must name two columns"));
  CHECK_THAT(in("file = \"m.csv\"\npoints = [[0, 1], [1, 2]]\n"), Contains("exactly one of points and file"));
  CHECK_THAT(in("points = [[0, 1], [1, 2]]\ncolumns = [\"a\", \"b\"]\n"),
             Contains("names columns of a file"));
  write(folder.path() / "inner" / "bad.csv", "t,x\n0,1\n1,oh\n");
  CHECK_THAT(in("file = \"bad.csv\"\n"), Contains("line 3: x: \"oh\" is not a finite number"));
  write(folder.path() / "inner" / "short.csv", "t,x\n0,1\n1\n");
  CHECK_THAT(in("file = \"short.csv\"\n"), Contains("line 3 has 1 fields, the header 2"));
  write(folder.path() / "inner" / "back.csv", "t,x\n0,1\n0,2\n");
  CHECK_THAT(in("file = \"back.csv\"\n"), Contains("must increase in x; 0 follows 0"));
  // A file without a header would lose its first point.
  write(folder.path() / "inner" / "bare.csv", "0,1\n1,2\n2,5\n");
  CHECK_THAT(in("file = \"bare.csv\"\n"),
             Contains("curves.c.file: line 1: expected a header with the names of "
                      "the columns"));
  CHECK_THAT(in("points = []\n"), Contains("must be a list of pairs [[a, b], ...], is an empty one"));
}

TEST_CASE("tables of springs, torques and cams may be read from files", "[driving][spring]") {
  const test::TemporaryFolder folder;
  const auto scene_file = folder.path() / "s.toml";
  const auto write = [&](const char* name, const char* text) { std::ofstream(folder.path() / name) << text; };
  write("pull.csv", "length,force\n0.1,-2\n0.3,0\n0.5,4\n");
  write("lift.csv", "angle,lift\n0,0\n2,0.004\n4,0.001\n");
  write("back.csv", "a,b\n0,1\n0,2\n");
  write("none.csv", "a,b\n");
  const auto text = [](const std::string& pull, const std::string& lift, const std::string& torque) {
    return rotor +
           "[surfaces.s]\nrestitution = 0.5\n[bodies.v]\nmass = 1\ninertia = 1\n[loads.k]\ntype = "
           "\"spring-damper\"\nbetween = [\"ground\", \"v\"]\nforce_table = " +
           pull + "\n[drives.d]\njoint = \"main\"\ntorque_table = " + torque +
           "\n[contacts.c]\ntype = \"cam\"\nbetween = [\"ground\", \"v\"]\nbase_radius = 0.05\nsurface = "
           "\"s\"\nlift_table = " +
           lift + "\n" + length;
  };
  const auto by_file = parse_scene(text("\"pull.csv\"", "\"lift.csv\"", "\"pull.csv\""), scene_file.string());
  const std::string pull = "[[0.1, -2], [0.3, 0], [0.5, 4]]";
  const auto by_points =
      parse_scene(text(pull, "[[0, 0], [2, 0.004], [4, 0.001]]", pull), scene_file.string());
  CHECK(to_toml(by_file) == to_toml(by_points));
  CHECK(by_file.files.size() == 3);
  const auto in = [&](const char* name) {
    return refusal(text(std::string("\"") + name + "\"", "[[0, 0], [2, 0.004], [4, 0.001]]", pull), {},
                   scene_file.string());
  };
  CHECK_THAT(in("back.csv"), Contains("loads.k.force_table: must increase in its first column; 0 follows 0"));
  CHECK_THAT(in("none.csv"), Contains("loads.k.force_table: must have points below its header"));
  CHECK_THAT(in("gone.csv"), Contains("loads.k.force_table"));
  CHECK_THAT(in("../pull.csv"), Contains("is outside the scene's folder"));
}

TEST_CASE("invalid curves and drives are refused at their place", "[driving]") {
  const auto drive = [](const std::string& lines, const std::string& curve = "") {
    return refusal(rotor + curve + "[drives.d]\njoint = \"main\"\n" + lines + length);
  };
  const std::string lines = "[curves.c]\nshape = \"table\"\npoints = [[0, 0], [1, 1], [2, 0]]\n";
  CHECK(drive("velocity = \"c\"\n", lines) == "accepted");
  CHECK_THAT(drive("velocity = \"c\"\n"), Contains("there is no curve \"c\""));
  CHECK_THAT(drive("position = \"c\"\n", lines),
             Contains("drives.d.position: the curve \"c\" has a kink at x"));
  CHECK(drive("position = \"c\"\n", lines + "between = \"spline\"\n") == "accepted");
  CHECK(drive("position = \"c\"\n", lines + "between = \"spline\"\nrepeat = true\n") == "accepted");
  CHECK_THAT(drive("torque_curve = \"c\"\n",
                   "[curves.c]\nshape = \"table\"\npoints = [[0, 0], [1, 1]]\nrepeat = true\n"),
             Contains("begins at 0 and ends at 1"));
  CHECK_THAT(drive("velocity = \"c\"\nspeed = 3\n", lines), Contains("needs exactly one of"));
  CHECK_THAT(drive("velocity = \"c\"\nof = \"main\"\n", lines), Contains("goes with position"));
  CHECK_THAT(drive("position = \"c\"\nof = \"main\"\n", lines + "between = \"spline\"\n"),
             Contains("is the driven joint itself"));
  CHECK_THAT(drive("force = 3\n"), Contains("must be a translational joint"));
  CHECK_THAT(
      refusal(rotor + "[bodies.block]\nmass = 1\ninertia = 1\n[joints.guide]\ntype = \"translational\"\n" +
              "between = [\"ground\", \"block\"]\n" + lines +
              "[drives.d]\njoint = \"guide\"\nvelocity = \"c\"\ncrank = true\n" + length),
      Contains("drives.d.crank: needs a revolute joint"));
  CHECK_THAT(refusal(rotor + "[bodies.wheel]\nmass = 1\ninertia = 1\nposition = [0.3, 0]\n" +
                     "[joints.mesh]\ntype = \"gear\"\nbetween = [\"rotor\", \"wheel\"]\n" +
                     "pitch_radii = [0.1, 0.2]\n" + lines +
                     "[drives.d]\njoint = \"mesh\"\nvelocity = \"c\"\n" + length),
             Contains("drives.d.joint: must be a revolute or translational joint, \"mesh\" is a gear joint"));
  CHECK_THAT(drive("torque_curve = \"c\"\nagainst = \"position\"\n", lines),
             Contains("has an angle, no position"));
  CHECK_THAT(drive("voltage = 24\nresistance = 0\ntorque_constant = 1\n"), Contains("resistance"));
  CHECK_THAT(drive("voltage = \"none\"\nresistance = 1\ntorque_constant = 1\n"),
             Contains("there is no curve \"none\""));
  CHECK_THAT(drive("target_speed = 3\n"), Contains("needs proportional or integral"));
  CHECK_THAT(drive("breakdown_torque = 3\nbreakdown_slip = 0.2\nsynchronous_speed = 0\n"),
             Contains("must not be 0"));
  CHECK_THAT(drive("velocity = \"c\"\n", "[curves.c]\nshape = \"ramp\"\nto = 3\nrise = 0\n"),
             Contains("greater than 0"));
  CHECK_THAT(drive("velocity = \"c\"\n", "[curves.c]\nshape = \"ramp\"\nto = 3\nrise = 1\ndwell = 2\n"),
             Contains("curves.c.dwell: does not apply to a ramp"));
  const auto load = [](const std::string& more) {
    return refusal(
        rotor +
        "[curves.c]\nshape = \"constant\"\nvalue = 1\n[loads.l]\ntype = \"force\"\nbody = \"rotor\"\n"
        "force = [1, 0]\n" +
        more + length);
  };
  CHECK_THAT(load("against = \"angle\"\n"), Contains("goes with factor"));
  CHECK_THAT(load("factor = \"c\"\nagainst = \"position\"\naxes = \"body\"\n"),
             Contains("no direction in the world"));
}

TEST_CASE("the canonical text contains every kind of drive", "[driving]") {
  const auto scene = parse_scene(
      rotor + test::body("block", 1, 1, "position = [0.4, 0.3]\n") +
          test::guide("guide", "ground", "block", {0.8, 0.6}) + R"([curves.up]
shape = "ramp"
to = 3
rise = 0.2
[curves.wave]
shape = "harmonic"
amplitude = 2
frequency = 50
)" + test::drive("a", "main", "voltage = \"wave\"\nresistance = 1\ntorque_constant = 0.1\n") +
          test::drive("b", "main", "target_speed = 3\nintegral = 2\ntorque_limit = 1\n") +
          test::drive("c", "guide", "velocity = \"up\"\n") +
          test::drive("d", "guide", "force = \"wave\"\nagainst = \"speed\"\n") +
          test::drive("e", "main",
                      "breakdown_torque = 3\nbreakdown_slip = 0.2\nsynchronous_speed_rpm = -1500\n") +
          "[loads.l]\ntype = \"force\"\nbody = \"rotor\"\nforce = [1, 0]\n"
          "axes = \"body\"\nfactor = \"up\"\n" +
          length,
      "s");
  const auto facts = to_toml(scene);
  CHECK(to_toml(parse_scene(facts, "again")) == facts);
  // from the body's position
  CHECK(std::get<MotionDrive>(scene.mechanism.drives[2]).initial == Approx(0.5));
  CHECK(scene.mechanism.curves[1].period == 0.02);
}

TEST_CASE("the exact Jacobian is correct with curves, motors and governors", "[driving][jacobian]") {
  const auto scene = parse_scene(
      test::body("a", 1.5, 0.2) + test::body("b", 0.7, 0.1) + test::body("c", 0.4, 0.3) +
          test::pin("pin", "ground", "a", {0.1, 0.2}, {0.3, -0.1}) +
          test::guide("slide", "a", "b", {0.6, 0.8}, {0.02, 0.03}, {-0.04, 0.05}) +
          test::pin("free", "a", "c", {0.1, 0.0}, {0.2, 0.1}) + test::harmonic("wave", 0.7, 2.1) +
          R"([curves.bent]
shape = "table"
points = [[-9, 1], [-2, 0.3], [0.1, -0.4], [3, 0.5], [9, 2]]
between = "spline"
)" + test::drive("place", "slide", "position = \"wave\"\nof = \"pin\"\n") +
          test::drive("turn", "pin", "velocity = \"bent\"\n") +
          test::drive("motor", "free",
                      "voltage = \"wave\"\nresistance = 0.7\ntorque_constant = 0.3\n"
                      "inductance = 0.4\n") +
          test::drive("governor", "free", "target_speed = \"bent\"\nproportional = 0.4\nintegral = 0.6\n") +
          test::drive("mains", "free",
                      "breakdown_torque = 0.8\nbreakdown_slip = 0.6\nsynchronous_speed = 2\n") +
          test::drive("push", "slide", "force = \"bent\"\nagainst = \"position\"\n") +
          test::drive("rub", "slide", "force = \"bent\"\nagainst = \"speed\"\n") +
          test::drive("twist", "free", "torque_curve = \"wave\"\nagainst = \"angle\"\n") + R"([loads.jet]
type = "force"
body = "c"
at = [0.1, 0.2]
force = [0.4, 0.3]
axes = "body"
factor = "wave"
against = "angle"
[loads.wind]
type = "force"
body = "b"
force = [0.4, 0.3]
factor = "bent"
against = "speed"
[loads.drag]
type = "torque"
body = "c"
torque = 0.3
factor = "bent"
against = "speed"
)" + length,
      "jacobian");
  CHECK(test::jacobian_error(scene, 7) < 1e-6);
}

TEST_CASE("a run with motors continues from a snapshot bit for bit", "[driving]") {
  const auto scene = parse_scene(
      rotor + "[curves.supply]\nshape = \"ramp\"\nto = 24\nrise = 0.2\n" +
          test::drive("motor", "main",
                      "voltage = \"supply\"\nresistance = 1.5\ntorque_constant = 0.4\n"
                      "inductance = 0.01\n") +
          test::drive("governor", "main", "target_speed = 10\nproportional = 0.1\nintegral = 1\n") + length,
      "s");
  for (const auto* formulation : {"penalty", "nonsmooth"}) {
    Simulation whole(scene, formulation), first(scene, formulation), second(scene, formulation);
    REQUIRE(whole.run().ending.status == Ending::Status::finished);
    first.run({.until = 0.21});
    second.restore(first.snapshot());
    first.run();
    second.run();
    CHECK(first.state().v == second.state().v);
    CHECK(first.state().z == second.state().z);
    CHECK(first.state().v[2] == Approx(whole.state().v[2]).epsilon(1e-6));
  }
}

TEST_CASE("a joint driven beyond its reach is reported with its drive", "[driving]") {
  const auto scene =
      parse_scene(rotor +
                      "[curves.c]\nshape = \"constant\"\nvalue = 0.7\n[drives.d]\njoint = \"main\"\n"
                      "position = \"c\"\n[drives.e]\njoint = \"main\"\nspeed = 0\ninitial_angle = 0.2\n" +
                      length,
                  "s");
  CHECK_THROWS_WITH(Simulation(scene, "penalty"), Contains("cannot be closed"));
}

TEST_CASE("rows between the ends of long steps are as accurate as the ends", "[driving][output]") {
  // A prescribed motion: a 3-4-5 rise of 0.5 rad in 0.4 s, polynomials that a method of high order
  // integrates in a few steps.
  const auto scene = parse_scene(
      rotor + test::drive("d", "main", "position = \"c\"\n") +
          "[curves.c]\nshape = \"rise-dwell-return\"\nto = 0.5\nstart = 0.1\nrise = 0.4\n"
          "dwell = 0.1\nreturn = 0.2\n" +
          test::run_for(1) + "[penalty]\nintegrator = \"" +
          GENERATE(as<std::string>{}, "adams_bashforth_moulton", "bulirsch_stoer", "dopri5", "rosenbrock4") +
          "\"\n",
      "s.toml");
  struct Rows final : Observer {
    void begin(const Layout&, const State& state) override { q = state.q, v = state.v; }
    void step(const Step& step) override {
      for (int k = 1; k < 8; ++k) {
        const double t = step.t0 + k / 8.0 * (step.t1 - step.t0);
        step.state(t, q, v);
        const double T = t < 0.6 ? 0.4 : -0.2, s = t < 0.6 ? (t - 0.1) / 0.4 : (0.8 - t) / 0.2;
        const double u = std::clamp(s, 0.0, 1.0);
        angle = std::max(angle, std::abs(q[2] - 0.5 * u * u * u * (10 + u * (6 * u - 15))));
        rate = std::max(rate, std::abs(v[2] - 0.5 * 30 * u * u * (1 - u) * (1 - u) / T));
      }
    }
    std::vector<double> q, v;
    double angle = 0, rate = 0;
  } rows;
  RunRequest request;
  request.observers = {&rows};
  REQUIRE(Simulation(scene, "penalty").run(request).ending.status == Ending::Status::finished);
  // The tolerance, 1e-9, on 0.5 rad and 4.7 rad/s; some tens of steps. Cubic interpolation between
  // them had errors of 2e-4 and 3e-3.
  CHECK(rows.angle < 1e-7);
  CHECK(rows.rate < 1e-6);
}

TEST_CASE("a force and a torque may depend on the angle of another joint", "[driving]") {
  // A crank turns at 10 rad/s from 0.3 rad; the curve is 4 sin φ, so that a velocity is (4/10
  // Ω)(cos 0.3 − cos φ) over its inertia.
  const std::string start = "format = 2\n" + test::body("crank", 1, 0.1, "angle = 0.3\n") +
                            test::body("block", 2, 0.5) + test::body("rotor", 2, 0.5) +
                            test::pin("shaft", "ground", "crank") + test::guide("guide", "ground", "block") +
                            test::pin("main", "ground", "rotor") + test::motor("motor", "shaft", 10) +
                            "[curves.gas]\nshape = \"harmonic\"\namplitude = 4\nperiod = \"1 turn\"\n" +
                            test::run_for(0.7);
  const std::string reads = "against = \"angle\"\nof = \"shaft\"\n";
  struct Kind {
    std::string text;
    std::size_t rate;
    double inertia;
  };
  const auto kind = GENERATE_COPY(values<Kind>(
      {{"[drives.d]\njoint = \"guide\"\nforce = \"gas\"\n", 3, 2},
       {"[drives.d]\njoint = \"main\"\ntorque_curve = \"gas\"\n", 8, 0.5},
       {"[loads.l]\ntype = \"force\"\nbody = \"block\"\nforce = [1, 0]\nfactor = \"pure\"\n", 3, 2},
       {"[loads.l]\ntype = \"torque\"\nbody = \"rotor\"\ntorque = 1\nfactor = \"pure\"\n", 8, 0.5}}));
  const auto* formulation = GENERATE("penalty", "nonsmooth");
  auto text = start;
  text += "[curves.pure]\nshape = \"harmonic\"\namplitude = 4\nperiod = 6.283185307179586\n";
  const auto scene = parse_scene(text + kind.text + reads, "s.toml");
  CHECK(same_facts(parse_scene(to_toml(scene), "again"), scene));
  Simulation simulation(scene, formulation);
  REQUIRE(simulation.run().ending.status == Ending::Status::finished);
  CHECK(simulation.state().v[kind.rate] ==
        Approx(4 / (10 * kind.inertia) * (std::cos(0.3) - std::cos(7.3))).epsilon(1e-7));
  CHECK_THAT(refusal(text + kind.text + "of = \"shaft\"\n"),
             Contains("goes with a curve against = \"angle\""));
}
