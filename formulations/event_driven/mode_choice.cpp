#include "formulations/event_driven/mode_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace freeplay {
namespace {

constexpr double most_modes = 324;  // a contact and four joints
constexpr double rounding = 1e-9;   // of accelerations and forces, relative

}  // namespace

ModeTrials::ModeTrials(const ModeEquations& d, const std::vector<int>& contacts,
                       const std::vector<int>& slips, const std::vector<int>& resting, double scale)
    : contacts_(contacts), slips_(slips), resting_(resting), scale_(scale) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const bool rough = d.contacts[contacts[i]].row.tangent.size > 0;
    options_.push_back(slips[i] != 0 ? Mode{slips[i], open} : rough ? Mode{0, 1, -1, open} : Mode{0, open});
  }
  options_.resize(contacts.size() + resting.size(), {0, 1, -1});
}

void ModeTrials::set(ModeEquations& d, const Mode& mode) const {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    auto& c = d.contacts[contacts_[i]];
    c.closed = mode[i] != open;
    c.resting = !c.closed;
    c.slip = c.closed ? mode[i] : 0;
  }
  for (std::size_t i = 0; i < resting_.size(); ++i)
    d.preloaded[resting_[i]].slip = mode[contacts_.size() + i];
}

bool ModeTrials::contact_holds(ModeEquations& d, const Vector& x, std::size_t i, int does) const {
  const int k = contacts_[i];
  auto& c = d.contacts[k];
  d.system.contact(k, x.data(), x.data() + d.system.n(), d.e, c.row);
  const double apart = c.row.normal.dot(d.a.data()) - c.row.gamma_n;
  if (does == open) return apart >= -rounding * scale_;
  if (!(std::abs(apart) <= rounding * scale_ && c.lambda_n * std::abs(c.mobility) > 1e-11 * scale_))
    return false;
  if (c.row.tangent.size == 0 || slips_[i] != 0) return true;
  const double along = c.row.tangent.dot(d.a.data()) - c.row.gamma_t;
  if (does != 0) return does * along >= -rounding * scale_;
  const double most = d.system.contact_facts(k).surface.friction_at_rest() * c.lambda_n;
  return std::abs(along) <= rounding * scale_ && std::abs(c.lambda_t) <= (1 + rounding) * most;
}

bool ModeTrials::joint_holds(const ModeEquations& d, const ModeFriction& p) const {
  const double along = p.row.dot(d.a.data()) - p.gamma;
  if (p.slip != 0) return p.slip * along >= -rounding * scale_;
  const double mobility = d.rows.K(p.unknown, p.unknown);
  const double zero = mobility > 0 ? 1e-11 * scale_ / mobility : 0;
  return std::abs(along) <= rounding * scale_ && std::abs(p.lambda) <= (1 + rounding) * p.bound + zero;
}

bool ModeTrials::holds(ModeEquations& d, const Vector& x, const Mode& mode) const {
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    if (!contact_holds(d, x, i, mode[i])) return false;
  return std::ranges::all_of(resting_, [&](int k) { return joint_holds(d, d.preloaded[k]); });
}

std::vector<ModeTrials::Motion> ModeTrials::find(ModeEquations& d, ModeMotion& motion, const Vector& x,
                                                 double t) const {
  std::vector<Motion> found;
  double number = 1;
  for (const auto& list : options_) number *= static_cast<double>(list.size());
  if (number > most_modes) return found;
  const auto contacts = d.contacts;
  const auto preloaded = d.preloaded;
  for (int n = 0; n < static_cast<int>(number) && found.size() < 2; ++n) {
    Mode mode;
    for (int rest = n; const auto& list : options_) {
      const int size = static_cast<int>(list.size());
      mode.push_back(list[rest % size]);
      rest /= size;
    }
    set(d, mode);
    motion.begin_mode();
    if (!motion.solve(d, x, t) || !holds(d, x, mode)) continue;
    Motion next{mode, d.a, d.preloaded};
    for (int i = 0; i < d.coupled.size(); ++i) {
      next.preloaded[d.coupled.friction(i)].reaction = d.bound_of(i).reactions(d.lambda.data());
    }
    if (!found.empty()) {
      auto by = d.a;
      for (std::size_t i = 0; i < by.size(); ++i) by[i] -= found[0].a[i];
      if (!(d.greatest(by.data()) > 1e-6 * std::max(scale_, d.acceleration_scale()))) continue;
    }
    found.push_back(std::move(next));
  }
  d.trouble.clear();
  d.contacts = contacts;
  d.preloaded = preloaded;
  motion.begin_mode();
  return found;
}

void ModeTrials::take(ModeEquations& d, ModeMotion& motion, const Motion& found) const {
  d.preloaded = found.preloaded;
  set(d, found.mode);
  motion.begin_mode();
}

std::string ModeTrials::words_of(const ModeEquations& d, const Mode& mode) const {
  std::string text;
  for (std::size_t i = 0; i < mode.size(); ++i) {
    const auto& name = i < contacts_.size() ? d.system.contact_facts(contacts_[i]).name
                                            : d.system.friction_facts(resting_[i - contacts_.size()]).name;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name,
                        mode[i] == open ? "open"
                        : mode[i] == 0  ? "sticking"
                        : mode[i] > 0   ? "sliding forwards"
                                        : "sliding backwards");
  }
  return text;
}

/// Opens all contacts. Sliding friction of preloaded joints stays a force; joints at rest are
/// unknowns, like the contacts.
void ModeChoice::open_all(ModeEquations& d, const Vector& x, double t) {
  for (auto& c : d.contacts) {
    c.closed = c.resting = false;
    c.slip = 0;
  }
  for (int k = 0; k < d.system.frictions(); ++k) {
    const double u = d.slide_rate(k, x, t);
    auto& p = d.preloaded[k];
    p.slip = std::abs(u) > p.share * d.slide_tolerance() ? (u > 0 ? 1 : -1) : 0;
  }
}

std::string ModeChoice::choose(ModeEquations& d, ModeMotion& motion, const Vector& x, double t,
                               const std::vector<int>& candidates) {
  lockup_ = false;
  motion.begin_mode();
  open_all(d, x, t);
  if (candidates.empty() && std::ranges::none_of(d.preloaded, [](const auto& p) { return p.slip == 0; }))
    return "";

  ++d.work.lcp_solves;
  d.trouble.clear();
  const auto solution = settle(d, x, t, candidates);
  if (d.coupled.size() > 0 && (!solution.solved || may_be_several(d))) {
    const ModeTrials trials(d, contacts_, slips_, resting_, problem_.scale());
    const auto trouble = d.trouble;
    const auto found = trials.find(d, motion, x, t);
    if (found.size() > 1)
      return fmt::format("{}: {}; or {}", words_of(CoupledFriction::Outcome::several),
                         trials.words_of(d, found[0].mode), trials.words_of(d, found[1].mode));
    if (found.size() == 1) {
      trials.take(d, motion, found[0]);
      return "";
    }
    d.trouble = trouble;
    if (solution.solved)
      if (const auto motions = other_motion(d, x, t, candidates); !motions.empty())
        return fmt::format("{}: {}", words_of(CoupledFriction::Outcome::several), motions);
  }
  if (!d.trouble.empty()) return d.trouble;
  d.work.pivots += solution.pivots;
  d.work.lcp_retries += solution.retries;
  lockup_ = !solution.solved;
  lockup_proved_ = solution.impossible;
  if (!solution.solved) return unsolved(d, solution);
  d.extremes.lcp_residual = std::max(d.extremes.lcp_residual, solution.residual);
  d.counts.undecided += solution.undecided;
  if (solution.ambiguous)
    return "Painlevé paradox: friction admits several motions: " +
           describe_motions(problem_, [&](int i) { return name_of_unknown(d, i); });
  take(d);
  return "";
}

/// Takes the mode from the solution. With all forces known, it determines the direction in which
/// resting surfaces begin to slide.
void ModeChoice::take(ModeEquations& d) {
  const auto slip_of = [&](const ContactUnknown& u) {
    const double bound = u.bound + u.friction * u.impulse_n;
    if (std::abs(u.impulse_t) < bound * (1 - 1e-12)) return 0;
    const double rate = problem_.rate(u.tangent);
    if (std::abs(rate) <= 1e-9 * problem_.scale()) return 0;
    return rate > 0 ? 1 : -1;
  };
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    auto& c = d.contacts[contacts_[i]];
    const auto& u = problem_.unknowns[i];
    c.closed = u.impulse_n * problem_.D(u.normal, u.normal) > 1e-11 * problem_.scale();
    c.resting = !c.closed;
    if (!c.closed) continue;
    c.slip = u.tangent >= 0 ? slip_of(u) : slips_[i];
  }
  for (std::size_t i = 0; i < resting_.size(); ++i)
    d.preloaded[resting_[i]].slip = slip_of(problem_.unknowns[contacts_.size() + i]);
}

/// Sets up the problem in accelerations of these contacts and of all joints at rest, from the
/// result of solve_free(). A contact that slides includes its friction in the
/// column of its normal force.
void ModeChoice::pose(ModeEquations& d, const Vector& x, const std::vector<int>& candidates) {
  const double* q = x.data();
  const double* v = q + d.system.n();
  contacts_ = candidates;
  problem_.clear();
  d.rows.clear();
  slips_.clear();
  resting_.clear();
  const auto add = [&](const SparseRow& row, double gamma, const SparseRow* beside, double factor) {
    const int r = d.add(row, beside, factor);
    problem_.reserve(static_cast<int>(d.rows.K.rows()));
    problem_.b[r] = row.dot(d.a.data()) - gamma;
    return r;
  };
  for (const int k : candidates) {
    auto& c = d.contacts[k];
    d.system.contact(k, q, v, d.e, c.row);
    ContactUnknown u;
    int slip = 0;
    double mu = 0;
    if (c.row.tangent.size > 0) {
      const auto& surface = d.system.contact_facts(k).surface;
      const double rate = c.row.tangent.dot(v);
      slip = std::abs(rate) > d.slide_tolerance() ? (rate > 0 ? 1 : -1) : 0;
      mu = slip != 0 ? surface.friction_at(rate) : surface.friction_at_rest();
    }
    u.normal = add(c.row.normal, c.row.gamma_n, slip != 0 ? &c.row.tangent : nullptr, -slip * mu);
    if (c.row.tangent.size > 0 && slip == 0) {
      u.tangent = add(c.row.tangent, c.row.gamma_t, nullptr, 0);
      u.friction = mu;
    }
    slips_.push_back(slip);
    problem_.unknowns.push_back(u);
  }
  for (int k = 0; k < d.system.frictions(); ++k) {
    const auto& p = d.preloaded[k];
    if (p.slip != 0) continue;
    ContactUnknown u;
    u.tangent = add(p.row, p.gamma, nullptr, 0);
    u.bound = p.bound;
    resting_.push_back(k);
    problem_.unknowns.push_back(u);
  }
  problem_.rows = d.rows.used();
  for (int r = 0; r < problem_.rows; ++r)
    for (int s = 0; s < problem_.rows; ++s) problem_.D(r, s) = d.rows.row(r).dot(d.rows.response(s));
  if (d.coupled.size() > 0) pose_driven(d);
}

/// For a row that no force moves, of a joint with prescribed motion: friction is at its bound,
/// opposed to the rate.
void ModeChoice::pose_driven(const ModeEquations& d) {
  for (std::size_t i = contacts_.size(); i < problem_.unknowns.size(); ++i) {
    const auto& u = problem_.unknowns[i];
    const double free = d.unconstrained_mobility(d.rows.row(u.tangent));
    if (std::abs(problem_.D(u.tangent, u.tangent)) > 1e-12 * free) continue;
    for (int r = 0; r < problem_.rows; ++r) problem_.D(r, u.tangent) = problem_.D(u.tangent, r) = 0;
    const double rate = std::abs(problem_.b[u.tangent]);
    problem_.D(u.tangent, u.tangent) = rate > 0 && u.bound > 0 ? 0.5 * rate / u.bound : free;
  }
}

/// Solves the problem in accelerations with the bounds that its reactions give. If there is no
/// problem or no bounds are found, d.trouble has the reason.
ContactSolution ModeChoice::settle(ModeEquations& d, const Vector& x, double t,
                                   const std::vector<int>& candidates) {
  ContactSolution solution;
  const auto pose_and_solve = [&] {
    if (!d.solve_free(x, t)) {
      if (d.trouble.empty()) d.trouble = "the constraint equations cannot be factorised";
      solution.solved = false;
      return false;
    }
    pose(d, x, candidates);
    solution = problem_.solve();
    return solution.solved;
  };
  const int coupled = d.coupled.size();
  if (coupled == 0) {
    pose_and_solve();
    return solution;
  }
  for (int i = 0; i < coupled; ++i) image_[i] = d.preloaded[d.coupled.friction(i)].bound;
  bounds_.start(image_);
  do {
    for (int i = 0; i < coupled; ++i) d.preloaded[d.coupled.friction(i)].bound = bounds_.bounds()[i];
    if (!pose_and_solve()) return solution;
    for (int i = 0; i < coupled; ++i) {
      const auto& bound = d.bound_of(i);
      auto& p = d.preloaded[d.coupled.friction(i)];
      p.reaction = bound.reactions(d.lambda.data());
      for (const auto& u : problem_.unknowns)
        for (const auto& [row, force] : {std::pair{u.normal, u.impulse_n}, std::pair{u.tangent, u.impulse_t}})
          if (row >= 0) {
            const auto by = bound.reactions(d.rows.reaction(row));
            for (const std::size_t which : {0U, 1U}) p.reaction[which] += force * by[which];
          }
      image_[i] = bound.coefficient(p.slip != 0 ? p.rate : 0) *
                  bound.support(p.reaction, force_side(d.coupled.friction(i), p.slip));
    }
  } while (bounds_.refine(image_));
  if (!bounds_.met()) {
    d.trouble = fmt::format("{}; after {} iterations bounds and reactions differ by {:.2g}, relative",
                            words_of(CoupledFriction::Outcome::none), bounds_.count(), bounds_.residual());
    solution.solved = false;
  }
  d.extremes.friction_residual = std::max(d.extremes.friction_residual, bounds_.residual());
  return solution;
}

/// The sign of the force of joint k, in slip or in the present solution. Where it is zero: of the force
/// that would oppose the acceleration.
double ModeChoice::force_side(int k, int slip) const {
  if (slip != 0) return -slip;
  const auto i = std::ranges::find(resting_, k) - resting_.begin();
  const auto& u = problem_.unknowns[contacts_.size() + static_cast<std::size_t>(i)];
  return u.impulse_t != 0 ? u.impulse_t : -problem_.rate(u.tangent);
}

/// Whether the problem may have several solutions. There is one only if reactions grow less than
/// the friction that they bound, and no contact with friction takes part.
bool ModeChoice::may_be_several(ModeEquations& d) {
  if (!d.coupled.reads_reactions()) return false;
  std::vector<double> a(static_cast<std::size_t>(d.system.n())), l(static_cast<std::size_t>(d.system.rows()));
  for (int i = 0; i < d.coupled.size(); ++i) {
    const auto& p = d.preloaded[d.coupled.friction(i)];
    d.saddle.respond(p.row, nullptr, 0, a.data(), l.data());
    d.coupled.factor(i) = d.bound_of(i).coefficient(p.rate);
    d.coupled.column(i, l.data());
  }
  const auto rough = [&](int k) { return d.contacts[k].row.tangent.size > 0; };
  return d.coupled.gain() >= 1 || std::ranges::any_of(contacts_, rough);
}

/// Describes the motion found and another one, if other initial bounds lead to one. The problem is
/// restored.
std::string ModeChoice::other_motion(ModeEquations& d, const Vector& x, double t,
                                     const std::vector<int>& candidates) {
  const int coupled = d.coupled.size();
  const auto accelerations = [&] {
    auto list = d.a;
    for (const auto& u : problem_.unknowns)
      for (const auto& [row, force] : {std::pair{u.normal, u.impulse_n}, std::pair{u.tangent, u.impulse_t}})
        if (row >= 0)
          for (std::size_t i = 0; i < list.size(); ++i) list[i] += force * d.rows.response(row)[i];
    return list;
  };
  const auto found = accelerations();
  const auto first = present_motion(d);
  const double free = d.acceleration_scale();
  const auto preloaded = d.preloaded;
  const auto unknowns = problem_.unknowns;
  double size = bounds_.bounds().maxCoeff();
  // force that would hold each joint alone
  for (std::size_t i = contacts_.size(); i < unknowns.size(); ++i)
    if (const int row = unknowns[i].tangent; problem_.D(row, row) > 0)
      size = std::max(size, std::abs(problem_.b[row]) / problem_.D(row, row));
  std::string other;
  for (const double from : {0.0, 100.0}) {
    for (int i = 0; i < coupled; ++i) d.preloaded[d.coupled.friction(i)].bound = from * size;
    const auto again = settle(d, x, t, candidates);
    d.trouble.clear();
    if (!again.solved) continue;
    auto by = accelerations();
    for (std::size_t k = 0; k < by.size(); ++k) by[k] -= found[k];
    if (d.greatest(by.data()) > 1e-6 * std::max(free, d.greatest(found.data())))
      other = first + "; or " + present_motion(d);
  }
  d.preloaded = preloaded;
  if (d.solve_free(x, t)) pose(d, x, candidates);
  problem_.unknowns = unknowns;
  return other;
}

/// What the contacts and joints of the problem do in its present solution.
std::string ModeChoice::present_motion(const ModeEquations& d) const {
  std::string text;
  const double none = 1e-9 * problem_.scale();
  for (std::size_t i = 0; i < problem_.unknowns.size(); ++i) {
    const auto& u = problem_.unknowns[i];
    const double rate = u.tangent >= 0 ? problem_.rate(u.tangent) : slips_[i];
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name_of_unknown(d, static_cast<int>(i)),
                        u.normal >= 0 && !(u.impulse_n > 0) ? "open"
                        : rate > none                       ? "sliding forwards"
                        : rate < -none                      ? "sliding backwards"
                                                            : "sticking");
  }
  return text;
}

std::string ModeChoice::name_of_unknown(const ModeEquations& d, int i) const {
  const auto contacts = static_cast<int>(contacts_.size());
  return i < contacts ? d.system.contact_facts(contacts_[i]).name
                      : d.system.friction_facts(resting_[i - contacts]).name;
}

/// Reason why the problem in accelerations has no mode.
std::string ModeChoice::unsolved(const ModeEquations& d, const ContactSolution& solution) const {
  if (!solution.impossible)
    return fmt::format(
        "no solver solved the acceleration problem of {} contacts (relative residual {:.2g}); a solution "
        "may exist",
        problem_.unknowns.size(), solution.residual);
  std::string sliding;
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    if (slips_[i] != 0)
      sliding +=
          fmt::format("{}{} {}", sliding.empty() ? "" : ", ", d.system.contact_facts(contacts_[i]).name,
                      slips_[i] > 0 ? "to the right" : "to the left");
  return fmt::format(
      "Painlevé paradox: friction admits no acceleration in any contact mode (sliding: {}); time stepping "
      "finds a consistent impulse",
      sliding);
}

}  // namespace freeplay
