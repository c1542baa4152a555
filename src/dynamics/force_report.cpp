#include "dynamics/force_report.hpp"

#include "dynamics/elements.hpp"

namespace freeplay {

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
  /// Not the reported force, but part of its power.
  void beside(const Link& link, double torque) const { f.power += weight * (torque * motion.spin(link)); }
  void couples(const Link& link, double on_i, double on_j) const {
    f.m += weight * on_j;
    f.m_second += weight * on_j;
    f.m_first += weight * on_i;
    f.power += weight * (on_i * omega(motion.v, link.i) + on_j * omega(motion.v, link.j));
  }
  void section(double normal, double shear, double bending) const {
    f.fn += weight * normal;
    f.ft += weight * shear;
    f.bending += weight * bending;
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

/// Adds an amount along a row to an element's force.
void along(const double* q, const Evaluation& e, const Link& link, const int* column, const double* value,
           int size, double amount, ElementForce& f) {
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

}  // namespace

void ForceReport::rows(const CsrPattern& pattern, const double* q, const Evaluation& e, const double* lambda,
                       double weight, Forces& out) const {
  for (const auto& r : reactions) {
    auto& f = out.elements[r.element];
    for (int k = r.begin; k < r.end; ++k) {
      const int first = pattern.begin[k];
      along(q, e, r.link, pattern.column.data() + first, e.G.data() + first, pattern.begin[k + 1] - first,
            -weight * lambda[k], f);
    }
    f.power += weight * lambda[r.begin] * e.phi_t[r.begin];
  }
}

void ForceReport::contact(int k, const Link& link, const double* q, const Evaluation& e,
                          const ContactRow& row, double fn, double ft, double weight, Forces& out) const {
  auto& f = out.elements[contacts[k]];
  along(q, e, link, row.normal.column.data(), row.normal.value.data(), row.normal.size, weight * fn, f);
  along(q, e, link, row.tangent.column.data(), row.tangent.value.data(), row.tangent.size, weight * ft, f);
  f.fn += weight * fn;
  f.ft += weight * ft;
}

void ForceReport::film(int k, const double* q, const Evaluation& e, const ContactRow& row, double fn,
                       double ft, double torque, double weight, Forces& out) const {
  auto& f = out.elements[contacts[k]];
  const auto& link = contact_links[k];
  along(q, e, link, row.normal.column.data(), row.normal.value.data(), row.normal.size, weight * fn, f);
  along(q, e, link, row.film.column.data(), row.film.value.data(), row.film.size, weight * ft, f);
  along(q, e, link, row.spin.column.data(), row.spin.value.data(), row.spin.size, weight * torque, f);
  f.fn += weight * fn;
  f.ft += weight * ft;
}

void ForceReport::friction(int k, const double* q, const double* v, const Evaluation& e, const SparseRow& row,
                           double force, double weight, Forces& out) const {
  auto& f = out.elements[frictions[k]];
  const auto& link = friction_links[k];
  along(q, e, link, row.column.data(), row.value.data(), row.size, weight * force, f);
  f.power += weight * force * row.dot(v);
}

void ForceReport::elastic(const double* q, const Evaluation& e, const double* displacement, double weight,
                          Forces& out) const {
  const Motion<double> motion{0, q, displacement, e, {}};
  for_each_item(placed->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (requires { x.facts.resist(motion, x.link, std::declval<Reported&>()); }) {
      Reported reported{motion, weight, out.elements[x.element]};
      x.facts.resist(motion, x.link, reported);
    }
  });
}

void ForceReport::loads(double t, const double* q, const double* v, const double* z, const Evaluation& e,
                        double weight, Forces& out, const Reading& reading) const {
  const Motion<double> motion{t, q, v, e, reading};
  for_each_item(placed->lists, [&]<class Facts>(const Placed<Facts>& x) {
    if constexpr (Acts<Facts> && requires { Facts::reports; }) {
      Reported reported{motion, weight, out.elements[x.element]};
      x.facts.template act<double>(motion.of(x.phase), x.link, x.state < 0 ? nullptr : z + x.state, reported);
    }
  });
}

}  // namespace freeplay
