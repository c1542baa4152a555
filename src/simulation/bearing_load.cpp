#include "simulation/bearing_load.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>

#include "mechanism/scene.hpp"
#include "numerics/bracketed_root.hpp"
#include "simulation/bearing_pressure.hpp"

namespace freeplay {
namespace {

using std::numbers::pi;

const RevoluteJoint* bearing_at(const Mechanism& m, std::size_t joint) {
  const auto* pin = std::get_if<RevoluteJoint>(&m.joints[joint]);
  return pin && pin->clearance ? pin : nullptr;
}

/// Angle of a body, or its rate.
double angle_of(std::span<const double> q, int body) { return body == ground ? 0 : q[3 * body + 2]; }

/// Mean force ∫ F² dt/∫ F dt (N) of an impact without loss; NaN without an approach speed (bearing_load.hpp).
double force_of_impact(const Foundation& f, double impulse, double approach, double rebound) {
  if (!(approach > 0 && approach + rebound > 0)) return NAN;
  const double mass = impulse / (approach + rebound);
  if (f.stiffness == 0) return pi / 4 * approach * std::sqrt(mass * pi / 2 * f.modulus * f.length);
  const double scale = f.stiffness * f.length * f.bearing_radius * f.clearance;  // N
  const double energy = 0.5 * mass * approach * approach / (scale * f.clearance);
  double high = 1e-9;
  while (RoundFoundation::energy(high) < energy) high *= 2;
  const double depth =
      bracketed_root([&](double d) { return RoundFoundation::energy(d) - energy; }, 0.0, high, {50, 100});
  const double force = RoundFoundation::force(depth), n = depth * force / energy - 1;
  return 0.5 * scale * force * std::beta((2 * n + 1) / (n + 1), 0.5);
}

}  // namespace

int degree_of(double angle) {
  const double turns = angle / (2 * pi);
  return std::min(static_cast<int>(360 * (turns - std::floor(turns))), 359);
}

double even_width(double length, double within) {
  const double width = std::sqrt(12 * (2 * std::max(0.0, 1 - length) + within));
  return width > 1e-6 ? width : 0;
}

/// An observed joint with its classes.
struct BearingLoadObserver::Bearing {
  /// Weighted sums of a class. The weight of the forces is smaller than that of the directions if forces of
  /// impulses are not known.
  struct Sums {
    double weight = 0, known = 0, force = 0;
    std::array<double, 4> directions{};  // cos and sin on the bearing and on the journal

    void add(double w, double f, double on_bearing, double on_journal) {
      weight += w;
      if (std::isfinite(f)) known += w, force += w * f;
      directions[0] += w * std::cos(on_bearing), directions[1] += w * std::sin(on_bearing);
      directions[2] += w * std::cos(on_journal), directions[3] += w * std::sin(on_journal);
    }
    template <class M>
    void serialize(M& m) {
      m(weight, known, force, directions);
    }
  };
  /// A class: sums weighted by F ds and by F dt.
  struct Class {
    Sums by_distance, by_time;
    double greatest = 0;
    template <class M>
    void serialize(M& m) {
      m(by_distance, by_time, greatest);
    }
  };

  std::string name;
  int joint;
  std::array<int, 2> bodies;
  std::array<Vec2, 2> at;
  Foundation foundation;
  bool merged;
  std::vector<std::size_t> contacts = {};  // indices into Layout::forces
  std::map<int, Class> classes = {};       // by the degrees on the bearing and on the journal
  double sliding = 0, work = 0;
  std::vector<double> works = {};  // at the ends of the turns

  /// The resultant normal force on the bearing, from forces or impulses.
  Vec2 normal(const Forces& forces) const {
    Vec2 sum{0, 0};
    for (const auto k : contacts) {
      const auto& f = forces.elements[k];
      if (!(f.fn > 0)) continue;
      // In complex numbers the force on the journal is n (−F_N + i F_T), the normal one on the bearing n F_N.
      const auto n = std::complex(f.fx, f.fy) / std::complex(-f.fn, f.ft) * f.fn;
      sum += Vec2{n.real(), n.imag()};
    }
    return sum;
  }
  /// Velocity of the journal's centre relative to the bearing's.
  Vec2 rate(std::span<const double> q, std::span<const double> v) const {
    Vec2 sum{0, 0};
    for (const int end : {0, 1}) {
      const int body = bodies[end];
      if (body == ground) continue;
      const double angle = q[3 * body + 2], c = std::cos(angle), s = std::sin(angle), w = v[3 * body + 2];
      const Vec2 arm{c * at[end].x() - s * at[end].y(), s * at[end].x() + c * at[end].y()};
      const Vec2 point = Vec2{v[3 * body], v[3 * body + 1]} + w * perp(arm);
      sum += (end == 0 ? -1.0 : 1.0) * point;
    }
    return sum;
  }
  /// v_T in the direction n.
  double slip(const Vec2& n, std::span<const double> q, std::span<const double> v) const {
    return dot(perp(n), rate(q, v)) + foundation.journal_radius() * angle_of(v, bodies[1]) -
           foundation.bearing_radius * angle_of(v, bodies[0]);
  }
  /// Adds an impulse F dt of the direction n at a sliding speed; `force`: F, which may be unknown.
  void add(double impulse, double speed, double force, double greatest, const Vec2& n,
           std::span<const double> q) {
    const double angle = std::atan2(n.y(), n.x());
    const double on_bearing = angle - angle_of(q, bodies[0]), on_journal = angle - angle_of(q, bodies[1]);
    auto& one = classes[360 * degree_of(on_bearing) + (merged ? 0 : degree_of(on_journal))];
    one.by_distance.add(impulse * speed, force, on_bearing, on_journal);
    one.by_time.add(impulse, force, on_bearing, on_journal);
    if (greatest > one.greatest) one.greatest = greatest;
    work += impulse * speed;
  }
  template <class M>
  void serialize(M& m) {
    std::uint64_t size = classes.size();
    m(sliding, work, works, size);
    if constexpr (M::reading) {
      classes.clear();
      for (std::uint64_t i = 0; i < size; ++i) {
        int key = 0;
        Class one;
        m(key, one);
        classes.emplace(key, one);
      }
    } else {
      for (auto& [key, one] : classes) {
        int copy = key;
        m(copy, one);
      }
    }
  }
};

BearingLoadObserver::~BearingLoadObserver() = default;

std::vector<std::size_t> observed_bearings(const Scene& scene) {
  const auto& m = scene.mechanism;
  std::vector<std::size_t> list;
  for (std::size_t k = 0; k < m.joints.size(); ++k) {
    const auto* pin = bearing_at(m, k);
    if (!pin || pin->clearance->lubricant >= 0) continue;
    const auto& c = *pin->clearance;
    const bool layered = scene.penalty.contact == ContactLaw::elastic_foundation && c.bearing_length &&
                         m.surfaces[static_cast<std::size_t>(c.surface)].layer_modulus;
    if (c.wears() || layered) list.push_back(k);
  }
  return list;
}

bool BearingLoadObserver::needed(const Scene& scene) { return !observed_bearings(scene).empty(); }

BearingLoadObserver::BearingLoadObserver(const Scene& scene) : discard_(scene.run.discard) {
  for (const auto k : observed_bearings(scene)) {
    const auto& pin = *bearing_at(scene.mechanism, k);
    bearings_.push_back({.name = pin.name,
                         .joint = static_cast<int>(k),
                         .bodies = pin.between,
                         .at = pin.at,
                         .foundation = foundation_of(scene.mechanism, pin),
                         .merged = !pin.clearance->journal_wear && pin.clearance->journal_profile < 0});
  }
}

void BearingLoadObserver::begin(const Layout& layout, const State& state) {
  for (auto& b : bearings_) {
    b.contacts.clear();
    for (std::size_t k = 0; k < layout.forces.size(); ++k)
      if (const auto& e = layout.forces[k]; e.kind == ForceElement::Kind::contact && e.joint == b.joint)
        b.contacts.push_back(k);
  }
  turn_ = layout.crank_speed != 0 ? 2 * pi / std::abs(layout.crank_speed) : 0;
  before_ = after_ = v_ = state.v;
  q_ = state.q;
}

void BearingLoadObserver::step(const Step& step) {
  const auto pressed = [&](const Forces& impulses) {
    return std::ranges::any_of(bearings_, [&](const Bearing& b) { return !b.normal(impulses).is_zero(); });
  };
  if (step.t0 >= discard_ && pressed(step.before())) {
    step.state(step.t0, q_, v_);
    add_impacts(step.before(), before_, step.v0);
  }
  // Parts that end at the ends of the turns.
  for (double a = std::max(step.t0, discard_); a < step.t1;) {
    const double next = turn_ > 0 ? discard_ + turn_ * static_cast<double>(turns_ + 1) : INFINITY;
    const bool ends = next <= step.t1 + 1e-9 * turn_;
    const double b = ends ? std::clamp(next, a, step.t1) : step.t1;
    if (b > a) observe(step, a, b);
    if (ends) {
      ++turns_;
      for (auto& bearing : bearings_) bearing.works.push_back(bearing.work);
    }
    a = b;
  }
  if (const auto impacts = step.in_impact(); !impacts.v.empty() && impacts.t >= discard_) {
    // The rest of the change of the velocities is even over the step.
    const double share = step.t1 > step.t0 ? (impacts.t - step.t0) / (step.t1 - step.t0) : 1;
    step.state(impacts.t, q_, v_);
    for (std::size_t i = 0; i < after_.size(); ++i) {
      before_[i] = step.v0[i] + share * (step.v1[i] - step.v0[i] - impacts.v[i]);
      after_[i] = before_[i] + impacts.v[i];
    }
    add_impacts(step.within(), before_, after_);
  }
  std::ranges::copy(step.v1, before_.begin());
}

/// Adds the forces from a to b, in parts.
void BearingLoadObserver::observe(const Step& step, double a, double b) {
  constexpr double most_turn = pi / 720, most_parts = 4096;
  double fastest = 0;
  for (const auto& bearing : bearings_)
    for (const int body : bearing.bodies)
      fastest = std::max({fastest, std::abs(angle_of(step.v0, body)), std::abs(angle_of(step.v1, body))});
  const double parts = std::clamp(std::ceil(fastest * (b - a) / most_turn), 1.0, most_parts);
  for (double k = 0; k < parts; ++k)
    observe_part(step, a + k / parts * (b - a), a + (k + 1) / parts * (b - a));
  time_ += b - a;
}

void BearingLoadObserver::observe_part(const Step& step, double a, double b) {
  constexpr double root = 0.7745966692414834;  // √(3/5)
  constexpr std::array nodes{0.5 - 0.5 * root, 0.5, 0.5 + 0.5 * root}, weights{5.0 / 18, 8.0 / 18, 5.0 / 18};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double t = a + nodes[i] * (b - a), dt = weights[i] * (b - a);
    step.state(t, q_, v_);
    step.forces(t, forces_);
    for (auto& bearing : bearings_) {
      const Vec2 normal = bearing.normal(forces_);
      const double force = normal.norm();
      if (!(force > 0)) continue;
      const Vec2 n = (1 / force) * normal;
      const double speed = std::abs(bearing.slip(n, q_, v_));
      bearing.add(force * dt, speed, force, force, n, q_);
      bearing.sliding += speed * dt;
    }
  }
}

/// Adds impacts at the positions q_.
void BearingLoadObserver::add_impacts(const Forces& impulses, std::span<const double> before,
                                      std::span<const double> after) {
  for (auto& bearing : bearings_) {
    const Vec2 normal = bearing.normal(impulses);
    const double impulse = normal.norm();
    if (!(impulse > 0)) continue;
    const Vec2 n = (1 / impulse) * normal;
    const double speed = 0.5 * (std::abs(bearing.slip(n, q_, before)) + std::abs(bearing.slip(n, q_, after)));
    const double force = force_of_impact(bearing.foundation, impulse, dot(n, bearing.rate(q_, before)),
                                         -dot(n, bearing.rate(q_, after)));
    bearing.add(impulse, speed, force, force, n, q_);
  }
}

std::vector<BearingLoads> BearingLoadObserver::loads() const {
  std::vector<BearingLoads> list;
  for (const auto& b : bearings_) {
    auto& out = list.emplace_back();
    out.joint = b.name;
    out.time = time_;
    out.sliding = b.sliding;
    out.merged = b.merged;
    for (std::size_t k = 0; k < b.works.size(); ++k)
      out.work_of_turns.push_back(b.works[k] - (k > 0 ? b.works[k - 1] : 0));
    double known = 0, force = 0;  // of all classes, for those of unknown forces
    for (const auto& [key, one] : b.classes) known += one.by_time.known, force += one.by_time.force;
    for (const auto& [key, one] : b.classes) {
      const auto& s = one.by_distance.weight > 0 ? one.by_distance : one.by_time;
      BearingLoad load;
      const auto& d = s.directions;
      load.on_bearing = std::atan2(d[1], d[0]);
      load.on_journal = std::atan2(d[3], d[2]);
      load.width_on_bearing = even_width(std::hypot(d[0], d[1]) / s.weight);
      load.width_on_journal = b.merged ? 0 : even_width(std::hypot(d[2], d[3]) / s.weight);
      load.force = s.known > 0 ? s.force / s.known : known > 0 ? force / known : one.by_time.weight / time_;
      load.work = one.by_distance.weight;
      load.impulse = one.by_time.weight;
      load.greatest = std::max(one.greatest, load.force);
      out.loads.push_back(load);
    }
  }
  return list;
}

template <class M>
void BearingLoadObserver::serialize(M& m) {
  m(time_, turns_);
  for (auto& b : bearings_) b.serialize(m);
}
template void BearingLoadObserver::serialize(MemoryWriter&);
template void BearingLoadObserver::serialize(MemoryReader&);

}  // namespace freeplay
