// Lyapunov exponents of a basin with two periodic attractors: against closed forms, against a
// single run from the same start, and divided into shards.
#include "analysis/lyapunov.hpp"
#include "verification/support/ball_study.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

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

constexpr const char* rotor_basin = R"(scene = "scene.toml"
[axes.angle]
key = "bodies.rotor.angle"
values = [-0.002, 0]
[axes.speed]
key = "bodies.rotor.angular_velocity"
values = [-0.45, 0.5]
[basin]
x = "angle"
y = "speed"
section = "every period"
columns = ["axle.angle"]
discard = 100
keep = 12
exponents = true
)";

struct Cell {
  double angle = 0, speed = 0, attractor = 0, period = 0, exponent = 0;
};

std::vector<Cell> cells_of(const std::string& csv) {
  std::istringstream rows(csv);
  std::string line;
  std::getline(rows, line);
  CHECK(line == "x,y,attractor,period,axle.angle,exponent,exponent_error");
  std::vector<Cell> list;
  while (std::getline(rows, line)) {
    std::array<double, 7> v{};
    std::istringstream fields(line);
    for (auto& value : v) {
      std::string field;
      std::getline(fields, field, ',');
      value = std::stod(field);
    }
    list.push_back({v[0], v[1], v[2], v[3], v[5]});
  }
  return list;
}

}  // namespace

TEST_CASE("exponents of a basin are those of runs from the same starts, also divided",
          "[attractors][lyapunov]") {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "scene.toml", stopped_rotor());
  write_file(folder.path() / "study.toml", rotor_basin);
  const auto basin = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"basin", (folder.path() / "study.toml").string()};
    words.insert(words.end(), more.begin(), more.end());
    const auto run = test::BallStudy::run(words);
    INFO(run.out << run.err);
    REQUIRE(run.status == 0);
  };
  const auto one = (folder.path() / "one").string(), divided = (folder.path() / "divided").string();
  basin({"-o", one});
  basin({"--plan", "2", "-o", divided});
  basin({"--shard", "2/2", "-o", divided});
  basin({"--shard", "1/2", "-o", divided});
  basin({"--merge", divided});
  basin({"-o", divided});
  const auto csv = test::file_text(folder.path() / "one/basin.csv");
  CHECK(test::file_text(folder.path() / "divided/basin.csv") == csv);

  const auto cells = cells_of(csv);
  REQUIRE(cells.size() == 4);
  bool is_impact[2] = {};
  for (const auto& cell : cells) {
    CAPTURE(cell.angle, cell.speed);
    CHECK(cell.period == 1);
    const auto scene = read_scene(folder.path() / "scene.toml",
                                  {fmt::format("bodies.rotor.angle={:.17g}", cell.angle),
                                   fmt::format("bodies.rotor.angular_velocity={:.17g}", cell.speed)});
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
    CHECK(cell.exponent == Approx(expected).epsilon(1e-8));
    CHECK(found.exponents[0].value == Approx(cell.exponent).epsilon(1e-8));
    CHECK(averaged.sum / 2 == Approx(cell.exponent).epsilon(1e-8));
  }
  CHECK(is_impact[false]);
  CHECK(is_impact[true]);
}
