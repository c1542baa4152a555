// Steps of integrators against closed forms: what a force or a place reads from a curve is neither passed over nor left
// out of the balance, whichever integrator steps over it.
#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <atomic>
#include <cmath>
#include <numbers>

#include "facade/simulation.hpp"
#include "formulations/integrators/methods.hpp"
#include "formulations/integrators/odeint_memory.hpp"
#include "mechanism/scene.hpp"
#include "simulation/observer.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using std::numbers::pi;

namespace {

const std::vector<std::string> adaptive{"dopri5", "bulirsch_stoer", "adams_bashforth_moulton", "rosenbrock4"};

/// A slider of 2 kg on a guide along x, and what acts on it.
Scene slider(const std::string& more, double speed, const std::vector<std::string>& sets) {
  return parse_scene(fmt::format(R"(
[bodies.slider]
mass = 2.0
inertia = 1.0
velocity = [{}, 0]
[joints.guide]
type = "translational"
between = ["ground", "slider"]
at = [[0, 0], [0, 0]]
axis = [1, 0]
{})",
                                 speed, more),
                     "slider.toml", sets);
}

std::string said(const Result& run) {
  std::string all;
  for (const auto& note : run.notes) all += note + "\n";
  return all;
}

}  // namespace

TEST_CASE("a step with a component that is not finite is refused", "[integrators]") {
  ErrorNorm norm;
  norm.absolute = {1, 1};
  norm.relative = {0, 0};
  norm.tolerance = 1e-8;
  int algebra = 0;
  const Vector x{0, 0, 0};
  const auto error = [&](Vector e) { return norm.error(algebra, x, x, e, 0.1); };
  CHECK(error({1e-9, 2e-9, 5}) == Approx(0.2));  // the third is carried along
  for (const double bad : {double(NAN), double(INFINITY)})
    for (std::size_t i = 0; i < 3; ++i) {
      Vector e{0, 0, 0};
      e[i] = bad;
      CAPTURE(bad, i);
      CHECK(error(e) == 1e10);
    }
  AdamsAdjuster adjuster{1e-8};
  Vector e{NAN, 0};
  CHECK(adjuster.adjust_stepsize(1, 1.0, e, x, x) < 1e-3);
}

TEST_CASE("a smooth push against the place does its work by every integrator", "[integrators]") {
  // From rest in force at x = 0.5 m to 10 N at 0.8 m: a trial step that reaches far beyond leaves the range of numbers.
  // ½ m v² = ½ m v₀² + ∫ F dx, and the 3-4-5 polynomial has the mean ½ over its rise.
  for (const auto& profile : {"polynomial", "cycloidal"})
    for (const double from : {0.0, 0.2, 2.0})
      for (const auto& integrator : adaptive)
        for (const double tolerance : {1e-6, 1e-9}) {
          const auto scene = slider(
              fmt::format("[curves.push]\nshape = \"ramp\"\nprofile = \"{}\"\nfrom = {}\nto = 10.0\nstart = "
                          "0.5\nrise = 0.3\n[drives.push]\njoint = \"guide\"\nforce = \"push\"\nagainst = "
                          "\"position\"\n[run]\nduration = 2.0\nstart = \"given\"\n",
                          profile, from),
              1, {"penalty.integrator=" + integrator, fmt::format("penalty.tolerance={}", tolerance)});
          const auto run = test::simulate(scene, Family::penalty);
          CAPTURE(profile, from, integrator, tolerance, run.ending.reason);
          REQUIRE(run.ending.status == Ending::Status::finished);
          const double x = run.final_state.q[0];
          const double work = from * 0.5 + 0.5 * (from + 10) * 0.3 + 10 * (x - 0.8);
          // Some hundred steps at the tolerance, of speeds of up to 10 m/s.
          CHECK(run.final_state.v[0] == Approx(std::sqrt(1 + work)).epsilon(0).margin(1e3 * tolerance));
          CHECK_THAT(said(run), !Contains("DOUBTFUL"));
        }
}

TEST_CASE("a bump stop's damper takes what its closed form takes", "[integrators][compliant]") {
  // m ÿ + c ẏ + k y = 0 from y = 0, ẏ = v: y = v/ω_d e^(−at) sin ω_d t. The stop lets go where k y + c ẏ = 0,
  // tan ω_d t = 2 a ω_d/(a² − ω_d² + ... ): found by bisection of the closed form; then the slider flies off.
  const double m = 2, v = 1, at = 0.1;
  for (const double k : {2000.0, 2e5})
    for (const double share : {0.05, 0.3, 0.8}) {  // of critical damping
      const double w = std::sqrt(k / m), a = share * w, c = 2 * m * a, d = std::sqrt(w * w - a * a);
      const auto y = [&](double t) { return v / d * std::exp(-a * t) * std::sin(d * t); };
      const auto rate = [&](double t) {
        return v * std::exp(-a * t) * (std::cos(d * t) - a / d * std::sin(d * t));
      };
      double low = 0, high = pi / d;  // pressed at first, pulled at last
      for (int i = 0; i < 200; ++i) {
        const double t = 0.5 * (low + high);
        (k * y(t) + c * rate(t) > 0 ? low : high) = t;
      }
      const double off = rate(low), loss = 0.5 * m * (v * v - off * off);
      const double x = at + y(low) + off * (0.3 - at / v - low);
      for (const auto& integrator : adaptive)
        for (const double tolerance : {1e-7, 1e-9}) {
          const auto run = test::simulate(
              slider(
                  fmt::format("[loads.stop]\ntype = \"bump-stop\"\nbetween = [\"ground\", \"slider\"]\nat = "
                              "[[0, 0], [0, 0]]\naxis = [1, 0]\nupper = {}\nstiffness = {}\ndamping = "
                              "{:.17g}\n[run]\nduration = 0.3\nstart = \"given\"\n",
                              at, k, c),
                  v, {"penalty.integrator=" + integrator, fmt::format("penalty.tolerance={}", tolerance)}),
              Family::penalty);
          CAPTURE(k, share, integrator, tolerance, said(run), run.ledger.closure());
          REQUIRE(run.ending.status == Ending::Status::finished);
          // A hundred steps at the tolerance, of 1 m/s and 1 J; the force has a kink where the stop lets go.
          const double bound = 300 * tolerance;
          CHECK(run.final_state.v[0] == Approx(off).margin(bound).epsilon(0));
          CHECK(run.final_state.q[0] == Approx(x).margin(bound).epsilon(0));
          CHECK(run.ledger.damping == Approx(loss).margin(bound).epsilon(0));
          CHECK_THAT(said(run), !Contains("DOUBTFUL"));
        }
    }
}

TEST_CASE("a motion that ends near rest is judged by the energy that passed", "[judge]") {
  // F = A sin ωt on a mass at rest: v = A/(m ω) (1 − cos ωt), at rest again after each period.
  const double A = 10, m = 2, f = 20, w = 2 * pi * f;
  const auto driven = [&](const std::vector<std::string>& sets) {
    return slider(fmt::format("[curves.push]\nshape = \"harmonic\"\namplitude = {}\nfrequency = {}\n"
                              "[drives.push]\njoint = \"guide\"\nforce = \"push\"\n[run]\nduration = {}\n"
                              "start = \"given\"\n",
                              A, f, 10 / f),
                  0, sets);
  };
  const auto judge = [&](const Result& run) {
    REQUIRE(run.ending.status == Ending::Status::finished);
    const double most = 2 * A / (m * w), energy = 0.5 * m * most * most;  // m/s, J
    CAPTURE(said(run), run.final_state.v[0], run.ledger.closure(), run.ledger.passed);
    CHECK(run.ledger.scale() < 1e-3 * energy);  // nothing is left
    CHECK(run.ledger.passed == Approx(energy).epsilon(0.05));
    CHECK(std::abs(run.final_state.v[0]) < 1e-4 * most);
    CHECK_THAT(said(run), !Contains("DOUBTFUL"));
  };
  for (const auto& integrator : adaptive)
    judge(test::simulate(driven({"penalty.integrator=" + integrator}), Family::penalty));
  judge(test::simulate(driven({"penalty.integrator=rk4", "penalty.step=1e-4"}), Family::penalty));
  for (const auto& scheme : {"event-driven", "automatic"})
    judge(test::simulate(driven({fmt::format("nonsmooth.scheme={}", scheme)}), Family::nonsmooth));
  judge(test::simulate(driven({"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-4"}), Family::nonsmooth));
}

TEST_CASE("a force of 3 kHz is followed in every row", "[integrators][curves]") {
  // v = A/(m ω) (1 − cos ωt), x = A/(m ω) (t − sin ωt/ω), at rest again after 150 periods.
  const double A = 10, m = 2, w = 2 * pi * 3000, size = A / (m * w), duration = 0.05;
  const auto scene = [&](const std::vector<std::string>& sets) {
    return slider(fmt::format("[curves.push]\nshape = \"harmonic\"\namplitude = {}\nfrequency = 3000\n"
                              "[drives.push]\njoint = \"guide\"\nforce = \"push\"\n[run]\nduration = {}\n"
                              "start = \"given\"\n",
                              A, duration),
                  0, sets);
  };
  const auto worst = [&](const Scene& driven, Family family, std::string& notes) {
    Simulation simulation(driven, test::name_of(family));
    double off = 0;
    const auto n = simulation.state().q.size();
    std::vector<double> q(n), v(n);
    test::Listener listener;
    listener.on_step = [&](const Step& step) {
      for (int i = 1; i <= 8; ++i) {
        const double t = step.t0 + (step.t1 - step.t0) * i / 8;
        step.state(t, q, v);
        off = std::max({off, std::abs(v[0] / size - (1 - std::cos(w * t))),
                        std::abs(q[0] - size * (t - std::sin(w * t) / w)) / (size * duration)});
      }
    };
    const auto run = simulation.run({.observers = {&listener}});
    REQUIRE(run.ending.status == Ending::Status::finished);
    notes = said(run);
    return off;
  };
  std::string notes;
  for (const auto& integrator : adaptive) {
    // A sixteenth of a period leaves a cubic between the ends of a step (2π/16)⁴/384 = 6e-5 of the sine off.
    const double off = worst(scene({"penalty.integrator=" + integrator}), Family::penalty, notes);
    CAPTURE(integrator, off, notes);
    CHECK(off < 1e-4);
    CHECK_THAT(notes, !Contains("DOUBTFUL"));
  }
  const auto fixed = [&](double step) {
    return scene({"penalty.integrator=rk4", fmt::format("penalty.step={}", step)});
  };
  CHECK(worst(fixed(1e-5), Family::penalty, notes) < 1e-4);
  CHECK_THAT(notes, !Contains("DOUBTFUL"));
  worst(fixed(1e-4), Family::penalty, notes);  // 3.3 steps a period
  CHECK_THAT(notes, Contains("DOUBTFUL: penalty.step is 4.8 times as long as"));
}

TEST_CASE("a force that turns round 3000 times a second is followed for a second", "[integrators][curves]") {
  // x = A/(m ω) t at whole periods, at rest: the speed that a step may have wrong is of the force's own impulse, 2A/ω, not of
  // what the greatest force would give within the arm.
  const double A = 10, m = 2, w = 2 * pi * 3000, size = A / (m * w);
  for (const auto* integrator : {"adams_bashforth_moulton", "rosenbrock4"}) {
    const auto run = test::simulate(
        slider(fmt::format("[curves.push]\nshape = \"harmonic\"\namplitude = {}\nfrequency = 3000\n"
                           "[drives.push]\njoint = \"guide\"\nforce = \"push\"\n[run]\nduration = 1.0\n"
                           "start = \"given\"\n",
                           A),
               0, {fmt::format("penalty.integrator={}", integrator)}),
        Family::penalty);
    CAPTURE(integrator, said(run), run.final_state.q[0] / size - 1, run.final_state.v[0] / size);
    REQUIRE(run.ending.status == Ending::Status::finished);
    // 1e-8 a step of the scale of 1e-3 m/s (tolerance.hpp), in 6e4 steps whose errors follow the sine's sign: a hundred of them.
    CHECK(run.final_state.q[0] == Approx(size).epsilon(4e-6));
    CHECK(std::abs(run.final_state.v[0]) < 4e-6 * size);
    CHECK_THAT(said(run), !Contains("DOUBTFUL"));
  }
}

TEST_CASE("a place that follows another joint's angle is lifted as its curve says", "[integrators][curves]") {
  const auto scene = [](const std::string& integrator, double stiffness) {
    return parse_scene(fmt::format(R"(
[bodies.rotor]
mass = 1.0
inertia = 0.01
angular_velocity = 6.0
[bodies.slide]
mass = 0.5
inertia = 0.001
position = [1, 0]
[joints.main]
type = "revolute"
between = ["ground", "rotor"]
at = [[0, 0], [0, 0]]
[joints.guide]
type = "translational"
between = ["ground", "slide"]
at = [[1, 0], [0, 0]]
axis = [0, 1]
[curves.lift]
shape = "rise-dwell-return"
to = 0.03
start = 1.0
rise = 1.0
dwell = 0.5
return = 1.0
[drives.cam]
joint = "guide"
position = "lift"
of = "main"
[loads.spring]
type = "spring-damper"
between = ["ground", "slide"]
at = [[1, -1], [0, 0]]
free_length = 1.0
stiffness = {}
[run]
duration = 1.0
start = "given"
)",
                                   stiffness),
                       "follower.toml", {"penalty.integrator=" + integrator});
  };
  const auto lift = [](double angle) {
    const auto p = [](double s) { return s * s * s * (10 + s * (-15 + 6 * s)); };
    if (angle < 1 || angle > 3.5) return 0.0;
    return 0.03 * (angle < 2 ? p(angle - 1) : angle < 2.5 ? 1.0 : 1 - p(angle - 2.5));
  };
  for (const double stiffness : {0.0, 1000.0})
    for (const auto& integrator : adaptive) {
      Simulation simulation(scene(integrator, stiffness), "penalty");
      std::vector<double> q(6), v(6);
      double off = 0, highest = 0, furthest = 0;
      test::Listener listener;
      listener.on_step = [&](const Step& step) {
        step.state(step.t1, q, v);
        off = std::max(off, std::abs(q[4] - lift(q[2])));
        highest = std::max(highest, q[4]);
        furthest = std::max(furthest, q[2]);
      };
      const auto run = simulation.run({.observers = {&listener}});
      CAPTURE(integrator, stiffness, off, highest, furthest, said(run));
      REQUIRE(run.ending.status == Ending::Status::finished);
      // Some hundred steps at a tolerance of 1e-9 of an arm of 1 m.
      CHECK(off < 1e-7);
      CHECK_THAT(said(run), !Contains("DOUBTFUL"));
      const double energy = 0.5 * 0.01 * 6 * 6;
      if (stiffness == 0) {
        CHECK(highest == Approx(0.03).epsilon(1e-5));
        CHECK(run.final_state.v[2] == Approx(6).epsilon(1e-6));  // the slide gives back what it took
      } else {  // ½ k y² = ½ J ω² below the top: the rotor turns back, and leaves as it came
        const double top = std::sqrt(2 * energy / stiffness);
        CHECK(highest < top + 1e-7);
        CHECK(highest > 0.98 * top);
        CHECK(furthest < 2);
        CHECK(run.final_state.v[2] == Approx(-6).epsilon(1e-6));
      }
    }
}

TEST_CASE("a barrier higher than the energy throws the slider back", "[integrators][curves]") {
  // 1 J against a hill of ½ 0.02 m 250 N = 2.5 J, whose sides do no net work: it comes back with −v₀.
  for (const auto& between : {"linear", "spline"})
    for (const auto& integrator : adaptive) {
      const auto run = test::simulate(
          slider(
              fmt::format("[curves.hill]\nshape = \"table\"\npoints = [[0.47, 0], [0.48, 0], [0.49, -250], "
                          "[0.5, 0], [0.51, 250], [0.52, 0], [0.53, 0]]\nbetween = \"{}\"\n[drives.hill]\n"
                          "joint = \"guide\"\nforce = \"hill\"\nagainst = \"position\"\n[run]\nduration "
                          "= 1.5\nstart = \"given\"\n",
                          between),
              1, {"penalty.integrator=" + integrator}),
          Family::penalty);
      CAPTURE(between, integrator, said(run), run.ending.reason);
      REQUIRE(run.ending.status == Ending::Status::finished);
      // Some hundred steps at a tolerance of 1e-9.
      CHECK(run.final_state.v[0] == Approx(-1).epsilon(0).margin(1e-6));
      CHECK_THAT(said(run), !Contains("DOUBTFUL"));
    }
}

TEST_CASE("a fixed step settles where great forces balance near rest", "[curves]") {
  // 125 N against a spring of 64 N/m with a damper of 2 N s/m: what is left near rest is rounding, 500 times below the
  // step of mass/damping that the stop used to name.
  const auto run = test::simulate(parse_scene(R"(
gravity = [0, -9.81]
[bodies.slider]
mass = 0.1059
inertia = 1.0
[joints.guide]
type = "translational"
between = ["ground", "slider"]
at = [[0, 0], [0, 0]]
axis = [1, 0]
[curves.push]
shape = "ramp"
from = 28.99
to = -124.8
start = 0.3261
rise = 0.2273
[drives.push]
joint = "guide"
force = "push"
[loads.spring]
type = "spring-damper"
between = ["ground", "slider"]
at = [[-1, 0], [0, 0]]
stiffness = 63.63
damping = 2.224
free_length = 1
[run]
duration = 4.0
start = "given"
[nonsmooth]
scheme = "moreau-jean"
step = 1e-4
)",
                                              "slider.toml"),
                                  Family::nonsmooth);
  CAPTURE(run.ending.reason);
  CHECK(run.ending.status == Ending::Status::finished);
  CHECK(std::abs(run.final_state.v[0]) < 1e-6);
}

TEST_CASE("fehlberg78 is refused with what to use instead", "[errors]") {
  CHECK_THROWS_WITH(slider("[run]\nduration = 1\n[penalty]\nintegrator = \"fehlberg78\"\n", 1, {}),
                    Contains("slider.toml:14:14: penalty.integrator: \"fehlberg78\" has been removed") &&
                        Contains("use \"bulirsch_stoer\""));
}
