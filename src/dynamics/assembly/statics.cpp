#include "dynamics/assembly/statics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "dynamics/planar.hpp"
#include "mechanism/error.hpp"
#include "numerics/dense.hpp"

namespace freeplay {
namespace {

constexpr int chunk = static_cast<int>(std::tuple_size_v<decltype(Gradient::slope)>);

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
      d_(system.make_evaluation<Gradient>()),
      rest_(system.n(), 0.0),
      f_(system.n()) {}

/// Newton's method on flow(q, z) = 0, which is linear in z for all present elements.
void Statics::settle_states(const double* q, std::vector<double>& z) {
  const int states = system_.states();
  z.resize(states, 0.0);
  if (states == 0) return;
  std::vector<Gradient> at(q, q + system_.n()), still(at.size()), x(states), rate(states);
  for (int pass = 0; pass < 50; ++pass) {
    Eigen::MatrixXd J(states, states);
    Eigen::VectorXd r(states);
    for (int first = 0; first < states; first += chunk) {
      for (int k = 0; k < states; ++k) {
        x[k] = z[k];
        if (k >= first && k < first + chunk) x[k].slope[k - first] = 1;
      }
      system_.flow<Gradient>(0, at.data(), still.data(), x.data(), rate.data());
      for (int k = 0; k < states; ++k) {
        r[k] = rate[k].value;
        for (int s = 0; s < std::min(chunk, states - first); ++s) J(k, first + s) = rate[k].slope[s];
      }
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
  settle_states(q.data(), z);
  system_.place(0, q.data(), e_);
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
  std::vector<Gradient> q(n), v(n), z(states), R(n), flow(states);
  ContactRowOf<Gradient> row;
  const int inputs = 2 * n + states;
  for (int first = 0; first < inputs; first += chunk) {
    const int directions = std::min(chunk, inputs - first);
    const auto seed = [&](int input, double value) {
      Gradient x(value);
      if (input >= first && input < first + directions) x.slope[input - first] = 1;
      return x;
    };
    for (int i = 0; i < n; ++i) q[i] = seed(i, at.q[i]);
    for (int i = 0; i < n; ++i) v[i] = seed(n + i, 0);
    for (int k = 0; k < states; ++k) z[k] = seed(2 * n + k, at.z[k]);
    system_.place<Gradient>(0, q.data(), d_);
    system_.forces<Gradient>(0, q.data(), v.data(), z.data(), d_);
    system_.flow<Gradient>(0, q.data(), v.data(), z.data(), flow.data());
    R = d_.force;
    const auto& p = system_.pattern();
    for (int k = 0; k < rows; ++k) {
      const double lambda = mu[k] * (system_.is_angle_row(k) ? length_ : 1);
      for (int i = p.begin[k]; i < p.begin[k + 1]; ++i) R[p.column[i]] -= lambda * d_.G[i];
    }
    int next = rows;
    for (int k = 0; k < system_.contacts(); ++k) {
      const bool held = std::ranges::binary_search(closed, k);
      if (!held && !(at.elastic[k] > 0)) continue;
      system_.contact(k, q.data(), v.data(), d_, row);
      const auto* law = compliance(k);
      const Gradient amount = held ? Gradient(-mu[next++])
                                   : (-row.gap).chain(law->force(-row.gap.value), law->slope(-row.gap.value));
      for (int i = 0; i < row.normal.size; ++i) R[row.normal.column[i]] += amount * row.normal.value[i];
    }
    for (int s = 0; s < directions; ++s) {
      const int input = first + s;
      for (int i = 0; i < n; ++i) {
        if (input < n)
          l.K(i, input) = -R[i].slope[s];
        else if (input < 2 * n)
          l.D(i, input - n) = -R[i].slope[s];
        else
          l.Z(i, input - 2 * n) = R[i].slope[s];
      }
      for (int k = 0; k < states; ++k) {
        if (input < n)
          l.flow_q(k, input) = flow[k].slope[s];
        else if (input < 2 * n)
          l.flow_v(k, input - n) = flow[k].slope[s];
        else
          l.flow_z(k, input - 2 * n) = flow[k].slope[s];
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
