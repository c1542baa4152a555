#include "formulations/event_driven/mode_trials.hpp"

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
  const double most = *d.system.contact_facts(k).surface.friction * c.lambda_n;
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
      const int row = d.bound_of(i).row;
      next.preloaded[d.coupled.friction(i)].reaction = {d.lambda[row], d.lambda[row + 1]};
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

}  // namespace freeplay
