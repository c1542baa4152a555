// Friction in joints that their reactions bound (docs/decisions/019): bounds of a step's contact problem that agree with the
// impulses they lead to.
#include <fmt/format.h>

#include <algorithm>

#include "formulations/time_stepping/moreau.hpp"

namespace freeplay {

/// A step of what is closed is followed by meet_rates(), whose impulses are of second order, but the joints' reactions as
/// much as those of the step: without them the rows would know the speeds of its beginning alone. Looked at ahead.
void MoreauStepper::look_at_end(double h) {
  v_end_ = v_;
  for (const auto& c : problem_.unknowns)
    for (const auto& [row, impulse] : {std::pair{c.normal, c.impulse_n}, std::pair{c.tangent, c.impulse_t}})
      if (row >= 0)
        for (int i = 0; i < system_.n(); ++i) v_end_[i] += impulse * response(row)[i];
  for (int i = 0; i < system_.n(); ++i) q_end_[i] = q_mid_[i] + 0.5 * h * v_end_[i];
  system_.place(t_, q_end_.data(), end_);
  for (int k = 0; k < system_.rows(); ++k)
    r_[k] = -end_.phi_t[k] - row_dot(system_.pattern(), end_.G.data(), k, v_end_.data());
  saddle_.solve(nullptr, r_.data(), dq_.data(), taken_back_.data());
}

/// A row that no force moves, of a joint whose motion is prescribed, is given a diagonal so small that friction there always
/// has its bound, against the rate: twice the bound would not stop it.
void MoreauStepper::hold_driven() {
  const auto preloaded = problem_.unknowns.size() - slides_.size();
  for (std::size_t k = 0; k < slides_.size(); ++k) {
    if (!(driven_[k] > 0)) continue;
    const auto& u = problem_.unknowns[preloaded + k];
    const double rate = std::abs(problem_.b[u.tangent]);
    problem_.D(u.tangent, u.tangent) = rate > 0 && u.bound > 0 ? 0.5 * rate / u.bound : driven_[k];
  }
}

/// The bounds that the present impulses give, in bound_image_.
void MoreauStepper::follow_bounds() {
  const auto preloaded = problem_.unknowns.size() - slides_.size();
  const double h = t_ - t_old_;
  if (reach_ == Reach::closed)
    look_at_end(h);
  else
    std::ranges::fill(taken_back_, 0.0);
  for (int i = 0; i < coupled_.size(); ++i) {
    const int k = coupled_.friction(i);
    const auto& bound = *system_.friction_facts(k).reaction;
    double reactions[2] = {lambda_[bound.row] + taken_back_[bound.row],
                           lambda_[bound.row + 1] + taken_back_[bound.row + 1]};
    for (const auto& c : problem_.unknowns)
      for (const auto& [row, impulse] : {std::pair{c.normal, c.impulse_n}, std::pair{c.tangent, c.impulse_t}})
        for (const int which : {0, 1})
          if (row >= 0) reactions[which] += impulse * reaction(row)[bound.row + which];
    const auto& u = problem_.unknowns[preloaded + static_cast<std::size_t>(k)];
    const double own = driven_[static_cast<std::size_t>(k)] > 0 ? problem_.b[u.tangent]
                                                                : problem_.rate(u.tangent),
                 after = own + 0.5 * h * slide_gamma_[k],
                 mean = 0.5 * (slides_[k].dot(v_old_.data()) + after);
    bound_image_[i] = bound.coefficient(mean) * bound.support(reactions[0], reactions[1]);
  }
}

/// Whether the present impulses obey the laws with the bounds that they give: what sticks lies within its own, whatever it was
/// given (of joints that stick together the impulses are not unique, and the bounds need not settle); what slides has it.
bool MoreauStepper::laws_hold(double share) const {
  const auto preloaded = problem_.unknowns.size() - slides_.size();
  const double size = bound_image_.maxCoeff();
  for (int i = 0; i < coupled_.size(); ++i) {
    const auto& u = problem_.unknowns[preloaded + static_cast<std::size_t>(coupled_.friction(i))];
    const double impulse = std::abs(u.impulse_t);
    const bool sticks =
        impulse < u.bound * (1 - 1e-9) || std::abs(problem_.rate(u.tangent)) <= 1e-10 * slide_scale_;
    if (sticks ? impulse > bound_image_[i] : !(std::abs(bound_image_[i] - u.bound) <= share * size))
      return false;
  }
  return true;
}

/// The laws with bounds that begin with `first` and agree with the impulses in the end; else a failure.
ContactSolution MoreauStepper::settle_bounds(const Eigen::VectorXd& first) {
  const auto preloaded = problem_.unknowns.size() - slides_.size();
  bounds_.start(first);
  ContactSolution result;
  do {
    for (int i = 0; i < coupled_.size(); ++i)
      problem_.unknowns[preloaded + static_cast<std::size_t>(coupled_.friction(i))].bound =
          bounds_.bounds()[i];
    hold_driven();
    result = solve_laws();
    if (!result.solved) return result;
    follow_bounds();
    if (laws_hold(bounds_.count() > 15 ? BoundIteration::accepted : 1e-14)) return result;
    // Joints that stick together may share their impulses in many ways: a little less than their bounds, if that holds.
    if (bounds_.count() == 20 || bounds_.count() == 40) {
      for (int i = 0; i < coupled_.size(); ++i)
        problem_.unknowns[preloaded + static_cast<std::size_t>(coupled_.friction(i))].bound =
            (bounds_.count() == 20 ? 0.95 : 0.7) * bound_image_[i];
      const auto less = solve_laws();
      if (!less.solved) return less;
      follow_bounds();
      if (laws_hold(BoundIteration::accepted)) return less;
    }
  } while (bounds_.refine(bound_image_));
  result.solved = bounds_.met();
  if (!result.solved)
    failure_ =
        fmt::format("t = {:.9g} s: {}; after {} tries bounds and reactions differ by {:.2g} of them", t_old_,
                    words_of(CoupledFriction::Outcome::none), bounds_.count(), bounds_.residual());
  return result;
}

/// The laws with friction that the reactions bound. Where these grow faster than it does, other motions are looked for.
ContactSolution MoreauStepper::solve_bounds() {
  const auto preloaded = problem_.unknowns.size() - slides_.size();
  bound_image_.resize(coupled_.size());
  driven_.assign(slides_.size(), 0.0);
  for (std::size_t k = 0; k < slides_.size(); ++k) {
    const int row = problem_.unknowns[preloaded + k].tangent;
    const auto& slide = slides_[k];
    double free = 0;  // its mobility without constraints
    for (int i = 0; i < slide.size; ++i)
      free += slide.value[i] * slide.value[i] / system_.mass()[slide.column[i]];
    slide_scale_ = std::max({slide_scale_, std::abs(problem_.b[row]), std::abs(slide.dot(v_old_.data()))});
    driven_[k] = std::abs(problem_.D(row, row)) <= 1e-12 * free ? free : 0;
    if (driven_[k] == 0) continue;
    for (int r = 0; r < problem_.rows; ++r) problem_.D(r, row) = problem_.D(row, r) = 0;
  }
  for (int i = 0; i < coupled_.size(); ++i) {
    const auto k = static_cast<std::size_t>(coupled_.friction(i));
    const auto& u = problem_.unknowns[preloaded + k];
    coupled_.factor(i) = system_.friction_facts(static_cast<int>(k)).reaction->coefficient(0.0);
    coupled_.column(i, reaction(u.tangent));
    bound_image_[i] = std::abs(u.impulse_t);
  }
  auto result = settle_bounds(bound_image_);
  if (!result.solved) return result;
  if (std::isfinite(bounds_.residual()) && !laws_hold(1e-14))
    extremes_.friction_residual = std::max(extremes_.friction_residual, bounds_.residual());
  if (coupled_.gain() < 1) return result;
  found_ = problem_.unknowns;
  double size = bounds_.bounds().maxCoeff();
  for (std::size_t k = 0; k < slides_.size(); ++k)  // what would hold each alone
    if (const int row = problem_.unknowns[preloaded + k].tangent; driven_[k] == 0)
      size = std::max(size, std::abs(problem_.b[row]) / problem_.D(row, row));
  for (const double from : {0.0, 100.0}) {
    bound_start_.setConstant(coupled_.size(), from * size);
    auto other = settle_bounds(bound_start_);
    failure_.clear();
    if (!other.solved) continue;
    for (std::size_t k = 0; k < slides_.size(); ++k) {
      const auto& was = found_[preloaded + k];
      const double other_by = std::abs(problem_.unknowns[preloaded + k].impulse_t - was.impulse_t);
      // Beyond what moves the joint by rounding of its speeds.
      if (driven_[k] > 0 || !(other_by > 1e-6 * size) ||
          !(other_by * problem_.D(was.tangent, was.tangent) > 1e-9 * slide_scale_))
        continue;
      failure_ = fmt::format("t = {:.9g} s: {}", t_old_, words_of(CoupledFriction::Outcome::several));
      result.solved = false;
      return result;
    }
  }
  problem_.unknowns = found_;
  if (locked_++ == 0) locked_since_ = t_old_;
  return result;
}

}  // namespace freeplay
