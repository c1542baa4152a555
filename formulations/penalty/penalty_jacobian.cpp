// Derivatives of the right-hand side of the penalty formulation, exact to rounding, by the traced equations
// (dynamics/system_tangent.hpp). jacobian() takes the unit vectors as directions, directional() any vectors,
// such as the columns of the variational equations (penalty_variation.hpp). The traced equations hold the
// forces of contacts, films and joint friction; the derivatives of these follow from their laws, such as
//
//     dF_N = F_δ dδ + F_δ̇ dδ̇ + F_v₀ dv₀ + F_m dm + F_p,      dF_T likewise by F_N, v_T and the bristle,
//
// with F_p by differences of fourth order between the laws of the displaced parameter at the nominal depth
// and rates.

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "dynamics/system_tangent.hpp"
#include "formulations/penalty/dynamics.hpp"
#include "numerics/dual.hpp"

namespace freeplay {

/// A contact with forces.
struct PenaltyDynamics::ActingContact {
  int contact = 0;
  const ContactRow* row = nullptr;
  bool pressed = false;
  double rate = 0, v_t = 0;  ///< m/s, δ̇ and v_T
  Dual<4> normal = {};       ///< by δ, δ̇, v₀ and m
  Dual<3> tangential = {};   ///< by F_N, v_T and the bristle
  Dual<4> bristle = {};      ///< rate of the bristle, by δ, δ̇, v_T and the bristle
  std::optional<FilmSlopes> film = {};
  Vector normal_by_parameter = {}, tangential_by_parameter = {};  ///< tangential: at constant F_N
};

/// A joint with friction.
struct PenaltyDynamics::RubbingJoint {
  SparseRow row;
  double u = 0, force = 0, by_u = 0;  ///< m/s, N, and the derivative at a constant reaction
};

struct PenaltyDynamics::Tangent {
  std::shared_ptr<SystemTangent> equations;
  /// Whether all laws have derivatives by parameters, and whether the last derivatives include them.
  bool has_parameters = false, with_parameters = false;
  std::vector<DisplacedLaws> displaced;
  DirectionBlocks blocks;
  UnitDirections units;
  SystemTangent::MotionSlopes motion;
  std::vector<ActingContact> acting;
  std::vector<SystemTangent::ContactSlopes> contacts;  // of the acting ones
  std::vector<RubbingJoint> joints;
  std::vector<SystemTangent::FrictionSlopes> frictions;
  Vector slope, force, r, a, lambda, acceleration, friction;

  explicit Tangent(const PenaltyDynamics& d)
      : equations(std::make_shared<SystemTangent>(d.system_, SystemTangent::Use::penalty)),
        blocks(d.system_, d.state_offset()),
        units(2 * d.system_.n(), d.bristle_offset(), d.bristles_ + d.system_.states(), d.size(),
              2 * d.system_.contacts()),
        motion(equations->make_slopes()),
        contacts(d.contacts_.size()),
        joints(static_cast<std::size_t>(d.system_.frictions())),
        frictions(joints.size()),
        slope(static_cast<std::size_t>(d.size())),
        force(static_cast<std::size_t>(d.system_.n())),
        r(static_cast<std::size_t>(d.system_.rows())),
        a(force.size()),
        lambda(r.size()),
        acceleration(a.size()),
        friction(static_cast<std::size_t>(d.friction_.laws.size())) {
    acting.reserve(contacts.size());
  }
  /// A law at the nominal state, by the parameter c; `value` evaluates it for a contact. Zero if it does not
  /// depend on c.
  double by_parameter(std::size_t c, const PenaltyContact& nominal, std::size_t k, double now,
                      auto value) const {
    const auto& laws = displaced[c];
    if (!laws.at[0]) return 0;
    std::array<double, 4> f{};
    for (const std::size_t i : {2U, 1U, 0U, 3U}) {
      auto& contact = laws.at[i]->contacts()[k];
      contact.mode() = nominal.mode();
      f[i] = value(contact);
      if (i == 2 && f[i] == now) return 0;
    }
    return (8 * (f[2] - f[1]) - (f[3] - f[0])) / (12 * laws.spacing);
  }
};

void PenaltyDynamics::reserve_jacobian() {
  if (!tangent_) tangent_ = std::make_shared<Tangent>(*this);
}

void PenaltyDynamics::trace_jacobian(const State& near) {
  reserve_jacobian();
  tangent_->equations->prepare(near);
}

void PenaltyDynamics::use_tangent(std::shared_ptr<SystemTangent> traced,
                                  std::vector<DisplacedLaws> displaced) {
  if (!traced) return;
  reserve_jacobian();
  const auto history = [](const PenaltyContact& c) {
    return c.film || c.shear || c.has_bristle() || c.law.own();
  };
  tangent_->equations = std::move(traced);
  tangent_->has_parameters = system_.frictions() == 0 && std::ranges::none_of(contacts_, history);
  tangent_->displaced = std::move(displaced);
}

bool PenaltyDynamics::includes_parameter(std::size_t c) const {
  return tangent_ && tangent_->with_parameters && tangent_->equations->covers(c);
}

void PenaltyDynamics::jacobian(const Vector& x, double t, double* J, double* dfdt) {
  reserve_jacobian();
  auto& units = tangent_->units;
  tangent_->with_parameters = false;
  differentiate(x, std::min(t, knot), units.directions, units.times, units.columns);
  units.put(J, dfdt);
}

const PenaltyDynamics::Vector& PenaltyDynamics::directional(const Vector& x, double t,
                                                            std::span<const Vector> directions,
                                                            std::span<const double> times,
                                                            std::span<Vector> out) {
  reserve_jacobian();
  tangent_->with_parameters = tangent_->has_parameters;
  differentiate(x, std::min(t, knot), directions, times, out);
  return tangent_->slope;
}

void PenaltyDynamics::anchor(const Vector& x, double t, std::vector<ContactAnchor>& out) {
  const double* v = x.data() + system_.n();
  out.assign(contacts_.size(), {});
  const Evaluation* at = nullptr;
  ContactRow row;
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = contacts_[k];
    if (!c.closed) continue;
    if (!at) at = &contact_rows.placed(x, std::min(t, knot));
    system_.contact(k, x.data(), v, *at, row);
    ActingContact p{k, &row, row.gap < 0 || touching || c.jumps()};
    p.rate = -row.normal.dot(v);
    if (p.pressed) press(p, bristles_ ? x[bristle_offset() + k] : 0, v, 0);
    const double delta = std::max(0.0, -row.gap);
    out[static_cast<std::size_t>(k)] = {p.pressed,
                                        delta,
                                        p.rate,
                                        p.v_t,
                                        p.normal.value,
                                        p.normal.slope[0],
                                        p.normal.slope[1],
                                        p.tangential.slope[0],
                                        p.tangential.slope[1],
                                        p.bristle.slope[2],
                                        c.law.elastic.force(delta)};
  }
}

/// Evaluates the equations and the laws at a state, with the derivatives of the laws.
void PenaltyDynamics::begin_tangent(const Vector& x, double t) {
  auto& w = *tangent_;
  (*this)(x, w.slope, t);  // computes a and λ and factorises the matrix of their equations
  ++work.jacobians;
  std::copy_n(w.slope.begin() + system_.n(), system_.n(), w.acceleration.begin());
  if (friction_.laws.size() > 0) friction_.laws.prepare_follow();
  const double *q = x.data(), *v = q + system_.n();
  const auto& e = terms_.e;
  const SystemTangent::Point point{t,
                                   q,
                                   v,
                                   x.data() + state_offset(),
                                   w.acceleration.data(),
                                   lambda_.data(),
                                   e.cosine.data(),
                                   e.sine.data(),
                                   phases.pieces()};
  w.equations->begin(point);
  w.acting.clear();
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = contacts_[static_cast<std::size_t>(k)];
    if (!c.closed && !c.film) continue;
    const auto& row = terms_.rows[static_cast<std::size_t>(k)];
    ActingContact p{k, &row, c.closed && (row.gap < 0 || touching || c.jumps())};
    p.rate = -row.normal.dot(v);
    SystemTangent::ContactForce force;
    if (c.film) {
      p.film = film_slopes(*c.film, v, row);
      if (p.film) {
        force.film_normal = p.film->normal.value;
        force.film = p.film->tangential.value;
        force.torque = p.film->torque.value;
      }
    }
    if (!p.pressed && !p.film) continue;
    if (p.pressed)
      press(p, bristles_ ? x[bristle_offset() + k] : 0, v, w.with_parameters ? w.displaced.size() : 0);
    force.normal = p.normal.value;
    force.tangential = p.tangential.value;
    w.equations->begin_contact(point, k, force);
    w.acting.push_back(std::move(p));
  }
  for (int k = 0, reactive = 0; k < system_.frictions(); ++k) {
    const auto& facts = system_.friction_facts(k);
    auto& joint = w.joints[static_cast<std::size_t>(k)];
    Dual<1> u, force;
    u.slope[0] = 1;
    system_.friction(k, q, v, e, joint.row);
    joint.u = u.value = joint.row.dot(v);
    if (facts.reaction)
      force = friction_.laws.support(reactive++) * preloaded_friction(1, *facts.regularisation, u) *
              facts.reaction->coefficient(u);
    else
      force = preloaded_friction(facts.bound, *facts.regularisation, u);
    joint.force = force.value;
    joint.by_u = force.slope[0];
    w.equations->begin_friction(point, k, joint.force);
  }
}

/// Evaluates the laws of a pressed contact, with its bristle z and for some parameters.
void PenaltyDynamics::press(ActingContact& p, double z, const double* v, std::size_t parameters) const {
  const auto& c = contacts_[static_cast<std::size_t>(p.contact)];
  const auto k = static_cast<std::size_t>(p.contact);
  const auto of = directions_of<4>({std::max(0.0, -p.row->gap), p.rate, c.v0, c.mass});
  const auto &delta = of[0], &rate = of[1], &speed = of[2], &mass = of[3];
  p.normal = c.force(delta, rate, c.law.elastic.force(delta), speed, mass);
  p.normal_by_parameter.assign(parameters, 0);
  p.tangential_by_parameter.assign(parameters, 0);
  for (std::size_t i = 0; i < parameters; ++i)
    p.normal_by_parameter[i] =
        tangent_->by_parameter(i, c, k, p.normal.value, [&](const PenaltyContact& law) {
          return law.force_in_piece(delta.value, p.rate, law.law.elastic.force(delta.value),
                                    p.normal.value > 0);
        });
  if (!c.rubs()) return;
  p.v_t = p.row->tangent.dot(v);
  const auto slide = directions_of<3>({p.normal.value, p.v_t, z});
  p.tangential = c.tangential_force(slide[0], slide[1], slide[2]);
  for (std::size_t i = 0; i < parameters; ++i)
    p.tangential_by_parameter[i] = tangent_->by_parameter(
        i, c, k, p.tangential.value,
        [&](const PenaltyContact& law) { return law.tangential_force(p.normal.value, p.v_t, 0.0); });
  if (bristles_ == 0) return;
  const auto y = directions_of<4>({delta.value, p.rate, p.v_t, z});
  p.bristle = c.bristle_rate(y[0], y[1], c.law.elastic.force(y[0]), y[2], y[3]);
}

/// Derivatives of dx/dt along `directions` of the extended state and `times`.
void PenaltyDynamics::differentiate(const Vector& x, double t, std::span<const Vector> directions,
                                    std::span<const double> times, std::span<Vector> out) {
  begin_tangent(x, t);
  const int n = system_.n(), m = system_.rows(), states = system_.states();
  auto& w = *tangent_;
  const auto& e = terms_.e;
  for (int first = 0; first < static_cast<int>(directions.size()); first += TangentTape::width) {
    const int some = w.blocks.take(directions, times, first);
    const auto along_block = w.blocks.along(w.with_parameters ? first : -1);
    w.equations->motion(along_block, w.motion);
    for (std::size_t i = 0; i < w.acting.size(); ++i)
      w.equations->contact(w.acting[i].contact, along_block, w.motion, w.contacts[i]);
    for (std::size_t k = 0; k < w.joints.size(); ++k)
      w.equations->friction(static_cast<int>(k), along_block, w.motion, w.frictions[k]);
    for (int s = 0; s < some; ++s) {
      const auto c = static_cast<std::size_t>(first) + static_cast<std::size_t>(s);
      const auto& direction = directions[c];
      double* column = out[c].data();
      std::fill(column + impulse_offset(), column + size(), 0.0);
      double* integral = column + integral_offset();
      for (int i = 0; i < n; ++i) w.force[i] = w.motion.force[i][s];
      for (int k = 0; k < m; ++k)
        w.r[k] = w.motion.side[k][s] - baumgarte_.two_alpha * w.motion.rate[k][s] -
                 baumgarte_.beta_squared * w.motion.place[k][s];
      for (std::size_t i = 0; i < w.acting.size(); ++i) add_contact(i, s, c, direction, column);
      for (std::size_t k = 0; k < w.joints.size(); ++k) {
        const auto& joint = w.joints[k];
        const double slide = w.frictions[k].slide[s], change = joint.by_u * slide;
        joint.row.add_to(w.force.data(), change);
        integral[friction_loss] -= change * joint.u + joint.force * slide;
      }
      saddle_.solve(w.force.data(), w.r.data(), w.a.data(), w.lambda.data());
      // The part due to the change of the reactions that bound friction.
      if (friction_.laws.size() > 0) friction_.laws.follow(w.lambda.data(), w.friction.data());
      for (int k = 0; k < friction_.laws.size(); ++k) {
        const double df = w.friction[k];
        for (int i = 0; i < n; ++i) w.a[i] += df * friction_.response[k][i];
        for (int i = 0; i < m; ++i) w.lambda[i] += df * friction_.reaction[k][i];
        integral[friction_loss] -= df * terms_.coupled[static_cast<std::size_t>(k)].u;
      }
      std::copy_n(direction.data() + n, n, column);
      std::ranges::copy(w.a, column + n);
      for (int k = 0; k < states; ++k) column[state_offset() + k] = w.motion.flow[k][s];
      integral[drive] = w.motion.power[SystemTangent::drive][s];
      integral[load] = w.motion.power[SystemTangent::load][s];
      integral[damping] = -w.motion.power[SystemTangent::damping][s];
      for (int k = 0; k < m; ++k) {
        integral[drive] += w.lambda[k] * e.phi_t[k];
        integral[stabilisation] -= w.lambda[k] * terms_.rate[k] + lambda_[k] * w.motion.rate[k][s];
      }
    }
  }
}

/// Adds the derivatives of the forces of an acting contact along direction c, entry s of its block, to the
/// forces and to the column.
void PenaltyDynamics::add_contact(std::size_t acting, int s, std::size_t c, const Vector& direction,
                                  double* column) const {
  auto& w = *tangent_;
  const auto& p = w.acting[acting];
  const auto& by = w.contacts[acting];
  double* integral = column + integral_offset();
  if (p.film) {
    const std::array change{by.gap[s], by.rate[s], by.film[s], by.spin[s]};
    p.row->normal.add_to(w.force.data(), p.film->normal.along(change));
    p.row->film.add_to(w.force.data(), p.film->tangential.along(change));
    p.row->spin.add_to(w.force.data(), p.film->torque.along(change));
    integral[film_loss] += p.film->loss.along(change);
  }
  if (!p.pressed) return;
  const auto& contact = contacts_[static_cast<std::size_t>(p.contact)];
  const int retained = size() + 2 * p.contact;
  const bool varies = c < p.normal_by_parameter.size() && w.equations->covers(c);
  const double deeper = p.row->gap > 0 ? 0 : -by.gap[s];
  double normal = p.normal.along({deeper, -by.rate[s], direction[retained], direction[retained + 1]});
  if (varies) normal += p.normal_by_parameter[c];
  p.row->normal.add_to(w.force.data(), normal);
  column[impulse_offset() + 2 * p.contact] = normal;
  if (contact.law.dissipates()) integral[contact_work] += normal * p.rate - p.normal.value * by.rate[s];
  if (!contact.rubs()) return;
  const double z = bristles_ ? direction[bristle_offset() + p.contact] : 0;
  double tangential = p.tangential.along({normal, by.slide[s], z});
  if (varies) tangential += p.tangential_by_parameter[c];
  p.row->tangent.add_to(w.force.data(), tangential);
  column[impulse_offset() + 2 * p.contact + 1] = tangential;
  integral[friction_loss] -= tangential * p.v_t + p.tangential.value * by.slide[s];
  if (bristles_)
    column[bristle_offset() + p.contact] = p.bristle.along({deeper, -by.rate[s], by.slide[s], z});
}

}  // namespace freeplay
