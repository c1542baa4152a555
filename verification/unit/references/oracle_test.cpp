// The oracle (verification/references/slider_crank_oracle.hpp), compared with facts that it is not
// computed from: differences, Lagrange's equation, elliptic functions, balances of
// momentum.
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <catch2/catch.hpp>
#include <cmath>

#include "verification/references/slider_crank_oracle.hpp"
#include "verification/unit/references/reference_checks.hpp"

using namespace freeplay::reference;

TEST_CASE("Cooper and Verner's method: row sums and measured order", "[references]") {
  const CooperVerner<Long> method;
  for (std::size_t i = 0; i < method.stages; ++i) {
    Long sum = 0;
    for (const Long a : method.a[i]) sum += a;
    within(sum, method.c[i], 1e-17L, "coefficients up to 20 in long double");
  }
  const auto error = [&](int steps) {
    std::array<Long, 2> y{1, 0};  // y₀ = exp(sin t), y₁ = t² y₀/2 made to depend on both
    const Long h = 3.0L / steps;
    const auto f = [](Long t, const std::array<Long, 2>& at) {
      return std::array<Long, 2>{at[0] * std::cos(t), t * at[0] + at[1] * std::cos(t)};
    };
    for (int i = 0; i < steps; ++i) y = method.step(f, i * h, y, h);
    return std::abs(y[0] - std::exp(std::sin(3.0L))) + std::abs(y[1] - 4.5L * std::exp(std::sin(3.0L)));
  };
  for (const int steps : {12, 24, 48}) {
    const Long order = std::log2(error(steps) / error(2 * steps));
    INFO("order " << order);
    CHECK(order > 7.5L);
    CHECK(order < 8.5L);
  }
}

namespace {

using Mechanism = LooseSliderCrank<Long>;
using State = LooseState<Long>;
using Point = std::array<Long, 2>;

/// Bearing centre (rod's end) at the time t and rod angle θ.
Point bearing_centre(const Mechanism& m, Long t, Long theta) {
  const Long phi = m.start_angle + m.speed * t;
  return {m.crank_length * std::cos(phi) + m.rod_length * std::cos(theta),
          m.crank_length * std::sin(phi) + m.rod_length * std::sin(theta)};
}

Long distance(const Mechanism& m, Long t, Long theta, Long x) {
  const Point b = bearing_centre(m, t, theta);
  return std::hypot(x - b[0], b[1]);
}

const Long some_t = 0.0123L;
const State some_state{-0.11L, -1.7L, 0.3455L, -0.6L, 0, 0};

/// Free flight from the ideal start at φ₀ = 0, where ψ = φ − θ is a rotating pendulum:
///
///     sin(ψ/2) = sn(ψ̇₀ t/2, k).
State closed_flight(const Mechanism& m, Long t) {
  const Long rate = m.speed * (1 + m.crank_length / m.rod_length);
  const Long stiffness =
      m.rod_mass * m.rod_centre * m.crank_length * m.speed * m.speed / m.rod_inertia_about_pin();
  Long cn = 1, dn = 1;
  const Long sn = boost::math::jacobi_elliptic(2 * std::sqrt(stiffness) / rate, rate * t / 2, &cn, &dn);
  return {m.speed * t - 2 * std::atan2(sn, cn), m.speed - rate * dn, m.crank_length + m.rod_length, 0, 0, 0};
}

OracleRun<Long> nonsmooth_run(Long friction, Long e, Long end = 0.02L, int most = 10000) {
  Mechanism m;
  m.friction = friction;
  OracleOptions<Long> options;
  options.most_impacts = most;
  return SliderCrankOracle<Long>(m, options).nonsmooth(e, end);
}

}  // namespace

TEST_CASE("oracle: contact rows are the derivatives of gap and surface motion", "[references]") {
  const Mechanism m;
  const Long t = some_t, theta = some_state[0], x = some_state[2];
  const GudgeonContact<Long> k = gudgeon_contact(m, t, some_state);
  const Long length = distance(m, t, theta, x);
  const char* why = "h⁴ truncation below 1e-14 for |e| near 5 mm and h = 1e-6; rounding 1e-19/1e-6";
  within(k.delta, length - m.clearance, 1e-18L, "the same distance");
  within(k.w_n[0], slope([&](Long a) { return -distance(m, t, a, x); }, theta, 1e-6L), 1e-11L, why);
  within(k.w_n[1], slope([&](Long a) { return -distance(m, t, theta, a); }, x, 1e-6L), 1e-11L, why);
  within(k.drive_n, slope([&](Long a) { return -distance(m, a, theta, x); }, t, 1e-6L), 1e-11L, why);
  within(k.u_n,
         slope([&](Long a) { return -distance(m, t + a, theta + some_state[1] * a, x + some_state[3] * a); },
               0, 1e-6L),
         1e-11L, why);

  // Sliding: the pin's point P + R_j n and the rod's point B + R_i n, each carried along with its
  // body.
  const Point b = bearing_centre(m, t, theta);
  const Point n{(x - b[0]) / length, -b[1] / length};
  const auto rod_point = [&](Long a) {
    const Long turn = some_state[1] * a, r = m.bearing_radius;
    const Point at = bearing_centre(m, t + a, theta + turn);
    const Long nx = n[0] * std::cos(turn) - n[1] * std::sin(turn),
               ny = n[0] * std::sin(turn) + n[1] * std::cos(turn);
    return -n[1] * (at[0] + r * nx) + n[0] * (at[1] + r * ny);  // along the fixed t
  };
  within(k.u_t, -n[1] * some_state[3] - slope(rod_point, 0, 1e-4L), 1e-12L,
         "pin less rod; truncation h⁴ r ω⁵/30 = 7e-13");
}

TEST_CASE("oracle: the rod's equation of motion is Lagrange's", "[references]") {
  const Mechanism m;
  const auto energy = [&](Long t, Long theta, Long rate) {  // from the centre of mass' velocity
    const Long phi = m.speed * t, w = m.crank_length * m.speed, s = m.rod_centre;
    const Long vx = -w * std::sin(phi) - s * rate * std::sin(theta),
               vy = w * std::cos(phi) + s * rate * std::cos(theta);
    return (m.rod_mass * (vx * vx + vy * vy) + m.rod_inertia * rate * rate) / 2;
  };
  const Long theta = some_state[0], rate = some_state[1];
  const Long acceleration = loose_rates(m, some_t, some_state)[1];
  const auto momentum =
      [&](Long a) {  // ∂T/∂θ̇ along the motion; T is quadratic in θ̇, so the difference is exact
        const Long at = theta + a * (rate + acceleration * a / 2), v = rate + acceleration * a;
        return (energy(some_t + a, at, v + 1) - energy(some_t + a, at, v - 1)) / 2;
      };
  const Long force = slope([&](Long a) { return energy(some_t, a, rate); }, theta, 1e-3L);
  within(slope(momentum, 0, 1e-4L), force, 5e-12L,
         "d/dt ∂T/∂θ̇ = ∂T/∂θ; truncation h⁴ m s r ω (ω − θ̇)⁵/30 = 3.5e-12");
  CHECK(std::abs(force) > 0.01L);  // not a test of 0 = 0
}

TEST_CASE("oracle: flight and first contact agree with elliptic functions", "[references]") {
  const Mechanism m;
  const char* why = "a dozen roundings of numbers of order one in long double; the modulus costs 1/k′²";
  const OracleRun<Long> before = SliderCrankOracle<Long>(m).nonsmooth(0.46L, 4.4e-3L);
  CHECK(before.impacts.empty());
  CHECK((before.end == OracleEnd::end_time && before.t == 4.4e-3L));
  for (const std::size_t i : {0u, 1u, 2u, 3u})
    within(before.state[i], closed_flight(m, 4.4e-3L)[i], 3e-17L, why);

  const auto gap = [&](Long t) {
    return m.clearance - distance(m, t, closed_flight(m, t)[0], closed_flight(m, t)[2]);
  };
  std::uintmax_t most = 200;
  const auto root =
      boost::math::tools::toms748_solve(gap, 4e-3L, 5e-3L, boost::math::tools::eps_tolerance<Long>(62), most);
  const OracleRun<Long> run = nonsmooth_run(0.01L, 0.46L);
  REQUIRE(run.impacts.size() > 5);
  const OracleImpact<Long>& first = run.impacts[0];
  within(first.t, root.first, 1e-17L, "rounding of e, 1e-19 m, over 0.11 m/s, and that of θ");
  within(first.v_n_minus, slope(gap, root.first, 1e-6L), 1e-12L, "h⁴ truncation; rounding 1e-19/1e-6");
  within(first.t, 4.42296e-3L, 5e-9L, "published value, half its last digit");
  within(first.v_n_minus, -0.112919L, 5e-7L, "published value, half its last digit");
  within(first.impulse_n, 0.16700L, 5e-6L, "published value, half its last digit");
}

TEST_CASE("oracle: the first impulse balances the momenta of rod and slider", "[references]") {
  for (const Long friction : {0.0L, 0.01L, 0.1L, 0.9L}) {
    Mechanism m;
    m.friction = friction;
    const OracleRun<Long> run = nonsmooth_run(friction, 0.46L, 0.02L, 1);
    REQUIRE(run.end == OracleEnd::most_impacts);
    const OracleImpact<Long>& i = run.impacts.at(0);
    const State before = closed_flight(m, i.t), &after = run.state;
    const Point b = bearing_centre(m, i.t, before[0]);
    const Point n{(before[2] - b[0]) / m.clearance, -b[1] / m.clearance};
    const Point pin{-i.impulse_n * n[0] - i.impulse_t * n[1],
                    -i.impulse_n * n[1] + i.impulse_t * n[0]};  // impulse on it
    const char* why = "balance to rounding; n from a distance of 2.5e-4 m known to 1e-19";
    within(m.slider_mass * (after[3] - before[3]), pin[0], 1e-14L, why);
    const Long phi = m.speed * i.t;
    const Point arm{b[0] + m.bearing_radius * n[0] - m.crank_length * std::cos(phi),
                    b[1] + m.bearing_radius * n[1] - m.crank_length * std::sin(phi)};
    within(m.rod_inertia_about_pin() * (after[1] - before[1]), -arm[0] * pin[1] + arm[1] * pin[0], 1e-14L,
           why);
    const GudgeonContact<Long> then = gudgeon_contact(m, i.t, after);
    within(then.u_n, -0.46L * i.v_n_minus, 1e-14L, "Newton's restitution in the motion itself");
    within(then.u_t, i.v_t_plus, 1e-14L, "sliding in the motion itself");
    if (friction == 0.9L) CHECK(i.v_t_plus == 0);  // sticks
  }
}
