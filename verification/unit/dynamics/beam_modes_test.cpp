// Frequencies and statics of further beams: free ends, heavy cables, rotation, supports.
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/modes.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// A beam of 1 m and 1 kg/m with EI (N m²) and EA (N), nearly without rotary inertia.
std::string beam(const std::string& from, const std::string& to, int elements, double bending, double axial,
                 const std::string& more = "") {
  return fmt::format(
      "[beams.rod]\nbetween = [\"{}\", \"{}\"]\nlength = 1.0\nelements = {}\nyoung = {}\ndensity = 1.0\n"
      "area = 1.0\nsecond_moment = {}\n{}",
      from, to, elements, axial, bending / axial, more);
}
std::string light(const std::string& name, Vec2 at, double angle = 0) {
  return test::body(name, 1e-5, 1e-8,
                    fmt::format("position = [{}, {}]\nangle = {}\n", at.x(), at.y(), angle));
}
int pieces(double h) { return static_cast<int>(std::round(1 / h)); }

/// Frequencies (rad/s), in order, about the equilibrium near the start.
std::vector<double> frequencies(const std::string& text) {
  const auto scene = parse_scene(text + test::run_for(1), "beam");
  const System system(scene.mechanism);
  const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
  std::vector<double> list;
  for (const auto& mode : find_modes(system, find_equilibrium(scene.mechanism, system, from.q, {}), {}).modes)
    if (mode.kind == Mode::Kind::swing) list.push_back(std::abs(mode.s));
  return list;
}

}  // namespace

TEST_CASE("a beam between free ends has the frequencies of a free beam", "[beams]") {
  // cos k cosh k = 1, as between clamps; masses in the middles of pieces: second order.
  const double known[] = {22.37328544806132, 61.67282286792025, 120.90339161522};
  for (const int n : {0, 1, 2}) {
    CAPTURE(n);
    const auto error = [&](double h) {
      const auto found =
          frequencies(light("a", {0, 0}) + light("b", {1, 0}) + beam("a", "b", pieces(h), 1, 1e7));
      double nearest = INFINITY;
      for (const double w : found) nearest = std::min(nearest, std::abs(w / known[n] - 1));
      return nearest;
    };
    test::check_order({1.0 / 8, 1.0 / 16, 1.0 / 32}, error, 1.8, 2.2);
  }
}

TEST_CASE("a heavy cable swings like a hanging chain", "[beams]") {
  // j_{0,k}/2 √(g/L) (Bernoulli 1732, Euler 1781). EI = 1e-8 N m² bends over √(EI/T): the term of the boundary at the
  // pin vanishes, and the free end's is below 1e-3. Masses in the middles: second order.
  const double g = 9.81, known[] = {2.404825557695773, 5.520078110286311, 8.653727912911013};
  for (const int k : {0, 1, 2}) {
    CAPTURE(k);
    const double w = 0.5 * known[k] * std::sqrt(g);
    const auto error = [&](double h) {
      const auto found =
          frequencies("gravity = [0.0, -9.81]\n" + light("top", {0, 0}, -0.5 * std::numbers::pi) +
                      test::pin("pin", "ground", "top") + beam("top", "free", pieces(h), 1e-8, 1e7));
      double nearest = INFINITY;
      for (const double x : found) nearest = std::min(nearest, std::abs(x / w - 1));
      return nearest;
    };
    // An independent chain of the same pieces has 3.09e-5, 1.06e-3, 5.51e-3 with 32 pieces, and orders 2.04, 2.1, 2.5.
    const double most[] = {4e-5, 1.3e-3, 7e-3};
    CHECK(error(1.0 / 32) < most[k]);
    test::check_order({1.0 / 16, 1.0 / 32, 1.0 / 64}, error, 1.9, 2.7);
  }
}

TEST_CASE("beams on two supports bend by closed forms", "[beams]") {
  // Central force P on the middle piece of an odd number: P L³/(48 EI) on pins, P L³/(192 EI) between clamps.
  const double P = 1e-6;
  const auto middle = [&](const std::string& ends, const std::string& from, const std::string& to) {
    const auto scene = parse_scene(
        ends + beam(from, to, 5, 1, 1e5) + test::force("f", "rod-3", {0, P}) + test::run_for(1), "beam");
    const System system(scene.mechanism);
    const auto start = assemble(scene.mechanism, RunOptions::Start::assembled);
    const auto q = find_equilibrium(scene.mechanism, system, start.q, {}).state.q;
    const auto& bodies = scene.mechanism.bodies;
    const auto at = std::ranges::find(bodies, "rod-3", &Body::name) - bodies.begin();
    return q[3 * static_cast<std::size_t>(at) + 1];
  };
  const auto pins = light("a", {0, 0}) + light("b", {1, 0}) + test::pin("A", "ground", "a") +
                    test::pin("B", "ground", "b", {1, 0});
  CHECK(middle(pins, "a", "b") == Approx(P / 48).epsilon(1e-6));
  const auto clamp = light("b", {1, 0}) + test::joint("B", "rigid", "ground", "b", {1, 0}, {0, 0});
  CHECK(middle(clamp, "ground", "b") == Approx(P / 192).epsilon(1e-6));
}
