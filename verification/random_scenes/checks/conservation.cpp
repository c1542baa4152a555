// Checks on a single run: energy, momentum, walls, Newton's and Euler's equations.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dynamics/elements/spring_force.hpp"
#include "verification/random_scenes/checks/checks.hpp"

namespace freeplay::verification::random_scenes {
namespace {

/// Kinetic and potential energy from the parameters and a state, without code of the model.
struct Energy {
  double kinetic = 0, potential = 0;
};
Energy energy_of(const Mechanism& m, const State& s) {
  Energy e;
  const auto place = [&](int body, Vec2 at) {
    if (body == ground) return at;
    const double a = s.q[3 * body + 2];
    return Vec2{s.q[3 * body] + std::cos(a) * at.x() - std::sin(a) * at.y(),
                s.q[3 * body + 1] + std::sin(a) * at.x() + std::cos(a) * at.y()};
  };
  const auto angle = [&](int body) { return body == ground ? 0.0 : s.q[3 * body + 2]; };
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    const auto& b = m.bodies[i];
    const double *q = s.q.data() + 3 * i, *v = s.v.data() + 3 * i;
    e.kinetic += 0.5 * b.mass * (v[0] * v[0] + v[1] * v[1]) + 0.5 * b.inertia * v[2] * v[2];
    e.potential -= b.mass * (m.gravity.x() * q[0] + m.gravity.y() * q[1]);
  }
  for (const auto& load : m.loads) {
    if (const auto* l = std::get_if<SpringDamper>(&load)) {
      const double length = (place(l->between[1], l->at[1]) - place(l->between[0], l->at[0])).norm();
      e.potential += SpringForce{l->law}.energy(l->stiffness, l->free_length, length);
    } else if (const auto* l = std::get_if<TorsionalSpringDamper>(&load)) {
      e.potential += SpringForce{l->law}.energy(l->stiffness, l->free_angle,
                                                angle(l->between[1]) - angle(l->between[0]));
    } else if (const auto* l = std::get_if<Bushing>(&load)) {
      const int i = l->between[0];
      const Vec2 d = place(l->between[1], l->at[1]) - place(i, l->at[0]),
                 along = place(i, l->axis) - place(i, {0, 0});
      const double x = dot(along, d), y = dot(perp(along), d),
                   turn = angle(l->between[1]) - angle(i) - l->free_angle;
      e.potential +=
          0.5 * (l->stiffness.x() * x * x + l->stiffness.y() * y * y + l->turn_stiffness * turn * turn) +
          SpringForce{l->radial}.energy(0, 0, d.norm());
    } else if (const auto* l = std::get_if<BeamElement>(&load)) {
      // By the flexibilities of a cantilever: end couples M_i, M_j turn the ends against the chord by
      // l (2M_i − M_j)/(6EI) + (M_i + M_j)/(κGA l) and likewise.
      const Vec2 d = place(l->between[1], l->at[1]) - place(l->between[0], l->at[0]);
      const double chord = std::atan2(d.y(), d.x());
      const auto turn = [&](std::size_t k, double own) {
        return std::remainder(angle(l->between[k]) + own - chord, 2 * std::numbers::pi);
      };
      const double a = turn(0, l->angles.x()), b = turn(1, l->angles.y()), h = l->length,
                   start = -0.5 * l->curvature * h, soft = l->shear > 0 ? 1 / (l->shear * h) : 0,
                   own = h / (3 * l->bending) + soft, other = -h / (6 * l->bending) + soft,
                   stretch = d.norm() - h + h / 30 * (2 * a * a - a * b + 2 * b * b);
      const double p = a - start, r = b + start;
      e.potential += 0.5 * l->axial / h * stretch * stretch +
                     0.5 * (own * (p * p + r * r) - 2 * other * p * r) / (own * own - other * other);
    }
  }
  return e;
}

/// The terms of the balance, from the states alone where possible.
std::optional<std::string> balance(Subject& s) {
  const auto& l = s.sight.result.ledger;
  const double bound = s.way.stepped ? 1e-3 : 1e-4;
  if (s.reduced()) {
    if (!(std::abs(l.closure()) <= bound * l.scale()))
      return fmt::format("balance misses {:.2g} of {:.2g} J, above {:.0e}", l.closure(), l.scale(), bound);
    return {};
  }
  const auto end = energy_of(s.scene.mechanism, s.sight.result.final_state),
             start = energy_of(s.scene.mechanism, s.sight.start);
  const double scale =
      std::max({l.scale(), end.kinetic, start.kinetic, std::abs(end.potential), std::abs(start.potential)});
  const double stated = std::max(std::abs(end.kinetic - l.kinetic), std::abs(end.potential - l.potential));
  if (!(stated <= 1e-9 * scale))
    return fmt::format("kinetic or potential energy: {:.2g} of {:.2g} J other than by the state", stated,
                       scale);
  const double left = end.kinetic + end.potential + l.elastic - start.kinetic - start.potential - l.drive -
                      l.load - l.stabilisation + l.contact + l.friction + l.damping + l.film;
  if (!(std::abs(left) <= bound * scale))
    return fmt::format("balance misses {:.2g} of {:.2g} J, above {:.0e}", left, scale, bound);
  return {};
}

/// For an impact only the sum of both directions is known: where rows are dependent, sticking may
/// return the energy that the normal impulse takes.
std::optional<std::string> losses(Subject& s) {
  const auto& l = s.sight.result.ledger;
  // A thousand steps at the tolerance.
  const double bound = (s.way.stepped ? 1e-3 : std::max(1e-6, 1e3 * s.tolerance())) * l.scale();
  for (const auto& [name, value] : {std::pair{"contacts with their friction", l.contact + l.friction},
                                    {"dampers", l.damping},
                                    {"films", l.film}})
    if (!(value >= -bound)) return fmt::format("{} give {:.2g} J, scale {:.2g} J", name, -value, l.scale());
  if (s.conservative() && !(std::abs(l.contact) <= bound))
    return fmt::format("elastic contacts lose {:.2g} J, scale {:.2g} J", l.contact, l.scale());
  return {};
}

std::optional<std::string> momentum(Subject& s) {
  if (!s.alone()) return {};
  const auto& m = s.scene.mechanism;
  struct Sum {
    double x = 0, y = 0, turn = 0, linear = 0, angular = 0, spin = 0;
  };
  const auto sum = [&](const State& at) {
    Sum p;
    for (std::size_t i = 0; i < m.bodies.size(); ++i) {
      const double *q = at.q.data() + 3 * i, *v = at.v.data() + 3 * i, mass = m.bodies[i].mass;
      const double spin = m.bodies[i].inertia * v[2], speed = std::hypot(v[0], v[1]);
      p.x += mass * v[0], p.y += mass * v[1];
      p.turn += mass * (q[0] * v[1] - q[1] * v[0]) + spin;
      p.linear += mass * speed;
      p.spin = std::max(p.spin, std::abs(v[2]));
      p.angular += mass * speed * std::hypot(q[0], q[1]) + std::abs(spin);
    }
    return p;
  };
  const auto a = sum(s.sight.start), b = sum(s.sight.result.final_state);
  // Friction of round contacts acts on surfaces a gap apart: a couple of the depth times its
  // impulse. The impulses of a step act in its middle, where the gap is up to h v, and the position
  // correction moves bodies by as much.
  double couple = 0;
  if (s.way.stepped)
    for (const auto& e : s.sight.result.events)
      couple += *s.scene.nonsmooth.step * std::abs(e.v_n_minus) *
                std::max({a.linear, b.linear, std::abs(e.impulse_t)});
  for (std::size_t k = 0; k < s.sight.depth.size(); ++k)
    for (const auto& e : s.sight.result.events) couple += 3 * s.sight.depth[k] * std::abs(e.impulse_t);
  // A contact that lasts to the end has no such event. It rotates its bodies' momentum, Σ m‖v‖ for
  // every radian that they turn, and friction has μ of that.
  for (std::size_t k = 0; k < s.sight.depth.size() && k < s.sight.contacts.size(); ++k) {
    const auto& events = s.sight.result.events;
    const auto last = std::find_if(events.rbegin(), events.rend(),
                                   [&](const auto& e) { return e.joint == s.sight.contacts[k]; });
    if (last == events.rend() || last->kind != EventKind::contact) continue;
    double mu = 0;
    for (const auto& surface : m.surfaces) mu = std::max(mu, surface.friction.value_or(0));
    couple += 3 * s.sight.depth[k] * mu * std::max(a.linear, b.linear) *
              (1 + std::max(a.spin, b.spin) * (s.sight.result.t_end - last->t));
  }
  const double linear = std::hypot(a.x - b.x, a.y - b.y), turn = std::abs(a.turn - b.turn);
  if (!(linear <= 1e-6 * std::max(a.linear, b.linear)))
    return fmt::format("momentum changes by {:.2g} of {:.2g} N s", linear, a.linear);
  if (!(turn <= 1e-6 * std::max(a.angular, b.angular) + couple))
    return fmt::format("angular momentum changes by {:.2g} of {:.2g} N m s", turn, a.angular);
  return {};
}

std::optional<std::string> depth(Subject& s) {
  const double bound = s.way.family == Family::penalty ? 0.1 : 1e-3;
  for (std::size_t k = 0; k < s.sight.depth.size(); ++k) {
    const double share = s.sight.depth[k] / s.sight.measure[k];
    if (!(share <= bound))
      return fmt::format("{} lies {:.2g} of its measure deep, above {}", s.sight.contacts[k], share, bound);
  }
  return {};
}

std::optional<std::string> newton(Subject& s) {
  if (!s.sight.newton || s.reduced()) return {};
  // Adaptive steps may be so short that their whole change is a rounding of velocities: only their
  // impulses are compared.
  const bool chosen = (s.way.means && !s.way.stepped) || s.sight.result.work.handovers > 0;
  if (!chosen && !(*s.sight.newton <= 1e-6))
    return fmt::format("residual {:.2g} of the greatest term", *s.sight.newton);
  const double bound = s.way.stepped ? 1e-9 : 1e-3;
  if (!(*s.sight.momentum <= bound))
    return fmt::format("momentum less impulses {:.2g} of the greatest", *s.sight.momentum);
  return {};
}

/// All reported times lie within the time of the run.
std::optional<std::string> times(Subject& s) {
  const auto& run = s.sight.result;
  const double end = run.t_end * (1 + 1e-12), step = s.way.stepped ? *s.scene.nonsmooth.step : 0;
  double before = 0, unsure = 0;
  for (const auto& e : run.events) {
    // The end of an accumulation of impacts may lie after the instant at which a run stops.
    if (!(e.t >= 0 && e.t - e.t_uncertainty <= end))
      return fmt::format("an event of {} at {:.6g} s, the run ends at {:.6g} s", e.joint, e.t, run.t_end);
    unsure = std::max(unsure, e.t_uncertainty);
    if (!(e.t >= before - step - unsure - 1e-12 * end))
      return fmt::format("an event of {} at {:.9g} s after one at {:.9g} s", e.joint, e.t, before);
    before = std::max(before, e.t);
  }
  for (const auto& c : run.contacts)
    for (const double share : {c.flight_fraction, c.impact_fraction, c.lasting_fraction})
      if (!(share >= -1e-3 - unsure / end && share <= 1 + 1e-3 + unsure / end))
        return fmt::format("{}: {:.3g} of the time", c.name, share);
  return {};
}

}  // namespace

std::span<const Check> conservation_checks() {
  static constexpr Check all[] = {
      {"energy balance", "kinetic and potential energy summed from the state, and the balance with them",
       "1e-4 of the greatest term; Moreau–Jean 1e-3",
       "event-driven's tolerance is 1e-7 where many contacts rest, over a thousand steps; "
       "penalty's work integrals are carried "
       "along without error control; the midpoint rule's h², and beyond 1e-3 the run says so",
       balance},
      {"losses",
       "what contacts with their friction, dampers and films took is not negative; "
       "nothing where e = 1 and µ = 0",
       "1e-6 of the greatest term; Moreau–Jean 1e-3",
       "the integrators' error; in time stepping the turning of normals within a step, h²", losses,
       "increased the energy"},
      {"momentum", "of mechanisms that nothing acts on from outside, linear and angular",
       "1e-6 of Σ m‖v‖; "
       "for the angular one also depth times friction's impulse (of a contact that lasts μ Σ m‖v‖ (1 + "
       "ω t)), Moreau–Jean h v_n Σ m‖v‖ an impact",
       "the integrators' error; friction acts on two surfaces that are a depth apart; "
       "a step's impulses act in its middle, "
       "where that is h v_n, and positions are brought back by as much",
       momentum},
      {"penetration", "four instants within each step on the dense output, ends of time steps",
       "1e-3 of the clearance, radius or arm; penalty 0.1",
       "beyond these the run gives a warning (docs/reference/results.md)", depth},
      {"Newton and Euler", "forces summed anew against accelerations, impulses against changes of momentum",
       "1e-6 of the greatest term, impulses 1e-3; Moreau–Jean's impulses 1e-9",
       "rounding of solves at mass ratios of 1e6, drift of joints; Gauss points over Hertz's kink; "
       "a step is its impulses",
       newton},
      {"times", "events in their order and within the run, shares of flight, impacts and lasting contact",
       "order to t_uncertainty, 0 to 1 to 1e-3",
       "a touch that ends an accumulation stands at its end, "
       "with the time that was not resolved as its uncertainty",
       times},
  };
  return all;
}

}  // namespace freeplay::verification::random_scenes
