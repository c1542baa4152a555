// Springs of variable rate and bushings: forces are the gradient of their stored energy, dampers
// dissipate energy, kinks are listed where the force has them, and invalid springs are refused.
#include "dynamics/system.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

Scene two_on(const std::string& load) {
  return parse_scene(test::body("a", 1, 1) + test::body("b", 1, 1, "position = [1.0, 0.0]\n") +
                         "[loads.it]\nbetween = [\"a\", \"b\"]\n" + load + "\n" + test::run_for(1),
                     "load");
}

const std::string ends = "at = [[0.1, 0.2], [-0.3, 0.1]]\n";
const std::string linear = "type = \"spring-damper\"\n" + ends,
                  torsional = "type = \"torsional-spring-damper\"\n",
                  bushing = "type = \"bushing\"\naxis = [0.6, 0.8]\n" + ends;

}  // namespace

TEST_CASE("forces of springs and bushings are the gradient of their stored energy", "[springs]") {
  for (const auto& load :
       {linear + "stiffness = 3\ncubic = 2\npreload = -0.7\nfree_length = 0.9",
        linear + "stiffness = 3\ncubic = 2\npreload = -0.7\nfree_length = 0.9\none_way = \"pull\"",
        linear + "stiffness = 3\npreload = 0.5\nfree_length = 1.3\none_way = \"push\"",
        linear + "cubic = 4\npreload = 0.2\nfree_length = 1.1\none_way = \"pull\"",
        linear + "force_table = [[0.3, -1], [0.9, 0.4], [1.2, -0.2], [1.5, 2]]",
        linear + "force_table = [[0.3, -1], [0.9, 0.4], [1.2, -0.2], [1.5, 2]]\none_way = \"pull\"",
        linear + "force_table = [[0.3, -1], [0.9, 0.4], [1.2, -0.2], [1.5, 2]]\none_way = \"push\"",
        torsional + "stiffness = 2\ncubic = 0.5\npreload = 0.4\nfree_angle = 0.2\none_way = \"push\"",
        torsional + "torque_table = [[-1, -0.5], [0.1, 0.2], [1, 3]]",
        bushing + "stiffness = [3.0, 7.0]\ntorsional_stiffness = 2\nfree_angle = 0.3",
        bushing + "radial_table = [[0, 0], [0.5, 1], [1.5, 5]]\ntorsional_stiffness = 1"}) {
    CAPTURE(load);
    const System system(two_on(load).mechanism);
    CHECK_FALSE(system.has_loads());
    auto e = system.make_evaluation();
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const std::vector<double> v(6), z;
    for (int trial = 0; trial < 40; ++trial) {
      std::vector<double> q(6);
      for (auto& x : q) x = uniform(engine);
      q[3] += 1;
      system.place(0, q.data(), e);
      system.forces(0, q.data(), v.data(), z.data(), e);
      const auto force = e.force;
      double sums[3] = {0, 0, 0};
      for (std::size_t i = 0; i < 6; ++i) {
        // Central differences: the error at a kink within 1e-6 is 1e-6 times the change of slope.
        const double s = 1e-6;
        auto lo = q, hi = q;
        lo[i] -= s, hi[i] += s;
        CHECK(force[i] ==
              Approx(-(system.potential(hi.data()) - system.potential(lo.data())) / (2 * s)).margin(2e-5));
        sums[i % 3] += force[i];
      }
      CHECK(sums[0] == Approx(0).margin(1e-12));
      CHECK(sums[1] == Approx(0).margin(1e-12));
      const double moment = q[0] * force[1] - q[1] * force[0] + q[3] * force[4] - q[4] * force[3] + sums[2];
      CHECK(moment == Approx(0).margin(1e-11));
    }
  }
}

TEST_CASE("dampers dissipate energy, in agreement with the ledger", "[springs]") {
  for (const auto& load :
       {linear + "stiffness = 3\ndamping = 2\nfree_length = 1\none_way = \"pull\"",
        linear + "stiffness = 3\ndamping = 9\nfree_length = 1\none_way = \"push\"",
        linear + "stiffness = 3\ndamping_table = [[-1, -4], [0, 0], [1, 1], [2, 1]]",
        torsional + "stiffness = 1\ndamping_table = [[-1, -4], [0, 0], [2, 1]]\none_way = \"pull\"",
        bushing + "stiffness = [3.0, 7.0]\ndamping = [1.0, 0.5]\ntorsional_damping = 0.2"}) {
    CAPTURE(load);
    const System system(two_on(load).mechanism);
    CHECK(system.has_loads());
    CHECK(system.has_velocity_forces());
    auto e = system.make_evaluation();
    std::mt19937 engine(6);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const std::vector<double> z;
    for (int trial = 0; trial < 100; ++trial) {
      std::vector<double> q(6), v(6);
      for (auto& x : q) x = uniform(engine);
      for (auto& x : v) x = uniform(engine);
      q[3] += 1;
      system.place(0, q.data(), e);
      system.forces(0, q.data(), v.data(), z.data(), e);
      CHECK(e.power.damping <= 1e-15);
      // The power of the forces is the loss of potential energy plus the dissipation of the damper.
      double power = 0;
      const double s = 1e-6;
      auto lo = q, hi = q;
      for (std::size_t i = 0; i < 6; ++i) power += e.force[i] * v[i], lo[i] -= s * v[i], hi[i] += s * v[i];
      const double stored = (system.potential(hi.data()) - system.potential(lo.data())) / (2 * s);
      CHECK(power + stored == Approx(e.power.damping).margin(5e-5));
    }
  }
}

TEST_CASE("kinks are where a force changes its slope or begins to act", "[springs]") {
  const auto kinks = [](const std::string& load) {
    const System system(two_on(load).mechanism);
    return system.phases() == 0 ? std::vector<double>{} : system.phase(0).kinks;
  };
  // A spring with a force at length 0 reverses there: a billionth of its free length, or of its
  // table's last.
  const auto turning = [&](const std::string& load, double length) {
    const auto list = kinks(load);
    REQUIRE_FALSE(list.empty());
    CHECK(list.front() == Approx(1e-9 * length));
    return std::vector<double>(list.begin() + 1, list.end());
  };
  CHECK(kinks(linear + "stiffness = 3").empty());
  CHECK(turning(linear + "stiffness = 3\ncubic = 2\nfree_length = 1", 1).empty());
  CHECK(kinks(linear + "stiffness = 4\npreload = 1\nfree_length = 1\none_way = \"pull\"") ==
        std::vector<double>{0.75});
  CHECK(turning(linear + "stiffness = 4\npreload = 8\nfree_length = 1\none_way = \"pull\"", 1)
            .empty());  // taut everywhere
  CHECK(turning(linear + "force_table = [[0, -1], [1, 0], [2, 1]]", 2).empty());
  CHECK(turning(linear + "force_table = [[0, -1], [1, 0], [2, 3], [3, 6]]", 3) == std::vector<double>{1});
  CHECK(kinks(linear + "force_table = [[1, 1], [2, 3]]\none_way = \"pull\"") == std::vector<double>{0.5});
  CHECK(kinks(linear + "force_table = [[1, -3], [2, -1], [3, 5]]\none_way = \"pull\"").size() == 1);
  const auto root = kinks(torsional + "stiffness = 2\ncubic = 3\npreload = 5\none_way = \"pull\"");
  REQUIRE(root.size() == 1);
  CHECK(5 + 2 * root[0] + 3 * std::pow(root[0], 3) == Approx(0).margin(1e-13));
}

TEST_CASE("invalid springs are refused", "[springs][scene]") {
  const auto refused = [](const std::string& load, const std::string& why) {
    CAPTURE(load);
    CHECK_THAT(test::refusal_of<SceneError>([&] { two_on(load); }), Catch::Contains(why));
  };
  refused(linear + "force_table = [[1, 0]]", "two points");
  refused(linear + "force_table = [[1, 0], [1, 2]]", "must increase");
  refused(linear + "stiffness = 1\nforce_table = [[1, 0], [2, 2]]", "cannot be combined with force_table");
  refused(linear + "preload = 1\nforce_table = [[1, 0], [2, 2]]", "cannot be combined with force_table");
  refused(linear + "damping = 1\ndamping_table = [[0, 0], [2, 2]]", "cannot be combined with damping_table");
  refused(linear + "stiffness = 1\ndamping_table = [[-1, 1], [0, 0], [2, 2]]", "must dissipate");
  refused(linear + "stiffness = 1\ndamping_table = [[-1, -1], [2, 2]]", "[0, 0]");
  refused(linear + "one_way = \"pull\"", "needs a stiffness");
  refused(linear + "stiffness = 1\ncubic = -1\none_way = \"pull\"", "0 or greater");
  refused(linear + "stiffness = 1\none_way = \"both\"", "one_way");
  refused(bushing + "stiffness = [-1.0, 2.0]", "0 or greater");
  refused(bushing + "radial_table = [[0.1, 0], [1, 2]]", "[0, 0]");
  refused(bushing + "stiffness = [1.0, 1.0]\nradial_table = [[0, 0], [1, 2]]",
          "cannot be combined with radial_table");
}
