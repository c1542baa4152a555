// The references of forces and impulses held against second derivations that share no equation with them:
// energy and momentum of positions written down from the geometry and differentiated numerically, quadrature,
// statics by hand. Units are SI throughout.
#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <random>
#include <string>

#include "verification/analytic/reference_checks.hpp"
#include "verification/references/bearing_load.hpp"
#include "verification/references/bouncing_ball.hpp"
#include "verification/references/impulses.hpp"
#include "verification/references/slider_crank_forces.hpp"

using namespace freeplay::reference;

namespace {

using Vec = Planar<Long>;

/// Central differences of the steps h, h/2, … h/32, extrapolated to zero (Richardson).
///
/// Truncation: with R the distance of the nearest singularity in the complex plane, (h/R)¹² 2⁻³⁰ of f/R. The
/// tests keep h/R ≤ 0.2/1.1, which leaves 1.2e-18. Rounding: a value wrong by η leaves 2 η/(h/32), the 2 from
/// the weights of the extrapolation, so 315 η at h = 0.2. Positions of the size l are known to 3e-19 l
/// (arguments up to π and a handful of operations, ε/2 = 5e-20), first derivatives therefore to 1e-16 l,
/// second to 3e-14 l.
template <class Function>
Long richardson(const Function& f, Long t, Long h = 0.2L) {
  constexpr int levels = 6;
  Long row[levels];
  for (int i = 0; i < levels; ++i, h /= 2) {
    row[i] = (f(t + h) - f(t - h)) / (2 * h);
    Long four = 1;
    for (int j = i - 1; j >= 0; --j) {
      four *= 4;
      row[j] = row[j + 1] + (row[j + 1] - row[j]) / (four - 1);
    }
  }
  return row[0];
}

template <class Function>
Vec richardson_vector(const Function& f, Long t, Long h = 0.2L) {
  return {richardson([&](Long s) { return f(s).x; }, t, h), richardson([&](Long s) { return f(s).y; }, t, h)};
}

const Long once = 1e-15L;
const char* const why_once = "one Richardson derivative: 1e-16 of the scale, several terms";
const Long twice = 3e-14L;
const char* const why_twice = "two Richardson derivatives: 3e-14 of the scale";
const Long combined = 4e-13L;
const char* const why_combined = "3e-14 of the scale, five terms, divided by x ≥ 0.4 l";

void within(const Vec& measured, const Vec& expected, Long bound, const std::string& why) {
  freeplay::reference::within(measured.x, expected.x, bound, "x: " + why);
  freeplay::reference::within(measured.y, expected.y, bound, "y: " + why);
}
using freeplay::reference::within;

Long size(const Vec& a) { return std::hypot(a.x, a.y); }

class Draw {
 public:
  explicit Draw(unsigned seed) : generator_(seed) {}
  Long between(Long a, Long b) {
    return a + (b - a) * std::uniform_real_distribution<Long>(0, 1)(generator_);
  }
  Vec vector(Long most) {
    const Long x = between(-most, most);
    return {x, between(-most, most)};
  }

 private:
  std::mt19937 generator_;
};

/// Positions of the slider-crank's centres as functions of the crank angle, and what follows from them alone.
struct Positions {
  const LoadedSliderCrank<Long>& s;

  Long rod_angle(Long phi) const { return -std::asin(s.crank_length / s.rod_length * std::sin(phi)); }
  Vec gudgeon(Long phi) const {
    const Long y = s.crank_length * std::sin(phi);
    return {s.crank_length * std::cos(phi) + std::sqrt(s.rod_length * s.rod_length - y * y), 0};
  }
  Vec crank(Long phi) const { return s.crank_centre * direction(phi); }
  /// On the straight line from pin to pin.
  Vec rod(Long phi) const {
    const Vec from = s.crank_length * direction(phi);
    return from + (s.rod_centre / s.rod_length) * (gudgeon(phi) - from);
  }
  Vec slider(Long phi) const { return gudgeon(phi) + s.slider_centre; }

  struct Momentum {
    Vec linear;
    Long angular;  // about the origin
  };
  template <class Place>
  Momentum momentum(Long mass, const Place& place, Long spin, Long phi) const {
    const Vec p = (mass * s.speed) * richardson_vector(place, phi);
    return {p, cross(place(phi), p) + spin};
  }
  Momentum of_crank(Long phi) const {
    return momentum(
        s.crank_mass, [&](Long a) { return crank(a); }, s.crank_inertia * s.speed, phi);
  }
  Momentum of_rod(Long phi) const {
    const Long rate = s.speed * richardson([&](Long a) { return rod_angle(a); }, phi);
    return momentum(
        s.rod_mass, [&](Long a) { return rod(a); }, s.rod_inertia * rate, phi);
  }
  Momentum of_slider(Long phi) const {
    return momentum(
        s.slider_mass, [&](Long a) { return slider(a); }, 0, phi);
  }
  template <class Part>
  Momentum rate(const Part& part, Long phi) const {
    return {s.speed * richardson_vector([&](Long a) { return part(a).linear; }, phi),
            s.speed * richardson([&](Long a) { return part(a).angular; }, phi)};
  }

  /// Kinetic energy and potential of gravity and load.
  Long energy(Long phi) const {
    const auto square = [](const Vec& v) { return dot(v, v); };
    const Long w2 = s.speed * s.speed;
    const Long spin = richardson([&](Long a) { return rod_angle(a); }, phi);
    const Long kinetic = s.crank_mass * square(richardson_vector([&](Long a) { return crank(a); }, phi)) +
                         s.crank_inertia +
                         s.rod_mass * square(richardson_vector([&](Long a) { return rod(a); }, phi)) +
                         s.rod_inertia * spin * spin +
                         s.slider_mass * square(richardson_vector([&](Long a) { return slider(a); }, phi));
    return w2 * kinetic / 2 -
           dot(s.gravity, s.crank_mass * crank(phi) + s.rod_mass * rod(phi) + s.slider_mass * slider(phi)) -
           dot(s.load, slider(phi));
  }

  /// τ ω = Ė, divided by ω, is dE/dφ; reactions from the momentum of parts and of the whole.
  SliderCrankForces<Long> forces(Long phi) const {
    SliderCrankForces<Long> f;
    f.torque = richardson([&](Long a) { return energy(a); }, phi);
    const Momentum c = rate([&](Long a) { return of_crank(a); }, phi);
    const Momentum r = rate([&](Long a) { return of_rod(a); }, phi);
    const Momentum t = rate([&](Long a) { return of_slider(a); }, phi);
    const Vec given_c = s.crank_mass * s.gravity, given_r = s.rod_mass * s.gravity,
              given_t = s.slider_mass * s.gravity + s.load;
    const Vec at_slider = t.linear - given_t;  // rod and guide together, both through the gudgeon pin
    f.guide.moment = t.angular - cross(slider(phi), given_t) - cross(gudgeon(phi), at_slider);
    const Long given = cross(crank(phi), given_c) + cross(rod(phi), given_r) + cross(slider(phi), given_t);
    const Long n = (c.angular + r.angular + t.angular - f.torque - f.guide.moment - given) / gudgeon(phi).x;
    f.guide.force = {0, n};
    f.rod_on_slider = at_slider - f.guide.force;
    f.crank_on_rod = r.linear - given_r + at_slider - f.guide.force;
    f.ground_on_crank = c.linear - given_c + f.crank_on_rod;
    return f;
  }
};

LoadedSliderCrank<Long> drawn(Draw& draw) {
  LoadedSliderCrank<Long> s;
  s.rod_length = draw.between(0.1L, 1);
  s.crank_length = draw.between(0.1L, 0.6L) * s.rod_length;
  s.crank_mass = draw.between(0.1L, 2);
  s.crank_centre = draw.between(-1, 1) * s.crank_length;
  s.crank_inertia = draw.between(0, 1) * s.crank_mass * s.crank_length * s.crank_length;
  s.rod_mass = draw.between(0.1L, 2);
  s.rod_centre = draw.between(0, 1) * s.rod_length;
  s.rod_inertia = draw.between(0.05L, 0.3L) * s.rod_mass * s.rod_length * s.rod_length;
  s.slider_mass = draw.between(0.1L, 2);
  s.slider_centre = draw.vector(0.2L * s.rod_length);
  s.gravity = draw.vector(10);
  s.load = draw.vector(50);
  s.speed = draw.between(-30, 30);
  return s;
}

/// Mass × acceleration that the forces of a slider-crank are made of.
Long force_scale(const LoadedSliderCrank<Long>& s) {
  return (s.crank_mass + s.rod_mass + s.slider_mass) * (s.rod_length * s.speed * s.speed + size(s.gravity)) +
         size(s.load);
}

template <class Real>
LoadedSliderCrank<Real> rounded(const LoadedSliderCrank<Long>& s) {
  const auto r = [](Long x) { return static_cast<Real>(x); };
  const auto v = [](const Vec& x) { return Planar<Real>{static_cast<Real>(x.x), static_cast<Real>(x.y)}; };
  return {r(s.crank_length), r(s.rod_length), r(s.crank_mass),  r(s.crank_centre), r(s.crank_inertia),
          r(s.rod_mass),     r(s.rod_centre), r(s.rod_inertia), r(s.slider_mass),  v(s.slider_centre),
          v(s.gravity),      v(s.load),       r(s.speed)};
}

Vec widened(const Planar<double>& v) { return {v.x, v.y}; }

}  // namespace

// ---------------------------------------------------------------------------------------------- slider-crank

TEST_CASE("slider-crank forces: energy and momentum of the positions", "[references][forces]") {
  Draw draw(1);
  for (int trial = 0; trial < 40; ++trial) {
    LoadedSliderCrank<Long> s = drawn(draw);
    if (trial % 10 == 9) s.speed = 0;  // statics
    const Positions second{s};
    const Long scale = force_scale(s), l = s.rod_length, w = s.speed;
    for (int i = 0; i < 8; ++i) {
      const Long phi = draw.between(-3, 3);
      INFO("trial " << trial << ", angle " << phi);
      const SliderCrankForces<Long> f = slider_crank_forces(s, phi), g = second.forces(phi);
      const auto angle = [&](Long a) { return second.rod_angle(a); };
      const auto place = [&](Long a) { return second.gudgeon(a).x; };
      const auto derivative = [](const auto& of) { return [of](Long a) { return richardson(of, a); }; };
      within(f.motion.rod_angle, angle(phi), 1e-18L, "rounding");
      within(f.motion.x, place(phi), 1e-18L, "rounding");
      within(f.motion.rod_rate, w * richardson(angle, phi), once * std::abs(w), why_once);
      within(f.motion.velocity, w * richardson(place, phi), once * l * std::abs(w), why_once);
      within(f.motion.rod_acceleration, w * w * richardson(derivative(angle), phi), twice * w * w, why_twice);
      within(f.motion.acceleration, w * w * richardson(derivative(place), phi), twice * l * w * w, why_twice);
      within(f.torque, g.torque, twice * scale * l, why_twice);
      within(f.rod_on_slider.x, g.rod_on_slider.x, twice * scale, why_twice);
      within(f.guide.moment, g.guide.moment, combined * scale * l, why_combined);
      within(f.guide.force, g.guide.force, combined * scale, why_combined);
      within(f.rod_on_slider, g.rod_on_slider, combined * scale, why_combined);
      within(f.crank_on_rod, g.crank_on_rod, combined * scale, why_combined);
      within(f.ground_on_crank, g.ground_on_crank, combined * scale, why_combined);
    }
  }
}

TEST_CASE("slider-crank forces: in double as in long double", "[references][forces]") {
  Draw draw(2);
  const char* why = "dozens of roundings in double of terms up to the scale over cos θ ≥ 0.8";
  for (int trial = 0; trial < 200; ++trial) {
    // Both from the same numbers of double.
    const LoadedSliderCrank<double> s = rounded<double>(drawn(draw));
    LoadedSliderCrank<Long> fine;
    fine.crank_length = s.crank_length, fine.rod_length = s.rod_length;
    fine.crank_mass = s.crank_mass, fine.crank_centre = s.crank_centre, fine.crank_inertia = s.crank_inertia;
    fine.rod_mass = s.rod_mass, fine.rod_centre = s.rod_centre, fine.rod_inertia = s.rod_inertia;
    fine.slider_mass = s.slider_mass, fine.slider_centre = widened(s.slider_centre);
    fine.gravity = widened(s.gravity), fine.load = widened(s.load), fine.speed = s.speed;
    const double phi = static_cast<double>(draw.between(-3, 3));
    const SliderCrankForces<double> a = slider_crank_forces(s, phi);
    const SliderCrankForces<Long> b = slider_crank_forces(fine, Long(phi));
    const Long bound = 1e-14L * force_scale(fine);
    within(widened(a.crank_on_rod), b.crank_on_rod, bound, why);
    within(widened(a.rod_on_slider), b.rod_on_slider, bound, why);
    within(widened(a.guide.force), b.guide.force, bound, why);
    within(widened(a.ground_on_crank), b.ground_on_crank, bound, why);
    within(a.guide.moment, b.guide.moment, bound * fine.rod_length, why);
    within(a.torque, b.torque, bound * fine.rod_length, why);
  }
}

TEST_CASE("slider-crank forces: dead centres, statics and the crank alone by hand", "[references][forces]") {
  const Long r = 0.05L, l = 0.3L, a = 0.02L, b = 0.12L, mc = 0.4L, m = 1.13L, J = 0.0153L, M = 1.013L,
             g = 9.81L;
  const char* const why = "roundings in long double of forces up to 100 N";
  LoadedSliderCrank<Long> s{r, l, mc, a, 0.001L, m, b, J, M, {}, {0, -g}, {}, 0};

  // At rest in top dead centre the rod is a beam on two supports, the shaft carries crank and near end.
  SliderCrankForces<Long> f = slider_crank_forces(s, 0.0L);
  within(f.crank_on_rod, {0, m * g * (l - b) / l}, 1e-17L, why);
  within(f.rod_on_slider, {0, -m * g * b / l}, 1e-17L, why);
  within(f.guide.force, {0, M * g + m * g * b / l}, 1e-17L, why);
  within(f.ground_on_crank, {0, mc * g + m * g * (l - b) / l}, 1e-17L, why);
  within(f.torque, r * m * g * (l - b) / l + a * mc * g, 1e-17L, why);

  // A push on the slider towards the shaft (gas) is felt by the rod, the crank and the ground; the drive has
  // to hold it back: with massless parts τ = −P_x dx/dφ, here at φ = π/2 where dx/dφ = −r, so τ = r P_x < 0,
  // and the rod's slope presses the slider against the guide's side y < 0, which pushes up.
  s = {r, l, 0, 0, 0, 0, 0, 0, 0, {}, {}, {-80, 0}, 0};
  const Long quarter = std::acos(0.0L), slope_of_rod = r / std::sqrt(l * l - r * r);
  f = slider_crank_forces(s, quarter);
  within(f.rod_on_slider, {80, -80 * slope_of_rod}, 1e-16L, why);
  within(f.crank_on_rod, f.rod_on_slider, 1e-16L, "a massless rod passes its force on");
  within(f.ground_on_crank, f.rod_on_slider, 1e-16L, "and so does a massless crank");
  within(f.guide.force, {0, 80 * slope_of_rod}, 1e-16L, why);
  within(f.torque, -80 * r, 1e-17L, why);

  // Turning, without gravity: at the dead centres the slider has −r ω² (±1 + r/l), the rod's centre the share
  // of its place between the pins, and nothing acts across but what turns the rod, θ̈ = 0.
  const Long w = 20;
  s = {r, l, mc, a, 0.001L, m, b, J, M, {}, {}, {}, w};
  for (const Long side : {1.0L, -1.0L}) {
    f = slider_crank_forces(s, side > 0 ? 0.0L : 2 * quarter);
    const Long end = -r * w * w * (side + r / l), middle = -side * r * w * w * (1 - b / l) + end * b / l;
    within(f.rod_on_slider, {M * end, 0}, 1e-16L, why);
    within(f.crank_on_rod, {M * end + m * middle, 0}, 1e-16L, why);
    within(f.ground_on_crank, {M * end + m * middle - side * mc * a * w * w, 0}, 1e-16L, why);
    within(f.torque, 0, 1e-17L, why);
  }

  // Crank alone: the rotor of bearing_load.hpp.
  s = {r, l, mc, a, 0.001L, 0, 0, 0, 0, {}, {1.2L, -g}, {}, w};
  for (Long phi = -3; phi < 3; phi += 0.7L) {
    f = slider_crank_forces(s, phi);
    const RotorLoad<Long> alone = rotor_load<Long>({mc, a, 0.001L}, {phi, w, 0}, s.gravity);
    within(f.ground_on_crank, alone.reaction, 1e-17L, why);
    within(f.torque, alone.torque, 1e-18L, why);
    within(f.crank_on_rod, {0, 0}, 0, "nothing to move");
  }
  CHECK_THROWS(slider_crank_forces(LoadedSliderCrank<Long>{0.3L, 0.3L}, 0.0L));
}

TEST_CASE("slider-crank forces: means over a turn", "[references][forces]") {
  Draw draw(3);
  const Long pi_long = std::acos(-1.0L);
  for (int trial = 0; trial < 10; ++trial) {
    const LoadedSliderCrank<Long> s = drawn(draw);
    const int count = 240;
    Vec outside;
    Long torque = 0;
    for (int i = 0; i < count; ++i) {
      const SliderCrankForces<Long> f = slider_crank_forces(s, 2 * pi_long * i / count);
      outside = outside + f.ground_on_crank + f.guide.force;
      torque += f.torque;
    }
    const Long scale = force_scale(s);
    const Vec given = (s.crank_mass + s.rod_mass + s.slider_mass) * s.gravity + s.load;
    const char* const why =
        "the rule's error e^{−240·1.1} is nothing; 240 roundings of terms up to the scale, 1e-17 of it";
    within((1.0L / count) * outside, -given, 1e-17L * scale, why);
    within(torque / count, 0, 1e-17L * scale * s.rod_length, why);
  }
}

// --------------------------------------------------------------------------------------------- bearing loads

TEST_CASE("rotor: momentum, angular momentum and power of its centre's path", "[references][forces]") {
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
    // Angles count like lengths here, l = 1 m above the eccentricity.
    const Long scale = (rotor.mass + rotor.inertia) * (pace * pace + size(g));
    within(load.reaction, richardson_vector(momentum, 0, h) - rotor.mass * g, twice * scale, why_twice);
    const auto angular = [&](Long t) { return cross(place(t), momentum(t)) + spin(t); };
    within(load.torque, richardson(angular, 0, h) - cross(place(0), rotor.mass * g), 2 * twice * scale,
           "two terms of two Richardson derivatives");
    within(load.torque * at.speed, richardson(energy, 0, h), 2 * twice * scale * pace,
           "two terms of two Richardson derivatives, times the speed");
  }
}

TEST_CASE("rotor: by hand", "[references][forces]") {
  const Long m = 1.7L, a = 0.08L, w = 31, g = 9.81L;
  const char* const why = "roundings in long double of 150 N";
  for (Long angle = -3; angle < 7; angle += 0.4L) {
    const RotorLoad<Long> load = rotor_load<Long>({m, a, 0.01L}, {angle, w, 0}, {0, -g});
    within(load.reaction, {-m * a * w * w * std::cos(angle), m * g - m * a * w * w * std::sin(angle)}, 1e-16L,
           why);
    within(load.torque, m * g * a * std::cos(angle), 1e-17L, why);
    const RotorLoad<Long> balanced = rotor_load<Long>({m, 0, 0.01L}, {angle, w, 0}, {0, -g});
    within(balanced.reaction, {0, m * g}, 0, "a balanced rotor only weighs");
    within(balanced.torque, 0, 0, "and needs no torque");
  }
  // A mass on a thread let go level: ω² = 2 g/a at the bottom, tension three times the weight.
  const Long down = -std::acos(0.0L);
  const RotorLoad<Long> bottom = rotor_load<Long>({m, a, 0}, {down, std::sqrt(2 * g / a), 0}, {0, -g});
  within(bottom.reaction, {0, 3 * m * g}, 1e-16L, why);
  // A rod let go level falls with 3g/(2 l) and leaves a quarter of its weight to the hinge.
  const Long l = 2 * a;
  const RotorLoad<Long> rod = rotor_load<Long>({m, a, m * l * l / 12}, {0, 0, -3 * g / (2 * l)}, {0, -g});
  within(rod.reaction, {0, m * g / 4}, 1e-17L, why);
  within(rod.torque, 0, 1e-18L, why);
}

TEST_CASE("weld: momentum, angular momentum and power of the body carried round", "[references][forces]") {
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
    // By distance and bearing from the axis.
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
  // A cantilever at rest, and a bar spun about one end and cut in the middle: half of it at 3l/4.
  const JointLoad<Long> still = weld_load<Long>({2, 0.1L, {0.3L, 0}, {0.5L, 0}}, {}, {0, -10});
  within(still.force, {0, 20}, 1e-18L, "the weight");
  within(still.moment, 10, 1e-18L, "the weight times its arm, holding it up counter-clockwise");
  const JointLoad<Long> spun = weld_load<Long>({2, 0.1L, {0.5L, 0}, {0.25L, 0}}, {0, 4, 0}, {});
  within(spun.force, {-2 * 0.75L * 16, 0}, 1e-18L, "m ω² 3l/4 inwards");
  within(spun.moment, 0, 1e-18L, "in line");
}

TEST_CASE("guide: momentum and angular momentum of a body that slides", "[references][forces]") {
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

TEST_CASE("guide: by hand", "[references][forces]") {
  const Long m = 2, g = 9.81L, slope_angle = 0.4L;
  const char* const why = "roundings in long double of 20 N";
  // A block on a slope without friction: N = m g cos β, and no moment about the foot of its centre.
  const Vec n = quarter_turn(direction(slope_angle));
  const GuidedBody<Long> block{m, slope_angle, 0.3L * n, {}, {}};
  within(guided_acceleration(block, {0, -g}), -g * std::sin(slope_angle), 1e-18L, why);
  const GuideLoad<Long> sliding = guide_load(block, guided_acceleration(block, {0, -g}), {0, -g});
  within(sliding.joint.force, m * g * std::cos(slope_angle) * n, 1e-17L, why);
  within(sliding.joint.moment, 0, 1e-17L, why);
  // Held at rest: D = m g sin β, and the moment that keeps it from tilting over its foot.
  const GuideLoad<Long> held = guide_load(block, 0.0L, {0, -g});
  within(held.drive, m * g * std::sin(slope_angle), 1e-17L, why);
  within(held.joint.moment, -0.3L * m * g * std::sin(slope_angle), 1e-17L, why);
  // Level guide, arm out to the right, 5 N down at its end: held up counter-clockwise.
  const GuideLoad<Long> arm = guide_load<Long>({m, 0, {0.1L, 0}, {0, -5}, {0.7L, 0.2L}}, 0, {0, -g});
  within(arm.joint.force, {0, m * g + 5}, 1e-17L, why);
  within(arm.joint.moment, 0.1L * m * g + 0.7L * 5, 1e-17L, why);
  // A mast accelerated to the right has to be pushed over forwards, clockwise.
  const GuideLoad<Long> mast = guide_load<Long>({m, 0, {0, 0.5L}, {}, {}}, 3, {});
  within(mast.joint.moment, -0.5L * m * 3, 1e-18L, why);
  within(mast.drive, m * 3, 1e-18L, why);
}

// ---------------------------------------------------------------------------------------------- impulses

TEST_CASE("dropped ball: momentum from rest to rest", "[references][impulses]") {
  for (const double e : {0.0, 0.46, 0.9, 1.0}) {
    const double m = 0.3, h = 1.7, g = 9.81;
    const BouncingBall ball{h, g, e};
    const double p = drop_impulse(m, h, e, g);
    const BallImpact first = ball_impact(ball, 1);
    within(p, m * g * (first.t + first.rebound / g), 1e-14,
           "the weight's impulse from release to the next top");
    within(p, m * (first.approach + first.rebound), 1e-14, rounding);
    if (e < 1) {
      double sum = 0, drop = h;
      for (int k = 0; k < 400; ++k, drop *= e * e) sum += drop_impulse(m, drop, e, g);
      within(sum, m * g * ball_accumulation_time(ball), 1e-12, "0.9⁴⁰⁰ left out, four hundred roundings");
    }
  }
}

TEST_CASE("dropped ball: a contact that lasts carries the weight as well", "[references][impulses]") {
  // Linear spring: δ = (g/w²)(1 − cos w t) + (v/w) sin w t, free again at w T = 2 (π − atan(v w/g)).
  const Long m = 0.3L, k = 2e3L, g = 9.81L, h = 0.2L, w = std::sqrt(k / m), v = std::sqrt(2 * g * h);
  const Long duration = 2 * (std::acos(-1.0L) - std::atan(v * w / g)) / w;
  const auto force = [&](Long t) {
    return k * (g / (w * w) * (1 - std::cos(w * t)) + v / w * std::sin(w * t));
  };
  within(force(duration), 0, 1e-16L, "roundings in long double of 50 N");
  const Long impulse = boost::math::quadrature::gauss<Long, 30>::integrate(force, 0.0L, duration);
  within(impulse, drop_impulse(m, h, 1.0L, g) + m * g * duration, 1e-17L,
         "Gauss of order 60 on half a wave is exact to rounding; a few dozen roundings");
}

TEST_CASE("low-pass: gain of a Butterworth filter, and the impulse kept", "[references][impulses]") {
  const Long f = 3e3L, impulse = 0.7L, w = 2 * std::acos(-1.0L) * f;
  const char* const why =
      "Gauss of order 60 on panels of 2/ω_c is exact to rounding, e^{−220 sin(π/16)} = 2e-19 left out; modes "
      "add "
      "up to some tens, over five time constants: 1e-17, tenfold";
  using Gauss = boost::math::quadrature::gauss<Long, 30>;
  for (int order = 1; order <= 8; ++order) {
    INFO("order " << order);
    const auto y = [&](Long t) { return low_pass_response(order, f, impulse, t); };
    for (const Long ratio : {0.0L, 0.5L, 1.0L, 2.0L}) {
      Long re = 0, im = 0;
      for (int panel = 0; panel < 110; ++panel) {
        const Long from = 2 * panel / w, to = 2 * (panel + 1) / w;
        re += Gauss::integrate([&](Long t) { return y(t) * std::cos(ratio * w * t); }, from, to);
        im -= Gauss::integrate([&](Long t) { return y(t) * std::sin(ratio * w * t); }, from, to);
      }
      within(std::hypot(re, im) / impulse, 1 / std::sqrt(1 + std::pow(ratio, 2.0L * order)), 1e-16L, why);
      if (ratio == 0) within(re, impulse, 1e-16L, why);
    }
    within(low_pass_integral(order, f, impulse, 0.0L), 0, 1e-16L, "starts from nothing");
    within(low_pass_integral(order, f, impulse, 220 / w), impulse, 1e-16L, "ends with the impulse");
    const Long middle = 1.7L / w;
    within(low_pass_integral(order, f, impulse, middle), Gauss::integrate(y, 0.0L, middle), 1e-16L, why);
  }
  CHECK_THROWS(low_pass_modes(0, f));
}

TEST_CASE("low-pass of order 2: its equation, start, peak and the modes", "[references][impulses]") {
  const Long f = 3e3L, impulse = 0.7L, pi_long = std::acos(-1.0L), w = 2 * pi_long * f, h = 0.2L / w;
  const auto y = [&](Long t) { return low_pass2_response(f, impulse, t); };
  const auto rate = [&](Long t) { return richardson(y, t, h); };
  const Long scale = impulse * w;
  for (Long a = 0.5L; a < 9; a += 0.37L) {
    const Long t = a / w;
    within(richardson(rate, t, h) + std::sqrt(2.0L) * w * rate(t) + w * w * y(t), 0,
           2 * twice * scale * w * w, "two Richardson derivatives, three terms");
    within(richardson([&](Long s) { return low_pass2_integral(f, impulse, s); }, t, h), y(t), once * scale,
           why_once);
    within(y(t), low_pass_response(2, f, impulse, t), 1e-17L * scale, "roundings in long double");
    within(low_pass2_integral(f, impulse, t), low_pass_integral(2, f, impulse, t), 1e-17L,
           "roundings in long double");
  }
  // The input's δ leaves ẏ = ω_c² P and y = 0 behind.
  const Long early = 1e-6L / w;
  within(y(early) / early, w * w * impulse, 1e-6L * w * w * impulse, "next term −ω_c t/√2 of it, 0.71e-6");
  const Long top = pi_long / 4 * std::sqrt(2.0L) / w;
  within(y(top), scale * std::exp(-pi_long / 4), 1e-18L * scale,
         "the peak's value; roundings in long double");
  within(rate(top), 0, once * scale * w, why_once);
  within(y(pi_long * std::sqrt(2.0L) / w), 0, 1e-18L * scale, "first zero; roundings in long double");
  CHECK(y(-1e-9L) == 0);
  CHECK(low_pass2_integral(f, impulse, -1e-9L) == 0);
}
