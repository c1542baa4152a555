// Springs with kinks, bushings and cams in complete runs: snapshots, the energy ledger, implicit
// and fixed steps, small and fast scenes.
#include "io/scene/read_scene.hpp"
#include "verification/property/comparison/snapshot_check.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using namespace freeplay::snapshots;

namespace {

/// A mass between a cable and a buffer under its weight, with a load on a bushing beside it.
const std::string hung =
    "gravity = [0.0, -9.81]\n" +
    test::body("mass", 1.0, 0.1, "position = [0.3, -0.2]\nvelocity = [0.5, 2.0]\nangular_velocity = 4.0\n") +
    test::body("rider", 0.4, 0.01, "position = [0.5, -0.2]\nvelocity = [0.5, 2.0]\n") +
    test::spring("cable", "ground", "mass", {}, {0.05, 0.0}, 1e5, 0.5,
                 "damping = 20.0\none_way = \"pull\"\n") +
    R"([loads.buffer]
type = "spring-damper"
between = ["ground", "mass"]
at = [[0.0, -0.8], [0.0, 0.0]]
force_table = [[0.1, -900], [0.3, -200], [0.4, 0]]
damping_table = [[-1, -5], [0, 0], [1, 1]]
one_way = "push"
[loads.twist]
type = "torsional-spring-damper"
between = ["ground", "mass"]
torque_table = [[-0.5, -20], [-0.2, 0], [0.2, 0], [0.5, 20]]
[loads.bushing]
type = "bushing"
between = ["mass", "rider"]
at = [[0.1, 0.0], [-0.1, 0.0]]
radial_table = [[0, 0], [1e-3, 5], [3e-3, 40]]
damping = [2.0, 2.0]
torsional_stiffness = 20.0
)" + test::run_for(0.8, "discard = 0.1\nstart = \"given\"\noutput_step = 1e-2\n");
const std::string cam =
    "gravity = [0.0, -9.81]\n" + test::body("cam", 1.0, 1e-3, "angular_velocity = 60.0\n") +
    test::body("lever", 0.3, 2e-3, "position = [0.05, 0.0345]\n") +
    test::surface("steel", 0.4, "young = 2e11\npoisson = 0.3\nfriction = 0.1\n") +
    test::pin("pin", "ground", "cam") + test::pin("rocker", "ground", "lever", {0.1, 0.0345}, {0.05, 0.0}) +
    R"([contacts.lobe]
type = "cam"
between = ["cam", "lever"]
at = [[0.0, 0.0], [-0.05, 0.0]]
axis = [-1.0, 0.0]
base_radius = 0.03
law = "polynomial"
lift = 0.006
start = 2.0
rise = 1.8
dwell = 0.3
return = 1.9
surface = "steel"
)" + test::torsion("spring", "ground", "lever", 2.0, "free_angle = 0.3\n") +
    test::run_for(0.15, "discard = 0.02\nstart = \"given\"\noutput_step = 1e-3\n");

Result run(const std::string& scene, const std::vector<std::string>& set, Family family) {
  const auto result = test::finished(parse_scene(scene, "scene", set), family);
  return result;
}

}  // namespace

TEST_CASE("snapshots: runs with kinks of springs and cams continue bit for bit", "[snapshot][compliant]") {
  for (const char* integrator : {"dopri5", "rosenbrock4", "adams_bashforth_moulton"})
    check({hung,
           "penalty",
           {fmt::format("penalty.integrator=\"{}\"", integrator), "penalty.tolerance=1e-7"},
           {}});
  for (const char* scheme : {"event-driven", "automatic", "moreau-jean"})
    check({hung, "nonsmooth", {fmt::format("nonsmooth.scheme=\"{}\"", scheme)}, {}});
  check({cam, "penalty", {"penalty.tolerance=1e-7"}, {flight, contact}});
  check({cam, "nonsmooth", {"nonsmooth.scheme=\"event-driven\""}, {flight}});
  check({cam, "nonsmooth", {"nonsmooth.step=2e-5"}, {flight}});
}

TEST_CASE("the energy ledger closes over kinks, dampers and cams in every scheme", "[compliant]") {
  // Relative to kinetic and stored energy: tolerance times some thousand steps; for fixed steps,
  // first order in the changes at kinks.
  const struct {
    Family family;
    std::vector<std::string> set;
    double bound;
  } ways[] = {{Family::penalty, {}, 1e-6},
              {Family::penalty, {"penalty.integrator=\"rosenbrock4\""}, 1e-5},
              {Family::penalty, {"penalty.integrator=\"bulirsch_stoer\""}, 1e-6},
              {Family::penalty, {"penalty.integrator=\"rk4\"", "penalty.step=1e-6"}, 1e-5},
              {Family::nonsmooth, {"nonsmooth.scheme=\"event-driven\""}, 1e-7},
              {Family::nonsmooth, {"nonsmooth.scheme=\"moreau-jean\""}, 1e-3},
              {Family::nonsmooth, {"nonsmooth.step=1e-5"}, 1e-2}};
  for (const auto& scene : {hung, cam})
    for (const auto& way : ways) {
      CAPTURE(scene.substr(0, 80), way.set);
      const auto result = run(scene, way.set, way.family);
      const auto& l = result.ledger;
      CHECK(std::abs(l.closure()) <= way.bound * l.scale());
      CHECK(l.damping >= -1e-12);  // energy dissipated by dampers
    }
}

TEST_CASE("a lever on an eccentric cam has the angle of the tangent to its circle", "[compliant]") {
  // The face passes through the lever's pivot P; the disc's centre is at e from the cam's axis, its
  // radius is ρ = base + e. The face is a tangent: its angle to the line from P to the centre is
  // asin(ρ/D).
  auto text = cam;
  const auto replace = [&](const std::string& from, const std::string& to) {
    text = test::replaced(text, from, to);
  };
  replace("law = \"polynomial\"\nlift = 0.006\nstart = 2.0\nrise = 1.8\ndwell = 0.3\nreturn = 1.9",
          "law = \"harmonic\"\nlift = 0.006\nstart = 1.5707963267948966\nrise = 3.141592653589793\n"
          "return = 3.141592653589793");
  replace("angular_velocity = 60.0", "angular_velocity = 20.0");
  replace("position = [0.05, 0.0345]", "position = [0.05, 0.0300001]");
  replace("at = [[0.1, 0.0345], [0.05, 0]]", "at = [[0.1, 0.0300001], [0.05, 0]]");
  replace("restitution = 0.4", "restitution = 0.0");
  text += "[drives.motor]\njoint = \"pin\"\nspeed = 20.0\n";
  for (const auto& set :
       {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.scheme=\"automatic\"", "nonsmooth.step=1e-5"}) {
    CAPTURE(set);
    const auto end = run(text, {set}, Family::nonsmooth).final_state;
    const double e = 0.003, rho = 0.033, turn = end.q[2] + M_PI / 2;
    const Vec2 pivot{0.1, 0.0300001}, centre{-e * std::cos(turn), -e * std::sin(turn)};
    const Vec2 away = centre - pivot;
    // No lift at the start: the centre is e below the axis, and rises with the cam.
    const double expected = std::asin(rho / away.norm()) - std::atan2(-away.y(), -away.x());
    CHECK(-end.q[5] == Approx(expected).margin(2e-7));
  }
}

TEST_CASE("a follower at rest on a dwell stays at rest, on cams of any size", "[compliant]") {
  for (const double size : {1e-4, 1.0, 1e3}) {
    const auto scene = fmt::format("gravity = [0.0, -{}]\n", size) + test::body("cam", 1.0, 1.0) +
                       test::body("follower", 1.0, 1.0, fmt::format("position = [0.0, {}]\n", 1.3 * size)) +
                       test::surface("steel", 0.4, "young = 2e11\npoisson = 0.3\n") +
                       test::pin("pin", "ground", "cam") +
                       test::guide("guide", "ground", "follower", {0.0, 1.0}, {0.0, 1.3 * size}, {}) +
                       fmt::format(R"([contacts.lobe]
type = "cam"
between = ["cam", "follower"]
follower = "roller"
roller_radius = {}
base_radius = {}
lift = {}
start = 3.0
rise = 1.2
return = 1.2
surface = "steel"
)",
                                   0.3 * size, size, 0.1 * size) +
                       test::run_for(5.0, "start = \"given\"\n");
    for (const auto& set :
         {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.scheme=\"automatic\"", "nonsmooth.step=1e-3"}) {
      CAPTURE(size, set);
      const auto end = run(scene, {set}, Family::nonsmooth).final_state;
      CHECK(end.q[4] == Approx(1.3 * size).epsilon(1e-9));
      CHECK(end.v[4] == Approx(0).margin(1e-9 * size));
      CHECK(end.q[2] == Approx(0).margin(1e-9));
    }
  }
}
