// The contact problems of a step of Moreau's: of velocities, and of positions that are brought back.
#include <fmt/format.h>

#include <algorithm>

#include "formulations/nonsmooth/moreau.hpp"
#include "sim/residuals.hpp"

namespace freeplay {

/// Solves the collected problem and adds its impulses to v and Λ.
bool MoreauStepper::solve_contacts() {
  const int n = system_.n(), m = system_.rows();
  for (int r = 0; r < problem_.rows; ++r) {
    saddle_.respond(rows_[r], nullptr, 0, response(r), reaction(r));
    if (films_.any()) films_.relax(response(r), reaction(r));
  }
  for (int r = 0; r < problem_.rows; ++r)
    for (int s = 0; s <= r; ++s) problem_.D(r, s) = problem_.D(s, r) = rows_[r].dot(response(s));
  if (films_.any())  // cavitated, they answer one way otherwise than back
    for (int r = 0; r < problem_.rows; ++r)
      for (int s = r + 1; s < problem_.rows; ++s) problem_.D(r, s) = rows_[r].dot(response(s));
  const auto result = coupled_.size() > 0 ? solve_bounds() : solve_laws();
  if (!result.solved) {
    if (failure_.empty())
      failure_ = fmt::format(
          "t = {:.9g} s: the contact problem of {} contacts was not solved by any of {} solvers: residual "
          "{:.2g} m/s",
          t_old_, problem_.unknowns.size(), result.retries, result.residual_rate);
    return false;
  }
  if (problem_.doubtful()) tell_painleve(result);
  const auto apply = [&](int row, double impulse) {
    if (row < 0 || impulse == 0) return;
    for (int i = 0; i < n; ++i) v_[i] += impulse * response(row)[i];
    for (int k = 0; k < m; ++k) lambda_[k] += impulse * reaction(row)[k];
  };
  for (const auto& c : problem_.unknowns) {
    apply(c.normal, c.impulse_n);
    apply(c.tangent, c.impulse_t);
  }
  return true;
}

ContactSolution MoreauStepper::solve_laws() {
  auto result = problem_.solve();
  ++work_.lcp_solves;
  if (!result.solved && strip_restitution()) {  // Newton's law may ask for rates that no impulse gives
    result.count(work_, extremes_);
    result = problem_.solve();
    inelastic_ += result.solved;
  }
  result.count(work_, extremes_);
  return result;
}

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
  const auto found = problem_.unknowns;
  double size = bounds_.bounds().maxCoeff();
  for (std::size_t k = 0; k < slides_.size(); ++k)  // what would hold each alone
    if (const int row = problem_.unknowns[preloaded + k].tangent; driven_[k] == 0)
      size = std::max(size, std::abs(problem_.b[row]) / problem_.D(row, row));
  for (const double from : {0.0, 100.0}) {
    auto other = settle_bounds(Eigen::VectorXd::Constant(coupled_.size(), from * size));
    failure_.clear();
    if (!other.solved) continue;
    for (std::size_t k = 0; k < slides_.size(); ++k) {
      const auto& was = found[preloaded + k];
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
  problem_.unknowns = found;
  if (locked_++ == 0) locked_since_ = t_old_;
  return result;
}

/// Takes restitution out of the present problem; false where there was none.
bool MoreauStepper::strip_restitution() {
  bool any = false;
  for (auto& u : problem_.unknowns) {
    any = any || u.target_n != 0 || u.target_t != 0;
    u.target_n = u.target_t = 0;
  }
  return any;
}

/// Notes the first problem with more than one motion, and the first contact that slid on without approach and
/// was stopped by an impulse, because friction there admits no finite force on what slides.
void MoreauStepper::tell_painleve(const ContactSolution& result) {
  undecided_ += result.undecided;
  if (result.ambiguous && motions_.empty()) {
    const auto name = [&](int i) {
      for (int k = 0; k < system_.contacts(); ++k)
        if (contacts_[k].unknown == i) return system_.contact_facts(k).name;
      return std::string("a preloaded joint");
    };
    motions_ = fmt::format("t = {:.9g} s: {}", t_old_, describe_motions(problem_, name, "N s"));
  }
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = contacts_[k];
    if (c.unknown < 0 || c.row.tangent.size == 0) continue;
    const auto& u = problem_.unknowns[c.unknown];
    const double slide = c.row.tangent.dot(v_old_.data()), after = problem_.rate(u.tangent);
    const double side = slide > 0 ? 1 : -1;
    const double slope = problem_.D(u.normal, u.normal) - side * u.friction * problem_.D(u.normal, u.tangent);
    if (u.impulse_n > 0 && slope <= 0 && -c.u_n_minus <= 1e-4 * std::abs(slide) &&
        side * after <= 1e-3 * std::abs(slide) && jams_++ == 0)
      jam_ = fmt::format("t = {:.9g} s, {}", t_old_, system_.contact_facts(k).name);
  }
}

void MoreauStepper::tell(std::vector<std::string>& notes) const {
  if (!motions_.empty())
    notes.push_back("Painlevé: friction admits more than one motion, of which one was taken; the first at " +
                    motions_);
  if (jams_ > 0)
    notes.push_back(fmt::format(
        "Painlevé: friction admitted no finite force on what slid, and an impulse stopped it, {} times; the "
        "first at {}",
        jams_, jam_));
  if (undecided_ > 0) notes.push_back(undecided_note(undecided_));
  if (inelastic_ > 0)
    notes.push_back(fmt::format(
        "{} steps with several contacts were taken without restitution, for no solver found impulses with it",
        inelastic_));
  if (unsettled_ > 0)
    notes.push_back(fmt::format(
        "DOUBTFUL: in {} steps contact came and went with the film's force, and none was found that fits both; take a shorter "
        "nonsmooth.step, or \"automatic\"",
        unsettled_));
  if (step_ > 0 && films_.leap.share > 0.3)
    notes.push_back(fmt::format(
        "DOUBTFUL: {} squeezed its film by {:.2g} of its thickness in one step, which takes the film as it was at the step's "
        "middle; take a nonsmooth.step of {:.1g} times this one, or \"automatic\"",
        system_.contact_facts(films_.leap.contact).name, films_.leap.share, 0.1 / films_.leap.share));
  if (locked_ > 0)
    notes.push_back(fmt::format(
        "friction in joints outgrows the reactions that bound it in {} problems, the first at t = {:.9g} s: the mechanism "
        "is self-locking there, and what slides may be stopped at once, by impulses",
        locked_, locked_since_));
  if (unswept_ > 0)
    notes.push_back(fmt::format(
        "DOUBTFUL: in {} steps the angle that a torque's table was swept over did not settle: the pulse turns the motion "
        "round within a step; take a shorter nonsmooth.step, or event-driven",
        unswept_));
}

int MoreauStepper::add_row(const SparseRow& row, double end_rate_bias) {
  const int r = problem_.rows++;
  rows_[r] = row;
  problem_.b[r] = row.dot(v_.data()) + end_rate_bias;
  return r;
}

/// A contact takes part once the motion with the other elements' impulses would have closed its gap by the
/// end of the step. True when one was added.
bool MoreauStepper::activate(double h) {
  bool added = false;
  for (auto& c : contacts_) {
    if (c.active || c.row.normal.size == 0 || !in_reach(c)) continue;
    const double end_gap = c.row.gap + 0.5 * h * (c.row.normal.dot(v_.data()) - 0.25 * h * c.row.gamma_n);
    added |= c.active = end_gap <= (c.closed ? slack_ : 0);
  }
  return added;
}

/// Which active contacts are struck, open before and approaching faster than rows turn within the step (what is slower has come
/// off a contact that lasts, and goes on with it), and the bias of every one's rates. True where one is.
bool MoreauStepper::find_struck(double h) {
  bool any = false;
  const auto approach = [&](const Contact& c) { return -c.row.normal.dot(v_old_.data()); };
  for (auto& c : contacts_) {
    if (!c.active) continue;
    c.bias_n = 0.5 * h * c.row.gamma_n;
    c.bias_t = 0.5 * h * c.row.gamma_t;
    c.struck = reach_ == Reach::all && c.steps == 0 && approach(c) > 10 * std::abs(c.bias_n);
    any |= c.struck;
  }
  if (!any) return false;
  if (system_.rows() == 0)
    std::ranges::fill(a_gamma_, 0.0);
  else
    saddle_.solve(nullptr, e_.gamma.data(), a_gamma_.data(), lambda_dq_.data());
  any = false;
  for (auto& c : contacts_) {
    if (!c.active || !c.struck) continue;
    const double bias = 0.5 * h * c.row.normal.dot(a_gamma_.data());
    c.struck = approach(c) > 10 * std::abs(bias);
    if (!c.struck) continue;
    any = true;
    c.bias_n = bias;
    if (c.row.tangent.size > 0) c.bias_t = 0.5 * h * c.row.tangent.dot(a_gamma_.data());
  }
  return any;
}

/// The contact problem of the active contacts and the preloaded joints.
void MoreauStepper::collect(double h) {
  problem_.clear();
  problem_.least = find_struck(h) ? ContactProblem::Least::where_singular : ContactProblem::Least::never;
  // An impact's impulses are no guess for the step behind it: in a wedge they may be a solution of their own, that jams.
  const bool guess =
      std::ranges::none_of(contacts_, [](const Contact& c) { return c.steps == 1 && c.last_n > 0; });
  for (auto& c : contacts_) {
    c.unknown = -1;
    if (!c.active) continue;
    c.u_n_minus = c.row.normal.dot(v_old_.data()) + c.bias_n;
    ContactUnknown u;
    u.normal = add_row(c.row.normal, -c.bias_n);
    u.target_n = reach_ == Reach::all && !c.soft ? -c.restitution * c.u_n_minus : 0;
    u.impulse_n = guess ? c.last_n : 0;
    if (c.row.tangent.size > 0) {
      const auto& surface = system_.contact_facts(static_cast<int>(&c - contacts_.data())).surface;
      u.tangent = add_row(c.row.tangent, -c.bias_t);
      u.friction = *surface.friction;
      u.impulse_t = guess ? c.last_t : 0;
      // Reversal belongs to impacts; a contact that lasts would be driven back by it.
      if (c.u_n_minus < 0 && c.steps == 0 && reach_ == Reach::all && !c.soft)
        u.target_t = -surface.tangential_restitution * (c.row.tangent.dot(v_old_.data()) + c.bias_t);
    }
    c.unknown = static_cast<int>(problem_.unknowns.size());
    problem_.unknowns.push_back(u);
  }
  for (int k = 0; k < system_.frictions(); ++k) {
    ContactUnknown u;
    u.tangent = add_row(slides_[k], -0.5 * h * slide_gamma_[k]);
    u.bound = h * system_.friction_facts(k).bound;
    u.impulse_t = slide_last_[k];
    problem_.unknowns.push_back(u);
  }
}

/// What is pressed drifts off by an error of third order as well as in: it is moved back one by one, which is enough for
/// gaps that are a small part of the tolerance.
void MoreauStepper::draw_closed(double t_new) {
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = contacts_[k];
    if (!c.closed || c.unknown < 0 || !(problem_.unknowns[c.unknown].impulse_n > 0)) continue;
    c.gap = system_.gap(k, q_.data(), end_);
    if (!(c.gap > 0.01 * slack_)) continue;
    saddle_.respond(c.row.normal, nullptr, 0, dq_.data(), lambda_dq_.data());
    const double by = c.gap / c.row.normal.dot(dq_.data());
    for (int i = 0; i < system_.n(); ++i) q_[i] -= by * dq_[i];
    system_.place(t_new, q_.data(), end_);
    c.gap = system_.gap(k, q_.data(), end_);
  }
}

/// One Newton step of least mass-weighted length onto Φ(q⁺, t⁺) = 0, then contacts whose gap is still
/// negative are opened to zero along A W_N, which leaves Φ alone to first order.
bool MoreauStepper::bring_back(double t_new) {
  const int n = system_.n(), m = system_.rows();
  const double potential = system_.potential(q_.data());
  if (films_.any()) films_.displace(q_.data(), [&](int k) { return contacts_[k].unknown >= 0; });
  system_.place(t_new, q_.data(), end_);
  const auto move = [&](const double* dq) {
    for (int i = 0; i < n; ++i) q_[i] += dq[i];
  };
  if (m > 0) {
    for (int k = 0; k < m; ++k) r_[k] = -end_.phi[k];
    saddle_.solve(nullptr, r_.data(), dq_.data(), lambda_dq_.data());
    move(dq_.data());
    system_.place(t_new, q_.data(), end_);
  }
  bool moved = false;
  for (auto& c : contacts_) {
    const int k = static_cast<int>(&c - contacts_.data());
    c.gap = system_.gap(k, q_.data(), end_);
    moved |= c.gap < 0 && in_reach(c);
  }
  if (moved) {
    position_problem_.clear();
    auto& p = position_problem_;
    for (auto& c : contacts_) {
      if (c.row.normal.size == 0 || !in_reach(c) || (c.gap >= 0 && c.unknown < 0)) continue;
      rows_[p.rows] = c.row.normal;
      saddle_.respond(c.row.normal, nullptr, 0, response(p.rows), reaction(p.rows));
      ContactUnknown u;
      u.normal = p.rows;
      p.b[p.rows++] = c.gap;
      p.unknowns.push_back(u);
    }
    for (int r = 0; r < p.rows; ++r)
      for (int s = 0; s <= r; ++s) p.D(r, s) = p.D(s, r) = rows_[r].dot(response(s));
    const auto result = p.solve();
    work_.pivots += result.pivots;
    if (!result.solved) {
      failure_ = fmt::format("t = {:.9g} s: the positions of {} contacts cannot be brought back together",
                             t_new, p.rows);
      return false;
    }
    for (const auto& u : p.unknowns)
      if (u.impulse_n > 0) {
        for (int i = 0; i < n; ++i) dq_[i] = u.impulse_n * response(u.normal)[i];
        move(dq_.data());
      }
    system_.place(t_new, q_.data(), end_);
  }
  if (reach_ == Reach::closed) draw_closed(t_new);
  integrals_.stabilisation += system_.potential(q_.data()) - potential;
  for (int k = 0; k < system_.contacts(); ++k) {
    if (moved || reach_ == Reach::closed) contacts_[k].gap = system_.gap(k, q_.data(), end_);
    if (in_reach(contacts_[k]))
      extremes_.penetration[k] = std::max(extremes_.penetration[k], -contacts_[k].gap);
  }
  keep_residuals(system_, end_, extremes_);
  return true;
}

/// Rates at the middle of a step, continued by ±(h/2)γ, miss those at its end by an error of third order, by which what
/// stays in contact on a turning normal would lift off: least mass-weighted change of v onto the rates at q⁺ of joints, of
/// what is pressed and of what sticks. Of what slides the error is of second order, γ being that of v⁻: friction has its
/// share of what brings its normal rate back, W_N + (P_T/P_N) W_T, or it would be of first order over a run.
bool MoreauStepper::meet_rates() {
  const int n = system_.n(), m = system_.rows();
  const auto preloaded = problem_.unknowns.size() - slides_.size();
  const auto sticks = [](const ContactUnknown& u, double bound) {
    return u.tangent >= 0 && std::abs(u.impulse_t) < bound * (1 - 1e-9);
  };
  int used = 0;
  const auto take = [&](const SparseRow& row, double least) {
    least_impulse_[used] = least;
    slope_[used] = 0;
    held_[used] = -1;
    rows_[used++] = row;
  };
  const auto each_pressed = [&](auto take) {
    for (int k = 0; k < system_.contacts(); ++k) {
      const auto& c = contacts_[k];
      if (!c.closed || c.unknown < 0) continue;
      const auto& u = problem_.unknowns[c.unknown];
      if (u.impulse_n > 0) take(k, sticks(u, u.friction * u.impulse_n));
    }
  };
  const auto each_preloaded = [&](auto take) {
    for (int k = 0; k < system_.frictions(); ++k) {
      const auto& u = problem_.unknowns[preloaded + static_cast<std::size_t>(k)];
      if (sticks(u, u.bound) && (driven_.empty() || driven_[static_cast<std::size_t>(k)] == 0)) take(k);
    }
  };
  const auto look = [&](int k) { system_.contact(k, q_.data(), v_.data(), end_, end_row_); };
  const auto look_along = [&](int k) { system_.friction(k, q_.data(), v_.data(), end_, end_row_.tangent); };
  each_pressed([&](int k, bool stuck) {
    look(k);
    const auto& u = problem_.unknowns[contacts_[k].unknown];
    take(end_row_.normal, -u.impulse_n);
    if (stuck) {
      take(end_row_.tangent, -INFINITY);
      held_[used - 1] = contacts_[k].unknown;
    } else if (u.tangent >= 0) {
      slope_[used - 1] = u.impulse_t / u.impulse_n;
      along_[used - 1] = end_row_.tangent;
    }
  });
  each_preloaded([&](int k) {
    look_along(k);
    take(end_row_.tangent, -INFINITY);
  });
  if (m == 0 && used == 0) return true;
  ++work_.factorisations;
  if (!saddle_.factor(end_.G.data())) {
    failure_ =
        fmt::format("t = {:.9g} s: the constraint equations are not finite or cannot be factorised", t_);
    return false;
  }
  const double before = system_.kinetic(v_.data());
  for (int k = 0; k < m; ++k)
    r_[k] = -end_.phi_t[k] - row_dot(system_.pattern(), end_.G.data(), k, v_.data());
  saddle_.solve(nullptr, r_.data(), dq_.data(), lambda_dq_.data());
  for (int r = 0; r < used; ++r) {
    saddle_.respond(rows_[r], &along_[r], slope_[r], response(r), reaction(r));
    if (!(rows_[r].dot(response(r)) > 0)) {  // friction that draws in (Painlevé)
      slope_[r] = 0;
      saddle_.respond(rows_[r], nullptr, 0, response(r), reaction(r));
    }
    end_impulse_[r] = 0;
  }
  for (int i = 0; i < n; ++i) v_[i] += dq_[i];
  // One by one, for they may depend on each other.
  double first = 0;
  for (int sweep = 0; sweep < (used > 1 ? 20 : 1); ++sweep) {
    double most = 0;
    for (int r = 0; r < used; ++r) {
      const double rate = rows_[r].dot(v_.data()), d = rows_[r].dot(response(r));
      if (!(d > 0)) continue;
      // No more is taken back than the step has pressed: what still parts then, parts, and friction no longer holds it.
      double impulse = std::max(end_impulse_[r] - rate / d, least_impulse_[r]);
      if (held_[r] >= 0) {
        const auto& u = problem_.unknowns[static_cast<std::size_t>(held_[r])];
        const double bound = u.friction * std::max(0.0, u.impulse_n + end_impulse_[r - 1]);
        impulse = std::clamp(impulse, -bound - u.impulse_t, bound - u.impulse_t);
      }
      const double by = impulse - end_impulse_[r];
      most = std::max(most, std::abs(by) * d);
      end_impulse_[r] = impulse;
      for (int i = 0; i < n; ++i) v_[i] += by * response(r)[i];
    }
    first = std::max(first, most);
    if (!(most > 1e-6 * first)) break;
  }
  double rubbed = 0;
  each_pressed([&, r = 0](int k, bool stuck) mutable {
    const double normal = end_impulse_[r], tangential = slope_[r] * normal;
    if (slope_[r] != 0) rubbed += tangential * along_[r].dot(v_.data());
    ++r;
    contacts_[k].impulse_n += normal;
    contacts_[k].impulse_t += stuck ? end_impulse_[r++] : tangential;
  });
  integrals_.friction -= rubbed;
  integrals_.stabilisation += system_.kinetic(v_.data()) - before - rubbed;
  if (!watching_) return true;
  for (int r = 0; r < used; ++r)
    for (int k = 0; k < m; ++k) lambda_dq_[k] += end_impulse_[r] * reaction(r)[k];
  for (int i = 0; i < n; ++i) {
    smooth_.acceleration[i] += dq_[i];
    for (int r = 0; r < used; ++r) smooth_.acceleration[i] += end_impulse_[r] * response(r)[i];
  }
  system_.report_rows(q_.data(), end_, lambda_dq_.data(), 1, smooth_);
  int r = 0;
  each_pressed([&](int k, bool stuck) {
    look(k);
    const double normal = end_impulse_[r], tangential = slope_[r] * normal;
    ++r;
    system_.report_contact(k, q_.data(), end_, end_row_, normal, stuck ? end_impulse_[r++] : tangential, 1,
                           smooth_);
  });
  each_preloaded([&](int k) {
    look_along(k);
    system_.report_friction(k, q_.data(), v_.data(), end_, end_row_.tangent, end_impulse_[r++], 1, smooth_);
  });
  return true;
}

}  // namespace freeplay
