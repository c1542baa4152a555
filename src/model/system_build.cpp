// From a Mechanism to a System: which rows there are, and which of their entries never change.
#include <fmt/format.h>

#include <cmath>
#include <tuple>

#include "model/system.hpp"

namespace freeplay {

System::System(const Mechanism& m) : gravity_(m.gravity) {
  G_.columns = 3 * static_cast<int>(m.bodies.size());
  for (const auto& b : m.bodies) {
    mass_.insert(mass_.end(), {b.mass, b.mass, b.inertia});
    constant_force_.insert(constant_force_.end(), {b.mass * gravity_.x(), b.mass * gravity_.y(), 0.0});
  }
  for (std::size_t j = 0; j < m.joints.size(); ++j) {
    std::visit(
        [&](const auto& joint) {
          const int begin = G_.rows;
          if constexpr (std::is_same_v<std::decay_t<decltype(joint)>, RigidJoint>)
            add(joint);
          else
            add(joint, m);
          if (G_.rows > begin)
            reactions_.push_back({make_link(joint.between, joint.at), begin, G_.rows, static_cast<int>(j)});
        },
        m.joints[j]);
    contact_joints_.resize(contacts_.size(), static_cast<int>(j));
  }
  for (const auto& contact : m.contacts) std::visit([&](const auto& c) { add(c, m); }, contact);
  contact_joints_.resize(contacts_.size(), -1);
  for (const auto& drive : m.drives) {
    if (const auto* speed = std::get_if<SpeedDrive>(&drive)) {
      const auto& pair = bodies_of(m.joints[speed->joint]);
      if (speed_drives_.empty()) crank_ = pair;
      speed_drives_.push_back({pair[0], pair[1], G_.rows, speed->initial_angle, speed->speed});
      if (pair[0] != ground) entry(3 * pair[0] + 2, -1);
      if (pair[1] != ground) entry(3 * pair[1] + 2, 1);
      end_row(speed->name, true);
    } else {
      const auto& torque = std::get<TorqueDrive>(drive);
      state_of_drive_.push_back(torque.lag ? states() : -1);
      if (torque.lag) {
        double greatest = 0;
        for (const auto& point : torque.table) greatest = std::max(greatest, std::abs(point.second));
        lagged_.push_back({torque_drives_.size(), greatest > 0 ? greatest : 1});
      }
      torque_drives_.emplace_back(bodies_of(m.joints[torque.joint]), torque);
    }
  }
  for (const auto& load : m.loads) {
    if (const auto* f = std::get_if<ForceLoad>(&load)) force_loads_.push_back(*f);
    if (const auto* t = std::get_if<TorqueLoad>(&load)) torque_loads_.push_back(*t);
    if (const auto* s = std::get_if<SpringDamper>(&load)) {
      springs_.emplace_back(make_link(s->between, s->at), *s);
      velocity_forces_ |= s->damping > 0;
    }
    if (const auto* s = std::get_if<TorsionalSpringDamper>(&load)) {
      torsions_.push_back(*s);
      velocity_forces_ |= s->damping > 0;
    }
    if (const auto* c = std::get_if<JointFriction>(&load)) {
      const auto& joint = std::get<TranslationalJoint>(m.joints[c->joint]);
      frictions_.push_back({make_link(joint.between, joint.at), joint.axis});
      friction_facts_.push_back({c->name, c->force, c->regularisation});
    }
  }
  list_elements(m);
}

int System::entry(int column, double constant) {
  G_.column.push_back(column);
  constant_G_.push_back(constant);
  return static_cast<int>(constant_G_.size()) - 1;
}

void System::end_row(const std::string& name, bool angle) {
  G_.end_row();
  row_names_.push_back(name);
  angle_rows_.push_back(angle);
}

System::Link System::make_link(const std::array<int, 2>& between, const std::array<Vec2, 2>& at) {
  if (between[0] != ground) longest_arm_ = std::max(longest_arm_, at[0].norm());
  if (between[1] != ground) longest_arm_ = std::max(longest_arm_, at[1].norm());
  return {between[0], between[1], at[0], at[1]};
}

/// r_j^P − r_i^P = 0
void System::add_points(const Link& link, const std::string& name) {
  PointRows rows{link, G_.rows, {-1, -1}, {-1, -1}};
  for (int axis : {0, 1}) {
    const auto a = axis;
    if (link.i != ground) {
      entry(3 * link.i + axis, -1);
      if (!link.si.is_zero()) rows.theta_i[a] = entry(3 * link.i + 2, 0);
    }
    if (link.j != ground) {
      entry(3 * link.j + axis, 1);
      if (!link.sj.is_zero()) rows.theta_j[a] = entry(3 * link.j + 2, 0);
    }
    end_row(name, false);
  }
  points_.push_back(rows);
}

void System::add_angle(int i, int j, double angle, double speed, const std::string& name) {
  angles_.push_back({i, j, G_.rows, angle, speed});
  if (i != ground) entry(3 * i + 2, -1);
  if (j != ground) entry(3 * j + 2, 1);
  end_row(name, true);
}

void System::add(const RevoluteJoint& joint, const Mechanism& m) {
  const Link link = make_link(joint.between, joint.at);
  if (!joint.clearance) return add_points(link, joint.name);
  const auto& c = *joint.clearance;
  const double journal = c.bearing_radius - c.radial;
  contacts_.push_back({ContactElement::Kind::round, link, 1, {1, 0}, c.radial, c.bearing_radius, journal});
  ContactFacts facts;
  facts.name = joint.name;
  facts.bodies = joint.between;
  facts.clearance = c.radial;
  facts.radius = c.bearing_radius * journal / c.radial;
  facts.radius_bearing = c.bearing_radius;
  facts.radius_journal = journal;
  facts.surface = m.surfaces[c.surface];
  facts.bearing_length = c.bearing_length;
  if (c.lubricant >= 0) facts.lubricant = m.lubricants[c.lubricant];
  contact_facts_.push_back(facts);
}

void System::add(const TranslationalJoint& joint, const Mechanism& m) {
  if (joint.clearance) return add_corners(joint, m);
  const Link link = make_link(joint.between, joint.at);
  // Between ground and a body the normal stands still: an entry that is zero stays so.
  SlideRow slide{link, joint.axis, G_.rows, link.i != ground || joint.axis.y() != 0,
                 link.i != ground || joint.axis.x() != 0};
  slides_.push_back(slide);
  for (int b : {link.i, link.j}) {
    if (b == ground) continue;
    if (b == link.i || slide.x) entry(3 * b, 0);
    if (b == link.i || slide.y) entry(3 * b + 1, 0);
    if (b == link.i || !link.sj.is_zero()) entry(3 * b + 2, 0);
  }
  end_row(joint.name, false);
  add_angle(link.i, link.j, joint.angle, 0, joint.name);
}

/// The four corners of a loose slider, each against the wall on its side.
void System::add_corners(const TranslationalJoint& joint, const Mechanism& m) {
  const auto& c = *joint.clearance;
  // The slider's own directions in its body's frame.
  const double turn = -joint.angle;
  const Vec2 along{std::cos(turn) * joint.axis.x() - std::sin(turn) * joint.axis.y(),
                   std::sin(turn) * joint.axis.x() + std::cos(turn) * joint.axis.y()};
  const Vec2 across{-along.y(), along.x()};
  for (const auto& [name, x, y] :
       {std::tuple{"rear_lower", -0.5, -0.5}, std::tuple{"rear_upper", -0.5, 0.5},
        std::tuple{"front_lower", 0.5, -0.5}, std::tuple{"front_upper", 0.5, 0.5}}) {
    const Vec2 corner = joint.at[1] + x * c.length * along + y * c.height * across;
    ContactElement element;
    element.kind = ContactElement::Kind::line;
    element.link = make_link(joint.between, {joint.at[0], corner});
    element.side = y < 0 ? 1 : -1;
    element.axis = joint.axis;
    element.rest = -(0.5 * c.height + c.half_play);
    contacts_.push_back(element);
    ContactFacts facts;
    facts.name = joint.name + "." + name;
    facts.bodies = joint.between;
    facts.clearance = c.half_play;
    facts.radius = c.corner_radius.value_or(0);
    facts.ring = false;
    facts.surface = m.surfaces[c.surface];
    contact_facts_.push_back(facts);
  }
}

void System::add(const PlaneContact& contact, const Mechanism& m) {
  ContactElement element;
  element.kind = ContactElement::Kind::line;
  element.link = make_link(contact.between, contact.at);
  element.axis = contact.axis;
  element.rest = contact.radius;
  element.radius_j = contact.radius;
  contacts_.push_back(element);
  ContactFacts facts;
  facts.name = contact.name;
  facts.bodies = contact.between;
  facts.radius = contact.radius;
  facts.clearance = 1e-3 * std::max(contact.radius, longest_arm_);
  if (!(facts.clearance > 0)) facts.clearance = 1e-3;
  facts.ring = false;
  facts.surface = m.surfaces[contact.surface];
  contact_facts_.push_back(facts);
}

void System::add(const DiscContact& contact, const Mechanism& m) {
  const auto [Ri, Rj] = contact.radii;
  contacts_.push_back(
      {ContactElement::Kind::round, make_link(contact.between, contact.at), -1, {1, 0}, Ri + Rj, Ri, -Rj});
  ContactFacts facts;
  facts.name = contact.name;
  facts.bodies = contact.between;
  facts.radius = Ri * Rj / (Ri + Rj);
  facts.clearance = 1e-3 * facts.radius;
  facts.ring = false;
  facts.surface = m.surfaces[contact.surface];
  contact_facts_.push_back(facts);
}

void System::add(const RigidJoint& joint) {
  add_points(make_link(joint.between, joint.at), joint.name);
  add_angle(joint.between[0], joint.between[1], joint.angle, 0, joint.name);
}

template <class T>
EvaluationOf<T> System::make_evaluation() const {
  EvaluationOf<T> e;
  e.cosine.assign(bodies(), 1);
  e.sine.assign(bodies(), 0);
  e.phi.assign(rows(), 0);
  e.phi_t.assign(rows(), 0);
  e.gamma.assign(rows(), 0);
  for (const auto& d : speed_drives_) e.phi_t[d.row] = -d.speed;
  e.G.assign(constant_G_.begin(), constant_G_.end());
  e.force.assign(constant_force_.begin(), constant_force_.end());
  return e;
}
template Evaluation System::make_evaluation() const;
template EvaluationOf<Gradient> System::make_evaluation() const;

}  // namespace freeplay
