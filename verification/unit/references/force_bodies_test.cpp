// The references for forces on single bodies and for a filtered impulse, compared with second
// derivations that share no equation with them: energy and momentum from positions that are written
// from the geometry and differentiated numerically, and the filter's differential equation. Units
// are SI throughout.
#include <catch2/catch.hpp>
#include <cmath>

#include "verification/references/bearing_load.hpp"
#include "verification/references/impulses.hpp"
#include "verification/unit/references/force_derivations.hpp"

using namespace freeplay::reference;
using namespace freeplay::reference::derived;
using freeplay::reference::derived::within;

TEST_CASE(
    "rotor: bearing load equals the rate of momentum of the centre of mass, "
    "its angular momentum and its power",
    "[references][forces]") {
  Draw draw(4);
  for (int trial = 0; trial < 60; ++trial) {
    const Rotor<Long> rotor{draw.between(0.1L, 3), draw.between(-0.5L, 0.5L), draw.between(0, 0.3L)};
    const Turning<Long> at{draw.between(-3, 3), draw.between(-20, 20),
                           trial % 2 ? draw.between(-200, 200) : 0};
    const Vec g = draw.vector(10);
    const RotorLoad<Long> load = rotor_load(rotor, at, g);

    const Long pace = std::abs(at.speed) + std::sqrt(std::abs(at.acceleration)), h = 0.2L / pace;
    const auto angle = [&](Long t) { return at.angle + t * (at.speed + t * at.acceleration / 2); };
    const auto place = [&](Long t) { return rotor.eccentricity * direction(angle(t)); };
    const auto momentum = [&](Long t) { return rotor.mass * richardson_vector(place, t, h); };
    const auto spin = [&](Long t) { return rotor.inertia * richardson(angle, t, h); };
    const auto energy = [&](Long t) {
      const Vec p = momentum(t);
      return dot(p, p) / (2 * rotor.mass) + spin(t) * spin(t) / (2 * rotor.inertia) -
             rotor.mass * dot(g, place(t));
    };
    // Angles are scaled like lengths here, l = 1 m above the eccentricity.
    const Long scale = (rotor.mass + rotor.inertia) * (pace * pace + size(g));
    within(load.reaction, richardson_vector(momentum, 0, h) - rotor.mass * g, twice * scale, why_twice);
    const auto angular = [&](Long t) { return cross(place(t), momentum(t)) + spin(t); };
    within(load.torque, richardson(angular, 0, h) - cross(place(0), rotor.mass * g), 2 * twice * scale,
           "two terms of two Richardson derivatives");
    within(load.torque * at.speed, richardson(energy, 0, h), 2 * twice * scale * pace,
           "two terms of two Richardson derivatives, times the speed");
  }
}

TEST_CASE("weld: load equals the rates of momentum and angular momentum of the welded body, and its power",
          "[references][forces]") {
  Draw draw(5);
  for (int trial = 0; trial < 60; ++trial) {
    const WeldedBody<Long> body{draw.between(0.1L, 3), draw.between(0.01L, 0.3L), draw.vector(0.3L),
                                draw.vector(0.3L)};
    const Turning<Long> at{draw.between(-3, 3), draw.between(-20, 20),
                           trial % 2 ? draw.between(-200, 200) : 0};
    const Vec g = draw.vector(10);
    const JointLoad<Long> load = weld_load(body, at, g);

    const Long pace = std::abs(at.speed) + std::sqrt(std::abs(at.acceleration)), h = 0.2L / pace;
    const auto angle = [&](Long t) { return at.angle + t * (at.speed + t * at.acceleration / 2); };
    // By distance and direction from the axis.
    const auto carried = [&](const Vec& v, Long t) {
      return size(v) * direction(std::atan2(v.y, v.x) + angle(t));
    };
    const auto joint = [&](Long t) { return carried(body.joint, t); };
    const auto centre = [&](Long t) { return carried(body.joint + body.centre, t); };
    const auto momentum = [&](Long t) { return body.mass * richardson_vector(centre, t, h); };
    const auto spin = [&](Long t) { return body.inertia * richardson(angle, t, h); };
    const auto angular = [&](Long t) { return cross(centre(t), momentum(t)) + spin(t); };
    const auto energy = [&](Long t) {
      const Vec p = momentum(t);
      return dot(p, p) / (2 * body.mass) + spin(t) * spin(t) / (2 * body.inertia) -
             body.mass * dot(g, centre(t));
    };
    const Long scale = (body.mass + body.inertia) * (pace * pace + size(g));
    const char* const why =
        "a few terms of two Richardson derivatives; arguments up to 2π, twice the rounding";
    const Vec force = richardson_vector(momentum, 0, h) - body.mass * g;
    within(load.force, force, 2 * twice * scale, why);
    const Long about_axis = richardson(angular, 0, h) - cross(centre(0), body.mass * g);
    within(load.moment, about_axis - cross(joint(0), force), 4 * twice * scale, why);
    within(moment_about(load, -joint(0)), about_axis, 4 * twice * scale, why);
    within(moment_about(load, centre(0) - joint(0)), body.inertia * at.acceleration, 1e-17L * scale,
           "about the centre of mass the weight is silent: roundings in long double");
    within(dot(load.force, richardson_vector(joint, 0, h)) + load.moment * at.speed, richardson(energy, 0, h),
           4 * twice * scale * pace, why);
  }
}

TEST_CASE("guide: load equals the rates of momentum and angular momentum of the sliding body",
          "[references][forces]") {
  Draw draw(6);
  for (int trial = 0; trial < 60; ++trial) {
    const GuidedBody<Long> body{draw.between(0.1L, 3), draw.between(-3, 3), draw.vector(0.5L),
                                draw.vector(30), draw.vector(0.5L)};
    const Vec g = draw.vector(10), start = draw.vector(0.5L), t = direction(body.axis_angle);
    const Long speed = draw.between(-3, 3);
    const Long acceleration = trial % 2 ? draw.between(-20, 20) : guided_acceleration(body, g);
    const GuideLoad<Long> load = guide_load(body, acceleration, g);
    const auto joint = [&](Long s) { return start + (s * (speed + acceleration * s / 2)) * t; };
    const auto centre = [&](Long s) { return joint(s) + body.centre; };
    const auto momentum = [&](Long s) { return body.mass * richardson_vector(centre, s); };
    const auto angular = [&](Long s) { return cross(centre(s), momentum(s)); };
    const Long scale = body.mass * (std::abs(acceleration) + std::abs(speed) + size(g) + 1) + size(body.load);
    const char* const why =
        "quadratic in time, so no truncation; two derivatives of positions near one, a few terms";
    const Vec all = load.joint.force + load.drive * t;
    within(all, richardson_vector(momentum, 0) - body.mass * g - body.load, 2 * twice * scale, why);
    within(dot(load.joint.force, t), 0, 1e-18L * scale, "without friction");
    within(
        cross(joint(0), all) + load.joint.moment,
        richardson(angular, 0) - cross(centre(0), body.mass * g) - cross(joint(0) + body.load_at, body.load),
        4 * twice * scale, why);
    if (trial % 2 == 0) within(load.drive, 0, 1e-17L * scale, "left to itself");
  }
}

TEST_CASE("low-pass filter of order 2: differential equation, start and peak of the impulse response",
          "[references][impulses]") {
  const Long f = 3e3L, impulse = 0.7L, pi_long = std::acos(-1.0L), w = 2 * pi_long * f, h = 0.2L / w;
  const auto y = [&](Long t) { return low_pass2_response(f, impulse, t); };
  const auto rate = [&](Long t) { return richardson(y, t, h); };
  const Long scale = impulse * w;
  for (Long a = 0.5L; a < 9; a += 0.37L) {
    const Long t = a / w;
    within(richardson(rate, t, h) + std::sqrt(2.0L) * w * rate(t) + w * w * y(t), 0,
           2 * twice * scale * w * w, "two Richardson derivatives, three terms");
  }
  // The δ impulse of the input gives the initial values ẏ = ω_c² P and y = 0.
  const Long early = 1e-6L / w;
  within(y(early) / early, w * w * impulse, 1e-6L * w * w * impulse, "next term −ω_c t/√2 of it, 0.71e-6");
  const Long top = pi_long / 4 * std::sqrt(2.0L) / w;
  within(y(top), scale * std::exp(-pi_long / 4), 1e-18L * scale,
         "the peak's value; roundings in long double");
  within(rate(top), 0, once * scale * w, why_once);
  within(y(pi_long * std::sqrt(2.0L) / w), 0, 1e-18L * scale, "first zero; roundings in long double");
  CHECK(y(-1e-9L) == 0);
}
