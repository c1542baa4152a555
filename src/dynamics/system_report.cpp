// Resulting forces. An element acts along rows: an amount λ along a row w is the generalised force
// λ w, whose entries for a body are a force and a moment about its centre of mass. The moment about
// the element's own point P follows: m = m_second − (P − c_second) × F. `along` does this for all
// elements.

#include <algorithm>
#include <cmath>

#include "dynamics/builder.hpp"
#include "dynamics/elements.hpp"
#include "dynamics/evaluation.hpp"
#include "dynamics/system.hpp"
#include "numerics/traced.hpp"

namespace freeplay {

// Applied forces, their potential, and the powers of forces without one, over all drives and loads.

/// Sums over drives and loads: generalised forces and powers.
template <class T>
struct AppliedForces {
  std::vector<T>& f;
  LoadPower<T>& power;

  /// Adds a force on the second body at its arm, and its reaction on the first.
  void pull(const Link& link, const Arms<T>& a, const Vec2Of<T>& force) const {
    const auto push = [&](int body, const Vec2Of<T>& arm, double sign) {
      if (body == ground) return;
      f[3 * body] += sign * force.x();
      f[3 * body + 1] += sign * force.y();
      f[3 * body + 2] += sign * cross(arm, force);
    };
    push(link.i, a.ri, -1);
    push(link.j, a.rj, 1);
  }
  void couple(const Link& link, const T& torque) const {
    if (link.i != ground) f[3 * link.i + 2] -= torque;
    if (link.j != ground) f[3 * link.j + 2] += torque;
  }
};

template <class T>
void System::forces(std::type_identity_t<T> t, const T* q, const T* v, const T* z, EvaluationOf<T>& e,
                    const Reading& reading) const {
  if constexpr (std::is_same_v<T, double>)
    if (compiled_ && forces_compiled(t, q, v, z, e, reading)) return;
  if constexpr (is_traced<T>)
    apply(Motion<T>{t, q, v, e}, z, e);
  else
    apply(Motion<T>{t, q, v, e, reading}, z, e);
}

void System::forces(const Traced& t, const Traced* q, const Traced* v, const Traced* z,
                    EvaluationOf<Traced>& e, const ReadingOf<Traced>& reading) const {
  apply(Motion<Traced>{t, q, v, e, reading}, z, e);
}

template <class T>
void System::apply(const Motion<T>& motion, const T* z, EvaluationOf<T>& e) const {
  std::ranges::copy(constant_force_, e.force.begin());
  e.power = {};
  if (!acts_) return;
  const AppliedForces<T> out{e.force, e.power};
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (Acts<Facts>)
      x.facts.template act<T>(motion.of(x.phase), x.link, x.state < 0 ? nullptr : z + x.state, out);
  });
}

template <class T>
void System::flow(std::type_identity_t<T> t, const T* q, const T* v, const T* z, T* dz,
                  const Reading& reading) const {
  if (state_scales_.empty()) return;
  const EvaluationOf<T> none;
  Motion<T> motion{t, q, v, none};
  if constexpr (!is_traced<T>) motion.reading = reading;
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.has_state(); })
      if (x.state >= 0) dz[x.state] = x.facts.flow(motion.of(x.phase), x.link, z[x.state]);
    if constexpr (requires { x.facts.states(); })
      if (x.state >= 0) x.facts.template flow<T>(motion, z + x.state, dz + x.state);
  });
}

void System::saturations(double t, const double* q, const double* v, const double* z,
                         Saturation* list) const {
  const Evaluation none;
  const Motion<double> motion{t, q, v, none, {}};
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.limiters(); })
      if (x.facts.limiters() > 0)
        *list++ = x.facts.saturation(motion, x.link, x.state < 0 ? nullptr : z + x.state);
  });
}

double System::next_knot(double t) const {
  double next = INFINITY;
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.next_knot(t); }) next = std::min(next, x.facts.next_knot(t));
  });
  for (const auto& row : std::get<std::vector<MotionRow>>(constraints_))
    if (!row.follows) next = std::min(next, row.course.next_knot(t));
  return next;
}

double System::kinetic(const double* v) const {
  double sum = 0;
  for (std::size_t i = 0; i < mass_.size(); ++i) sum += 0.5 * mass_[i] * v[i] * v[i];
  return sum;
}

double System::potential(const double* q) const {
  double sum = 0;
  const bool heavy = gravity_.x() != 0 || gravity_.y() != 0;
  for (std::size_t b = 0; heavy && b < mass_.size(); b += 3)
    sum -= mass_[b] * (gravity_.x() * q[b] + gravity_.y() * q[b + 1]);
  if (!acts_) return sum;
  const Placement placement{q};
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.potential(placement, x.link); })
      sum += x.facts.potential(placement, x.link);
  });
  return sum;
}

template void System::forces(double, const double*, const double*, const double*, Evaluation&,
                             const Reading&) const;
template void System::forces(Gradient, const Gradient*, const Gradient*, const Gradient*,
                             EvaluationOf<Gradient>&, const Reading&) const;
template void System::forces(Traced, const Traced*, const Traced*, const Traced*, EvaluationOf<Traced>&,
                             const Reading&) const;
template void System::flow(double, const double*, const double*, const double*, double*,
                           const Reading&) const;
template void System::flow(Gradient, const Gradient*, const Gradient*, const Gradient*, Gradient*,
                           const Reading&) const;
template void System::flow(Traced, const Traced*, const Traced*, const Traced*, Traced*,
                           const Reading&) const;

namespace {

/// Records the force of one drive or load; act() writes to it in place of AppliedForces.
struct Reported {
  const Motion<double>& motion;
  double weight;
  ElementForce& f;
  LoadPower<double> power = {};  // not used

  void couple(const Link& link, double torque) const {
    f.m += weight * torque;
    f.m_second += weight * torque;
    f.m_first -= weight * torque;
    f.power += weight * (torque * motion.spin(link));
  }
  void pull(const Link& link, const Arms<double>& a, const Vec2& force) const {
    f.fx += weight * force.x();
    f.fy += weight * force.y();
    f.m_second += weight * cross(a.rj, force);
    // On the ground as first body the force acts at the same point, so that both balance about the
    // origin.
    const Vec2 at = link.i == ground ? centre(motion.q, link.j) + a.rj : a.ri;
    f.m_first -= weight * cross(at, force);
    f.power += weight * dot(force, motion.relative_velocity(link, a));
  }
};

}  // namespace

int System::add_element(const std::string& name, ForceElement::Kind kind, const std::array<int, 2>& bodies,
                        int joint) {
  force_elements_.push_back({name, kind, bodies, joint, true});
  return static_cast<int>(force_elements_.size()) - 1;
}

/// Lists the elements in the order of forces.csv: ideal joints, contacts, drives, loads.
void System::list_elements(const Mechanism& m) {
  using Kind = ForceElement::Kind;
  for (auto& r : reactions_)
    if (r.element >= 0)
      r.element =
          add_element(name_of(m.joints[r.element]), Kind::joint, bodies_of(m.joints[r.element]), r.element);
  for (std::size_t k = 0; k < contact_facts_.size(); ++k)
    contact_elements_.push_back(
        add_element(contact_facts_[k].name, Kind::contact, contact_facts_[k].bodies, contact_joints_[k]));
  Builder builder(*this, m);
  const auto list = [&]<class Facts>(const Facts& stated) {
    const Dynamics<Facts> facts{stated};
    const auto link = facts.link(builder);
    int joint = -1;
    if constexpr (requires { facts.joint; }) joint = facts.joint;
    auto kind = Facts::reports;
    if constexpr (requires { facts.kind(m); }) kind = facts.kind(m);
    if constexpr (requires { facts.reports_as(builder); }) kind = facts.reports_as(builder);
    const int element = add_element(facts.name, kind, {link.i, link.j}, joint);
    const auto is_new = [](const auto& x) { return x.element < 0; };
    if constexpr (Acts<Facts>)
      std::ranges::find_if(std::get<std::vector<Placed<Facts>>>(placed_->lists), is_new)->element = element;
    else if constexpr (Facts::reports == Kind::drive)
      std::ranges::find_if(reactions_, is_new)->element = element;
    else
      friction_elements_.push_back(element);
  };
  for (const auto& drive : m.drives) std::visit(list, drive);
  for (const auto& load : m.loads) std::visit(list, load);
}

/// Adds an amount along a row to an element's force.
void System::along(const double* q, const Evaluation& e, const Link& link, const int* column,
                   const double* value, int size, double amount, ElementForce& f) const {
  // Force and moment on the first and second body.
  double first[3] = {0, 0, 0}, second[3] = {0, 0, 0};
  for (int k = 0; k < size; ++k) {
    const int body = column[k] / 3;
    if (body == link.i) first[column[k] % 3] += amount * value[k];
    if (body == link.j) second[column[k] % 3] += amount * value[k];
  }
  const auto across = [](const double* arm, const double* force) {
    return arm[0] * force[1] - arm[1] * force[0];
  };
  // The ground receives the opposite of the other body's force; its moment is about the world's
  // origin.
  const auto opposite = [&](const double* of, int body, double* to) {
    to[0] = -of[0];
    to[1] = -of[1];
    to[2] = -of[2] - across(q + 3 * body, of);
  };
  if (link.j == ground) opposite(first, link.i, second);
  if (link.i == ground) opposite(second, link.j, first);
  const Vec2 P = turned(link.j, link.sj, e);
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
    f.power += weight * lambda[r.begin] * e.phi_t[r.begin];
  }
}

void System::report_contact(int k, const Link& link, const double* q, const Evaluation& e,
                            const ContactRow& row, double fn, double ft, double weight, Forces& out) const {
  auto& f = out.elements[contact_elements_[k]];
  along(q, e, link, row.normal.column.data(), row.normal.value.data(), row.normal.size, weight * fn, f);
  along(q, e, link, row.tangent.column.data(), row.tangent.value.data(), row.tangent.size, weight * ft, f);
  f.fn += weight * fn;
  f.ft += weight * ft;
}

void System::report_film(int k, const double* q, const Evaluation& e, const ContactRow& row, double fn,
                         double ft, double torque, double weight, Forces& out) const {
  auto& f = out.elements[contact_elements_[k]];
  const auto& link = link_of(k);
  along(q, e, link, row.normal.column.data(), row.normal.value.data(), row.normal.size, weight * fn, f);
  along(q, e, link, row.film.column.data(), row.film.value.data(), row.film.size, weight * ft, f);
  along(q, e, link, row.spin.column.data(), row.spin.value.data(), row.spin.size, weight * torque, f);
  f.fn += weight * fn;
  f.ft += weight * ft;
}

void System::report_friction(int k, const double* q, const double* v, const Evaluation& e,
                             const SparseRow& row, double force, double weight, Forces& out) const {
  auto& f = out.elements[friction_elements_[k]];
  const auto& link = std::visit([](const auto& x) -> const Link& { return x.link; }, slidings_[k]);
  along(q, e, link, row.column.data(), row.value.data(), row.size, weight * force, f);
  f.power += weight * force * row.dot(v);
}

void System::report_loads(double t, const double* q, const double* v, const double* z, const Evaluation& e,
                          double weight, Forces& out, const Reading& reading) const {
  const Motion<double> motion{t, q, v, e, reading};
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (Acts<Facts>) {
      Reported reported{motion, weight, out.elements[x.element]};
      x.facts.template act<double>(motion.of(x.phase), x.link, x.state < 0 ? nullptr : z + x.state, reported);
    }
  });
}

std::vector<std::string> contact_names(const Mechanism& mechanism) {
  const System system(mechanism);
  std::vector<std::string> names;
  for (int k = 0; k < system.contacts(); ++k) names.push_back(system.contact_facts(k).name);
  return names;
}

}  // namespace freeplay
