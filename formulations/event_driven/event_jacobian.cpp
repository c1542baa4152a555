// The derivative of a mode's right-hand side, exact to rounding. With
//
//     M a + Gᵀλ − Σ E_r s_r = F,   G a = γ,   W_r a = γ_r,
//
// where E_r = W_N − s μ W_T for sliding contacts and W_r otherwise, the derivatives satisfy
//
//     M da + Gᵀdλ − Σ E_r ds_r = dF − dGᵀλ + Σ dE_r s_r,
//     G da = dγ − dG a,   W_r da = dγ_r − dW_r a,
//
// with the same matrix as the mode. jacobian() takes the unit vectors as directions, directional()
// any vectors, such as the columns of the variational equations (variation.hpp).

#include "formulations/event_driven/event_jacobian.hpp"

#include <algorithm>
#include <utility>

#include "dynamics/system_tangent.hpp"
#include "formulations/contact/film.hpp"

namespace freeplay {

/// The derivative of a mode's right-hand side along several directions by traced equations
/// (dynamics/system_tangent.hpp). It includes derivatives with respect to the parameters of the directions.
struct EventDynamics::TracedTangent {
  using Block = SystemTangent::Block;
  std::vector<Block> q, v, z;
  SystemTangent::MotionSlopes motion;
  std::vector<SystemTangent::ContactSlopes> contacts;
};

void EventDynamics::use_tangent(std::shared_ptr<SystemTangent> traced) {
  traced_ = nullptr;
  along_traced_ = false;
  // Forces of films and of joint friction are not traced.
  if (!traced || films.any() || system.frictions() > 0) return;
  traced_ = std::move(traced);
  const auto n = static_cast<std::size_t>(system.n()), states = static_cast<std::size_t>(system.states());
  using Blocks = std::vector<SystemTangent::Block>;
  traced_room_ = std::make_shared<TracedTangent>(
      TracedTangent{Blocks(n), Blocks(n), Blocks(states), traced_->make_slopes(),
                    std::vector<SystemTangent::ContactSlopes>(contacts.size())});
}

bool EventDynamics::includes_parameter(std::size_t c) const { return along_traced_ && traced_->covers(c); }

/// False if the equations have another branch at this state than where they were traced, or if the forces of
/// dependent rows are shared: how they are shared depends on parameters, too.
bool EventDynamics::differentiate_traced(const Vector& x, double t, std::span<const Vector> directions,
                                         std::span<Vector> out) {
  constexpr int width = TangentTape::width;
  const int n = system.n(), m = system.rows(), states = system.states(), used = rows.used();
  const int count = static_cast<int>(directions.size());
  if (used > 0 && rows.dependent()) return false;
  auto& d = *tangent_;
  auto& w = *traced_room_;
  const SystemTangent::Point point{t,
                                   x.data(),
                                   x.data() + n,
                                   x.data() + state_offset(),
                                   d.acceleration.data(),
                                   lambda.data(),
                                   e.cosine.data(),
                                   e.sine.data()};
  if (!traced_->begin(point)) return false;
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& c = contacts[k];
    if (c.unknown < 0) continue;
    if (!traced_->begin(point, k, {c.lambda_n, c.slip == 0 ? c.lambda_t : 0.0, static_cast<double>(c.slip)}))
      return false;
  }
  const SystemTangent::Block still = SystemTangent::Block::Zero();
  for (int first = 0; first < count; first += width) {
    const int some = std::min(width, count - first);
    SystemTangent::gather(directions, first, 0, w.q);
    SystemTangent::gather(directions, first, n, w.v);
    SystemTangent::gather(directions, first, state_offset(), w.z);
    const SystemTangent::Directions along{&still, w.q.data(), w.v.data(), w.z.data(), first};
    traced_->motion(along, w.motion);
    for (int k = 0; k < system.contacts(); ++k)
      if (contacts[k].unknown >= 0) traced_->contact(k, along, w.motion, w.contacts[k]);
    auto& slopes = d.slopes;
    for (int s = 0; s < some; ++s) {
      for (int i = 0; i < n; ++i) slopes.force[i] = w.motion.force[i][s];
      for (int k = 0; k < m; ++k) slopes.side[k] = w.motion.side[k][s];
      for (int k = 0; k < states; ++k) slopes.flow[k] = w.motion.flow[k][s];
      slopes.drive = w.motion.power[SystemTangent::drive][s];
      slopes.load = w.motion.power[SystemTangent::load][s];
      slopes.damping = w.motion.power[SystemTangent::damping][s];
      slopes.friction_power = 0;
      for (int k = 0; k < system.contacts() && used > 0; ++k) {
        const auto& c = contacts[k];
        if (c.unknown < 0) continue;
        const auto& contact = w.contacts[k];
        slopes.rows[c.unknown] = contact.side[0][s];
        if (c.tangent_unknown >= 0) slopes.rows[c.tangent_unknown] = contact.side[1][s];
        slopes.friction[k] = contact.friction[s];
        slopes.friction_power -= c.lambda_t * contact.slide[s];
      }
      double* column = out[first + s].data();
      std::copy_n(directions[first + s].data() + n, n, column);
      respond(x, slopes, column);
    }
  }
  std::ranges::fill(d.slopes.friction, 0.0);
  return true;
}

void EventDynamics::reserve_jacobian() {
  if (tangent_) return;
  const auto n = static_cast<std::size_t>(system.n()), m = static_cast<std::size_t>(system.rows()),
             states = static_cast<std::size_t>(system.states());
  tangent_ = std::make_shared<Tangent>();
  auto& d = *tangent_;
  d.e = system.make_evaluation<Gradient>();
  d.state.resize(2 * n + states);
  d.reaction.resize(n);
  d.flow.resize(states);
  d.sigma.resize(static_cast<std::size_t>(rows.most()));
  d.r.resize(m);
  d.slope.resize(static_cast<std::size_t>(size()));
  for (auto* x : {&d.acceleration, &d.slopes.force, &d.a}) x->resize(n);
  for (auto* x : {&d.slopes.side, &d.lambda}) x->resize(m);
  d.slopes.flow.resize(states);
  d.slopes.rows.resize(static_cast<std::size_t>(rows.most()));
  d.slopes.friction.assign(contacts.size(), 0);
}

void EventDynamics::begin_tangent(const Vector& x, double t) {
  reserve_jacobian();
  auto& d = *tangent_;
  rate(x, d.slope, t, false);  // accelerations, multipliers and the matrix of the mode
  ++work.jacobians;
  std::ranges::copy(a, d.acceleration.begin());
}

void EventDynamics::jacobian(const Vector& x, double t, double* J, double* dfdt) {
  constexpr int chunk = tangent_directions;
  const int n = system.n(), N = size(), states = system.states();
  begin_tangent(x, t);
  auto& d = *tangent_;
  std::fill(J, J + static_cast<long>(N) * N, 0.0);
  std::fill(dfdt, dfdt + N, 0.0);
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
    std::array<double*, tangent_directions> columns{};
    for (int s = 0; s < directions; ++s)
      columns[s] = first + s == inputs ? dfdt : J + static_cast<long>(N) * place_of(first + s);
    differentiate(x, time, directions, columns.data());
  }
}

const EventDynamics::Vector& EventDynamics::directional(const Vector& x, double t,
                                                        std::span<const Vector> directions,
                                                        std::span<Vector> out) {
  constexpr int chunk = tangent_directions;
  t = std::min(t, knot);
  const int n = system.n(), states = system.states(), count = static_cast<int>(directions.size());
  begin_tangent(x, t);
  auto& d = *tangent_;
  along_traced_ = traced_ && differentiate_traced(x, t, directions, out);
  if (along_traced_) return d.slope;
  for (int first = 0; first < count; first += chunk) {
    const int some = std::min(chunk, count - first);
    const auto seed = [&](Gradient& y, int place) {
      y = x[place];
      for (int s = 0; s < some; ++s) y.slope[s] = directions[first + s][place];
    };
    for (int i = 0; i < 2 * n; ++i) seed(d.state[i], i);
    for (int k = 0; k < states; ++k) seed(d.state[2 * n + k], state_offset() + k);
    std::array<double*, tangent_directions> columns{};
    for (int s = 0; s < some; ++s) columns[s] = out[first + s].data();
    differentiate(x, t, some, columns.data());
  }
  return d.slope;
}

/// Derivatives of dx/dt in the directions that the tangent's state and the time have.
void EventDynamics::differentiate(const Vector& x, const Gradient& time, int directions,
                                  double* const* columns) {
  const int n = system.n(), m = system.rows(), states = system.states(), used = rows.used();
  auto& d = *tangent_;
  const double* held = d.acceleration.data();
  const Gradient *q = d.state.data(), *v = q + n, *z = v + n;
  auto& de = d.e;
  system.place(time, q, de, phases.pieces());
  system.rate(q, v, de);
  system.forces(time, q, v, z, de, {nullptr, phases.pieces()});
  system.flow(time, q, v, z, d.flow.data(), {nullptr, phases.pieces()});
  Gradient friction_power = 0, film_power = 0;
  const auto take = [&](int active, const SparseRowOf<Gradient>& row, const Gradient& gamma) {
    Gradient rest = gamma;
    for (int i = 0; i < row.size; ++i) rest -= row.value[i] * held[row.column[i]];
    d.sigma[active] = rest;
  };
  for (int k = 0; k < system.frictions(); ++k) {
    const auto& p = preloaded[k];
    const Gradient gamma = system.friction(k, q, v, de, d.slide);
    d.slide.add_to(de.force.data(), p.lambda);
    if (p.unknown >= 0) take(p.unknown, d.slide, gamma);
    friction_power -= p.lambda * d.slide.dot(v);
  }
  for (const auto& f : films.list()) {
    system.contact(f.contact, q, v, de, d.row);
    const auto film = film_action(f.law, v, d.row);
    if (!film) continue;
    d.row.normal.add_to(de.force.data(), film->normal);
    d.row.film.add_to(de.force.data(), film->tangential);
    d.row.spin.add_to(de.force.data(), film->torque);
    film_power += film->loss;
  }
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& c = contacts[k];
    if (c.unknown < 0) continue;
    system.contact(k, q, v, de, d.row);
    d.row.normal.add_to(de.force.data(), c.lambda_n);
    if (c.row.tangent.size > 0) d.row.tangent.add_to(de.force.data(), c.lambda_t);
    take(c.unknown, d.row.normal, d.row.gamma_n);
    if (c.tangent_unknown >= 0) take(c.tangent_unknown, d.row.tangent, d.row.gamma_t);
    if (c.lambda_t != 0) friction_power -= c.lambda_t * d.row.tangent.dot(v);
  }
  for (int i = 0; i < n; ++i) d.reaction[i] = 0;
  add_transposed(system.pattern(), de.G.data(), lambda.data(), d.reaction.data());
  for (int i = 0; i < n; ++i) d.reaction[i] = de.force[i] - d.reaction[i];
  for (int k = 0; k < m; ++k) {
    d.r[k] = de.gamma[k];
    for (int s = system.pattern().begin[k]; s < system.pattern().begin[k + 1]; ++s)
      d.r[k] -= de.G[s] * held[system.pattern().column[s]];
  }

  auto& slopes = d.slopes;
  for (int s = 0; s < directions; ++s) {
    for (int i = 0; i < n; ++i) slopes.force[i] = d.reaction[i].slope[s];
    for (int k = 0; k < m; ++k) slopes.side[k] = d.r[k].slope[s];
    for (int r = 0; r < used; ++r) slopes.rows[r] = d.sigma[r].slope[s];
    for (int k = 0; k < states; ++k) slopes.flow[k] = d.flow[k].slope[s];
    slopes.drive = de.power.drive.slope[s];
    for (int k = 0; k < m; ++k) slopes.drive += lambda[k] * de.phi_t[k].slope[s];
    slopes.load = de.power.load.slope[s];
    slopes.damping = de.power.damping.slope[s];
    slopes.friction_power = friction_power.slope[s];
    slopes.film_power = film_power.slope[s];
    for (int i = 0; i < n; ++i) columns[s][i] = d.state[n + i].slope[s];
    respond(x, slopes, columns[s]);
  }
}

/// Solves for the derivatives of accelerations and multipliers, and fills a column of dx/dt but for its
/// rates.
void EventDynamics::respond(const Vector& x, const Slopes& slopes, double* column) {
  const int n = system.n(), m = system.rows(), states = system.states(), used = rows.used();
  auto& d = *tangent_;
  saddle.solve(slopes.force.data(), slopes.side.data(), d.a.data(), d.lambda.data());
  if (used > 0) {
    for (int r = 0; r < used; ++r) rows.b[r] = slopes.rows[r] - rows.row(r).dot(d.a.data());
    rows.solve();
    rows.apply(d.a.data(), d.lambda.data());
  }
  std::ranges::copy(d.a, column + n);
  double* integral = column + integral_offset();
  integral[friction_loss] = slopes.friction_power;
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& c = contacts[k];
    double normal = 0, tangential = 0;
    if (c.unknown >= 0) normal = rows.x[c.unknown];
    if (c.tangent_unknown >= 0)
      tangential = rows.x[c.tangent_unknown];
    else if (c.unknown >= 0 && c.slip != 0)
      tangential = slopes.friction[k] - c.slip * *system.contact_facts(k).surface.friction * normal;
    column[impulse_offset() + 2 * k] = normal;
    column[impulse_offset() + 2 * k + 1] = tangential;
    if (tangential != 0) integral[friction_loss] -= tangential * c.row.tangent.dot(x.data() + n);
  }
  for (const auto& p : preloaded)
    if (p.unknown >= 0) integral[friction_loss] -= rows.x[p.unknown] * p.rate;
  for (int k = 0; k < states; ++k) column[state_offset() + k] = slopes.flow[k];
  integral[drive] = slopes.drive;
  integral[load] = slopes.load;
  integral[damping] = -slopes.damping;
  for (int k = 0; k < m; ++k) integral[drive] += d.lambda[k] * e.phi_t[k];
  if (films.any()) integral[film_loss] = slopes.film_power;
}

}  // namespace freeplay
