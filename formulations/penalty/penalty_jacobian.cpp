// Derivatives of the right-hand side of the penalty formulation, exact to rounding. jacobian() takes the
// unit vectors as directions, directional() any vectors, such as the columns of the variational equations
// (penalty_variation.hpp).
#include <algorithm>

#include "formulations/penalty/dynamics.hpp"

namespace freeplay {
namespace {

constexpr int penalty_directions = static_cast<int>(std::tuple_size_v<decltype(Gradient::slope)>);

}  // namespace

void PenaltyDynamics::reserve_jacobian() {
  const int n = system_.n(), m = system_.rows(), N = size();
  if (!tangent_)
    tangent_ = std::make_unique<Tangent>(Tangent{PenaltyTerms<Gradient>(system_, bristles_),
                                                 std::vector<Gradient>(2 * n + bristles_ + system_.states()),
                                                 std::vector<Gradient>(std::max(n, m)), Vector(N), Vector(n),
                                                 Vector(m), Vector(n), Vector(m), Vector(n),
                                                 Vector(static_cast<std::size_t>(coupled_.size()))});
}

void PenaltyDynamics::begin_tangent(const Vector& x, double t) {
  reserve_jacobian();
  auto& d = *tangent_;
  (*this)(x, d.slope, t);  // computes a and λ and factorises the matrix of their equations
  ++work.jacobians;
  std::copy_n(d.slope.begin() + system_.n(), system_.n(), d.acceleration.begin());
  if (coupled_.size() > 0) coupled_.prepare_follow();
}

void PenaltyDynamics::jacobian(const Vector& x, double t, double* J, double* dfdt) {
  constexpr int chunk = penalty_directions;
  const int n = system_.n(), N = size();
  begin_tangent(x, t);
  auto& d = *tangent_;
  d.terms.retained.clear();
  std::fill(J, J + static_cast<long>(N) * N, 0.0);
  if (traced_ && traced_jacobian(x, t, J, dfdt)) return;

  const int inputs = 2 * n + bristles_ + system_.states();  // then time
  for (int first = 0; first <= inputs; first += chunk) {
    const int directions = std::min(chunk, inputs + 1 - first);
    for (int i = 0; i < inputs; ++i) {
      d.state[i] = x[place_of_input(i)];
      if (i >= first && i < first + chunk) d.state[i].slope[i - first] = 1;
    }
    Gradient time = t;
    if (inputs < first + chunk) time.slope[inputs - first] = 1;
    std::array<double*, penalty_directions> columns{};
    for (int s = 0; s < directions; ++s)
      columns[s] = first + s == inputs ? dfdt : J + static_cast<long>(N) * place_of_input(first + s);
    differentiate(time, directions, columns.data());
  }
}

const PenaltyDynamics::Vector& PenaltyDynamics::directional(const Vector& x, double t,
                                                            std::span<const Vector> directions,
                                                            std::span<const double> times,
                                                            std::span<Vector> out) {
  constexpr int chunk = penalty_directions;
  t = std::min(t, knot);
  const int n = system_.n(), inputs = 2 * n + bristles_ + system_.states(),
            count = static_cast<int>(directions.size());
  begin_tangent(x, t);
  auto& d = *tangent_;
  if (traced_ && differentiate_traced(x, t, directions, times, out)) return d.slope;
  d.terms.retained.resize(2 * static_cast<std::size_t>(system_.contacts()));
  for (int first = 0; first < count; first += chunk) {
    const int some = std::min(chunk, count - first);
    const auto seed = [&](Gradient& y, double value, int place) {
      y = value;
      for (int s = 0; s < some; ++s) y.slope[s] = directions[first + s][place];
    };
    for (int i = 0; i < inputs; ++i) {
      const int place = place_of_input(i);
      seed(d.state[i], x[place], place);
    }
    for (int k = 0; k < system_.contacts(); ++k) {
      seed(d.terms.retained[2 * k], contacts_[k].v0, size() + 2 * k);
      seed(d.terms.retained[2 * k + 1], contacts_[k].mass, size() + 2 * k + 1);
    }
    std::array<double*, penalty_directions> columns{};
    for (int s = 0; s < some; ++s) columns[s] = out[first + s].data();
    Gradient time = t;
    for (int s = 0; s < some; ++s) time.slope[s] = times[first + s];
    differentiate(time, some, columns.data());
  }
  return d.slope;
}

/// Derivatives of dx/dt in the directions that the tangent's state and the time have.
void PenaltyDynamics::differentiate(const Gradient& time, int directions, double* const* columns) {
  const int n = system_.n(), m = system_.rows();
  auto& d = *tangent_;
  const auto& a = d.acceleration;
  auto& terms = d.terms;
  const Gradient* state = d.state.data();
  evaluate(state, state + n, state + 2 * n, state + 2 * n + bristles_, time, terms);

  // Derivatives of joint friction −factor·S(λ) with the reaction S held fixed. The loop over
  // directions below adds the part due to the change of S.
  for (int k = 0; k < coupled_.size(); ++k) {
    auto& c = terms.coupled[static_cast<std::size_t>(k)];
    c.factor = -coupled_.support(k) * c.factor;  // now the force
    c.row.add_to(terms.e.force.data(), c.factor);
  }

  // Residuals of the derivatives of M a + Gᵀλ = F and G a = r at fixed a and λ.
  for (int i = 0; i < n; ++i) d.reaction[i] = 0;
  add_transposed(system_.pattern(), terms.e.G.data(), lambda_.data(), d.reaction.data());
  for (int i = 0; i < n; ++i) d.reaction[i] = terms.e.force[i] - d.reaction[i];
  for (int k = 0; k < m; ++k)
    for (int e = system_.pattern().begin[k]; e < system_.pattern().begin[k + 1]; ++e)
      terms.r[k] -= terms.e.G[e] * a[system_.pattern().column[e]];

  for (int s = 0; s < directions; ++s) {
    for (int i = 0; i < n; ++i) d.force[i] = d.reaction[i].slope[s];
    for (int k = 0; k < m; ++k) d.r[k] = terms.r[k].slope[s];
    saddle_.solve(d.force.data(), d.r.data(), d.a.data(), d.lambda.data());
    double loss = terms.friction_loss.slope[s];
    if (coupled_.size() > 0) coupled_.follow(d.lambda.data(), d.friction.data());
    for (int k = 0; k < coupled_.size(); ++k) {
      const auto& c = terms.coupled[static_cast<std::size_t>(k)];
      const double df = d.friction[k];
      for (int i = 0; i < n; ++i) d.a[i] += df * response(k)[i];
      for (int i = 0; i < m; ++i) d.lambda[i] += df * reaction(k)[i];
      loss -= (c.factor.slope[s] + df) * c.u.value + c.factor.value * c.u.slope[s];
    }
    double* column = columns[s];
    for (int i = 0; i < n; ++i) column[i] = state[n + i].slope[s];
    std::ranges::copy(d.a, column + n);
    for (int k = 0; k < 2 * system_.contacts(); ++k)
      column[impulse_offset() + k] = terms.impulse_rate[k].slope[s];
    for (int k = 0; k < bristles_; ++k) column[bristle_offset() + k] = terms.bristle_rate[k].slope[s];
    for (int k = 0; k < system_.states(); ++k) column[state_offset() + k] = terms.flow[k].slope[s];
    double* integral = column + integral_offset();
    integral[drive] = terms.e.power.drive.slope[s];
    integral[load] = terms.e.power.load.slope[s];
    integral[damping] = -terms.e.power.damping.slope[s];
    integral[contact_work] = terms.contact_work.slope[s];
    integral[friction_loss] = loss;
    integral[film_loss] = terms.film_loss.slope[s];
    integral[stabilisation] = 0;
    for (int k = 0; k < m; ++k) {
      integral[drive] += d.lambda[k] * terms.e.phi_t[k].value + lambda_[k] * terms.e.phi_t[k].slope[s];
      integral[stabilisation] -= d.lambda[k] * terms.rate[k].value + lambda_[k] * terms.rate[k].slope[s];
    }
  }
}

void PenaltyDynamics::anchor(const Vector& x, double t, std::vector<ContactAnchor>& out) {
  const double* v = x.data() + system_.n();
  out.assign(contacts_.size(), {});
  const Evaluation* at = nullptr;
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = contacts_[k];
    if (!c.closed) continue;
    if (!at) at = &placed(x, std::min(t, knot));
    system_.contact(k, x.data(), v, *at, row_);
    auto& a = out[static_cast<std::size_t>(k)];
    a.pressed = row_.gap < 0 || touching || c.jumps();
    a.delta = std::max(0.0, -row_.gap);
    a.rate = -row_.normal.dot(v);
    a.elastic = c.law.elastic.force(a.delta);
    if (!a.pressed) continue;
    Dual<2> delta(a.delta), rate(a.rate);
    delta.slope[0] = rate.slope[1] = 1;
    const auto normal = c.force(delta, rate, c.law.elastic.force(delta));
    a.normal = normal.value;
    a.normal_by_delta = normal.slope[0];
    a.normal_by_rate = normal.slope[1];
    if (!c.rubs()) continue;
    a.v_t = row_.tangent.dot(v);
    const Dual<2> z = bristles_ ? x[bristle_offset() + k] : 0;
    Dual<2> load(a.normal), slide(a.v_t);
    load.slope[0] = slide.slope[1] = 1;
    const auto tangential = c.tangential_force(load, slide, z);
    a.tangential_by_normal = tangential.slope[0];
    a.tangential_by_v_t = tangential.slope[1];
    if (bristles_)
      a.bristle_by_v_t = c.bristle_rate(delta, Dual<2>(a.rate), Dual<2>(a.elastic), slide, z).slope[1];
  }
}

}  // namespace freeplay
