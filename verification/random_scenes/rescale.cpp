#include "verification/random_scenes/curve_scaling.hpp"
#include "verification/random_scenes/transform.hpp"

namespace freeplay::verification::random_scenes {
namespace {

void stretch(SpringTable& table, double along, double force) {
  for (auto& [at, value] : table) at *= along, value *= force;
}
/// A law over a coordinate that is measured in `unit`.
void rescale(SpringLaw& law, double unit, double force, double time) {
  if (law.cubic) *law.cubic *= force / (unit * unit * unit);
  if (law.preload) *law.preload *= force;
  stretch(law.table, unit, force), stretch(law.damping_table, unit / time, force);
}

}  // namespace

Scene rescaled(Scene scene, const Units& u) {
  const double L = u.length, M = u.mass, T = u.time, force = M * L / (T * T), torque = force * L;
  auto& m = scene.mechanism;
  const auto ends = [&](std::array<Vec2, 2>& at) {
    for (auto& p : at) p = L * p;
  };
  const auto maybe = [](std::optional<double>& x, double factor) {
    if (x) *x *= factor;
  };
  const auto scale_law = [&](ControlLaw& d, double stiffness) {
    d.proportional *= stiffness;
    d.derivative *= stiffness * T;
    d.integral *= stiffness / T;
    maybe(d.lag, T), maybe(d.tracking_time, T), maybe(d.sampling_time, T);
    d.dead_time *= T;
  };
  const auto backlash = [&](std::optional<Backlash>& b) {
    if (b) b->normal *= L, maybe(b->stiffness, force / L);
  };
  const auto ratio = [&](JointRatio& r) {
    if (r.slider(m)) r.ratio *= L, r.offset *= L;
  };
  const auto stop = [&](StopFacts& s) { maybe(s.stiffness, force / L), maybe(s.curvature_radius, L); };
  m.gravity = (L / (T * T)) * m.gravity;
  for (auto& b : m.bodies) {
    b.mass *= M;
    b.inertia *= M * L * L;
    if (b.position) b.position = L * *b.position;
    if (b.velocity) b.velocity = (L / T) * *b.velocity;
    if (b.angular_velocity) *b.angular_velocity /= T;
  }
  for (auto& joint : m.joints)
    std::visit(Overloaded{[&](RevoluteJoint& j) {
                            ends(j.at);
                            if (!j.clearance) return;
                            j.clearance->radial *= L;
                            j.clearance->bearing_radius *= L;
                            maybe(j.clearance->bearing_length, L);
                            maybe(j.clearance->bearing_wear, L * L / force);
                            maybe(j.clearance->journal_wear, L * L / force);
                          },
                          [&](RigidJoint& j) { ends(j.at); },
                          [&](TranslationalJoint& j) {
                            ends(j.at);
                            if (!j.clearance) return;
                            j.clearance->half_play *= L;
                            j.clearance->length *= L;
                            j.clearance->height *= L;
                            maybe(j.clearance->corner_radius, L);
                          },
                          [&](GearJoint& j) {
                            ends(j.at), maybe(j.tooth_module, L);
                            if (j.pitch_radii) *j.pitch_radii = L * *j.pitch_radii;
                            backlash(j.clearance), maybe(j.loss.regularisation, 1 / T);
                          },
                          [&](RackJoint& j) {
                            ends(j.at), maybe(j.tooth_module, L), j.pitch_radius *= L;
                            backlash(j.clearance), maybe(j.loss.regularisation, 1 / T);
                          },
                          [&](SlotJoint& j) {
                            ends(j.at);
                            if (!j.clearance) return;
                            j.clearance->half_play *= L;
                            j.clearance->pin_radius *= L;
                          },
                          [&](RodJoint& j) { ends(j.at), j.length *= L; },
                          [&](RatioJoint& j) {
                            ratio(j);
                            if (!j.clearance) return;
                            (j.slider(m) ? j.clearance->play : j.clearance->radius) *= L;
                            maybe(j.clearance->stiffness, force / L);
                          }},
               joint);
  for (auto& contact : m.contacts)
    std::visit(Overloaded{[&](PlaneContact& c) { ends(c.at), c.radius *= L, maybe(c.stiffness, force / L); },
                          [&](DiscContact& c) {
                            ends(c.at);
                            for (auto& R : c.radii) R *= L;
                          },
                          [&](CamContact& c) {
                            ends(c.at);
                            c.roller_radius *= L, c.base_radius *= L, c.lift *= L;
                            stretch(c.table, 1, L);
                          },
                          [&](OutlineContact& c) {
                            ends(c.at), maybe(c.stiffness, force / L);
                            for (auto& p : c.points) p = L * p;
                            c.radius *= L, c.corner_radius *= L;
                          },
                          [&](TravelStop& c) {
                            stop(c.stop);
                            maybe(c.stop.lower, L), maybe(c.stop.upper, L);
                          },
                          [&](AngleStop& c) { stop(c.stop), c.radius = c.arm() * L; }},
               contact);
  for (auto& s : m.surfaces) {
    maybe(s.young, force / (L * L)), maybe(s.layer_modulus, force / (L * L));
    maybe(s.layer_thickness, L), maybe(s.peak.stribeck_speed, L / T);
  }
  for (auto& l : m.lubricants) l.viscosity *= force * T / (L * L), maybe(l.hand_over, L);
  for (auto& p : m.profiles) {
    for (auto& row : p.harmonics) row[1] *= L, row[2] *= L;
    for (auto& [angle, deviation] : p.points) deviation *= L;
  }
  for (auto& drive : m.drives)
    std::visit(Overloaded{[&](SpeedDrive& d) { d.speed /= T; },
                          [&](TorqueDrive& d) {
                            for (auto& [at, value] : d.table) {
                              value *= torque;
                              if (d.against == TorqueDrive::Against::time) at *= T;
                            }
                            maybe(d.lag, T);
                          },
                          [&](MotionDrive& d) {
                            if (d.velocity < 0) throw std::logic_error("positions are not transformed");
                            d.velocity = scaled_curve(m, d.velocity, T, d.slides(m) ? L / T : 1 / T);
                            if (d.slides(m)) d.initial *= L;
                          },
                          [&](TorqueCurveDrive& d) {
                            need_time(d.against);
                            d.curve = scaled_curve(m, d.curve, T, torque);
                          },
                          [&](ForceDrive& d) {
                            need_time(d.against);
                            scale(m, d.force, T, force);
                          },
                          [&](DcMotor& d) {  // amperes stay
                            scale(m, d.voltage, T, torque / T);
                            d.resistance *= torque / T;
                            d.torque_constant *= torque;
                            maybe(d.emf_constant, torque);
                            maybe(d.inductance, torque);
                          },
                          [&](InductionMotor& d) { d.breakdown_torque *= torque, d.synchronous_speed /= T; },
                          [&](Governor& d) {
                            scale(m, d.target, T, 1 / T);
                            d.proportional *= torque * T;
                            d.integral *= torque;
                            maybe(d.limit, torque);
                          },
                          [&](AngleController& d) {
                            scale(m, d.target, T, 1);
                            scale_law(d, torque);
                            maybe(d.limit, torque);
                          },
                          [&](PositionController& d) {
                            scale(m, d.target, T, L);
                            scale_law(d, force / L);
                            maybe(d.limit, force), maybe(d.resolution, L);
                          }},
               drive);
  for (auto& load : m.loads)
    std::visit(
        Overloaded{[&](ForceLoad& l) {
                     l.at = L * l.at, l.force = force * l.force;
                     if (l.factor >= 0) need_time(l.against), l.factor = scaled_curve(m, l.factor, T, 1);
                   },
                   [&](TorqueLoad& l) {
                     l.torque *= torque;
                     if (l.factor >= 0) need_time(l.against), l.factor = scaled_curve(m, l.factor, T, 1);
                   },
                   [&](SpringDamper& l) {
                     ends(l.at);
                     l.stiffness *= force / L;
                     l.damping *= force / L * T;
                     l.free_length *= L;
                     rescale(l.law, L, force, T);
                   },
                   [&](TorsionalSpringDamper& l) {
                     l.stiffness *= torque, l.damping *= torque * T;
                     rescale(l.law, 1, torque, T);
                   },
                   [&](Bushing& l) {
                     ends(l.at);
                     l.stiffness = (force / L) * l.stiffness, l.damping = (force / L * T) * l.damping;
                     l.turn_stiffness *= torque, l.turn_damping *= torque * T;
                     rescale(l.radial, L, force, T);
                   },
                   [&](JointFriction& l) {
                     maybe(l.force, force), maybe(l.torque, torque);
                     maybe(l.regularisation, (l.torque ? 1 : L) / T);
                     if (l.peak) {
                       l.peak->bound *= l.torque ? torque : force;
                       l.peak->stribeck_speed *= (l.torque ? 1 : L) / T;
                     }
                     if (!l.reaction) return;
                     l.reaction->pin_radius *= L;
                     maybe(l.reaction->slider_length, L), maybe(l.reaction->peak.stribeck_speed, L / T);
                   },
                   [&](Freewheel& l) { l.torque_limit *= torque, maybe(l.regularisation, 1 / T); },
                   [&](BumpStop& l) {
                     ends(l.at), maybe(l.bump.lower, L), maybe(l.bump.upper, L);
                     l.bump.stiffness *= force / L, l.bump.damping *= force / L * T;
                   },
                   [&](TorsionalBumpStop& l) { l.bump.stiffness *= torque, l.bump.damping *= torque * T; },
                   [&](ElasticRatio& l) {
                     ratio(l);
                     const double rate = l.slider(m) ? force / L : torque;
                     l.stiffness *= rate, l.damping *= rate * T;
                   },
                   [&](BeamElement& l) {
                     ends(l.at);
                     l.length *= L, l.curvature /= L, l.damping *= T;
                     l.axial *= force, l.shear *= force, l.bending *= torque * L;
                   }},
        load);
  scene.run.duration *= T;
  scene.run.discard *= T;
  if (scene.nonsmooth.step) *scene.nonsmooth.step *= T;
  auto& p = scene.penalty;
  p.step *= T;
  p.friction_v0 *= L / T;
  p.friction_v1 *= L / T;
  p.alpha /= T;
  p.beta /= T;
  maybe(p.v0_floor, L / T);
  return scene;
}

}  // namespace freeplay::verification::random_scenes
