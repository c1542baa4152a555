// Compiled functions of beams: runs with them are bitwise identical to those without.
#include "verification/support/compiled_runs.hpp"
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("compiled runs with beams have the digits of the general functions", "[compiled][beams]") {
  using namespace test;
  const CompilerCache cache;
  // A hub on a pin with a curved arm of two sections that yields in shear and has a body at its end, a damped tail with
  // a free end, and a reduced link beside the arm. The body falls on a floor. The given positions strain the beams.
  const auto beam = [](const char* name, const char* from, const char* to, const std::string& keys) {
    return fmt::format(
        "[beams.{}]\nbetween = [\"{}\", \"{}\"]\nelements = 3\nyoung = 1e8\ndensity = 1000\n{}", name, from,
        to, keys);
  };
  const auto text =
      "gravity = [0.0, -9.81]\n" + body("hub", 1, 0.01) +
      body("nose", 0.1, 1e-4, "position = [0.45, -0.03]\nangle = 0.2\n") + pin("axis", "ground", "hub") +
      beam("arm", "hub", "nose",
           "length = 0.45\nsection = \"tube\"\nsections = [[0, 0.03, 0.004], [0.6, 0.02, 0.003]]\n"
           "shear_modulus = 4e7\ncurvature = -0.4\ndamping = 1e-5\n") +
      beam("tail", "hub", "free",
           "length = 0.3\nsection = \"circle\"\ndiameter = 0.02\nangles = [3, 0]\ndamping_ratio = 0.01\n"
           "damping_frequency = 50\n") +
      beam("link", "nose", "hub",
           "at = [[0.01, 0], [0, 0.05]]\nangles = [3.2, 3.2]\nlength = 0.46\narea = 1e-4\n"
           "second_moment = 1e-9\nmodes = 2\n") +
      plane("floor", "ground", "nose", 0.02, "s", "at = [[0.0, -0.06], [0, 0]]\n") +
      surface("s", 0.5, 0.2, "young = 1e9\npoisson = 0.3\n") +
      "[instruments.gauge]\ntype = \"strain-gauge\"\nbeam = \"arm\"\nplace = 0.2\noffset = 0.01\n"
      "bandwidth = 1000.0\nsampling = 10000.0\n" +
      run_for(0.07);
  for (const auto& way : {penalty, event_driven, fixed_steps(1e-4)}) {
    CAPTURE(way.name);
    check_all_compiled(way, text);
  }
}

TEST_CASE("compiled runs of a slider-crank with a flexible rod", "[compiled][beams]") {
  // The journal starts in the centre of its bearing, where it has no row: states there are evaluated by the general
  // functions. The first impacts occur after 4.5 ms.
  const test::CompilerCache cache;
  for (const auto& way :
       {test::penalty, test::penalty_by("rosenbrock4"), test::event_driven, test::fixed_steps(2e-5)})
    CHECK(test::check_compiled("flores2011-flexible/scene", 0.006, way, INFINITY).events_seen > 0);
}
