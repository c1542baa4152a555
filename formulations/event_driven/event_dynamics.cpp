#include "formulations/event_driven/event_dynamics.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/contact/film_force.hpp"
#include "formulations/integrators/crossing.hpp"
#include "simulation/residuals.hpp"

namespace freeplay {

EventDynamics::EventDynamics(const System& system, const NonsmoothOptions& options,
                             std::vector<double> restitution, RowFacts facts, double speed_scale)
    : system_(system),
      options_(options),
      facts_(facts),
      speed_scale_(speed_scale),
      saddle_(system.mass(), system.pattern(), SolvePath::automatic, facts),
      e_(system.make_evaluation()),
      contacts_(system.contacts()),
      preloaded_(system.frictions()),
      impact_(options.impact_law, options.solver, options.lcp_tolerance),
      status_(options.solver, options.lcp_tolerance),
      coupled_(system) {
  for (int k = 0; k < system.contacts(); ++k) {
    contacts_[k].restitution = restitution[k];
    if (const auto film = make_film(system.contact_facts(k))) films_.push_back({k, *film});
  }
  for (int k = 0; k < system.frictions(); ++k) {
    preloaded_[k].bound = system.friction_facts(k).bound;
    preloaded_[k].share = system.slide_share(k);
  }
  bound_image_.setZero(coupled_.size());
  const int most = 2 * system.contacts() + system.frictions();
  rows_.resize(most);
  rhs_.setZero(most);
  a_.resize(system.n());
  change_.resize(system.n());
  placed_.resize(system.n());
  for (auto* x : {&lambda_, &r_, &struck_lambda_}) x->resize(system.rows());
  extremes.penetration.assign(system.contacts(), 0);
}

/// Contacts that act at one time are few among many: room for their dense matrices grows with the most of them so far.
void EventDynamics::make_room(int rows) {
  if (rows <= room_) return;
  constexpr int least = 16;
  room_ = std::min(std::max({rows, 2 * room_, least}), static_cast<int>(rows_.size()));
  response_.resize(static_cast<std::size_t>(room_) * system_.n());
  reaction_.resize(static_cast<std::size_t>(room_) * system_.rows());
  status_.reserve(room_);
  K_.conservativeResize(room_, room_);
}

int EventDynamics::add(const SparseRow& row, const SparseRow* beside, double factor) {
  const int r = used_++;
  make_room(used_);
  rows_[r] = row;
  saddle_.respond(row, beside, factor, response(r), reaction(r));
  return r;
}

/// Contacts are looked at one by one, many at one state: its sines and rows are evaluated once.
void EventDynamics::place(const double* q, double t) {
  if (t == placed_t_ && std::equal(placed_.begin(), placed_.end(), q)) return;
  system_.place(t, q, e_, phases.pieces());
  placed_t_ = t;
  std::copy(q, q + system_.n(), placed_.begin());
}

/// Accelerations in a_ with no contact closed, what slips as forces and what rests without friction.
bool EventDynamics::solve_free(const Vector& x, double t) {
  const double *q = x.data(), *v = q + system_.n();
  ++work.rhs;
  ++work.factorisations;
  place(q, t);
  system_.rate(q, v, e_);
  system_.forces(t, q, v, x.data() + state_offset(), e_, {nullptr, phases.pieces()});
  for (int k = 0; k < system_.frictions(); ++k) {
    auto& p = preloaded_[k];
    p.gamma = system_.friction(k, q, v, e_, p.row);
    p.rate = p.row.dot(v);
    p.lambda = -p.slip * p.bound;
    if (p.slip != 0) p.row.add_to(e_.force.data(), p.lambda);
  }
  if (has_films()) add_films(q, v);
  if (!saddle_.factor(e_.G.data())) return false;
  saddle_.solve(e_.force.data(), e_.gamma.data(), a_.data(), lambda_.data());
  if (coupled_.size() > 0 && saddle_.singular() && !facts_.redundant) {
    trouble_ =
        "constraint rows depend on each other there: the reactions that bound friction in joints are not unique";
    return false;
  }
  return true;
}

void EventDynamics::add_films(const double* q, const double* v) {
  film_loss_ = 0;
  for (const auto& f : films_) {
    system_.contact(f.contact, q, v, e_, film_row_);
    const auto film = film_action(f.law, v, film_row_);
    if (!film) continue;
    film_row_.normal.add_to(e_.force.data(), film->normal);
    film_row_.film.add_to(e_.force.data(), film->tangential);
    film_row_.spin.add_to(e_.force.data(), film->torque);
    film_loss_ += film->loss;
  }
}

/// Accelerations and multipliers of the mode at a state, in a_, lambda_ and the elements.
bool EventDynamics::solve_mode(const Vector& x, double t) {
  const double *q = x.data(), *v = q + system_.n();
  const int n = system_.n(), m = system_.rows();
  if (coupled_.size() > 0) {
    if (!is_finite(x)) return false;  // a stage after one that failed
    trouble_.clear();
    for (int k = 0; k < coupled_.size(); ++k) preloaded_[coupled_.friction(k)].bound = 0;
  }
  if (!solve_free(x, t)) return false;
  used_ = 0;
  const auto want = [&](const SparseRow& row, double gamma, const SparseRow* beside, double factor) {
    const int r = add(row, beside, factor);
    rhs_[r] = gamma - row.dot(a_.data());
    return r;
  };
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = contacts_[k];
    c.unknown = c.tangent_unknown = -1;
    c.lambda_n = c.lambda_t = 0;
    if (!c.closed) continue;
    system_.contact(k, q, v, e_, c.row);
    const bool rough = c.row.tangent.size > 0;
    const double mu = rough ? *system_.contact_facts(k).surface.friction : 0;
    c.unknown = want(c.row.normal, c.row.gamma_n, c.slip != 0 ? &c.row.tangent : nullptr, -c.slip * mu);
    if (rough && c.slip == 0) c.tangent_unknown = want(c.row.tangent, c.row.gamma_t, nullptr, 0);
  }
  for (auto& p : preloaded_) {
    p.unknown = -1;
    if (p.slip == 0) p.unknown = want(p.row, p.gamma, nullptr, 0);
  }
  if (used_ == 0 && coupled_.size() == 0) return true;
  solve_rows();
  if (passes_pole()) return false;
  if (coupled_.size() > 0 && !add_coupled()) return false;
  for (int r = 0; r < used_; ++r) {
    for (int i = 0; i < n; ++i) a_[i] += solution_[r] * response(r)[i];
    for (int k = 0; k < m; ++k) lambda_[k] += solution_[r] * reaction(r)[k];
  }
  keep_bounds();
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = contacts_[k];
    if (c.unknown < 0) continue;
    c.lambda_n = solution_[c.unknown];
    c.mobility = K_(c.unknown, c.unknown);
    if (c.row.tangent.size == 0) continue;
    const double mu = *system_.contact_facts(k).surface.friction;
    c.lambda_t = c.slip != 0 ? -c.slip * mu * c.lambda_n : solution_[c.tangent_unknown];
  }
  for (auto& p : preloaded_)
    if (p.unknown >= 0) p.lambda = solution_[p.unknown];
  return true;
}

/// The rows that hold, from what is wanted of them.
void EventDynamics::solve_rows() {
  if (used_ == 0) return;
  for (int r = 0; r < used_; ++r)
    for (int s = 0; s < used_; ++s) K_(r, s) = rows_[r].dot(response(s));
  solve_active();
  if (!dependent_) return;
  // Weighed by bounds: those of reactions are known with the forces only, and looked at once before.
  for (int i = 0; i < coupled_.size(); ++i) {
    auto& p = preloaded_[coupled_.friction(i)];
    if (p.slip != 0) return;  // its force would not agree with another choice
    const auto& bound = *system_.friction_facts(coupled_.friction(i)).reaction;
    double l[2] = {lambda_[bound.row], lambda_[bound.row + 1]};
    for (int r = 0; r < used_; ++r)
      for (const int which : {0, 1}) l[which] += solution_[r] * reaction(r)[bound.row + which];
    p.bound = bound.coefficient(0.0) * bound.support(l[0], l[1]);
  }
  share_friction();
}

/// Where D_NN − s μ D_NT (of several rows the determinant) of what slides comes to zero its forces grow beyond any bound, and
/// behind it they pull: no step leads across, however well its stages agree (Painlevé).
bool EventDynamics::passes_pole() {
  const auto slides = [](const Contact& c) { return c.closed && c.slip != 0 && c.row.tangent.size > 0; };
  if (used_ == 0 || dependent_ || std::ranges::none_of(contacts_, slides)) return false;
  if (orientation_ == 0) orientation_ = turn_;
  if (turn_ == orientation_ || reporting_) {
    if (std::exchange(pole_, false)) {  // a shorter step ends before it
      jam_ = false;
      trouble_.clear();
    }
    return false;
  }
  pole_ = jam_ = jam_proved_ = true;
  trouble_ =
      "friction admits no finite force on what slides (Painlevé); time stepping gives a consistent impulse";
  return true;
}

/// What slips and is bounded by reactions: a unit of each, with what then holds the rows that hold, added to a_ and
/// lambda_, and to the rows' forces.
bool EventDynamics::add_coupled() {
  const int n = system_.n(), m = system_.rows(), held = used_;
  const auto total = [&](const double* own, auto part, const Eigen::VectorXd& forces, int k) {
    double sum = own[k];
    for (int r = 0; r < held; ++r) sum += forces[r] * part(r)[k];
    return sum;
  };
  if (held > 0) held_forces_ = solution_;
  auto& reactions = held_reactions_;
  reactions.resize(static_cast<std::size_t>(m));
  for (int k = 0; k < m; ++k)
    reactions[k] = total(
        lambda_.data(), [&](int r) { return reaction(r); }, held_forces_, k);
  coupled_.base(reactions.data());
  answers_.resize(static_cast<std::size_t>(coupled_.size()));
  int own = held;  // the next slot behind the rows that hold
  for (int i = 0; i < coupled_.size(); ++i) {
    const int f = coupled_.friction(i);
    const auto& p = preloaded_[f];
    coupled_.factor(i) = p.slip * system_.friction_facts(f).reaction->coefficient(p.rate);
    if (p.slip == 0) continue;
    make_room(own + 1);
    rows_[own] = p.row;
    saddle_.respond(p.row, nullptr, 0, response(own), reaction(own));
    auto& answer = answers_[i];
    if (held > 0) {
      for (int r = 0; r < held; ++r) rhs_[r] = -rows_[r].dot(response(own));
      solve_active();
      answer = solution_;
    }
    for (int k = 0; k < m; ++k)
      reactions[k] = total(
          reaction(own), [&](int r) { return reaction(r); }, answer, k);
    coupled_.column(i, reactions.data());
    ++own;
  }
  if (held > 0) solution_ = held_forces_;
  if (own == held) return true;
  if (const auto outcome = coupled_.solve(); outcome != CoupledFriction::Outcome::solved) {
    trouble_ = words_of(outcome);
    return false;
  }
  extremes.friction_residual = std::max(extremes.friction_residual, coupled_.residual());
  own = held;
  for (int i = 0; i < coupled_.size(); ++i) {
    auto& p = preloaded_[coupled_.friction(i)];
    if (p.slip == 0) continue;
    p.lambda = coupled_.force(i);
    for (int k = 0; k < n; ++k) a_[k] += p.lambda * response(own)[k];
    for (int k = 0; k < m; ++k) lambda_[k] += p.lambda * reaction(own)[k];
    ++own;
    if (held > 0) solution_ += p.lambda * answers_[i];
  }
  return true;
}

/// Bounds that the reactions in lambda_ give.
void EventDynamics::keep_bounds() {
  for (int i = 0; i < coupled_.size(); ++i) {
    const int k = coupled_.friction(i);
    auto& p = preloaded_[k];
    p.bound = system_.friction_facts(k).limit(p.slip != 0 ? p.rate : 0, lambda_.data());
  }
}

/// K x = rhs of the active rows; of several solutions (sticking feet of one body share a row) the least.
void EventDynamics::solve_active() {
  const auto K = K_.topLeftCorner(used_, used_);
  active_.compute(K);
  const auto pivots = active_.matrixLU().diagonal().cwiseAbs();
  dependent_ = !(pivots.minCoeff() > 1e-11 * pivots.maxCoeff());
  turn_ = static_cast<int>(active_.permutationP().determinant());
  for (int r = 0; r < used_; ++r) turn_ *= active_.matrixLU()(r, r) < 0 ? -1 : 1;
  if (dependent_) {
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
    decomposition.setThreshold(1e-10);
    decomposition.compute(K);
    solution_ = decomposition.solve(rhs_.head(used_));
  } else {
    solution_ = active_.solve(rhs_.head(used_));
  }
}

/// Where sticking rows depend on each other their forces are not unique. They are shared in proportion to
/// what each contact can hold, so that none gives way while others could hold on. One that seems unpressed keeps a small
/// share: without its force its row may not be met at all.
void EventDynamics::share_friction() {
  Eigen::VectorXd share = Eigen::VectorXd::Ones(used_);
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = contacts_[k];
    if (c.tangent_unknown < 0) continue;
    const double bound = *system_.contact_facts(k).surface.friction * solution_[c.unknown];
    share[c.tangent_unknown] = std::max(bound, 0.0);
  }
  for (int k = 0; k < system_.frictions(); ++k)
    if (preloaded_[k].unknown >= 0) share[preloaded_[k].unknown] = preloaded_[k].bound;
  share = (share / share.maxCoeff())
              .cwiseMax(1e-6)
              .cwiseSqrt();  // least Σ λ²/bound: λ in proportion to the bound
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(1e-10);
  decomposition.compute(K_.topLeftCorner(used_, used_) * share.asDiagonal());
  solution_ = share.asDiagonal() * decomposition.solve(rhs_.head(used_));
}

void EventDynamics::operator()(const Vector& x, Vector& dxdt, double t) {
  t = std::min(t, knot);
  const int n = system_.n(), m = system_.rows();
  const double* v = x.data() + n;
  if (!solve_mode(x, t)) {
    std::ranges::fill(dxdt, __builtin_nan(""));  // refused by the step control
    return;
  }
  std::copy(v, v + n, dxdt.begin());
  std::ranges::copy(a_, dxdt.begin() + n);
  double* integral = dxdt.data() + integral_offset();
  integral[drive] = e_.power.drive;
  integral[load] = e_.power.load;
  integral[damping] = -e_.power.damping;
  integral[friction_loss] = 0;
  if (has_films()) integral[film_loss] = film_loss_;
  for (int k = 0; k < m; ++k) integral[drive] += lambda_[k] * e_.phi_t[k];
  system_.flow(t, x.data(), v, x.data() + state_offset(), dxdt.data() + state_offset(),
               {nullptr, phases.pieces()});
  double* impulse = dxdt.data() + impulse_offset();
  for (const auto& c : contacts_) {
    *impulse++ = c.lambda_n;
    *impulse++ = c.lambda_t;
    if (c.lambda_t != 0) integral[friction_loss] -= c.lambda_t * c.row.tangent.dot(v);
  }
  for (const auto& p : preloaded_) integral[friction_loss] -= p.lambda * p.rate;
}

void EventDynamics::take_mode(const EventDynamics& other) {
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    contacts_[k].closed = other.contacts_[k].closed;
    contacts_[k].slip = other.contacts_[k].slip;
    contacts_[k].resting = other.contacts_[k].resting;
    contacts_[k].lambda_n = other.contacts_[k].lambda_n;
    contacts_[k].lambda_t = other.contacts_[k].lambda_t;
  }
  orientation_ = 0;
  phases = other.phases;
  forget_place();
  knot = other.knot;
  for (std::size_t k = 0; k < preloaded_.size(); ++k) preloaded_[k].slip = other.preloaded_[k].slip;
}

void EventDynamics::report(const Vector& x, double t, Forces& out) {
  t = std::min(t, knot);
  const double *q = x.data(), *v = q + system_.n();
  out.clear();
  reporting_ = true;
  const bool solved = solve_mode(x, t);
  reporting_ = false;
  if (!solved) return void(++unreported);
  std::ranges::copy(a_, out.acceleration.begin());
  system_.report_rows(q, e_, lambda_.data(), 1, out);
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = contacts_[k];
    if (c.closed) system_.report_contact(k, q, e_, c.row, c.lambda_n, c.lambda_t, 1, out);
  }
  for (const auto& f : films_) {
    system_.contact(f.contact, q, v, e_, film_row_);
    if (const auto film = film_action(f.law, v, film_row_))
      system_.report_film(f.contact, q, e_, film_row_, film->normal, film->tangential, film->torque, 1, out);
  }
  for (int k = 0; k < system_.frictions(); ++k)
    system_.report_friction(k, q, v, e_, preloaded_[k].row, preloaded_[k].lambda, 1, out);
  system_.report_loads(t, q, v, x.data() + state_offset(), e_, 1, out, {nullptr, phases.pieces()});
}

double EventDynamics::greatest(const double* rates) const {
  double most = 0;
  for (int i = 0; i < system_.n(); ++i)
    most = std::max(most, std::abs(rates[i]) * (system_.is_angle(i) ? system_.longest_arm() : 1));
  return most;
}

double EventDynamics::centripetal_scale(const double* v) const {
  double fastest = 0;
  for (int i = 0; i < system_.n(); ++i)
    if (system_.is_angle(i)) fastest = std::max(fastest, std::abs(v[i]));
  return fastest * fastest * system_.longest_arm();
}

void EventDynamics::measure_speeds(const Vector& x) {
  const double fastest = greatest(x.data() + system_.n());
  speed_tolerance_ = 1e-10 * speed_scale_ + 1e-14 * fastest;
  slide_tolerance_ = 1e-7 * speed_scale_ + 1e-12 * fastest;
}

void EventDynamics::keep_extremes(const Vector& x, double t) {
  place(x.data(), t);
  keep_residuals(system_, e_, extremes);
  for (int k = 0; k < system_.contacts(); ++k)
    extremes.penetration[k] = std::max(extremes.penetration[k], -system_.gap(k, x.data(), e_));
}

const ContactRow& EventDynamics::look(int k, const Vector& x, double t) {
  place(x.data(), t);
  system_.contact(k, x.data(), x.data() + system_.n(), e_, contacts_[k].row);
  return contacts_[k].row;
}

double EventDynamics::closed_gap(int k, const double* q) const {
  return std::max(1e-9 * system_.contact_facts(k).clearance, 8 * gap_rounding(system_, k, q));
}

double EventDynamics::slide_rate(int k, const Vector& x, double t) {
  const double* v = x.data() + system_.n();
  place(x.data(), t);
  system_.friction(k, x.data(), v, e_, preloaded_[k].row);
  return preloaded_[k].row.dot(v);
}

}  // namespace freeplay
