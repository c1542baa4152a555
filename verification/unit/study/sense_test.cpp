// Unit plausibility check: implausible units raise a question, and nothing else does.
#include "mechanism/plausibility.hpp"
#include "study/calibration/agreement.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

std::vector<std::string> questions(const std::vector<std::string>& overrides) {
  return plausibility_checks(read_scene(test::scene_file("four_bar"), overrides).mechanism);
}

}  // namespace

TEST_CASE("unit plausibility: shipped scenes raise no question", "[sense]") {
  const auto list = test::all_scenes();
  CHECK(list.size() >= 30);
  for (const auto& file : list) {
    CAPTURE(file.string());
    // A similarity: arms of 1000 m and angles of 1e-5 rad give the published linear model.
    if (file.parent_path().filename() == "woodpecker-small-angles") continue;
    // Stiff enough that a contact lasts no step: scenes of tests alone.
    if (file.parent_path().filename() == "tests") continue;
    for (const auto& q : plausibility_checks(read_scene(file).mechanism)) FAIL_CHECK(q);
  }
  // The row of four-bars of growing size.
  CHECK(plausibility_checks(test::row_of_four_bars(8, 0).mechanism).empty());
  CHECK(plausibility_checks(test::row_of_four_bars(8, 1e-3).mechanism).empty());
}

TEST_CASE("unit plausibility: each implausible unit raises one question with the likely meaning", "[sense]") {
  struct Case {
    std::vector<std::string> set;
    const char* expected;
  };
  // Meanings by hand: 60° = π/3; J of 5.6e-3 kg m² in kg mm², g cm²; 0.2 mm.
  const std::vector<Case> cases{
      {{"bodies.crank.angle=60"}, "60 degrees would be 1.0472"},
      {{"bodies.crank.angle=-45", "bodies.rocker.angle=110"},
       "-45 degrees would be -0.785398 (and 1 similar)"},
      {{"bodies.crank.angle=36.87"}, "36.87 degrees would be 0.643503"},
      {{"drives.motor.initial_angle=90"}, "90 degrees would be 1.5708"},
      {{"surfaces.steel.young=207"}, "207 GPa would be 2.07e+11"},
      {{"surfaces.steel.young=207000"}, "207000 MPa would be 2.07e+11"},
      {{"surfaces.steel.young=207e15"}, "stiffer than diamond"},
      {{"bodies.coupler.inertia=5609.5"}, "5609.5 kg mm² would be 0.0056"},
      {{"bodies.coupler.inertia=56095"}, "56095 g cm² would be 0.0056"},
      {{"joints.rocker_pin.clearance=0.2", "joints.rocker_pin.bearing_radius=0.25"},
       "0.2 mm would be 0.0002"},
      {{"joints.rocker_pin.clearance=0.2", "joints.rocker_pin.bearing_radius=10"}, "10 mm would be 0.01"},
      {{"joints.rocker_pin.bearing_wear=1e-6", "joints.rocker_pin.bearing_length=0.02"},
       "1e-06 mm³/(N m) would be 1e-15"},
      {{"gravity=[0,-9810]"}, "9810 mm/s² would be 9.81"},
      {{"gravity=[0,-981]"}, "981 cm/s² would be 9.81"},
      {{"drives.motor.speed_rpm=250000"}, "rpm would be"},
      {{"joints.crank_pin.at=[[50,0],[-175,0]]"}, "mm would be 0.05"},
  };
  for (const auto& c : cases) {
    CAPTURE(c.expected);
    const auto list = questions(c.set);
    REQUIRE(list.size() == 1);
    CHECK_THAT(list[0], Contains(c.expected));
  }
}

TEST_CASE("unit plausibility: unusual but possible values raise no question", "[sense]") {
  // A start taken from a run after some revolutions; 3π, rounded; a rubber; a bob without inertia;
  // a flywheel on a short crank; a worn bearing; Jupiter; a fast spindle.
  for (const auto* set :
       {"bodies.crank.angle=62.17418350728591", "bodies.crank.angle=9.42", "bodies.crank.angle=6.28",
        "surfaces.steel.young=1e6", "surfaces.steel.young=1.2e12", "bodies.coupler.inertia=1e-9",
        "bodies.crank.inertia=0.3", "joints.rocker_pin.clearance=1.9e-3", "gravity=[0,-24.8]",
        "drives.motor.speed_rpm=60000"}) {
    CAPTURE(set);
    for (const auto& q : questions({set})) FAIL_CHECK(q);
  }
}

TEST_CASE("unit plausibility: a measurement in g is recognised by its lowest harmonics", "[sense]") {
  TurnMetrics ideal, measured;
  ideal.spectrum = {40, 12, 0.5, 0.2};
  const auto scaled = [&](double factor, double apart) {
    measured.spectrum = ideal.spectrum;
    for (auto& x : measured.spectrum) x *= factor;
    measured.spectrum[1] *= 1 + apart;       // clearance changes harmonics a little,
    measured.spectrum.back() = 30 * factor;  // impacts change the high ones
    return unit_plausibility(measured, ideal);
  };
  CHECK(scaled(1, 0.1).empty());
  CHECK(scaled(0.7, 0).empty());  // another stroke or mass is no other unit
  CHECK(scaled(3, 0).empty());
  CHECK_THAT(scaled(1 / 9.80665, 0.1), Contains("is the file in g instead of m/s²?"));
  CHECK_THAT(scaled(1 / 9.80665, -0.3), Contains("is the file in g instead of m/s²?"));
  CHECK_THAT(scaled(100, 0.1), Contains("cm/s²"));
  CHECK_THAT(scaled(1000, 0.1), Contains("mm/s²"));
  CHECK(unit_plausibility({}, ideal).empty());
}
