// Drives of mechanisms: prescribed motions, torques and forces by curves, motors and a speed
// governor. Each is claimed against a closed form, by every formulation and scheme.
#include "verification/claims/claim.hpp"
#include "verification/references/feedback.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

constexpr double h = 1e-4;  // s, of time stepping

using test::Way;
const Way ways[] = {test::penalty, test::fixed_steps(h, "Moreau–Jean, h = 1e-4 s"), test::event_driven,
                    test::automatic};

/// Results of a run: final state, greatest error by `off` during the run, error of the energy
/// balance, and its greatest work.
struct Outcome {
  State end;
  double worst = 0, closure = 0, energy = 0;
};

class Watch final : public Observer {
 public:
  using Off = std::function<double(double t, const std::vector<double>& q, const std::vector<double>& v,
                                   const Forces& f)>;
  Watch(Off off, bool stepping) : off_(std::move(off)), stepping_(stepping) {}
  Wants wants() const override { return {.forces = true}; }
  void begin(const Layout& layout, const State& state) override {
    q_ = state.q;
    v_ = state.v;
    forces_ = {std::vector<ElementForce>(layout.forces.size()), std::vector<double>(q_.size())};
  }
  void step(const Step& step) override {
    // The force of a time step is its mean, taken at its middle; within a step of an integrator the
    // state is interpolated.
    const double t = stepping_ ? 0.5 * (step.t0 + step.t1) : step.t1;
    step.state(t, q_, v_);
    forces_.clear();
    step.forces(t, forces_);
    worst = greatest(worst, off_(t, q_, v_, forces_));
  }
  double worst = 0;

 private:
  Off off_;
  bool stepping_;
  std::vector<double> q_, v_;
  Forces forces_;
};

Outcome run(Scene scene, const Way& way, const Watch::Off& off = nullptr) {
  way.choose(scene);
  scene.penalty.tolerance = 1e-10;
  Simulation simulation(scene, test::name_of(way.family));
  Watch watch(off, way.fixed());
  test::finished(simulation, off ? std::vector<Observer*>{&watch} : std::vector<Observer*>{});
  const auto ledger = simulation.ledger();
  return {simulation.state(), watch.worst, std::abs(ledger.closure()),
          std::max({std::abs(ledger.drive), std::abs(ledger.load), ledger.kinetic})};
}
Outcome run(const std::string& text, double duration, const Way& way, const Watch::Off& off = nullptr) {
  return run(parse_scene(text + test::run_for(duration), "drive"), way, off);
}

constexpr double inertia = 0.05;
const std::string rotor =
    test::body("rotor", 2.0, 0.05) + test::pin("main", "ground", "rotor") + R"([drives.motor]
joint = "main"
)";
const std::string slider =
    test::body("block", 2.0, 0.05) + test::guide("guide", "ground", "block", {0.8, 0.6}) + R"([drives.motor]
joint = "guide"
)";

const char* const tight = "tolerance 1e-10 per step, margin of 1000";
/// Greatest acceleration of Baumgarte's stabilisation due to the constraint residual of a step
/// (m/s² or rad/s²).
constexpr double answer = 100 * 1e-10 * (2 * 5 * 10 + 5 * 5);
const char* const stabilised =
    "Baumgarte acceleration 2αΦ̇ + β²Φ for residuals of 100 tolerances, rates at 10 m/s or 10 rad/s, "
    "over the greatest "
    "acceleration";

const char* const second_order = "second order: (h/τ)² of the smallest time constant τ, margin of ten";

void closure(Findings& f, const char* subject, const Way& way, const Outcome& o) {
  f.at_most(claim_name(subject, "error of the energy balance over the greatest work", way.name), "",
            o.closure / o.energy, 1e-6, "0", "works are integrated at the tolerance, margin of 1000");
}

void dc_motors(Findings& f) {
  for (const double L : {0.0, 0.01}) {
    const char* const subject = L > 0 ? "DC motor with inductance" : "DC motor without inductance";
    const reference::DcSpinUp motor{24, 1.5, 0.4, L, inertia};
    const auto text = rotor + "voltage = 24\nresistance = 1.5\ntorque_constant = 0.4\n" +
                      (L > 0 ? "inductance = 0.01\n" : "");
    for (const auto& way : ways) {
      const auto o = run(text, 0.5, way);
      // τ = R J/k² = 0.47 s, L/R = 6.7e-3 s
      f.relative(claim_name(subject, "speed after 0.5 s", way.name), "rad/s", o.end.v[2], motor.speed(0.5),
                 way.fixed() ? 10 * h * h / (L > 0 ? 4.4e-5 : 0.2) : 1e-7,
                 L > 0 ? "two exponentials (τ = R J/k², L/R)" : "U/k (1 − exp(−t/τ))",
                 way.fixed() ? second_order : tight);
      closure(f, subject, way, o);
    }
  }
  const auto text =
      rotor + "voltage = 24\nresistance = 1.5\ntorque_constant = 0.4\n" + test::motor("hold", "main", 0);
  for (const auto& way : ways)
    f.at_most(
        claim_name("DC motor at standstill", "torques of motor and holding drive, greatest error", way.name),
        "N m",
        run(text, 0.1, way,
            [](double, const auto&, const auto&, const Forces& now) {
              return greatest(std::abs(now.elements[1].m - 6.4), std::abs(now.elements[2].m + 6.4));
            })
            .worst,
        1e-12, "k U/R = 6.4 N m", "rounding");
}

void induction_motors(Findings& f) {
  const double w = 2 * std::numbers::pi * 25, s = reference::kloss_slip(10, 0.2, 4);
  const auto text = rotor + R"(breakdown_torque = 10
breakdown_slip = 0.2
synchronous_speed_rpm = 1500
[loads.brake]
type = "torque"
body = "rotor"
torque = -4
)";
  // From rest the brake would turn the motor backwards. It therefore starts above the breakdown
  // speed, and settles within J ω_s s_k²…/M_k ≈ 0.1 s.
  auto turning = text;
  turning.insert(turning.find("inertia = 0.05\n"), "angular_velocity = 140\n");
  for (const auto& way : ways)
    f.relative(claim_name("asynchronous motor against 4 N m", "speed after 4 s", way.name), "rad/s",
               run(turning, 4, way).end.v[2], w * (1 - s), 1e-7, "s = s_k (M_k/M − √((M_k/M)² − 1))",
               "stationary speed: error of the order of the tolerance");
}

void governors(Findings& f) {
  const auto text = rotor + "target_speed = 30\nproportional = 0.2\nintegral = 1.0\n";
  for (const auto& way : ways) {
    const auto o = run(text, 1.0, way);
    f.relative(claim_name("speed governor", "speed after 1 s", way.name), "rad/s", o.end.v[2],
               reference::governed_speed(30, 0.2, 1.0, inertia, 1.0), way.fixed() ? 10 * h * h * 20 : 1e-7,
               "PI control of an inertia: linear system of second order", way.fixed() ? second_order : tight);
    closure(f, "speed governor", way, o);
  }
}

void prescribed(Findings& f) {
  for (const bool polynomial : {true, false}) {
    const auto* name = polynomial ? "polynomial" : "cycloidal";
    const auto subject = fmt::format("rotor with {} start-up", name);
    const auto text = rotor + fmt::format(
                                  "velocity = \"up\"\n[curves.up]\nshape = \"ramp\"\nto = 20\nrise = 0.5\n"
                                  "profile = \"{}\"\n",
                                  name);
    const auto p = polynomial ? reference::polynomial_rise(0.5) : reference::cycloidal_rise(0.5);
    for (const auto& way : ways) {
      const auto o = run(text, 0.25, way);
      f.within(claim_name(subject, "angle after half the rise", way.name), "rad", o.end.q[2],
               20 * 0.5 * p.integral, way.penalty() ? 1e-8 : 1e-12, "the profile's integral",
               "rounding of a prescribed motion; penalty: 1e-10 per step in a radian, margin of 100");
      closure(f, subject.c_str(), way, o);
    }
    for (const auto& way : ways)
      f.at_most(claim_name(subject, "torque of the drive, greatest error over greatest torque", way.name), "",
                run(text, 0.6, way,
                    [polynomial](double t, const auto&, const auto&, const Forces& now) {
                      const auto rise = polynomial ? reference::polynomial_rise(t / 0.5)
                                                   : reference::cycloidal_rise(t / 0.5);
                      const double a = t < 0.5 ? 40 * rise.slope : 0;
                      return std::abs(now.elements[1].m - inertia * a) / (inertia * (polynomial ? 75 : 80));
                    })
                    .worst,
                way.fixed()     ? 1e-6
                : way.penalty() ? answer / 75
                                : 1e-10,
                "J α, the profile's derivative",
                way.fixed() ? "mean force of a step against that at its middle: (h/0.5 s)² times some tens"
                : way.penalty() ? stabilised
                                : "rounding of a prescribed motion");
  }
  const auto shaken =
      slider +
      "position = \"shake\"\n[curves.shake]\nshape = \"harmonic\"\namplitude = 0.05\nfrequency = 3\n";
  constexpr double w = 6 * std::numbers::pi;
  for (const auto& way : ways) {
    const auto o = run(shaken, 0.7, way, [](double t, const auto&, const auto&, const Forces& now) {
      const auto& e = now.elements[1];
      const double force = -2.0 * 0.05 * w * w * std::sin(w * t);
      return std::hypot(e.fx - 0.8 * force, e.fy - 0.6 * force) / (0.1 * w * w);
    });
    f.within(claim_name("slider with prescribed harmonic motion", "position after 0.7 s", way.name), "m",
             0.8 * o.end.q[0] + 0.6 * o.end.q[1], 0.05 * std::sin(0.7 * w), way.penalty() ? 1e-8 : 1e-12,
             "A sin ωt", "rounding of a prescribed motion; penalty: tolerance");
    f.at_most(claim_name("slider with prescribed harmonic motion",
                         "force of the drive, greatest error over greatest force", way.name),
              "", o.worst,
              way.fixed()     ? w * w * h * h
              : way.penalty() ? answer / (0.05 * w * w)
                              : 1e-10,
              "−m A ω² sin ωt",
              way.fixed()     ? "mean force of a step: (ω h)²"
              : way.penalty() ? stabilised
                              : "rounding of a prescribed motion");
  }
}

/// A ball on a plate that accelerates upwards at 2 m/s² until 0.5 s and then downwards at 14 m/s²,
/// when the ball separates.
void plates(Findings& f) {
  const char* const subject = "ball on a plate that accelerates downwards";
  const auto scene = read_scene(test::scene_file("ball_on_lift"));
  for (const auto& way : ways) {
    const auto o = run(scene, way);
    // Penalty: K δ^1.5 = m (g + a) with K = 4/3 E/(1 − ν²) √R gives δ = 7e-6 m; on release the ball
    // gains ω δ < 5e-3 m/s.
    f.within(claim_name(subject, "height after 0.9 s", way.name), "m", o.end.q[4],
             0.1 + 0.25 + 0.4 - 0.5 * 9.81 * 0.16,
             way.penalty() ? 0.4 * 5e-3
             : way.fixed() ? 1.4 * h
                           : 1e-9,
             "free flight from 0.25 m at 1 m/s",
             way.penalty() ? "velocity gained from the release of compression"
             : way.fixed() ? "separation a step late at 14 m/s²"
                           : tight);
    closure(f, subject, way, o);
  }
}

/// A follower whose position is prescribed as a cam law of the angle of another joint, which turns
/// at 10 rad/s.
void followed(Findings& f) {
  const char* const subject = "follower prescribed by a cam law";
  const auto scene = read_scene(test::scene_file("cam_law_follower"));
  for (const auto& way : ways) {
    const auto o = run(scene, way, [](double t, const auto&, const auto&, const Forces& now) {
      const double turn = std::fmod(10 * t, 2 * std::numbers::pi);
      double slope = 0, bend = 0;
      if (turn < 2 || (turn > 3 && turn < 5)) {
        const auto p = reference::polynomial_rise(turn < 2 ? turn / 2 : (turn - 3) / 2);
        slope = (turn < 2 ? 0.015 : -0.015) * p.slope;
        bend = (turn < 2 ? 0.0075 : -0.0075) * p.bend;
      }
      const double force = 2.0 * 100 * bend;  // m Ω² s″
      return greatest(std::abs(now.elements[3].fy - force) / 8.66,
                      std::abs(now.elements[2].m - force * slope) / 0.2);
    });
    const auto p = reference::polynomial_rise((10 - 2 * std::numbers::pi - 3) / 2);
    f.within(claim_name(subject, "lift after 1 s", way.name), "m", o.end.q[4], 0.03 * (1 - p.value),
             way.penalty() ? 1e-8 : 1e-10, "3-4-5 polynomial",
             "rounding of a prescribed motion; penalty: tolerance");
    f.at_most(
        claim_name(subject, "follower force and crank torque, greatest error over the greatest", way.name),
        "", o.worst,
        way.fixed()     ? 0.01
        : way.penalty() ? answer / 4.33
                        : 1e-10,
        "F = m Ω² s″, M Ω = F ṡ",
        way.fixed()     ? "a step across a knot, where s‴ jumps: h Ω p‴/(2 p″) = 5e-3, margin of two"
        : way.penalty() ? stabilised
                        : "rounding of a prescribed motion");
    closure(f, subject, way, o);
  }
}

void efforts(Findings& f) {
  const auto falling = rotor +
                       "torque_curve = \"line\"\nagainst = \"speed\"\n[curves.line]\nshape = \"table\"\n"
                       "points = [[-100, 12], [100, -8]]\n";  // M = 2 − ω/10
  const auto bump = rotor +
                    "torque_curve = \"bump\"\n[curves.bump]\nshape = \"table\"\n"
                    "points = [[0.1, 0], [0.2, 3], [0.3, 0]]\nbetween = \"spline\"\n";
  const auto swing = rotor +
                     "torque_curve = \"spring\"\nagainst = \"angle\"\n[curves.spring]\nshape = \"table\"\n"
                     "points = [[-9, 18], [9, -18]]\n";  // M = −2 φ: J φ̈ = −2 φ
  auto turning = swing;
  turning.insert(turning.find("inertia = 0.05\n"), "angular_velocity = 5\n");
  const auto pushed =
      slider + "force = \"wave\"\n[curves.wave]\nshape = \"harmonic\"\namplitude = 4\nperiod = 0.8\n";
  const auto spun = test::body("disc", 2.0, 0.05, "angular_velocity = 3\n") + R"([curves.rise]
shape = "table"
points = [[0, 0], [1, 1]]
[loads.jet]
type = "force"
body = "disc"
force = [1.5, 0]
axes = "body"
factor = "rise"
)";
  for (const auto& way : ways) {
    const auto claim = [&](const char* subject, const char* quantity, const char* unit, double measured,
                           double expected, double bound, const char* source) {
      f.relative(claim_name(subject, quantity, way.name), unit, measured, expected,
                 way.fixed() ? bound : 1e-7, source, way.fixed() ? second_order : tight);
    };
    const auto slow = run(falling, 0.5, way);
    claim("rotor with torque falling with speed", "speed after 0.5 s", "rad/s", slow.end.v[2],
          -20 * std::expm1(-0.5 / 0.5), 10 * h * h / 0.25, "M₀/c (1 − exp(−c t/J))");
    closure(f, "rotor with torque falling with speed", way, slow);
    const auto hit = run(bump, 0.5, way);
    claim("rotor with a torque pulse by a spline of time", "speed after the pulse", "rad/s", hit.end.v[2],
          1.25 * 3 * 0.1 / inertia, 1e-9, "5/4 M a/J, integral of the natural spline");
    const auto swung = run(turning, 0.3, way);
    const double w = std::sqrt(2 / inertia);
    claim("rotor with torque by a table of angle", "angle after 0.3 s", "rad", swung.end.q[2],
          5 / w * std::sin(0.3 * w), 10 * w * w * h * h, "(ω₀/w) sin wt");
    closure(f, "rotor with torque by a table of angle", way, swung);
    const auto slid = run(pushed, 0.4, way);
    const double W = 2 * std::numbers::pi / 0.8;
    claim("slider with a harmonic force", "speed after half a period", "m/s",
          0.8 * slid.end.v[0] + 0.6 * slid.end.v[1], 2 * 4 / (2.0 * W), 10 * W * W * h * h, "2 F/(m ω)");
    const auto flown = run(spun, 1.0, way);
    // ∫ t e^{iwt} dt = (e^{iwt}(1 − iwt) − 1)/w²
    claim("spinning disc with a growing force in body axes", "transverse velocity after 1 s", "m/s",
          flown.end.v[1], 1.5 / 2.0 * (std::sin(3.0) - 3 * std::cos(3.0)) / 9, 10 * 9 * h * h,
          "(F/m) ∫ t sin wt");
    closure(f, "spinning disc with a growing force in body axes", way, flown);
  }
}

}  // namespace

Parts driving() { return {dc_motors, induction_motors, governors, prescribed, followed, plates, efforts}; }

}  // namespace freeplay::verification
