#include "dynamics/assembly/modes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "numerics/dense.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

VectorXd masses(const System& system) { return Eigen::Map<const VectorXd>(system.mass().data(), system.n()); }

/// Multipliers of the rows of `at`, from those of an equilibrium.
VectorXd multipliers(const Statics& s, const AtRest& at, const Equilibrium& e) {
  const auto& system = s.system();
  VectorXd mu(at.C.rows());
  for (int k = 0; k < system.rows(); ++k)
    mu[k] = e.multipliers[k] / (system.is_angle_row(k) ? s.length() : 1);
  for (std::size_t i = 0; i < s.closed.size(); ++i)
    mu[system.rows() + static_cast<int>(i)] = -e.normal[s.closed[i]];
  return mu;
}

Mode made(const std::complex<double>& s, const Eigen::VectorXcd& shape, double zero, double length) {
  Mode m;
  m.s = s;
  if (std::abs(s) <= zero) {
    m.kind = Mode::Kind::free;
    m.s = 0;
  } else if (s.real() > zero) {
    m.kind = Mode::Kind::growth;
  } else if (std::abs(s.imag()) <= zero) {
    m.kind = Mode::Kind::decay;
    m.s = s.real();
  }
  std::complex<double> most = 0;
  for (int i = 0; i < shape.size(); ++i) {
    const std::complex<double> x = shape[i] * (i % 3 == 2 ? length : 1);
    if (std::abs(x) > std::abs(most) * (1 + 1e-9)) most = x;
  }
  if (std::abs(most) == 0) most = 1;
  for (int i = 0; i < shape.size(); ++i) {
    m.shape.push_back(shape[i] / most);
  }
  return m;
}

}  // namespace

double Mode::natural() const { return std::abs(s) / (2 * std::numbers::pi); }
double Mode::swinging() const { return std::abs(s.imag()) / (2 * std::numbers::pi); }

Modes find_modes(const System& system, const Equilibrium& at, const Compliances& elastic) {
  Statics s(system, elastic);
  if (elastic.empty()) s.closed = at.pressed;
  AtRest rest;
  s.look(Eigen::Map<const VectorXd>(at.state.q.data(), system.n()), rest);
  const auto l = s.linearise(rest, multipliers(s, rest, at));
  const MatrixXd Z = null_space(rest.C, masses(system));
  const auto n = static_cast<int>(Z.cols()), states = system.states();
  Modes out;
  out.length = s.length();
  const auto add = [&](const std::complex<double>& value, const Eigen::VectorXcd& shape, double zero) {
    out.modes.push_back(made(value, shape, zero, out.length));
  };
  const MatrixXd K = Z.transpose() * l.K * Z, D = Z.transpose() * l.D * Z;
  const auto h = curvatures(0.5 * (l.K + l.K.transpose()), Z, masses(system));
  const bool symmetric =
      n == 0 || (K - K.transpose()).cwiseAbs().maxCoeff() <=
                    std::max(1e-9 * K.cwiseAbs().maxCoeff(), h.doubt.cwiseAbs().maxCoeff());
  if (states == 0 && symmetric && (n == 0 || D.isZero(0))) {
    for (int d = 0; d < n; ++d) {
      const bool nothing = std::abs(h.value[d]) <= h.doubt[d];
      const double size = std::sqrt(std::abs(h.value[d]));
      const auto value = nothing          ? 0.0
                         : h.value[d] < 0 ? std::complex<double>(size)
                                          : std::complex(0.0, size);
      add(value, h.direction.col(d), 0);
    }
  } else {
    const int all = 2 * n + states;
    MatrixXd A = MatrixXd::Zero(all, all);
    A.block(0, n, n, n).setIdentity();
    A.block(n, 0, n, n) = -K;
    A.block(n, n, n, n) = -D;
    A.block(n, 2 * n, n, states) = Z.transpose() * l.Z;
    A.block(2 * n, 0, states, n) = l.flow_q * Z;
    A.block(2 * n, n, states, n) = l.flow_v * Z;
    A.block(2 * n, 2 * n, states, states) = l.flow_z;
    const auto [values, vectors] = general_eigen(A);
    // Double zeros of free motions split by the square root of the rounding error.
    const double zero = 1e-7 * (all > 0 ? values.cwiseAbs().maxCoeff() : 0);
    for (int i = 0; i < all; ++i)
      if (values[i].imag() >= 0) add(values[i], Z * vectors.col(i).head(n), zero);
  }
  std::ranges::stable_sort(out.modes, [](const Mode& a, const Mode& b) {
    const bool first = a.kind == Mode::Kind::growth, second = b.kind == Mode::Kind::growth;
    return first != second ? first : std::abs(a.s) < std::abs(b.s);
  });
  return out;
}

Equilibrium as_it_stands(const System& system, const State& state, const Compliances& elastic, double& left) {
  Statics s(system, elastic);
  AtRest at;
  Equilibrium e;
  const VectorXd q = Eigen::Map<const VectorXd>(state.q.data(), system.n());
  s.look(q, at);
  if (elastic.empty())
    for (int k = 0; k < system.contacts(); ++k)
      if (at.gap[k] <= 1e-3 * system.contact_facts(k).clearance) s.closed.push_back(k);
  VectorXd root = VectorXd::Ones(system.n());
  for (int i = 0; i < system.n(); ++i)
    if (system.is_angle(i)) root[i] = s.length();
  for (;;) {  // without contacts that would pull
    s.look(q, at);
    const VectorXd R = at.force.cwiseQuotient(root);
    VectorXd mu = VectorXd::Zero(at.C.rows()), rest = R;
    if (mu.size() > 0) {
      const MatrixXd B = (at.C * root.cwiseInverse().asDiagonal()).transpose();
      mu = MinimumNorm(B).solve(R);
      rest -= B * mu;
    }
    Eigen::Index worst = -1;
    const auto held = static_cast<Eigen::Index>(s.closed.size());
    if (held > 0 && mu.tail(held).maxCoeff(&worst) > 0) {
      s.closed.erase(s.closed.begin() + worst);
      continue;
    }
    left = rest.size() > 0 ? rest.cwiseAbs().maxCoeff() : 0;
    e.multipliers.resize(system.rows());
    for (int k = 0; k < system.rows(); ++k)
      e.multipliers[k] = mu[k] * (system.is_angle_row(k) ? s.length() : 1);
    e.normal = at.elastic;
    for (std::size_t i = 0; i < s.closed.size(); ++i)
      e.normal[s.closed[i]] = -mu[system.rows() + static_cast<int>(i)];
    break;
  }
  for (int k = 0; k < system.contacts(); ++k)
    if (e.normal[k] > 0) e.pressed.push_back(k);
  e.state = state;
  std::ranges::fill(e.state.v, 0.0);
  e.state.z = at.z;
  e.freedoms = static_cast<int>(null_space(at.C, masses(system)).cols());
  return e;
}

}  // namespace freeplay
