#include "formulations/penalty/dynamics.hpp"

#include <algorithm>

namespace freeplay {

PenaltyDynamics::PenaltyDynamics(const System& system, const PenaltyOptions& options,
                                 std::vector<PenaltyContact> contacts, bool redundant)
    : system_(system),
      projects_(options.stabilisation == Stabilisation::projection),
      contacts_(std::move(contacts)),
      saddle_(system.mass(), system.pattern(), SolvePath::automatic, redundant),
      e_(system.make_evaluation()),
      probe_(system.make_evaluation()),
      r_(system.rows()),
      lambda_(system.rows()),
      rate_(system.rows()),
      scratch_(system.n()),
      unit_(system.n()) {
  if (options.stabilisation == Stabilisation::baumgarte) {
    two_alpha_ = 2 * options.alpha;
    beta_squared_ = options.beta * options.beta;
  }
  // One place per contact, so that a bristle is found by its contact; contacts without friction leave theirs
  // at zero.
  for (const auto& c : contacts_)
    if (c.friction && c.friction->has_state()) bristles_ = system.contacts();
}

void PenaltyDynamics::operator()(const Vector& x, Vector& dxdt, double t) {
  ++work.rhs;
  const int n = system_.n(), m = system_.rows();
  const double* q = x.data();
  const double* v = q + n;
  system_.place(t, q, e_);
  system_.rate(q, v, e_);
  system_.forces(t, q, v, e_);
  double* integral = dxdt.data() + integral_offset();
  integral[contact_loss] = integral[friction_loss] = integral[film_loss] = 0;

  double* impulse = dxdt.data() + impulse_offset();
  for (int k = 0; k < system_.contacts(); ++k, impulse += 2) {
    impulse[0] = impulse[1] = 0;
    if (bristles_) dxdt[bristle_offset() + k] = 0;
    const auto& c = contacts_[k];
    if (!c.closed && !c.film) continue;
    system_.contact(k, q, v, e_, row_);
    if (c.film) integral[film_loss] += film_forces(*c.film, v);
    if (!c.closed) continue;
    if (!(row_.gap < 0)) continue;
    const double delta = -row_.gap, rate = -row_.normal.dot(v);
    const double elastic = c.law.elastic.force(delta);
    const double force = c.law.force(elastic, rate, c.v0);
    row_.normal.add_to(e_.force.data(), force);
    impulse[0] = force;
    integral[contact_loss] += (force - elastic) * rate;
    if (!c.friction) continue;
    const double v_t = row_.tangent.dot(v), z = bristles_ ? x[bristle_offset() + k] : 0;
    const double tangential = -c.friction->coefficient(v_t, c.zone, z) * force;
    if (bristles_) dxdt[bristle_offset() + k] = c.friction->bristle_rate(v_t, c.zone, z);
    row_.tangent.add_to(e_.force.data(), tangential);
    impulse[1] = tangential;
    integral[friction_loss] -= tangential * v_t;
  }
  for (int k = 0; k < system_.frictions(); ++k) {
    const auto& facts = system_.friction_facts(k);
    system_.friction(k, q, v, e_, slide_);
    const double u = slide_.dot(v), force = preloaded_friction(facts.bound, *facts.regularisation, u);
    slide_.add_to(e_.force.data(), force);
    integral[friction_loss] -= force * u;
  }

  for (int k = 0; k < m; ++k) {
    rate_[k] = row_dot(system_.pattern(), e_.G.data(), k, v) + e_.phi_t[k];
    r_[k] = e_.gamma[k] - two_alpha_ * rate_[k] - beta_squared_ * e_.phi[k];
  }
  ++work.factorisations;
  double* a = dxdt.data() + n;
  if (saddle_.factor(e_.G.data()))
    saddle_.solve(e_.force.data(), r_.data(), a, lambda_.data());
  else
    std::fill(a, a + n, __builtin_nan(""));  // refused by the step control
  if (!saddle_.converged()) std::fill(a, a + n, __builtin_nan(""));
  singular_ = singular_ || saddle_.singular();

  integral[drive] = e_.power.drive;
  integral[load] = e_.power.load;
  integral[damping] = -e_.power.damping;
  integral[stabilisation] = 0;
  for (int k = 0; k < m; ++k) {
    integral[drive] += lambda_[k] * e_.phi_t[k];
    integral[stabilisation] -= lambda_[k] * rate_[k];
  }
  std::copy(v, v + n, dxdt.data());
}

/// Adds a film's forces at row_ and returns the power that it dissipates (W).
double PenaltyDynamics::film_forces(const Film& film, const double* v) {
  const double share = film.share(row_.gap);
  if (share == 0) return 0;
  const double w_r = -row_.normal.dot(v), w_t = row_.film.dot(v), spin = row_.spin.dot(v);
  const auto F = film.force(film.ratio(row_.gap), w_r, w_t);
  const double torque = share * film.shear(film.ratio(row_.gap)) * spin;
  row_.normal.add_to(e_.force.data(), -share * F.radial);
  row_.film.add_to(e_.force.data(), share * F.tangential);
  row_.spin.add_to(e_.force.data(), -torque);
  return torque * spin - share * (F.radial * w_r + F.tangential * w_t);
}

void PenaltyDynamics::project(Vector& x, double t) {
  const int n = system_.n(), m = system_.rows();
  double* q = x.data();
  double* v = q + n;
  const double before = system_.kinetic(v) + system_.potential(q);
  const auto move = [&](double* y, auto residual) {
    for (int k = 0; k < m; ++k) r_[k] = -residual(k);
    saddle_.solve(nullptr, r_.data(), scratch_.data(), lambda_.data());
    for (int i = 0; i < n; ++i) y[i] += scratch_[i];
  };
  system_.place(t, q, e_);
  ++work.factorisations;
  if (!saddle_.factor(e_.G.data())) return;
  move(q, [&](int k) { return e_.phi[k]; });
  system_.place(t, q, e_);
  move(v, [&](int k) { return row_dot(system_.pattern(), e_.G.data(), k, v) + e_.phi_t[k]; });
  x[integral_offset() + stabilisation] += system_.kinetic(v) + system_.potential(q) - before;
}

const ContactRow& PenaltyDynamics::contact_row(int k, const Vector& x, double t) {
  system_.place(t, x.data(), probe_);
  system_.contact(k, x.data(), x.data() + system_.n(), probe_, row_);
  return row_;
}

std::pair<double, double> PenaltyDynamics::gap(int k, const Vector& x, double t) {
  const auto& row = contact_row(k, x, t);
  return {row.gap, row.normal.dot(x.data() + system_.n())};
}

double PenaltyDynamics::effective_mass(const ContactRow& row) {
  std::ranges::fill(unit_, 0);
  row.normal.add_to(unit_.data(), 1);
  if (!saddle_.factor(probe_.G.data())) return 0;
  saddle_.solve(unit_.data(), nullptr, scratch_.data(), lambda_.data());
  const double mobility = row.normal.dot(scratch_.data());
  return mobility > 0 ? 1 / mobility : 0;
}

double PenaltyDynamics::elastic_energy(const Vector& x, double t) {
  double sum = 0;
  for (int k = 0; k < system_.contacts(); ++k)
    if (contacts_[k].closed) sum += contacts_[k].law.elastic.energy(std::max(0.0, -gap(k, x, t).first));
  return sum;
}

}  // namespace freeplay
