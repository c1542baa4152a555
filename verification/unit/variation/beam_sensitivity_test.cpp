// Derivatives by the keys of beams: static deflections against closed forms, and vibrations with an impact against the
// identities that a change of units gives.
#include "verification/support/rig.hpp"
#include "verification/unit/variation/varied_scenes.hpp"

using namespace freeplay;
using namespace freeplay::test::varied;

namespace {

const std::string precise = "[nonsmooth]\ntolerance = 1e-12\n[penalty]\ntolerance = 1e-12\n";

/// Derivatives of one quantity, each times the value of its key.
class Weighted {
 public:
  Weighted(const Sensitivities& s, std::size_t quantity) : s_(s), q_(s.quantities[quantity]) {}
  double value() const { return q_.value; }
  double by(const std::string& key) const {
    const auto at = static_cast<std::size_t>(std::ranges::find(s_.keys, key) - s_.keys.begin());
    REQUIRE(at < s_.keys.size());
    return s_.key_values[at] * q_.derivatives[at];
  }

 private:
  const Sensitivities& s_;
  const Sensitivity& q_;
};

}  // namespace

TEST_CASE("the keys of a beam change its static deflection as in closed form", "[sensitivity][beams]") {
  // A cantilever of two pieces under its weight and that of a body at its tip, at rest after its damped vibration:
  // y = −m g L³/(3 EI) − Σ ρA (L/2) g x² (3 L − x)/(6 EI) with x = L/4 and 3 L/4, EI = E w h³/12, A = w h.
  const double E = 12, w = 1, h = 1, L = 1, rho = 1, m = 0.5, g = 1e-3;
  const auto text =
      fmt::format("gravity = [0.0, {}]\n", -g) +
      test::body("tip", m, 0.01, "position = [1.0, 0.0]\nangle = 0.0\n") +
      fmt::format(
          "[beams.rod]\nbetween = [\"ground\", \"tip\"]\nlength = {}\nelements = 2\nyoung = {}\ndensity = {}\n"
          "section = \"rectangle\"\nwidth = {}\nheight = {}\ndamping = 0.5\n",
          L, E, rho, w, h) +
      test::run_for(20) + precise;
  const double EI = E * w * h * h * h / 12, by_tip = -m * g * L * L * L / (3 * EI);
  const auto by_piece = [&](double x) { return -0.5 * L * rho * w * h * g * x * x * (3 * L - x) / (6 * EI); };
  const double by_pieces = by_piece(0.25 * L) + by_piece(0.75 * L), y = by_tip + by_pieces;
  const std::vector<std::string> keys{"beams.rod.young",  "beams.rod.width",   "beams.rod.height",
                                      "beams.rod.length", "beams.rod.density", "bodies.tip.mass"};
  const std::vector<double> expected{
      -y / E,          -by_tip / w, (-3 * by_tip - 2 * by_pieces) / h, (3 * by_tip + 4 * by_pieces) / L,
      by_pieces / rho, by_tip / m};
  for (const auto& way : {test::event_driven, test::fixed_steps(0.02), test::penalty}) {
    CAPTURE(way.name);
    const auto q =
        sensitivities(
            test::scene_by(way, text),
            {.of = {"end.tip.y"}, .to = keys, .formulation = test::name_of(way.family), .errors = false})
            .quantities[0];
    // The shape is linear up to the square of the slope, 4e-4; vibrations have decayed by e^−40.
    CHECK(q.value == Approx(y).epsilon(1e-6));
    check_derivatives(q, expected, 2e-6);
  }
}

TEST_CASE("derivatives by the keys of a beam satisfy the identities of dimensions", "[sensitivity][beams]") {
  // A cantilever with a moving body at its tip, which meets a wall. Its deflection is large, and neither the length of
  // the beam nor the places of its pieces are stated: they follow from the position of the tip. With Y[p] = p ∂Y/∂p,
  //   Y[E] + Y[ρ] + Y[m] + Y[J] = M Y for a quantity in kg^M,
  //   2 Y[E] + Y[v] − Y[T] = −S Y for a quantity in s^S and the duration T,
  //   Y[all lengths] + 3 Y[m] + 5 Y[J] + Y[v] + 2 Y[E] = N Y for a quantity in kg^M m^K, N = K + 3 M, at the same
  //   density,
  // with both moduli as E. The width multiplies stiffness and mass of the beam: Y[w] = Y[E of the beam] + Y[ρ].
  const auto text =
      test::body("tip", 0.5, 0.01, "position = [1.0, 0.0]\nangle = 0.0\nvelocity = [0.0, -0.3]\n") +
      "[beams.rod]\nbetween = [\"ground\", \"tip\"]\nelements = 3\nyoung = 12e3\ndensity = 1\n"
      "section = \"rectangle\"\nwidth = 1\nheight = 0.1\n" +
      test::plane("wall", "ground", "tip", 0.05, "s", "at = [[0, -0.1], [0, 0]]\n") +
      test::surface("s", 0.6, "young = 2e5\npoisson = 0.3\n") + test::run_for(1.2) + precise;
  struct Quantity {
    const char* name;
    double mass, time, length;  // M, S, N
  };
  const std::vector<Quantity> quantities{{"event.1.t", 0, 1, 0},
                                         {"event.1.v_n_minus", 0, -1, 1},
                                         {"event.1.impulse_n", 1, -1, 4},
                                         {"end.tip.y", 0, 0, 1},
                                         {"end.tip.vy", 0, -1, 1}};
  const std::vector<std::string> lengths{"beams.rod.width", "beams.rod.height", "bodies.tip.position[0]",
                                         "contacts.wall.radius", "contacts.wall.at[0][1]"};
  std::vector<std::string> names,
      keys{"beams.rod.young",    "surfaces.s.young",       "beams.rod.density", "bodies.tip.mass",
           "bodies.tip.inertia", "bodies.tip.velocity[1]", "run.duration"};
  keys.insert(keys.end(), lengths.begin(), lengths.end());
  for (const auto& q : quantities) names.emplace_back(q.name);
  std::vector<Sensitivity> first;
  for (const auto& way : {test::event_driven, test::penalty})
    for (const auto* reduction : {"", "beams.rod.modes=2"}) {
      CAPTURE(way.name, reduction);
      std::vector<std::string> options;
      if (*reduction != 0) options.emplace_back(reduction);
      // As an override: a scene changed otherwise is that of its canonical text, which states the length.
      if (!way.penalty()) options.emplace_back("nonsmooth.scheme=\"event-driven\"");
      const auto s =
          sensitivities(test::scene_by(way, text, options),
                        {.of = names, .to = keys, .formulation = test::name_of(way.family), .errors = false});
      for (std::size_t i = 0; i < quantities.size(); ++i) {
        const auto& of = quantities[i];
        CAPTURE(of.name);
        const Weighted y(s, i);
        REQUIRE(std::isfinite(y.value()));
        const double moduli = y.by("beams.rod.young") + y.by("surfaces.s.young"),
                     masses = y.by("bodies.tip.mass") + y.by("bodies.tip.inertia"),
                     speed = y.by("bodies.tip.velocity[1]"), density = y.by("beams.rod.density");
        double along = 0, scale = std::abs(y.value());
        for (const auto& key : lengths) along += y.by(key);
        for (const auto& key : keys) scale = std::max(scale, std::abs(y.by(key)));
        // Tolerances of 1e-12, whose errors grow to 1e-10 of the largest term over the fastest vibration's periods.
        const double error = 1e-8 * scale;
        CHECK(std::abs(y.by("beams.rod.young")) > 1e-3 * scale);
        CHECK(std::abs(moduli + density + masses - of.mass * y.value()) < error);
        CHECK(std::abs(2 * moduli + speed - y.by("run.duration") + of.time * y.value()) < error);
        CHECK(std::abs(along + 3 * y.by("bodies.tip.mass") + 5 * y.by("bodies.tip.inertia") + speed +
                       2 * moduli - of.length * y.value()) < error);
        CHECK(std::abs(y.by("beams.rod.width") - y.by("beams.rod.young") - density) < error);
      }
      // Before the impact both formulations have one motion.
      if (*reduction != 0) continue;
      if (first.empty()) {
        first = s.quantities;
        continue;
      }
      for (const std::size_t i : {0, 1}) {
        CHECK(s.quantities[i].value == Approx(first[i].value).epsilon(1e-9));
        check_derivatives(s.quantities[i], first[i].derivatives, 1e-7, 1e-13);
      }
    }
}
