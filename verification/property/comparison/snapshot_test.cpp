// Snapshots of complete simulations. At random accepted steps of a run, in every integrator and
// scheme and in every state of the motion (in flight, within an impact, sliding, sticking, on a
// film, before and after a knot of a table), an observer takes a snapshot, which is restored in a
// new simulation and continued. All observable results of the rest must equal those of the
// uninterrupted run bit for bit.
#include <catch2/catch.hpp>

#include "verification/property/comparison/snapshot_check.hpp"

using namespace freeplay;
using namespace freeplay::snapshots;

TEST_CASE("snapshots: every penalty integrator continues bit for bit", "[snapshot]") {
  const auto set = [](const std::string& integrator, std::vector<std::string> more) {
    more.insert(more.end(), {"penalty.integrator=\"" + integrator + "\"", "run.duration=0.02",
                             "run.discard=0.003", "run.output_step=1e-4", "penalty.tolerance=1e-7"});
    return more;
  };
  for (const auto& [integrator, more] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"rk4", {"penalty.step=5e-6"}},
           {"dopri5", {}},
           {"bulirsch_stoer", {"penalty.stabilisation=\"projection\""}},
           {"bulirsch_stoer", {"surfaces.steel.friction=0.1"}},
           {"bulirsch_stoer", {"penalty.stabilisation=\"projection\""}},
           {"adams_bashforth_moulton", {}},
           {"rosenbrock4", {"penalty.stabilisation=\"none\"", "penalty.tolerance=1e-6"}}})
    check({rig(), "penalty", set(integrator, more), {flight, contact, slide}});
}

TEST_CASE("snapshots: friction zones and bristles", "[snapshot]") {
  for (const auto& [law, own] : {std::pair{"ambrosio", "penalty.friction_v1=0.3"},
                                 {"threlfall", "run.discard=0"},
                                 {"bengisu-akay", "penalty.friction_static=1.2"},
                                 {"brown-mcphee", "penalty.friction_static=1.2"},
                                 {"lugre", "penalty.friction_static=1.2"}})
    for (const char* integrator : {"dopri5", "adams_bashforth_moulton"})
      check(
          {text("ring"),
           "penalty",
           {fmt::format("penalty.friction=\"{}\"", law), fmt::format("penalty.integrator=\"{}\"", integrator),
            "penalty.tolerance=1e-6", "penalty.friction_v0=0.02", own, "run.duration=0.03"},
           {flight, contact, stick}});
  // A block that slides up a slope and stays there, held by its bristles.
  for (const char* integrator : {"rosenbrock4", "dopri5", "bulirsch_stoer", "adams_bashforth_moulton"})
    check({text("block_on_slope"),
           "penalty",
           {fmt::format("penalty.integrator=\"{}\"", integrator), "penalty.contact=\"kelvin-voigt\"",
            "penalty.kelvin_stiffness=1e5", "penalty.kelvin_damping=200", "penalty.friction=\"lugre\"",
            "penalty.bristle_stiffness=3e3", "penalty.friction_v0=0.01", "penalty.tolerance=1e-7",
            "bodies.block.velocity=[0.3,0]", "run.duration=0.08", "run.output_step=1e-3"},
           {contact, slide, stick}});
}

TEST_CASE("snapshots: a film, and its hand-over to dry contact", "[snapshot]") {
  const auto oiled = [](std::string scene) {
    const std::string surface = "surface = \"steel\"\n";
    scene.insert(scene.find(surface), "bearing_length = 0.02\nlubricant = \"oil\"\n");
    return scene + "[lubricants.oil]\nviscosity = 0.004\nhand_over = 1e-5\n";
  };
  for (const char* integrator : {"dopri5", "adams_bashforth_moulton", "rosenbrock4"})
    check({oiled(rig()),
           "penalty",
           {fmt::format("penalty.integrator=\"{}\"", integrator), "penalty.tolerance=1e-6",
            "run.duration=0.02", "run.output_step=1e-4"},
           {film}});
}

TEST_CASE("snapshots: springs, dampers, preloaded friction and tables", "[snapshot]") {
  const std::vector knots{0.02, 0.05, 0.07};
  for (const char* integrator : {"dopri5", "bulirsch_stoer", "adams_bashforth_moulton", "rosenbrock4"})
    check({loads(),
           "penalty",
           {fmt::format("penalty.integrator=\"{}\"", integrator)},
           {before_knot, behind_knot, contact, flight},
           false,
           true,
           knots});
  check({loads(), "nonsmooth", {}, {before_knot, behind_knot, impact, flight}, false, true, knots});
  check({loads(),
         "nonsmooth",
         {"nonsmooth.scheme=\"event-driven\""},
         {before_knot, behind_knot, impact, flight},
         false,
         true,
         knots});
}

TEST_CASE("snapshots: sparse factors with their pivots, and redundant rows", "[snapshot]") {
  for (const bool forces : {true, false}) {
    for (const char* integrator : {"dopri5", "adams_bashforth_moulton"})
      check({chain(),
             "penalty",
             {fmt::format("penalty.integrator=\"{}\"", integrator), "penalty.tolerance=1e-5",
              "run.duration=0.06", "run.output_step=1e-3"},
             {flight},
             false,
             forces});
    check({chain(),
           "nonsmooth",
           {"nonsmooth.step=5e-4", "run.output_step=1e-3"},
           {flight, impact},
           false,
           forces});
    check({chain(),
           "nonsmooth",
           {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.tolerance=1e-6", "run.duration=0.2",
            "run.output_step=1e-3"},
           {flight},
           false,
           forces});
  }
  check({text("redundant_rail"),
         "penalty",
         {"penalty.tolerance=1e-5", "run.duration=0.03", "run.output_step=1e-3"},
         {flight}});
  check({text("redundant_rail"),
         "nonsmooth",
         {"nonsmooth.step=5e-4", "run.duration=0.1", "run.output_step=1e-3"},
         {flight}});
  check({text("redundant_rail"),
         "nonsmooth",
         {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.tolerance=1e-6", "run.duration=0.1",
          "run.output_step=1e-3"},
         {flight}});
}

TEST_CASE("snapshots: both nonsmooth schemes, in flight, in contact and at impacts", "[snapshot]") {
  const std::string events = "nonsmooth.scheme=\"event-driven\"", output = "run.output_step=1e-4";
  for (const bool matched : {false, true}) {
    check({rig(),
           "nonsmooth",
           {"run.duration=0.03", "run.discard=0.01", output, "nonsmooth.step=2e-5"},
           {flight, contact, impact, slide},
           matched});
    check({rig(),
           "nonsmooth",
           {"run.duration=0.03", "run.discard=0.01", output, events},
           {flight, contact, impact},
           matched});
  }
  for (const char* law : {"poisson", "energetic"})
    check({rig(),
           "nonsmooth",
           {"run.duration=0.02", output, events, fmt::format("nonsmooth.impact_law=\"{}\"", law)},
           {flight, impact}});
  const std::string stepping = "nonsmooth.scheme=\"moreau-jean\"";
  check({text("block_on_slope"), "nonsmooth", {}, {contact, slide}});
  check({text("block_on_slope"), "nonsmooth", {stepping, "nonsmooth.step=5e-4"}, {contact, slide, stick}});
  check({text("dragged_block"), "nonsmooth", {"run.duration=0.6"}, {contact, slide, stick}});
  check({text("dragged_block"), "nonsmooth", {stepping, "nonsmooth.step=1e-3"}, {contact, slide, stick}});
  check({text("bouncing_ball"), "nonsmooth", {events, "run.output_step=1e-3"}, {flight, impact}});
  check({text("four_bar_two"),
         "nonsmooth",
         {events, "run.duration=0.1", "run.output_step=1e-3"},
         {flight, impact}});
}

TEST_CASE("snapshots: adaptive time stepping, and the default scheme before, within and after its hand-overs",
          "[snapshot]") {
  const std::vector<std::string> chosen{"nonsmooth.scheme=\"moreau-jean\"", "nonsmooth.step=\"automatic\""},
      automatic{"nonsmooth.scheme=\"automatic\"", "nonsmooth.step=\"automatic\""};
  const std::vector knots{0.02, 0.05, 0.07};
  for (const auto& way : {chosen, automatic}) {
    const auto set = [&](std::vector<std::string> more) {
      more.insert(more.end(), way.begin(), way.end());
      return more;
    };
    for (const bool matched : {false, true})
      check({rig(),
             "nonsmooth",
             set({"run.duration=0.03", "run.discard=0.01", "run.output_step=1e-4"}),
             {flight, contact, impact},
             matched});
    check({loads(), "nonsmooth", set({}), {before_knot, behind_knot, impact, flight}, false, true, knots});
    check({text("bouncing_ball"), "nonsmooth", set({"run.output_step=1e-3"}), {flight, impact}});
    check({text("block_on_slope"), "nonsmooth", set({"run.output_step=1e-3"}), {contact, slide}});
    check({text("dragged_block"), "nonsmooth", set({"run.duration=0.6"}), {contact, slide, stick}});
    check({chain(),
           "nonsmooth",
           set({"nonsmooth.step_tolerance=1e-4", "run.duration=0.1", "run.output_step=1e-3",
                way == chosen ? "run.discard=0" : "nonsmooth.tolerance=1e-6"}),
           {flight}});
    check({test::random_pile(8), "nonsmooth", set({"run.duration=0.1"}), {contact, impact}, false, false});
  }
  // Three hand-overs; most of its steps are those of time stepping.
  check({test::random_pile(1), "nonsmooth", {"run.duration=0.443"}, {contact, impact}});
}

TEST_CASE("snapshots: the four corners of a guide with clearance, and every contact solver", "[snapshot]") {
  check({text("free_slider"), "nonsmooth", {"run.output_step=1e-3"}, {flight, impact}});
  check({text("free_slider"),
         "penalty",
         {"penalty.contact=\"kelvin-voigt\"", "penalty.kelvin_stiffness=1e6", "penalty.kelvin_damping=50",
          "surfaces.steel.tangential_restitution=0", "run.output_step=1e-3", "penalty.tolerance=1e-6"},
         {flight, contact, slide}});
  for (const char* solver : {"automatic", "enumeration", "lemke", "gauss-seidel", "newton"})
    for (const char* scene : {"free_slider", "dragged_block", "four_bar_two"}) {
      CAPTURE(scene);
      check({text(scene),
             "nonsmooth",
             {"nonsmooth.scheme=\"moreau-jean\"", fmt::format("nonsmooth.solver=\"{}\"", solver),
              "nonsmooth.step=5e-4", "run.output_step=1e-3", "run.duration=0.2"},
             {std::string_view(scene) == "free_slider" ? impact : contact}});
    }
}
