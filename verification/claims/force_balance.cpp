#include "verification/claims/force_balance.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "verification/claims/claim.hpp"
#include "verification/references/planar.hpp"

namespace freeplay::verification {
namespace {

using Point = reference::Planar<double>;

Point centre_of(std::span<const double> q, int body) {
  return body == ground ? Point{} : Point{q[3 * body], q[3 * body + 1]};
}

Point point_of(std::span<const double> q, int body, const Vec2& at) {
  if (body == ground) return {at.x(), at.y()};
  const auto e = reference::direction(q[3 * body + 2]);
  return centre_of(q, body) + at.x() * e + at.y() * reference::quarter_turn(e);
}

/// The corner `name` of a slider with clearance, in the frame of its body.
Vec2 corner(const TranslationalJoint& joint, const std::string& name) {
  const double x = (name.find("front") != name.npos ? 0.5 : -0.5) * joint.clearance->length;
  const double y = (name.find("upper") != name.npos ? 0.5 : -0.5) * joint.clearance->height;
  const double turn = std::atan2(joint.axis.y(), joint.axis.x()) - joint.angle;
  return joint.at[1] + Vec2{x * std::cos(turn) - y * std::sin(turn), x * std::sin(turn) + y * std::cos(turn)};
}

}  // namespace

void Balance::take(const Balance& b) {
  own = greatest(own, b.own);
  anew = greatest(anew, b.anew);
}

ForceBalance::ForceBalance(const Mechanism& mechanism, const Layout& layout)
    : mechanism_(mechanism),
      elements_(layout.forces),
      at_(layout.forces.size()),
      overlap_(layout.forces.size()) {
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    const auto& e = elements_[i];
    if (e.joint >= 0) {
      const auto& joint = mechanism.joints[e.joint];
      std::visit([&](const auto& j) { at_[i] = j.at[1]; }, joint);
      if (e.kind != ForceElement::Kind::contact) continue;
      if (const auto* slider = std::get_if<TranslationalJoint>(&joint)) at_[i] = corner(*slider, e.name);
      if (const auto* pin = std::get_if<RevoluteJoint>(&joint))
        overlap_[i] = pin->clearance->lubricant < 0 ? 1 : 0;
    }
    for (const auto& contact : mechanism.contacts)
      std::visit(
          [&](const auto& c) {
            constexpr bool stop = requires { c.stop; };
            if (c.name != e.name && !(stop && e.name.starts_with(c.name + "."))) return;
            if constexpr (requires { c.at; })
              at_[i] = c.at[1];
            else  // a stop on a joint
              at_[i] = std::visit([](const auto& j) { return j.at[1]; }, mechanism.joints[c.joint]);
            if constexpr (std::is_same_v<std::decay_t<decltype(c)>, DiscContact>) overlap_[i] = -1;
          },
          contact);
    for (const auto& load : mechanism.loads) {
      if (const auto* l = std::get_if<ForceLoad>(&load); l && l->name == e.name) at_[i] = l->at;
      if (const auto* l = std::get_if<SpringDamper>(&load); l && l->name == e.name) at_[i] = l->at[1];
      if (const auto* l = std::get_if<BumpStop>(&load); l && l->name == e.name) at_[i] = l->at[1];
      if (const auto* l = std::get_if<BeamElement>(&load)) {
        arm_ = std::max(arm_, l->length);
        couple_ = std::max(couple_, 1e-16 * l->axial * l->length);
      }
    }
  }
}

double ForceBalance::worst(const std::vector<Sum>& sums, std::span<const double> a, const Over& over) const {
  double most = 0;
  const auto share = [&](double left, double scale, double inertia, std::size_t coordinate) {
    double rounding = over.v.empty() ? 0 : 4e-16 * inertia * std::abs(over.v[coordinate]);
    if (coordinate % 3 == 2) rounding += couple_ * over.seconds;
    if (!(std::abs(left) <= rounding)) most = greatest(most, std::abs(left) / scale);
  };
  for (std::size_t b = 0; b < sums.size(); ++b) {
    const auto& body = mechanism_.bodies[b];
    const auto& s = sums[b];
    const double x = body.mass * a[3 * b], y = body.mass * a[3 * b + 1], turn = body.inertia * a[3 * b + 2];
    const double gx = body.mass * over.seconds * mechanism_.gravity.x(),
                 gy = body.mass * over.seconds * mechanism_.gravity.y();
    const double force = std::max({s.force, std::hypot(x, y), std::hypot(gx, gy)});
    share(x - gx - s.fx, force, body.mass, 3 * b);
    share(y - gy - s.fy, force, body.mass, 3 * b + 1);
    share(turn - s.m, std::max(s.moment, std::abs(turn)), body.inertia, 3 * b + 2);
  }
  return most;
}

std::vector<ForceBalance::Sum> ForceBalance::own(std::span<const ElementForce> elements) const {
  std::vector<Sum> sums(mechanism_.bodies.size());
  for (std::size_t i = 0; i < elements.size(); ++i)
    for (const int side : {0, 1}) {
      const auto& f = elements[i];
      const int body = elements_[i].bodies[side];
      if (body == ground) continue;
      auto& s = sums[body];
      const double sign = side ? 1 : -1, m = side ? f.m_second : f.m_first;
      s.fx += sign * f.fx;
      s.fy += sign * f.fy;
      s.m += m;
      s.force = std::max(s.force, std::hypot(f.fx, f.fy));
      s.moment = std::max({s.moment, std::abs(m), 1e-10 * arm_ * std::hypot(f.fx, f.fy)});
    }
  return sums;
}

double ForceBalance::residual_anew(std::span<const double> q, std::span<const ElementForce> elements,
                                   std::span<const double> acceleration, std::span<const ContactPlace> gaps,
                                   const Over& over) const {
  std::vector<Sum> sums(mechanism_.bodies.size());
  std::size_t contact = 0;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const auto& f = elements[i];
    const auto& e = elements_[i];
    const Point force{f.fx, f.fy}, at = point_of(q, e.bodies[1], at_[i]);
    // Equal and opposite friction acts on both surfaces, which are a gap apart. `lost` is the
    // resulting difference of the moment on the first body.
    double lost = 0;
    if (e.kind == ForceElement::Kind::contact) lost = overlap_[i] * f.ft * gaps[contact++].gap;
    for (const int side : {0, 1}) {
      const int body = e.bodies[side];
      if (body == ground) continue;
      auto& s = sums[body];
      const Point arm = at - centre_of(q, body);
      const double sign = side ? 1 : -1, m = f.m + cross(arm, force) + (side ? 0 : lost);
      s.fx += sign * f.fx;
      s.fy += sign * f.fy;
      s.m += sign * m;
      s.force = std::max(s.force, std::hypot(f.fx, f.fy));
      s.moment = std::max({s.moment, std::abs(f.m), std::hypot(arm.x, arm.y) * std::hypot(f.fx, f.fy)});
    }
  }
  return worst(sums, acceleration, over);
}

Balance ForceBalance::residual(std::span<const double> q, const Forces& forces,
                               std::span<const ContactPlace> gaps, const Over& over) const {
  return {worst(own(forces.elements), forces.acceleration, over),
          residual_anew(q, forces.elements, forces.acceleration, gaps, over)};
}

std::vector<double> ForceBalance::momentum_left(const Forces& impulses, std::span<const double> change,
                                                double seconds) const {
  std::vector<double> left;
  const auto sums = own(impulses.elements);
  for (std::size_t b = 0; b < sums.size(); ++b) {
    const auto& body = mechanism_.bodies[b];
    left.push_back(body.mass * (change[3 * b] - seconds * mechanism_.gravity.x()) - sums[b].fx);
    left.push_back(body.mass * (change[3 * b + 1] - seconds * mechanism_.gravity.y()) - sums[b].fy);
    left.push_back(body.inertia * change[3 * b + 2] - sums[b].m);
  }
  return left;
}

void BalanceWatch::begin(const Layout& layout, const State& state) {
  balance_ = std::make_unique<ForceBalance>(mechanism_, layout);
  q_ = v_ = state.q;
  v_last_ = state.v;
  left_.assign(v_.size(), 0);
  scale_.assign(v_.size(), 0);
  gaps_.resize(layout.contacts.size());
  sum_.elements.resize(layout.forces.size());
  sum_.acceleration.resize(v_.size());
  piece_ = total = sum_;
  since_ = state.t;
  grid_.begin(state.t, interval_, layout.end, layout.duration);
}

void BalanceWatch::add(const Forces& impulses) {
  sum_.add(1, impulses);
  total.add(1, impulses);
  for (std::size_t i = 0; i < impulses.elements.size(); ++i)
    for (const int side : {0, 1}) {
      const int body = balance_->elements()[i].bodies[side];
      if (body == ground) continue;
      const auto& f = impulses.elements[i];
      double* scale = scale_.data() + 3 * body;
      scale[0] = scale[1] = std::max(scale[0], std::hypot(f.fx, f.fy));
      scale[2] = std::max(scale[2], std::abs(side ? f.m_second : f.m_first));
    }
}

void BalanceWatch::step(const Step& step) {
  const double h = step.t1 - step.t0;
  add(step.before());
  const bool look = steps_++ % every_ == 0;
  if (whole_) {
    piece_.clear();
    step.add_impulse(step.t0, step.t1, piece_);
    piece_.add(1, step.within());
    step.state(step.t0, q_, v_);
    for (std::size_t i = 0; i < q_.size(); ++i) {
      piece_.acceleration[i] = step.v1[i] - step.v0[i];
      q_[i] += 0.5 * h * step.v0[i];
    }
    step.contacts(0.5 * (step.t0 + step.t1), q_, gaps_);
    if (look) worst.take(balance_->residual(q_, piece_, gaps_, {h, step.v1})), ++checked;
  } else if (look) {
    for (const double share : {0.0, 0.37, 1.0}) {
      const double t = share < 1 ? step.t0 + share * h : step.t1;
      step.state(t, q_, v_);
      step.contacts(t, q_, gaps_);
      step.forces(t, piece_);
      worst.take(balance_->residual(q_, piece_, gaps_)), ++checked;
    }
  }
  double from = step.t0;
  const auto up_to = [&](double t) {
    piece_.clear();
    step.add_impulse(from, t, piece_);
    piece_.add(h > 0 ? (t - from) / h : 1, step.within());
    add(piece_);
    from = t;
  };
  for (; grid_.next() <= step.t1; grid_.advance()) {
    const double t = grid_.next();
    up_to(t);
    step.state(t, q_, v_);
    for (std::size_t i = 0; i < v_.size(); ++i) {
      const int body = static_cast<int>(i) / 3;
      const auto& b = mechanism_.bodies[body];
      scale_[i] = std::max(scale_[i], std::abs(v_[i]) * (i % 3 == 2 ? b.inertia : b.mass));
      v_last_[i] = v_[i] - v_last_[i];
    }
    const auto left = balance_->momentum_left(sum_, v_last_, t - since_);
    for (std::size_t i = 0; i < v_.size(); ++i) left_[i] = greatest(left_[i], std::abs(left[i]));
    v_last_ = v_;
    since_ = t;
    sum_.clear();
  }
  if (from < step.t1 || h == 0) up_to(step.t1);
}

double BalanceWatch::left(bool angular) const {
  double most = 0;
  for (std::size_t i = 0; i < left_.size(); ++i)
    if ((i % 3 == 2) == angular && left_[i] != 0) most = greatest(most, left_[i] / scale_[i]);
  return most;
}

std::vector<ElementForce> elements_of(const test::Columns& forces, std::size_t row,
                                      const std::vector<ForceElement>& list, const std::string& suffix) {
  std::vector<ElementForce> out(list.size());
  const auto read = [&](const std::string& column, double& to) {
    if (forces.has(column + suffix)) to = forces.at(row, column + suffix);
  };
  for (std::size_t i = 0; i < list.size(); ++i) {
    read(list[i].name + ".fx", out[i].fx);
    read(list[i].name + ".fy", out[i].fy);
    read(list[i].name + ".ft", out[i].ft);
    read(list[i].name + ".m", out[i].m);
    read(list[i].name + ".torque", out[i].m);
  }
  return out;
}

}  // namespace freeplay::verification
