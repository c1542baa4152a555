// Derivatives of the right-hand side of the penalty formulation by traced equations
// (dynamics/system_tangent.hpp), including those with respect to the parameters of the directions. The traced
// equations hold the contact forces; the derivatives of these,
//
//     dF_N = F_δ dδ + F_δ̇ dδ̇ + F_v₀ dv₀ + F_m dm + F_p,      dF_T likewise by F_N and v_T,
//
// follow from the laws: F_p by differences of fourth order between the laws of the displaced parameter at the
// nominal depth and rates.
#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "dynamics/system_tangent.hpp"
#include "formulations/penalty/dynamics.hpp"

namespace freeplay {

/// A contact with depth and the derivatives of its forces.
struct PenaltyDynamics::PressedContact {
  int contact = 0;
  ContactRow row;
  double rate = 0, v_t = 0;  ///< m/s, δ̇ and v_T
  double normal = 0, tangential = 0;
  std::array<double, 4> by_state{};  ///< dF_N by δ, δ̇, v₀ and m
  double tangential_by_normal = 0, tangential_by_v_t = 0;
  Vector normal_by_parameter, tangential_by_parameter;  ///< tangential: at constant F_N
};

struct PenaltyDynamics::TracedTangent {
  std::shared_ptr<SystemTangent> equations;
  std::vector<DisplacedLaws> displaced;
  std::vector<SystemTangent::Block> q, v, z;
  SystemTangent::MotionSlopes motion;
  std::vector<PressedContact> pressed;
  std::vector<SystemTangent::ContactSlopes> contacts;  // of the pressed ones
  bool in_force = false;
  /// Of jacobian(): the directions of the inputs and then of time, their part of t, and the columns.
  std::vector<Vector> units, columns;
  Vector times;

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

bool PenaltyDynamics::includes_parameter(std::size_t c) const {
  return traced_ && traced_->in_force && traced_->equations->covers(c);
}

void PenaltyDynamics::use_tangent(std::shared_ptr<SystemTangent> traced,
                                  std::vector<DisplacedLaws> displaced) {
  traced_ = nullptr;
  const auto& contacts = contacts_;
  const auto general = [](const PenaltyContact& c) {
    return c.film || c.shear || c.has_bristle() || c.law.own();
  };
  if (!traced || system_.frictions() > 0 || bristles_ > 0 || std::ranges::any_of(contacts, general)) return;
  using Blocks = std::vector<SystemTangent::Block>;
  const auto n = static_cast<std::size_t>(system_.n()), states = static_cast<std::size_t>(system_.states());
  traced_ = std::make_shared<TracedTangent>();
  traced_->motion = traced->make_slopes();
  traced_->equations = std::move(traced);
  traced_->displaced = std::move(displaced);
  traced_->q = traced_->v = Blocks(n);
  traced_->z = Blocks(states);
  traced_->contacts.resize(contacts.size());
  traced_->pressed.reserve(contacts.size());
}

bool PenaltyDynamics::jacobian_is_traced() const { return traced_ && traced_->in_force; }

void PenaltyDynamics::trace_jacobian(const State& near) {
  use_tangent(SystemTangent::trace(system_, near, {}, SystemTangent::Use::penalty), {});
  if (!traced_) return;
  reserve_jacobian();
  auto& w = *traced_;
  const auto n = static_cast<std::size_t>(system_.n()), states = static_cast<std::size_t>(system_.states()),
             length = static_cast<std::size_t>(size());
  const auto inputs = 2 * n + states;
  w.units.assign(inputs + 1, Vector(length + 2 * contacts_.size()));
  w.columns.assign(inputs + 1, Vector(length));
  w.times.assign(inputs + 1, 0);
  for (std::size_t i = 0; i < inputs; ++i)
    w.units[i][static_cast<std::size_t>(place_of_input(static_cast<int>(i)))] = 1;
  w.times[inputs] = 1;
}

/// jacobian() by the traced equations; J must be zero. False as for differentiate_traced().
bool PenaltyDynamics::traced_jacobian(const Vector& x, double t, double* J, double* dfdt) {
  auto& w = *traced_;
  if (w.units.empty() || !differentiate_traced(x, t, w.units, w.times, w.columns)) return false;
  for (std::size_t i = 0; i + 1 < w.columns.size(); ++i)
    std::ranges::copy(w.columns[i], J + static_cast<long>(size()) * place_of_input(static_cast<int>(i)));
  std::ranges::copy(w.columns.back(), dfdt);
  return true;
}

/// False if the equations have another branch at this state than where they were traced.
bool PenaltyDynamics::differentiate_traced(const Vector& x, double t, std::span<const Vector> directions,
                                           std::span<const double> times, std::span<Vector> out) {
  constexpr int width = TangentTape::width;
  const int n = system_.n(), m = system_.rows(), states = system_.states();
  const int count = static_cast<int>(directions.size());
  auto& d = *tangent_;
  auto& w = *traced_;
  const double *q = x.data(), *v = q + n;
  const auto& e = terms_.e;
  const SystemTangent::Point point{t,
                                   q,
                                   v,
                                   x.data() + state_offset(),
                                   d.acceleration.data(),
                                   lambda_.data(),
                                   e.cosine.data(),
                                   e.sine.data()};
  w.in_force = false;
  if (anchors || !w.equations->begin(point)) return false;
  w.pressed.clear();
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = contacts_[static_cast<std::size_t>(k)];
    if (!c.closed) continue;
    auto& p = w.pressed.emplace_back();
    p.contact = k;
    system_.contact(k, q, v, e, p.row);
    if (!(p.row.gap < 0) && !touching && !c.jumps()) {
      w.pressed.pop_back();
      continue;
    }
    p.rate = -p.row.normal.dot(v);
    Dual<4> delta(std::max(0.0, -p.row.gap)), rate(p.rate), speed(c.v0), mass(c.mass);
    delta.slope[0] = rate.slope[1] = speed.slope[2] = mass.slope[3] = 1;
    if (-p.row.gap < 0) delta.slope[0] = 0;
    const auto elastic = c.law.elastic.force(delta);
    const auto normal = c.force(delta, rate, elastic, speed, mass);
    p.normal = normal.value;
    p.by_state = normal.slope;
    const auto keys = w.displaced.size();
    p.normal_by_parameter.assign(keys, 0);
    p.tangential_by_parameter.assign(keys, 0);
    for (std::size_t i = 0; i < keys; ++i)
      p.normal_by_parameter[i] =
          w.by_parameter(i, c, static_cast<std::size_t>(k), p.normal, [&](const PenaltyContact& law) {
            return law.force_in_piece(delta.value, p.rate, law.law.elastic.force(delta.value), p.normal > 0);
          });
    if (c.rubs()) {
      p.v_t = p.row.tangent.dot(v);
      Dual<4> load(p.normal), slide(p.v_t);
      load.slope[0] = slide.slope[1] = 1;
      const auto tangential = c.tangential_force(load, slide, Dual<4>(0));
      p.tangential = tangential.value;
      p.tangential_by_normal = tangential.slope[0];
      p.tangential_by_v_t = tangential.slope[1];
      for (std::size_t i = 0; i < keys; ++i)
        p.tangential_by_parameter[i] = w.by_parameter(
            i, c, static_cast<std::size_t>(k), p.tangential,
            [&](const PenaltyContact& law) { return law.tangential_force(p.normal, p.v_t, 0.0); });
    }
    if (!w.equations->begin(point, k, {p.normal, p.tangential, 0})) return false;
  }

  SystemTangent::Block time = SystemTangent::Block::Zero();
  for (int first = 0; first < count; first += width) {
    const int some = std::min(width, count - first);
    SystemTangent::gather(directions, first, 0, w.q);
    SystemTangent::gather(directions, first, n, w.v);
    SystemTangent::gather(directions, first, state_offset(), w.z);
    for (int s = 0; s < some; ++s) time[s] = times[first + s];
    const SystemTangent::Directions along{&time, w.q.data(), w.v.data(), w.z.data(),
                                          w.displaced.empty() ? -1 : first};
    w.equations->motion(along, w.motion);
    for (std::size_t i = 0; i < w.pressed.size(); ++i)
      w.equations->contact(w.pressed[i].contact, along, w.motion, w.contacts[i]);
    for (int s = 0; s < some; ++s) {
      const auto c = static_cast<std::size_t>(first) + static_cast<std::size_t>(s);
      const auto& direction = directions[c];
      double* column = out[c].data();
      std::fill(column + impulse_offset(), column + size(), 0.0);
      double* integral = column + integral_offset();
      for (int i = 0; i < n; ++i) d.force[i] = w.motion.force[i][s];
      for (int k = 0; k < m; ++k)
        d.r[k] =
            w.motion.side[k][s] - two_alpha_ * w.motion.rate[k][s] - beta_squared_ * w.motion.place[k][s];
      for (std::size_t i = 0; i < w.pressed.size(); ++i) {
        const auto& p = w.pressed[i];
        const auto& contact = w.contacts[i];
        const int retained = size() + 2 * p.contact;
        const bool varies = c < w.displaced.size();
        const double normal = -p.by_state[0] * contact.gap[s] - p.by_state[1] * contact.rate[s] +
                              p.by_state[2] * direction[retained] + p.by_state[3] * direction[retained + 1] +
                              (varies ? p.normal_by_parameter[c] : 0);
        p.row.normal.add_to(d.force.data(), normal);
        column[impulse_offset() + 2 * p.contact] = normal;
        const auto& law = contacts_[static_cast<std::size_t>(p.contact)];
        if (law.law.dissipates()) integral[contact_work] += normal * p.rate - p.normal * contact.rate[s];
        if (!law.rubs()) continue;
        const double tangential = p.tangential_by_normal * normal + p.tangential_by_v_t * contact.slide[s] +
                                  (varies ? p.tangential_by_parameter[c] : 0);
        p.row.tangent.add_to(d.force.data(), tangential);
        column[impulse_offset() + 2 * p.contact + 1] = tangential;
        integral[friction_loss] -= tangential * p.v_t + p.tangential * contact.slide[s];
      }
      saddle_.solve(d.force.data(), d.r.data(), d.a.data(), d.lambda.data());
      std::copy_n(direction.data() + n, n, column);
      std::ranges::copy(d.a, column + n);
      for (int k = 0; k < states; ++k) column[state_offset() + k] = w.motion.flow[k][s];
      integral[drive] = w.motion.power[SystemTangent::drive][s];
      integral[load] = w.motion.power[SystemTangent::load][s];
      integral[damping] = -w.motion.power[SystemTangent::damping][s];
      for (int k = 0; k < m; ++k) {
        integral[drive] += d.lambda[k] * e.phi_t[k];
        integral[stabilisation] -= d.lambda[k] * terms_.rate[k] + lambda_[k] * w.motion.rate[k][s];
      }
    }
  }
  w.in_force = true;
  return true;
}

}  // namespace freeplay
