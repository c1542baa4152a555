// Detection of events shorter than an integration step: pegs in free flight, pulses of a table,
// simultaneous contacts, and friction too steep for an explicit step.
#include <random>

#include "io/scene/read_scene.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/bouncing_ball.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

constexpr Integrator integrators[] = {Integrator::dopri5, Integrator::bulirsch_stoer,
                                      Integrator::adams_bashforth_moulton, Integrator::rosenbrock4,
                                      Integrator::rk4};

Scene scene_of(const reference::Throw& s, double spin, double duration) {
  Scene scene;
  auto& m = scene.mechanism;
  m.bodies.push_back({"ball", 0.2, 1e-5, {s.x, s.y}, 0, {s.vx, s.vy}, spin});
  m.surfaces.push_back(test::steel(0.6));
  DiscContact peg;
  peg.name = "peg";
  peg.between = {ground, 0};
  peg.radii = {0.4 * s.reach, 0.6 * s.reach};
  peg.surface = 0;
  m.contacts.push_back(peg);
  scene.run.duration = duration;
  scene.run.start = RunOptions::Start::given;
  return scene;
}

/// Sums over the runs of throws at a peg.
struct Throws {
  int missed = 0, invented = 0, stopped = 0, touches = 0;
  /// greatest relative errors of the contact time and the approach speed
  double time = 0, approach = 0;
};

void judge_throw(Throws& sum, const Result& run, const std::optional<reference::PegTouch>& exact) {
  if (run.ending.status != Ending::Status::finished) ++sum.stopped;
  const auto found = test::touches(run);
  if (!exact) {
    sum.invented += !found.empty();
    return;
  }
  ++sum.touches;
  if (found.empty()) {
    ++sum.missed;
    return;
  }
  sum.time = greatest(sum.time, std::abs(found[0].t / exact->t - 1));
  sum.approach = greatest(sum.approach, std::abs(-found[0].v_n_minus / exact->approach - 1));
}

/// Throws over four decades of speed; a third of them graze the peg, by 1e-9 of the reach or more.
Throws throws(int count) {
  Throws sum;
  std::mt19937_64 engine(16);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < count; ++i) {
    const double speed = std::pow(10, -1 + 4 * uniform(engine)), reach = 0.05,
                 away = reach * (3 + 200 * uniform(engine));
    double off = (2 * uniform(engine) - 1) * 1.1;
    if (i % 3 == 0)
      off = std::copysign(1 + (uniform(engine) < 0.5 ? -1 : 1) * std::pow(10, -9 + 6 * uniform(engine)), off);
    const double turn = 2 * M_PI * uniform(engine), c = std::cos(turn), s = std::sin(turn),
                 across = off * reach;
    const reference::Throw one{-away * c - across * s, -away * s + across * c, speed * c, speed * s, reach};
    const auto exact = reference::touch_of(one);
    auto scene = scene_of(one, speed / reach * (uniform(engine) - 0.5), 3 * away / speed);
    for (const auto integrator : integrators) {
      // its fixed step would have to resolve the contact
      if (integrator == Integrator::rk4) continue;
      scene.penalty.integrator = integrator;
      judge_throw(sum, test::simulate(scene, Family::penalty), exact);
    }
    scene.nonsmooth.scheme = Scheme::event_driven;
    judge_throw(sum, test::simulate(scene, Family::nonsmooth), exact);
  }
  return sum;
}

Scene rotor(const char* against) {
  return parse_scene(
      test::body("rotor", 1, 0.5, "angular_velocity = 10\n") + test::pin("pin", "ground", "rotor") +
          test::drive(
              "motor", "pin",
              fmt::format("against = \"{}\"\ntorque_table = [[1.0, 0.0], [1.001, 1000.0], [1.002, 0.0]]\n",
                          against)) +
          test::run_for(10, "start = \"given\"\n"),
      "rotor");
}

/// Greatest error of the final speed over the integrators, relative.
double worst_speed(Scene scene, double expected) {
  double worst = 0;
  for (const auto integrator : integrators) {
    if (integrator == Integrator::rk4) continue;  // a fixed step
    scene.penalty.integrator = integrator;
    worst = greatest(worst, std::abs(test::simulate(scene, Family::penalty).final_state.v[2] / expected - 1));
  }
  scene.nonsmooth.scheme = Scheme::event_driven;
  return greatest(worst, std::abs(test::simulate(scene, Family::nonsmooth).final_state.v[2] / expected - 1));
}

void tables(Findings& f) {
  const char* const by_angle = "rotor with a torque pulse of 2 mrad per turn";
  const char* const adaptive = "adaptive integrators and event-driven";
  const auto angle = rotor("angle");
  const double expected =
      reference::speed_after_pulses(10, 0.5, 1, reference::pulses_by(10, 10, 0.5, 1, 1.001));
  f.at_most(claim_name(by_angle, "speed after 10 s, greatest relative error", adaptive), "",
            worst_speed(angle, expected), 1e-6, "½ J ω² = ½ J ω₀² + n W",
            "tolerance 1e-8 per step, some hundred steps");
  auto stepped = angle;
  stepped.nonsmooth.scheme = Scheme::moreau_jean;
  stepped.nonsmooth.step = 1e-3;
  f.at_most(claim_name(by_angle, "speed after 10 s, greatest relative error", "Moreau–Jean, h = 1e-3 s"), "",
            std::abs(test::simulate(stepped, Family::nonsmooth).final_state.v[2] / expected - 1),
            19 * 1e-3 * 0.1, "½ J ω² = ½ J ω₀² + n W",
            "a step, longer than the pulse, "
            "resolves the angle to (h ω)²/2 = 1e-4 of 1e-2 rad swept: a hundredth of each of 19 "
            "pulses, margin of ten");
  const double pulsed = 10 + 1000 * 1e-3 / 0.5;  // the pulse's area over J
  f.at_most(
      claim_name("rotor with a torque pulse of 2 ms", "speed after 10 s, greatest relative error", adaptive),
      "", worst_speed(rotor("time"), pulsed), 1e-9, "J Δω = ∫ M dt",
      "rounding, since each piece is a polynomial, and tolerance 1e-8 of the speed's scale");
}

/// Balls side by side that reach the floor at the same instant.
void at_once(Findings& f) {
  constexpr int count = 64;
  Scene scene;
  auto& m = scene.mechanism;
  m.gravity = {0, -9.81};
  m.surfaces.push_back(test::steel(0.7));
  for (int i = 0; i < count; ++i) {
    m.bodies.push_back({fmt::format("b{}", i), 1, 0.004, {static_cast<double>(i), 1}, 0, {0, 0}, 0});
    PlaneContact floor;
    floor.name = fmt::format("c{}", i);
    floor.between = {ground, i};
    floor.radius = 0.1;
    floor.surface = 0;
    m.contacts.push_back(floor);
  }
  scene.run.duration = 1;
  scene.run.start = RunOptions::Start::given;
  int finished = 0;
  double apart = 0;
  const double exact = std::sqrt(2 * 0.9 / 9.81);
  for (const auto integrator : integrators) {
    if (integrator == Integrator::rk4 || integrator == Integrator::rosenbrock4) continue;
    scene.penalty.integrator = integrator;
    const auto run = test::simulate(scene, Family::penalty);
    finished += run.ending.status == Ending::Status::finished;
    const auto touches = test::touches(run);
    for (std::size_t i = 0; i < std::min<std::size_t>(touches.size(), count); ++i)
      apart = greatest(apart, std::abs(touches[i].t - exact));
  }
  f.within("64 balls reaching the floor at one instant: integrators of three that finish [penalty]", "",
           finished, 3, 0, "all", "exact");
  f.at_most("64 balls reaching the floor at one instant: times of first contact, greatest error [penalty]",
            "s", apart, 1e-12, "√(2h/g)", "rounding of 1 m and 64 m over 4 m/s: free fall is a polynomial");
}

/// Steep friction: an impact at 250 m/s with sliding at 100 m/s, µ = 1, friction regularised below
/// 1 mm/s.
void steep(Findings& f) {
  auto scene = read_scene(test::scene_file("steep_friction"));
  int finished = 0;
  double worst = 0;
  // Slip ends within the contact: P_T = v_T/D_TT, v_T = 100 m/s at the rim, D_TT = 1/m + R²/J.
  const double grip = 100 / (1 / 0.12 + 0.006 * 0.006 / 2e-6);
  for (const auto integrator : integrators) {
    if (integrator == Integrator::rk4) continue;
    scene.penalty.integrator = integrator;
    const auto run = test::simulate(scene, Family::penalty);
    finished += run.ending.status == Ending::Status::finished;
    worst =
        greatest(worst, run.events.empty() ? NAN : std::abs(std::abs(run.events[0].impulse_t) / grip - 1));
  }
  f.within("impact with steep regularised friction: integrators of four that finish [penalty]", "", finished,
           4, 0, "all", "exact");
  f.at_most("impact with steep regularised friction: friction impulse, greatest relative error [penalty]", "",
            worst, 1e-4, "v_T/D_TT: slip ends within the contact",
            "the remaining slip is the regularising speed or less, 1e-4 of 100 m/s at most");
}

void throws_at_peg(Findings& f) {
  const int count = 60;
  const auto all = throws(count);
  const auto name = [&](const char* quantity) {
    return claim_name(fmt::format("{} throws at a peg at 0.1 to 1000 m/s", count), quantity,
                      "adaptive integrators and event-driven");
  };
  f.within(name("contacts missed"), "", all.missed, 0, 0, "quadratic equation",
           "exact: the gap is bounded over each step, not sampled");
  f.within(name("contacts reported without one"), "", all.invented, 0, 0, "quadratic equation",
           "exact: the gap is bounded over each step, not sampled");
  f.within(name("runs that do not finish"), "", all.stopped, 0, 0, "0", "exact");
  f.at_most(
      name("time of contact, greatest relative error"), "", all.time, 1e-8, "quadratic equation",
      "a grazing contact of depth d is located to √(ε/d) of its chord, ε = 1e-16 and d = 1e-9 of the reach");
}

}  // namespace

Parts missed_contacts() { return {throws_at_peg, tables, at_once, steep}; }

}  // namespace freeplay::verification
