// The reference for forces in a slider-crank, compared with second derivations that share no
// equation with it: energy and momentum from positions that are written from the geometry and
// differentiated numerically, and statics by hand. Units are SI throughout.
#include <catch2/catch.hpp>

#include "verification/references/slider_crank_forces.hpp"
#include "verification/unit/references/force_derivations.hpp"

using namespace freeplay::reference;
using namespace freeplay::reference::derived;
using freeplay::reference::derived::within;

namespace {

/// Positions of the slider-crank's centres as functions of the crank angle, and quantities derived
/// from them alone.
struct Positions {
  const LoadedSliderCrank<Long>& s;

  Long rod_angle(Long phi) const { return -std::asin(s.crank_length / s.rod_length * std::sin(phi)); }
  Vec gudgeon(Long phi) const {
    const Long y = s.crank_length * std::sin(phi);
    return {s.crank_length * std::cos(phi) + std::sqrt(s.rod_length * s.rod_length - y * y), 0};
  }
  Vec crank(Long phi) const { return s.crank_centre * direction(phi); }
  /// On the straight line between the pins.
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
    const auto of_crank = [&](Long a) { return crank(a); };
    const auto of_rod = [&](Long a) { return rod(a); };
    const auto of_slider = [&](Long a) { return slider(a); };
    const auto spin = [&](Long a) { return s.speed * richardson([&](Long b) { return rod_angle(b); }, a); };
    const Momentum c =
        rate([&](Long a) { return momentum(s.crank_mass, of_crank, s.crank_inertia * s.speed, a); }, phi);
    const Momentum r =
        rate([&](Long a) { return momentum(s.rod_mass, of_rod, s.rod_inertia * spin(a), a); }, phi);
    const Momentum t = rate([&](Long a) { return momentum(s.slider_mass, of_slider, 0, a); }, phi);
    const Vec given_c = s.crank_mass * s.gravity, given_r = s.rod_mass * s.gravity,
              given_t = s.slider_mass * s.gravity + s.load;
    // rod and guide together, both through the gudgeon pin
    const Vec at_slider = t.linear - given_t;
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

/// Scale of mass × acceleration of the forces in a slider-crank.
Long force_scale(const LoadedSliderCrank<Long>& s) {
  return (s.crank_mass + s.rod_mass + s.slider_mass) * (s.rod_length * s.speed * s.speed + size(s.gravity)) +
         size(s.load);
}

}  // namespace

TEST_CASE("slider-crank forces: balances of energy and momentum from numerically differentiated positions",
          "[references][forces]") {
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

TEST_CASE("slider-crank forces: at rest in the dead centre the rod is a beam on two supports",
          "[references][forces]") {
  const Long r = 0.05L, l = 0.3L, a = 0.02L, b = 0.12L, mc = 0.4L, m = 1.13L, J = 0.0153L, M = 1.013L,
             g = 9.81L;
  const char* const why = "roundings in long double of forces up to 100 N";
  const LoadedSliderCrank<Long> s{r, l, mc, a, 0.001L, m, b, J, M, {}, {0, -g}, {}, 0};

  // The shaft carries the crank and the near end.
  const SliderCrankForces<Long> f = slider_crank_forces(s, 0.0L);
  within(f.crank_on_rod, {0, m * g * (l - b) / l}, 1e-17L, why);
  within(f.rod_on_slider, {0, -m * g * b / l}, 1e-17L, why);
  within(f.guide.force, {0, M * g + m * g * b / l}, 1e-17L, why);
  within(f.ground_on_crank, {0, mc * g + m * g * (l - b) / l}, 1e-17L, why);
  within(f.torque, r * m * g * (l - b) / l + a * mc * g, 1e-17L, why);

  CHECK_THROWS(slider_crank_forces(LoadedSliderCrank<Long>{0.3L, 0.3L}, 0.0L));
}
