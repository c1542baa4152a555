// Followers that leave their cams, by every nonsmooth scheme and in sizes from micrometres to a
// kilometre, and the forces of automatic steps in motions that they resolve in few steps.
#include "verification/references/curve_shapes.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// A flat-faced follower under gravity on a cam of constant speed ω, with cycloidal rise and return: it
/// leaves where g + ω² h″ = 0, and falls freely until it meets the cam again.
struct Follower {
  double rise = 0, dwell = 0, fall = 0, lift = 0, base = 0, speed = 0, restitution = 0, size = 1;
  double g = 9.81;
  double left = 0, landed = 0, approach = 0;  // s, s, m/s
  bool valid = false;

  reference::CurveShape law{
      .kind = reference::CurveShape::Kind::rise_dwell_return, .cycloidal = true, .repeats = true};

  explicit Follower(std::mt19937_64& engine) {
    const auto uniform = [&](double a, double b) { return std::uniform_real_distribution(a, b)(engine); };
    rise = uniform(0.8, 2.2);
    dwell = uniform(0, 0.8);
    fall = uniform(0.8, 2.2);
    lift = uniform(0.05, 0.4);
    const double narrow = std::min(rise, fall);
    base = std::max(1.0, 8 * lift / (narrow * narrow)) * uniform(1, 2);
    speed = std::sqrt(g * rise * rise / (2 * M_PI * lift)) * uniform(1.01, 3);
    restitution = uniform(0, 0.9);
    size = std::ldexp(1, std::uniform_int_distribution(-20, 10)(engine));
    law.to = lift, law.rise = rise, law.dwell = dwell, law.fall = fall;
    law.rest = 2 * M_PI - rise - dwell - fall;
    const auto pressed = [&](double a) { return g + speed * speed * law.at(a).bend; };
    const auto first = [](auto value, double from, double to) {
      for (double a = from; a < to; a += 1e-3) {
        if (value(a + 1e-3) > 0) continue;
        double b = a + 1e-3;
        reference::bisect(a, b, 60, [&](double x) { return value(x) > 0; });
        return a;
      }
      return static_cast<double>(NAN);
    };
    const double off = first(pressed, 0, 2 * M_PI);
    const auto there = law.at(off);
    const auto gap = [&](double a) {
      const double t = (a - off) / speed;
      return there.y + t * (speed * there.slope - 0.5 * g * t) - law.at(a).y;
    };
    const double back = first(gap, off + 0.01, off + 20);
    approach = speed * law.at(back).slope - (speed * there.slope - g * (back - off) / speed);
    left = (off + 0.3) / speed;
    landed = (back + 0.3) / speed;
    valid = std::isfinite(back) && approach > 0.02 * speed * lift;
  }
  double turn() const { return 2 * M_PI / speed; }
  std::string scene() const {
    return fmt::format("gravity = [0, {:.17g}]\n", -size * g) +
           test::body("cam", 1, size * size, fmt::format("angular_velocity = {:.17g}\n", -speed)) +
           test::body("follower", 2, size * size, fmt::format("position = [0, {:.17g}]\n", size * base)) +
           test::pin("pin", "ground", "cam") +
           test::guide("guide", "ground", "follower", {0, 1}, {0, size * base}, {}) +
           test::motor("motor", "pin", -speed) +
           test::surface("steel", restitution, "young = 2e11\npoisson = 0.3\n") +
           fmt::format(R"([contacts.lobe]
type = "cam"
between = ["cam", "follower"]
axis = [-1, 0]
base_radius = {:.17g}
law = "cycloidal"
lift = {:.17g}
start = {:.17g}
rise = {:.17g}
dwell = {:.17g}
return = {:.17g}
surface = "steel"
)",
                       size * base, size * lift, M_PI / 2 + 0.3, rise, dwell, fall) +
           test::run_for(landed + 1e-3 * turn(), "start = \"given\"\n");
  }
};

/// The forces at four places of each step, the sum of the impulses, and the first and last velocities.
struct ForceRecord final : Observer {
  Wants wants() const override { return {.forces = true}; }
  void begin(const Layout& layout, const State& state) override {
    now.elements.resize(layout.forces.size());
    now.acceleration.resize(state.v.size());
    sum = now;
    v0.assign(state.v.begin(), state.v.end());
  }
  void step(const Step& step) override {
    for (const double share : {0.0, 0.3, 0.7, 1.0}) {
      const double t = step.t0 + share * (step.t1 - step.t0);
      now.clear();
      step.forces(t, now);
      times.push_back(t);
      values.push_back({now.elements[0].fx, now.elements[0].fy});
    }
    step.add_impulse(step.t0, step.t1, sum);
    sum.add(1, step.before());
    sum.add(1, step.within());
    v1.assign(step.v1.begin(), step.v1.end());
  }
  Forces now, sum;
  std::vector<double> times, v0, v1;
  std::vector<Vec2> values;
};

}  // namespace

TEST_CASE("followers leave their cams where the contact force ends, in any size", "[chosen][events]") {
  // Automatic steps bound the error of the motion. Where the force only just falls below zero, the
  // motion hardly depends on when the contact ends, so that this time may be off by more than the
  // landing.
  std::mt19937_64 engine(20261128);
  int runs = 0;
  while (runs < 25) {
    const Follower f(engine);
    if (!f.valid) continue;
    ++runs;
    for (const auto& way : {test::event_driven, test::automatic, test::chosen_steps}) {
      const auto run = test::finished(way, f.scene());
      CAPTURE(runs, way.name, f.size);
      double left = NAN, landed = NAN, approach = NAN;
      for (const auto& e : run.events)
        if (e.kind == EventKind::separation && std::isnan(left))
          left = e.t;
        else if (!std::isnan(left) && std::isnan(landed))
          landed = e.t, approach = -e.v_n_minus;
      const double bound = way.chosen() ? 1e-5 : 1e-9;
      CHECK(std::abs(left - f.left) < (way.chosen() ? 1e-3 : 1e-9) * f.turn());
      CHECK(std::abs(landed - f.landed) < bound * f.turn());
      CHECK(std::abs(approach / f.size - f.approach) < bound * f.speed * f.lift / std::min(f.rise, f.fall));
    }
  }
}

TEST_CASE("forces of automatic steps follow a driven arm, and give its change of momentum",
          "[chosen][forces]") {
  // The reaction at the shaft turns with the arm and contains its weight. Steps are limited to 0.3
  // rad, where the third differences that a parabola omits are 0.3³/64 = 4e-4 of the amplitude.
  const double mass = 0.7, arm = 0.2, speed = 12, g = 9.81;
  const auto scene = test::scene_by(test::chosen_steps,
                                    fmt::format("gravity = [0, {}]\n", -g) + test::body("arm", mass, 0.01) +
                                        test::pin("shaft", "ground", "arm", {}, {-arm, 0}) +
                                        test::motor("motor", "shaft", speed) + test::run_for(1.3));
  Simulation simulation(scene, "nonsmooth");
  ForceRecord record;
  test::finished(simulation, {&record});
  const double size = mass * arm * speed * speed;
  double worst = 0;
  for (std::size_t i = 0; i < record.times.size(); ++i) {
    const double a = speed * record.times[i];
    const Vec2 on_arm{-size * std::cos(a), -size * std::sin(a) + mass * g};
    worst = std::max(worst, (record.values[i] - on_arm).norm());
  }
  CAPTURE(record.times.size());
  CHECK(worst < 1e-3 * size);
  const Vec2 momentum{mass * (record.v1[0] - record.v0[0]),
                      mass * (record.v1[1] - record.v0[1]) + mass * g * 1.3};
  const Vec2 impulse{record.sum.elements[0].fx, record.sum.elements[0].fy};
  CHECK((impulse - momentum).norm() < 1e-5 * mass * arm * speed);
}

TEST_CASE("automatic steps are limited by the path of the bodies, not by their rotation alone", "[chosen]") {
  // A wheel on its centre has no path. A driven arm leaves that of a cubic through two halves of
  // the angle a by a⁴/(16·384) of its length, the accepted 1e-6 at 0.28 rad.
  const auto steps = [](double offset) {
    const auto run =
        test::finished(test::chosen_steps, "\ngravity = [0, 0]\n" + test::body("wheel", 1, 0.01) +
                                               test::pin("shaft", "ground", "wheel", {}, {offset, 0}) +
                                               test::motor("motor", "shaft", 100) + test::run_for(10));
    return static_cast<double>(run.work.steps);
  };
  CHECK(steps(0) < 50);
  CHECK(1000 / steps(0.1) == Approx(0.28).epsilon(0.3));
}

TEST_CASE("a point mass at a wall has the same motion in any size", "[chosen][scaling]") {
  // Powers of two change exponents only, so that every digit must agree where no scale is absolute.
  // The radius and all arms are zero: the length of the mechanism is its distance from the wall.
  const auto state_of = [](const test::Way& way, double size) {
    const double time = std::sqrt(size);
    const auto text =
        fmt::format("gravity = [{:.17g}, 0]\n", -10.0) +
        test::body("ball", 1, 0.4 * size * size, fmt::format("position = [{:.17g}, 0]\n", size)) +
        test::surface("wall", 0.9, "young = 2e11\npoisson = 0.3\n") +
        test::plane("wall", "ground", "ball", 0, "wall",
                    fmt::format("at = [[0, 0], [0, 0]]\naxis = [0, -1]\nstiffness = {:.17g}\n", 1e4 / size)) +
        test::run_for(3 * time, "start = \"given\"\n") + "[penalty]\ncontact = \"exact\"\n";
    const auto run = test::finished(way, text);
    return std::array{run.final_state.q[0] / size, run.final_state.v[0] / time,
                      static_cast<double>(run.work.steps), run.contacts[0].lasting_fraction};
  };
  for (const auto& way : {test::event_driven, test::automatic, test::chosen_steps, test::penalty})
    for (const double size : {std::ldexp(1, -20), std::ldexp(1, 10)}) {
      CAPTURE(way.name, size);
      CHECK(state_of(way, size) == state_of(way, 1));
    }
}
