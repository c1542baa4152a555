// Right-hand side of the penalty formulation, the projection onto the constraints, and the report of
// forces. dynamics.hpp has the equations.
#include "formulations/penalty/dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "dynamics/planar.hpp"
#include "formulations/contact/film.hpp"

namespace freeplay {

namespace {

/// Number of bristle states: one per contact if any friction has a state, otherwise none.
/// The state has the index of its contact and stays zero for a contact without such a law.
int count_bristles(const std::vector<PenaltyContact>& contacts) {
  const bool any = std::ranges::any_of(contacts, &PenaltyContact::has_bristle);
  return any ? static_cast<int>(contacts.size()) : 0;
}

}  // namespace

PenaltyDynamics::PenaltyDynamics(const System& system, const PenaltyOptions& options,
                                 std::vector<PenaltyContact> contacts, RowFacts facts)
    : contact_rows(system),
      system_(system),
      options_(options),
      facts_(facts),
      bristles_(count_bristles(contacts)),
      contacts_(std::move(contacts)),
      saddle_(system.mass(), system.pattern(), SolvePath::automatic, facts),
      terms_(system, bristles_),
      evaluated_{Vector(2 * static_cast<std::size_t>(system.n()))},
      lambda_(system.rows()),
      r_(system.rows()),
      scratch_(system.n()),
      impulse_(system.rows()),
      friction_(system) {
  saddle_.use(system.compiled().solve());
  if (options.stabilisation == Stabilisation::baumgarte)
    baumgarte_ = {2 * options.alpha, options.beta * options.beta};
}

void PenaltyDynamics::evaluate(const double* q, const double* v, const double* bristle, const double* z,
                               double t, bool known) {
  auto& terms = terms_;
  auto& e = terms.e;
  if (!known) {
    system_.place(t, q, e, phases.pieces());
    system_.rate(q, v, e);
    system_.forces(t, q, v, z, e, {nullptr, phases.pieces()});
  }
  system_.flow(t, q, v, z, terms.flow.data(), {nullptr, phases.pieces()});
  terms.contact_work = terms.friction_loss = terms.film_loss = 0;

  double* impulse = terms.impulse_rate.data();
  for (int k = 0; k < system_.contacts(); ++k, impulse += 2) {
    impulse[0] = impulse[1] = 0;
    if (bristles_) terms.bristle_rate[k] = 0;
    const auto& c = contacts_[k];
    if (!c.closed && !c.film) continue;
    auto& row = terms.rows[static_cast<std::size_t>(k)];
    system_.contact(k, q, v, e, row);
    if (c.film)
      if (const auto film = film_action(*c.film, v, row)) {
        row.normal.add_to(e.force.data(), film->normal);
        row.film.add_to(e.force.data(), film->tangential);
        row.spin.add_to(e.force.data(), film->torque);
        terms.film_loss += film->loss;
      }
    if (!c.closed) continue;
    const auto* anchor = anchors ? &(*anchors)[static_cast<std::size_t>(k)] : nullptr;
    if (anchor ? !anchor->pressed : !(row.gap < 0) && !touching && !c.jumps()) continue;
    const double rate = -row.normal.dot(v);
    double delta = -row.gap;
    if (delta < 0 && (touching || !anchor)) delta = 0;  // beside an anchor the force is linear
    const double elastic = c.law.elastic.force(anchor ? anchor->delta : delta);
    double force;
    if (anchor)
      force = c.force_in_piece(anchor->delta, anchor->rate, elastic, anchor->normal > 0) +
              anchor->normal_by_delta * (delta - anchor->delta) +
              anchor->normal_by_rate * (rate - anchor->rate);
    else
      force = c.force(delta, rate, elastic);
    row.normal.add_to(e.force.data(), force);
    impulse[0] = force;
    if (c.law.dissipates()) terms.contact_work += force * rate;
    if (!c.rubs()) continue;
    const double v_t = row.tangent.dot(v), z = bristles_ ? bristle[k] : 0;
    double tangential;
    if (anchor) {
      tangential = c.tangential_force(anchor->normal, anchor->v_t, z) +
                   anchor->tangential_by_normal * (force - anchor->normal) +
                   anchor->tangential_by_v_t * (v_t - anchor->v_t);
      if (bristles_)
        terms.bristle_rate[k] = c.bristle_rate(delta, rate, elastic, anchor->v_t, z) +
                                anchor->bristle_by_v_t * (v_t - anchor->v_t);
    } else {
      tangential = c.tangential_force(force, v_t, z);
      if (bristles_) terms.bristle_rate[k] = c.bristle_rate(delta, rate, elastic, v_t, z);
    }
    row.tangent.add_to(e.force.data(), tangential);
    impulse[1] = tangential;
    terms.friction_loss -= tangential * v_t;
  }
  for (int k = 0, reactive = 0; k < system_.frictions(); ++k) {
    const auto& facts = system_.friction_facts(k);
    if (facts.reaction) {  // ReactiveFriction adds this friction, which depends on the reactions
      auto& c = terms.coupled[static_cast<std::size_t>(reactive++)];
      system_.friction(k, q, v, e, c.row);
      c.u = c.row.dot(v);
      c.factor = -preloaded_friction(1, *facts.regularisation, c.u) * facts.reaction->coefficient(c.u);
      continue;
    }
    system_.friction(k, q, v, e, terms.slide);
    const double u = terms.slide.dot(v), force = preloaded_friction(facts.bound, *facts.regularisation, u);
    terms.slide.add_to(e.force.data(), force);
    terms.friction_loss -= force * u;
  }
  for (int k = 0; !known && k < system_.rows(); ++k) {
    terms.rate[k] = row_dot(system_.pattern(), e.G.data(), k, v) + e.phi_t[k];
    terms.r[k] = e.gamma[k] - baumgarte_.two_alpha * terms.rate[k] - baumgarte_.beta_squared * e.phi[k];
  }
}

void PenaltyDynamics::operator()(const Vector& x, Vector& dxdt, double t) {
  t = std::min(t, knot);
  ++work.rhs;
  const int n = system_.n(), m = system_.rows();
  const double *q = x.data(), *v = q + n, *z = q + state_offset();
  auto& e = terms_.e;
  const double baumgarte[] = {baumgarte_.two_alpha, baumgarte_.beta_squared};
  const bool known =
      kernel_.state(system_, saddle_, e, {t, q, v, z}, baumgarte, terms_.rate.data(), terms_.r.data());
  if (known) e.pieces = phases.pieces();
  evaluate(q, v, q + bristle_offset(), z, t, known);
  evaluated_.set(x, t);
  ++work.factorisations;
  double* a = dxdt.data() + n;
  if (facts_.redundant) saddle_.expect_noise(rounding_of_rows(x.data(), v));
  if (known || saddle_.factor(e.G.data()))
    saddle_.solve(e.force.data(), terms_.r.data(), a, lambda_.data());
  else
    std::fill(a, a + n, __builtin_nan(""));  // the step is rejected
  if (!saddle_.converged()) std::fill(a, a + n, __builtin_nan(""));
  singular_ = singular_ || saddle_.singular();
  if (friction_.laws.size() > 0 && !friction_.add(terms_, saddle_, facts_.redundant, a, lambda_))
    std::fill(a, a + n, __builtin_nan(""));

  std::copy(v, v + n, dxdt.data());
  std::ranges::copy(terms_.impulse_rate, dxdt.begin() + impulse_offset());
  std::ranges::copy(terms_.bristle_rate, dxdt.begin() + bristle_offset());
  std::ranges::copy(terms_.flow, dxdt.begin() + state_offset());
  double* integral = dxdt.data() + integral_offset();
  integral[load] = e.power.load;
  integral[damping] = -e.power.damping;
  integral[contact_work] = terms_.contact_work;
  integral[friction_loss] = terms_.friction_loss;
  integral[film_loss] = terms_.film_loss;
  double driving = e.power.drive, stabilising = 0;
  for (int k = 0; k < m; ++k) {
    driving += lambda_[k] * e.phi_t[k];
    stabilising -= lambda_[k] * terms_.rate[k];
  }
  integral[drive] = driving;
  integral[stabilisation] = stabilising;
}

/// Bound of the rounding error of r (m/s², rad/s²), from the magnitudes of γ and of Baumgarte's
/// terms 2αΦ̇ and β²Φ.
double PenaltyDynamics::rounding_of_rows(const double* q, const double* v) const {
  const auto& p = system_.pattern();
  double fastest = 0, most = 0;  // rad/s
  for (int c = 0; c < system_.n(); ++c)
    if (system_.is_angle(c)) fastest = std::max(fastest, std::abs(v[c]));
  for (int k = 0; k < system_.rows(); ++k) {
    double rates = std::abs(terms_.e.phi_t[k]), places = 0;
    for (int i = p.begin[k]; i < p.begin[k + 1]; ++i) {
      rates += std::abs(terms_.e.G[i] * v[p.column[i]]);
      places += std::abs(terms_.e.G[i] * q[p.column[i]]);
    }
    most = std::max(most, rates * (fastest + baumgarte_.two_alpha) + places * baumgarte_.beta_squared);
  }
  return 16 * std::numeric_limits<double>::epsilon() * most;
}

bool ReactiveFriction::add(PenaltyTerms& terms, SaddlePoint& saddle, bool redundant, double* a,
                           std::vector<double>& lambda) {
  if (!std::isfinite(a[0])) return true;  // solving for a failed, in this stage or an earlier one
  trouble = nullptr;
  if (laws.reads_reactions() && saddle.singular() && !redundant) {
    trouble =
        "constraint rows are linearly dependent, so the reactions that bound joint friction are not unique "
        "(redundant joints, or a singular position)";
    return false;
  }
  laws.base(lambda.data());
  for (int k = 0; k < laws.size(); ++k) {
    const auto& c = terms.coupled[static_cast<std::size_t>(k)];
    saddle.respond(c.row, nullptr, 0, response[k].data(), reaction[k].data());
    laws.factor(k) = c.factor;
    laws.column(k, reaction[k].data());
  }
  if (const auto outcome = laws.solve(); outcome != CoupledFriction::Outcome::solved) {
    trouble = words_of(outcome);
    return false;
  }
  residual = std::max(residual, laws.residual());
  for (int k = 0; k < laws.size(); ++k) {
    const double f = laws.force(k);
    for (std::size_t i = 0; i < response[k].size(); ++i) a[i] += f * response[k][i];
    for (std::size_t i = 0; i < lambda.size(); ++i) lambda[i] += f * reaction[k][i];
    terms.friction_loss -= f * terms.coupled[static_cast<std::size_t>(k)].u;
  }
  return true;
}

void PenaltyDynamics::report(const Vector& x, double t, Vector& dxdt, Forces& out) {
  (*this)(x, dxdt, t);
  const int n = system_.n();
  const double *q = x.data(), *v = q + n;
  const auto& e = terms_.e;
  ContactRow row;
  out.clear();
  std::copy_n(dxdt.begin() + n, n, out.acceleration.begin());
  system_.report().rows(system_.pattern(), q, e, lambda_.data(), 1, out);
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = contacts_[k];
    if (!c.closed && !c.film) continue;
    system_.contact(k, q, v, e, row);
    if (c.film)
      if (const auto film = film_action(*c.film, v, row))
        system_.report().film(k, q, e, row, film->normal, film->tangential, film->torque, 1, out);
    if (c.closed)
      system_.report().contact(k, q, e, row, terms_.impulse_rate[2 * k], terms_.impulse_rate[2 * k + 1], 1,
                               out);
  }
  for (int k = 0, reactive = 0; k < system_.frictions(); ++k) {
    const auto& facts = system_.friction_facts(k);
    if (facts.reaction) {
      const auto& c = terms_.coupled[static_cast<std::size_t>(reactive)];
      system_.report().friction(k, q, v, e, c.row, friction_.laws.force(reactive++), 1, out);
      continue;
    }
    system_.friction(k, q, v, e, terms_.slide);
    const double force = preloaded_friction(facts.bound, *facts.regularisation, terms_.slide.dot(v));
    system_.report().friction(k, q, v, e, terms_.slide, force, 1, out);
  }
  system_.report().loads(t, q, v, x.data() + state_offset(), e, 1, out, {nullptr, phases.pieces()});
}

void PenaltyDynamics::report_projection(const Vector& x, Forces& out) const {
  system_.report().rows(system_.pattern(), x.data(), terms_.e, impulse_.data(), 1, out);
  for (int i = 0; i < system_.n(); ++i) out.acceleration[i] += scratch_[i];
}

void PenaltyDynamics::project(Vector& x, double t) {
  const int n = system_.n(), m = system_.rows();
  double* q = x.data();
  double* v = q + n;
  evaluated_.t = NAN;
  const double before = system_.kinetic(v) + system_.potential(q);
  const auto move = [&](double* y, auto residual) {
    for (int k = 0; k < m; ++k) r_[k] = -residual(k);
    saddle_.solve(nullptr, r_.data(), scratch_.data(), impulse_.data());
    for (int i = 0; i < n; ++i) y[i] += scratch_[i];
  };
  system_.place(t, q, terms_.e, phases.pieces());
  ++work.factorisations;
  if (!saddle_.factor(terms_.e.G.data())) return;
  move(q, [&](int k) { return terms_.e.phi[k]; });
  system_.place(t, q, terms_.e, phases.pieces());
  move(v, [&](int k) { return row_dot(system_.pattern(), terms_.e.G.data(), k, v) + terms_.e.phi_t[k]; });
  x[integral_offset() + stabilisation] += system_.kinetic(v) + system_.potential(q) - before;
}

const Evaluation& ContactRows::placed(const Vector& x, double t) {
  if (end_.at.is(x, t)) return end_.e;
  any_.place(system_, x, t);
  return any_.e;
}

const ContactRow& ContactRows::at(int k, const Vector& x, double t) {
  last_ = &placed(x, t);
  system_.contact(k, x.data(), x.data() + system_.n(), *last_, row_);
  return row_;
}

const ContactRow& ContactRows::alone(int k, const Vector& x) {
  any_.at.t = NAN;  // no longer that of one state
  for (const int body : system_.contact_facts(k).bodies)
    if (body != ground) {
      const double angle = planar::angle(x.data(), body);
      any_.e.cosine[static_cast<std::size_t>(body)] = std::cos(angle);
      any_.e.sine[static_cast<std::size_t>(body)] = std::sin(angle);
    }
  system_.contact(k, x.data(), x.data() + system_.n(), any_.e, row_);
  return row_;
}

void ContactRows::place_end(const Vector& x, double t, const PenaltyTerms* known,
                            const std::vector<PenaltyContact>& contacts) {
  std::ranges::fill(end_known_, 0);
  if (!known) return end_.place(system_, x, t);
  std::ranges::copy(known->e.cosine, end_.e.cosine.begin());
  std::ranges::copy(known->e.sine, end_.e.sine.begin());
  std::ranges::copy(known->e.G, end_.e.G.begin());
  end_.at.set(x, t);
  for (std::size_t k = 0; k < contacts.size(); ++k)
    if (contacts[k].closed) {
      const auto& row = known->rows[k];
      end_rows_[k].gap = row.gap;
      end_rows_[k].normal = row.normal;
      end_rows_[k].tangent = row.tangent;
      end_known_[k] = 1;
    }
}

const ContactRow& ContactRows::end(int k, const Vector& x) {
  auto& row = end_rows_[static_cast<std::size_t>(k)];
  if (end_known_[static_cast<std::size_t>(k)] == 0) {
    system_.contact(k, x.data(), x.data() + system_.n(), end_.e, row);
    end_known_[static_cast<std::size_t>(k)] = 1;
  }
  return row;
}

double PenaltyDynamics::effective_mass(const ContactRow& row) {
  if (!saddle_.factor(contact_rows.last().G.data())) return 0;
  saddle_.respond(row.normal, nullptr, 0, scratch_.data(), impulse_.data());
  const double mobility = row.normal.dot(scratch_.data());
  return mobility > 0 ? 1 / mobility : 0;
}

PenaltyDynamics::Stored PenaltyDynamics::elastic_energy(const Vector& x, double t) {
  Stored sum;
  const auto n = static_cast<std::size_t>(system_.n());
  const bool at_end = contact_rows.is_end(x, t);
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = contacts_[k];
    if (!c.closed) continue;
    const auto& row = at_end ? contact_rows.end(k, x) : contact_rows.at(k, x, t);
    const double delta = std::max(0.0, -row.gap), energy = c.law.elastic.energy(delta);
    sum.all += energy;
    if (c.law.dissipates()) sum.dissipative += energy;
    if (c.shear) {
      const double elastic = c.law.elastic.force(delta);
      const double y = c.zone == 0 ? x[bristle_offset() + k]
                                   : c.shear->mu * c.force(delta, -row.normal.dot(&x[n]), elastic);
      sum.shear += c.shear->energy(delta, elastic, y);
    }
  }
  return sum;
}

EnergyLedger PenaltyDynamics::ledger(const Vector& x, double t) {
  const double* w = x.data() + integral_offset();
  const auto stored = elastic_energy(x, t);
  EnergyLedger l;
  l.elastic = stored.all + stored.shear;
  l.drive = w[drive];
  l.load = w[load];
  l.damping = w[damping];
  l.contact = w[contact_work] - stored.dissipative;
  l.friction = w[friction_loss] - stored.shear;
  l.film = w[film_loss];
  l.stabilisation = w[stabilisation];
  return l;
}

}  // namespace freeplay
