#include "formulations/time_stepping/lane_group.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "dynamics/system_functions.hpp"
#include "formulations/time_stepping/moreau.hpp"

namespace freeplay {
namespace {

constexpr int row_size = SparseRow::max_size;

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
  const auto& d = like.data_;
  const auto& system = d.system;
  const int n = system.n(), m = system.rows(), K = contacts_, bodies = system.bodies(),
            entries = static_cast<int>(d.middle.G.size()),
            all_ratios = std::accumulate(functions_.ratios.begin(), functions_.ratios.end(), 0);
  const auto state = [&](State& s) {
    return std::vector<std::pair<Block*, int>>{{&s.q, n},
                                               {&s.v, n},
                                               {&s.drive, 1},
                                               {&s.stabilisation, 1},
                                               {&s.gaps, K},
                                               {&s.records, K * lane_record_size},
                                               {&s.totals, lane_total_size},
                                               {&s.slides, static_cast<int>(functions_.slides.size())},
                                               {&s.ratios, all_ratios}};
  };
  const auto blocks = state(now_);
  divide(state_room_, blocks);
  divide(saved_room_, state(saved_));
  for (const auto& [block, size] : blocks) state_size_ += static_cast<std::size_t>(size * width_);
  auto& w = work_;
  std::vector<std::pair<Block*, int>> work;
  const auto of_size = [&](int size, std::initializer_list<Block*> list) {
    for (auto* block : list) work.emplace_back(block, size);
  };
  of_size(n, {&w.middle_q, &w.force, &w.free_q});
  of_size(m, {&w.phi_t, &w.gamma, &w.lambda});
  of_size(bodies, {&w.cosine, &w.sine});
  of_size(entries, {&w.G});
  of_size(functions_.factors, {&w.factors});
  of_size(K, {&w.middle_gap, &w.gamma_n, &w.gamma_t, &w.reach, &w.acts, &w.opens, &w.slide_reach});
  of_size(K * row_size, {&w.normal, &w.tangent});
  of_size(4 * K, {&w.rates});
  of_size(2 * K, {&w.facts});
  of_size(row_size, {&w.slide_row});
  of_size(1, {&w.t_middle, &w.t_end, &w.h, &w.slide_gamma, &w.slide_asked, &w.tolerance, &w.unused});
  divide(work_room_, work);
  potential_ = system.has_potential();
  q_one_.resize(static_cast<std::size_t>(n));
  q_free_one_.resize(static_cast<std::size_t>(n));
  least_.resize(functions_.ratios.size());
  connect();
}

void LaneGroup::enter(int lane, const Member& member) {
  members_[static_cast<std::size_t>(lane)] = member;
  const auto& list = *member.constants;
  const auto width = static_cast<std::size_t>(width_);
  if (!constants_) constants_ = aligned(constants_room_, list.size() * width);
  for (std::size_t i = 0; i < list.size(); ++i)
    constants_[i * width + static_cast<std::size_t>(lane)] = list[i];
}

/// Gives each block its place in a room.
void LaneGroup::divide(std::vector<double>& room, const std::vector<std::pair<Block*, int>>& blocks) const {
  int size = 0;
  for (const auto& [block, count] : blocks) size += count * width_;
  double* next = aligned(room, static_cast<std::size_t>(size));
  for (const auto& [block, count] : blocks) {
    *block = {next, count};
    next += count * width_;
  }
}

/// Collects the arguments of the functions.
void LaneGroup::connect() {
  const auto& s = now_;
  const auto& w = work_;
  const auto part = [&](const Block& block, int i) { return block.data + i * width_; };
  middle_.in = {w.t_middle, w.h, saved_.q, saved_.v, saved_.ratios};
  middle_.out = {w.middle_q, w.cosine, w.sine,  w.phi_t, w.G,      w.gamma,
                 w.factors,  w.unused, w.force, s.v,     w.lambda, w.unused};
  end_.in = {w.t_end, w.h,       w.middle_q, saved_.v, s.v,     w.lambda,        w.force, w.phi_t,
             w.G,     w.factors, w.cosine,   w.sine,   s.drive, s.stabilisation, s.totals};
  end_.out = {w.free_q, s.q, w.unused, w.unused, s.drive, s.stabilisation, w.unused, w.unused};
  for (int k = 0; k < contacts_; ++k) {
    double *record = part(s.records, lane_record_size * k), *normal = part(w.normal, row_size * k),
           *tangent = part(w.tangent, row_size * k), *rates = part(w.rates, 4 * k), *acts = part(w.acts, k),
           *facts = part(w.facts, 2 * k), *opens = part(w.opens, k);
    for (double* x : {part(w.middle_gap, k), normal, tangent, part(w.gamma_n, k), part(w.gamma_t, k), rates})
      middle_.out.push_back(x);
    end_.out.push_back(part(s.gaps, k));
    contact_calls_.push_back(
        {{w.h,       w.factors,    w.G,      normal,   tangent,     rates,         w.gamma_n,
          w.gamma_t, w.middle_gap, w.normal, s.v,      w.lambda,    w.force,       saved_.v,
          acts,      facts,        record,   s.totals, w.slide_row, w.slide_gamma, s.slides},
         {s.v, w.lambda, w.force, record, s.totals, s.slides}});
    open_calls_.push_back({{w.t_end, w.middle_q, w.cosine, w.sine, w.factors, w.G, normal, s.q, s.gaps, opens,
                            s.totals, record, facts},
                           {s.q, s.gaps, s.totals, record}});
  }
  for (double* x : {w.reach, s.ratios, w.slide_row, w.slide_gamma}) middle_.out.push_back(x);
  slide_.in = {w.h,       w.factors,    w.G,           w.slide_row, w.slide_gamma, s.slides,
               w.gamma_n, w.middle_gap, w.normal,      w.unused,    s.v,           w.lambda,
               w.force,   saved_.v,     w.slide_asked, w.tolerance, s.totals};
  slide_.out = {s.v, w.lambda, w.force, s.totals, s.slides, w.slide_reach};
  end_.out.push_back(s.totals);
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
    if (now_.slides.size > 0 && c.steps < 2) return false;  // the next step would not start from its impulses
    if (c.steps == 0 || std::isfinite(log.undecided_since(k)) || ++closed > 1) return false;
  }
  return true;
}

void LaneGroup::load(int lane) {
  const auto& member = members_[static_cast<std::size_t>(lane)];
  const auto& s = *member.stepper;
  const auto& d = s.data_;
  auto& time = times_[static_cast<std::size_t>(lane)];
  time = {.t = d.t, .t_start = s.t_start_, .step = s.step_, .index = s.index_};
  const auto put = [&](const Block& block, const std::vector<double>& list) {
    for (int i = 0; i < block.size; ++i) at(block, i, lane) = list[static_cast<std::size_t>(i)];
  };
  put(now_.q, d.q);
  put(now_.v, d.v);
  put(now_.slides, s.problem_.slide_last);
  at(work_.tolerance, 0, lane) = s.tolerance_;
  const auto& works = d.totals.integrals;
  const auto& extremes = d.totals.extremes;
  at(now_.drive, 0, lane) = works.drive;
  at(now_.stabilisation, 0, lane) = works.stabilisation;
  at(now_.totals, lane_contact_loss, lane) = works.contact;
  at(now_.totals, lane_friction_loss, lane) = works.friction;
  at(now_.totals, lane_lcp_residual, lane) = extremes.lcp_residual;
  at(now_.totals, lane_lcp_residual_rate, lane) = extremes.lcp_residual_rate;
  at(now_.totals, lane_constraint_length, lane) = extremes.constraint_length;
  at(now_.totals, lane_constraint_angle, lane) = extremes.constraint_angle;
  at(now_.totals, lane_passed, lane) = *member.passed;
  for (int i = 0; i < now_.ratios.size; ++i) at(now_.ratios, i, lane) = 1;
  for (int k = 0; k < contacts_; ++k) {
    const auto& c = s.contacts_[k];
    if (c.steps > 0) time.contact = k;
    at(now_.gaps, k, lane) = c.gap;
    at(work_.facts, 2 * k, lane) = c.restitution;
    at(work_.facts, 2 * k + 1, lane) = s.tolerance_;
    const auto record = [&](int i) -> double& { return at(now_.records, lane_record_size * k + i, lane); };
    record(lane_impulse_n) = c.impulse_n;
    record(lane_impulse_t) = c.impulse_t;
    record(lane_last_n) = c.last_n;
    record(lane_last_t) = c.last_t;
    record(lane_u_n_minus) = c.u_n_minus;
    record(lane_u_n_plus) = c.u_n_plus;
    record(lane_u_t_plus) = c.u_t_plus;
    record(lane_bias_n) = c.bias_n;
    record(lane_bias_t) = c.bias_t;
    record(lane_penetration) = extremes.penetration[static_cast<std::size_t>(k)];
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
  const auto take = [&](const Block& block, std::vector<double>& list) {
    for (int i = 0; i < block.size; ++i) list[static_cast<std::size_t>(i)] = at(block, i, lane);
  };
  take(now_.q, d.q);
  take(now_.v, d.v);
  take(now_.slides, s.problem_.slide_last);
  auto& works = d.totals.integrals;
  auto& extremes = d.totals.extremes;
  works.drive = at(now_.drive, 0, lane);
  works.stabilisation = at(now_.stabilisation, 0, lane);
  works.contact = at(now_.totals, lane_contact_loss, lane);
  works.friction = at(now_.totals, lane_friction_loss, lane);
  extremes.lcp_residual = at(now_.totals, lane_lcp_residual, lane);
  extremes.lcp_residual_rate = at(now_.totals, lane_lcp_residual_rate, lane);
  extremes.constraint_length = at(now_.totals, lane_constraint_length, lane);
  extremes.constraint_angle = at(now_.totals, lane_constraint_angle, lane);
  *member.passed = at(now_.totals, lane_passed, lane);
  auto& work = d.totals.work;
  work.steps += time.steps;
  work.factorisations += time.steps;
  work.rhs += time.steps;
  work.lcp_solves += time.solves;
  if (now_.slides.size > 0) work.pivots += time.pressed;  // the first mode of each
  int ratio = 0;
  for (std::size_t block = 0; block < least_.size(); ++block) {
    least_[block] = 1;
    for (int i = 0; i < functions_.ratios[block]; ++i)
      least_[block] = std::min(least_[block], at(now_.ratios, ratio++, lane));
  }
  d.saddle.factored_elsewhere(least_.data());
  for (int k = 0; k < contacts_; ++k) {
    auto& c = s.contacts_[k];
    c.gap = at(now_.gaps, k, lane);
    if (k != time.contact) continue;
    const auto record = [&](int i) { return at(now_.records, lane_record_size * k + i, lane); };
    c.impulse_n = record(lane_impulse_n);
    c.impulse_t = record(lane_impulse_t);
    c.last_n = record(lane_last_n);
    c.last_t = record(lane_last_t);
    c.u_n_minus = record(lane_u_n_minus);
    c.u_n_plus = record(lane_u_n_plus);
    c.u_t_plus = record(lane_u_t_plus);
    c.bias_n = record(lane_bias_n);
    c.bias_t = record(lane_bias_t);
    extremes.penetration[static_cast<std::size_t>(k)] = record(lane_penetration);
    c.steps += static_cast<int>(time.pressed);
    c.t_pressed = time.t;
  }
}

void LaneGroup::set_times() {
  for (int lane = 0; lane < width_; ++lane) {
    auto& time = times_[static_cast<std::size_t>(lane)];
    time.solves_now = 0;
    const double t = time.t_start + static_cast<double>(time.index + 1) * time.step, h = t - time.t;
    at(work_.t_end, 0, lane) = t;
    at(work_.h, 0, lane) = h;
    at(work_.t_middle, 0, lane) = time.t + 0.5 * h;
  }
}

/// The impulses of contacts and of a joint friction. Returns the bits of lanes where other contacts act than
/// the one that is closed, or where they are not solved.
unsigned LaneGroup::meet_contacts(unsigned lanes) {
  unsigned other = 0, open = lanes;
  for (int k = 0; k < contacts_; ++k) {
    const unsigned acting = lanes_where([&](int lane) { return at(work_.reach, k, lane) <= 0; }),
                   closed = closed_at(k);
    // A joint friction may still press the closed contact.
    other |= functions_.slides.empty() ? acting ^ closed : acting & ~closed;
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
    const bool acts = (lanes >> lane & 1) != 0;
    at(work_.acts, contact, lane) = acts ? 1 : 0;
    times_[static_cast<std::size_t>(lane)].solves_now += acts ? 1 : 0;
  }
  return lanes &
         functions_.contacts[k](constants_, contact_calls_[k].in.data(), contact_calls_[k].out.data());
}

/// The impulse of the joint friction where no contact acts without it; and of a contact that acts with it.
/// Returns the bits of lanes where it is not the closed one, or where they are not solved.
unsigned LaneGroup::slide(unsigned lanes) {
  if (functions_.slides.empty() || lanes == 0) return 0;
  for (int lane = 0; lane < width_; ++lane) {
    const bool asked = (lanes >> lane & 1) != 0;
    at(work_.slide_asked, 0, lane) = asked ? 1 : 0;
    times_[static_cast<std::size_t>(lane)].solves_now += asked ? 1 : 0;
  }
  unsigned other = lanes & functions_.slides.front()(constants_, slide_.in.data(), slide_.out.data());
  for (int k = 0; k < contacts_; ++k)
    other |= lanes_where([&](int lane) { return at(work_.slide_reach, k, lane) <= 0; }) ^ closed_at(k);
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
      const bool opens = at(now_.gaps, k, lane) < 0;
      at(work_.opens, k, lane) = opens ? 1 : 0;
      if (opens) deep |= 1u << lane;
    }
    other |= deep & ~closed_at(k);
    deep &= lanes & ~other;
    if (deep == 0) continue;
    const auto which = static_cast<std::size_t>(k);
    other |= deep &
             functions_.opens[which](constants_, open_calls_[which].in.data(), open_calls_[which].out.data());
  }
  return other;
}

/// The work of the correction of positions against gravity and springs.
void LaneGroup::account_potential(unsigned lanes) {
  for (int lane = 0; lane < width_; ++lane) {
    if ((lanes >> lane & 1) == 0) continue;
    for (int i = 0; i < now_.q.size; ++i) {
      q_one_[static_cast<std::size_t>(i)] = at(now_.q, i, lane);
      q_free_one_[static_cast<std::size_t>(i)] = at(work_.free_q, i, lane);
    }
    const auto& system = members_[static_cast<std::size_t>(lane)].stepper->data_.system;
    const double before = system.potential(q_free_one_.data());
    at(now_.stabilisation, 0, lane) += system.potential(q_one_.data()) - before;
  }
}

/// Takes back the present step of these lanes.
void LaneGroup::restore(unsigned lanes) {
  const auto quantities = state_size_ / static_cast<std::size_t>(width_);
  for (int lane = 0; lane < width_; ++lane) {
    if ((lanes >> lane & 1) == 0) continue;
    for (std::size_t i = 0; i < quantities; ++i) {
      const auto place = i * static_cast<std::size_t>(width_) + static_cast<std::size_t>(lane);
      now_.q.data[place] = saved_.q.data[place];
    }
  }
}

void LaneGroup::record(long most) {
  const auto states = most > 0 ? static_cast<std::size_t>(most) + 1 : 0, lanes = members_.size();
  motion_.resize(states * static_cast<std::size_t>(now_.q.size + now_.v.size) * lanes);
  motion_times_.resize(states * lanes);
}

void LaneGroup::keep_motion(long step) {
  if (motion_.empty()) return;
  const auto at = static_cast<std::size_t>(step),
             size = static_cast<std::size_t>(now_.q.size + now_.v.size) * times_.size();
  std::memcpy(motion_.data() + at * size, now_.q.data, size * sizeof(double));  // and now_.v, which follows
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
  for (done_ = 0; done_ < most; ++done_) {
    std::memcpy(saved_.q.data, now_.q.data, state_size_ * sizeof(double));
    set_times();
    auto bad = functions_.middle(constants_, middle_.in.data(), middle_.out.data());
    bad |= meet_contacts(lanes);
    if ((bad & lanes) != lanes) {
      bad |= functions_.end(constants_, end_.in.data(), end_.out.data());
      bad |= open_gaps(lanes & ~bad);
      if (potential_) account_potential(lanes & ~bad);
    }
    bad &= lanes;
    for (int lane = 0; lane < width_; ++lane) {
      if ((bad >> lane & 1) != 0) continue;
      auto& time = times_[static_cast<std::size_t>(lane)];
      time.t = at(work_.t_end, 0, lane);
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
