// Applied forces of a System, their potential and powers over all drives and loads, and the list of its
// elements with forces.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/builder.hpp"
#include "dynamics/elements.hpp"
#include "dynamics/evaluation.hpp"
#include "dynamics/sampling.hpp"
#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "numerics/traced.hpp"

namespace freeplay {

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
  void couple(const Link& link, const T& torque) const { couples(link, -torque, torque); }
  /// A couple between two other bodies than those of the element.
  void beside(const Link& link, const T& torque) const { couple(link, torque); }
  /// Couples on the first and on the second body.
  void couples(const Link& link, const T& on_i, const T& on_j) const {
    if (link.i != ground) f[3 * link.i + 2] += on_i;
    if (link.j != ground) f[3 * link.j + 2] += on_j;
  }
};

template <class T>
void System::forces(std::type_identity_t<T> t, const T* q, const T* v, std::type_identity_t<const T*> z,
                    EvaluationOf<T>& e, const ReadingOf<std::type_identity_t<T>>& reading) const {
  if constexpr (std::is_same_v<T, double>)
    if (compiled_.any() && compiled_.forces(t, q, v, z, states(), e, reading)) return;
  apply(Motion<T>{t, q, v, e, reading}, z, e);
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
                  const ReadingOf<std::type_identity_t<T>>& reading) const {
  if (state_scales_.empty()) return;
  const EvaluationOf<T> none;
  const Motion<T> motion{t, q, v, none, reading};
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.has_state(); })
      if (x.state >= 0) dz[x.state] = x.facts.flow(motion.of(x.phase), x.link, z[x.state]);
    if constexpr (requires { x.facts.states(); })
      if (x.state >= 0) x.facts.template flow<T>(motion, z + x.state, dz + x.state);
  });
}

void System::elastic_rows(const double* q, const Evaluation& e, double* values, double* stiffness) const {
  const Motion<double> motion{0, q, nullptr, e, {}};
  std::ranges::copy(elastic_.stiffness, stiffness);
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.strain_rows(motion, x.link, values); })
      values = x.facts.strain_rows(motion, x.link, values);
    if constexpr (requires { x.facts.tension_stiffness(motion, x.link); })
      for (const double k : x.facts.tension_stiffness(motion, x.link)) *stiffness++ += k;
    else if constexpr (requires { x.facts.stiffness(); })
      stiffness += x.facts.stiffness().size();
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

double System::next_sample(double t, const double* z) const {
  double next = INFINITY;
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.next_sample(t, z); })
      if (x.facts.sampled()) next = std::min(next, x.facts.next_sample(t, z + x.state));
  });
  return next;
}

bool System::sample(double t, const double* q, const double* v, double* z) const {
  bool taken = false;
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.sample(t, q, v, z); })
      if (x.facts.sampled()) taken |= x.facts.sample(t, q, v, z + x.state);
  });
  return taken;
}

void refuse_sampling(const System& system, std::string_view why) {
  if (!system.sampled().empty())
    throw ModelError(fmt::format("drives.{}.sampling_time", system.sampled()), std::string(why));
}

double System::next_knot(double t) const {
  double next = INFINITY;
  for_each_item(placed_->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.next_knot(t); }) next = std::min(next, x.facts.next_knot(t));
  });
  for (const auto& row : std::get<std::vector<MotionRow>>(rows_.kinds))
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
template void System::forces(Traced, const Traced*, const Traced*, const Traced*, EvaluationOf<Traced>&,
                             const ReadingOf<Traced>&) const;
template void System::flow(double, const double*, const double*, const double*, double*,
                           const Reading&) const;
template void System::flow(Traced, const Traced*, const Traced*, const Traced*, Traced*,
                           const ReadingOf<Traced>&) const;

/// Lists the elements in the order of forces.csv: ideal joints, contacts, drives, loads.
void System::list_elements(const Mechanism& m) {
  using Kind = ForceElement::Kind;
  for (auto& r : report_.reactions)
    if (r.element >= 0)
      r.element =
          report_.add(name_of(m.joints[r.element]), Kind::joint, bodies_of(m.joints[r.element]), r.element);
  for (const auto& f : friction_facts_)  // of meshes, with their reactions; others are loads
    for (const auto& r : report_.reactions)
      if (f.of_mesh() && r.begin == f.reaction->row) report_.frictions.push_back(r.element);
  for (std::size_t k = 0; k < contact_facts_.size(); ++k)
    report_.contacts.push_back(
        report_.add(contact_facts_[k].name, Kind::contact, contact_facts_[k].bodies, contact_joints_[k]));
  for (const auto& pair : pairs_) report_.contact_links.push_back(link_of(pair));
  for (const auto& sliding : slidings_)
    report_.friction_links.push_back(std::visit([](const auto& x) { return x.link; }, sliding));
  report_.placed = placed_;
  Builder builder(*this, m);
  const auto list = [&]<class Facts>(const Facts& stated) {
    const Dynamics<Facts> facts{stated};
    const auto link = facts.link(builder);
    int joint = -1;
    if constexpr (requires { facts.joint; }) joint = facts.joint;
    auto kind = Facts::reports;
    if constexpr (requires { facts.kind(m); }) kind = facts.kind(m);
    if constexpr (requires { facts.reports_as(builder); }) kind = facts.reports_as(builder);
    const int element = report_.add(facts.name, kind, {link.i, link.j}, joint);
    const auto is_new = [](const auto& x) { return x.element < 0; };
    if constexpr (Acts<Facts>)
      std::ranges::find_if(std::get<std::vector<Placed<Facts>>>(placed_->lists), is_new)->element = element;
    else if constexpr (Facts::reports == Kind::drive)
      std::ranges::find_if(report_.reactions, is_new)->element = element;
    else
      report_.frictions.push_back(element);
  };
  for (const auto& drive : m.drives) std::visit(list, drive);
  for (const auto& load : m.loads) std::visit(list, load);
}

std::vector<std::string> contact_names(const Mechanism& mechanism) {
  const System system(mechanism);
  std::vector<std::string> names;
  for (int k = 0; k < system.contacts(); ++k) names.push_back(system.contact_facts(k).name);
  return names;
}

}  // namespace freeplay
