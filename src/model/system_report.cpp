// Forces that come out. An element acts along rows: an amount λ along a row w is the generalised force λ w, whose
// entries on a body are a force and a moment about its centre of mass. The moment about the element's own point P
// follows: m = m_second − (P − c_second) × F. What any element does goes through `along`.
#include "model/plane.hpp"

namespace freeplay {

int System::add_element(const std::string& name, ForceElement::Kind kind, const std::array<int, 2>& bodies,
                        int joint) {
  force_elements_.push_back({name, kind, bodies, joint, true});
  return static_cast<int>(force_elements_.size()) - 1;
}

/// In the order of forces.csv: ideal joints, contacts, drives, loads.
void System::list_elements(const Mechanism& m) {
  using Kind = ForceElement::Kind;
  for (auto& r : reactions_) {
    const int joint = r.element;
    r.element = add_element(name_of(m.joints[joint]), Kind::joint, bodies_of(m.joints[joint]), joint);
  }
  for (std::size_t k = 0; k < contact_facts_.size(); ++k)
    contact_elements_.push_back(
        add_element(contact_facts_[k].name, Kind::contact, contact_facts_[k].bodies, contact_joints_[k]));
  std::size_t speeds = 0;
  for (const auto& drive : m.drives) {
    if (const auto* speed = std::get_if<SpeedDrive>(&drive)) {
      const auto& row = speed_drives_[speeds++];
      const int element = add_element(speed->name, Kind::drive, {row.i, row.j}, speed->joint);
      reactions_.push_back({{row.i, row.j, {0, 0}, {0, 0}}, row.row, row.row + 1, element, row.speed});
    } else {
      const auto& torque = std::get<TorqueDrive>(drive);
      torque_elements_.push_back(
          add_element(torque.name, Kind::drive, bodies_of(m.joints[torque.joint]), torque.joint));
    }
  }
  for (const auto& load : m.loads)
    std::visit(
        [&](const auto& l) {
          using L = std::decay_t<decltype(l)>;
          if constexpr (std::is_same_v<L, ForceLoad>)
            force_load_elements_.push_back(add_element(l.name, Kind::force, {ground, l.body}));
          else if constexpr (std::is_same_v<L, TorqueLoad>)
            torque_load_elements_.push_back(add_element(l.name, Kind::torque, {ground, l.body}));
          else if constexpr (std::is_same_v<L, SpringDamper>)
            spring_elements_.push_back(add_element(l.name, Kind::force, l.between));
          else if constexpr (std::is_same_v<L, TorsionalSpringDamper>)
            torsion_elements_.push_back(add_element(l.name, Kind::torque, l.between));
          else
            friction_elements_.push_back(
                add_element(l.name, Kind::force, bodies_of(m.joints[l.joint]), l.joint));
        },
        load);
}

/// Adds an amount along a row to an element's force.
void System::along(const double* q, const Evaluation& e, const Link& link, const int* column,
                   const double* value, int size, double amount, ElementForce& f) const {
  double first[3] = {0, 0, 0}, second[3] = {0, 0, 0};  // force and moment on either body
  for (int k = 0; k < size; ++k) {
    const int body = column[k] / 3;
    if (body == link.i) first[column[k] % 3] += amount * value[k];
    if (body == link.j) second[column[k] % 3] += amount * value[k];
  }
  const auto across = [](const double* arm, const double* force) {
    return arm[0] * force[1] - arm[1] * force[0];
  };
  // The ground takes the opposite of what its partner gets; its moment is about the world's origin.
  const auto opposite = [&](const double* of, int body, double* to) {
    to[0] = -of[0];
    to[1] = -of[1];
    to[2] = -of[2] - across(q + 3 * body, of);
  };
  if (link.j == ground) opposite(first, link.i, second);
  if (link.i == ground) opposite(second, link.j, first);
  const Vec2Of<double> P = turned(link.j, link.sj, e);
  const double arm[2] = {P.x(), P.y()};
  f.fx += second[0];
  f.fy += second[1];
  f.m += second[2] - across(arm, second);
  f.m_first += first[2];
  f.m_second += second[2];
}

void System::report_rows(const double* q, const Evaluation& e, const double* lambda, double weight,
                         Forces& out) const {
  for (const auto& r : reactions_) {
    auto& f = out.elements[r.element];
    for (int k = r.begin; k < r.end; ++k) {
      const int first = G_.begin[k];
      along(q, e, r.link, G_.column.data() + first, e.G.data() + first, G_.begin[k + 1] - first,
            -weight * lambda[k], f);
    }
    f.power -= weight * lambda[r.begin] * r.speed;
  }
}

void System::report_contact(int k, const double* q, const Evaluation& e, const ContactRow& row, double fn,
                            double ft, double weight, Forces& out) const {
  auto& f = out.elements[contact_elements_[k]];
  const auto& link = contacts_[k].link;
  along(q, e, link, row.normal.column.data(), row.normal.value.data(), row.normal.size, weight * fn, f);
  along(q, e, link, row.tangent.column.data(), row.tangent.value.data(), row.tangent.size, weight * ft, f);
  f.fn += weight * fn;
  f.ft += weight * ft;
}

void System::report_film(int k, const double* q, const Evaluation& e, const ContactRow& row, double fn,
                         double ft, double torque, double weight, Forces& out) const {
  auto& f = out.elements[contact_elements_[k]];
  const auto& link = contacts_[k].link;
  along(q, e, link, row.normal.column.data(), row.normal.value.data(), row.normal.size, weight * fn, f);
  along(q, e, link, row.film.column.data(), row.film.value.data(), row.film.size, weight * ft, f);
  along(q, e, link, row.spin.column.data(), row.spin.value.data(), row.spin.size, weight * torque, f);
  f.fn += weight * fn;
  f.ft += weight * ft;
}

void System::report_friction(int k, const double* q, const double* v, const Evaluation& e,
                             const SparseRow& row, double force, double weight, Forces& out) const {
  auto& f = out.elements[friction_elements_[k]];
  along(q, e, frictions_[k].link, row.column.data(), row.value.data(), row.size, weight * force, f);
  f.power += weight * force * row.dot(v);
}

void System::report_loads(double t, const double* q, const double* v, const double* z, const Evaluation& e,
                          double weight, Forces& out) const {
  // As in forces(): each load alone.
  const auto couple = [&](int element, double torque, double power) {
    auto& f = out.elements[element];
    f.m += weight * torque;
    f.m_second += weight * torque;
    f.m_first -= weight * torque;
    f.power += weight * power;
  };
  const auto pull = [&](int element, const Link& link, const Arms<double>& a, const Vec2Of<double>& force,
                        double power) {
    auto& f = out.elements[element];
    const auto centre = [&](int body) {
      return body == ground ? Vec2Of<double>{0, 0} : Vec2Of<double>{q[3 * body], q[3 * body + 1]};
    };
    f.fx += weight * force.x();
    f.fy += weight * force.y();
    f.m_second += weight * cross(a.rj, force);
    // On a first body that is the ground it acts at the same point, so that the two balance about the origin.
    const Vec2Of<double> at = link.i == ground ? Vec2Of<double>(centre(link.j) + a.rj) : a.ri;
    f.m_first -= weight * cross(at, force);
    f.power += weight * power;
  };
  for (std::size_t k = 0; k < torque_drives_.size(); ++k) {
    const auto& pair = torque_drives_[k].first;
    const double torque = torque_of(k, t, q, z);
    couple(torque_elements_[k], torque, torque * (omega(v, pair[1]) - omega(v, pair[0])));
  }
  for (std::size_t k = 0; k < force_loads_.size(); ++k) {
    const auto& load = force_loads_[k];
    const Link link{ground, load.body, {0, 0}, load.at};
    const auto a = arms(link, q, e);
    const Vec2Of<double> force{load.force.x(), load.force.y()};
    pull(force_load_elements_[k], link, a, force, dot(force, relative_velocity(link, a, v)));
  }
  for (std::size_t k = 0; k < torque_loads_.size(); ++k)
    couple(torque_load_elements_[k], torque_loads_[k].torque,
           torque_loads_[k].torque * omega(v, torque_loads_[k].body));
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    const auto& [link, s] = springs_[k];
    const auto a = arms(link, q, e);
    const double length = a.d.norm();
    if (!(length > 0)) continue;
    const Vec2Of<double> direction = a.d / length, rate = relative_velocity(link, a, v);
    const double force = s.stiffness * (length - s.free_length) + s.damping * dot(direction, rate);
    const Vec2Of<double> on_second = -force * direction;
    pull(spring_elements_[k], link, a, on_second, dot(on_second, rate));
  }
  for (std::size_t k = 0; k < torsions_.size(); ++k) {
    const auto& s = torsions_[k];
    const double speed = omega(v, s.between[1]) - omega(v, s.between[0]);
    const double angle = theta(q, s.between[1]) - theta(q, s.between[0]) - s.free_angle;
    const double torque = -(s.stiffness * angle + s.damping * speed);
    couple(torsion_elements_[k], torque, torque * speed);
  }
}

}  // namespace freeplay
