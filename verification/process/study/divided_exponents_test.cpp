// Lyapunov exponents of attractors by the commands, whole and divided into shards: of a basin with two
// periodic attractors against closed forms and single runs, of a bifurcation diagram; and work that cannot be
// divided.
#include "analysis/lyapunov.hpp"
#include "verification/support/columns.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// A torsional oscillator with a stop, of verification/references/orbits.hpp (ImpactOscillator): J,
/// c, k, e and the frequency of the torque. Its steady oscillation and a motion with one impact per
/// period coexist.
constexpr double inertia = 0.5, damping = 1, restitution = 0.7, frequency = 30;
constexpr double period_of_torque = 2 * std::numbers::pi / frequency;

std::string stopped_rotor() {
  return test::body("rotor", 1, inertia) + test::pin("axle", "ground", "rotor") +
         test::torsion("spring", "ground", "rotor", 200, fmt::format("damping = {}\n", damping)) +
         test::stop("stop", "angle-stop", "axle", "radius = 0.1\nupper = 0.02\n", "hard") +
         test::surface("hard", restitution) + test::harmonic("torque", 4, period_of_torque) +
         test::drive("shaker", "axle", "torque_curve = \"torque\"\nagainst = \"time\"\n") +
         test::run_for(104 * period_of_torque, "start = \"given\"\n") +
         "[nonsmooth]\nscheme = \"event-driven\"\ntolerance = 1e-10\n";
}

std::string rotor_basin() {
  return "scene = \"scene.toml\"\n" + test::axis("angle", "bodies.rotor.angle", "-0.002, 0") +
         test::axis("speed", "bodies.rotor.angular_velocity", "-0.45, 0.5") +
         "[basin]\nx = \"angle\"\ny = \"speed\"\nsection = \"every period\"\ncolumns = [\"axle.angle\"]\n"
         "discard = 100\nkeep = 12\nexponents = true\n";
}

std::string case_scene(const char* name) {
  return (test::source_folder() / "cases" / name / "scene.toml").string();
}

/// Two strengths of shaking, swept up and down: two units of a division.
std::string ball_study() {
  return fmt::format(
      "scene = \"{}\"\n[axes.strength]\nkey = \"curves.shake.amplitude\"\nvalues = [0.6e-3, 1.065e-3]\n"
      "[bifurcation]\nsection = \"each touch\"\ncolumns = [\"phase\", \"approach\"]\ndiscard = 60\n"
      "keep = 20\n"
      "exponents = true\nset = ['joints.rail.type=\"translational\"', "
      "'joints.rail.between=[\"ground\", \"ball\"]', 'joints.rail.axis=[0, 1]', "
      "'nonsmooth.scheme=\"event-driven\"']\n",
      case_scene("ball-on-table"));
}

}  // namespace

TEST_CASE("exponents of a basin are those of runs from the same starts, also divided",
          "[attractors][lyapunov]") {
  const test::StudyDesk desk;
  desk.put("scene.toml", stopped_rotor());
  desk.put("study.toml", rotor_basin());
  const auto basin = [&](const std::string& options) {
    return test::succeeded(fmt::format("basin {} {}", desk.at("study.toml").string(), options)).out;
  };
  const auto one = desk.at("one").string(), divided = desk.at("divided").string();
  basin("-o " + one);
  for (const char* options : {"--plan 2 -o ", "--shard 2/2 -o ", "--shard 1/2 -o ", "--merge "})
    basin(options + divided);
  CHECK_THAT(basin("-o " + divided), Contains("from the store, 0 new"));
  for (const char* file : {"basin.csv", "basin.json"})
    CHECK(test::file_text(desk.at("divided") / file) == test::file_text(desk.at("one") / file));

  const test::Columns cells(desk.at("one/basin.csv"));
  CHECK(cells.header() == "x,y,attractor,period,axle.angle,exponent,exponent_error");
  REQUIRE(cells.rows() == 4);
  bool is_impact[2] = {};
  for (std::size_t i = 0; i < cells.rows(); ++i) {
    const double angle = cells.at(i, "x"), speed = cells.at(i, "y"), exponent = cells.at(i, "exponent");
    CAPTURE(angle, speed);
    CHECK(cells.at(i, "period") == 1);
    const auto scene =
        read_scene(desk.at("scene.toml"), {fmt::format("bodies.rotor.angle={:.17g}", angle),
                                           fmt::format("bodies.rotor.angular_velocity={:.17g}", speed)});
    LyapunovRequest request{.batches = 4, .transient = 100 * period_of_torque};
    const auto averaged = lyapunov(scene, request);
    request.cycle = period_of_torque;
    const auto found = lyapunov(scene, request);
    REQUIRE(averaged.failure.empty());
    REQUIRE(found.failure.empty());
    REQUIRE(found.exponents.size() == 2);
    const bool impact = found.impacts > 0;
    is_impact[impact] = true;
    // Both multipliers are complex and have equal moduli: half the logarithm of the determinant, to which the
    // damper contributes −c/J per time and an impact 2 ln e. Bound: eight digits, with a tolerance of 1e-10.
    const double expected = -damping / inertia / 2 + (impact ? std::log(restitution) / period_of_torque : 0);
    CHECK(exponent == Approx(expected).epsilon(1e-8));
    CHECK(found.exponents[0].value == Approx(exponent).epsilon(1e-8));
    CHECK(averaged.sum / 2 == Approx(exponent).epsilon(1e-8));
  }
  CHECK(is_impact[false]);
  CHECK(is_impact[true]);
}

TEST_CASE("a bifurcation diagram with exponents in shards has the tables of one process",
          "[shards][lyapunov]") {
  const test::TemporaryFolder folder;
  const auto place = folder.path().string();
  write_file(folder.path() / "study.toml", ball_study());
  const auto run = [&](const std::string& options) {
    test::succeeded("bifurcation " + place + "/study.toml --allow-outside " + options);
  };
  run("-o " + place + "/one");
  for (const char* options : {"--plan 2 -o ", "--shard 2/2 -o ", "--shard 1/2 -o ", "--merge ", "-o "})
    run(options + place + "/two");
  for (const char* file : {"bifurcation.csv", "bifurcation.json"}) {
    const auto one = test::file_text(folder.path() / "one" / file);
    CHECK_THAT(one, Contains("exponent"));
    CHECK(test::file_text(folder.path() / "two" / file) == one);
  }
}

TEST_CASE("work that cannot be divided is refused with the reason", "[shards][errors]") {
  const auto branches = (test::source_folder() / "cases/ball-on-table/branches.toml").string();
  const test::TemporaryFolder folder;
  const auto place = folder.path().string();
  for (const auto& [command, answer] :
       {std::pair{"continue " + branches + " --plan 2 -o " + place,
                  "--plan: a continuation cannot be divided, because each motion of a branch starts"},
        {"lyapunov " + case_scene("impact-oscillator") + " --shard 1/2 -o " + place,
         "--shard: lyapunov cannot be divided; sweep, bifurcation, basin, calibrate and ensemble can"},
        {"sweep " + branches + " --plan 2 -o " + place, "continue: the study has no axes to sweep"},
        {"sweep " + branches + " -o " + place, "continue: the study has no axes to sweep"}}) {
    test::refused(command, Contains(answer));
    CHECK(std::filesystem::is_empty(folder.path()));
  }
}
