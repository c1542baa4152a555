// Followers that lift off a cam and return, against closed forms. A cam turns at ω under a flat face or
// a roller guided radially, of mass m, that rests on it. In contact y = h(φ) and the force is
//
//     N = m (g + ω² h''(φ))                along the guide; zero at the separation
//
// after which y is a parabola, until it meets h again.
#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "mechanism/scene.hpp"
#include "values/event.hpp"
#include "verification/support/support.hpp"
#include "verification/support/ways.hpp"

using namespace freeplay;

namespace {

/// Rise, dwell and return; s = u/β from 0 to 1 with its derivatives by u.
struct Lift {
  bool polynomial = false;
  double lift = 0, rise = 1, dwell = 0, fall = 1;
  struct Value {
    double h, d1, d2;
  };
  Value ramp(double s, double width) const {
    if (polynomial)
      return {lift * s * s * s * (10 - 15 * s + 6 * s * s), lift * 30 * s * s * (1 - s) * (1 - s) / width,
              lift * 60 * s * (1 - s) * (1 - 2 * s) / (width * width)};
    const double a = 2 * M_PI * s;
    return {lift * (s - std::sin(a) / (2 * M_PI)), lift * (1 - std::cos(a)) / width,
            lift * 2 * M_PI * std::sin(a) / (width * width)};
  }
  Value at(double u) const {
    u -= 2 * M_PI * std::floor(u / (2 * M_PI));
    if (u < rise) return ramp(u / rise, rise);
    if (u < rise + dwell) return {lift, 0, 0};
    if (u > rise + dwell + fall) return {0, 0, 0};
    const auto y = ramp((u - rise - dwell) / fall, fall);
    return {lift - y.h, -y.d1, -y.d2};
  }
};

struct CamRig {
  Lift lift;
  double speed = 1, gravity = 9.81, restitution = 0.5, base = 1;
  bool roller = false;
  double size = 1;  ///< m

  explicit CamRig(std::mt19937_64& engine) {
    const auto uniform = [&](double a, double b) { return std::uniform_real_distribution(a, b)(engine); };
    lift.polynomial = uniform(0, 1) < 0.5;
    lift.rise = uniform(0.8, 2.2);
    lift.dwell = uniform(0, 0.8);
    lift.fall = uniform(0.8, 2.2);
    lift.lift = uniform(0.05, 0.4);
    roller = uniform(0, 1) < 0.3;
    // An outline that a flat face can follow, and a pitch curve without undercut.
    const double bend = 6.3 * lift.lift / std::pow(std::min(lift.rise, lift.fall), 2);
    base = std::max(1.0, 1.2 * bend) * uniform(1, 2);
    // It lifts off if ω² max(−h'') > g; on the rise −h'' reaches about 6 lift/rise².
    const double least = std::sqrt(gravity * lift.rise * lift.rise / (5.77 * lift.lift));
    speed = least * uniform(1.01, 3);
    restitution = uniform(0, 0.9);
    size = std::ldexp(1, std::uniform_int_distribution(-20, 10)(engine));
  }
  /// Cam angle from the beginning of the rise, at which the follower separates.
  double separation() const {
    const auto force = [&](double u) { return gravity + speed * speed * lift.at(u).d2; };
    double a = 0;
    while (a < 2 * M_PI && force(a + 1e-4) > 0) a += 1e-4;
    double b = a + 1e-4;
    for (int i = 0; i < 60; ++i) (force(0.5 * (a + b)) > 0 ? a : b) = 0.5 * (a + b);
    return a;
  }
  struct Return {
    double u, approach;
  };
  Return back(double from) const {
    const auto y = lift.at(from);
    const auto gap = [&](double u) {
      const double t = (u - from) / speed;
      return y.h + t * (speed * y.d1 - 0.5 * t * gravity) - lift.at(u).h;
    };
    double a = from + 0.01;
    while (gap(a + 1e-4) > 0) a += 1e-4;
    double b = a + 1e-4;
    for (int i = 0; i < 60; ++i) (gap(0.5 * (a + b)) > 0 ? a : b) = 0.5 * (a + b);
    // along the normal, which a roller's pressure angle inclines
    const auto at = lift.at(a);
    const double along = roller ? (base + at.h) / std::hypot(base + at.h, at.d1) : 1;
    return {a, along * (speed * at.d1 - (speed * y.d1 - gravity * (a - from) / speed))};
  }
  /// It begins 0.3 rad before the rise; the cam turns clockwise, so that its angle under the face grows.
  std::string scene(double duration) const {
    const double radius = 0.2 * base, y = size * base;
    return fmt::format(R"(
gravity = [0.0, {:.17g}]
[bodies.cam]
mass = 1
inertia = {:.17g}
angular_velocity = {:.17g}
[bodies.follower]
mass = 2
inertia = {:.17g}
position = [0.0, {:.17g}]
[joints.pin]
type = "revolute"
between = ["ground", "cam"]
[joints.guide]
type = "translational"
between = ["ground", "follower"]
at = [[0.0, {:.17g}], [0.0, 0.0]]
axis = [0.0, 1.0]
[drives.motor]
joint = "pin"
speed = {:.17g}
[surfaces.steel]
young = 2e11
poisson = 0.3
restitution = {:.17g}
[contacts.lobe]
type = "cam"
between = ["cam", "follower"]
{}
base_radius = {:.17g}
law = "{}"
lift = {:.17g}
start = {:.17g}
rise = {:.17g}
dwell = {:.17g}
return = {:.17g}
surface = "steel"
[run]
duration = {:.17g}
start = "given"
)",
                       -size * gravity, size * size, -speed, size * size, y, y, -speed, restitution,
                       roller ? fmt::format("follower = \"roller\"\nroller_radius = {:.17g}", size * radius)
                              : "axis = [-1.0, 0.0]",
                       size * (roller ? base - radius : base), lift.polynomial ? "polynomial" : "cycloidal",
                       size * lift.lift, M_PI / 2 + 0.3, lift.rise, lift.dwell, lift.fall, duration);
  }
};

struct Worst {
  double separation = 0, landing = 0, approach = 0;
  int missed = 0, runs = 0, off = 0;
};

Worst lift_off(unsigned seed, int count, const test::Way& way) {
  std::mt19937_64 engine(seed);
  Worst worst;
  for (int i = 0; i < count; ++i) {
    const CamRig s(engine);
    const double from = s.separation();
    if (!(from < 2 * M_PI)) continue;
    const auto back = s.back(from);
    const double turn = 2 * M_PI / s.speed, end = (back.u + 0.3) / s.speed;
    const auto run = test::simulate(test::scene_by(way, s.scene(end + 1e-3 * turn)), way.family);
    ++worst.runs;
    const ContactEvent *left = nullptr, *landed = nullptr;
    for (const auto& e : run.events)
      if (e.kind == EventKind::separation) {
        if (!left) left = &e;
      } else if (left && !landed)
        landed = &e;
    if (run.ending.status != Ending::Status::finished || !left || !landed) {
      UNSCOPED_INFO(way.name << " " << i << ": " << run.ending.reason << ", events " << run.events.size());
      ++worst.missed;
      continue;
    }
    // Times by a turn of the cam, the approach by the greatest speed of the lift.
    const double a = std::abs(left->t - (from + 0.3) / s.speed) / turn, b = std::abs(landed->t - end) / turn,
                 c = std::abs(-landed->v_n_minus / s.size - back.approach) /
                     (2 * s.speed * s.lift.lift / std::min(s.lift.rise, s.lift.fall));
    // A grazing return has no definite time: compare where the approach is above 1 % of that speed.
    if (back.approach < 0.02 * s.speed * s.lift.lift) continue;
    worst.separation = std::max(worst.separation, a);
    worst.landing = std::max(worst.landing, b);
    worst.approach = std::max(worst.approach, c);
    worst.off += a > 1e-4 || b > 1e-4 || c > 1e-4;
  }
  return worst;
}

}  // namespace

TEST_CASE("followers separate from cams and return where closed forms say", "[cam]") {
  // The force is exact to the tolerance of a step, relative to the weight; the time of its zero is then
  // within the same order of a turn. 1e-10 of event-driven steps, 1e-6 of adaptive time steps, with a
  // factor of 100 for a force that vanishes slowly.
  for (const auto& way : {test::event_driven, test::automatic, test::chosen_steps}) {
    CAPTURE(way.name);
    const auto worst = lift_off(6302, 25, way);
    CHECK(worst.runs > 20);
    CHECK(worst.missed == 0);
    const double bound = way.stepping() ? 1e-4 : 1e-8;
    CHECK(worst.separation < bound);
    CHECK(worst.landing < bound);
    CHECK(worst.approach < bound);
  }
}

TEST_CASE("1,000 followers of two seeds separate and return where closed forms say", "[cam][.long]") {
  for (const unsigned seed : {630201u, 630202u})
    for (const auto& way : {test::event_driven, test::automatic, test::chosen_steps}) {
      const auto worst = lift_off(seed, 1000, way);
      WARN(way.name << ", seed " << seed << ": " << worst.runs << " runs, " << worst.missed << " missed, "
                    << worst.off << " off by more than 1e-4; separation " << worst.separation << ", landing "
                    << worst.landing << ", approach " << worst.approach);
      CHECK(worst.missed == 0);
      CHECK(worst.off == 0);
    }
}
