// Snapshots of complete simulations. At random accepted steps of a run, in every integrator and
// scheme and in every state of the motion (in flight, within an impact, sliding, sticking, on a
// film, before and after a knot of a table), an observer takes a snapshot, which is restored in a
// new simulation and continued. All observable results of the rest must equal those of the
// uninterrupted run bit for bit.
#include "verification/property/comparison/snapshot_check.hpp"

using namespace freeplay;
using namespace freeplay::snapshots;

namespace {

const std::string events = "nonsmooth.scheme=event-driven ",
                  stepping = "nonsmooth.scheme=moreau-jean nonsmooth.step=",
                  adaptive = "nonsmooth.scheme=moreau-jean nonsmooth.step=automatic ",
                  automatic = "nonsmooth.scheme=automatic nonsmooth.step=automatic ";

std::string by(const std::string& integrator) { return "penalty.integrator=" + integrator + " "; }

std::string rig() { return text("tests/instrumented_crank"); }

/// A scene whose pins of steel have an oil film.
std::string oiled(std::string scene) {
  const std::string surface = "surface = \"steel\"\n";
  scene.insert(scene.find(surface), "bearing_length = 0.02\nlubricant = \"oil\"\n");
  return scene + "[lubricants.oil]\nviscosity = 0.004\nhand_over = 1e-5\n";
}

/// Springs, a damper, preloaded friction and a table over time.
void check_springs(const std::string& formulation, const std::string& set, Place contact_state) {
  check({text("tests/springs_and_brake"),
         formulation,
         set,
         {before_knot, behind_knot, contact_state, flight},
         false,
         true,
         {0.02, 0.05, 0.07}});
}

}  // namespace

TEST_CASE("snapshots: every penalty integrator continues bit for bit", "[snapshot]") {
  for (const auto& method :
       {by("rk4") + "penalty.step=5e-6", by("dopri5"), by("bulirsch_stoer") + "surfaces.steel.friction=0.1",
        by("bulirsch_stoer") + "penalty.stabilisation=projection", by("adams_bashforth_moulton"),
        by("rosenbrock4") + "penalty.stabilisation=none"})
    check(rig(), "penalty",
          method + " run.duration=0.02 run.discard=0.003 run.output_step=1e-4 penalty.tolerance=1e-7",
          {flight, contact, slide});
}

TEST_CASE("snapshots: friction zones and bristles", "[snapshot]") {
  for (const std::string law :
       {"ambrosio penalty.friction_v1=0.3", "threlfall run.discard=0",
        "bengisu-akay penalty.friction_static=1.2", "brown-mcphee penalty.friction_static=1.2",
        "lugre penalty.friction_static=1.2"})
    for (const char* integrator : {"dopri5", "adams_bashforth_moulton"})
      check(text("ring"), "penalty",
            by(integrator) + "penalty.tolerance=1e-6 penalty.friction_v0=0.02 run.duration=0.03 " +
                "penalty.friction=" + law,
            {flight, contact, stick});
  // A block that slides up a slope and stays there, held by its bristles.
  for (const char* integrator : {"rosenbrock4", "dopri5", "bulirsch_stoer", "adams_bashforth_moulton"})
    check(text("block_on_slope"), "penalty",
          by(integrator) + "penalty.contact=kelvin-voigt penalty.kelvin_stiffness=1e5 " +
              "penalty.kelvin_damping=200 penalty.friction=lugre penalty.bristle_stiffness=3e3 " +
              "penalty.friction_v0=0.01 penalty.tolerance=1e-7 bodies.block.velocity=[0.3,0] " +
              "run.duration=0.08 run.output_step=1e-3",
          {contact, slide, stick});
}

TEST_CASE("snapshots: a film, and its hand-over to dry contact", "[snapshot][films]") {
  for (const char* integrator : {"dopri5", "adams_bashforth_moulton", "rosenbrock4"})
    check(oiled(rig()), "penalty",
          by(integrator) + "penalty.tolerance=1e-6 run.duration=0.02 run.output_step=1e-4", {film});
  for (const char* scheme : {"moreau-jean", "event-driven", "automatic"})
    check(oiled(rig()), "nonsmooth",
          fmt::format("nonsmooth.scheme={} run.duration=0.02 run.discard=0.01 run.output_step=1e-4", scheme),
          {film});
  // Stiff: the implicit method is active.
  check(oiled(rig()), "nonsmooth",
        events + "lubricants.oil.viscosity=40 run.duration=0.01 run.discard=0.001 run.output_step=1e-4",
        {film});
}

TEST_CASE("snapshots: springs, dampers, preloaded friction and tables", "[snapshot]") {
  for (const char* integrator : {"dopri5", "bulirsch_stoer", "adams_bashforth_moulton", "rosenbrock4"})
    check_springs("penalty", by(integrator), contact);
  for (const auto& scheme : {stepping + "2e-4", events, adaptive, automatic})
    check_springs("nonsmooth", scheme, impact);
}

TEST_CASE("snapshots: runs with kinks of springs and cams continue bit for bit", "[snapshot][compliant]") {
  for (const char* integrator : {"dopri5", "rosenbrock4", "adams_bashforth_moulton"})
    check(text("tests/cable_and_buffer"), "penalty", by(integrator) + "penalty.tolerance=1e-7");
  for (const char* scheme : {"event-driven", "automatic", "moreau-jean"})
    check(text("tests/cable_and_buffer"), "nonsmooth", fmt::format("nonsmooth.scheme={}", scheme));
  check(text("tests/cam_and_lever"), "penalty", "penalty.tolerance=1e-7", {flight, contact});
  for (const auto& scheme : {events, stepping + "2e-5"})
    check(text("tests/cam_and_lever"), "nonsmooth", scheme, {flight});
}

TEST_CASE("snapshots: sparse factors with their pivots, and redundant rows", "[snapshot]") {
  for (const bool forces : {true, false}) {
    for (const char* integrator : {"dopri5", "adams_bashforth_moulton"})
      check({chain(),
             "penalty",
             by(integrator) + "penalty.tolerance=1e-5 run.duration=0.06 run.output_step=1e-3",
             {flight},
             false,
             forces});
    check({chain(), "nonsmooth", stepping + "5e-4 run.output_step=1e-3", {flight, impact}, false, forces});
    check({chain(),
           "nonsmooth",
           events + "nonsmooth.tolerance=1e-6 run.duration=0.2 run.output_step=1e-3",
           {flight},
           false,
           forces});
  }
  check(text("redundant_rail"), "penalty", "penalty.tolerance=1e-5 run.duration=0.03 run.output_step=1e-3",
        {flight});
  for (const auto& scheme : {stepping + "5e-4", events + "nonsmooth.tolerance=1e-6"})
    check(text("redundant_rail"), "nonsmooth", scheme + " run.duration=0.1 run.output_step=1e-3", {flight});
}

TEST_CASE("snapshots: both nonsmooth schemes, in flight, in contact and at impacts", "[snapshot]") {
  const std::string brief = " run.duration=0.03 run.discard=0.01 run.output_step=1e-4";
  for (const bool matched : {false, true}) {
    check({rig(), "nonsmooth", stepping + "2e-5" + brief, {flight, contact, impact, slide}, matched});
    for (const auto& scheme : {events, adaptive, automatic})
      check({rig(), "nonsmooth", scheme + brief, {flight, contact, impact}, matched});
  }
  for (const char* law : {"poisson", "energetic"})
    check(rig(), "nonsmooth", events + "run.duration=0.02 run.output_step=1e-4 nonsmooth.impact_law=" + law,
          {flight, impact});
  for (const auto& scheme :
       {std::string(), adaptive + "run.output_step=1e-3", automatic + "run.output_step=1e-3"})
    check(text("block_on_slope"), "nonsmooth", scheme, {contact, slide});
  check(text("block_on_slope"), "nonsmooth", stepping + "5e-4", {contact, slide, stick});
  for (const auto& scheme : {std::string(), adaptive, automatic})
    check(text("dragged_block"), "nonsmooth", scheme + "run.duration=0.6", {contact, slide, stick});
  check(text("dragged_block"), "nonsmooth", stepping + "1e-3", {contact, slide, stick});
  for (const auto& scheme : {events, adaptive, automatic})
    check(text("bouncing_ball"), "nonsmooth", scheme + "run.output_step=1e-3", {flight, impact});
  check(text("four_bar_two"), "nonsmooth", events + "run.duration=0.1 run.output_step=1e-3",
        {flight, impact});
}

TEST_CASE("snapshots: adaptive time stepping, and the default scheme before, within and after its hand-overs",
          "[snapshot]") {
  const std::string steps_of_chain = "nonsmooth.step_tolerance=1e-4 run.duration=0.1 run.output_step=1e-3 ";
  check(chain(), "nonsmooth", adaptive + steps_of_chain + "run.discard=0", {flight});
  check(chain(), "nonsmooth", automatic + steps_of_chain + "nonsmooth.tolerance=1e-6", {flight});
  for (const auto& scheme : {adaptive, automatic})
    check({test::random_pile(8), "nonsmooth", scheme + "run.duration=0.1", {contact, impact}, false, false});
  // Three hand-overs; most of its steps are those of time stepping.
  check(test::random_pile(1), "nonsmooth", "run.duration=0.443", {contact, impact});
}

TEST_CASE("snapshots: the four corners of a guide with clearance, and every contact solver", "[snapshot]") {
  check(text("free_slider"), "nonsmooth", "run.output_step=1e-3", {flight, impact});
  check(text("free_slider"), "penalty",
        "penalty.contact=kelvin-voigt penalty.kelvin_stiffness=1e6 penalty.kelvin_damping=50 "
        "surfaces.steel.tangential_restitution=0 run.output_step=1e-3 penalty.tolerance=1e-6",
        {flight, contact, slide});
  for (const char* solver : {"automatic", "enumeration", "lemke", "gauss-seidel", "newton"})
    for (const std::string scene : {"free_slider", "dragged_block", "four_bar_two"}) {
      CAPTURE(scene);
      check(
          {text(scene),
           "nonsmooth",
           fmt::format("{}5e-4 nonsmooth.solver={} run.output_step=1e-3 run.duration=0.2", stepping, solver),
           {scene == "free_slider" ? impact : contact}});
    }
}

TEST_CASE("snapshots: the integral and the lag of a controller, across gears with backlash",
          "[controller][snapshot]") {
  const auto axis = text("tests/controlled_axis");
  for (const auto& method : {std::string(), by("rosenbrock4")})
    check(axis, "penalty", method, {flight, contact});
  // Without restitution, since events do not resolve an accumulation of impacts.
  check(axis, "nonsmooth", events + "surfaces.steel.restitution=0", {flight, contact});
  for (const auto& scheme : {automatic, stepping + "2e-4", adaptive})
    check(axis, "nonsmooth", scheme, {flight});
}
