// Objects that follow another one (numerics/trace.hpp), and simulations that share compiled functions:
// the result is the one without sharing, whatever is shared.
#include "compile/compiled_structures.hpp"
#include "numerics/trace.hpp"
#include "verification/support/compiled_runs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// Records a random function: `operations` of them, in which a number of `shared` seeds equals that of
/// other functions. Constants are from `scale`.
void record_randomly(TracedObject& object, unsigned shared, unsigned own, int operations, double scale) {
  Trace trace(object, "f");
  std::minstd_rand same(shared), other(own);
  auto list = trace.inputs(0, std::vector{0.3, 0.7, 1.9});
  for (int i = 0; i < operations; ++i) {
    auto& random = i < operations / 2 ? same : other;
    const auto any = [&] { return list[random() % list.size()]; };
    const Traced a = any(), b = random() % 4 == 0 ? Traced(scale * static_cast<double>(random() % 5)) : any();
    const auto kind = random() % 6;
    if (kind == 5)
      (void)(a < b);
    else
      list.push_back(kind == 0 ? a + b : kind == 1 ? a - b : kind == 2 ? a * b : kind == 3 ? -a : sin(a));
  }
  trace.output(0, 0, list.back());
}

TracedObject recorded(unsigned shared, unsigned own, int operations, double scale,
                      const TracedObject* like = nullptr) {
  TracedObject object(0, like);
  record_randomly(object, shared, own, operations, scale);
  record_randomly(object, shared + 1, own + 1, operations, scale);
  return object;
}

Scene slider_crank(std::vector<std::string> changes = {}) {
  changes.insert(changes.end(), {"run.discard=0", "run.revolutions=0.2"});
  return read_scene(test::flores(), changes);
}

State end_of(const Scene& scene, CompiledStructures* structures = nullptr, bool checked = false) {
  Simulation simulation(scene, "nonsmooth",
                        {.compile = Compile::always, .structures = structures, .checked = checked});
  const auto run = simulation.run();
  CHECK(run.compiled.used);
  return run.final_state;
}

}  // namespace

TEST_CASE("an object that follows another one is the object recorded alone", "[compiled]") {
  int shared = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const auto like = recorded(seed, 1000 + seed, 60, 0.3);
    // Equal; with other constants; with other operations from the middle on; shorter; longer; and with
    // constants of 0 and 1, which change the structure.
    struct Follower {
      unsigned own;
      int operations;
      double scale;
    };
    for (const auto& f : {Follower{1000, 60, 0.3},
                          {1000, 60, 0.7},
                          {2000, 60, 0.3},
                          {1000, 40, 0.3},
                          {1000, 90, 0.3},
                          {1000, 60, 1}}) {
      const auto alone = recorded(seed, f.own + seed, f.operations, f.scale),
                 follower = recorded(seed, f.own + seed, f.operations, f.scale, &like);
      CHECK(follower.text() == alone.text());
      CHECK(follower.constants() == alone.constants());
      CHECK(follower.same_structure(alone));
      CHECK(follower.same_structure(like) == alone.same_structure(like));
      shared += follower.same_structure(like) ? 1 : 0;
    }
    // A follower can be followed.
    const auto follower = recorded(seed, 2000 + seed, 60, 0.3, &like);
    CHECK(recorded(seed, 1000 + seed, 60, 0.3, &follower).text() == like.text());
  }
  CHECK(shared >= 40);  // the first of each; the second if no comparison has another result
  CHECK(shared < 240);
}

TEST_CASE("constants that coincide in a follower have one slot, as alone", "[compiled]") {
  const auto sum = [](double a, double b, const TracedObject* like) {
    TracedObject object(0, like);
    {
      Trace trace(object, "f");
      const auto x = trace.input(0, 0, 0.3);
      const auto first = Traced(a) * x;
      trace.output(0, 0, first + Traced(b) * sin(x));
    }
    return object;
  };
  const auto two = sum(2, 3, nullptr), one = sum(2, 2, nullptr);
  CHECK(two.constants() == std::vector<double>{2, 3});
  for (const auto* like : {&two, &one}) {
    CHECK(sum(5, 7, like).constants() == std::vector<double>{5, 7});
    CHECK(sum(5, 5, like).constants() == std::vector<double>{5});
    CHECK(sum(5, 7, like).text() == two.text());
    CHECK(sum(5, 5, like).text() == one.text());
  }
}

TEST_CASE("simulations that share compiled functions have the digits of simulations alone", "[compiled]") {
  const test::CompilerCache cache;
  const std::vector<Scene> scenes{slider_crank(), slider_crank({"joints.gudgeon.clearance=0.4e-3"}),
                                  slider_crank({"surfaces.steel.friction=0"}),
                                  slider_crank({"bodies.rod.mass=2", "drives.motor.speed_rpm=-150"}),
                                  read_scene("cases/four-bar/scene.toml", {"run.revolutions=0.2"})};
  for (const auto& first : scenes) {
    CompiledStructures structures;
    end_of(first, &structures);
    for (const auto& scene : scenes) {
      const auto expected = end_of(scene), found = end_of(scene, &structures);
      CHECK(found.q == expected.q);
      CHECK(found.v == expected.v);
    }
  }
}

TEST_CASE("a scene that is known to be valid is not read again, with the same digits", "[compiled]") {
  auto scene = slider_crank();
  CHECK(end_of(scene, nullptr, true).q == end_of(scene).q);
  scene.mechanism.joints.clear();  // drives and contacts name them
  CHECK_THROWS_AS(Simulation(scene, "nonsmooth"), ModelError);
}
