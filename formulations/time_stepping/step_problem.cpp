#include "formulations/time_stepping/step_problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "formulations/time_stepping/step_text.hpp"

namespace freeplay {

using Multipliers = SaddlePoint::Multipliers;

namespace {

/// Computes D of few contacts, with the responses to their rows.
void assemble(ContactProblem& problem, StepData& s, ImpulseResponses& responses, FilmStep& films,
              Multipliers which) {
  const int rows = problem.rows;
  for (int r = 0; r < rows; ++r) {
    s.saddle.respond(responses.row(r), nullptr, 0, responses.response(r), responses.reaction(r), which);
    if (films.any()) films.relax(responses.response(r), responses.reaction(r));
  }
  double* D = problem.D.data();
  const auto size = problem.D.rows();
  for (int r = 0; r < rows; ++r) {
    const auto& row = responses.row(r);
    for (int c = 0; c <= r; ++c) D[r + c * size] = D[c + r * size] = row.dot(responses.response(c));
  }
  if (!films.any()) return;
  for (int r = 0; r < rows; ++r)  // D is not symmetric with cavitated films
    for (int c = r + 1; c < rows; ++c) problem.D(r, c) = responses.row(r).dot(responses.response(c));
}

/// Adds the impulses of few contacts to v and lambda.
void act(const ContactProblem& problem, StepData& s, const ImpulseResponses& responses) {
  const auto n = s.v.size(), m = s.lambda.size();
  double *v = s.v.data(), *lambda = s.lambda.data();
  const auto apply = [&](int row, double impulse) {
    if (row < 0 || impulse == 0) return;
    const double *a = responses.response(row), *l = responses.reaction(row);
    for (std::size_t i = 0; i < n; ++i) v[i] += impulse * a[i];
    for (std::size_t k = 0; k < m; ++k) lambda[k] += impulse * l[k];
  };
  for (const auto& c : problem.unknowns) {
    if (c.impulse_n == 0 || c.impulse_t == 0) {
      apply(c.normal, c.impulse_n);
      apply(c.tangent, c.impulse_t);
      continue;
    }
    const double *a = responses.response(c.normal), *l = responses.reaction(c.normal),
                 *b = responses.response(c.tangent), *t = responses.reaction(c.tangent);
    push(n, c.impulse_n, a, c.impulse_t, b, v);
    push(m, c.impulse_n, l, c.impulse_t, t, lambda);
  }
}

}  // namespace

StepProblem::StepProblem(const StepData& step, const NonsmoothOptions& options, int rows, bool many,
                         bool films)
    : problem(options.solver, options.lcp_tolerance),
      slides(step.system.frictions()),
      slide_gamma(step.system.frictions()),
      slide_last(step.system.frictions()),
      bounds_(step.system),
      v_free_(step.system.n()),
      lambda_free_(step.system.rows()),
      late_multipliers_(!many && !films && bounds_.size() == 0) {
  if (!many) {
    problem.reserve(rows);
    return;
  }
  islands_ =
      std::make_unique<ContactIslands>(step.saddle, step.system.n(), options.solver, options.lcp_tolerance);
  problem.reserve_rates(rows);
  place_.reserve(static_cast<std::size_t>(rows));
  id_.reserve(static_cast<std::size_t>(rows));
}

void StepProblem::begin(StepData& s) {
  if (islands_) islands_->use(s.saddle);
  for (int k = 0; k < s.system.frictions(); ++k)
    slide_gamma[k] = s.system.friction(k, s.q_mid.data(), s.v_old.data(), s.middle, slides[k]);
}

bool StepProblem::solve(StepData& s, ContactSet& contacts, ImpulseResponses& responses, FilmStep& films) {
  const bool heap = islands_ && s.system.rows() == 0;
  contacts.begin(s, islands_ != nullptr);
  if (islands_) islands_->clear();
  // Impulses of other elements may close a gap that the free motion leaves open: check again with
  // them.
  for (bool first = true; contacts.activate(s, responses) || first; first = false) {
    if (!first) {
      s.v = v_free_;
      s.lambda = lambda_free_;
    }
    collect(s, contacts, responses, first);
    if (problem.unknowns.empty()) break;
    if (first && contacts.waiting()) {
      v_free_ = s.v;
      lambda_free_ = s.lambda;
    }
    if (!solve_contacts(s, contacts, responses, films)) return false;
    if (heap)  // initial guess if more contacts join
      for (const int k : contacts.live())
        if (auto& c = contacts[k]; c.active) {
          c.last_n = problem.unknowns[c.unknown].impulse_n;
          c.last_t = problem.unknowns[c.unknown].impulse_t;
        }
  }
  if (islands_) react_to_all(s, responses);
  if (late_multipliers_) {
    for (const auto& u : problem.unknowns) {
      if (u.normal >= 0) responses.row(u.normal).add_to(s.force.data(), u.impulse_n);
      if (u.tangent >= 0) responses.row(u.tangent).add_to(s.force.data(), u.impulse_t);
    }
    if (!s.whole) s.saddle.finish(s.force.data(), s.v.data(), s.lambda.data());
  }
  return true;
}

int StepProblem::add_row(const SparseRow& row, const StepData& s, double end_rate_bias, int place,
                         ImpulseResponses& responses) {
  const int r = problem.rows++;
  if (islands_) place_.push_back(place);
  responses.row(islands_ ? place : r) = row;
  problem.b[r] = row.dot(s.v.data()) + end_rate_bias;
  return r;
}

/// Sets up the contact problem of the active contacts and the joints with friction.
void StepProblem::collect(StepData& s, ContactSet& contacts, ImpulseResponses& responses, bool first) {
  const double h = s.length();
  const bool all = s.reach == StepReach::all;
  problem.clear();
  sliding_.clear();
  place_.clear();
  id_.clear();
  if (islands_ && problem.b.size() < static_cast<Eigen::Index>(responses.rows().size()))
    problem.reserve_rates(static_cast<int>(responses.rows().size()));
  const bool impact = contacts.find_impacts(s);
  problem.least = impact ? ContactProblem::Least::where_singular : ContactProblem::Least::never;
  // The impulses of an impact are no initial guess for the step after it: in a wedge they may be
  // another solution, a lockup. A heap of bodies without joints always has an impact somewhere;
  // there, each contact decides for itself.
  const auto in_impact_last = [](const StepContact& c) { return c.steps == 1 && c.last_n > 0; };
  const bool heap = islands_ && s.system.rows() == 0,
             any = !heap &&
                   std::ranges::any_of(contacts.live(), [&](int k) { return in_impact_last(contacts[k]); });
  for (const int k : contacts.live()) {
    auto& c = contacts[k];
    c.unknown = -1;
    if (!c.active) continue;
    c.u_n_minus = c.row.normal.dot(s.v_old.data()) + c.bias_n;
    ContactUnknown u;
    const int place = islands_ ? responses.first(k) : 0;
    u.normal = add_row(c.row.normal, s, -c.bias_n, place, responses);
    u.target_n = all && !c.soft ? -c.restitution * c.u_n_minus : 0;
    const bool guess = heap ? !first || !in_impact_last(c) : !any;
    u.impulse_n = guess ? c.last_n : 0;
    if (c.row.tangent.size > 0) {
      const auto& surface = contacts.facts(k).surface;
      u.tangent = add_row(c.row.tangent, s, -c.bias_t, place + 1, responses);
      const double slide = c.row.tangent.dot(s.v_old.data());
      u.friction = surface.friction_at(slide);
      if (surface.friction_by_speed() && !(heap ? c.in_impact : impact))
        sliding_.add({static_cast<int>(problem.unknowns.size()), &surface, slide + c.bias_t});
      u.impulse_t = guess ? c.last_t : 0;
      // Reversal of sliding is for impacts only; it would drive back a lasting contact.
      if (c.u_n_minus < 0 && c.steps == 0 && all && !c.soft)
        u.target_t = -surface.tangential_restitution * (slide + c.bias_t);
    }
    c.unknown = static_cast<int>(problem.unknowns.size());
    problem.unknowns.push_back(u);
    if (islands_) id_.push_back(s.system.frictions() + k);
  }
  if (all && contacts.restitution_by_speed())
    for (const int k : contacts.live())
      if (const auto& c = contacts[k]; c.active && !c.soft)
        problem.unknowns[c.unknown].target_n = -c.restitution_at(-c.u_n_minus) * c.u_n_minus;
  for (int k = 0; k < s.system.frictions(); ++k) {
    ContactUnknown u;
    if (islands_) id_.push_back(k);
    u.tangent =
        add_row(slides[k], s, -rate_bias(slide_gamma[k], h), islands_ ? responses.friction(k) : 0, responses);
    u.bound = h * s.system.friction_facts(k).bound;
    u.impulse_t = slide_last[k];
    problem.unknowns.push_back(u);
  }
}

/// Solves the present problem and adds its impulses to v and, without islands, to lambda.
bool StepProblem::solve_contacts(StepData& s, ContactSet& contacts, ImpulseResponses& responses,
                                 FilmStep& films) {
  if (!islands_) {
    assemble(problem, s, responses, films, late_multipliers_ ? Multipliers::kept : Multipliers::all);
    if (bounds_.size() > 0) bounds_.find_driven(s, *this);
  }
  const auto solve = [&] { return solve_present(s, responses); };
  const auto result =
      sliding_.any() ? sliding_.solve(problem.unknowns, solve, [&](int row) { return rate(row); }) : solve();
  if (result.solved && sliding_.any() && !sliding_.met())
    return s.fail(fmt::format(
        "t = {:.9g} s: coefficients of friction that depend on the sliding speed differ from those of the "
        "motion by {:.2g}, relative, after all iterations; use a smaller step",
        s.t_old, sliding_.residual()));
  if (!result.solved) {
    if (s.failure.empty())
      s.failure = fmt::format(
          "t = {:.9g} s: none of the solvers solved the contact problem of {} contacts ({} tried, residual "
          "{:.2g} m/s); use a smaller step",
          s.t_old, problem.unknowns.size(), result.retries, result.residual_rate);
    return false;
  }
  if (islands_ ? islands_->doubtful() : problem.doubtful()) note_painleve(s, contacts, result);
  if (!islands_) {
    act(problem, s, responses);
    return true;
  }
  for (const auto& c : problem.unknowns)
    for (const auto& [row, impulse] : {std::pair{c.normal, c.impulse_n}, std::pair{c.tangent, c.impulse_t}})
      if (row >= 0 && impulse != 0) responses.push(place(row), impulse, s.v.data());
  return true;
}

/// Solves the present problem with its coefficients of friction.
ContactSolution StepProblem::solve_present(StepData& s, ImpulseResponses& responses) {
  if (islands_) return solve_islands(s, responses);
  return bounds_.size() > 0 ? bounds_.solve(s, *this, responses) : solve_laws(s);
}

/// Solves the present problem in islands; react_to_all() computes the reactions.
ContactSolution StepProblem::solve_islands(StepData& s, ImpulseResponses& responses) {
  auto& totals = s.totals;
  for (const int place : place_) responses.respond(s.saddle, place);
  const auto solve = [&] {
    ++totals.work.lcp_solves;
    return islands_->solve(problem, place_, id_, responses.rows(), responses.sparse());
  };
  auto result = solve();
  if (!result.solved && strip_restitution()) {
    result.count(totals.work, totals.extremes);
    islands_->clear();
    result = solve();
    totals.found.inelastic += result.solved;
  }
  result.count(totals.work, totals.extremes);
  return result;
}

ContactSolution StepProblem::solve_laws(StepData& s) {
  auto& totals = s.totals;
  auto result = problem.solve();
  ++totals.work.lcp_solves;
  if (!result.solved && strip_restitution()) {
    result.count(totals.work, totals.extremes);
    result = problem.solve();
    totals.found.inelastic += result.solved;
  }
  result.count(totals.work, totals.extremes);
  return result;
}

/// Removes restitution from the present problem; returns false if there was none.
bool StepProblem::strip_restitution() {
  bool any = false;
  for (auto& u : problem.unknowns) {
    any = any || u.target_n != 0 || u.target_t != 0;
    u.target_n = u.target_t = 0;
  }
  return any;
}

/// Computes the joints' impulses with all impulses of contacts and friction.
void StepProblem::react_to_all(StepData& s, const ImpulseResponses& responses) const {
  for (const auto& c : problem.unknowns)
    for (const auto& [row, impulse] : {std::pair{c.normal, c.impulse_n}, std::pair{c.tangent, c.impulse_t}})
      if (row >= 0 && impulse != 0) responses.row(place(row)).add_to(s.force.data(), impulse);
  s.saddle.solve(s.force.data(), s.r.data(), s.dq.data(), s.lambda.data());
}

/// Records the first problem with more than one motion, and the first contact that slid without
/// approach and was stopped by an impulse, because friction admits no finite force on the sliding
/// body.
void StepProblem::note_painleve(StepData& s, const ContactSet& contacts,
                                const ContactSolution& result) const {
  auto& found = s.totals.found;
  found.undecided += result.undecided;
  if (result.ambiguous && found.motions.empty()) {
    const std::string joint = "a preloaded joint";
    const auto by_unknown = [&](int i) {
      for (const int k : contacts.live())
        if (contacts[k].unknown == i) return contacts.facts(k).name;
      return joint;
    };
    const auto by_id = [&](int i) {
      const int k = islands_->ambiguous_ids()[i] - s.system.frictions();
      return k >= 0 ? contacts.facts(k).name : joint;
    };
    found.motions = fmt::format("t = {:.9g} s: {}", s.t_old,
                                islands_ ? describe_motions(islands_->ambiguous(), by_id, "N s")
                                         : describe_motions(problem, by_unknown, "N s"));
  }
  for (const int k : contacts.live()) {
    const auto& c = contacts[k];
    if (c.unknown < 0 || c.row.tangent.size == 0) continue;
    const auto& u = problem.unknowns[c.unknown];
    const double slide = c.row.tangent.dot(s.v_old.data()), after = rate(u.tangent);
    const double side = slide > 0 ? 1 : -1;
    const double slope = D(u.normal, u.normal) - side * u.friction * D(u.normal, u.tangent);
    // A contact at rest does not slide: rounding leaves it far below what the step's forces do. A lockup
    // stops a sliding contact that hardly approaches; both shares are of the sliding speed.
    constexpr double at_rest = 1e-6, most_approach = 1e-4, stopped = 1e-3;
    const bool slides = std::abs(slide) > at_rest * std::abs(problem.b[u.tangent] - slide);
    if (slides && u.impulse_n > 0 && slope <= 0 && -c.u_n_minus <= most_approach * std::abs(slide) &&
        side * after <= stopped * std::abs(slide) && found.lockups++ == 0)
      found.lockup = fmt::format("t = {:.9g} s, {}", s.t_old, contacts.facts(k).name);
  }
}

}  // namespace freeplay
