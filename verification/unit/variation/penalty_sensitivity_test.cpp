// Derivatives of penalty runs: refusals, closed forms of one contact with damping, and random scenes against
// Richardson-extrapolated differences of whole runs.
#include "analysis/sensitivity.hpp"
#include "formulations/contact/contact_law.hpp"
#include "verification/references/sensitivity.hpp"
#include "verification/support/rig.hpp"
#include "verification/unit/variation/varied_scenes.hpp"

using namespace freeplay;
using namespace freeplay::test::varied;
using Catch::Matchers::Contains;

namespace {

/// A ball of 0.3 kg and radius 0.05 m between two walls without gravity; the first is met after 0.1 m at
/// 0.8 m/s, the second 0.15 m from there.
std::string between_walls(const std::string& penalty) {
  return test::body("ball", 0.3, 3e-4, "position = [0, 0]\nvelocity = [-0.8, 0]\n") +
         test::plane("left", "ground", "ball", 0.05, "s", "at = [[-0.15, 0], [0, 0]]\naxis = [0, -1]\n") +
         test::plane("right", "ground", "ball", 0.05, "s", "at = [[0.1, 0], [0, 0]]\naxis = [0, 1]\n") +
         test::surface("s", 0.6, "young = 1e8\npoisson = 0.3\nfriction = 0.2\n") +
         test::run_for(0.6, "start = \"given\"\n[penalty]\n" + penalty);
}

Sensitivities penalty_of(const std::string& text, std::vector<std::string> quantities,
                         std::vector<std::string> keys) {
  return sensitivities(parse_scene(text, "s.toml"),
                       {.of = std::move(quantities), .to = std::move(keys), .formulation = "penalty"});
}

/// The random scenes of event-driven runs with elastic surfaces and penalty settings.
RandomCase compliant(int i, Draw& r) {
  auto c = random_case(i, r);
  const auto replace = [&](const std::string& what, const std::string& with) {
    const auto at = c.text.find(what);
    REQUIRE(at != c.text.npos);
    c.text.replace(at, what.size(), with);
  };
  const char* const laws[] = {"exact", "hunt-crossley", "flores", "lankarani-nikravesh", "kelvin-voigt"};
  const char* const frictions[] = {"ambrosio", "threlfall", "lugre", "brown-mcphee"};
  const int law = static_cast<int>(r.between(0, 4.999)), friction = static_cast<int>(r.between(0, 3.999));
  const auto viscous = law < 4 ? std::string()
                               : fmt::format("kelvin_stiffness = {:.6g}\nkelvin_damping = {:.6g}\n",
                                             std::pow(10, r.between(5, 6)), r.between(1, 30));
  replace("[nonsmooth]\nscheme = \"event-driven\"\ntolerance = 1e-12\n",
          fmt::format("[penalty]\ncontact = \"{}\"\n{}friction = \"{}\"\nfriction_v0 = 1e-2\n{}"
                      "integrator = \"{}\"\n"
                      "tolerance = 1e-13\nv0_floor = 1e-4\n",
                      laws[law], viscous, frictions[friction], friction == 0 ? "friction_v1 = 3e-2\n" : "",
                      i % 8 < 4 ? "dopri5" : "adams_bashforth_moulton"));
  replace("[surfaces.s]\n",
          fmt::format("[surfaces.s]\nyoung = {:.6g}\npoisson = 0.3\n", std::pow(10, r.between(7, 9))));
  if (i % 4 == 1)
    replace("type = \"angle-stop\"\n",
            fmt::format("type = \"angle-stop\"\nstiffness = {:.6g}\n", std::pow(10, r.between(5, 7))));
  c.keys.emplace_back(law < 4 ? "surfaces.s.young" : "penalty.kelvin_damping");
  return c;
}

}  // namespace

TEST_CASE("penalty runs without derivatives are refused with the reason", "[sensitivity]") {
  const auto reason = [](const std::string& text) {
    const auto s = penalty_of(text, {"end.ball.x"}, {"bodies.ball.mass"});
    CHECK(std::isnan(s.quantities[0].derivatives[0]));
    return s.quantities[0].reasons[0];
  };
  CHECK_THAT(reason(between_walls("friction = \"mindlin\"\n")), Contains("mindlin"));
  CHECK_THAT(reason(between_walls("stabilisation = \"projection\"\nintegrator = \"dopri5\"\n")),
             Contains("\"projection\" has no derivatives"));
  const auto setting = [](const std::string& key) {
    try {
      penalty_of(between_walls("tolerance = 1e-10\n"), {"end.ball.x"}, {key});
    } catch (const std::exception& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  CHECK_THAT(setting("penalty.tolerance"), Contains("is a numerical setting"));
}

TEST_CASE("derivatives through a damped contact scale like the contact", "[sensitivity]") {
  // Derivatives are exact at fixed steps of tolerance 1e-13; the beginning of a contact, where S grows as
  // the square root of the depth, leaves about 1e-9.
  for (const char* integrator : {"dopri5", "adams_bashforth_moulton", "bulirsch_stoer", "rk4"}) {
    const bool fixed = std::string(integrator) == "rk4";
    const auto text = between_walls(fmt::format("contact = \"hunt-crossley\"\nintegrator = \"{}\"\n{}",
                                                integrator, fixed ? "step = 1e-6\n" : "tolerance = 1e-13\n"));
    const auto s =
        penalty_of(text, {"event.1.t", "event.2.t", "event.2.v_n_minus", "event.1.impulse_n"},
                   {"bodies.ball.mass", "surfaces.s.young", "initial.ball.vx", "surfaces.s.restitution"});
    INFO(integrator);
    const double delivered = delivered_restitution(1.5 * 0.4);
    const double free = 0.1 / 0.8 + 0.15 / (delivered * 0.8);
    const reference::ScaledContact c{
        0.1L, 0.15L, 0.8L, delivered, 1.5L, static_cast<long double>(s.quantities[1].value - free)};
    REQUIRE(c.duration > 1e-4L);
    const double bound = 1e-7;
    const auto check = [&](int quantity, int key, double expected) {
      CAPTURE(quantity, key);
      CHECK(s.quantities[quantity].derivatives[key] == Approx(expected).epsilon(bound));
    };
    check(0, 2, 0.1 / 0.64);
    check(1, 0, static_cast<double>(c.second_by_mass(0.3L)));
    check(1, 1, static_cast<double>(c.second_by_stiffness(1e8L)));
    check(1, 2, -static_cast<double>(c.second_by_speed()));
    check(2, 2, delivered);
    check(3, 0, 0.8 * (1 + delivered));
    check(3, 2, -0.3 * (1 + delivered));
    // χ = 3(1 − e)/2, and ê(χ) by its equation χ (1 + ê) = ln[(1 + χ)/(1 − χ ê)], differentiated.
    const double chi = 0.6, e = delivered;
    const double by_chi = (1 / (1 + chi) + e / (1 - chi * e) - (1 + e)) / (chi - chi / (1 - chi * e));
    check(3, 3, 0.3 * 0.8 * by_chi * -1.5);
  }
}

// F = K δ + D δ̇ ends at the instant at which it vanishes. With ζ = D/(2 √(K m)) = cos φ, the ball
// leaves with e = exp(−2 φ cot φ) times its speed, and with τ = 2 φ/(ω sin φ), δ(τ) = e v 2 ζ/ω, ω
// = √(K/m). The derivatives of e and of the end are those of these formulas.
TEST_CASE("derivatives by the damping of a spring and damper are exact at its release", "[sensitivity]") {
  // An explicit method that repeats steps of tolerance 1e-13 leaves 1e-11 for each of about a hundred steps.
  constexpr double bound = 1e-8;
  for (const double K : {1e6, 1e8, 1e10}) {
    const double m = 0.3, v = 0.8, zeta = 0.2, D = 2 * zeta * std::sqrt(K * m);
    const auto s = penalty_of(
        between_walls(fmt::format("contact = \"kelvin-voigt\"\nkelvin_stiffness = {:.17g}\n"
                                  "kelvin_damping = {:.17g}\nintegrator = \"dopri5\"\n"
                                  "tolerance = 1e-13\n",
                                  K, D)),
        {"event.2.v_n_minus", "event.1.impulse_n"}, {"penalty.kelvin_damping", "bodies.ball.mass"});
    const double phi = std::acos(zeta), cot = zeta / std::sin(phi), e = std::exp(-2 * phi * cot);
    // de/dζ = e (2 φ/sin² φ − 2 cot φ) · (−1/sin φ)
    const double by_zeta = -e * (2 * phi / std::pow(std::sin(phi), 2) - 2 * cot) / std::sin(phi);
    const double by_damping = by_zeta * zeta / D, by_mass = -by_zeta * zeta / (2 * m);
    CAPTURE(K);
    CHECK(s.quantities[0].value == Approx(-e * v).epsilon(1e-9));
    CHECK(s.quantities[0].derivatives[0] == Approx(-v * by_damping).epsilon(bound));
    CHECK(s.quantities[0].derivatives[1] == Approx(-v * by_mass).epsilon(bound));
    CHECK(s.quantities[1].derivatives[0] == Approx(m * v * by_damping).epsilon(bound));
    CHECK(s.quantities[1].derivatives[1] == Approx(v * (1 + e) + m * v * by_mass).epsilon(bound));
  }
}

TEST_CASE("derivatives of random penalty runs equal extrapolated differences of runs", "[sensitivity]") {
  // Two scenes of each kind with either integrator.
  const auto found = compare_random(
      8, 20261126, compliant, "penalty", [](const std::string&) { return 1e-5; }, false);
  CHECK(found.compared > 30);
}

TEST_CASE("estimated errors bound those of derivatives of random penalty runs", "[sensitivity][slow]") {
  const auto found =
      compare_random(26, 20261126, compliant, "penalty", [](const std::string&) { return 1e-5; });
  INFO(found.summary());
  CHECK(found.compared > 100);
  CHECK(found.silent == 0);
  CHECK(found.beyond <= 0.05 * found.compared);
}
