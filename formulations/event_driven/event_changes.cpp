// What happens at an event: impacts, and the mode that follows.
#include "formulations/event_driven/event_dynamics.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace freeplay {

std::string EventDynamics::strike(Vector& x, double t, const std::vector<int>& struck,
                                  const std::vector<int>& soft, bool jammed) {
  const int n = system_.n(), m = system_.rows();
  double* q = x.data();
  double* v = q + n;
  place(q, t);
  ++work.factorisations;
  ++work.lcp_solves;
  if (!saddle_.factor(e_.G.data())) return "the constraint equations cannot be factorised";
  used_ = 0;
  struck_.clear();
  for (const int k : struck) {
    auto& c = contacts_[k];
    system_.contact(k, q, v, e_, c.row);
    ImpactContact i;
    i.normal = add(c.row.normal, nullptr, 0);
    rhs_[i.normal] = c.row.normal.dot(v);
    const bool inelastic = std::ranges::find(soft, k) != soft.end();
    i.restitution = inelastic ? 0 : c.restitution;
    if (c.row.tangent.size > 0) {
      const auto& surface = system_.contact_facts(k).surface;
      i.tangent = add(c.row.tangent, nullptr, 0);
      rhs_[i.tangent] = c.row.tangent.dot(v);
      i.friction = *surface.friction;
      i.tangential_restitution = inelastic ? 0 : surface.tangential_restitution;
    }
    struck_.push_back(i);
  }
  for (int i = 0; i < coupled_.size(); ++i) {
    auto& p = preloaded_[coupled_.friction(i)];
    system_.friction(coupled_.friction(i), q, v, e_, p.row);
    ImpactContact pin;
    pin.tangent = add(p.row, nullptr, 0);
    rhs_[pin.tangent] = p.row.dot(v);
    struck_.push_back(pin);
  }
  for (int r = 0; r < used_; ++r)
    for (int s = 0; s <= r; ++s) K_(r, s) = K_(s, r) = rows_[r].dot(response(s));
  if (jammed) press_jammed();
  const auto reason =
      coupled_.size() > 0 ? strike_bounded(x, struck.size()) : impact_.solve(K_, rhs_, used_, struck_);
  impact_.solution().count(work, extremes);
  undecided += impact_.solution().undecided;
  wedged += impact_.wedged();
  if (!reason.empty()) return reason;
  for (const auto& i : struck_)
    if (!std::isfinite(i.impulse_n) || !std::isfinite(i.impulse_t))
      return fmt::format("the impact of {} contacts has no finite impulses that any solver finds",
                         struck_.size());
  // What the solver leaves of the laws is no approach.
  speed_tolerance_ = std::max(speed_tolerance_, 2 * impact_.solution().residual_rate);
  double* integral = x.data() + integral_offset();
  std::ranges::fill(struck_lambda_, 0.0);
  const auto apply = [&](int r, double impulse) {
    if (r < 0) return;
    for (int i = 0; i < n; ++i) v[i] += impulse * response(r)[i];
    for (int k = 0; k < m; ++k) {
      integral[drive] += impulse * reaction(r)[k] * e_.phi_t[k];
      struck_lambda_[k] += impulse * reaction(r)[k];
    }
  };
  for (std::size_t i = 0; i < struck.size(); ++i) {
    apply(struck_[i].normal, struck_[i].impulse_n);
    apply(struck_[i].tangent, struck_[i].impulse_t);
    double* impulse = x.data() + impulse_offset() + 2 * struck[i];
    impulse[0] += struck_[i].impulse_n;
    impulse[1] += struck_[i].impulse_t;
  }
  for (std::size_t i = struck.size(); i < struck_.size(); ++i)
    apply(struck_[i].tangent, struck_[i].impulse_t);
  contact_loss -= impact_.normal_work();
  integral[friction_loss] -= impact_.tangential_work();
  return "";
}

/// Rates of an impact without collision: what touches approaches as slowly as can be told from the sliding that is to end; what
/// leaves faster than that has its own rate. Where contacts share their freedoms they are the nearest that a motion has: of
/// others the laws need have no solution (by_copositive_lemke).
void EventDynamics::press_jammed() {
  auto rates = rhs_.head(used_);
  jam_rate_ = std::max(speed_tolerance_, 1e-5 * rates.cwiseAbs().maxCoeff());
  Eigen::VectorXd pressed = rates;
  for (const auto& i : struck_)
    if (i.normal >= 0 && rates[i.normal] <= jam_rate_)
      pressed[i.normal] = std::min(0.0, rates[i.normal]) - jam_rate_;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(1e-10);
  const auto K = K_.topLeftCorner(used_, used_);
  if (decomposition.compute(K); decomposition.rank() < used_)
    pressed = rates + K * decomposition.solve(pressed - rates);
  rates = pressed;
}

/// The impact with friction in joints whose bounds are those of its own reaction impulses.
std::string EventDynamics::strike_bounded(const Vector& x, std::size_t contacts) {
  const double* v = x.data() + system_.n();
  bound_image_.setZero();
  bounds_.start(bound_image_);
  std::vector<double> driven(static_cast<std::size_t>(coupled_.size()));  // as in pose()
  for (std::size_t i = 0; i < driven.size(); ++i) {
    const int own = struck_[contacts + i].tangent;
    const auto& row = rows_[own];
    double free = 0;
    for (int c = 0; c < row.size; ++c) free += row.value[c] * row.value[c] / system_.mass()[row.column[c]];
    if (std::abs(K_(own, own)) > 1e-12 * free) continue;
    driven[i] = free;
    for (int r = 0; r < used_; ++r) K_(r, own) = K_(own, r) = 0;
  }
  do {
    for (std::size_t i = 0; i < driven.size(); ++i) {
      if (driven[i] == 0) continue;
      const int own = struck_[contacts + i].tangent;
      const double bound = bounds_.bounds()[static_cast<Eigen::Index>(i)], rate = std::abs(rhs_[own]);
      K_(own, own) = rate > 0 && bound > 0 ? 0.5 * rate / bound : driven[i];
    }
    for (int i = 0; i < coupled_.size(); ++i) struck_[contacts + i].bound = bounds_.bounds()[i];
    if (auto reason = impact_.solve(K_, rhs_, used_, struck_); !reason.empty()) return reason;
    for (int i = 0; i < coupled_.size(); ++i) {
      const auto& bound = *system_.friction_facts(coupled_.friction(i)).reaction;
      const int own = struck_[contacts + i].tangent;
      double l[2] = {0, 0}, mean = rows_[own].dot(v);
      for (const auto& c : struck_)
        for (const auto& [row, impulse] :
             {std::pair{c.normal, c.impulse_n}, std::pair{c.tangent, c.impulse_t}}) {
          if (row < 0) continue;
          if (row != own || driven[static_cast<std::size_t>(i)] == 0) mean += 0.5 * K_(own, row) * impulse;
          for (const int which : {0, 1}) l[which] += impulse * reaction(row)[bound.row + which];
        }
      bound_image_[i] = bound.coefficient(mean) * bound.support(l[0], l[1]);
    }
  } while (bounds_.refine(bound_image_));
  extremes.friction_residual = std::max(extremes.friction_residual, bounds_.residual());
  return bounds_.met() ? ""
                       : fmt::format("within an impact {}; bounds and reactions differ by {:.2g} of them",
                                     words_of(CoupledFriction::Outcome::none), bounds_.residual());
}

void EventDynamics::report_strike(const Vector& x, const std::vector<int>& struck, Forces& out) {
  const double* q = x.data();
  out.clear();
  system_.report_rows(q, e_, struck_lambda_.data(), 1, out);
  for (std::size_t i = 0; i < struck.size(); ++i) {
    const auto& s = struck_[i];
    system_.report_contact(struck[i], q, e_, contacts_[struck[i]].row, s.impulse_n, s.impulse_t, 1, out);
    for (const auto& [row, impulse] : {std::pair{s.normal, s.impulse_n}, std::pair{s.tangent, s.impulse_t}})
      for (int k = 0; row >= 0 && k < system_.n(); ++k) out.acceleration[k] += impulse * response(row)[k];
  }
  for (std::size_t i = struck.size(); i < struck_.size(); ++i) {
    const auto& s = struck_[i];
    system_.report_friction(coupled_.friction(static_cast<int>(i - struck.size())), q, x.data() + system_.n(),
                            e_, rows_[s.tangent], s.impulse_t, 1, out);
    for (int k = 0; k < system_.n(); ++k) out.acceleration[k] += s.impulse_t * response(s.tangent)[k];
  }
}

/// The problem in accelerations of these contacts and of all preloaded joints at rest, from what
/// solve_free() left; a contact that slides, or is torn, has its friction in its normal's column.
void EventDynamics::pose(const Vector& x, const std::vector<int>& candidates) {
  const double* q = x.data();
  const double* v = q + system_.n();
  posed_ = candidates;
  status_.clear();
  used_ = 0;
  posed_slips_.clear();
  posed_resting_.clear();
  for (const int k : candidates) {
    auto& c = contacts_[k];
    system_.contact(k, q, v, e_, c.row);
    ContactUnknown u;
    int slip = 0;
    double mu = 0;
    if (c.row.tangent.size > 0) {
      mu = *system_.contact_facts(k).surface.friction;
      const double rate = c.row.tangent.dot(v);
      slip = std::abs(rate) > slide_tolerance() ? (rate > 0 ? 1 : -1) : c.forced;
    }
    u.normal = add(c.row.normal, slip != 0 ? &c.row.tangent : nullptr, -slip * mu);
    status_.b[u.normal] = c.row.normal.dot(a_.data()) - c.row.gamma_n;
    if (c.row.tangent.size > 0 && slip == 0) {
      u.tangent = add(c.row.tangent, nullptr, 0);
      status_.b[u.tangent] = c.row.tangent.dot(a_.data()) - c.row.gamma_t;
      u.friction = mu;
    }
    posed_slips_.push_back(slip);
    status_.unknowns.push_back(u);
  }
  for (int k = 0; k < system_.frictions(); ++k) {
    if (preloaded_[k].slip != 0) continue;
    ContactUnknown u;
    u.tangent = add(preloaded_[k].row, nullptr, 0);
    status_.b[u.tangent] = preloaded_[k].row.dot(a_.data()) - preloaded_[k].gamma;
    u.bound = preloaded_[k].bound;
    posed_resting_.push_back(k);
    status_.unknowns.push_back(u);
  }
  status_.rows = used_;
  for (int r = 0; r < used_; ++r)
    for (int s = 0; s < used_; ++s) status_.D(r, s) = rows_[r].dot(response(s));
  for (std::size_t i = posed_.size(); coupled_.size() > 0 && i < status_.unknowns.size(); ++i) {
    // A row that no force moves, of a joint whose motion is prescribed: friction has its bound there, against the rate.
    const auto& u = status_.unknowns[i];
    double free = 0;
    const auto& row = rows_[u.tangent];
    for (int c = 0; c < row.size; ++c) free += row.value[c] * row.value[c] / system_.mass()[row.column[c]];
    if (std::abs(status_.D(u.tangent, u.tangent)) > 1e-12 * free) continue;
    for (int r = 0; r < used_; ++r) status_.D(r, u.tangent) = status_.D(u.tangent, r) = 0;
    const double rate = std::abs(status_.b[u.tangent]);
    status_.D(u.tangent, u.tangent) = rate > 0 && u.bound > 0 ? 0.5 * rate / u.bound : free;
  }
}

std::string EventDynamics::name_of_unknown(int i) const {
  const auto contacts = static_cast<int>(posed_.size());
  return i < contacts ? system_.contact_facts(posed_[i]).name
                      : fmt::format("preloaded joint {}", posed_resting_[i - contacts] + 1);
}

/// Why the problem in accelerations gave no mode.
std::string EventDynamics::unsolved(const ContactSolution& solution) const {
  if (!solution.impossible)
    return fmt::format(
        "the problem in accelerations of {} contacts was not solved by any solver (residual {:.2g} of the "
        "greatest acceleration); whether it has a solution is not known",
        status_.unknowns.size(), solution.residual);
  std::string sliding;
  for (std::size_t i = 0; i < posed_.size(); ++i)
    if (posed_slips_[i] != 0)
      sliding += fmt::format("{}{} {}", sliding.empty() ? "" : ", ", system_.contact_facts(posed_[i]).name,
                             posed_slips_[i] > 0 ? "to the right" : "to the left");
  return fmt::format(
      "friction admits no acceleration (Painlevé): all modes were tried with what slides there ({}); time "
      "stepping gives a consistent impulse",
      sliding);
}

/// The problem in accelerations, with the bounds that its reactions give. In trouble_ why it cannot be posed, or why no
/// bounds are found.
ContactSolution EventDynamics::settle_bounds(const Vector& x, double t, const std::vector<int>& candidates) {
  ContactSolution solution;
  const auto pose_and_solve = [&] {
    if (!solve_free(x, t)) {
      if (trouble_.empty()) trouble_ = "the constraint equations cannot be factorised";
      solution.solved = false;
      return false;
    }
    pose(x, candidates);
    solution = status_.solve();
    return solution.solved;
  };
  if (coupled_.size() == 0) {
    pose_and_solve();
    return solution;
  }
  for (int i = 0; i < coupled_.size(); ++i) bound_image_[i] = preloaded_[coupled_.friction(i)].bound;
  bounds_.start(bound_image_);
  do {
    for (int i = 0; i < coupled_.size(); ++i) preloaded_[coupled_.friction(i)].bound = bounds_.bounds()[i];
    if (!pose_and_solve()) return solution;
    for (int i = 0; i < coupled_.size(); ++i) {
      const int k = coupled_.friction(i);
      const auto& bound = *system_.friction_facts(k).reaction;
      double l[2] = {lambda_[bound.row], lambda_[bound.row + 1]};
      for (const auto& u : status_.unknowns)
        for (const auto& [row, force] : {std::pair{u.normal, u.impulse_n}, std::pair{u.tangent, u.impulse_t}})
          for (const int which : {0, 1})
            if (row >= 0) l[which] += force * reaction(row)[bound.row + which];
      const auto& p = preloaded_[k];
      bound_image_[i] = bound.coefficient(p.slip != 0 ? p.rate : 0) * bound.support(l[0], l[1]);
    }
  } while (bounds_.refine(bound_image_));
  if (!bounds_.met()) {
    trouble_ = fmt::format("{}; after {} tries bounds and reactions differ by {:.2g} of them",
                           words_of(CoupledFriction::Outcome::none), bounds_.count(), bounds_.residual());
    solution.solved = false;
  }
  extremes.friction_residual = std::max(extremes.friction_residual, bounds_.residual());
  return solution;
}

/// Whether bounds that begin elsewhere lead to another motion, where reactions grow faster than the friction they bound.
/// Leaves the problem as it was.
bool EventDynamics::other_motion(const Vector& x, double t, const std::vector<int>& candidates) {
  std::vector<double> a(static_cast<std::size_t>(system_.n())), l(static_cast<std::size_t>(system_.rows()));
  for (int i = 0; i < coupled_.size(); ++i) {
    const int k = coupled_.friction(i);
    saddle_.respond(preloaded_[k].row, nullptr, 0, a.data(), l.data());
    coupled_.factor(i) = system_.friction_facts(k).reaction->coefficient(preloaded_[k].rate);
    coupled_.column(i, l.data());
  }
  if (coupled_.gain() < 1) return false;
  const auto forces = [&] {
    std::vector<double> list;
    for (const auto& p : preloaded_) list.push_back(p.lambda);
    for (std::size_t i = 0; i < posed_resting_.size(); ++i)
      list[static_cast<std::size_t>(posed_resting_[i])] = status_.unknowns[posed_.size() + i].impulse_t;
    return list;
  };
  const auto found = forces();
  const auto bounds = bounds_.bounds();
  const auto unknowns = status_.unknowns;
  double size = bounds.maxCoeff();
  for (std::size_t i = posed_.size(); i < unknowns.size(); ++i)  // what would hold each alone
    if (const int row = unknowns[i].tangent; status_.D(row, row) > 0)
      size = std::max(size, std::abs(status_.b[row]) / status_.D(row, row));
  bool other = false;
  for (const double from : {0.0, 100.0}) {
    for (int i = 0; i < coupled_.size(); ++i) preloaded_[coupled_.friction(i)].bound = from * size;
    const auto again = settle_bounds(x, t, candidates);
    trouble_.clear();
    if (!again.solved) continue;
    const auto now = forces();
    for (std::size_t k = 0; k < now.size(); ++k) other = other || std::abs(now[k] - found[k]) > 1e-6 * size;
  }
  for (int i = 0; i < coupled_.size(); ++i) preloaded_[coupled_.friction(i)].bound = bounds[i];
  if (solve_free(x, t)) pose(x, candidates);
  status_.unknowns = unknowns;
  return other;
}

std::string EventDynamics::choose(const Vector& x, double t, const std::vector<int>& candidates) {
  jam_ = false;
  orientation_ = 0;
  for (auto& c : contacts_) {
    c.closed = c.resting = false;
    c.slip = 0;
  }
  // Preloaded joints that slide stay as forces; those at rest, like the contacts, are unknowns.
  for (int k = 0; k < system_.frictions(); ++k) {
    const double u = slide_rate(k, x, t);
    auto& p = preloaded_[k];
    p.slip = std::abs(u) > p.share * slide_tolerance() ? (u > 0 ? 1 : -1) : p.forced;
  }
  if (candidates.empty() && std::ranges::none_of(preloaded_, [](const auto& p) { return p.slip == 0; }))
    return "";

  // Accelerations with nothing closed and resting joints without friction.
  ++work.lcp_solves;
  trouble_.clear();
  const auto solution = settle_bounds(x, t, candidates);
  if (!trouble_.empty()) return trouble_;
  if (coupled_.size() > 0 && solution.solved && other_motion(x, t, candidates))
    return words_of(CoupledFriction::Outcome::several);
  work.pivots += solution.pivots;
  work.lcp_retries += solution.retries;
  jam_ = !solution.solved;
  jam_proved_ = solution.impossible;
  if (!solution.solved) return unsolved(solution);
  extremes.lcp_residual = std::max(extremes.lcp_residual, solution.residual);
  undecided += solution.undecided;
  if (solution.ambiguous)
    return "friction admits more than one motion (Painlevé): " +
           describe_motions(status_, [&](int i) { return name_of_unknown(i); });

  // With all impulses known: which way do resting surfaces start to slide?
  const auto slip_of = [&](const ContactUnknown& u) {
    const double bound = u.bound + u.friction * u.impulse_n;
    if (std::abs(u.impulse_t) < bound * (1 - 1e-12)) return 0;
    const double rate = status_.rate(u.tangent);
    if (std::abs(rate) <= 1e-9 * status_.scale()) return 0;
    return rate > 0 ? 1 : -1;
  };
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    auto& c = contacts_[candidates[i]];
    const auto& u = status_.unknowns[i];
    c.closed = u.impulse_n * status_.D(u.normal, u.normal) > 1e-11 * status_.scale();
    c.resting = !c.closed;
    if (!c.closed) continue;
    c.slip = u.tangent >= 0 ? slip_of(u) : posed_slips_[i];
  }
  for (std::size_t i = 0; i < posed_resting_.size(); ++i) {
    auto& p = preloaded_[posed_resting_[i]];
    const auto& u = status_.unknowns[candidates.size() + i];
    p.slip = slip_of(u);
  }
  return "";
}

bool EventDynamics::torn() const {
  const auto is = [](const auto& x) { return x.forced != 0; };
  return std::ranges::any_of(contacts_, is) || std::ranges::any_of(preloaded_, is);
}

void EventDynamics::mend() {
  for (auto& c : contacts_) c.forced = 0;
  for (auto& p : preloaded_) p.forced = 0;
}

double EventDynamics::torn_back(const Vector& x, double t) {
  if (!solve_mode(x, t)) return std::numeric_limits<double>::infinity();
  double back = 0;
  for (const auto& c : contacts_)
    if (c.forced != 0 && c.closed)
      back = std::max(back, -c.forced * (c.row.tangent.dot(a_.data()) - c.row.gamma_t));
  for (const auto& p : preloaded_)
    if (p.forced != 0) back = std::max(back, -p.forced * (p.row.dot(a_.data()) - p.gamma));
  return back / acceleration_scale();
}

double EventDynamics::gap_acceleration(int k, const Vector& x, double t) {
  const double* v = x.data() + system_.n();
  if (!solve_mode(x, t)) return 0;
  system_.contact(k, x.data(), v, e_, contacts_[k].row);
  return contacts_[k].row.normal.dot(a_.data()) - contacts_[k].row.gamma_n;
}

}  // namespace freeplay
