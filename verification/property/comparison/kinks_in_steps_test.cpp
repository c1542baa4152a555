// Narrow kinks of forces against speed and of limited controllers: no scheme may pass over them.
// Every recorded row is compared with a solution piece by piece (references/kinked_forces.hpp and
// feedback.hpp).
#include "formulations/integrators/adams.hpp"
#include "formulations/integrators/methods.hpp"
#include "verification/references/feedback.hpp"
#include "verification/references/kinked_forces.hpp"
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using std::numbers::pi;
using test::notes_of;

namespace {

using test::Way;

const auto all_ways = test::with_integrators({test::automatic, test::event_driven, test::chosen_steps});

/// Bound of a row's error over the greatest speed. Located kinks leave the tolerance of 1e-8 a step,
/// over at most some thousand steps. Adaptive time stepping is of second order with a tolerance of
/// 1e-6, and passes knots of speeds by up to a hundredth of the narrowest piece.
double bound(const Way& way) { return way.stepping() ? 2e-3 : 2e-5; }

test::MotionRows rows_of(const Way& way, const std::string& text, double apart) {
  return test::motion_rows(test::scene_by(way, text), way.family, apart);
}

/// A body of mass m (kg), or inertia, under a force that is a table of its speed.
std::string by_speed(bool turns, double m, double v, const std::vector<reference::SpeedCurve::Knot>& knots,
                     double duration) {
  std::string points;
  for (const auto& k : knots) points += fmt::format("[{:.17g}, {:.17g}], ", k.v, k.force);
  const auto curve = fmt::format("[curves.c]\nshape = \"table\"\npoints = [{}]\n", points) +
                     test::run_for(duration, "start = \"given\"\n");
  if (turns)
    return test::body("it", 1, m, fmt::format("angular_velocity = {}\n", v)) +
           test::pin("j", "ground", "it") +
           test::drive("d", "j", "torque_curve = \"c\"\nagainst = \"speed\"\n") + curve;
  return test::body("it", m, 1, fmt::format("velocity = [{}, 0]\n", v)) + test::guide("j", "ground", "it") +
         test::drive("d", "j", "force = \"c\"\nagainst = \"speed\"\n") + curve;
}

void check_speed(bool turns, double m, double v, const std::vector<reference::SpeedCurve::Knot>& knots,
                 double duration, double scale) {
  for (const auto& way : all_ways) {
    INFO(way.name);
    const auto rows = rows_of(way, by_speed(turns, m, v, knots, duration), duration / 40);
    REQUIRE(rows.rows.size() >= 40);
    reference::SpeedCurve exact(knots, m, v);
    CHECK(rows.worst([&](const test::MotionRow& r) {
      exact.advance(r.t);
      return (r.v[turns ? 2 : 0] - exact.v()) / scale;
    }) < bound(way));
  }
}

/// An inertia at the angle 0 under a controller with a limit.
struct Axis {
  double J, stiffness, damping, target, limit, speed = 0;
};

void check_controller(const Axis& axis, double duration) {
  const double pace = std::sqrt(2 * std::abs(axis.target) * axis.limit / axis.J) + std::abs(axis.speed);
  const auto text =
      test::body("it", 1, axis.J, fmt::format("angular_velocity = {}\n", axis.speed)) +
      test::pin("j", "ground", "it") +
      test::drive("d", "j",
                  fmt::format("proportional = {}\nderivative = {}\ntarget_angle = {}\ntorque_limit = {}\n",
                              axis.stiffness, axis.damping, axis.target, axis.limit)) +
      test::run_for(duration, "start = \"given\"\n");
  for (const auto& way : all_ways) {
    INFO(way.name);
    const auto rows = rows_of(way, text, duration / 40);
    REQUIRE(rows.rows.size() >= 40);
    reference::SwitchedAxis exact;
    exact.J1 = axis.J, exact.kp = axis.stiffness, exact.kd = axis.damping, exact.limit = axis.limit;
    exact.at_load = false, exact.longest = 0.02 / std::sqrt(axis.stiffness / axis.J);
    reference::SwitchedAxis::State y{-axis.target, axis.speed};
    double t = 0;
    CHECK(rows.worst([&](const test::MotionRow& r) {
      y = exact.run(y, r.t - t);
      t = r.t;
      return (r.v[2] - static_cast<double>(y[1])) / pace;
    }) < bound(way));
  }
}

struct Uniform {
  std::mt19937_64 engine;
  double operator()(double a, double b) { return std::uniform_real_distribution(a, b)(engine); }
};

}  // namespace

TEST_CASE("kinks in steps: a narrow drive against speed holds a braked slider in every scheme") {
  check_speed(false, 1, 1, {{-10, -1}, {0.499, -1}, {0.5, 1}, {0.501, -1}, {10, -1}}, 2, 1);
}

TEST_CASE("kinks in steps: random tables against speed with pieces of 1e-4 to 1e-1 of the range") {
  Uniform uniform{std::mt19937_64(20261128)};
  for (int n = 0; n < 6; ++n) {
    INFO("scene " << n);
    const double m = std::pow(10, uniform(-2, 2)), V = std::pow(10, uniform(-1, 1)),
                 width = V * std::pow(10, uniform(-4, -1));
    std::vector<reference::SpeedCurve::Knot> knots{{-3 * V, m * V * uniform(-1, 1)}};
    std::vector<double> places;
    for (int k = 0; k < 5; ++k) places.push_back(uniform(-V, V));
    std::ranges::sort(places);
    for (const double v : places) {
      if (v - knots.back().v < 4 * width) continue;
      const double force = m * V * uniform(-1, 1);
      if (uniform(0, 1) < 0.6)
        for (const double side : {-1, 0, 1})
          knots.push_back({v + side * width, side == 0 ? m * V * uniform(-2, 2) : force});
      else
        knots.push_back({v, force});
    }
    knots.push_back({3 * V, m * V * uniform(-1, 1)});
    check_speed(n % 2 == 1, m, uniform(-V, V), knots, uniform(1, 4), V);
  }
}

TEST_CASE("kinks in steps: a controller with a narrow linear zone, and a saturated one of great gain") {
  check_controller({9.852780376729157, 1735.357782308705, 0, 0.06940249334480664, 10.23785577439855},
                   5.365314374424757);
  check_controller({0.0028226615166461874, 9085.475527864346, 44.42911172701613 * 0.04, 0.02052527265518027,
                    0.008194846600754481, 0.1594812152315423},
                   0.5624332614809124);
}

TEST_CASE("kinks in steps: random saturated controllers") {
  Uniform uniform{std::mt19937_64(20261129)};
  for (int n = 0; n < 6; ++n) {
    INFO("scene " << n);
    const double J = std::pow(10, uniform(-3, 2)), w = std::pow(10, uniform(0, 2)), k = J * w * w,
                 d = n % 2 == 0 ? 0 : 2 * uniform(0.02, 0.9) * J * w, target = std::pow(10, uniform(-2, 0)),
                 limit = k * target * std::pow(10, uniform(-2.5, -0.3));
    check_controller({J, k, d, target, limit, uniform(-0.2, 0.2) * target * w},
                     6 * std::sqrt(2 * target * J / limit));
  }
}

TEST_CASE("a speed follows and leaves a flank of its curve at any size of the mechanism", "[cross][kinks]") {
  // A spring drives a slider along a falling flank 4e-5 m/s wide until the flank ends. Powers of two
  // only change exponents. Expected: products of matrix exponentials of the pieces, with borders bisected.
  const double x = -0.05344602545871351, v = -0.14931813027382967;  // m, m/s
  for (const double size : {0x1p-20, 1.0, 0x1p10})
    for (const auto& way : all_ways) {
      CAPTURE(size, way.name);
      const double force = std::pow(size, 4), mass = std::pow(size, 3);
      std::string points;
      const double knots[][2] = {
          {-2.366692287207438, -0.01679445185775615},  {0.07094775063382791, -0.01679445185775615},
          {0.07098486322150457, 0.07484523517265404},  {0.07101667401094172, 0.07484523517265404},
          {0.07105378659861838, -0.01679445185775615}, {2.366692287207438, -0.01679445185775615}};
      for (const auto& k : knots) points += fmt::format("[{:.17g}, {:.17g}], ", k[0] * size, k[1] * force);
      const auto text =
          test::body("it", 0.18299571643338447 * mass, 0.1 * mass * size * size,
                     fmt::format("velocity = [{:.17g}, 0]\n", 0.1688206472886759 * size)) +
          test::guide("j", "ground", "it") + test::drive("d", "j", "force = \"c\"\nagainst = \"speed\"\n") +
          fmt::format("[curves.c]\nshape = \"table\"\npoints = [{}]\n", points) +
          test::spring("k", "ground", "it", {-5 * size, 0}, {}, 1.4852204843047074 * mass, 5 * size) +
          test::run_for(1.3639652692102953, "start = \"given\"\n");
      const auto run = test::finished(test::scene_by(way, text), way.family);
      // thousand steps of 1e-8 of the arm; time stepping as above
      CHECK(run.final_state.q[0] / size == Approx(x).margin(way.stepping() ? 1e-4 : 2e-6).epsilon(0));
      CHECK(run.final_state.v[0] / size == Approx(v).margin(way.stepping() ? 1e-4 : 2e-6).epsilon(0));
    }
}

TEST_CASE("a speed leaves an equilibrium that becomes unstable", "[cross][kinks]") {
  // A spring draws a slider along a falling flank 5e-5 m/s wide, until k x is the greatest force, 5
  // N. The equilibrium goes on along a rising flank with a rate of growth of 1e5/s: a long implicit
  // step damps that growth, and follows it. Expected: a harmonic motion, v = 1 m/s, and again a
  // harmonic motion.
  const std::string text =
      "gravity = [0, 0]\n" + test::body("it", 1, 1, "velocity = [1.01, 0]\n") +
      test::guide("j", "ground", "it") + test::drive("d", "j", "force = \"c\"\nagainst = \"speed\"\n") +
      "[curves.c]\nshape = \"table\"\n"
      "points = [[-9, 0], [0.99995, 0], [1, 5], [1.00005, 0], [9, 0]]\n" +
      test::spring("k", "ground", "it", {-20, 0}, {}, 10, 20) + test::run_for(0.8, "start = \"given\"\n");
  const double omega = std::sqrt(10.0), v0 = 1.01, reached = std::acos(1 / v0) / omega,
               left = reached + 0.5 - v0 / omega * std::sin(omega * reached), phase = omega * (0.8 - left);
  for (const auto& way : all_ways) {
    INFO(way.name);
    const auto run = test::finished(test::scene_by(way, text), way.family);
    // 5e-5 of the speed for 0.5 s, and growth from rounding to 1 m/s within 3e-4 s. Adaptive time
    // stepping as above.
    const double bound = way.stepping() ? 2e-3 : 5e-4;
    CHECK(std::abs(run.final_state.q[0] - 0.5 * std::cos(phase) - std::sin(phase) / omega) < bound);
    CHECK(std::abs(run.final_state.v[0] + 0.5 * omega * std::sin(phase) - std::cos(phase)) < 10 * bound);
  }
}

// Steps of the integrators against closed forms. A force or a prescribed position read from a curve
// is neither stepped over nor missing in the energy balance, in any integrator.

namespace {

/// A drive of the slider by a harmonic force of 10 N.
std::string harmonic_push(double frequency) {
  return test::harmonic("push", 10, 1 / frequency) + test::drive("push", "guide", "force = \"push\"\n");
}

/// A slider of 2 kg on a guide along x, and the elements acting on it.
Scene slider(const std::string& more, double speed, const std::vector<std::string>& sets) {
  return parse_scene(test::body("slider", 2.0, 1.0, fmt::format("velocity = [{}, 0]\n", speed)) +
                         test::guide("guide", "ground", "slider") + more,
                     "slider.toml", sets);
}

}  // namespace

TEST_CASE("a step with a non-finite component is refused", "[integrators]") {
  ErrorNorm norm;
  norm.absolute = {1, 1};
  norm.relative = {0, 0};
  norm.tolerance = 1e-8;
  int algebra = 0;
  const Vector x{0, 0, 0};
  const auto error = [&](Vector e) { return norm.error(algebra, x, x, e, 0.1); };
  CHECK(error({1e-9, 2e-9, 5}) == Approx(0.2));  // the third component is not part of the norm
  for (const double bad : {double(NAN), double(INFINITY)})
    for (std::size_t i = 0; i < 3; ++i) {
      Vector e{0, 0, 0};
      e[i] = bad;
      CAPTURE(bad, i);
      CHECK(error(e) == 1e10);
    }
  CHECK(AdamsAdjuster{1e-8}.next(1, 1.0, NAN) < 1e-3);
}

TEST_CASE("a smooth force over position does its work in every integrator", "[integrators]") {
  // From zero force at x = 0.5 m to 10 N at 0.8 m: a trial step that reaches far beyond exceeds the
  // range of numbers. ½ m v² = ½ m v₀² + ∫ F dx, and the 3-4-5 polynomial has the mean ½ over its
  // rise.
  for (const auto& profile : {"polynomial", "cycloidal"})
    for (const double from : {0.0, 0.2, 2.0})
      for (const std::string integrator : test::adaptive_integrators)
        for (const double tolerance : {1e-6, 1e-9}) {
          const auto scene =
              slider(fmt::format("[curves.push]\nshape = \"ramp\"\nprofile = \"{}\"\nfrom = {}\nto = 10.0\n"
                                 "start = 0.5\nrise = 0.3\n",
                                 profile, from) +
                         test::drive("push", "guide", "force = \"push\"\nagainst = \"position\"\n") +
                         test::run_for(2.0, "start = \"given\"\n"),
                     1, {"penalty.integrator=" + integrator, fmt::format("penalty.tolerance={}", tolerance)});
          CAPTURE(profile, from, integrator, tolerance);
          const auto run = test::finished(scene, Family::penalty);
          const double x = run.final_state.q[0];
          const double work = from * 0.5 + 0.5 * (from + 10) * 0.3 + 10 * (x - 0.8);
          // Some hundred steps at the tolerance, at speeds of up to 10 m/s.
          CHECK(run.final_state.v[0] == Approx(std::sqrt(1 + work)).epsilon(0).margin(1e3 * tolerance));
          CHECK_THAT(notes_of(run), !Contains("warning: "));
        }
}

TEST_CASE("the damper of a bump stop dissipates the energy of its closed form", "[integrators][compliant]") {
  // m ÿ + c ẏ + k y = 0 from y = 0, ẏ = v: y = v/ω_d e^(−at) sin ω_d t. The stop separates where k
  // y + c ẏ = 0, tan ω_d t = 2 a ω_d/(a² − ω_d² + ... ): found by bisection of the closed form;
  // then the slider moves freely.
  const double m = 2, v = 1, at = 0.1;
  for (const double k : {2000.0, 2e5})
    for (const double share : {0.05, 0.3, 0.8}) {  // of critical damping
      const double w = std::sqrt(k / m), a = share * w, c = 2 * m * a, d = std::sqrt(w * w - a * a);
      const auto y = [&](double t) { return v / d * std::exp(-a * t) * std::sin(d * t); };
      const auto rate = [&](double t) {
        return v * std::exp(-a * t) * (std::cos(d * t) - a / d * std::sin(d * t));
      };
      double low = 0, high = pi / d;  // compressive at first, tensile at last
      for (int i = 0; i < 200; ++i) {
        const double t = 0.5 * (low + high);
        (k * y(t) + c * rate(t) > 0 ? low : high) = t;
      }
      const double off = rate(low), loss = 0.5 * m * (v * v - off * off);
      const double x = at + y(low) + off * (0.3 - at / v - low);
      for (const std::string integrator : test::adaptive_integrators)
        for (const double tolerance : {1e-7, 1e-9}) {
          const auto run = test::finished(
              slider(
                  fmt::format("[loads.stop]\ntype = \"bump-stop\"\nbetween = [\"ground\", \"slider\"]\nat = "
                              "[[0, 0], [0, 0]]\naxis = [1, 0]\nupper = {}\nstiffness = {}\ndamping = "
                              "{:.17g}\n[run]\nduration = 0.3\nstart = \"given\"\n",
                              at, k, c),
                  v, {"penalty.integrator=" + integrator, fmt::format("penalty.tolerance={}", tolerance)}),
              Family::penalty);
          CAPTURE(k, share, integrator, tolerance, notes_of(run), run.ledger.closure());
          // A hundred steps at the tolerance, of 1 m/s and 1 J; the force has a kink where the stop
          // separates.
          const double bound = 300 * tolerance;
          CHECK(run.final_state.v[0] == Approx(off).margin(bound).epsilon(0));
          CHECK(run.final_state.q[0] == Approx(x).margin(bound).epsilon(0));
          CHECK(run.ledger.damping == Approx(loss).margin(bound).epsilon(0));
          CHECK_THAT(notes_of(run), !Contains("warning: "));
        }
    }
}

TEST_CASE("a motion that ends near rest is assessed by the energy that it exchanged", "[assess]") {
  // F = A sin ωt on a mass at rest: v = A/(m ω) (1 − cos ωt), at rest again after each period.
  const double A = 10, m = 2, f = 20, w = 2 * pi * f;
  const auto driven = [&](const std::vector<std::string>& sets) {
    return slider(harmonic_push(f) + test::run_for(10 / f, "start = \"given\"\n"), 0, sets);
  };
  const auto assess = [&](const Result& run) {
    REQUIRE(run.ending.status == Ending::Status::finished);
    const double most = 2 * A / (m * w), energy = 0.5 * m * most * most;  // m/s, J
    CAPTURE(notes_of(run), run.final_state.v[0], run.ledger.closure(), run.ledger.passed);
    CHECK(run.ledger.scale() < 1e-3 * energy);  // zero remains
    CHECK(run.ledger.passed == Approx(energy).epsilon(0.05));
    CHECK(std::abs(run.final_state.v[0]) < 1e-4 * most);
    CHECK_THAT(notes_of(run), !Contains("warning: "));
  };
  for (const std::string integrator : test::adaptive_integrators)
    assess(test::simulate(driven({"penalty.integrator=" + integrator}), Family::penalty));
  assess(test::simulate(driven({"penalty.integrator=rk4", "penalty.step=1e-4"}), Family::penalty));
  for (const auto& scheme : {"event-driven", "automatic"})
    assess(test::simulate(driven({fmt::format("nonsmooth.scheme={}", scheme)}), Family::nonsmooth));
  assess(test::simulate(driven({"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-4"}), Family::nonsmooth));
}

TEST_CASE("a force that alternates at 3000 Hz is followed for a second", "[integrators][curves]") {
  // x = A/(m ω) t at whole periods, at rest: the permitted speed error of a step refers to the
  // impulse of the force, 2A/ω, not to the effect of the greatest force over the lever arm.
  const double A = 10, m = 2, w = 2 * pi * 3000, size = A / (m * w);
  for (const auto* integrator : {"adams_bashforth_moulton", "rosenbrock4"}) {
    const auto run = test::finished(slider(harmonic_push(3000) + test::run_for(1.0, "start = \"given\"\n"), 0,
                                           {fmt::format("penalty.integrator={}", integrator)}),
                                    Family::penalty);
    CAPTURE(integrator, notes_of(run), run.final_state.q[0] / size - 1, run.final_state.v[0] / size);
    // 1e-8 a step at the scale of 1e-3 m/s (tolerance.hpp), in 6e4 steps whose errors follow the
    // sine's sign: a hundred of them.
    CHECK(run.final_state.q[0] == Approx(size).epsilon(4e-6));
    CHECK(std::abs(run.final_state.v[0]) < 4e-6 * size);
    CHECK_THAT(notes_of(run), !Contains("warning: "));
  }
}

TEST_CASE("a fixed step settles where large forces balance near rest", "[curves]") {
  // 125 N against a spring of 64 N/m with a damper of 2 N s/m: near rest only rounding remains, 500
  // times below the step of mass/damping that the message used to name.
  const auto run = test::simulate(
      parse_scene(
          "gravity = [0, -9.81]\n" + test::body("slider", 0.1059, 1.0) +
              test::guide("guide", "ground", "slider") +
              "[curves.push]\nshape = \"ramp\"\nfrom = 28.99\nto = -124.8\nstart = 0.3261\n"
              "rise = 0.2273\n" +
              test::drive("push", "guide", "force = \"push\"\n") +
              test::spring("spring", "ground", "slider", {-1, 0}, {0, 0}, 63.63, 1, "damping = 2.224\n") +
              test::run_for(4.0, "start = \"given\"\n") + R"([nonsmooth]
scheme = "moreau-jean"
step = 1e-4
)",
          "slider.toml"),
      Family::nonsmooth);
  CAPTURE(run.ending.reason);
  CHECK(run.ending.status == Ending::Status::finished);
  CHECK(std::abs(run.final_state.v[0]) < 1e-6);
}

TEST_CASE("fehlberg78 is refused with the name of its replacement", "[errors]") {
  CHECK_THROWS_WITH(slider("[run]\nduration = 1\n[penalty]\nintegrator = \"fehlberg78\"\n", 1, {}),
                    Contains("slider.toml:13:14: penalty.integrator: \"fehlberg78\" has been removed") &&
                        Contains("use \"bulirsch_stoer\""));
}
