#include "dynamics/assembly/statics.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "dynamics/planar.hpp"
#include "dynamics/sampling.hpp"
#include "mechanism/error.hpp"
#include "numerics/dense.hpp"

namespace freeplay {
namespace {

/// Length scale: the longest arm, or the greatest radius of a contact.
double length_of(const System& system) {
  double length = system.longest_arm();
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& facts = system.contact_facts(k);
    length = std::max(length, facts.ring ? facts.radius_bearing : facts.radius);
  }
  return length > 0 ? length : 1;
}

}  // namespace

Eigen::MatrixXd Linearised::settled() const {
  if (flow_z.rows() == 0) return K;
  const auto follow = solve_regular(flow_z, flow_q);  // settle_states() found it regular
  return follow ? Eigen::MatrixXd(K + Z * *follow) : K;
}

Statics::Statics(const System& system, Compliances elastic)
    : system_(system),
      elastic_(std::move(elastic)),
      length_(length_of(system)),
      e_(system.make_evaluation()),
      tangent_(system, SystemTangent::Use::penalty),
      blocks_(system, 2 * system.n()),
      motion_(tangent_.make_slopes()),
      rest_(system.n(), 0.0),
      f_(system.n()) {
  refuse_sampling(
      system,
      "a sampled controller acts at instants only: it has no equilibrium and no modes as a motion "
      "in continuous time; omit the key for the continuous law");
}

/// The state of the last place(), at rest.
SystemTangent::Point Statics::point(const double* q, const std::vector<double>& z,
                                    const std::vector<double>& lambda) const {
  return {0, q, rest_.data(), z.data(), rest_.data(), lambda.data(), e_.cosine.data(), e_.sine.data()};
}

/// Newton's method on flow(q, z) = 0, which is linear in z for all present elements; needs place().
void Statics::settle_states(const double* q, std::vector<double>& z) {
  const int n = system_.n(), states = system_.states();
  z.resize(states, 0.0);
  if (states == 0) return;
  const std::vector<double> none(system_.rows());
  std::vector<std::vector<double>> units(states, std::vector<double>(2 * n + states));
  for (int k = 0; k < states; ++k) units[k][2 * n + k] = 1;
  for (int pass = 0; pass < 50; ++pass) {
    Eigen::MatrixXd J(states, states);
    Eigen::VectorXd r(states);
    system_.flow(0, q, rest_.data(), z.data(), r.data());
    tangent_.begin(point(q, z, none));
    for (int first = 0; first < states; first += TangentTape::width) {
      const int some = blocks_.take(units, {}, first);
      tangent_.motion(blocks_.along(-1), motion_);
      for (int s = 0; s < some; ++s)
        for (int k = 0; k < states; ++k) J(k, first + s) = motion_.flow[k][s];
    }
    const auto step = solve_regular(J, r);
    if (!step)
      throw ModelError("run.start", "no equilibrium: a drive's first-order state has no stationary value");
    double change = 0;
    for (int k = 0; k < states; ++k) {
      z[k] -= (*step)(k, 0);
      change = std::max(change, std::abs((*step)(k, 0)) / system_.state_scale(k));
    }
    if (change < 1e-14) return;
  }
}

const Eigen::VectorXd& Statics::applied(const Eigen::VectorXd& q, std::vector<double>& z) {
  system_.place(0, q.data(), e_);
  settle_states(q.data(), z);
  system_.forces(0, q.data(), rest_.data(), z.data(), e_);
  f_ = Eigen::Map<const Eigen::VectorXd>(e_.force.data(), system_.n());
  return f_;
}

void Statics::look(const Eigen::VectorXd& q, AtRest& at) {
  const int n = system_.n(), rows = system_.rows();
  at.q = q;
  at.applied = applied(q, at.z);
  at.force = at.applied;
  at.gap.assign(system_.contacts(), 0);
  at.elastic.assign(system_.contacts(), 0);
  at.C = Eigen::MatrixXd::Zero(rows + static_cast<int>(closed.size()), n);
  at.c.resize(at.C.rows());
  const auto& p = system_.pattern();
  for (int k = 0; k < rows; ++k) {
    const double scale = system_.is_angle_row(k) ? length_ : 1;
    at.c[k] = scale * e_.phi[k];
    for (int i = p.begin[k]; i < p.begin[k + 1]; ++i) at.C(k, p.column[i]) += scale * e_.G[i];
  }
  int next = rows;
  for (int k = 0; k < system_.contacts(); ++k) {
    at.gap[k] = system_.gap(k, q.data(), e_);
    const bool held = std::ranges::binary_search(closed, k);
    const auto* law = compliance(k);
    if (!held && !(law && at.gap[k] < 0)) continue;
    system_.contact(k, q.data(), rest_.data(), e_, row_);
    if (held) {
      at.c[next] = at.gap[k];
      for (int i = 0; i < row_.normal.size; ++i) at.C(next, row_.normal.column[i]) += row_.normal.value[i];
      ++next;
    } else {
      at.elastic[k] = law->force(-at.gap[k]);
      row_.normal.add_to(at.force.data(), at.elastic[k]);
    }
  }
}

Linearised Statics::linearise(const AtRest& at, const Eigen::VectorXd& mu) {
  const int n = system_.n(), rows = system_.rows(), states = system_.states();
  Linearised l{Eigen::MatrixXd::Zero(n, n),      Eigen::MatrixXd::Zero(n, n),
               Eigen::MatrixXd::Zero(n, states), Eigen::MatrixXd::Zero(states, n),
               Eigen::MatrixXd::Zero(states, n), Eigen::MatrixXd::Zero(states, states)};
  system_.place(0, at.q.data(), e_);
  std::vector<double> lambda(rows);
  for (int k = 0; k < rows; ++k) lambda[k] = mu[k] * (system_.is_angle_row(k) ? length_ : 1);
  const auto here = point(at.q.data(), at.z, lambda);
  tangent_.begin(here);
  struct Pressed {
    int contact;
    double force, stiffness;  // N, N/m
    SparseRow row;
  };
  std::vector<Pressed> pressed;
  int next = rows;
  for (int k = 0; k < system_.contacts(); ++k) {
    const bool held = std::ranges::binary_search(closed, k);
    if (!held && !(at.elastic[k] > 0)) continue;
    system_.contact(k, at.q.data(), rest_.data(), e_, row_);
    const auto* law = held ? nullptr : compliance(k);
    pressed.push_back(
        {k, held ? -mu[next++] : law->force(-row_.gap), held ? 0 : law->slope(-row_.gap), row_.normal});
    tangent_.begin_contact(here, k, {.normal = pressed.back().force});
  }
  std::vector<std::vector<double>> units(2 * n + states, std::vector<double>(2 * n + states));
  for (std::size_t i = 0; i < units.size(); ++i) units[i][i] = 1;
  SystemTangent::ContactSlopes contact;
  Eigen::VectorXd R(n), flow(states);
  for (int first = 0; first < 2 * n + states; first += TangentTape::width) {
    const int some = blocks_.take(units, {}, first);
    const auto along = blocks_.along(-1);
    tangent_.motion(along, motion_);
    for (const auto& p : pressed) {
      tangent_.contact(p.contact, along, motion_, contact);
      for (int i = 0; i < p.row.size; ++i)
        motion_.force[p.row.column[i]] -= p.stiffness * p.row.value[i] * contact.gap;
    }
    for (int s = 0; s < some; ++s) {
      for (int i = 0; i < n; ++i) R[i] = motion_.force[i][s];
      for (int k = 0; k < states; ++k) flow[k] = motion_.flow[k][s];
      const int input = first + s;
      if (input < n) {
        l.K.col(input) = -R;
        l.flow_q.col(input) = flow;
      } else if (input < 2 * n) {
        l.D.col(input - n) = -R;
        l.flow_v.col(input - n) = flow;
      } else {
        l.Z.col(input - 2 * n) = R;
        l.flow_z.col(input - 2 * n) = flow;
      }
    }
  }
  return l;
}

double Statics::climb(const AtRest& a, const AtRest& b) {
  // Gauss–Legendre quadrature with five points.
  constexpr std::array node{0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr std::array weight{0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const Eigen::VectorXd step = b.q - a.q;
  auto z = a.z;
  double work = 0;
  for (int i = -2; i <= 2; ++i) {
    const double s = 0.5 + 0.5 * (i < 0 ? -node[-i] : node[i]);
    work += 0.5 * weight[std::abs(i)] * applied(a.q + s * step, z).dot(step);
  }
  double stored = 0;
  for (int k = 0; k < system_.contacts(); ++k)
    if (const auto* law = compliance(k); law && !std::ranges::binary_search(closed, k)) {
      if (b.gap[k] < 0) stored += law->energy(-b.gap[k]);
      if (a.gap[k] < 0) stored -= law->energy(-a.gap[k]);
    }
  return stored - work;
}

Eigen::VectorXd Statics::sizes(const AtRest& at, const Eigen::VectorXd& mu) {
  const int n = system_.n();
  // The total applied force, for constant forces such as weight, plus the reported force of each
  // element.
  Eigen::VectorXd all = at.applied.cwiseAbs();
  system_.place(0, at.q.data(), e_);
  auto each = system_.make_forces();
  system_.report().loads(0, at.q.data(), rest_.data(), at.z.data(), e_, 1, each);
  const auto& elements = system_.report().elements;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const auto& f = each.elements[i];
    for (const int end : {0, 1}) {
      const int body = elements[i].bodies[end];
      if (body == ground) continue;
      const int first = planar::first(body);
      all[first] += std::abs(f.fx);
      all[first + 1] += std::abs(f.fy);
      all[first + 2] += std::abs(end == 0 ? f.m_first : f.m_second);
    }
  }
  all += (at.force - at.applied).cwiseAbs();
  if (at.C.rows() > 0) all += at.C.cwiseAbs().transpose() * mu.cwiseAbs();
  // Couples of forces on arms: a force through the centre of mass passes it up to rounding only.
  for (int i = 0; i < n; ++i)
    if (system_.is_angle(i)) all[i] += 1e-3 * length_ * (all[i - 1] + all[i - 2]);
  return all;
}

}  // namespace freeplay
