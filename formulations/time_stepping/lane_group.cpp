#include "formulations/time_stepping/lane_group.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include "dynamics/system.hpp"
#include "formulations/time_stepping/moreau.hpp"

namespace freeplay {
namespace {

using enum LaneArray;

/// The start of a room of doubles at a multiple of 64 bytes.
double* aligned(std::vector<double>& room, std::size_t size) {
  room.assign(size + 8, 0);
  const auto address = reinterpret_cast<std::uintptr_t>(room.data());
  return room.data() + (64 - address % 64) % 64 / sizeof(double);
}

}  // namespace

LaneGroup::LaneGroup(LaneFunctions functions, const MoreauStepper& like)
    : functions_(std::move(functions)),
      members_(static_cast<std::size_t>(functions_.lanes)),
      width_(functions_.lanes),
      contacts_(static_cast<int>(functions_.contacts.size())),
      times_(static_cast<std::size_t>(width_)) {
  const auto& system = like.data_.system;
  // The arrays one after the other; the state before the step has the order of the state.
  const auto numbers = [&](LaneArray array) {
    return static_cast<std::size_t>(size(array)) * members_.size();
  };
  std::size_t all = 0;
  for (std::size_t i = 0; i < table_.size(); ++i) {
    sizes_.push_back(functions_.size(static_cast<LaneArray>(i), system));
    const auto count = numbers(static_cast<LaneArray>(i));
    all += count;
    if (i >= static_cast<std::size_t>(q) && i <= static_cast<std::size_t>(ratios)) state_size_ += count;
  }
  double* next = aligned(room_, all + state_size_);
  for (std::size_t i = 0; i < table_.size(); ++i) {
    table_[i] = next;
    next += numbers(static_cast<LaneArray>(i));
  }
  table_[static_cast<std::size_t>(q_old)] = next;
  table_[static_cast<std::size_t>(v_old)] = next + numbers(q);
  potential_ = system.has_potential();
  q_one_.resize(static_cast<std::size_t>(system.n()));
  q_free_one_.resize(static_cast<std::size_t>(system.n()));
  least_.resize(functions_.ratios.size());
}

void LaneGroup::enter(int lane, const Member& member) {
  members_[static_cast<std::size_t>(lane)] = member;
  const auto& list = *member.constants;
  const auto width = static_cast<std::size_t>(width_);
  if (!constants_) constants_ = aligned(constants_room_, list.size() * width);
  for (std::size_t i = 0; i < list.size(); ++i)
    constants_[i * width + static_cast<std::size_t>(lane)] = list[i];
}

bool LaneGroup::fits(const MoreauStepper& s) {
  return s.fixed() && !s.responses_.many() && !s.films_.any() && s.automatic_solver_ && s.resolution_.idle();
}

bool LaneGroup::ready(int lane) const {
  const auto& s = *members_[static_cast<std::size_t>(lane)].stepper;
  const auto& log = *s.data_.log;
  if (s.forces_.watching() || log.has_pending() || s.data_.reach != StepReach::all) return false;
  int closed = 0;
  for (int k = 0; k < contacts_; ++k) {
    const auto& c = s.contacts_[k];
    if (c.soft || c.closed) return false;
    if (c.steps == 0 && !log.is_open(k)) continue;
    if (functions_.slide && c.steps < 2) return false;  // the next step would not start from its impulses
    if (c.steps == 0 || std::isfinite(log.undecided_since(k)) || ++closed > 1) return false;
  }
  return true;
}

/// Calls copy(own, lane's) for all that steps change.
void LaneGroup::move(MoreauStepper& s, int lane, double& passed, auto copy) const {
  auto& d = s.data_;
  const auto list = [&](LaneArray array, std::vector<double>& own) {
    for (int i = 0; i < size(array); ++i) copy(own[static_cast<std::size_t>(i)], at(array, i, lane));
  };
  list(q, d.q);
  list(v, d.v);
  list(slide_impulse, s.problem_.slide_last);
  auto& works = d.totals.integrals;
  auto& extremes = d.totals.extremes;
  copy(works.drive, at(drive, 0, lane));
  copy(works.stabilisation, at(stabilisation, 0, lane));
  const auto total = [&](double& own, LaneTotal i) { copy(own, at(totals, i, lane)); };
  total(works.contact, lane_contact_loss);
  total(works.friction, lane_friction_loss);
  total(extremes.lcp_residual, lane_lcp_residual);
  total(extremes.lcp_residual_rate, lane_lcp_residual_rate);
  total(extremes.constraint_length, lane_constraint_length);
  total(extremes.constraint_angle, lane_constraint_angle);
  total(passed, lane_passed);
  for (int k = 0; k < contacts_; ++k) {
    auto& c = s.contacts_[k];
    const auto field = [&](double& own, LaneRecord i) {
      copy(own, at(LaneArray::record, lane_record_size * k + i, lane));
    };
    copy(c.gap, at(gap, k, lane));
    field(c.impulse_n, lane_impulse_n);
    field(c.impulse_t, lane_impulse_t);
    field(c.last_n, lane_last_n);
    field(c.last_t, lane_last_t);
    field(c.u_n_minus, lane_u_n_minus);
    field(c.u_n_plus, lane_u_n_plus);
    field(c.u_t_plus, lane_u_t_plus);
    field(c.bias_n, lane_bias_n);
    field(c.bias_t, lane_bias_t);
    field(extremes.penetration[static_cast<std::size_t>(k)], lane_penetration);
  }
}

void LaneGroup::load(int lane) {
  const auto& member = members_[static_cast<std::size_t>(lane)];
  auto& s = *member.stepper;
  auto& time = times_[static_cast<std::size_t>(lane)];
  time = {.t = s.data_.t, .t_start = s.t_start_, .step = s.step_, .index = s.index_};
  move(s, lane, *member.passed, [](const double& own, double& in_lane) { in_lane = own; });
  at(tolerance, 0, lane) = s.tolerance_;
  for (int i = 0; i < size(ratios); ++i) at(ratios, i, lane) = 1;
  for (int k = 0; k < contacts_; ++k) {
    if (s.contacts_[k].steps > 0) time.contact = k;
    at(restitution, k, lane) = s.contacts_[k].restitution;
  }
}

void LaneGroup::store(int lane) {
  const auto& member = members_[static_cast<std::size_t>(lane)];
  const auto& time = times_[static_cast<std::size_t>(lane)];
  if (time.steps == 0) return;
  auto& s = *member.stepper;
  auto& d = s.data_;
  d.t = time.t;
  s.index_ = time.index;
  move(s, lane, *member.passed, [](double& own, const double& in_lane) { own = in_lane; });
  if (time.contact >= 0) {
    auto& c = s.contacts_[time.contact];
    c.steps += static_cast<int>(time.pressed);
    c.t_pressed = time.t;
  }
  auto& work = d.totals.work;
  work.steps += time.steps;
  work.factorisations += time.steps;
  work.rhs += time.steps;
  work.lcp_solves += time.solves;
  if (functions_.slide) work.pivots += time.pressed;  // the first mode of each
  int ratio = 0;
  for (std::size_t block = 0; block < least_.size(); ++block) {
    least_[block] = 1;
    for (int i = 0; i < functions_.ratios[block]; ++i)
      least_[block] = std::min(least_[block], at(ratios, ratio++, lane));
  }
  d.saddle.factored_elsewhere(least_.data());
}

void LaneGroup::set_times() {
  for (int lane = 0; lane < width_; ++lane) {
    auto& time = times_[static_cast<std::size_t>(lane)];
    time.solves_now = 0;
    const double t = time.t_start + static_cast<double>(time.index + 1) * time.step, length = t - time.t;
    at(t_end, 0, lane) = t;
    at(h, 0, lane) = length;
    at(t_middle, 0, lane) = time.t + 0.5 * length;
  }
}

/// The impulses of contacts and of a joint friction. Returns the bits of lanes where other contacts act than
/// the one that is closed, or where they are not solved.
unsigned LaneGroup::meet_contacts(unsigned lanes) {
  unsigned other = 0, open = lanes;
  for (int k = 0; k < contacts_; ++k) {
    const unsigned acting = lanes_where([&](int lane) { return at(reach, k, lane) <= 0; }),
                   closed = closed_at(k);
    // A joint friction may still press the closed contact.
    other |= !functions_.slide ? acting ^ closed : acting & ~closed;
    open &= ~acting;
    other |= press(k, acting & lanes & ~other);
  }
  return other | slide(open & ~other);
}

/// The impulses of a contact that acts in these lanes. Returns the bits of those where it is not solved.
unsigned LaneGroup::press(int contact, unsigned lanes) {
  if (lanes == 0) return 0;
  const auto k = static_cast<std::size_t>(contact);
  for (int lane = 0; lane < width_; ++lane) {
    const int now = static_cast<int>(lanes >> lane & 1);
    at(acts, contact, lane) = now;
    times_[static_cast<std::size_t>(lane)].solves_now += now;
  }
  return lanes & call(functions_.contacts[k]);
}

/// The impulse of the joint friction where no contact acts without it; and of a contact that acts with it.
/// Returns the bits of lanes where it is not the closed one, or where they are not solved.
unsigned LaneGroup::slide(unsigned lanes) {
  if (!functions_.slide || lanes == 0) return 0;
  for (int lane = 0; lane < width_; ++lane) {
    const bool asked = (lanes >> lane & 1) != 0;
    at(slide_asked, 0, lane) = asked ? 1 : 0;
    times_[static_cast<std::size_t>(lane)].solves_now += asked ? 1 : 0;
  }
  unsigned other = lanes & call(functions_.slide);
  for (int k = 0; k < contacts_; ++k)
    other |= lanes_where([&](int lane) { return at(slide_reach, k, lane) <= 0; }) ^ closed_at(k);
  for (int k = 0; k < contacts_; ++k) other |= press(k, closed_at(k) & lanes & ~other);
  return other & lanes;
}

/// Corrects negative gaps. Returns the bits of lanes where it is not the closed contact's, or is not
/// solved.
unsigned LaneGroup::open_gaps(unsigned lanes) {
  unsigned other = 0;
  for (int k = 0; k < contacts_; ++k) {
    unsigned deep = 0;
    for (int lane = 0; lane < width_; ++lane) {
      const bool negative = at(gap, k, lane) < 0;
      at(opens, k, lane) = negative ? 1 : 0;
      if (negative) deep |= 1u << lane;
    }
    other |= deep & ~closed_at(k);
    deep &= lanes & ~other;
    if (deep == 0) continue;
    other |= deep & call(functions_.opens[static_cast<std::size_t>(k)]);
  }
  return other;
}

/// The work of the correction of positions against gravity and springs.
void LaneGroup::accumulate_potential(unsigned lanes) {
  for (int lane = 0; lane < width_; ++lane) {
    if ((lanes >> lane & 1) == 0) continue;
    for (int i = 0; i < size(q); ++i) {
      q_one_[static_cast<std::size_t>(i)] = at(q, i, lane);
      q_free_one_[static_cast<std::size_t>(i)] = at(q_free, i, lane);
    }
    const auto& system = members_[static_cast<std::size_t>(lane)].stepper->data_.system;
    const double before = system.potential(q_free_one_.data());
    at(stabilisation, 0, lane) += system.potential(q_one_.data()) - before;
  }
}

/// Takes back the present step of these lanes.
void LaneGroup::restore(unsigned lanes) {
  double* state = table_[static_cast<std::size_t>(q)];
  const double* old = table_[static_cast<std::size_t>(q_old)];
  const auto quantities = state_size_ / static_cast<std::size_t>(width_);
  for (int lane = 0; lane < width_; ++lane) {
    if ((lanes >> lane & 1) == 0) continue;
    for (std::size_t i = 0; i < quantities; ++i) {
      const auto place = i * static_cast<std::size_t>(width_) + static_cast<std::size_t>(lane);
      state[place] = old[place];
    }
  }
}

void LaneGroup::record(long most) {
  const auto states = most > 0 ? static_cast<std::size_t>(most) + 1 : 0, lanes = members_.size();
  motion_.resize(states * static_cast<std::size_t>(size(q) + size(v)) * lanes);
  motion_times_.resize(states * lanes);
}

void LaneGroup::keep_motion(long step) {
  if (motion_.empty()) return;
  const auto at = static_cast<std::size_t>(step),
             numbers = static_cast<std::size_t>(size(q) + size(v)) * times_.size();
  std::memcpy(motion_.data() + at * numbers, table_[static_cast<std::size_t>(q)],
              numbers * sizeof(double));  // and v, which follows
  for (std::size_t lane = 0; lane < times_.size(); ++lane)
    motion_times_[at * times_.size() + lane] = times_[lane].t;
}

double LaneGroup::recorded(long step, int lane, std::vector<double>& q, std::vector<double>& v) const {
  const auto at = static_cast<std::size_t>(step), width = times_.size();
  const double* x = motion_.data() + at * (q.size() + v.size()) * width + lane;
  for (auto* list : {&q, &v})
    for (auto& value : *list) {
      value = *x;
      x += width_;
    }
  return motion_times_[at * width + static_cast<std::size_t>(lane)];
}

unsigned LaneGroup::advance(unsigned lanes, long most) {
  keep_motion(0);
  double* old = table_[static_cast<std::size_t>(q_old)];
  for (done_ = 0; done_ < most; ++done_) {
    std::memcpy(old, table_[static_cast<std::size_t>(q)], state_size_ * sizeof(double));
    set_times();
    auto bad = call(functions_.middle);
    bad |= meet_contacts(lanes);
    if ((bad & lanes) != lanes) {
      bad |= call(functions_.end);
      bad |= open_gaps(lanes & ~bad);
      if (potential_) accumulate_potential(lanes & ~bad);
    }
    bad &= lanes;
    for (int lane = 0; lane < width_; ++lane) {
      if ((bad >> lane & 1) != 0) continue;
      auto& time = times_[static_cast<std::size_t>(lane)];
      time.t = at(t_end, 0, lane);
      ++time.index;
      ++time.steps;
      time.pressed += time.contact >= 0 ? 1 : 0;
      time.solves += time.solves_now;
    }
    keep_motion(done_ + 1);
    if (bad == 0) continue;
    restore(bad);
    return bad;
  }
  return 0;
}

}  // namespace freeplay
