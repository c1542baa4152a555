// Derivatives of the right-hand side of the penalty formulation, exact to rounding. jacobian() takes the
// unit vectors as directions, directional() any vectors, such as the columns of the variational equations
// (penalty_variation.hpp).

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "dynamics/system_tangent.hpp"
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
                                                 Vector(static_cast<std::size_t>(friction_.laws.size()))});
}

void PenaltyDynamics::begin_tangent(const Vector& x, double t) {
  reserve_jacobian();
  auto& d = *tangent_;
  (*this)(x, d.slope, t);  // computes a and λ and factorises the matrix of their equations
  ++work.jacobians;
  std::copy_n(d.slope.begin() + system_.n(), system_.n(), d.acceleration.begin());
  if (friction_.laws.size() > 0) friction_.laws.prepare_follow();
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
  for (int k = 0; k < friction_.laws.size(); ++k) {
    auto& c = terms.coupled[static_cast<std::size_t>(k)];
    c.factor = -friction_.laws.support(k) * c.factor;  // now the force
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
    if (friction_.laws.size() > 0) friction_.laws.follow(d.lambda.data(), d.friction.data());
    for (int k = 0; k < friction_.laws.size(); ++k) {
      const auto& c = terms.coupled[static_cast<std::size_t>(k)];
      const double df = d.friction[k];
      for (int i = 0; i < n; ++i) d.a[i] += df * friction_.response[k][i];
      for (int i = 0; i < m; ++i) d.lambda[i] += df * friction_.reaction[k][i];
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
  ContactRow row;
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = contacts_[k];
    if (!c.closed) continue;
    if (!at) at = &contact_rows.placed(x, std::min(t, knot));
    system_.contact(k, x.data(), v, *at, row);
    auto& a = out[static_cast<std::size_t>(k)];
    a.pressed = row.gap < 0 || touching || c.jumps();
    a.delta = std::max(0.0, -row.gap);
    a.rate = -row.normal.dot(v);
    a.elastic = c.law.elastic.force(a.delta);
    if (!a.pressed) continue;
    Dual<2> delta(a.delta), rate(a.rate);
    delta.slope[0] = rate.slope[1] = 1;
    const auto normal = c.force(delta, rate, c.law.elastic.force(delta));
    a.normal = normal.value;
    a.normal_by_delta = normal.slope[0];
    a.normal_by_rate = normal.slope[1];
    if (!c.rubs()) continue;
    a.v_t = row.tangent.dot(v);
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

// Derivatives of the right-hand side of the penalty formulation by traced equations
// (dynamics/system_tangent.hpp), including those with respect to the parameters of the directions. The traced
// equations hold the contact forces; the derivatives of these,
//
//     dF_N = F_δ dδ + F_δ̇ dδ̇ + F_v₀ dv₀ + F_m dm + F_p,      dF_T likewise by F_N and v_T,
//
// follow from the laws: F_p by differences of fourth order between the laws of the displaced parameter at the
// nominal depth and rates.

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
        d.r[k] = w.motion.side[k][s] - baumgarte_.two_alpha * w.motion.rate[k][s] -
                 baumgarte_.beta_squared * w.motion.place[k][s];
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
