// The derivative of a mode's right-hand side, exact to rounding. With
//
//     M a + Gᵀλ − Σ E_r s_r = F,   G a = γ,   W_r a = γ_r,
//
// where E_r = W_N − s μ W_T for sliding contacts and W_r otherwise, the derivatives satisfy
//
//     M da + Gᵀdλ − Σ E_r ds_r = dF − dGᵀλ + Σ dE_r s_r,
//     G da = dγ − dG a,   W_r da = dγ_r − dW_r a,
//
// with the same matrix as the mode. The right-hand sides are those of the traced equations
// (dynamics/system_tangent.hpp), of the laws of films, and of coefficients μ(|u|), whose change is part of
// dE_r. jacobian() takes the unit vectors as directions, directional() any vectors, such as the columns of
// the variational equations (variation.hpp).

#include <algorithm>
#include <array>
#include <utility>

#include "dynamics/system_tangent.hpp"
#include "formulations/contact/film.hpp"
#include "formulations/event_driven/event_dynamics.hpp"

namespace freeplay {

/// A contact with forces.
struct EventDynamics::ActingContact {
  int contact = 0;
  bool closed = false;
  ContactRow row;  ///< of a film
  std::optional<FilmSlopes> film;
};

struct EventDynamics::Tangent {
  std::shared_ptr<SystemTangent> equations;
  /// Whether all laws have derivatives by parameters, and whether the last derivatives include them.
  bool has_parameters = false, with_parameters = false;
  DirectionBlocks blocks;
  UnitDirections units;
  SystemTangent::MotionSlopes motion;
  std::vector<ActingContact> acting;
  std::vector<SystemTangent::ContactSlopes> contacts;  // of the acting ones
  std::vector<SystemTangent::FrictionSlopes> frictions;
  Vector slope, acceleration;
  Vector force, side, rows, a, lambda;  // right-hand sides and solutions of the equations along one direction

  explicit Tangent(const EventDynamics& d)
      : equations(std::make_shared<SystemTangent>(d.system, SystemTangent::Use::modes)),
        blocks(d.system, d.state_offset()),
        units(2 * d.system.n(), d.state_offset(), d.system.states(), d.size()),
        motion(equations->make_slopes()),
        contacts(d.contacts.size()),
        frictions(static_cast<std::size_t>(d.system.frictions())),
        slope(static_cast<std::size_t>(d.size())),
        acceleration(static_cast<std::size_t>(d.system.n())),
        force(acceleration.size()),
        side(static_cast<std::size_t>(d.system.rows())),
        rows(static_cast<std::size_t>(d.rows.most())),
        a(acceleration.size()),
        lambda(side.size()) {
    acting.reserve(contacts.size());
  }
};

void EventDynamics::reserve_jacobian() {
  if (!tangent_) tangent_ = std::make_shared<Tangent>(*this);
}

void EventDynamics::use_tangent(std::shared_ptr<SystemTangent> traced) {
  if (!traced) return;
  reserve_jacobian();
  tangent_->equations = std::move(traced);
  tangent_->has_parameters = !films.any() && system.frictions() == 0;
}

bool EventDynamics::includes_parameter(std::size_t c) const {
  return tangent_ && tangent_->with_parameters && tangent_->equations->covers(c);
}

void EventDynamics::jacobian(const Vector& x, double t, double* J, double* dfdt) {
  reserve_jacobian();
  auto& units = tangent_->units;
  tangent_->with_parameters = false;
  differentiate(x, std::min(t, knot), units.directions, units.times, units.columns);
  units.put(J, dfdt);
}

const EventDynamics::Vector& EventDynamics::directional(const Vector& x, double t,
                                                        std::span<const Vector> directions,
                                                        std::span<Vector> out) {
  reserve_jacobian();
  tangent_->with_parameters = tangent_->has_parameters;
  differentiate(x, std::min(t, knot), directions, {}, out);
  return tangent_->slope;
}

/// Evaluates the equations at a state.
void EventDynamics::begin_tangent(const Vector& x, double t) {
  auto& w = *tangent_;
  rate(x, w.slope, t, false);  // accelerations, multipliers and the matrix of the mode
  ++work.jacobians;
  std::ranges::copy(a, w.acceleration.begin());
  // How the forces of dependent rows are shared depends on parameters, too.
  if (rows.used() > 0 && rows.dependent()) w.with_parameters = false;
  const double *q = x.data(), *v = q + system.n();
  const SystemTangent::Point point{t,
                                   q,
                                   v,
                                   x.data() + state_offset(),
                                   w.acceleration.data(),
                                   lambda.data(),
                                   e.cosine.data(),
                                   e.sine.data(),
                                   phases.pieces()};
  w.equations->begin(point);
  w.acting.clear();
  auto lubricated = films.list().begin();
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& c = contacts[k];
    const auto* law =
        lubricated != films.list().end() && lubricated->contact == k ? &(lubricated++)->law : nullptr;
    if (c.unknown < 0 && !law) continue;
    auto& p = w.acting.emplace_back();
    p.contact = k;
    p.closed = c.unknown >= 0;
    SystemTangent::ContactForce force{c.lambda_n, c.slip == 0 ? c.lambda_t : 0.0,
                                      static_cast<double>(c.slip)};
    // The traced friction in slip has the coefficient μ, and the rest of μ(|u|) is a given force.
    if (const auto& surface = system.contact_facts(k).surface; c.slip != 0 && surface.friction_by_speed())
      force.tangential = c.lambda_t + c.slip * *surface.friction * c.lambda_n;
    if (law) {
      system.contact(k, q, v, e, p.row);
      p.film = film_slopes(*law, v, p.row);
      if (p.film) {
        force.film_normal = p.film->normal.value;
        force.film = p.film->tangential.value;
        force.torque = p.film->torque.value;
      }
    }
    w.equations->begin_contact(point, k, force);
  }
  for (int k = 0; k < system.frictions(); ++k) w.equations->begin_friction(point, k, preloaded[k].lambda);
}

/// Derivatives of dx/dt along `directions` of x and `times` (empty: zeros).
void EventDynamics::differentiate(const Vector& x, double t, std::span<const Vector> directions,
                                  std::span<const double> times, std::span<Vector> out) {
  begin_tangent(x, t);
  auto& w = *tangent_;
  for (int first = 0; first < static_cast<int>(directions.size()); first += TangentTape::width) {
    const int some = w.blocks.take(directions, times, first);
    const auto along = w.blocks.along(w.with_parameters ? first : -1);
    w.equations->motion(along, w.motion);
    for (std::size_t i = 0; i < w.acting.size(); ++i)
      w.equations->contact(w.acting[i].contact, along, w.motion, w.contacts[i]);
    for (int k = 0; k < system.frictions(); ++k)
      w.equations->friction(k, along, w.motion, w.frictions[static_cast<std::size_t>(k)]);
    for (int s = 0; s < some; ++s) {
      double* column = out[first + s].data();
      std::copy_n(directions[first + s].data() + system.n(), system.n(), column);
      respond(x, s, column);
    }
  }
}

/// Change of a sliding contact's friction (N) with μ(|u|) for a change of its sliding speed (m/s).
double EventDynamics::faster(const ActingContact& p, const Vector& x, double slide) const {
  const auto& surface = system.contact_facts(p.contact).surface;
  if (!surface.friction_by_speed()) return 0;
  const auto& c = contacts[p.contact];
  return -c.slip * c.lambda_n * surface.friction_slope(c.row.tangent.dot(x.data() + system.n())) * slide;
}

/// Solves for the derivatives of accelerations and multipliers along entry s of the block, and fills a
/// column of dx/dt but for its rates.
void EventDynamics::respond(const Vector& x, int s, double* column) {
  const int n = system.n(), m = system.rows(), used = rows.used();
  auto& w = *tangent_;
  double* integral = column + integral_offset();
  std::fill(column + impulse_offset(), column + size(), 0.0);
  for (int i = 0; i < n; ++i) w.force[i] = w.motion.force[i][s];
  for (int k = 0; k < m; ++k) w.side[k] = w.motion.side[k][s];
  for (std::size_t i = 0; i < w.acting.size(); ++i) {
    const auto& p = w.acting[i];
    const auto& by = w.contacts[i];
    if (p.film) {
      const std::array change{by.gap[s], by.rate[s], by.film[s], by.spin[s]};
      p.row.normal.add_to(w.force.data(), p.film->normal.along(change));
      p.row.film.add_to(w.force.data(), p.film->tangential.along(change));
      p.row.spin.add_to(w.force.data(), p.film->torque.along(change));
      integral[film_loss] += p.film->loss.along(change);
    }
    if (!p.closed) continue;
    const auto& c = contacts[p.contact];
    w.rows[c.unknown] = by.side[0][s];
    if (const double change = faster(p, x, by.slide[s]); change != 0)
      c.row.tangent.add_to(w.force.data(), change);
    if (c.tangent_unknown >= 0) w.rows[c.tangent_unknown] = by.side[1][s];
  }
  for (int k = 0; k < system.frictions(); ++k) {
    const auto& p = preloaded[k];
    const auto& by = w.frictions[static_cast<std::size_t>(k)];
    if (p.unknown >= 0) w.rows[p.unknown] = by.side[s];
    integral[friction_loss] -= p.lambda * by.slide[s];
  }
  saddle.solve(w.force.data(), w.side.data(), w.a.data(), w.lambda.data());
  if (used > 0) {
    for (int r = 0; r < used; ++r) rows.b[r] = w.rows[r] - rows.row(r).dot(w.a.data());
    rows.solve();
    rows.apply(w.a.data(), w.lambda.data());
  }
  std::ranges::copy(w.a, column + n);
  for (std::size_t i = 0; i < w.acting.size(); ++i) {
    if (!w.acting[i].closed) continue;
    const auto& c = contacts[w.acting[i].contact];
    double* impulse = column + impulse_offset() + 2 * w.acting[i].contact;
    impulse[0] = rows.x[c.unknown];
    if (c.tangent_unknown >= 0)
      impulse[1] = rows.x[c.tangent_unknown];
    else if (c.slip != 0)
      impulse[1] = w.contacts[i].friction[s] + faster(w.acting[i], x, w.contacts[i].slide[s]) -
                   c.slip * friction_of(w.acting[i].contact, x.data() + n) * impulse[0];
    if (c.row.tangent.size > 0)
      integral[friction_loss] -=
          impulse[1] * c.row.tangent.dot(x.data() + n) + c.lambda_t * w.contacts[i].slide[s];
  }
  for (const auto& p : preloaded)
    if (p.unknown >= 0) integral[friction_loss] -= rows.x[p.unknown] * p.rate;
  for (int k = 0; k < system.states(); ++k) column[state_offset() + k] = w.motion.flow[k][s];
  integral[drive] = w.motion.power[SystemTangent::drive][s];
  integral[load] = w.motion.power[SystemTangent::load][s];
  integral[damping] = -w.motion.power[SystemTangent::damping][s];
  for (int k = 0; k < m; ++k) integral[drive] += w.lambda[k] * e.phi_t[k];
}

}  // namespace freeplay
