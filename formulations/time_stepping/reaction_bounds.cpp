#include "formulations/time_stepping/reaction_bounds.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "formulations/time_stepping/step_problem.hpp"

namespace freeplay {

ReactionBounds::ReactionBounds(const System& system)
    : coupled_(system), q_end_(system.n()), v_end_(system.n()), taken_back_(system.rows()) {}

/// EndRates follows a smooth step. Its impulses are of second order, but belong to the joints'
/// reactions like those of the step: without them the rows would only depend on the velocities at
/// its beginning. They are therefore predicted here.
void ReactionBounds::look_at_end(StepData& s, const StepProblem& p, const ImpulseResponses& responses) {
  const int n = s.system.n();
  v_end_ = s.v;
  for (const auto& c : p.problem.unknowns)
    for (const auto& [row, impulse] : {std::pair{c.normal, c.impulse_n}, std::pair{c.tangent, c.impulse_t}})
      if (row >= 0)
        for (int i = 0; i < n; ++i) v_end_[i] += impulse * responses.response(row)[i];
  for (int i = 0; i < n; ++i) q_end_[i] = s.q_mid[i] + 0.5 * s.length() * v_end_[i];
  s.system.place(s.t, q_end_.data(), s.end);
  for (int k = 0; k < s.system.rows(); ++k)
    s.r[k] = -s.end.phi_t[k] - row_dot(s.system.pattern(), s.end.G.data(), k, v_end_.data());
  s.saddle.solve(nullptr, s.r.data(), s.dq.data(), taken_back_.data());
}

/// Finds the rows that no force can move; their entries of D are zero up to rounding.
void ReactionBounds::find_driven(StepData& s, StepProblem& p) {
  auto& problem = p.problem;
  driven_.assign(p.slides.size(), 0.0);
  for (std::size_t k = 0; k < p.slides.size(); ++k) {
    const int row = p.friction(static_cast<int>(k)).tangent;
    const auto& slide = p.slides[k];
    double free = 0;  // mobility of the row without constraints
    for (int i = 0; i < slide.size; ++i)
      free += slide.value[i] * slide.value[i] / s.system.mass()[slide.column[i]];
    slide_scale = std::max({slide_scale, std::abs(problem.b[row]), std::abs(slide.dot(s.v_old.data()))});
    driven_[k] = std::abs(problem.D(row, row)) <= 1e-12 * free ? free : 0;
    if (driven_[k] == 0) continue;
    for (int r = 0; r < problem.rows; ++r) problem.D(r, row) = problem.D(row, r) = 0;
  }
}

/// Gives a driven row a diagonal so small that friction there is always at its bound and opposed to
/// the rate: twice the bound would not stop it.
void ReactionBounds::hold_driven(StepProblem& p) const {
  for (std::size_t k = 0; k < p.slides.size(); ++k) {
    if (!(driven_[k] > 0)) continue;
    const auto& u = p.friction(static_cast<int>(k));
    const double rate = std::abs(p.problem.b[u.tangent]);
    p.problem.D(u.tangent, u.tangent) = rate > 0 && u.bound > 0 ? 0.5 * rate / u.bound : driven_[k];
  }
}

/// Computes the bounds from the present impulses in image_.
void ReactionBounds::follow(StepData& s, const StepProblem& p, const ImpulseResponses& responses) {
  const auto& problem = p.problem;
  const double h = s.length();
  if (s.smooth())
    look_at_end(s, p, responses);
  else
    std::ranges::fill(taken_back_, 0.0);
  for (int i = 0; i < coupled_.size(); ++i) {
    const int k = coupled_.friction(i);
    const auto& bound = *s.system.friction_facts(k).reaction;
    auto reactions = bound.reactions(s.lambda.data());
    const auto add = [&](const double* lambda, double weight) {
      const auto by = bound.reactions(lambda);
      for (const std::size_t which : {0U, 1U}) reactions[which] += weight * by[which];
    };
    add(taken_back_.data(), 1);
    for (const auto& c : problem.unknowns)
      for (const auto& [row, impulse] : {std::pair{c.normal, c.impulse_n}, std::pair{c.tangent, c.impulse_t}})
        if (row >= 0) add(responses.reaction(row), impulse);
    const auto& u = p.friction(k);
    const double own = driven_[static_cast<std::size_t>(k)] > 0 ? problem.b[u.tangent]
                                                                : problem.rate(u.tangent),
                 after = own + 0.5 * h * p.slide_gamma[k],
                 mean = 0.5 * (p.slides[k].dot(s.v_old.data()) + after);
    image_[i] = bound.coefficient(mean) * bound.support(reactions, u.impulse_t != 0 ? u.impulse_t : -own, h);
  }
}

/// Whether the present impulses satisfy the laws with the bounds that they give. A sticking joint
/// must be within its new bound, whatever its given bound (impulses of joints that stick together
/// are not unique, and their bounds need not converge); a sliding joint must be at its bound.
bool ReactionBounds::laws_hold(double share, const StepProblem& p) const {
  const double size = image_.maxCoeff();
  for (int i = 0; i < coupled_.size(); ++i) {
    const auto& u = p.friction(coupled_.friction(i));
    const double impulse = std::abs(u.impulse_t);
    const bool sticks =
        impulse < u.bound * (1 - 1e-9) || std::abs(p.problem.rate(u.tangent)) <= 1e-10 * slide_scale;
    if (sticks ? impulse > image_[i] : !(std::abs(image_[i] - u.bound) <= share * size)) return false;
  }
  return true;
}

/// Solves the laws with bounds that start with `first` and are iterated until they agree with the
/// impulses; otherwise fails.
ContactSolution ReactionBounds::settle(const Eigen::VectorXd& first, StepData& s, StepProblem& p,
                                       const ImpulseResponses& responses) {
  iteration_.start(first);
  ContactSolution result;
  do {
    for (int i = 0; i < coupled_.size(); ++i) p.friction(coupled_.friction(i)).bound = iteration_.bounds()[i];
    hold_driven(p);
    result = p.solve_laws(s);
    if (!result.solved) return result;
    follow(s, p, responses);
    if (laws_hold(iteration_.count() > 15 ? BoundIteration::accepted : 1e-14, p)) return result;
    // Joints that stick together may share their impulses in many ways: try bounds a little lower.
    if (iteration_.count() == 20 || iteration_.count() == 40) {
      for (int i = 0; i < coupled_.size(); ++i)
        p.friction(coupled_.friction(i)).bound = (iteration_.count() == 20 ? 0.95 : 0.7) * image_[i];
      const auto less = p.solve_laws(s);
      if (!less.solved) return less;
      follow(s, p, responses);
      if (laws_hold(BoundIteration::accepted, p)) return less;
    }
  } while (iteration_.refine(image_));
  result.solved = iteration_.met();
  if (!result.solved)
    s.failure = fmt::format(
        "t = {:.9g} s: {}; after {} iterations bounds and reactions differ by {:.2g}, relative", s.t_old,
        words_of(CoupledFriction::Outcome::none), iteration_.count(), iteration_.residual());
  return result;
}

ContactSolution ReactionBounds::solve(StepData& s, StepProblem& p, ImpulseResponses& responses) {
  auto& problem = p.problem;
  image_.resize(coupled_.size());
  for (int i = 0; i < coupled_.size(); ++i) {
    const int k = coupled_.friction(i);
    const auto& u = p.friction(k);
    coupled_.factor(i) = s.system.friction_facts(k).reaction->coefficient(0.0);
    coupled_.column(i, responses.reaction(u.tangent));
    image_[i] = std::abs(u.impulse_t);
    // From the last impulse, friction that holds would creep: the bound of its rate is a tolerance.
    if (const auto& bound = *s.system.friction_facts(k).reaction;
        !bound.reads_reactions() && u.impulse_t != 0 &&
        std::abs(p.slides[static_cast<std::size_t>(k)].dot(s.v_old.data())) <= 1e-10 * slide_scale)
      image_[i] = bound.coefficient(0.0) * bound.support({}, u.impulse_t, s.length());
  }
  auto result = settle(image_, s, p, responses);
  if (!result.solved) return result;
  auto& extremes = s.totals.extremes;
  if (std::isfinite(iteration_.residual()) && !laws_hold(1e-14, p))
    extremes.friction_residual = std::max(extremes.friction_residual, iteration_.residual());
  if (coupled_.gain() < 1) return result;
  found_ = problem.unknowns;
  const std::size_t preloaded = found_.size() - p.slides.size();
  double size = iteration_.bounds().maxCoeff();
  for (std::size_t k = 0; k < p.slides.size(); ++k)  // impulse that would stop each joint alone
    if (const int row = problem.unknowns[preloaded + k].tangent; driven_[k] == 0)
      size = std::max(size, std::abs(problem.b[row]) / problem.D(row, row));
  for (const double from : {0.0, 100.0}) {
    start_.setConstant(coupled_.size(), from * size);
    auto other = settle(start_, s, p, responses);
    s.failure.clear();
    if (!other.solved) continue;
    for (std::size_t k = 0; k < p.slides.size(); ++k) {
      const auto& was = found_[preloaded + k];
      const double other_by = std::abs(problem.unknowns[preloaded + k].impulse_t - was.impulse_t);
      // A difference beyond the rounding of the joint's sliding speed.
      if (driven_[k] > 0 || !(other_by > 1e-6 * size) ||
          !(other_by * problem.D(was.tangent, was.tangent) > 1e-9 * slide_scale))
        continue;
      s.failure = fmt::format("t = {:.9g} s: {}", s.t_old, words_of(CoupledFriction::Outcome::several));
      result.solved = false;
      return result;
    }
  }
  problem.unknowns = found_;
  if (s.totals.found.locked++ == 0) s.totals.found.locked_since = s.t_old;
  return result;
}

}  // namespace freeplay
