// Angle and position controllers: linear responses, limit with anti-windup, lag, and limit cycles
// across backlash. Every scheme against references/feedback.hpp.
#include <complex>

#include "verification/claims/claim.hpp"
#include "verification/references/feedback.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

constexpr double step = 1e-4;  // s, of time stepping

using test::Way;
const Way control_ways[] = {test::penalty, test::fixed_steps(step, "Moreau–Jean, h = 1e-4 s"),
                            test::event_driven, test::automatic, test::chosen_steps};

/// Greatest |θ| of the last body and of the difference to the body before it, and the mean angular
/// frequency of the last body's zeros, from `from` (s) on.
class Cycle final : public Observer {
 public:
  Cycle(double from, double middle) : from_(from), middle_(middle) {}
  void begin(const Layout&, const State& state) override { q_ = state.q, v_ = state.v; }
  void step(const Step& step) override {
    if (step.t0 < from_) return;
    constexpr int parts = 8;
    for (int k = 1; k <= parts; ++k) {
      const double t = step.t0 + (step.t1 - step.t0) * k / parts;
      step.state(t, q_, v_);
      const double load = q_[5] - middle_;
      greatest_load = std::max(greatest_load, std::abs(load));
      greatest_play = std::max(greatest_play, std::abs(q_[2] - q_[5]));
      if (last_ < 0 && load >= 0 && t > last_t_) {
        const double zero = last_t_ + (t - last_t_) * last_ / (last_ - load);
        if (zeros_++ == 0) first_zero_ = zero;
        last_zero_ = zero;
      }
      last_ = load;
      last_t_ = t;
    }
  }
  double frequency() const { return 2 * std::numbers::pi * (zeros_ - 1) / (last_zero_ - first_zero_); }
  double greatest_load = 0, greatest_play = 0;

 private:
  double from_, middle_, last_ = 0, last_t_ = 0, first_zero_ = 0, last_zero_ = 0;
  int zeros_ = 0;
  std::vector<double> q_, v_;
};

struct ControlledRun {
  State end;
  double closure = 0, energy = 0;
};

/// `accuracy`: tolerance of adaptive time steps.
ControlledRun controlled(Scene scene, const Way& way, Observer* observer = nullptr, double accuracy = 1e-9) {
  way.choose(scene);
  scene.nonsmooth.step_tolerance = accuracy;
  scene.nonsmooth.tolerance = scene.penalty.tolerance = 1e-10;
  Simulation simulation(scene, test::name_of(way.family));
  test::finished(simulation, observer ? std::vector<Observer*>{observer} : std::vector<Observer*>{});
  const auto ledger = simulation.ledger();
  return {simulation.state(), std::abs(ledger.closure()), std::max(std::abs(ledger.drive), ledger.kinetic)};
}
ControlledRun controlled(const std::string& text, double duration, const Way& way) {
  return controlled(parse_scene(text + test::run_for(duration), "controlled"), way);
}

constexpr double J = 0.05, m = 2;  // kg m², kg
const std::string controlled_rotor = test::body("rotor", 2.0, 0.05) + test::pin("main", "ground", "rotor") +
                                     "[drives.motor]\njoint = \"main\"\n";
const std::string driven_block = test::body("block", 2.0, 0.05) +
                                 test::guide("guide", "ground", "block", {0.8, 0.6}) +
                                 "[drives.motor]\njoint = \"guide\"\n";

const char* const reason =
    "tolerance 1e-10 per step, margin of 1000; adaptive time steps: 1e-9 per step, some thousand steps; "
    "fixed steps: "
    "second order, ten times (h ω)²";

/// Bounds of a quantity of this size; `rate`: the greatest frequency of the motion (rad/s).
/// Tolerances refer to scales of 1 rad and 1 m.
double bound(const Way& way, double size, double rate) {
  if (way.fixed()) return size * 10 * step * step * rate * rate;
  return std::max(1.0, size) * (way.chosen() ? 1e-5 : 1e-7);
}

/// `spring_rate`: of a stiff spring (rad/s), whose work fixed steps take from the force at their middle.
void balance(Findings& f, const char* subject, const Way& way, const ControlledRun& o,
             double spring_rate = 0) {
  const double fixed = std::max(1e-6, step * step * spring_rate * spring_rate);
  f.at_most(
      claim_name(subject, "error of the energy balance over the greatest work", way.name), "",
      o.closure / o.energy,
      way.chosen()  ? 1e-5
      : way.fixed() ? fixed
                    : 1e-6,
      "0",
      "works are integrated at the tolerance, margin of 1000; work of stiff springs in fixed steps: (h ω)²");
}

/// A rotor from rest at 0 whose angle is controlled to 0.5 rad.
void steps_of_target(Findings& f) {
  struct Law {
    const char *subject, *keys, *source;
    reference::LinearResponse error;
    double t;
  };
  constexpr double e0 = 0.5;
  const Law laws[] = {
      {"rotor under PD control", "proportional = 20\nderivative = 0.4\n", "roots of J s² + k_d s + k_p",
       reference::LinearResponse::second(0.4 / J, 20 / J, e0, 0), 0.3},
      {"rotor under PID control", "proportional = 20\nderivative = 0.8\nintegral = 60\n",
       "roots of J s³ + k_d s² + k_p s + k_i by Cardano's formula",
       reference::LinearResponse::third(0.8 / J, 20 / J, 60 / J, e0, 0, -20 * e0 / J), 0.3},
      {"rotor under PD control with lag", "proportional = 5\nderivative = 0.4\nlag = 0.02\n",
       "roots of τ J s³ + J s² + k_d s + k_p by Cardano's formula",
       reference::LinearResponse::third(1 / 0.02, 0.4 / (J * 0.02), 5 / (J * 0.02), e0, 0, 0), 0.3}};
  for (const auto& law : laws)
    for (const auto& way : control_ways) {
      const auto o = controlled(controlled_rotor + "target_angle = 0.5\n" + law.keys, law.t, way);
      f.within(claim_name(law.subject, "angle after 0.3 s", way.name), "rad", o.end.q[2],
               e0 - law.error.value(law.t), bound(way, e0, 50), law.source, reason);
      f.within(claim_name(law.subject, "speed after 0.3 s", way.name), "rad/s", o.end.v[2],
               -law.error.rate(law.t), bound(way, 20 * e0, 50), law.source, reason);
      balance(f, law.subject, way, o);
    }
}

/// A block on an inclined guide follows A sin Ωt: H(s) = (k_d s + k_p)/(m s² + k_d s + k_p).
void followed_curve(Findings& f) {
  const char* const subject = "block under PD control along a harmonic curve";
  constexpr double A = 0.05, W = 2 * std::numbers::pi * 3, kp = 800, kd = 20, t = 0.4;
  using C = std::complex<double>;
  const C s(0, W), H = (kd * s + kp) / (m * s * s + kd * s + kp), now = H * std::exp(s * t);
  const auto transient = reference::LinearResponse::second(kd / m, kp / m, -A * H.imag(), -A * W * H.real());
  const std::string text = driven_block +
                           "target_position = \"wave\"\nproportional = 800\nderivative = 20\n[curves.wave]\n"
                           "shape = \"harmonic\"\namplitude = 0.05\nfrequency = 3\n";
  for (const auto& way : control_ways) {
    const auto o = controlled(text, t, way);
    f.within(claim_name(subject, "position after 0.4 s", way.name), "m", 0.8 * o.end.q[0] + 0.6 * o.end.q[1],
             A * now.imag() + transient.value(t), bound(way, A, 20), "H(iΩ) and roots of m s² + k_d s + k_p",
             reason);
    f.within(claim_name(subject, "speed after 0.4 s", way.name), "m/s", 0.8 * o.end.v[0] + 0.6 * o.end.v[1],
             A * W * now.real() + transient.rate(t), bound(way, A * W, 20),
             "H(iΩ) and roots of m s² + k_d s + k_p", reason);
    balance(f, subject, way, o);
  }
}

/// The fed back joint stands still, so that the demand is constant, k_p e₀ = 3 N m, and the torque
/// is that of a first-order filter.
void filtered(Findings& f) {
  const char* const subject = "lag of a constant demand";
  constexpr double T = 0.05, u = 3, t = 0.2;
  const std::string text =
      test::body("rotor", 2.0, 0.05) + test::body("still", 1.0, 0.01, "position = [1.0, 0.0]\n") +
      test::pin("main", "ground", "rotor") + test::pin("other", "ground", "still", {1.0, 0.0}) +
      test::motor("hold", "other", 0) +
      "[drives.motor]\njoint = \"main\"\nmeasured = \"other\"\ntarget_angle = 0.5\n"
      "proportional = 6\nlag = 0.05\n";
  for (const auto& way : control_ways) {
    const auto o = controlled(text, t, way);
    f.within(claim_name(subject, "torque after 0.2 s", way.name), "N m", o.end.z.at(0),
             u * -std::expm1(-t / T), bound(way, u, 1 / T), "u (1 − exp(−t/τ))", reason);
    f.within(claim_name(subject, "speed after 0.2 s", way.name), "rad/s", o.end.v[2],
             u / J * (t + T * std::expm1(-t / T)), bound(way, u / J * t, 1 / T),
             "(u/J)(t − τ(1 − exp(−t/τ)))", reason);
    balance(f, subject, way, o);
  }
}

void limited(Findings& f) {
  const char* const subject = "rotor under PD control with a limit";
  const reference::LimitedStep course{J, 20, 1.8, 5, 1};
  for (const auto& way : control_ways) {
    const auto o = controlled(
        controlled_rotor + "target_angle = 1\nproportional = 20\nderivative = 1.8\ntorque_limit = 5\n", 0.2,
        way);
    f.within(claim_name(subject, "angle after 0.2 s", way.name), "rad", o.end.q[2], 1 - course.error(0.2),
             bound(way, 1, 50), "parabola until k_p e + k_d ė = limit, then roots of J s² + k_d s + k_p",
             reason);
    balance(f, subject, way, o);
  }
  // Both limits, the integral driven back, and a lag.
  const char* const wound = "rotor under PID control with limit and lag";
  reference::SwitchedAxis axis;
  axis.J1 = J, axis.kp = 20, axis.kd = 1, axis.ki = 100, axis.limit = 3, axis.tracking = 0.2L,
  axis.lag = 0.01L;
  axis.at_load = false;
  axis.longest = 1e-4L;
  const auto y = axis.run({-0.5L, 0, 0, 0, 0, 0}, 0.8L);
  for (const auto& way : control_ways) {
    const auto o = controlled(
        controlled_rotor +
            "target_angle = 0.5\nproportional = 20\nderivative = 1\nintegral = 100\ntorque_limit = 3\n"
            "lag = 0.01\n",
        0.8, way);
    const char* const source = "references/feedback, linear pieces between switches";
    f.within(claim_name(wound, "angle after 0.8 s", way.name), "rad", o.end.q[2],
             0.5 + static_cast<double>(y[0]), bound(way, 0.5, 100), source, reason);
    f.within(claim_name(wound, "integral of the error after 0.8 s", way.name), "rad s", o.end.z.at(0),
             static_cast<double>(y[4]), bound(way, 0.1, 100), source, reason);
    f.within(claim_name(wound, "torque after 0.8 s", way.name), "N m", o.end.z.at(1),
             static_cast<double>(y[5]), bound(way, 3, 100), source, reason);
    balance(f, wound, way, o);
  }
}

/// Motor and table with a dead zone under PD control of the table.
void dead_zone(Findings& f) {
  const char* const subject = "axis under PD control across a dead zone";
  const auto scene = test::read_short(test::scene_file("axis_with_dead_zone"), 0.5),
             longer = test::read_short(test::scene_file("axis_with_dead_zone"), 6);
  reference::SwitchedAxis axis;
  axis.J1 = axis.J2 = J, axis.c1 = 0.4L, axis.c2 = 0.2L, axis.kp = 20, axis.kd = 0.4L, axis.k = 500,
  axis.b = 0.01L;
  const reference::DescribingFunction cycle(axis);
  const auto y = axis.run({0.03L, 0, 0.03L, 0, 0, 0}, 0.5L);
  for (const auto& way : control_ways) {
    const auto o = controlled(scene, way);
    const char* const source = "references/feedback, linear pieces between switches";
    // ω² = 2k/J = (141 rad/s)²
    f.within(claim_name(subject, "angle of the motor after 0.5 s", way.name), "rad", o.end.q[2],
             -0.03 + static_cast<double>(y[0]), bound(way, 0.05, 141), source, reason);
    f.within(claim_name(subject, "angle of the table after 0.5 s", way.name), "rad", o.end.q[5],
             -0.03 + static_cast<double>(y[2]), bound(way, 0.05, 141), source, reason);
    balance(f, subject, way, o, 141);
    Cycle seen(4, -0.03);
    controlled(longer, way, &seen, 1e-6);
    const char* const harmonic =
        "harmonics neglected: the dead zone's third is below a third of the first, "
        "and the inertias attenuate it "
        "ninefold: 4 %, margin of three";
    f.relative(claim_name(subject, "frequency of the limit cycle", way.name), "rad/s", seen.frequency(),
               cycle.omega, 0.12, "describing function of the dead zone", harmonic);
    f.relative(claim_name(subject, "amplitude of the table in the limit cycle", way.name), "rad",
               seen.greatest_load, cycle.load_amplitude, 0.12, "describing function of the dead zone",
               harmonic);
    f.relative(claim_name(subject, "amplitude across the dead zone in the limit cycle", way.name), "rad",
               seen.greatest_play, cycle.amplitude, 0.12, "describing function of the dead zone", harmonic);
  }
}

/// Motor and table on two equal gears with backlash, without restitution.
void backlash(Findings& f) {
  const char* const subject = "axis under PD control across gears with backlash";
  const auto scene = read_scene(test::scene_file("axis_with_backlash"));
  reference::SwitchedAxis axis;
  axis.J1 = axis.J2 = J, axis.c1 = axis.c2 = 0.05L, axis.kp = 20, axis.kd = 1, axis.b = 0.01L;
  axis.rigid = true;
  axis.longest = 1e-4L;
  const auto y = axis.run({0.03L, 0, 0.03L, 0, 0, 0}, 1.5L);
  for (const auto& way : control_ways) {
    if (way.penalty()) continue;  // rigid teeth
    const auto o = controlled(scene, way);
    const char* const source = "references/feedback, linear pieces and plastic impacts";
    const char* const why =
        "tolerance 1e-10 per step and impact, margin of 1e4; adaptive time steps: 1e-9, likewise; "
        "fixed steps: an "
        "impact up to a step late at 0.5 rad/s, ten impacts of memory";
    const double most = way.fixed() ? 10 * 0.5 * step : way.chosen() ? 1e-5 : 1e-6;
    f.within(claim_name(subject, "angle of the motor after 1.5 s", way.name), "rad", -o.end.q[2],
             -0.03 + static_cast<double>(y[0]), most, source, why);
    f.within(claim_name(subject, "angle of the table after 1.5 s", way.name), "rad", o.end.q[5],
             -0.03 + static_cast<double>(y[2]), most, source, why);
  }
}

}  // namespace

Parts controllers() { return {steps_of_target, followed_curve, filtered, limited, dead_zone, backlash}; }

}  // namespace freeplay::verification
