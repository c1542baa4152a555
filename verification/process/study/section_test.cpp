// Poincaré sections: the exact place of their points within steps, and the independence of a run
// from its section.
#include <boost/math/special_functions/ellint_1.hpp>

#include "study/runs/section_run.hpp"
#include "verification/references/orbits.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr double pi = std::numbers::pi;

struct Way {
  const char *formulation, *set;
  double accuracy;  ///< of a smooth motion over seconds, relative
  /// With a step of time stepping.
  std::vector<std::string> sets(const char* step) const {
    return std::string(set).ends_with("moreau-jean\"") ? std::vector<std::string>{set, step}
                                                       : std::vector<std::string>{set};
  }
};
/// Penalty and event-driven runs keep their tolerances of 1e-9 and better over the runs here;
/// Moreau–Jean is of second order, (ωh)²/24 of a period and as much again in the state.
const Way ways[] = {{"penalty", "penalty.tolerance=1e-10", 1e-6},
                    {"nonsmooth", "nonsmooth.scheme=\"automatic\"", 1e-6},
                    {"nonsmooth", "nonsmooth.scheme=\"event-driven\"", 1e-6},
                    {"nonsmooth", "nonsmooth.scheme=\"moreau-jean\"", 1e-5}};

const std::string oscillator =
    test::body("mass", 2.0, 1.0, "position = [0.3, 0.0]\n") + test::guide("guide", "ground", "mass") +
    test::spring("spring", "ground", "mass", {-1, 0}, {0, 0}, 50.0, 1.0, "damping = 4.0\n") +
    "[loads.push]\ntype = \"force\"\nbody = \"mass\"\nforce = [3.0, 0.0]\n"
    "factor = \"wave\"\n" +
    test::harmonic("wave", 1.0, 2.0) + test::run_for(40, "discard = 30\nstart = \"given\"\n");

const std::string swing = "gravity = [0, -9.81]\n" + test::body("bar", 1.0, 0.03, "position = [0.3, 0.0]\n") +
                          test::pin("pivot", "ground", "bar", {0, 0}, {-0.3, 0}) +
                          test::run_for(10, "start = \"given\"\n");

SectionRun section_of(const Scene& scene, const char* formulation, const std::string& section,
                      std::vector<std::string> columns) {
  return SectionSimulation(
             scene, {.formulation = formulation, .section = section, .columns = std::move(columns)}, {})
      .run();
}

}  // namespace

TEST_CASE("the section of a driven oscillator converges to one point", "[section]") {
  // m x'' + c x' + k x = F sin ωt: x = X sin(ωt − φ), X = F/√((k − mω²)² + (cω)²), tan
  // φ = cω/(k − mω²). The transient decays as e^{−t}: 1e-13 of it is left after the 30 s that are
  // discarded.
  const double omega = pi, m = 2, c = 4, k = 50, f = 3;
  const double x = f / std::hypot(k - m * omega * omega, c * omega);
  const double phi = std::atan2(c * omega, k - m * omega * omega);
  for (const auto& way : ways) {
    CAPTURE(way.formulation, way.set);
    const auto scene = parse_scene(oscillator, "oscillator", way.sets("nonsmooth.step=1e-3"));
    const auto run = section_of(scene, way.formulation, "every period", {"mass.x", "mass.vx", "phase"});
    REQUIRE(run.size() == 6);  // 30, 32, … 40 s
    for (std::size_t i = 0; i < run.size(); ++i) {
      CHECK(run.t[i] == 30 + 2.0 * static_cast<double>(i));
      CHECK(run.at(i, 0) == Approx(-x * std::sin(phi)).margin(way.accuracy * x));
      CHECK(run.at(i, 1) == Approx(x * omega * std::cos(phi)).margin(way.accuracy * x * omega));
      CHECK(run.at(i, 2) == 0);
    }
  }
}

TEST_CASE("a prescribed crank crosses an angle once in every revolution, at the exact time", "[section]") {
  // 200 rpm from 0: 30° at (30/360 + k) · 0.3 s, to the rounding of a root of a line.
  for (const auto& way : ways) {
    CAPTURE(way.formulation, way.set);
    auto scene = read_scene(test::flores(), {way.set, "run.revolutions=3", "run.discard=0"});
    const auto run =
        section_of(scene, way.formulation, "main.angle crosses 30 deg upwards", {"main.angle", "main.rate"});
    REQUIRE(run.size() == 3);
    for (std::size_t i = 0; i < run.size(); ++i) {
      // Baumgarte stabilisation permits an error of a driven angle of the order of its tolerance.
      CHECK(run.t[i] == Approx((1.0 / 12 + static_cast<double>(i)) * 0.3).margin(1e-8));
      CHECK(run.at(i, 0) == Approx(pi / 6).margin(1e-12));
      CHECK(run.at(i, 1) == Approx(2 * pi / 0.3).epsilon(1e-7));
    }
    CHECK(section_of(scene, way.formulation, "main.angle crosses 30 deg downwards", {"phase"}).size() == 0);
    CHECK(section_of(scene, way.formulation, "main.angle crosses 30 deg", {"phase"}).size() == 3);
  }
}

TEST_CASE("a pendulum's section lies on its energy curve", "[section]") {
  // Released at the horizontal: at the angle φ below it, ½ J θ'² = m g l sin φ; at the bottom,
  // θ' = ±√(2 m g l/J). From one crossing upwards to the next is the period 4 K(sin(90°/2)) √(J/(m
  // g l)).
  const double mgl = 9.81 * 0.3, j = 0.03 + 0.09;
  const double period = 4 * boost::math::ellint_1(std::sin(pi / 4)) * std::sqrt(j / mgl);
  for (const auto& way : ways) {
    CAPTURE(way.formulation, way.set);
    const auto scene = parse_scene(swing, "swing", way.sets("nonsmooth.step=1e-4"));
    const auto low =
        section_of(scene, way.formulation, "pivot.angle crosses -90 deg", {"pivot.angle", "pivot.rate"});
    REQUIRE(low.size() >= 12);
    const double after = 100 * way.accuracy;  // accumulated error of the period over the run
    for (std::size_t i = 0; i < low.size(); ++i) {
      CHECK(low.at(i, 0) == Approx(-pi / 2).margin(1e-12));
      CHECK(low.at(i, 1) == Approx((i % 2 ? 1 : -1) * std::sqrt(2 * mgl / j)).epsilon(way.accuracy));
      CHECK(low.t[i] == Approx((0.25 + 0.5 * static_cast<double>(i)) * period).margin(after * period));
    }
    const auto up = section_of(scene, way.formulation, "pivot.angle crosses -30 deg upwards", {"pivot.rate"});
    REQUIRE(up.size() >= 6);
    for (std::size_t i = 0; i < up.size(); ++i)
      CHECK(up.at(i, 0) == Approx(std::sqrt(2 * mgl * 0.5 / j)).epsilon(2 * way.accuracy));
  }
}

TEST_CASE("a position on a turning guide is a coordinate of sections", "[section]") {
  // Without friction on a guide that turns at Ω: s'' = Ω² s. Released at rest on the guide at s₀,
  // s = s₀ cosh Ωt: it passes 2 s₀ at t = arcosh(2)/Ω, at the rate √3 Ω s₀. An error at the start grows at
  // most twofold until then.
  const double omega = 2, from = 0.1;
  const std::string text =
      test::body("b", 1.0, 1.0, "position = [0.0, 0.0]\nangular_velocity = 2.0\n") +
      test::body("c", 1.0, 1.0, "position = [0.1, 0.0]\nvelocity = [0.0, 0.2]\nangular_velocity = 2.0\n") +
      test::pin("pivot", "ground", "b") + test::guide("guide", "b", "c") +
      test::motor("spin", "pivot", omega) + test::run_for(1, "discard = 0\nstart = \"given\"\n");
  for (const auto& way : ways) {
    CAPTURE(way.formulation, way.set);
    const auto scene = parse_scene(text, "guide", way.sets("nonsmooth.step=1e-4"));
    const auto run = section_of(scene, way.formulation, "guide.position crosses 200 mm upwards",
                                {"guide.position", "guide.rate"});
    REQUIRE(run.size() == 1);
    CHECK(run.t[0] == Approx(std::acosh(2.0) / omega).epsilon(4 * way.accuracy));
    CHECK(run.at(0, 0) == Approx(2 * from).margin(1e-12));
    CHECK(run.at(0, 1) == Approx(std::sqrt(3.0) * omega * from).epsilon(4 * way.accuracy));
  }
}

TEST_CASE("a motion that reverses within a step gives two crossings or none", "[section]") {
  // An undamped oscillator reaches X = 0.3 m at whole periods: it is above X(1 − 1e-6) for
  // 2√(2e-6)/ω = 5.7e-4 s around them, far within a step of the integrator. The error over 10 s, of
  // some thousand steps of 1e-10 each, changes that time by a twentieth.
  const std::vector<std::string> set = {"loads.spring.damping=0",  "loads.push.force=[0,0]",
                                        "run.discard=0",           "run.duration=10",
                                        "penalty.tolerance=1e-10", "nonsmooth.tolerance=1e-10"};
  const auto text = test::replaced(test::replaced(oscillator, "factor = \"wave\"\n", ""),
                                   test::harmonic("wave", 1.0, 2.0), "");
  const double omega = 5, inside = std::sqrt(2e-6) / omega;
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    CAPTURE(formulation);
    const auto scene = parse_scene(text, "oscillator", set);
    const auto run = section_of(scene, formulation, "mass.x crosses 0.2999997 m", {"mass.vx"});
    CHECK(run.work.steps < 5000);
    REQUIRE(run.size() == 15);  // once after the start, twice in each of seven periods of 1.2566 s
    CHECK(run.t[0] == Approx(inside).epsilon(0.05));
    for (std::size_t i = 1; i < run.size(); ++i) {
      const auto period = (i + 1) / 2;
      const double whole = static_cast<double>(period) * 2 * pi / omega;
      CHECK(run.t[i] - whole == Approx(i % 2 ? -inside : inside).epsilon(0.2));
    }
    CHECK(section_of(scene, formulation, "mass.x crosses 0.3000003 m", {"mass.vx"}).size() == 0);
  }
}

TEST_CASE("impacts of a ball on a shaking table have the phase of the closed form", "[section]") {
  const double gravity = 9.81, omega = std::sqrt(9810.0);
  for (const double e : {0.5, 0.8}) {
    // The orbit at the strength A ω²/g, which is A in mm.
    const auto orbit = [&](double strength) {
      return reference::ShakenBall{strength * 1e-3L, omega, gravity, e};
    };
    const double strength = 500 * static_cast<double>(orbit(1).fold() + orbit(1).flip()),
                 phase = static_cast<double>(orbit(strength).phase()),
                 period = static_cast<double>(orbit(1).period()),
                 approach = static_cast<double>(orbit(1).approach());
    // The table is at the phase of an impact half a period before the start, where the ball is at
    // its top, displaced by a hundredth: the orbit is stable and the deviation decays.
    const double top = 0.01 + strength * 1e-3 * std::sin(phase) + gravity * period * period / 8 * 1.01;
    for (const char* scheme : {"event-driven", "automatic", "moreau-jean"}) {
      CAPTURE(e, scheme);
      const auto scene = read_scene(test::source_folder() / "cases/ball-on-table/scene.toml",
                                    {"curves.shake.amplitude=" + std::to_string(strength * 1e-3),
                                     "curves.shake.phase=" + std::to_string(phase + pi),
                                     "surfaces.hard.restitution=" + std::to_string(e), "run.duration=13",
                                     "run.discard=12", "bodies.ball.position=[0," + std::to_string(top) + "]",
                                     std::string("nonsmooth.scheme=\"") + scheme + "\"",
                                     scheme[0] == 'm' ? "nonsmooth.step=1e-5" : "run.duration=13"});
      const auto run =
          section_of(scene, "nonsmooth", "each touch of top", {"phase", "approach", "ball.vy", "table.vy"});
      // One in every period, within a second.
      REQUIRE(run.size() >= 15);
      REQUIRE(run.size() <= 16);
      // std::to_string keeps six decimals: 1e-6/4e-4 of the amplitude, an error of 2e-3; the orbit
      // is that of the rounded value.
      const double set = std::stod(std::to_string(strength * 1e-3)) * 1e3,
                   at = static_cast<double>(orbit(set).phase());
      const double started = std::stod(std::to_string(phase + pi));
      const double accuracy =
          scheme[0] == 'm' ? 2e-3 : 1e-6;  // a step of time stepping is 1e-5 · ω = 1e-3 of phase
      for (std::size_t i = 0; i < run.size(); ++i) {
        const double share = std::remainder(2 * pi * run.at(i, 0) + started - at, 2 * pi);
        CHECK(share == Approx(0).margin(accuracy));
        CHECK(run.at(i, 1) == Approx(approach).epsilon(accuracy));
        // Before the impact: the table rises at V, the ball falls at g T/2.
        CHECK(run.at(i, 2) == Approx(-gravity * period / 2).epsilon(accuracy));
        CHECK(run.at(i, 3) == Approx(gravity * period / 2 * (1 - e) / (1 + e)).epsilon(5 * accuracy));
      }
    }
  }
}

TEST_CASE("the state at a contact is that of its onset, also where contact lasts", "[section]") {
  // The gap is zero there: an impact reported after its end is evaluated at its onset.
  auto scene = read_scene(test::flores(), {"run.revolutions=1", "run.discard=0"});
  const auto run = section_of(scene, "penalty", "each touch of gudgeon", {"gudgeon.gap", "approach"});
  const auto whole = Simulation(scene, "penalty").run();
  const auto touches = test::touches(whole);
  REQUIRE(run.size() == touches.size());
  REQUIRE(run.size() > 5);
  for (std::size_t i = 0; i < run.size(); ++i) {
    CHECK(run.t[i] == touches[i].t);
    CHECK(run.at(i, 0) == Approx(0).margin(1e-12));
    CHECK(run.at(i, 1) == -touches[i].v_n_minus);
  }
}

TEST_CASE("a run observed by a section is bit-identical", "[section]") {
  for (const auto& way : ways)
    for (const char* section : {"every period", "every 7.3 ms", "main.angle crosses 1 rad", "each touch"}) {
      CAPTURE(way.formulation, way.set, section);
      const auto scene = read_scene(test::flores(), {way.set, "run.revolutions=1", "run.discard=0"});
      const auto alone = Simulation(scene, way.formulation).run({.keep_events = false});
      const auto run = section_of(scene, way.formulation, section, {});
      CHECK(run.size() > 0);
      CHECK(run.end.q == alone.final_state.q);
      CHECK(run.end.v == alone.final_state.v);
      CHECK(run.work.rhs == alone.work.rhs);
    }
}

TEST_CASE("an invalid section is refused with the valid forms", "[section]") {
  const auto scene = read_scene(test::flores());
  const auto pendulum = parse_scene(swing, "swing");
  struct Case {
    const Scene& scene;
    const char *section, *column, *message;
  };
  for (const auto& [of, section, column, message] :
       {Case{scene, "now and then", "phase", "is not a section"},
        {scene, "every 3 kg", "phase", "must be a time"},
        {scene, "every 0 s", "phase", "greater than 0"},
        {scene, "main.angl crosses 1", "phase", "did you mean main.angle"},
        {scene, "slider.vx crosses 0", "phase", "not a coordinate of a section"},
        {scene, "main.angle crosses upwards", "phase", "needs a value"},
        {scene, "each touch of main", "phase", "gudgeon"},
        {scene, "every period", "slider.z", "not a column"},
        {scene, "every period", "approach", "only for sections"},
        {pendulum, "every period", "phase", "define no period, or several"},
        {pendulum, "each touch", "phase", "no contacts"}})
    CHECK_THAT(test::refusal_of([&] { section_of(of, "nonsmooth", section, {column}); }),
               Catch::Contains(message));
}

TEST_CASE("a section with more points than can be stored is refused before the run", "[section][errors]") {
  const auto scene = (test::source_folder() / "cases/ball-on-table/scene.toml").string();
  const test::TemporaryFolder folder;
  test::refused("poincare " + scene + " --section 'every 1e-9 s' -o " + (folder.path() / "out").string(),
                Catch::Matchers::Contains("--section") && Catch::Matchers::Contains("1000000 are kept"));
  CHECK(!std::filesystem::exists(folder.path() / "out"));
}

TEST_CASE("a section of impossibly short or long runs is refused", "[section][errors]") {
  const auto scene = read_scene(test::source_folder() / "cases/ball-on-table/scene.toml");
  for (const auto& [keep, discard] : {std::pair{1e-308, 0.0}, {1e-320, 0.0}, {1.0, 1e-300}, {1.0, 1e200}}) {
    const SectionRequest request{.section = "every period",
                                 .discard = discard,
                                 .keep = keep,
                                 .section_key = "s",
                                 .periods_key = "periods"};
    CHECK_THAT(test::refusal_of([&] { SectionSimulation(scene, request, {}); }),
               Catch::Contains("periods: makes a duration of"));
  }
}

TEST_CASE("poincare writes its points, its provenance and a figure, or nothing", "[section][figures]") {
  const test::TemporaryFolder folder;
  const auto out = folder.path() / "out";
  const auto scene = (test::source_folder() / "cases/ball-on-table/scene.toml").string();
  test::refused("poincare " + scene + " --section 'each tuch' -o " + out.string(),
                Catch::Contains("--section: ") && Catch::Contains("is not a section"));
  CHECK_FALSE(std::filesystem::exists(out));
  const auto good = test::succeeded("poincare " + scene +
                                    " --section 'each touch' --periods 5 --discard 10 -o " + out.string());
  CHECK_THAT(good.out, Catch::Contains("5 points of \"each touch\""));
  for (const char* file : {"section.csv", "section.json", "figures/poincare.pdf", "figures/poincare.png"})
    CHECK(std::filesystem::exists(out / file));
}

TEST_CASE("figures of an empty section state that it is empty", "[section][figures]") {
  const test::TemporaryFolder folder;
  const auto source = test::source_folder() / "cases/ball-on-table/scene.toml";
  const auto script = [&](const std::string& line, const char* file) {
    test::succeeded(line + " -o " + (folder.path() / "out").string());
    return test::file_text(folder.path() / "out/figures" / file);
  };
  const auto said = Catch::Contains("'no point of the section'");
  CHECK_THAT(script("poincare " + source.string() + " --section 'every 1000 s'", "poincare.gp"), said);
  // A table that accelerates downwards at a hundredth of g does not throw the ball: it rests, at
  // every strength.
  std::filesystem::copy_file(source, folder.path() / "scene.toml");
  write_file(
      folder.path() / "study.toml",
      "scene = \"scene.toml\"\n[axes.strength]\nkey = \"curves.shake.amplitude\"\nvalues = [1e-5, 2e-5]\n"
      "[bifurcation]\nsection = \"each touch\"\ndiscard = 200\nkeep = 2\n");
  const auto drawn = script("bifurcation " + (folder.path() / "study.toml").string(), "bifurcation.gp");
  CHECK_THAT(drawn, said && Catch::Contains("no points (at the bottom)"));
}
