// Steps of the integrators against closed forms. A force or a prescribed position read from a curve
// is neither stepped over nor missing in the energy balance, in any integrator.
#include "formulations/integrators/adams.hpp"
#include "formulations/integrators/methods.hpp"
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using std::numbers::pi;
using test::notes_of;

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
