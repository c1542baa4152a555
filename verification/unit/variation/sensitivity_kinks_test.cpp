// Derivatives of event-driven runs whose forces have kinks and limits, and of contacts in positions
// where rounding matters.
#include "analysis/sensitivity.hpp"

#include "verification/support/rig.hpp"
#include "verification/unit/variation/varied_scenes.hpp"

using namespace freeplay;
using namespace freeplay::test::varied;

namespace {

Sensitivities by_way(const test::Way& way, const std::string& text, std::vector<std::string> of,
                     std::vector<std::string> to) {
  return sensitivities(
      test::scene_by(way, text),
      {.of = std::move(of), .to = std::move(to), .formulation = std::string(test::name_of(way.family))});
}

}  // namespace

TEST_CASE("derivatives jump where a governor leaves its limit", "[sensitivity]") {
  // At the limit T the speed is T t/J and the integral is held at 0. The governor leaves it at the
  // speed ω₁ = ω₀ − T/p. From there, J ë + p ė + i e = 0 for e = ω₀ − ω, with e = T/p and ė = −T/J.
  const auto angle = [](long double T, long double p, long double target) {
    const long double J = 0.03L, i = 3, w = target - T / p, t = J * w / T, s = 1 - t;
    const long double root = std::sqrt(p * p - 4 * J * i), a = (-p + root) / (2 * J),
                      b = (-p - root) / (2 * J), A = (-T / J - b * T / p) / (a - b), B = T / p - A;
    return T / J * t * t / 2 + target * s - A / a * (std::exp(a * s) - 1) - B / b * (std::exp(b * s) - 1);
  };
  const auto q =
      of(test::body("rot", 1, 0.03) + test::pin("a", "ground", "rot") +
             test::drive("m", "a",
                         "target_speed = 10\nproportional = 0.7\nintegral = 3\ntorque_limit = 1.8\n") +
             test::run_for(1, "start = \"given\"\n") + by_events,
         {"end.rot.theta"}, {"drives.m.torque_limit", "drives.m.proportional", "drives.m.target_speed"})
          .quantities[0];
  CHECK(q.value == Approx(static_cast<double>(angle(1.8L, 0.7L, 10))).epsilon(1e-10));
  const auto slope = [&](auto at) {
    constexpr long double h = 1e-4L;
    return static_cast<double>((8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h));
  };
  // The rates on both sides are extrapolated, with an error of about 1e-8.
  check_derivatives(q,
                    {slope([&](auto d) { return angle(1.8L + d, 0.7L, 10); }),
                     slope([&](auto d) { return angle(1.8L, 0.7L + d, 10); }),
                     slope([&](auto d) { return angle(1.8L, 0.7L, 10 + d); })},
                    1e-7);
  for (const double error : q.errors) CHECK(error < 1e-6);
}

TEST_CASE("derivatives follow the kinks of a damping table", "[sensitivity]") {
  // Expected: by the motion between the kinks in closed form, differenced in 20 digits.
  const auto text = test::body("p", 1, 0.05, "angular_velocity = 4\n") + test::pin("h", "ground", "p") +
                    test::torsion("s", "ground", "p", 5,
                                  "damping_table = [[-6, -0.9], [-3, -0.1], [0, 0], [3, 0.1], [6, 0.9]]\n") +
                    test::run_for(3, "start = \"given\"\n[penalty]\ntolerance = 1e-10\n");
  for (const auto& [way, bound] :
       {std::pair{test::event_driven, 1e-6}, {test::penalty, 1e-6}, {test::fixed_steps(5e-5), 1e-3}}) {
    INFO(way.name);
    const auto s = by_way(way, text, {"end.p.theta", "end.p.omega"}, {"initial.p.omega"});
    check_derivatives(s.quantities[0], {-0.01702247}, bound);
    check_derivatives(s.quantities[1], {0.03725622}, bound);
  }
}

TEST_CASE("derivatives jump where a damped bump stop begins", "[sensitivity]") {
  // Free motion at v to u, then y = x − u with m ÿ + d ẏ + k y = 0 from (0, v); s is the time since then.
  const double m = 1, d = 5, k = 200, v = 2, u = 0.3, T = 0.25, s = T - u / v, a = d / (2 * m),
               w = std::sqrt(k / m - a * a), y = v / w * std::exp(-a * s) * std::sin(w * s),
               rate = v * std::exp(-a * s) * (std::cos(w * s) - a / w * std::sin(w * s)),
               bend = -(d * rate + k * y) / m;
  const auto text = test::body("p", m, 0.01, "velocity = [2, 0]\n") + test::guide("guide", "ground", "p") +
                    "[loads.b]\ntype = \"bump-stop\"\nbetween = [\"ground\", \"p\"]\nupper = 0.3\n"
                    "stiffness = 200\ndamping = 5\n" +
                    test::run_for(T, "start = \"given\"\n");
  for (const auto& [way, bound] :
       {std::pair{test::event_driven, 1e-8}, {test::penalty, 1e-7}, {test::fixed_steps(1e-4), 1e-2}}) {
    INFO(way.name);
    const auto s = by_way(way, text, {"end.p.x", "end.p.vx"}, {"loads.b.upper", "initial.p.vx"});
    check_derivatives(s.quantities[0], {1 - rate / v, y / v + rate * u / (v * v)}, bound);
    check_derivatives(s.quantities[1], {-bend / v, rate / v + bend * u / (v * v)}, bound);
  }
}

TEST_CASE("an approach far from the origin of a body does not graze", "[sensitivity]") {
  // A body at height h under an upward acceleration g approaches a wall at v; the gap closes at the
  // rate r with r² = v² − 2 g h = 0.067², and dt/dh = 1/r. The points of contact are 250 m below
  // the body's origin.
  const double h = 0.5, g = 9.81, r = 0.067, v = std::sqrt(r * r + 2 * g * h);
  const auto q =
      of("gravity = [0, 9.81]\n" +
             test::body("toy", 1, 1, fmt::format("position = [0, {}]\nvelocity = [0, {:.17g}]\n", h, -v)) +
             test::plane("wall", "ground", "toy", 0, "s", "at = [[0, -250], [0, -250]]\n") +
             test::surface("s", 0.5) +
             test::run_for(0.4, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n"),
         {"event.1.t"}, {"initial.toy.y"})
          .quantities[0];
  CHECK(q.derivatives[0] == Approx(1 / r).epsilon(1e-6));
}

TEST_CASE("a slider that lies flat does not turn with its clearance", "[sensitivity]") {
  const auto q = of(test::file_text(test::scene_file("tests/slider_on_flat")), {"end.sl.theta", "end.sl.y"},
                    {"joints.g.clearance"});
  // Both corners of its lower side are closed: θ = 0 and y = −c for every clearance c.
  CHECK(std::abs(q.quantities[0].derivatives[0]) < 1e-9);
  CHECK(q.quantities[1].derivatives[0] == Approx(-1).epsilon(1e-9));
}

TEST_CASE("rounding errors of an impact are no kink", "[sensitivity]") {
  const auto q = of(test::file_text(test::scene_file("tests/four_bar_on_spring")), {"end.coupler.theta"},
                    {"joints.D.at[0][0]"})
                     .quantities[0];
  CHECK(q.reasons[0].empty());
  CHECK(q.errors[0] < 1e-4 * std::abs(q.derivatives[0]));
}

TEST_CASE("derivatives of elements with kinks and limits equal extrapolated differences of runs",
          "[sensitivity]") {
  const auto found = compare_random(
      30, 20261128, [](int, auto& r) { return with_elements(r); }, "nonsmooth",
      [](const std::string&) { return 1e-5; });
  WARN(found.summary());
  CHECK(found.compared > 90);
  CHECK(found.silent == 0);
  CHECK(found.beyond <= 0.05 * found.compared);
}

TEST_CASE("derivatives jump where a disc passes the end of a face", "[sensitivity][outline]") {
  // A disc slides at v off a face, around its rounded end and away (closed form of its leaving: see
  // outline_runs_test.cpp). A longer face moves its later path by δ along x and by δ/v in time:
  // ∂x/∂δ = 1 − v_x/v, ∂y/∂δ = −v_y/v.
  const double v = 0.5, R = 0.1, r = 0.02, g = 9.81, rho = R + r;
  const auto text = "gravity = [0, -9.81]\n" +
                    test::body("disc", 1, 0.5,
                               "position = [-0.09, 0.12]\nvelocity = [0.5, 0]\nangle = 0\n"
                               "angular_velocity = 0\n") +
                    test::surface("s", 0, "young = 2e11\npoisson = 0.3\n") +
                    "[contacts.side]\ntype = \"outline\"\nbetween = [\"ground\", \"disc\"]\n"
                    "points = [[-1, 0], [0.01, 0]]\ncorner_radius = 0.02\nradius = 0.1\nsurface = \"s\"\n" +
                    test::run_for(0.48, "start = \"given\"\n");
  const auto s = by_way(test::event_driven, text, {"end.disc.x", "end.disc.y", "end.disc.vx", "end.disc.vy"},
                        {"contacts.side.points[1][0]"});
  const double cosine = 2.0 / 3 + v * v / (3 * g * rho), speed = std::sqrt(g * rho * cosine);
  const double vx = speed * cosine, vy = s.quantities[3].value;
  CHECK(s.quantities[2].value == Approx(vx).epsilon(1e-6));
  check_derivatives(s.quantities[0], {1 - vx / v}, 1e-5);
  check_derivatives(s.quantities[1], {-vy / v}, 1e-5);
  check_derivatives(s.quantities[2], {0}, 1e-5, 1e-5);
  check_derivatives(s.quantities[3], {g / v}, 1e-5);  // −v̇_y/v
}
