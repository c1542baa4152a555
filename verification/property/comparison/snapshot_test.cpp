// Snapshots of complete simulations. At random accepted steps of a run, in every integrator and
// scheme and in every state of the motion (in flight, within an impact, sliding, sticking, on a
// film, before and after a knot of a table), an observer takes a snapshot, which is restored in a
// new simulation and continued. All observable results of the rest must equal those of the
// uninterrupted run bit for bit.
#include "verification/property/comparison/snapshot_check.hpp"

using namespace freeplay;
using namespace freeplay::snapshots;
using Catch::Matchers::Contains;

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
        by("dopri5") + "surfaces.steel.yield_speed=0.01", by("rosenbrock4") + "penalty.stabilisation=none"})
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

TEST_CASE("snapshots: a sampled controller between its samples and at them", "[controller][snapshot]") {
  const auto axis = text("tests/controlled_axis");
  // The dead time ends between samples.
  const std::string sampled =
      " drives.servo.sampling_time=2e-3 drives.servo.dead_time=5e-3 drives.servo.resolution=1e-5";
  for (const auto& method : {std::string(), by("rosenbrock4"), by("adams_bashforth_moulton")})
    check(axis, "penalty", method + sampled, {flight, contact});
  check(axis, "nonsmooth", events + "surfaces.steel.restitution=0" + sampled, {flight, contact});
  for (const auto& scheme : {automatic, stepping + "3e-4", adaptive})
    check(axis, "nonsmooth", scheme + sampled, {flight});
}

// Snapshots in use: return to the start, observation from the snapshot on, a changed start, files,
// and refusals.

namespace {

Scene crank(std::vector<std::string> set = {"run.duration=0.01"}) {
  set.emplace_back("penalty.tolerance=1e-7");
  return read_scene(test::scene_file("tests/instrumented_crank"), set);
}

}  // namespace

TEST_CASE("snapshots: return to a state before the first step, in a simulation that has run", "[snapshot]") {
  const auto check_again = [](const std::string& text, const std::string& formulation,
                              const std::vector<std::string>& set) {
    CAPTURE(formulation, set);
    Simulation simulation(parse_scene(text, "snapshot.toml", set), formulation);
    const auto empty = simulation.snapshot();
    Record first(simulation, true), second(simulation, true);
    const auto whole = test::finished(simulation, {&first});
    simulation.restore(empty);
    REQUIRE(simulation.t() == 0);
    const auto again = simulation.run({.observers = {&second}});
    CHECK((second.steps == first.steps));
    CHECK((second.events == first.events));
    CHECK((second.samples == first.samples));
    CHECK((bits_of(again) == bits_of(whole)));
  };
  for (const std::string integrator :
       {"rk4", "dopri5", "bulirsch_stoer", "adams_bashforth_moulton", "rosenbrock4"})
    check_again(text("tests/instrumented_crank"), "penalty",
                {"penalty.integrator=" + integrator, "run.duration=0.012",
                 integrator == "rk4" ? "penalty.step=1e-5" : "penalty.tolerance=1e-7"});
  check_again(chain(), "penalty", {"penalty.tolerance=1e-7", "run.duration=0.05"});
  check_again(chain(), "nonsmooth",
              {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=5e-4", "run.duration=0.1"});
  check_again(chain(), "nonsmooth",
              {"nonsmooth.scheme=event-driven", "nonsmooth.tolerance=1e-6", "run.duration=0.1"});
  for (const std::string scheme : {"moreau-jean", "automatic"})
    check_again(test::random_pile(1), "nonsmooth", {"nonsmooth.scheme=" + scheme, "run.duration=0.45"});
}

TEST_CASE("snapshots: observation that begins after the snapshot", "[snapshot]") {
  // Sparse factors: the separate factors of forces are made at the first request for forces.
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    const auto scene = parse_scene(chain(), "snapshot.toml",
                                   {"penalty.tolerance=1e-7", "nonsmooth.step=5e-4", "run.duration=0.1"});
    Simulation seen(scene, formulation), restored(scene, formulation);
    seen.run({.until = 0.05});
    restored.restore(seen.snapshot());
    Record a(seen, true), b(restored, true);
    const auto rest = seen.run({.observers = {&a}}), again = restored.run({.observers = {&b}});
    CHECK((a.steps == b.steps));
    CHECK((a.samples == b.samples));
    CHECK_FALSE(a.samples.empty());
    CHECK((bits_of(rest) == bits_of(again)));
  }
}

TEST_CASE("snapshots: a changed start is included", "[snapshot]") {
  const auto scene = read_scene(test::scene_file("pendulum"), {"run.duration=0.1", "penalty.tolerance=1e-6"});
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    Simulation first(scene, formulation);
    first.run({.until = 0.05});
    Simulation begun(scene, formulation, {.start = first.state()}), fresh(scene, formulation);
    begun.run({.until = 0.07});
    fresh.restore(begun.snapshot());
    CHECK(fresh.layout().start[0].gap == begun.layout().start[0].gap);
    CHECK((bits_of(fresh.run()) == bits_of(begun.run())));
  }
}

TEST_CASE("snapshots: paused instruments resume at the present time", "[snapshot][instruments]") {
  const auto scene = crank({"run.duration=0.03"});
  Simulation rested(scene, "penalty");
  rested.run({.until = 0.0151});
  test::Listener listener;
  double last = 0;
  std::array<double, 5> first{};
  listener.on_sample = [&](std::size_t channel, double t, double) {
    if (first[channel] == 0) first[channel] = t;
    last = std::max(last, t);
  };
  rested.run({.observers = {&listener}});
  CHECK(last <= 0.03 + 1e-9);
  for (std::size_t i = 0; i < first.size(); ++i) {
    CAPTURE(scene.instruments[i].name);
    CHECK(first[i] > 0.0151);
    CHECK(first[i] <= 0.0151 + (1 + 1e-6) / scene.instruments[i].sampling);
  }
}

TEST_CASE("snapshots: written to a file and read back", "[snapshot][files]") {
  test::TemporaryFolder folder;
  const auto file = folder.path() / "a.snapshot";
  const auto scene = crank();
  Simulation one(scene, "penalty"), two(scene, "penalty");
  one.run({.until = 0.007});
  const auto s = one.snapshot();
  s.write(file);
  s.write(file);  // over an older one
  const auto r = Snapshot::read(file);
  CHECK(r.t == s.t);
  CHECK(r.program == s.program);
  CHECK(r.formulation == s.formulation);
  CHECK(r.scene == s.scene);
  CHECK((r.memory == s.memory));
  two.restore(r);
  CHECK((bits_of(two.run()) == bits_of(one.run())));
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) CHECK(entry.path() == file);
  CHECK_THROWS_AS(s.write(folder.path() / "none" / "a.snapshot"), SnapshotError);
}

TEST_CASE("snapshots: one that does not fit is refused, and the simulation stays unchanged",
          "[snapshot][files]") {
  test::TemporaryFolder folder;
  const auto scene = crank();
  Simulation simulation(scene, "penalty");
  simulation.run({.until = 0.007});
  const auto own = simulation.snapshot();
  Simulation untouched(scene, "penalty");
  untouched.restore(own);
  const auto rest = bits_of(untouched.run());
  const auto refused = [&](const Snapshot& s, const std::string& why) {
    CHECK_THROWS_AS(simulation.restore(s), SnapshotError);
    CHECK_THROWS_WITH(simulation.restore(s), Contains(why));
    CHECK((simulation.snapshot().memory == own.memory));
  };
  const auto of = [](const Scene& other) { return Simulation(other, "penalty").snapshot(); };
  refused(of(crank({"run.duration=0.01", "joints.gudgeon.clearance=3e-4"})),
          "joints.gudgeon.clearance is 0.00025 here and 0.0003 there");
  refused(of(crank({"run.duration=0.02"})), "run.duration is 0.01 here and 0.02 there");
  refused(of(read_scene(test::scene_file("pendulum"))), "is of another scene");
  Simulation nonsmooth(scene, "nonsmooth"), matched(scene, "nonsmooth", {.matched = true});
  refused(nonsmooth.snapshot(),
          "is of another formulation: formulation is \"penalty\" here and \"nonsmooth\" there");
  CHECK_THROWS_WITH(nonsmooth.restore(matched.snapshot()), Contains("matched is false here and true there"));
  CHECK_THROWS_WITH(matched.restore(nonsmooth.snapshot()), Contains("matched is true here and false there"));
  CHECK_THROWS_WITH(matched.restore(own),
                    Contains("formulation is \"nonsmooth\" here and \"penalty\" there"));
  auto changed = own;
  changed.program = "version = \"9.9.9\"\nsources = \"abc\"\n";
  refused(changed, "was taken by freeplay 9.9.9 (");
  for (const std::size_t size :
       {own.memory.size() - 1, own.memory.size() / 2, std::size_t{5}, std::size_t{0}}) {
    changed = own;
    changed.memory.resize(size);
    refused(changed, "incomplete");
  }
  changed = own;
  changed.memory.push_back(std::byte{0});
  refused(changed, "the snapshot is too long");

  // Files.
  const auto file = folder.path() / "a.snapshot";
  own.write(file);
  const auto whole = test::file_text(file);
  const auto read_refused = [&](const std::string& bytes, const std::string& why) {
    write_file(file, bytes);
    CHECK_THROWS_WITH(Snapshot::read(file), Contains(file.string()) && Contains(why));
    CHECK_THROWS_AS(Snapshot::read(file), SnapshotError);
  };
  std::mt19937 engine(7);
  const auto body = whole.find('\n') + 1;
  for (const auto size : {whole.size() - 1, whole.size() / 2, body})
    read_refused(whole.substr(0, size), "is damaged");
  read_refused(whole + "x", "is damaged");
  for (const std::size_t size : {std::size_t{0}, std::size_t{4}, body - 1})
    read_refused(whole.substr(0, size), "is not a snapshot of freeplay");
  for (int i = 0; i < 50; ++i) {
    auto flipped = whole;
    flipped[body + engine() % (whole.size() - body)] ^= static_cast<char>(1 << engine() % 8);
    read_refused(flipped, "is damaged");
  }
  for (std::size_t i = 0; i < body; ++i) {  // in the line before it
    auto flipped = whole;
    flipped[i] ^= 1;
    write_file(file, flipped);
    CAPTURE(flipped.substr(0, body));
    CHECK_THROWS_AS(Snapshot::read(file), SnapshotError);
  }
  const std::string version = "freeplay snapshot 2 ";
  REQUIRE(whole.starts_with(version));
  read_refused("freeplay snapshot 1 " + whole.substr(version.size()),
               "is a snapshot of version 1; this program reads version 2");
  read_refused("freeplay checkpoint 2 " + whole.substr(version.size()), "is not a snapshot of freeplay");
  read_refused("t,x,y\n0,0,0\n", "is not a snapshot of freeplay");
  CHECK_THROWS_WITH(Snapshot::read(folder.path()), Contains("is a folder, not a file"));
  CHECK_THROWS_WITH(Snapshot::read(folder.path() / "none"), Contains("none"));

  CHECK((bits_of(simulation.run()) == rest));
}
