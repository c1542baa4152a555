// Special cases of equilibria: refusals and their messages, mirrored and tiny scenes, held drives,
// and the command.
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/modes.hpp"
#include "dynamics/system.hpp"
#include "formulations/make.hpp"
#include "study/runs/perturb.hpp"
#include "verification/random_scenes/scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

const std::string run = "[run]\nduration = 0.1\nstart = \"equilibrium\"\n";
const std::string body = test::body("a", 2, 0.5), pivot = test::pin("pivot", "ground", "a");
const std::string steel = test::surface("s", 0.5, "young = 2e11\npoisson = 0.3\n");

State begin(const std::string& text, std::string* assumed = nullptr) {
  const auto scene = parse_scene(text + run, "test");
  return assemble(scene.mechanism, scene.run.start, assumed);
}

/// A disc in a ring on a spring, all lengths multiplied by `length`, mirrored at the vertical by
/// `side`.
Modes ring(double length, int side, Family family) {
  const auto scene = parse_scene(fmt::format("gravity = [{}, {}]\n", side * 2 * length, -10 * length) +
                                     test::body("a", 1e-3, 1e-3 * length * length) +
                                     test::pin("pin", "ground", "a", {}, {-side * 0.8 * length, 0.6 * length},
                                               test::loose(0.01 * length, 0.2 * length)) +
                                     steel + run,
                                 "test");
  const System system(scene.mechanism);
  const auto elastic = compliances(family, scene, system);
  const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
  return find_modes(system, find_equilibrium(scene.mechanism, system, from.q, elastic), elastic);
}

}  // namespace

TEST_CASE("a scene without an equilibrium is refused with the reason", "[equilibrium]") {
  const std::string weight = "gravity = [0, -9.81]\n";
  CHECK_THROWS_WITH(begin(weight + body),
                    Contains("no equilibrium") && Contains("bodies.a moves without limit"));
  CHECK_THROWS_WITH(begin(body + pivot + "[drives.m]\njoint = \"pivot\"\ntorque = 1\n"),
                    Contains("bodies.a turns without limit"));
  CHECK_THROWS_WITH(begin(body + "velocity = [1, 0]\n" + pivot), Contains("begins at rest"));
}

TEST_CASE("an unconstrained body rests at its position and its equilibrium is called marginal",
          "[equilibrium]") {
  std::string assumed;
  const auto s = begin(body + "position = [3, 4]\nangle = 0.5\n", &assumed);
  CHECK(s.q == std::vector<double>{3, 4, 0.5});
  CHECK_THAT(assumed, Contains("marginal: 3 of 3 motions without stiffness"));
}

TEST_CASE("a drive holds its joint at the initial angle in equilibrium and moves from there",
          "[equilibrium]") {
  std::string assumed;
  const auto s = begin("gravity = [0, -9.81]\n" + body + "angle = 0.7\n" + pivot +
                           "[drives.m]\njoint = \"pivot\"\nspeed = 5\n",
                       &assumed);
  CHECK(s.q[2] == Approx(0.7));
  CHECK(s.v[2] == Approx(5));
  CHECK_THAT(assumed, Contains("computed with all drives"));
}

TEST_CASE("a spring without free length is in equilibrium at zero length", "[equilibrium]") {
  const auto scene = parse_scene(
      body + "position = [0.4, 0]\n" + test::spring("s", "ground", "a", {}, {}, 8, 0) + run, "test");
  const System system(scene.mechanism);
  const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
  const auto at = find_equilibrium(scene.mechanism, system, from.q, {});
  CHECK(std::abs(at.state.q[0]) < 1e-12);
  const auto modes = find_modes(system, at, {}).modes;
  REQUIRE(modes.size() == 3);
  CHECK(modes[0].kind == Mode::Kind::free);
  CHECK(std::abs(modes[1].s) == Approx(2));
  CHECK(std::abs(modes[2].s) == Approx(2));
}

TEST_CASE("small vibrations are the same in the mirrored scene and at a millionth of its size",
          "[equilibrium]") {
  const auto plain = ring(1, 1, Family::nonsmooth).modes;
  REQUIRE(plain.size() == 2);
  for (const auto& other : {ring(1, -1, Family::nonsmooth).modes, ring(1e-6, 1, Family::nonsmooth).modes}) {
    REQUIRE(other.size() == plain.size());
    for (std::size_t i = 0; i < plain.size(); ++i)
      CHECK(std::abs(other[i].s) == Approx(std::abs(plain[i].s)).epsilon(1e-9));
  }
  const auto yields = ring(1, 1, Family::penalty).modes;
  REQUIRE(yields.size() == 3);
  CHECK(std::abs(yields[0].s) == Approx(std::abs(plain[0].s)).epsilon(1e-4));
}

TEST_CASE("the command equilibrium prints within 80 columns and writes its results", "[equilibrium]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "scene.toml";
  write_file(file, "gravity = [0, -9.81]\n" + body + "position = [0.3, 0]\n" +
                       test::pin("pivot", "ground", "a", {}, {-0.3, 0}) + run);
  const auto out = test::succeeded("modes " + file.string() + " -o " + (folder.path() / "o").string());
  CHECK_THAT(out.out, Contains("equilibrium, stable"));
  for (const char* name : {"modes.csv", "modes.json", "equilibrium.csv", "static_forces.csv"})
    CHECK(std::filesystem::exists(folder.path() / "o" / name));
  CHECK(test::freeplay("modes " + file.string() + " --about nothing").status == 2);
  test::succeeded("modes " + file.string() + " --set gravity=[0,0] --about start");
}

TEST_CASE("equilibria of random scenes balance or are refused with a reason", "[equilibrium]") {
  int rest = 0;
  for (int index = 0; index < 60; ++index) {
    const auto drawn = verification::random_scenes::draw(11, index);
    auto scene = parse_scene(drawn.text, "random scene");
    scene.run.start = RunOptions::Start::equilibrium;
    for (auto& b : scene.mechanism.bodies) {
      b.velocity = {0, 0};
      b.angular_velocity = 0;
    }
    const System system(scene.mechanism);
    if (system.n() > 40 || system.drive_rows() > 0) continue;
    INFO(drawn.text);
    for (const auto family : {Family::nonsmooth, Family::penalty}) {
      Equilibrium at;
      try {
        const auto elastic = compliances(family, scene, system);
        const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
        at = find_equilibrium(scene.mechanism, system, from.q, elastic);
      } catch (const ModelError& e) {
        CHECK(!e.message.empty());
        continue;
      }
      ++rest;
      // Newton's law of every body, from the elements' forces alone.
      const auto forces = static_forces(system, at);
      std::vector<double> sum(system.n()), size(system.n());
      for (int i = 0; i < system.n(); ++i)
        if (i % 3 < 2) {
          const auto& g = scene.mechanism.gravity;
          sum[i] = size[i] = system.mass()[i] * (i % 3 == 0 ? g.x() : g.y());
          size[i] = std::abs(size[i]);
        }
      double all = 0;
      for (std::size_t e = 0; e < forces.elements.size(); ++e)
        for (const int end : {0, 1}) {
          const int b = system.report().elements[e].bodies[end];
          if (b == ground) continue;
          const auto& f = forces.elements[e];
          const double sign = end == 0 ? -1 : 1;
          sum[3 * b] += sign * f.fx;
          sum[3 * b + 1] += sign * f.fy;
          size[3 * b] += std::abs(f.fx);
          size[3 * b + 1] += std::abs(f.fy);
        }
      for (const double x : size) all = std::max(all, x);
      // Couples are divided by the longest lever arm.
      for (const auto& f : forces.elements)
        if (system.longest_arm() > 0) all = std::max(all, std::abs(f.m) / system.longest_arm());
      // If all springs are slack and all torques zero: the rounding of a position times the
      // greatest stiffness.
      double far = 0, stiffest = 0;
      for (const double x : at.state.q) far = std::max(far, std::abs(x));
      for (const auto& load : scene.mechanism.loads)
        if (const auto* spring = std::get_if<SpringDamper>(&load))
          stiffest = std::max(stiffest, spring->stiffness);
        else if (const auto* rubber = std::get_if<Bushing>(&load))
          stiffest =
              std::max({stiffest, rubber->stiffness.x(), rubber->stiffness.y(), rubber->turn_stiffness});
      for (const auto& drive : scene.mechanism.drives)
        if (const auto* torque = std::get_if<TorqueDrive>(&drive))
          for (const auto& point : torque->table) stiffest = std::max(stiffest, std::abs(point.second));
      for (int i = 0; i < system.n(); ++i)
        if (i % 3 < 2) CHECK(std::abs(sum[i]) <= 1e-7 * all + 1e-13 * stiffest * far);
      for (int k = 0; k < system.contacts(); ++k) CHECK(at.normal[k] >= -1e-12 * all);
    }
  }
  CHECK(rest > 10);
}

TEST_CASE("perturbed starts of a scene that begins in equilibrium are in equilibrium",
          "[equilibrium][study]") {
  // A pendulum with a horizontal start; its pivot is within the clearance, so that it hangs below
  // that point.
  const auto scene =
      parse_scene("gravity = [0, -9.81]\n" + body + "position = [0.3, 0]\n" +
                      test::pin("pivot", "ground", "a", {}, {-0.3, 0}, test::loose(1e-3, 0.01)) + steel + run,
                  "test");
  for (int start = 0; start < 3; ++start) {
    const auto moved = perturbed(scene, {}, 7, start, {});
    const auto& a = moved.mechanism.bodies[0];
    CHECK(std::remainder(*a.angle + 0.5 * M_PI, 2 * M_PI) == Approx(0).margin(1e-9));
    CHECK(std::hypot(a.position->x(), a.position->y() + 0.3) <= 0.9e-3 * (1 + 1e-9));
    CHECK(a.position->x() != 0);
    CHECK(a.velocity->is_zero());
  }
}

TEST_CASE("an equilibrium does not depend on the order of the elements in a scene", "[equilibrium]") {
  // The desk lamp of cases/spring-balance: with increasing contact stiffness, residual forces fall
  // below rounding in one direction before another; the order of the elements decides which.
  const auto text = [](bool reversed) {
    std::vector<std::string> blocks{
        test::body("lower_arm", 0.3, 0.004, "position = [0.2, 0]\n"),
        test::body("upper_arm", 0.3, 0.004, "position = [0.2, 0.05]\n"),
        test::body("head", 1.2, 0.003, "position = [0.48, 0.025]\n"),
        test::pin("base_low", "ground", "lower_arm", {}, {-0.2, 0}),
        test::pin("base_high", "ground", "upper_arm", {0, 0.05}, {-0.2, 0}),
        test::pin("head_low", "lower_arm", "head", {0.2, 0}, {-0.08, -0.025}),
        test::pin("head_high", "upper_arm", "head", {0.2, 0}, {-0.08, 0.025}, test::loose(1e-4, 3e-3))};
    if (reversed) std::ranges::reverse(blocks);
    std::string all = "gravity = [0, -9.81]\n" + test::surface("s", 0.5, "young = 207e9\npoisson = 0.3\n");
    for (const auto& block : blocks) all += block;
    return all + test::spring("balance", "ground", "lower_arm", {0, 0.2}, {-0.08, 0}, 300, 0.0426);
  };
  const auto given = begin(text(false)), turned = begin(text(true));
  // The softest motion, 3 N/m, moves by 1e-11 m under the residual force, 1e-11 N; the bound is a
  // hundred times that.
  for (int b = 0; b < 3; ++b)
    for (int c = 0; c < 3; ++c) CHECK(turned.q[3 * (2 - b) + c] == Approx(given.q[3 * b + c]).margin(1e-9));
}
