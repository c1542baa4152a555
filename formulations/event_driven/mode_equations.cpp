#include "formulations/event_driven/mode_equations.hpp"

#include <algorithm>

#include "formulations/contact/film_force.hpp"
#include "formulations/integrators/crossing.hpp"
#include "simulation/residuals.hpp"

namespace freeplay {

ModeFilms::ModeFilms(const System& system) {
  for (int k = 0; k < system.contacts(); ++k)
    if (const auto film = make_film(system.contact_facts(k))) films_.push_back({k, *film});
}

void ModeFilms::add(const System& system, const double* q, const double* v, Evaluation& e) {
  loss_ = 0;
  for (const auto& f : films_) {
    system.contact(f.contact, q, v, e, row_);
    const auto film = film_action(f.law, v, row_);
    if (!film) continue;
    row_.normal.add_to(e.force.data(), film->normal);
    row_.film.add_to(e.force.data(), film->tangential);
    row_.spin.add_to(e.force.data(), film->torque);
    loss_ += film->loss;
  }
}

void ModeFilms::report(const System& system, const double* q, const double* v, Evaluation& e, Forces& out) {
  for (const auto& f : films_) {
    system.contact(f.contact, q, v, e, row_);
    if (const auto film = film_action(f.law, v, row_))
      system.report_film(f.contact, q, e, row_, film->normal, film->tangential, film->torque, 1, out);
  }
}

ModeEquations::ModeEquations(const System& s, const std::vector<double>& restitution, RowFacts facts,
                             double speed_scale)
    : system(s),
      contacts(s.contacts()),
      preloaded(s.frictions()),
      saddle(s.mass(), s.pattern(), SolvePath::automatic, facts),
      e(s.make_evaluation()),
      films(s),
      rows(s.n(), s.rows(), 2 * s.contacts() + s.frictions()),
      coupled(s),
      a(s.n()),
      lambda(s.rows()),
      facts_(facts),
      speed_scale_(speed_scale),
      placed_(s.n()) {
  saddle.use(s.solve_functions());
  for (int k = 0; k < s.contacts(); ++k) contacts[k].restitution = restitution[k];
  for (int k = 0; k < s.frictions(); ++k) {
    preloaded[k].bound = s.friction_facts(k).bound;
    preloaded[k].share = s.slide_share(k);
  }
  extremes.penetration.assign(s.contacts(), 0);
}

/// Many contacts are evaluated one by one at the same state; its sines and rows are computed once.
void ModeEquations::place(const double* q, double t) {
  if (t == placed_t_ && std::equal(placed_.begin(), placed_.end(), q)) return;
  system.place(t, q, e, phases.pieces());
  placed(q, t);
}

bool ModeEquations::solve_free(const Vector& x, double t) {
  shared_force = 0;
  const double *q = x.data(), *v = q + system.n();
  ++work.rhs;
  ++work.factorisations;
  place(q, t);
  system.rate(q, v, e);
  system.forces(t, q, v, x.data() + state_offset(), e, {nullptr, phases.pieces()});
  for (int k = 0; k < system.frictions(); ++k) {
    auto& p = preloaded[k];
    p.gamma = system.friction(k, q, v, e, p.row);
    p.rate = p.row.dot(v);
    p.lambda = -p.slip * p.bound;
    if (p.slip != 0) p.row.add_to(e.force.data(), p.lambda);
  }
  if (films.any()) films.add(system, q, v, e);
  if (!saddle.factor(e.G.data())) return false;
  saddle.solve(e.force.data(), e.gamma.data(), a.data(), lambda.data());
  if (coupled.size() > 0 && saddle.singular() && !facts_.redundant) {
    trouble =
        "constraint rows are linearly dependent, so the reactions that bound joint friction are not unique "
        "(redundant joints, or a singular position)";
    return false;
  }
  return true;
}

double ModeEquations::unconstrained_mobility(const SparseRow& row) const {
  double free = 0;
  for (int c = 0; c < row.size; ++c) free += row.value[c] * row.value[c] / system.mass()[row.column[c]];
  return free;
}

const ContactRow& ModeEquations::look(int k, const Vector& x, double t) {
  place(x.data(), t);
  system.contact(k, x.data(), x.data() + system.n(), e, contacts[k].row);
  return contacts[k].row;
}

double ModeEquations::slide_rate(int k, const Vector& x, double t) {
  const double* v = x.data() + system.n();
  place(x.data(), t);
  system.friction(k, x.data(), v, e, preloaded[k].row);
  return preloaded[k].row.dot(v);
}

double ModeEquations::closed_gap(int k, const double* q) const {
  return std::max(1e-9 * system.contact_facts(k).clearance, 8 * gap_rounding(system, k, q));
}

void ModeEquations::keep_extremes(const Vector& x, double t) {
  place(x.data(), t);
  keep_residuals(system, e, extremes);
  for (int k = 0; k < system.contacts(); ++k)
    extremes.penetration[k] = std::max(extremes.penetration[k], -system.gap(k, x.data(), e));
}

double ModeEquations::greatest(const double* rates) const {
  double most = 0;
  for (int i = 0; i < system.n(); ++i)
    most = std::max(most, std::abs(rates[i]) * (system.is_angle(i) ? system.longest_arm() : 1));
  return most;
}

double ModeEquations::centripetal_scale(const double* v) const {
  double fastest = 0;
  for (int i = 0; i < system.n(); ++i)
    if (system.is_angle(i)) fastest = std::max(fastest, std::abs(v[i]));
  return fastest * fastest * system.longest_arm();
}

void ModeEquations::measure_speeds(const Vector& x) {
  const double fastest = greatest(x.data() + system.n());
  speed_tolerance_ = 1e-10 * speed_scale_ + 1e-14 * fastest;
  slide_tolerance_ = 1e-7 * speed_scale_ + 1e-12 * fastest;
}

}  // namespace freeplay
