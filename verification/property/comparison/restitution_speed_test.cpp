// Restitution that depends on the approach speed: a bouncing ball by Johnson's decay and by a table, in
// every scheme against recurrences in closed form.
//
// By Johnson's decay beyond v_y, with the approach speeds v_k of successive impacts,
//
//     v_{k+1} = e₀ v_k^(3/4) v_y^(1/4)    ⇒    v_{k+1}/v_y = e₀^{4(1 − q)} (v_1/v_y)^q,   q = (3/4)^k
//
// while v_k > v_y, and t_{k+1} = t_k + 2 v_{k+1}/g.
#include "formulations/contact/contact_law.hpp"
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/scene_text.hpp"
#include "verification/unit/variation/varied_scenes.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

constexpr double height = 0.5, gravity = 9.81, e0 = 0.95, yield = 0.05;
const double first = std::sqrt(2 * gravity * height);

/// A ball of steel that falls from `height`; `surface`: keys of its restitution.
std::string ball(const std::string& surface, double duration) {
  return fmt::format("gravity = [0, {}]\n", -gravity) +
         test::body("ball", 0.3, 3e-4, fmt::format("position = [0, {}]\n", 0.05 + height)) +
         test::plane("floor", "ground", "ball", 0.05, "s") + "[surfaces.s]\nyoung = 207e9\npoisson = 0.3\n" +
         surface + test::run_for(duration, "start = \"given\"\n");
}
std::string johnson(double duration) {
  return ball(fmt::format("restitution = {}\nyield_speed = {}\n", e0, yield), duration);
}

/// v of the k-th impact, k ≥ 1.
double johnson_speed(int k) {
  const double q = std::pow(0.75, k - 1);
  return yield * std::pow(e0, 4 * (1 - q)) * std::pow(first / yield, q);
}

/// Times and speeds of the first impacts of a run.
void check_impacts(const Result& run, double (*speed)(int), int impacts, double relative) {
  const auto found = test::touches(run);
  REQUIRE(static_cast<int>(found.size()) >= impacts);
  double t = first / gravity;
  for (int k = 1; k <= impacts; ++k) {
    CAPTURE(k);
    const auto& event = found[static_cast<std::size_t>(k) - 1];
    CHECK(event.t == Approx(t).epsilon(relative));
    CHECK(-event.v_n_minus == Approx(speed(k)).epsilon(relative));
    CHECK(event.v_n_plus == Approx(speed(k + 1)).epsilon(relative));
    t += 2 * speed(k + 1) / gravity;
  }
}

/// e of the table [[0.2, 0.9], [1, 0.6], [2, 0.5]].
double table_at(double v) {
  if (v <= 0.2) return 0.9;
  if (v >= 2) return 0.5;
  return v < 1 ? 0.9 - 0.3 * (v - 0.2) / 0.8 : 0.6 - 0.1 * (v - 1);
}
double table_speed(int k) {
  double v = first;
  for (int i = 1; i < k; ++i) v *= table_at(v);
  return v;
}
const std::string table = "restitution_table = [[0.2, 0.9], [1, 0.6], [2, 0.5]]\n";

}  // namespace

TEST_CASE("a ball whose restitution decays with its speed follows the recurrence", "[impact]") {
  // 3.13, 1.06, 0.47, 0.25, 0.16, 0.11 m/s, with e from 0.34 to 0.77: all beyond the yield speed.
  REQUIRE(johnson_speed(7) > yield);
  const auto text = johnson(0.75);
  // Rounding: free flight is a polynomial in time.
  check_impacts(test::finished(test::event_driven, text), johnson_speed, 6, 1e-10);
  check_impacts(test::finished(test::automatic, text), johnson_speed, 6, 1e-10);
  // A step over an impact moves the ball by the tolerance; the errors of six impacts add, and the
  // slowest is 0.04 of the first.
  check_impacts(test::finished(test::chosen_steps, text, {"nonsmooth.step_tolerance=1e-8"}), johnson_speed, 6,
                1e-6);
  // The impact acts up to a step late with the speed at its beginning: g h = 1e-5 m/s of 0.1 m/s, six times.
  check_impacts(test::finished(test::fixed_steps(1e-6), text), johnson_speed, 6, 1e-3);
}

TEST_CASE("a ball follows a table of restitution over the approach speed", "[impact]") {
  const auto text = ball(table, 0.95);
  check_impacts(test::finished(test::event_driven, text), table_speed, 4, 1e-10);
  check_impacts(test::finished(test::chosen_steps, text, {"nonsmooth.step_tolerance=1e-8"}), table_speed, 4,
                1e-6);
  check_impacts(test::finished(test::fixed_steps(1e-6), text), table_speed, 4, 1e-3);
}

TEST_CASE("Poisson's and the energetic law take the restitution at the approach speed", "[impact]") {
  for (const char* law : {"poisson", "energetic"})
    check_impacts(
        test::finished(test::event_driven, johnson(0.75), {fmt::format("nonsmooth.impact_law=\"{}\"", law)}),
        johnson_speed, 6, 1e-10);
}

TEST_CASE("a penalty contact delivers the restitution at its approach speed", "[impact]") {
  // The exact law delivers e of a free impact. The weight of 3 N beside contact forces above 300 N at
  // 0.11 m/s changes it by less than 1e-2.
  for (const char* integrator : {"dopri5", "rosenbrock4"}) {
    const auto found = test::touches(test::finished(test::penalty_by(integrator), johnson(0.75)));
    REQUIRE(found.size() >= 6);
    for (int i = 0; i < 6; ++i) {
      const auto& event = found[static_cast<std::size_t>(i)];
      const double v = -event.v_n_minus;
      CAPTURE(integrator, i, v);
      CHECK(event.v_n_plus / v == Approx(e0 * std::pow(v / yield, -0.25)).epsilon(1e-2));
    }
  }
  const auto found = test::touches(test::finished(test::penalty, ball(table, 0.95)));
  REQUIRE(found.size() >= 4);
  for (int i = 0; i < 4; ++i) {
    const auto& event = found[static_cast<std::size_t>(i)];
    CHECK(-event.v_n_plus / event.v_n_minus == Approx(table_at(-event.v_n_minus)).epsilon(1e-2));
  }
}

TEST_CASE("a constant table, and speeds below yield, are a constant restitution", "[impact]") {
  // Until after the bounces have ended. Bounds: rounding of e by interpolation, and the end of bounces.
  for (const auto& way : {test::event_driven, test::chosen_steps, test::penalty}) {
    CAPTURE(way.name);
    const auto constant = test::finished(way, ball("restitution = 0.5\n", 1.0));
    for (const char* surface :
         {"restitution_table = [[0, 0.5], [5, 0.5]]\n", "restitution = 0.5\nyield_speed = 10\n"}) {
      const auto run = test::finished(way, ball(surface, 1.0));
      CHECK(run.events.size() == constant.events.size());
      CHECK(run.final_state.q[1] == Approx(constant.final_state.q[1]).epsilon(1e-12));
      CHECK(run.ledger.contact == Approx(constant.ledger.contact).epsilon(1e-9));
    }
  }
}

TEST_CASE("restitution by speed is matched with the exact law, and refused with others", "[impact]") {
  CHECK_NOTHROW(Simulation(parse_scene(johnson(0.1), "s.toml"), "nonsmooth", {.matched = true}));
  const auto matched = [&](const std::string& surface) {
    return Simulation(parse_scene(ball(surface, 0.1), "s.toml", {"penalty.contact=flores"}), "nonsmooth",
                      {.matched = true});
  };
  CHECK_THROWS_WITH(matched("restitution = 0.9\nyield_speed = 0.1\n"),
                    Contains("surfaces.s.yield_speed") && Contains("--as-given"));
  CHECK_THROWS_WITH(matched(table), Contains("surfaces.s.restitution_table") && Contains("\"exact\""));
  CHECK_NOTHROW(matched("restitution = 0.9\n"));
  // χ is infinite at e = 0, at any speed of a table.
  CHECK_THROWS_WITH(
      Simulation(parse_scene(ball("restitution_table = [[0, 0.5], [1, 0]]\n", 0.1), "s.toml"), "penalty"),
      Contains("needs a restitution greater than 0"));
}

TEST_CASE("impact speeds have the derivatives of the recurrence", "[sensitivity]") {
  // v₂ = e₀ v₁^(3/4) v_y^(1/4), v₁² = w² + 2 g H with the speed w at the start.
  const double w = 1.0, v1 = std::hypot(w, first), v2 = e0 * std::pow(v1, 0.75) * std::pow(yield, 0.25);
  auto text = johnson(0.5);
  text.insert(text.find("[contacts"), fmt::format("velocity = [0, {}]\n", -w));
  const std::vector<std::string> keys = {"surfaces.s.restitution", "surfaces.s.yield_speed",
                                         "bodies.ball.velocity[1]"};
  const std::vector<double> expected = {-v2 / e0, -v2 / (4 * yield), 0.75 * v2 * w / (v1 * v1)};
  const auto by = [&](const char* formulation, std::vector<std::string> options) {
    return sensitivities(parse_scene(text, "s.toml", options),
                         {.of = {"event.2.v_n_minus"}, .to = keys, .formulation = formulation})
        .quantities[0];
  };
  // Differences of the impact law with steps of 1e-3: fifth order.
  const auto exact = by("nonsmooth", {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.tolerance=1e-12"});
  CHECK(exact.value == Approx(-v2).epsilon(1e-10));
  test::varied::check_derivatives(exact, expected, 1e-6);
  // Duration and weight during the contact change the speeds by 1e-3.
  test::varied::check_derivatives(by("penalty", {"penalty.tolerance=1e-10"}), expected, 1e-2);
}

TEST_CASE("the damping factor of a restitution by speed has its derivative by v0", "[laws]") {
  const auto scene = parse_scene(johnson(0.1), "s.toml");
  const auto facts = test::first_contact(scene);
  const auto law = make_contact_force(scene, facts);
  REQUIRE(law.by_speed);
  for (const double v : {0.01, 0.2, 3.0}) {
    CAPTURE(v);
    const double e = v < yield ? e0 : e0 * std::pow(v / yield, -0.25);
    CHECK((*law.by_speed)(v) == Approx(exact_damping_factor(e)).epsilon(1e-12));
    CHECK(delivered_restitution((*law.by_speed)(v)) == Approx(e).epsilon(1e-10));
    Dual<1> x(v);
    x.slope[0] = 1;
    const double h = 1e-5 * v, difference = ((*law.by_speed)(v + h) - (*law.by_speed)(v - h)) / (2 * h);
    // Both are differences of ∛ε.
    CHECK((*law.by_speed)(x).slope[0] == Approx(difference).epsilon(1e-6).margin(1e-12));
  }
}
