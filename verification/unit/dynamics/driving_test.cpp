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
const std::string length = test::run_for(0.5);

}  // namespace

TEST_CASE("points of a curve may be read from a file beside the scene", "[driving]") {
  const test::TemporaryFolder folder;
  const auto scene_file = folder.path() / "inner" / "s.toml";
  std::filesystem::create_directory(folder.path() / "inner");
  write_file(folder.path() / "inner" / "m.csv", "# measured\nt,skip,torque\n0,9,1\n0.2,9,3.5\n\n0.5,9,-1\n");
  write_file(folder.path() / "m.csv", "t,torque\n0,1\n1,2\n");
  const auto text = [](const std::string& lines) {
    return rotor + test::curve("c", "table", lines) + test::drive("d", "main", "torque_curve = \"c\"\n") +
           length;
  };
  write_file(scene_file, text("file = \"m.csv\"\ncolumns = [\"t\", \"torque\"]\n"));
  const auto scene = read_scene(scene_file);
  REQUIRE(scene.mechanism.curves.size() == 1);
  CHECK(scene.mechanism.curves[0].points == Curve::Points{{0, 1}, {0.2, 3.5}, {0.5, -1}});
  REQUIRE(scene.files.size() == 1);
  CHECK(scene.files[0].name == "m.csv");
  // The canonical text needs no file.
  const auto facts = to_toml(scene);
  CHECK_THAT(facts, !Contains("m.csv"));
  CHECK(to_toml(parse_scene(facts, "elsewhere/x.toml")) == facts);

  const std::pair<const char*, const char*> files[] = {{"bad.csv", "t,x\n0,1\n1,oh\n"},
                                                       {"short.csv", "t,x\n0,1\n1\n"},
                                                       {"back.csv", "t,x\n0,1\n0,2\n"},
                                                       // Without a header the first point would be lost.
                                                       {"bare.csv", "0,1\n1,2\n2,5\n"}};
  for (const auto& [name, content] : files) write_file(folder.path() / "inner" / name, content);
  CHECK_NOTHROW(parse_scene(text("file = \"../m.csv\"\n"), scene_file.string(), {}, true));
  test::check_messages(
      [&](const std::string& lines) { return refusal(text(lines + "\n"), {}, scene_file.string()); },
      {{"file = \"../m.csv\"", "is outside the scene's folder"},
       {"file = \"none.csv\"", "curves.c.file"},
       {"file = \"m.csv\"\ncolumns = [\"t\", \"force\"]", "has no column \"force\"; there are: \"t\""},
       {"file = \"m.csv\"\ncolumns = [\"t\"]", "must name two columns"},
       {"file = \"m.csv\"\npoints = [[0, 1], [1, 2]]", "exactly one of points and file"},
       {"points = [[0, 1], [1, 2]]\ncolumns = [\"a\", \"b\"]", "names columns of a file"},
       {"file = \"bad.csv\"", "line 3: x: \"oh\" is not a finite number"},
       {"file = \"short.csv\"", "line 3 has 1 field, the header has 2"},
       {"file = \"back.csv\"", "must increase in x; 0 follows 0"},
       {"file = \"bare.csv\"", "curves.c.file: line 1: expected a header with the names of the columns"},
       {"points = []", "must be a list of pairs [[a, b], ...], is an empty one"}});
}

TEST_CASE("tables of springs, torques and cams may be read from files", "[driving][spring]") {
  const test::TemporaryFolder folder;
  const auto scene_file = folder.path() / "s.toml";
  for (const auto& [name, content] : {std::pair{"pull.csv", "length,force\n0.1,-2\n0.3,0\n0.5,4\n"},
                                      {"lift.csv", "angle,lift\n0,0\n2,0.004\n4,0.001\n"},
                                      {"back.csv", "a,b\n0,1\n0,2\n"},
                                      {"none.csv", "a,b\n"}})
    write_file(folder.path() / name, content);
  const auto text = [](const std::string& pull, const std::string& lift, const std::string& torque) {
    return rotor + test::surface("s", 0.5) + test::body("v", 1, 1) +
           "[loads.k]\ntype = \"spring-damper\"\nbetween = [\"ground\", \"v\"]\nforce_table = " + pull +
           "\n" + test::drive("d", "main", "torque_table = " + torque) +
           "\n[contacts.c]\ntype = \"cam\"\nbetween = [\"ground\", \"v\"]\nbase_radius = 0.05\nsurface = "
           "\"s\"\nlift_table = " +
           lift + "\n" + length;
  };
  const std::string pull = "[[0.1, -2], [0.3, 0], [0.5, 4]]", lift = "[[0, 0], [2, 0.004], [4, 0.001]]";
  const auto by_file = parse_scene(text("\"pull.csv\"", "\"lift.csv\"", "\"pull.csv\""), scene_file.string());
  CHECK(to_toml(by_file) == to_toml(parse_scene(text(pull, lift, pull), scene_file.string())));
  CHECK(by_file.files.size() == 3);
  test::check_messages(
      [&](const std::string& name) { return refusal(text(name, lift, pull), {}, scene_file.string()); },
      {{"\"back.csv\"", "loads.k.force_table: must increase in its first column; 0 follows 0"},
       {"\"none.csv\"", "loads.k.force_table: must have points below its header"},
       {"\"gone.csv\"", "loads.k.force_table"},
       {"\"../pull.csv\"", "is outside the scene's folder"}});
}

TEST_CASE("invalid curves and drives are refused at their place", "[driving]") {
  using namespace test;
  // Curves may follow the drive's own keys.
  const auto with_drive = [](const std::string& lines) {
    return refusal(rotor + drive("d", "main", lines) + length);
  };
  const std::string kinked = table("c", "[[0, 0], [1, 1], [2, 0]]"),
                    smooth = kinked + "between = \"spline\"\n";
  for (const auto& good : {"velocity = \"c\"\n" + kinked, "position = \"c\"\n" + smooth,
                           "position = \"c\"\n" + smooth + "repeat = true\n"})
    CHECK(with_drive(good) == "accepted");
  check_messages(with_drive,
                 {{"velocity = \"c\"\n", "there is no curve \"c\""},
                  {"position = \"c\"\n" + kinked, "drives.d.position: the curve \"c\" has a kink at x"},
                  {"torque_curve = \"c\"\n" + table("c", "[[0, 0], [1, 1]]", "repeat = true\n"),
                   "begins at 0 and ends at 1"},
                  {"velocity = \"c\"\nspeed = 3\n" + kinked, "needs exactly one of"},
                  {"velocity = \"c\"\nof = \"main\"\n" + kinked, "goes with position"},
                  {"position = \"c\"\nof = \"main\"\n" + smooth, "is the driven joint itself"},
                  {"force = 3\n", "must be a translational joint"},
                  {"torque_curve = \"c\"\nagainst = \"position\"\n" + kinked, "has an angle, no position"},
                  {"voltage = 24\nresistance = 0\ntorque_constant = 1\n", "resistance"},
                  {"voltage = \"none\"\nresistance = 1\ntorque_constant = 1\n", "there is no curve \"none\""},
                  {"target_speed = 3\n", "needs proportional or integral"},
                  {"breakdown_torque = 3\nbreakdown_slip = 0.2\nsynchronous_speed = 0\n", "must not be 0"},
                  {"velocity = \"c\"\n" + curve("c", "ramp", "to = 3\nrise = 0\n"), "greater than 0"},
                  {"velocity = \"c\"\n" + curve("c", "ramp", "to = 3\nrise = 1\ndwell = 2\n"),
                   "curves.c.dwell: does not apply to a ramp"}});
  const auto on_rotor = [](const std::string& elements) { return refusal(rotor + elements + length); };
  const std::string constant = curve("c", "constant", "value = 1\n");
  check_messages(
      on_rotor,
      {{body("block", 1, 1) + guide("guide", "ground", "block") + kinked +
            drive("d", "guide", "velocity = \"c\"\ncrank = true\n"),
        "drives.d.crank: needs a revolute joint"},
       {body("wheel", 1, 1, "position = [0.3, 0]\n") + gear("mesh", "rotor", "wheel", {0.1, 0.2}) + kinked +
            drive("d", "mesh", "velocity = \"c\"\n"),
        "drives.d.joint: must be a revolute or translational joint, \"mesh\" is a gear joint"},
       {constant + force("l", "rotor", {1, 0}, "against = \"angle\"\n"), "goes with factor"},
       {constant + force("l", "rotor", {1, 0}, "factor = \"c\"\nagainst = \"position\"\naxes = \"body\"\n"),
        "no direction in the world"}});
}

TEST_CASE("a drive with a velocity starts from its body's position, and a frequency is stored as a period",
          "[driving]") {
  const auto scene = parse_scene(test::body("block", 1, 1, "position = [0.4, 0.3]\n") +
                                     test::guide("guide", "ground", "block", {0.8, 0.6}) +
                                     test::curve("wave", "harmonic", "amplitude = 2\nfrequency = 50\n") +
                                     test::drive("c", "guide", "velocity = \"wave\"\n") + length,
                                 "s");
  CHECK(std::get<MotionDrive>(scene.mechanism.drives[0]).initial == Approx(0.5));
  CHECK(scene.mechanism.curves[0].period == 0.02);
}

TEST_CASE("the exact Jacobian is correct with curves, motors and governors", "[driving][jacobian]") {
  const auto scene = parse_scene(
      test::body("a", 1.5, 0.2) + test::body("b", 0.7, 0.1) + test::body("c", 0.4, 0.3) +
          test::pin("pin", "ground", "a", {0.1, 0.2}, {0.3, -0.1}) +
          test::guide("slide", "a", "b", {0.6, 0.8}, {0.02, 0.03}, {-0.04, 0.05}) +
          test::pin("free", "a", "c", {0.1, 0.0}, {0.2, 0.1}) + test::harmonic("wave", 0.7, 2.1) +
          test::table("bent", "[[-9, 1], [-2, 0.3], [0.1, -0.4], [3, 0.5], [9, 2]]",
                      "between = \"spline\"\n") +
          test::drive("place", "slide", "position = \"wave\"\nof = \"pin\"\n") +
          test::drive("turn", "pin", "velocity = \"bent\"\n") +
          test::drive("motor", "free",
                      "voltage = \"wave\"\nresistance = 0.7\ntorque_constant = 0.3\n"
                      "inductance = 0.4\n") +
          test::drive("governor", "free", "target_speed = \"bent\"\nproportional = 0.4\nintegral = 0.6\n") +
          test::drive("mains", "free",
                      "breakdown_torque = 0.8\nbreakdown_slip = 0.6\nsynchronous_speed = 2\n") +
          test::drive("push", "slide", "force = \"bent\"\nagainst = \"position\"\n") +
          test::drive("rub", "slide", "force = \"bent\"\nagainst = \"speed\"\n") +
          test::drive("twist", "free", "torque_curve = \"wave\"\nagainst = \"angle\"\n") +
          test::force("jet", "c", {0.4, 0.3},
                      "at = [0.1, 0.2]\naxes = \"body\"\nfactor = \"wave\"\nagainst = \"angle\"\n") +
          test::force("wind", "b", {0.4, 0.3}, "factor = \"bent\"\nagainst = \"speed\"\n") +
          "[loads.drag]\ntype = \"torque\"\nbody = \"c\"\ntorque = 0.3\n"
          "factor = \"bent\"\nagainst = \"speed\"\n" +
          length,
      "jacobian");
  CHECK(test::jacobian_error(scene, 7) < 1e-6);
}

TEST_CASE("a joint driven beyond its reach is reported with its drive", "[driving]") {
  const auto scene = parse_scene(rotor + test::curve("c", "constant", "value = 0.7\n") +
                                     test::drive("d", "main", "position = \"c\"\n") +
                                     test::motor("e", "main", 0, "initial_angle = 0.2\n") + length,
                                 "s");
  CHECK_THROWS_WITH(Simulation(scene, "penalty"), Contains("cannot be closed"));
}

TEST_CASE("rows between the ends of long steps are as accurate as the ends", "[driving][output]") {
  // A prescribed motion: a 3-4-5 rise of 0.5 rad in 0.4 s, polynomials that a method of high order
  // integrates in a few steps.
  const auto scene = parse_scene(
      rotor + test::drive("d", "main", "position = \"c\"\n") +
          test::curve("c", "rise-dwell-return",
                      "to = 0.5\nstart = 0.1\nrise = 0.4\ndwell = 0.1\nreturn = 0.2\n") +
          test::run_for(1) + "[penalty]\nintegrator = \"" +
          GENERATE(as<std::string>{}, "adams_bashforth_moulton", "bulirsch_stoer", "dopri5", "rosenbrock4") +
          "\"\n",
      "s.toml");
  double worst_angle = 0, worst_rate = 0;
  std::vector<double> q(3), v(3);
  test::Listener rows;
  rows.on_step = [&](const Step& step) {
    for (int k = 1; k < 8; ++k) {
      const double t = step.t0 + k / 8.0 * (step.t1 - step.t0);
      step.state(t, q, v);
      const double T = t < 0.6 ? 0.4 : -0.2, s = t < 0.6 ? (t - 0.1) / 0.4 : (0.8 - t) / 0.2;
      const double u = std::clamp(s, 0.0, 1.0);
      worst_angle = std::max(worst_angle, std::abs(q[2] - 0.5 * u * u * u * (10 + u * (6 * u - 15))));
      worst_rate = std::max(worst_rate, std::abs(v[2] - 0.5 * 30 * u * u * (1 - u) * (1 - u) / T));
    }
  };
  Simulation simulation(scene, "penalty");
  test::finished(simulation, {&rows});
  // The tolerance, 1e-9, on 0.5 rad and 4.7 rad/s; some tens of steps. Cubic interpolation between
  // them had errors of 2e-4 and 3e-3.
  CHECK(worst_angle < 1e-7);
  CHECK(worst_rate < 1e-6);
}

TEST_CASE("a force and a torque may depend on the angle of another joint", "[driving]") {
  // A crank turns at 10 rad/s from 0.3 rad; the curve is 4 sin φ, so that a velocity is (4/10
  // Ω)(cos 0.3 − cos φ) over its inertia.
  const std::string start = "format = 2\n" + test::body("crank", 1, 0.1, "angle = 0.3\n") +
                            test::body("block", 2, 0.5) + test::body("rotor", 2, 0.5) +
                            test::pin("shaft", "ground", "crank") + test::guide("guide", "ground", "block") +
                            test::pin("main", "ground", "rotor") + test::motor("motor", "shaft", 10) +
                            test::curve("gas", "harmonic", "amplitude = 4\nperiod = \"1 turn\"\n") +
                            test::harmonic("pure", 4, 2 * M_PI) + test::run_for(0.7);
  const std::string reads = "against = \"angle\"\nof = \"shaft\"\n";
  struct Kind {
    std::string text;
    std::size_t rate;
    double inertia;
  };
  const auto kind = GENERATE_COPY(values<Kind>(
      {{test::drive("d", "guide", "force = \"gas\"\n"), 3, 2},
       {test::drive("d", "main", "torque_curve = \"gas\"\n"), 8, 0.5},
       {test::force("l", "block", {1, 0}, "factor = \"pure\"\n"), 3, 2},
       {"[loads.l]\ntype = \"torque\"\nbody = \"rotor\"\ntorque = 1\nfactor = \"pure\"\n", 8, 0.5}}));
  const auto* formulation = GENERATE("penalty", "nonsmooth");
  const auto scene = parse_scene(start + kind.text + reads, "s.toml");
  CHECK(same_facts(parse_scene(to_toml(scene), "again"), scene));
  Simulation simulation(scene, formulation);
  REQUIRE(simulation.run().ending.status == Ending::Status::finished);
  CHECK(simulation.state().v[kind.rate] ==
        Approx(4 / (10 * kind.inertia) * (std::cos(0.3) - std::cos(7.3))).epsilon(1e-7));
  CHECK_THAT(refusal(start + kind.text + "of = \"shaft\"\n"),
             Contains("goes with a curve against = \"angle\""));
}
