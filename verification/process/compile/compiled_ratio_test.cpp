// Compiled functions of ratios between two joints: runs with them are bitwise identical to those
// without.
#include "verification/support/compiled_runs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("compiled runs with ratios have the digits of the general functions", "[compiled][ratio]") {
  using namespace test;
  const CompilerCache cache;
  const auto ratio = [](const char* name, const char* type, const char* joint, const char* of,
                        const std::string& keys) {
    return fmt::format("[{}]\ntype = \"{}\"\njoint = \"{}\"\nof = \"{}\"\n{}", name, type, joint, of, keys);
  };
  // A shaft leads a wheel by a loose belt, a slider ideally, a second wheel elastically, and a wheel on an arm.
  const auto text =
      "gravity = [0, -9.81]\n" + body("shaft", 1, 0.1) + body("wheel", 1, 0.05, "position = [0.5, 0]\n") +
      body("slider", 2, 0.01, "position = [0, 1]\n") + body("soft", 1, 0.05, "position = [1, 0]\n") +
      body("arm", 1, 0.2, "position = [2.2, 0]\n") + body("planet", 1, 0.02, "position = [2.4, 0]\n") +
      pin("lead", "ground", "shaft") + pin("follow", "wheel", "ground", {}, {0.5, 0}) +
      guide("rail", "ground", "slider", {0.6, 0.8}, {0, 1}) + pin("last", "ground", "soft", {1, 0}) +
      pin("pivot", "ground", "arm", {2, 0}, {-0.2, 0}) + pin("axle", "arm", "planet", {0.2, 0}) +
      surface("hard", 0.6) +
      ratio("joints.belt", "ratio", "follow", "lead",
            "ratio = 2\nbacklash = 0.02\nradius = 0.05\nmesh_stiffness = 1e7\nsurface = \"hard\"\n") +
      ratio("joints.mimic", "ratio", "rail", "lead", "ratio = 0.05\n") +
      ratio("joints.four", "ratio", "axle", "lead", "ratio = -1.5\n") +
      ratio("loads.soft", "elastic-ratio", "last", "lead", "ratio = 1.5\nstiffness = 20\ndamping = 0.05\n") +
      "[curves.swing]\nshape = \"harmonic\"\namplitude = 2\nperiod = 0.1\n" +
      drive("engine", "lead", "torque_curve = \"swing\"\n") + run_for(0.3);
  for (const auto& way : {penalty, event_driven, fixed_steps(1e-4)}) {
    CAPTURE(way.name);
    const auto found = check_all_compiled(way, text);
    CHECK(std::abs(found.ledger.closure()) < 1e-3 * found.ledger.scale());
  }
}
