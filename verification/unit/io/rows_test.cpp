// Times of rows are multiples of the output step by their index, and the last row is exactly at the
// end time.
#include "facade/run_folder.hpp"
#include "simulation/trajectory.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// A rod on an ideal pivot: one set of rows, long steps.
Scene rod(double duration, const std::string& more = "") {
  auto scene =
      parse_scene("gravity = [0.0, -9.81]\n" + test::body("rod", 1, 0.0833, "position = [0.5, 0]\n") +
                      test::pin("pivot", "ground", "rod", {0, 0}, {-0.5, 0}) + more + "[run]\nduration = 1\n",
                  "rod");
  scene.run.duration = duration;
  scene.nonsmooth.step = duration / 20;
  return scene;
}

/// Lines of a CSV file after its header, and the first field of the last.
std::pair<long, double> rows_of(const std::filesystem::path& file) {
  const auto lines = test::lines_of(test::file_text(file));
  return {static_cast<long>(lines.size()) - 1, std::strtod(lines.back().c_str(), nullptr)};
}

}  // namespace

TEST_CASE("each part of a continued run has its last row at its own end time", "[rows]") {
  // 3 × 0.01 is less than 0.03, and 6 × 0.01 than 0.06, by rounding alone; 3 × 0.1 is greater than 0.3, and
  // 6 × 0.1 than 0.6.
  REQUIRE(3 * 0.1 > 0.3);
  REQUIRE(6 * 0.1 > 0.6);
  for (const auto& [half, end, step] : {std::array{0.03, 0.06, 0.01}, {0.3, 0.6, 0.1}})
    for (const auto* family : {"penalty", "nonsmooth"}) {
      CAPTURE(family, end);
      auto scene = rod(end);
      scene.run.output_step = step;
      Simulation simulation(scene, family);
      Trajectory path, ninths(half / 9);
      Energies energies;
      simulation.run({.until = half, .observers = {&path, &ninths, &energies}});
      REQUIRE(path.size() == 4);
      CHECK(path.t(3) == half);
      REQUIRE(ninths.size() == 10);
      CHECK(ninths.t(9) == half);
      REQUIRE(energies.rows.size() == 3);  // from the first step on
      CHECK(energies.rows[2].t == half);
      simulation.run({.observers = {&path, &ninths, &energies}});
      REQUIRE(path.size() == 7);
      CHECK(path.t(6) == end);
      REQUIRE(ninths.size() == 19);
      CHECK(ninths.t(18) == end);
      REQUIRE(energies.rows.size() == 6);
      CHECK(energies.rows[5].t == end);
      for (std::size_t i = 1; i < path.size(); ++i) CHECK(path.t(i) - path.t(i - 1) == Approx(step));
      // 20000 steps of a 20000th are more than 0.03: a continued run has no such row twice.
      Simulation again(scene, family);
      Trajectory fine(half / 20000);
      again.run({.until = half, .observers = {&fine}});
      again.run({.observers = {&fine}});
      CHECK(fine.size() == 40001);
      CHECK(fine.t(20000) == half);
      CHECK(fine.t(40000) == end);
    }
}

TEST_CASE("an end time that is not a multiple of the output step has its own row", "[rows]") {
  auto scene = rod(0.105);
  scene.run.output_step = 0.01;
  Trajectory path, whole;
  Simulation(scene, "nonsmooth").run({.observers = {&path}});
  REQUIRE(path.size() == 12);
  // Rounding of a product and a quotient, 2 ε.
  for (std::size_t i = 0; i < 11; ++i)
    CHECK(std::abs(path.t(i) - 0.01 * static_cast<double>(i)) <= 2 * 2.3e-16 * 0.105);
  CHECK(path.t(11) == 0.105);
  // The end of a part is no end of the run, and a run continued after the end misses no multiple.
  Simulation parts(scene, "nonsmooth");
  parts.run({.until = 0.033, .observers = {&whole}});
  CHECK(whole.size() == 4);
  parts.run({.observers = {&whole}});
  CHECK(whole.size() == 12);
  parts.run({.until = 0.13, .observers = {&whole}});
  REQUIRE(whole.size() == 15);
  CHECK(whole.t(12) == Approx(0.11));
}

TEST_CASE("files and samples reach the end time", "[rows]") {
  const std::string lvdt = "[instruments.x]\ntype = \"lvdt\"\nbody = \"rod\"\nsampling = 1000\n";
  for (const double duration : {0.03, 0.06, 0.12, 0.24, 0.75}) {
    CAPTURE(duration);
    test::TemporaryFolder folder;
    auto scene = rod(duration, lvdt);
    scene.run.forces = true;
    run_scene(scene, {.formulation = "penalty", .folder = folder.path(), .checkpoint = 0});
    for (const auto* name : {"trajectory.csv", "forces.csv"}) {
      const auto [count, last] = rows_of(folder.path() / name);
      CHECK(count == 20001);
      CHECK(last == duration);
    }
    CHECK(rows_of(folder.path() / "signals.csv").first == std::lround(1000 * duration));
    // An end that differs from a product by rounding, as after many revolutions.
    scene.run.duration = std::nextafter(duration, 0.0);
    run_scene(scene, {.formulation = "penalty", .folder = folder.path(), .checkpoint = 0});
    CHECK(rows_of(folder.path() / "signals.csv").first == std::lround(1000 * duration));
  }
}
