// Properties of every run: the energy balance, constraints, walls, no allocation in the stepping
// loop, and memory that does not grow with the length of the run.
#include "io/files/csv.hpp"
#include "io/scene/read_scene.hpp"
#include "simulation/statistics.hpp"
#include "verification/property/invariants/allocations.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

#if !defined(__SANITIZE_ADDRESS__)
namespace {

/// Allocations between two steps of a run of 0.6 s with every observer, with or without forces: a
/// run allocates before its first step and after its last.
long allocated(Simulation& simulation, bool with_forces, Work& work) {
  test::TemporaryFolder folder;
  TrajectoryCsv trajectory(folder.path() / "trajectory.csv");
  EventsCsv events(folder.path() / "events.csv");
  SignalsCsv signals(folder.path() / "signals.csv");
  ForcesCsv forces(folder.path() / "forces.csv");
  ContactStatistics statistics(0);
  long first = -1, last = -1;
  test::Listener counter;
  counter.on_step = [&](const Step& step) {
    if (step.t1 > 1e-3 && first < 0) first = test::operator_new_calls();
    last = test::operator_new_calls();
  };
  std::vector<Observer*> observers{&trajectory, &events, &signals, &statistics, &counter};
  if (with_forces) observers.push_back(&forces);
  const auto run = simulation.run({.until = 0.6, .observers = observers, .keep_events = false});
  REQUIRE(run.ending.status == Ending::Status::finished);
  work = run.work;
  return last - first;
}

/// Steps of a run after a time (s), and the number of them that allocate memory.
struct Steps {
  long all = 0, allocating = 0;
  Work work = {};
};
Steps steps_of(Simulation& simulation, double from, std::optional<double> until = {}) {
  Steps steps;
  long last = 0;
  test::Listener counter;
  counter.on_step = [&](const Step& step) {
    if (step.t1 > from) {
      ++steps.all;
      steps.allocating += test::malloc_calls() > last;
    }
    last = test::malloc_calls();
  };
  const auto run = simulation.run({.until = until, .observers = {&counter}, .keep_events = false});
  REQUIRE(run.ending.status == Ending::Status::finished);
  steps.work = run.work;
  return steps;
}

}  // namespace

TEST_CASE("the stepping loop allocates no memory", "[allocation]") {
  auto scene = read_scene(test::flores());
  const auto family = GENERATE(Family::penalty, Family::nonsmooth);
  // Boost's bulirsch_stoer_dense_out allocates in its steps, as docs/theory/penalty.md states.
  scene.penalty.integrator = family == Family::penalty
                                 ? GENERATE(Integrator::rk4, Integrator::dopri5,
                                            Integrator::adams_bashforth_moulton, Integrator::rosenbrock4)
                                 : Integrator::dopri5;
  CAPTURE(family == Family::penalty, static_cast<int>(scene.penalty.integrator));
  Simulation simulation(scene, test::name_of(family));
  Work work;
  REQUIRE(allocated(simulation, GENERATE(false, true), work) == 0);
  REQUIRE(work.events > 10);  // flights, impacts, lasting contact
}

TEST_CASE("the loop of adaptive time stepping allocates no memory", "[allocation]") {
  // The state that a refused step restores is copied at every step, including the contacts' log,
  // into memory allocated at the start.
  auto scene = read_scene(test::flores());
  scene.nonsmooth.step.reset();
  Simulation simulation(scene, "nonsmooth");
  Work work;
  REQUIRE(allocated(simulation, GENERATE(false, true), work) == 0);
  REQUIRE(work.events > 10);  // flights, impacts, bounces, lasting contact
  REQUIRE(work.rejected > 10);
}

TEST_CASE("no element allocates memory within a step, in any scheme", "[allocation]") {
  // Springs, cams, motors, gears, films and joints with friction. Allocations of the event-driven
  // scheme at events (lists of touching contacts, new sizes of the closed set) are not included:
  // most of its steps have no event.
  struct Case {
    const char* name;
    double until;
  };
  struct Way {
    const char *name, *formulation, *scheme;
    std::optional<double> step;
  };
  const auto c = GENERATE(Case{"four-bar-friction", 0.5}, Case{"cam-follower", 0.5},
                          Case{"spring-balance", 0.5}, Case{"motor-startup", 0.1}, Case{"gear-rattle", 0.1},
                          Case{"lubricated-pin", 0.2}, Case{"press", 0.3}, Case{"four-bar", 0.2});
  const auto way = GENERATE(
      Way{"penalty", "penalty", "automatic", {}}, Way{"fixed steps", "nonsmooth", "moreau-jean", 1e-4},
      Way{"chosen steps", "nonsmooth", "moreau-jean", {}},
      Way{"event-driven", "nonsmooth", "event-driven", {}}, Way{"automatic", "nonsmooth", "automatic", {}});
  CAPTURE(c.name, way.name);
  auto scene = read_scene(test::source_folder() / "cases" / c.name / "scene.toml",
                          {fmt::format("nonsmooth.scheme=\"{}\"", way.scheme)});
  scene.nonsmooth.step = way.step;
  scene.instruments.clear();
  // Boost's Rosenbrock method allocates a vector at each step.
  const bool penalty = way.formulation == std::string("penalty");
  if (penalty && scene.penalty.integrator == Integrator::rosenbrock4) return;
  Simulation simulation(scene, way.formulation);
  const auto steps = steps_of(simulation, 0.02 * c.until, c.until);
  REQUIRE(steps.all > 20);
  const bool events = way.scheme != std::string("moreau-jean") && !penalty;
  // A switch of the penalty formulation to an implicit method and back allocates its memory.
  const double most = events ? 0.25 * static_cast<double>(steps.all) : penalty ? 2 : 0;
  CHECK(static_cast<double>(steps.allocating) <= most);
}

TEST_CASE("no contact solver allocates memory within a step", "[allocation]") {
  const auto* name = GENERATE("gudgeon_mu03", "four_bar_two");
  const auto solver = GENERATE(LcpSolver::automatic, LcpSolver::lemke, LcpSolver::gauss_seidel,
                               LcpSolver::newton, LcpSolver::enumeration);
  const bool chosen = GENERATE(false, true);
  CAPTURE(name, static_cast<int>(solver), chosen);
  auto scene = read_scene(test::scene_file(name));
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  scene.nonsmooth.step = 1e-5;
  if (chosen) scene.nonsmooth.step.reset();
  scene.nonsmooth.solver = solver;
  scene.instruments.clear();
  Simulation simulation(scene, "nonsmooth");
  const auto steps = steps_of(simulation, 0.04, 0.2);  // after the first problems of each size
  REQUIRE(steps.all > (chosen ? 50 : 1000));
  CHECK(steps.work.lcp_solves > (chosen ? 100 : 1000));
  CHECK(steps.allocating == 0);
}

TEST_CASE("a pile with pairs that form and dissolve allocates no memory once at rest",
          "[allocation][groups]") {
  // Three columns of discs, each on the one below, under load for the whole run: lists, slots,
  // islands and sweeps have their memory from the first steps.
  Simulation simulation(
      parse_scene(
          "gravity = [0, -9.81]\n[groups.g]\nmass = 0.3\nradius = 0.1\ngrid = [3, 10]\n"
          "origin = [0.1, 0.1]\nspacing = [0.25, 0.2]\n"
          "walls = [[0, 3], [0, 0], [0.72, 0], [0.72, 3]]\nsurface = \"s\"\npairs = \"near\"\n"
          "[surfaces.s]\nrestitution = 0.4\nfriction = 0.3\n[run]\nduration = 0.3\nstart = \"given\"\n"
          "[nonsmooth]\nscheme = \"moreau-jean\"\nstep = 1e-3\n",
          "heap.toml"),
      "nonsmooth");
  // From 0.1 s on: the patterns of its islands were analysed, the last one at 0.082 s.
  const auto steps = steps_of(simulation, 0.1);
  REQUIRE(steps.all > 190);
  CHECK(steps.allocating == 0);
}
#endif

TEST_CASE("energy balance, constraints and walls hold in every mechanism", "[invariants]") {
  for (const auto* name : {"gudgeon", "gudgeon_mu03", "gudgeon_1mm_250rpm", "big_end", "four_bar",
                           "four_bar_two", "pendulum", "double_pendulum", "ring"})
    for (const auto family : {Family::penalty, Family::nonsmooth}) {
      CAPTURE(name, family == Family::penalty);
      auto scene = read_scene(test::scene_file(name));
      scene.run.duration = 0.3;
      const auto run = test::simulate(scene, family);
      REQUIRE(run.ending.status == Ending::Status::finished);
      // Penalty: 1e-9 per step and thousands of steps. Time stepping: the work of impulses is
      // recorded exactly; the remaining error is that of the midpoint rule for the potential, h²
      // relative.
      CHECK(std::abs(run.ledger.closure()) <= (family == Family::penalty ? 1e-5 : 1e-7) * run.ledger.scale());
      CHECK(run.ledger.contact >= 0);
      CHECK(run.ledger.friction >= 0);
      for (const auto& c : run.contacts) {
        if (family == Family::nonsmooth) CHECK(c.penetration_ratio < 1e-3);
        CHECK(c.penetration_ratio < 0.1);
      }
      if (family == Family::nonsmooth) {
        CHECK(run.extremes.constraint_length < 1e-9);
        CHECK(run.extremes.lcp_residual < 1e-10);
        // After an impact the journal is up to h|u|/2 inside the wall; the position correction
        // raises the weight W by no more than that (leverage up to 2). Without weight only
        // second-order terms remain: 1e-4 of the energy that contacts dissipate.
        double weight = 0, speeds = 0;
        for (const auto& b : scene.mechanism.bodies) weight += b.mass * scene.mechanism.gravity.norm();
        for (const auto& e : run.events) speeds += std::abs(e.v_n_minus);
        CHECK(std::abs(run.ledger.stabilisation) <=
              *scene.nonsmooth.step * weight * speeds + 1e-4 * run.ledger.contact);
      } else {
        CHECK(run.extremes.constraint_length < 1e-8);
      }
    }
}

TEST_CASE("set-valued friction stops a preloaded slide permanently; regularised friction creeps",
          "[friction]") {
  // Mass 2 kg at 0.3 m/s against 15 N: stops after 0.04 s and 6 mm. Then a force of 10 N acts,
  // below the friction limit: it sticks.
  auto scene = parse_scene(test::body("block", 2, 1, "velocity = [0.3, 0]\n") +
                               test::guide("guide", "ground", "block") +
                               "[loads.rub]\ntype = \"joint-friction\"\njoint = \"guide\"\nforce = 15\n"
                               "regularisation = 1e-3\n" +
                               test::run_for(0.2),
                           "block");
  const auto final_x = [&](Family family) {
    Simulation f(scene, test::name_of(family));
    REQUIRE(f.run({.until = 0.2}).ending.status == Ending::Status::finished);
    return std::pair{f.state().q[0], f.state().v[0]};
  };
  // Time stepping stops within a step of 1e-5 s: ½·0.3·1e-5 m. Regularised: the last 1e-3 m/s
  // decays over m v/F.
  const auto [x, v] = final_x(Family::nonsmooth);
  CHECK(x == Approx(6e-3).margin(1.5e-6).epsilon(0));
  CHECK(v == 0);
  const auto [xp, vp] = final_x(Family::penalty);
  CHECK(xp == Approx(6e-3).margin(1e-6).epsilon(0));
  scene = parse_scene(scene.text + "\n[loads.pull]\ntype = \"force\"\nbody = \"block\"\nforce = [10, 0]\n",
                      "block");
  const double stop = 0.3 * 2 / (15 - 10);  // decelerated by 5 N while it slides: 0.12 s, 18 mm
  const auto [xs, vs] = final_x(Family::nonsmooth);
  CHECK(stop < 0.2);
  CHECK(xs == Approx(0.018).margin(1.5e-6).epsilon(0));
  CHECK(vs == 0);
  const auto [xc, vc] = final_x(Family::penalty);
  CHECK(vc == Approx(1e-3 * 10 / 15).epsilon(1e-6));  // creep: v/v_r = force/limit
}

TEST_CASE("dampers and springs: a damped oscillator against its closed form", "[loads]") {
  // m ẍ + d ẋ + k x = 0 from x₀ at rest.
  auto scene = parse_scene(test::body("block", 1.5, 1, "position = [1.02, 0]\n") +
                               test::guide("guide", "ground", "block") +
                               test::spring("spring", "ground", "block", {}, {}, 60, 1, "damping = 3\n") +
                               test::run_for(1) + "[nonsmooth]\nstep = 1e-4\n",
                           "oscillator");
  const double sigma = 3 / (2 * 1.5), omega = std::sqrt(60 / 1.5 - sigma * sigma);
  const double expected = 0.02 * std::exp(-sigma) * (std::cos(omega) + sigma / omega * std::sin(omega));
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    Simulation f(scene, test::name_of(family));
    REQUIRE(f.run({.until = 1}).ending.status == Ending::Status::finished);
    // Time stepping: (ω h)²/12 of the phase over ω t: 2e-7 relative here; dopri5 far better.
    CHECK(f.state().q[0] - 1 ==
          Approx(expected).margin(family == Family::penalty ? 1e-8 : 1e-7 * 0.2).epsilon(0));
    const auto l = f.ledger();
    CHECK(l.damping == Approx(l.initial - l.kinetic - l.potential).epsilon(1e-5));
  }
}

TEST_CASE("a redundant constraint is detected and does not change the motion", "[redundant]") {
  // A slider in two parallel guides: every row of the second depends on the first.
  const std::string one =
      test::body("slider", 2, 0.1, "velocity = [1, 0]\n") + test::guide("guide", "ground", "slider") +
      "[loads.push]\ntype = \"force\"\nbody = \"slider\"\nforce = [4, 3]\n" + test::run_for(0.5);
  const std::string two = std::string(one) +
                          "[joints.guide2]\ntype = \"translational\"\nbetween = [\"ground\", "
                          "\"slider\"]\nat = [[0, 0.1], [0, 0.1]]\n";
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    const auto a = parse_scene(one, "one"), b = parse_scene(two, "two");
    REQUIRE(test::redundant_rows(b).size() == 2);
    const auto ra = test::simulate(a, family), rb = test::simulate(b, family);
    REQUIRE(ra.notes.empty());
    REQUIRE(rb.notes.size() == 1);
    // x = t + t², v = 1 + 2t: kinetic energy 2·½·(1 + 2·0.5)² = 4 J. The proximal term loses nine
    // digits of sixteen.
    CHECK(ra.ledger.kinetic == Approx(4).epsilon(1e-9));
    CHECK(rb.ledger.kinetic == Approx(4).epsilon(1e-7));
  }
}

TEST_CASE("friction in the guide does not make a lasting contact chatter", "[friction]") {
  // The guide's impulse of a step can close the gudgeon's gap. A step that considers only the free
  // motion omits the contact and lets it bounce every second step: 3500 impacts a revolution
  // instead of some tens.
  auto scene = read_scene(test::flores());
  scene = parse_scene(scene.text +
                          "\n[loads.rub]\ntype = \"joint-friction\"\njoint = \"guide\"\nforce = 15.0\n"
                          "regularisation = 1e-3\n",
                      "guide", {"run.revolutions=52", "run.discard=2", "penalty.contact=exact"});
  scene.instruments.clear();
  const auto nonsmooth = test::simulate(scene, Family::nonsmooth),
             penalty = test::simulate(scene, Family::penalty);
  CHECK(nonsmooth.contacts[0].impacts < 5000);
  // Shares of flight over fifty revolutions (over ten, rounding alone changes them by 0.03):
  // within half a flight of the measured kind (20° of crank angle) per revolution.
  CHECK(nonsmooth.contacts[0].flight_fraction ==
        Approx(penalty.contacts[0].flight_fraction).margin(0.5 * 20 / 360));
}

// Runs that must stop with a reason or be reported as doubtful, and the penetration of contacts.

TEST_CASE("an explicit integrator does not advance forever at tiny steps in a stiff lasting contact",
          "[penalty]") {
  // The contact rests: v0 is the floor, and χ/v0 with a picometre a second makes the contact so
  // stiff that stability requires steps of nanoseconds. The implicit method takes some hundred
  // steps; it takes over after 2000 of an explicit one.
  for (const char* integrator : {"adams_bashforth_moulton", "dopri5", "bulirsch_stoer", "rosenbrock4"}) {
    const auto run = test::simulate(
        *open_scene(test::scene_file("resting_journal"),
                    {"penalty.v0_floor=1e-12", std::string("penalty.integrator=") + integrator}),
        Family::penalty);
    CAPTURE(integrator);
    CHECK(run.ending.status == Ending::Status::finished);
    CHECK(run.work.steps < 10000);
  }
}

TEST_CASE("a run beyond the permitted range of numbers is refused", "[run]") {
  CHECK_THROWS_WITH(open_scene(test::scene_file("ring"), {"bodies.journal.angular_velocity=1e200"}),
                    Contains("must be at most 1e+12 rad/s"));
}

TEST_CASE("time steps too long for the flights are reported", "[nonsmooth]") {
  // At 0.11 m/s the journal crosses 0.1 mm in 0.9 ms: 90 steps of 1e-5 s, one of 1e-3 s.
  const auto notes = [](const std::string& step) {
    const auto scene = read_scene(test::flores(), {"joints.gudgeon.clearance=0.1e-3", "run.revolutions=2",
                                                   "run.discard=0", "nonsmooth.step=" + step});
    return test::notes_of(test::simulate(scene, Family::nonsmooth));
  };
  CHECK_THAT(notes("1e-5"), !Contains("warning: "));
  CHECK_THAT(notes("1e-3"), Contains("warning: the free flight before one of the fastest impacts lasted"));
}

TEST_CASE("penetration stays below a thousandth of the clearance over the settings of the paper",
          "[invariant]") {
  // At h = 1e-5 s, including lasting contact (more than 90 % of the time). Two revolutions each;
  // over fifty the greatest ratio was 3.7e-7 (docs/theory/nonsmooth.md).
  for (const double clearance : {0.1e-3, 0.25e-3, 0.5e-3, 1e-3})
    for (const double rpm : {100.0, 150.0, 200.0, 250.0}) {
      const auto scene = open_scene(test::flores(), {"joints.gudgeon.clearance=" + std::to_string(clearance),
                                                     "drives.motor.speed_rpm=" + std::to_string(rpm),
                                                     "run.revolutions=2", "run.discard=0.5"});
      const auto run = test::simulate(*scene, Family::nonsmooth);
      CAPTURE(clearance, rpm);
      REQUIRE(run.ending.status == Ending::Status::finished);
      CHECK(run.contacts[0].penetration_ratio < 1e-3);
      CHECK(run.contacts[0].lasting_fraction > 0.5);
      // The energy of position corrections: no gravity or spring here, so only rounding of 100 J.
      CHECK(std::abs(run.ledger.stabilisation) < 1e-6);
    }
}
