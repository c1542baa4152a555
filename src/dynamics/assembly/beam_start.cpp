#include "dynamics/assembly/beam_start.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "dynamics/beam_reduction.hpp"
#include "dynamics/planar.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

/// An end of a beam: place and tangent, and their rates.
struct BeamEnd {
  Vec2 place, tangent, velocity{0, 0}, turning{0, 0};
  double angle = 0;  // rad, of the tangent, full turns included
  double rate = 0;   // rad/s
};

BeamEnd end_of(const Beam& beam, std::size_t k, const State& s) {
  const int body = beam.between[k];
  BeamEnd end;
  const double own = k == 0 ? beam.angles.x() : beam.angles.y();
  end.angle = own + (body == ground ? 0 : planar::angle(s.q.data(), body));
  end.tangent = {std::cos(end.angle), std::sin(end.angle)};
  end.place = beam.at[k];
  if (body == ground) return end;
  const double turn = end.angle - own, c = std::cos(turn), sn = std::sin(turn);
  const Vec2 arm{c * end.place.x() - sn * end.place.y(), sn * end.place.x() + c * end.place.y()};
  end.place = planar::position(s.q.data(), body) + arm;
  end.rate = planar::rate(s.v.data(), body);
  end.velocity = planar::velocity(s.v.data(), body) + end.rate * perp(arm);
  end.turning = end.rate * perp(end.tangent);
  return end;
}

/// From the beginning to the end of an arc that begins in the direction `angle`. A negative length goes back.
Vec2 arc(double length, double curvature, double angle) {
  const double half = 0.5 * curvature * length, chord = length * (half == 0 ? 1 : std::sin(half) / half);
  return {chord * std::cos(angle + half), chord * std::sin(angle + half)};
}

/// Weights of place and tangent at both ends in the place of the curve at the share x of the length, and in its
/// slope.
struct Cubic {
  explicit Cubic(double x)
      : place{1 - x * x * (3 - 2 * x), x * (1 - x) * (1 - x), x * x * (3 - 2 * x), -x * x * (1 - x)},
        slope{-6 * x * (1 - x), (1 - x) * (1 - 3 * x), 6 * x * (1 - x), x * (3 * x - 2)} {}
  std::array<double, 4> place, slope;
  static Vec2 sum(const std::array<double, 4>& w, const Vec2& a, const Vec2& b, const Vec2& c,
                  const Vec2& d) {
    return w[0] * a + w[1] * b + w[2] * c + w[3] * d;
  }
};

/// Calls f for the pieces of a beam with a free end: the unloaded arc, which moves with the body at end k.
template <class F>
void each_piece_of_arc(const Beam& beam, std::size_t k, const State& s, F f) {
  const auto from = end_of(beam, k, s);
  for (int n = 0; n < beam.elements; ++n) {
    const double along = beam.length * ((n + 0.5) / beam.elements - static_cast<double>(k)),
                 angle = from.angle + beam.curvature * along;
    const Vec2 arm = arc(along, beam.curvature, from.angle), slope{std::cos(angle), std::sin(angle)};
    f(beam.first + n, Vec2(from.place + arm), slope, Vec2(from.velocity + from.rate * perp(arm)),
      Vec2(from.rate * perp(slope)), from);
  }
}

/// Calls f for the pieces of a reduced beam: its static deflection, without modes.
template <class F>
void each_piece_of_reduced(const Beam& beam, const State& s, F f) {
  const BeamReduction reduced(beam);
  const auto a = end_of(beam, 0, s), b = end_of(beam, 1, s);
  const Vec2 d = b.place - a.place, u = b.velocity - a.velocity;
  const double length = d.norm();
  const Vec2 along = d / length, left = perp(along);
  const double stretch = dot(along, u), spin = dot(left, u) / length;
  const auto over_chord = [&](const Vec2& t) { return std::atan2(cross(along, t), dot(along, t)); };
  const Eigen::Vector2d phi{over_chord(a.tangent), over_chord(b.tangent)}, rate{a.rate - spin, b.rate - spin};
  for (int n = 0; n < beam.elements; ++n) {
    const double share = (n + 0.5) / beam.elements, x = share * length, y = reduced.deflection.row(n) * phi,
                 angle = reduced.rotation.row(n) * phi, rises = reduced.deflection.row(n) * rate,
                 turns = reduced.rotation.row(n) * rate;
    const Vec2 slope = std::cos(angle) * along + std::sin(angle) * left;
    f(beam.first + n, Vec2(a.place + x * along + y * left), slope,
      Vec2(a.velocity + (share * stretch - spin * y) * along + (rises + spin * x) * left),
      Vec2((spin + turns) * perp(slope)), a);
  }
}

/// Calls f(body, place, slope, velocity, rate of the slope, an end that is not free) for each piece.
template <class F>
void each_piece(const Mechanism& mechanism, const State& s, F f) {
  for (const auto& beam : mechanism.beams) {
    if (beam.is_free(0) || beam.is_free(1)) {
      each_piece_of_arc(beam, beam.is_free(0) ? 1 : 0, s, f);
      continue;
    }
    if (beam.is_reduced()) {
      each_piece_of_reduced(beam, s, f);
      continue;
    }
    const auto a = end_of(beam, 0, s), b = end_of(beam, 1, s);
    for (int n = 0; n < beam.elements; ++n) {
      const Cubic cubic((n + 0.5) / beam.elements);
      const auto at = [&](const std::array<double, 4>& w) {
        return Cubic::sum(w, a.place, beam.length * a.tangent, b.place, beam.length * b.tangent);
      };
      const auto moves = [&](const std::array<double, 4>& w) {
        return Cubic::sum(w, a.velocity, beam.length * a.turning, b.velocity, beam.length * b.turning);
      };
      f(beam.first + n, at(cubic.place), at(cubic.slope), moves(cubic.place), moves(cubic.slope), a);
    }
  }
}

}  // namespace

Mechanism with_rigid_beams(Mechanism mechanism) {
  for (const auto& beam : mechanism.beams) {
    if (beam.is_free(0) || beam.is_free(1)) continue;
    RigidJoint joint;
    joint.name = beam.name;
    joint.between = beam.between;
    joint.at = {beam.at[0] + arc(beam.length, beam.curvature, beam.angles.x()), beam.at[1]};
    joint.angle = beam.angles.x() + beam.curvature * beam.length - beam.angles.y();
    mechanism.joints.emplace_back(std::move(joint));
  }
  mechanism.beams.clear();
  return mechanism;
}

void place_beams(const Mechanism& mechanism, State& s) {
  each_piece(mechanism, s,
             [&](int body, const Vec2& place, const Vec2& slope, auto, auto, const BeamEnd& from) {
               const auto& facts = mechanism.bodies[static_cast<std::size_t>(body)];
               double* q = s.q.data() + planar::coordinates * body;
               if (!facts.position) q[0] = place.x(), q[1] = place.y();
               if (!facts.angle)
                 q[2] = from.angle + std::atan2(cross(from.tangent, slope), dot(from.tangent, slope));
             });
}

void move_beams(const Mechanism& mechanism, State& s) {
  each_piece(mechanism, s,
             [&](int body, auto, const Vec2& slope, const Vec2& velocity, const Vec2& turning, auto) {
               const auto& facts = mechanism.bodies[static_cast<std::size_t>(body)];
               double* v = s.v.data() + planar::coordinates * body;
               if (!facts.velocity) v[0] = velocity.x(), v[1] = velocity.y();
               if (!facts.angular_velocity) v[2] = cross(slope, turning) / dot(slope, slope);
             });
}

}  // namespace freeplay
