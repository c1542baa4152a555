// Derivatives of both formulations against closed forms, their agreement, and published cases in which
// differentiable simulators give wrong derivatives through impacts.
#include "analysis/sensitivity.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/sensitivity.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

constexpr double one_degree = M_PI / 180;

/// Ten digits; differences of fourth order and rounding allow eleven.
constexpr double ten_digits = 1e-10;
const char* const ten_digits_reason =
    "required: ten digits; differences of closed forms are exact to about 1e-11";

struct Case {
  Findings& f;
  std::string subject;
  Sensitivities all;
  std::string formulation = "event-driven";

  void expect(std::size_t quantity, std::size_t key, const std::string& unit, long double expected,
              const std::string& source, double bound = ten_digits,
              const char* reason = ten_digits_reason) const {
    const auto name = claim_name(
        subject, fmt::format("d({})/d({})", all.quantities[quantity].name, all.keys[key]), formulation);
    const double measured = all.quantities[quantity].derivatives[key];
    if (expected == 0 || bound < 0)
      f.within(name, unit, measured, static_cast<double>(expected), std::abs(bound), source, reason);
    else
      f.relative(name, unit, measured, static_cast<double>(expected), bound, source, reason);
  }
};

std::string event_scheme(const char* more = "") {
  return fmt::format("[nonsmooth]\nscheme = \"event-driven\"\n{}", more);
}

void dropped_ball(Findings& f) {
  const auto ball = [](double gravity, const char* start, double restitution, double duration) {
    return fmt::format("gravity = [0, {}]\n", gravity) + test::body("ball", 0.3, 3e-4, start) +
           test::plane("table", "ground", "ball", 0.05, "hard") + test::surface("hard", restitution) +
           test::run_for(duration, "start = \"given\"\n") + event_scheme();
  };
  const auto text = [&](double duration) { return ball(-9.81, "position = [0, 0.55]\n", 0.5, duration); };
  const reference::BallDerivatives b{0.5L, 9.81L, 0.5L};
  const std::string source = "geometric series of flights";
  const Case bounces{f, "ball dropped from 0.5 m",
                     sensitivities(parse_scene(text(0.85), "ball"),
                                   {.of = {"event.1.t", "event.3.t", "event.3.v_n_minus",
                                           "energy.dissipated_in_contacts", "mean.table.fn"},
                                    .to = {"surfaces.hard.restitution", "initial.ball.y", "gravity[1]",
                                           "bodies.ball.mass"}})};
  bounces.expect(0, 0, "s", 0, source, 1e-15, "the restitution does not act before the first impact");
  bounces.expect(0, 1, "s/m", b.time_by_height(1), source);
  bounces.expect(0, 2, "s³/m", -b.time_by_gravity(1), source);
  bounces.expect(1, 0, "s", b.time_by_restitution(3), source);
  bounces.expect(1, 1, "s/m", b.time_by_height(3), source);
  bounces.expect(1, 2, "s³/m", -b.time_by_gravity(3), source);
  bounces.expect(2, 0, "m/s", -b.speed_by_restitution(3), source);
  // Impacts at 0.319, 0.639 and 0.798 s.
  bounces.expect(3, 0, "J", 0.3L * b.loss_by_restitution(3), source);
  bounces.expect(4, 0, "N", b.mean_force_by_restitution(3, 0.3L, 0.85L), "balance of momentum");
  // Programs that differentiate a discrete map or omit the motion of the event give 1 or −e here.
  const Case once{
      f, "ball dropped from 0.5 m, one impact",
      sensitivities(parse_scene(text(0.5), "ball"), {.of = {"end.ball.y"}, .to = {"initial.ball.y"}})};
  once.expect(0, 0, "", b.end_by_height(0.5L),
              "uniform acceleration; the kind of case of brax issue 73 and diffrax issue 729");
  const Case bounced{
      f, "elastic ball without gravity, one impact",
      sensitivities(parse_scene(ball(0, "position = [0, 2.95]\nvelocity = [0, -5]\n", 1, 1), "ball"),
                    {.of = {"end.ball.y"}, .to = {"initial.ball.y"}})};
  bounced.expect(0, 0, "", -1, "uniform motion; the kind of case of github.com/google/brax/issues/317");
  // The last contact event is the onset of rest.
  const auto scene = parse_scene(text(1), "ball");
  const auto last = test::touches(test::simulate(scene, Family::nonsmooth)).size();
  const Case rest{f, "ball dropped from 0.5 m",
                  sensitivities(scene, {.of = {fmt::format("event.{}.t", last)},
                                        .to = {"surfaces.hard.restitution", "initial.ball.y"}})};
  f.within(claim_name("ball dropped from 0.5 m", "time of rest", "event-driven"), "s",
           rest.all.quantities[0].value, static_cast<double>(b.rest()), 1e-9, source,
           "the accumulation of impacts is ended in closed form");
  rest.expect(0, 0, "s", b.rest_by_restitution(), source, 1e-8,
              "the tail of the accumulation ends at bounces of 1e-9 of the radius");
  rest.expect(0, 1, "s/m", b.rest() / (2 * b.height), source, 1e-8,
              "the tail of the accumulation ends at bounces of 1e-9 of the radius");
}

std::string pendulum_at_wall(const std::string& of_wall, const std::string& scheme) {
  const double lean = 60 * one_degree;
  return fmt::format("gravity = [0, -9.81]\n{}{}",
                     test::body("bar", 0.8, 0.01,
                                fmt::format("position = [{:.17g}, {:.17g}]\nangle = {:.17g}\n",
                                            0.25 * std::sin(lean), -0.25 * std::cos(lean), lean)),
                     test::pin("pivot", "ground", "bar", {0, 0}, {0, 0.25})) +
         test::stop("wall", "angle-stop", "pivot", "lower = 0.0\nradius = 0.25\n", "hard") + of_wall +
         "[surfaces.hard]\nrestitution = 0.6\n" + test::run_for(0.9, "start = \"given\"\n") + scheme;
}

void pendulum_and_wall(Findings& f) {
  const long double arm = 0.25L, mass = 0.8L, inertia = 0.01L + mass * arm * arm, g = 9.81L;
  const reference::PendulumWall p{std::sqrt(mass * g * arm / inertia), 60 * acosl(-1.0L) / 180, 0.6L};
  const auto text = pendulum_at_wall("", event_scheme("tolerance = 1e-13\n"));
  const Case c{
      f, "pendulum released at 60° against a wall at 0°",
      sensitivities(parse_scene(text, "pendulum"), {.of = {"event.1.t", "event.2.t"},
                                                    .to = {"surfaces.hard.restitution", "initial.bar.theta",
                                                           "gravity[1]", "contacts.wall.lower"}})};
  const std::string source = "complete elliptic integrals";
  const double bound = 1e-10;
  const char* reason = "required: ten digits; tolerance 1e-13 per step";
  c.expect(0, 3, "s/rad", p.first_by_wall(), source, bound, reason);
  c.expect(1, 0, "s", p.second_by_restitution(), source, bound, reason);
  c.expect(1, 2, "s³/m", -p.second_by_gravity(9.81L), source, bound, reason);
  // initial.bar.theta is projected onto the pin by the least mass-weighted change:
  // dθ₀ = J δθ/(J + m a²).
  const long double share = 0.01L / inertia;
  c.expect(0, 1, "s/rad", p.first_by_amplitude() * share, source, bound, reason);
  c.expect(1, 1, "s/rad", p.second_by_amplitude() * share, source, 1e-9,
           "differences of the start: 1e-12 of a unit change, which is a hundred times this derivative");
}

void oblique_drop(Findings& f) {
  const auto text = "gravity = [6, -8]\n" +
                    test::body("disc", 0.3, 0.3 * 0.4 * 0.0025, "position = [0, 0.55]\n") +
                    test::plane("plane", "ground", "disc", 0.05, "hard") + test::surface("hard", 0.8, 0.1) +
                    test::run_for(0.6, "start = \"given\"\n") + event_scheme();
  const reference::ObliqueDrop d{0.5L, 6, 8, 0.8L, 0.1L, 0.6L};
  const Case c{
      f, "disc dropped onto an inclined plane",
      sensitivities(parse_scene(text, "drop"), {.of = {"end.disc.x"},
                                                .to = {"surfaces.hard.friction", "surfaces.hard.restitution",
                                                       "initial.disc.y", "gravity[0]", "gravity[1]"}})};
  const std::string source = "uniform acceleration, Coulomb's and Newton's impact laws";
  c.expect(0, 0, "m", d.by_friction(), source);
  c.expect(0, 1, "m", d.by_restitution(), source);
  c.expect(0, 2, "", d.by_height(), source);
  c.expect(0, 3, "s²", d.by_along(), source);
  c.expect(0, 4, "s²", -d.by_normal(), source);
}

void sliding_block(Findings& f) {
  const auto text =
      "gravity = [-3, -9]\n" + test::body("block", 2, 0.01, "position = [0, 0.05]\nvelocity = [1.5, 0]\n") +
      test::plane("rear", "ground", "block", 0, "wood", "at = [[0, 0], [-0.1, -0.05]]\n") +
      test::plane("front", "ground", "block", 0, "wood", "at = [[0, 0], [0.1, -0.05]]\n") +
      test::surface("wood", 0.3, 0.5) + test::run_for(0.5, "start = \"given\"\n") + event_scheme();
  const reference::SlidingBlock b{1.5L, 3, 9, 0.5L};
  const Case c{f, "block that slides up a slope and sticks",
               sensitivities(parse_scene(text, "block"), {.of = {"end.block.x"},
                                                          .to = {"initial.block.vx", "surfaces.wood.friction",
                                                                 "gravity[0]", "bodies.block.mass"}})};
  const std::string source = "uniform deceleration to rest";
  c.expect(0, 0, "s", b.by_speed(), source);
  c.expect(0, 1, "m", b.by_friction(), source);
  c.expect(0, 2, "s²", -b.by_along(), source);
  c.expect(0, 3, "m/kg", 0, source, 1e-12, "rounding: the mass cancels");
}

std::string two_discs(double e, double mass2) {
  return test::body("one", 1, 0.004, "position = [-0.5, 0]\nvelocity = [1, 0]\n") +
         test::body("two", mass2, 0.004, "position = [0, 0]\n") +
         test::discs("pair", "one", "two", 0.1, 0.1, "hard") +
         "[surfaces.hard]\nrestitution = " + fmt::format("{}\n", e) +
         test::run_for(1, "start = \"given\"\n") + event_scheme();
}

void head_on(Findings& f) {
  const Case equal{f, "equal discs that collide head-on, e = 1",
                   sensitivities(parse_scene(two_discs(1, 1), "discs"),
                                 {.of = {"end.two.x", "end.two.vx", "end.one.vx"},
                                  .to = {"initial.one.x", "initial.two.x", "initial.one.vx"}})};
  const std::string nimble =
      "exchange of velocities; nimblephysics issue 97 reports 0.75, 0.25, 0.91 and 0.08 for 1, 0, 1 and 0";
  equal.expect(0, 0, "", 1, nimble);
  equal.expect(0, 1, "", 0, nimble, 1e-10);
  equal.expect(1, 2, "", 1, nimble);
  equal.expect(2, 2, "", 0, nimble, 1e-10);
  const reference::HeadOn h{1, 2, -0.5L, 0, 1, 0.2L, 0.7L, 1};
  const Case c{f, "discs of 1 and 2 kg that collide head-on, e = 0.7",
               sensitivities(parse_scene(two_discs(0.7, 2), "discs"),
                             {.of = {"end.two.vx", "end.two.x", "event.1.impulse_n", "event.1.t"},
                              .to = {"surfaces.hard.restitution", "bodies.one.mass", "initial.one.x",
                                     "initial.two.x", "initial.one.vx", "contacts.pair.radii[0]"}})};
  const std::string source = "balance of momentum and Newton's law";
  c.expect(0, 0, "m/s", h.after2_by_restitution(), source);
  c.expect(0, 1, "m/(s kg)", h.after2_by_mass1(), source);
  c.expect(0, 4, "", h.after2_by_v1(), source);
  c.expect(1, 2, "", h.end2_by_x1(), source);
  c.expect(1, 3, "", h.end2_by_x2(), source);
  c.expect(2, 1, "m/s", h.impulse_by_mass1(), source);
  c.expect(3, 5, "s/m", -1, source);
  c.expect(3, 4, "s²/m", -h.contact(), source);
}

/// In the rig without gravity, forces of impacts and of Coulomb friction have no time scale: a change of the
/// drive's speed Ω rescales time, so that (Ω/Q) dQ/dΩ is −1 for times, 1 for speeds, 2 for energies.
void speed_of_rig(Findings& f) {
  const auto all =
      sensitivities(read_scene(test::flores(), {"nonsmooth.scheme=event-driven", "nonsmooth.tolerance=1e-12",
                                                "run.revolutions=0.1", "run.discard=0"}),
                    {.of = {"event.1.t", "event.4.t", "event.4.v_n_minus", "energy.dissipated_in_contacts"},
                     .to = {"drives.motor.speed_rpm"}});
  const double expected[] = {-1, -1, 1, 2};
  for (std::size_t i = 0; i < all.quantities.size(); ++i) {
    const auto& q = all.quantities[i];
    f.relative(claim_name("slider-crank of Flores et al.", "influence of the drive's speed on " + q.name,
                          "event-driven"),
               "", q.derivatives[0] * all.key_values[0] / q.value, expected[i], 1e-6, "rescaling of time",
               "as for random scenes: bounces amplify the rounding of differences");
  }
}

std::string ball_on_spring(double stiffness, double restitution) {
  return "gravity = [0, -9.81]\n" + test::body("ball", 0.3, 3e-4, "position = [0, 0.55]\n") +
         test::plane("table", "ground", "ball", 0.05, "hard", fmt::format("stiffness = {}\n", stiffness)) +
         test::surface("hard", restitution) +
         test::run_for(1, "start = \"given\"\n[penalty]\nintegrator = \"dopri5\"\ntolerance = 1e-13\n");
}

void ball_and_spring(Findings& f) {
  const reference::SpringBounce b{0.5L, 9.81L, 0.3L, 1e5L};
  const Case c{f, "ball dropped from 0.5 m onto a spring",
               sensitivities(parse_scene(ball_on_spring(1e5, 1), "spring"),
                             {.of = {"event.2.t", "event.1.impulse_n"},
                              .to = {"contacts.table.stiffness", "bodies.ball.mass", "initial.ball.y"},
                              .formulation = "penalty"}),
               "penalty"};
  const std::string source = "undamped oscillation under gravity";
  constexpr double bound = 1e-9;
  const char* reason = "tolerance 1e-13 per step, some hundred steps, and ten times that for derivatives";
  f.relative(claim_name(c.subject, "event.2.t", "penalty"), "s", c.all.quantities[0].value,
             static_cast<double>(b.second()), bound, source, reason);
  c.expect(0, 0, "s m/N", b.second_by_stiffness(), source, bound, reason);
  c.expect(0, 1, "s/kg", b.second_by_mass(), source, bound, reason);
  c.expect(0, 2, "s/m", b.second_by_height(), source, bound, reason);
  c.expect(1, 0, "s m", b.impulse_by_stiffness(), source, 1e-8,
           "the impulse changes by the weight alone, a hundredth of its value");
  c.expect(1, 1, "m/s", b.impulse_by_mass(), source, bound, reason);
}

/// As the stiffness grows, derivatives tend to those of the impact law with the duration of contact, as
/// K^(−1/2).
void rigid_limit(Findings& f) {
  const reference::BallDerivatives b{0.5L, 9.81L, 0.5L};
  const auto apart = [&](double stiffness) {
    const auto all =
        sensitivities(parse_scene(ball_on_spring(stiffness, 0.5), "limit"),
                      {.of = {"event.3.t"}, .to = {"surfaces.hard.restitution"}, .formulation = "penalty"});
    return all.quantities[0].derivatives[0] - static_cast<double>(b.time_by_restitution(3));
  };
  const double soft = apart(1e6), hard = apart(1e8);
  const std::string subject = "ball dropped from 0.5 m, exact damping, linear spring";
  const std::string source = "duration of contact, proportional to K^(-1/2)";
  f.relative(claim_name(subject, "d(event.3.t)/de less its rigid limit, 1e6 over 1e8 N/m", "penalty"), "",
             soft / hard, 10, 0.02, source,
             "the next order is the speed change by gravity during contact over the speed, 5e-3 at 1e6 N/m");
  f.within(claim_name(subject, "d(event.3.t)/de less its rigid limit at 1e8 N/m", "penalty"), "s", hard, 0,
           1e-3, source, "two contacts of 2e-4 s each, whose duration changes by its order per unit of e");
}

/// The mean square of errors of one derivative over 20 steps of slightly different length: the
/// instant of an impact lies anywhere within its step, so that the error is a sawtooth of the step.
double mean_square(const std::string& text, const char* quantity, const char* key, long double exact,
                   double step) {
  constexpr int runs = 20;
  double sum = 0;
  for (int i = 0; i < runs; ++i) {
    const auto all = sensitivities(parse_scene(text, "steps",
                                               {"nonsmooth.scheme=moreau-jean",
                                                fmt::format("nonsmooth.step={}", step * (1 + 0.02 * i))}),
                                   {.of = {quantity}, .to = {key}});
    const double error = all.quantities[0].derivatives[0] / static_cast<double>(exact) - 1;
    sum += error * error;
  }
  return sum / runs;
}

/// Derivatives of both formulations tend to those of the rigid impact, as the stiffness grows and as the step
/// shrinks.
void agreement_of_formulations(Findings& f, const std::string& subject, const std::string& text,
                               const char* stiffness, const char* quantity, const char* key,
                               long double exact, const std::vector<double>& K, double order,
                               const std::string& source) {
  const auto name = fmt::format("d({})/d({})", quantity, key);
  std::vector<double> errors, squares, steps;
  for (const double k : K) {
    const auto all = sensitivities(parse_scene(text, "stiff", {fmt::format("{}={}", stiffness, k)}),
                                   {.of = {quantity}, .to = {key}, .formulation = "penalty"});
    errors.push_back(std::abs(all.quantities[0].derivatives[0] / static_cast<double>(exact) - 1));
  }
  f.between(claim_name(subject, fmt::format("order of the error of {} in the stiffness", name), "penalty"),
            "", test::observed_order(K, errors), order - 0.05, order + 0.05, source,
            "the next order is the speed change by gravity during contact over the speed, at most 2e-2");
  f.at_most(claim_name(subject, fmt::format("relative error of {} at {:g} N/m", name, K.back()), "penalty"),
            "", errors.back(), 0.01, source, "a contact lasts less than a hundredth of the flight");
  for (const double step : {4e-3, 2e-3, 1e-3, 5e-4}) {
    steps.push_back(step);
    squares.push_back(mean_square(text, quantity, key, exact, step));
  }
  f.between(claim_name(subject, fmt::format("order of the error of {} in the step", name), "moreau-jean"), "",
            test::observed_order(steps, squares) / 2, 0.8, 1.3, source,
            "first order; a mean over 20 runs at four steps leaves a standard error of 0.07");
  f.at_most(
      claim_name(subject, fmt::format("error of {} at a step of 5e-4 s, root mean square, relative", name),
                 "moreau-jean"),
      "", std::sqrt(squares.back()), 0.05, source,
      "an impact acts up to a step late, a thousandth of the flight; the derivative of a nearly isochronous "
      "motion is a tenth of the time, which makes it 1e-2; margin of five");
}

void agreements(Findings& f) {
  const reference::BallDerivatives b{0.5L, 9.81L, 0.5L};
  const auto ball = ball_on_spring(1e5, 0.5);
  const std::string dropped = "ball dropped from 0.5 m, both formulations";
  // The duration of contact is proportional to K^(-1/2) and does not depend on the speed; its
  // change by gravity has the order g/(v ω²).
  agreement_of_formulations(f, dropped, ball, "contacts.table.stiffness", "event.2.t", "initial.ball.y",
                            b.time_by_height(2), {1e4, 1e5, 1e6}, -1, "geometric series of flights");
  agreement_of_formulations(f, dropped, ball, "contacts.table.stiffness", "event.3.t",
                            "surfaces.hard.restitution", b.time_by_restitution(3), {1e5, 1e6, 1e7}, -0.5,
                            "geometric series of flights");
  const long double arm = 0.25L, mass = 0.8L, inertia = 0.01L + mass * arm * arm;
  const reference::PendulumWall p{std::sqrt(mass * 9.81L * arm / inertia), 60 * acosl(-1.0L) / 180, 0.6L};
  const auto pendulum =
      pendulum_at_wall("stiffness = 1e5\n", "[penalty]\nintegrator = \"dopri5\"\ntolerance = 1e-13\n");
  agreement_of_formulations(f, "pendulum released at 60° against a wall at 0°, both formulations", pendulum,
                            "contacts.wall.stiffness", "event.2.t", "surfaces.hard.restitution",
                            p.second_by_restitution(), {1e5, 1e6, 1e7}, -0.5, "complete elliptic integrals");
}

}  // namespace

Parts sensitivity_claims() {
  return {dropped_ball, pendulum_and_wall, oblique_drop, sliding_block, head_on,
          speed_of_rig, ball_and_spring,   rigid_limit,  agreements};
}

}  // namespace freeplay::verification
