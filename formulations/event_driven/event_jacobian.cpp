// The derivative of a mode's right-hand side, exact to rounding: where
//
//     M a + Gᵀλ − Σ E_r s_r = F,   G a = γ,   W_r a = γ_r      (E_r = W_N − s μ W_T of what slips, else W_r)
//
// its derivatives obey
//
//     M da + Gᵀdλ − Σ E_r ds_r = dF − dGᵀλ + Σ dE_r s_r,   G da = dγ − dG a,   W_r da = dγ_r − dW_r a,
//
// with the matrix that the mode was solved with.
#include <algorithm>

#include "formulations/contact/film_force.hpp"
#include "formulations/event_driven/event_dynamics.hpp"

namespace freeplay {

struct EventDynamics::Tangent {
  EvaluationOf<Gradient> e;
  ContactRowOf<Gradient> row;
  SparseRowOf<Gradient> slide;
  std::vector<Gradient> state, reaction, flow, sigma;  // sigma: γ_r − W_r a
  std::vector<Gradient> r;
  Vector slope, acceleration, active, force, side, a, lambda;
};

void EventDynamics::reserve_jacobian() {
  if (tangent_) return;
  const auto n = static_cast<std::size_t>(system_.n()), m = static_cast<std::size_t>(system_.rows()),
             states = static_cast<std::size_t>(system_.states());
  tangent_ = std::make_shared<Tangent>();
  auto& d = *tangent_;
  d.e = system_.make_evaluation<Gradient>();
  d.state.resize(2 * n + states);
  d.reaction.resize(n);
  d.flow.resize(states);
  d.sigma.resize(rows_.size());
  d.r.resize(m);
  d.slope.resize(static_cast<std::size_t>(size()));
  for (auto* x : {&d.acceleration, &d.force, &d.a}) x->resize(n);
  for (auto* x : {&d.side, &d.lambda}) x->resize(m);
  d.active.resize(rows_.size());
}

void EventDynamics::jacobian(const Vector& x, double t, double* J, double* dfdt) {
  constexpr int chunk = static_cast<int>(std::tuple_size_v<decltype(Gradient::slope)>);
  const int n = system_.n(), m = system_.rows(), N = size(), states = system_.states();
  reserve_jacobian();
  auto& d = *tangent_;
  (*this)(x, d.slope, t);  // accelerations, multipliers and the matrix of the mode
  ++work.jacobians;
  std::fill(J, J + static_cast<long>(N) * N, 0.0);
  std::fill(dfdt, dfdt + N, 0.0);
  std::ranges::copy(a_, d.acceleration.begin());
  const double* a = d.acceleration.data();
  const int used = used_;
  if (used > 0) std::copy_n(solution_.data(), used, d.active.begin());
  const auto place_of = [&](int input) { return input < 2 * n ? input : state_offset() + input - 2 * n; };

  const int inputs = 2 * n + states;  // then time
  for (int first = 0; first <= inputs; first += chunk) {
    const int directions = std::min(chunk, inputs + 1 - first);
    for (int i = 0; i < inputs; ++i) {
      d.state[i] = x[place_of(i)];
      if (i >= first && i < first + chunk) d.state[i].slope[i - first] = 1;
    }
    Gradient time = t;
    if (inputs < first + chunk) time.slope[inputs - first] = 1;
    const Gradient *q = d.state.data(), *v = q + n, *z = v + n;
    auto& e = d.e;
    system_.place(time, q, e, phases.pieces());
    system_.rate(q, v, e);
    system_.forces(time, q, v, z, e, {nullptr, phases.pieces()});
    system_.flow(time, q, v, z, d.flow.data(), {nullptr, phases.pieces()});
    Gradient friction_power = 0, film_power = 0;
    const auto take = [&](int active, const SparseRowOf<Gradient>& row, const Gradient& gamma) {
      Gradient rest = gamma;
      for (int i = 0; i < row.size; ++i) rest -= row.value[i] * a[row.column[i]];
      d.sigma[active] = rest;
    };
    for (int k = 0; k < system_.frictions(); ++k) {
      const auto& p = preloaded_[k];
      const Gradient gamma = system_.friction(k, q, v, e, d.slide);
      d.slide.add_to(e.force.data(), p.lambda);
      if (p.unknown >= 0) take(p.unknown, d.slide, gamma);
      friction_power -= p.lambda * d.slide.dot(v);
    }
    for (const auto& f : films_) {
      system_.contact(f.contact, q, v, e, d.row);
      const auto film = film_action(f.law, v, d.row);
      if (!film) continue;
      d.row.normal.add_to(e.force.data(), film->normal);
      d.row.film.add_to(e.force.data(), film->tangential);
      d.row.spin.add_to(e.force.data(), film->torque);
      film_power += film->loss;
    }
    for (int k = 0; k < system_.contacts(); ++k) {
      const auto& c = contacts_[k];
      if (c.unknown < 0) continue;
      system_.contact(k, q, v, e, d.row);
      d.row.normal.add_to(e.force.data(), c.lambda_n);
      if (c.row.tangent.size > 0) d.row.tangent.add_to(e.force.data(), c.lambda_t);
      take(c.unknown, d.row.normal, d.row.gamma_n);
      if (c.tangent_unknown >= 0) take(c.tangent_unknown, d.row.tangent, d.row.gamma_t);
      if (c.lambda_t != 0) friction_power -= c.lambda_t * d.row.tangent.dot(v);
    }
    for (int i = 0; i < n; ++i) d.reaction[i] = 0;
    add_transposed(system_.pattern(), e.G.data(), lambda_.data(), d.reaction.data());
    for (int i = 0; i < n; ++i) d.reaction[i] = e.force[i] - d.reaction[i];
    for (int k = 0; k < m; ++k) {
      d.r[k] = e.gamma[k];
      for (int s = system_.pattern().begin[k]; s < system_.pattern().begin[k + 1]; ++s)
        d.r[k] -= e.G[s] * a[system_.pattern().column[s]];
    }

    for (int s = 0; s < directions; ++s) {
      for (int i = 0; i < n; ++i) d.force[i] = d.reaction[i].slope[s];
      for (int k = 0; k < m; ++k) d.side[k] = d.r[k].slope[s];
      saddle_.solve(d.force.data(), d.side.data(), d.a.data(), d.lambda.data());
      if (used > 0) {
        for (int r = 0; r < used; ++r) rhs_[r] = d.sigma[r].slope[s] - rows_[r].dot(d.a.data());
        solve_active();
        for (int r = 0; r < used; ++r) {
          for (int i = 0; i < n; ++i) d.a[i] += solution_[r] * response(r)[i];
          for (int k = 0; k < m; ++k) d.lambda[k] += solution_[r] * reaction(r)[k];
        }
      }
      const int input = first + s;
      double* column = input == inputs ? dfdt : J + static_cast<long>(N) * place_of(input);
      for (int i = 0; i < n; ++i) column[i] = input == n + i ? 1 : 0;
      std::ranges::copy(d.a, column + n);
      double* integral = column + integral_offset();
      integral[friction_loss] = friction_power.slope[s];
      for (int k = 0; k < system_.contacts(); ++k) {
        const auto& c = contacts_[k];
        if (c.unknown < 0) continue;
        const double normal = solution_[c.unknown];
        double tangential = 0;
        if (c.tangent_unknown >= 0)
          tangential = solution_[c.tangent_unknown];
        else if (c.slip != 0)
          tangential = -c.slip * *system_.contact_facts(k).surface.friction * normal;
        column[impulse_offset() + 2 * k] = normal;
        column[impulse_offset() + 2 * k + 1] = tangential;
        if (tangential != 0) integral[friction_loss] -= tangential * c.row.tangent.dot(x.data() + n);
      }
      for (const auto& p : preloaded_)
        if (p.unknown >= 0) integral[friction_loss] -= solution_[p.unknown] * p.rate;
      for (int k = 0; k < states; ++k) column[state_offset() + k] = d.flow[k].slope[s];
      integral[drive] = e.power.drive.slope[s];
      integral[load] = e.power.load.slope[s];
      integral[damping] = -e.power.damping.slope[s];
      for (int k = 0; k < m; ++k) integral[drive] += d.lambda[k] * e_.phi_t[k];
      if (has_films()) integral[film_loss] = film_power.slope[s];
    }
  }
}

}  // namespace freeplay
