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
  const auto state = [&](Block& q, Block& v, Block& drive, Block& stabilisation, Block& gaps, Block& records,
                         Block& totals, Block& slides, Block& ratios) {
    return std::vector<std::pair<Block*, int>>{{&q, n},
                                               {&v, n},
                                               {&drive, 1},
                                               {&stabilisation, 1},
                                               {&gaps, K},
                                               {&records, K * lane_record_size},
                                               {&totals, lane_total_size},
                                               {&slides, static_cast<int>(functions_.slides.size())},
                                               {&ratios, all_ratios}};
  };
  const auto blocks = state(q_, v_, drive_, stabilisation_, gaps_, records_, totals_, slides_, ratios_);
  divide(state_room_, blocks);
  divide(saved_room_, state(saved_q_, saved_v_, saved_drive_, saved_stabilisation_, saved_gaps_,
                            saved_records_, saved_totals_, saved_slides_, saved_ratios_));
  for (const auto& [block, size] : blocks) state_size_ += static_cast<std::size_t>(size * width_);
  divide(work_room_, {{&middle_q_, n},
                      {&cosine_, bodies},
                      {&sine_, bodies},
                      {&phi_t_, m},
                      {&G_, entries},
                      {&gamma_, m},
                      {&factors_, functions_.factors},
                      {&force_, n},
                      {&lambda_, m},
                      {&middle_gap_, K},
                      {&normal_, K * row_size},
                      {&tangent_, K * row_size},
                      {&gamma_n_, K},
                      {&gamma_t_, K},
                      {&rates_, 4 * K},
                      {&reach_, K},
                      {&free_q_, n},
                      {&t_middle_, 1},
                      {&t_end_, 1},
                      {&h_, 1},
                      {&acts_, K},
                      {&opens_, K},
                      {&facts_, 2 * K},
                      {&slide_row_, row_size},
                      {&slide_gamma_, 1},
                      {&slide_asked_, 1},
                      {&slide_reach_, K},
                      {&tolerance_, 1},
                      {&unused_, 1}});
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
  const auto part = [&](const Block& block, int i) { return block.data + i * width_; };
  middle_in_ = {t_middle_.data, h_.data, saved_q_.data, saved_v_.data, saved_ratios_.data};
  middle_out_ = {middle_q_.data, cosine_.data, sine_.data,  phi_t_.data, G_.data,      gamma_.data,
                 factors_.data,  unused_.data, force_.data, v_.data,     lambda_.data, unused_.data};
  end_in_ = {
      t_end_.data, h_.data, middle_q_.data, saved_v_.data, v_.data,    lambda_.data, force_.data,
      phi_t_.data, G_.data, factors_.data,  cosine_.data,  sine_.data, drive_.data,  stabilisation_.data,
      totals_.data};
  end_out_ = {free_q_.data,        q_.data,      unused_.data, unused_.data, drive_.data,
              stabilisation_.data, unused_.data, unused_.data};
  for (int k = 0; k < contacts_; ++k) {
    for (double* x : {part(middle_gap_, k), part(normal_, row_size * k), part(tangent_, row_size * k),
                      part(gamma_n_, k), part(gamma_t_, k), part(rates_, 4 * k)})
      middle_out_.push_back(x);
    end_out_.push_back(part(gaps_, k));
    double* record = part(records_, lane_record_size * k);
    contact_in_.push_back({h_.data,
                           factors_.data,
                           G_.data,
                           part(normal_, row_size * k),
                           part(tangent_, row_size * k),
                           part(rates_, 4 * k),
                           gamma_n_.data,
                           gamma_t_.data,
                           middle_gap_.data,
                           normal_.data,
                           v_.data,
                           lambda_.data,
                           force_.data,
                           saved_v_.data,
                           part(acts_, k),
                           part(facts_, 2 * k),
                           record,
                           totals_.data,
                           slide_row_.data,
                           slide_gamma_.data,
                           slides_.data});
    contact_out_.push_back({v_.data, lambda_.data, force_.data, record, totals_.data, slides_.data});
    open_in_.push_back({t_end_.data, middle_q_.data, cosine_.data, sine_.data, factors_.data, G_.data,
                        part(normal_, row_size * k), q_.data, gaps_.data, part(opens_, k), totals_.data,
                        record, part(facts_, 2 * k)});
    open_out_.push_back({q_.data, gaps_.data, totals_.data, record});
  }
  for (double* x : {reach_.data, ratios_.data, slide_row_.data, slide_gamma_.data}) middle_out_.push_back(x);
  slide_in_ = {h_.data,         factors_.data, G_.data,          slide_row_.data, slide_gamma_.data,
               slides_.data,    gamma_n_.data, middle_gap_.data, normal_.data,    unused_.data,
               v_.data,         lambda_.data,  force_.data,      saved_v_.data,   slide_asked_.data,
               tolerance_.data, totals_.data};
  slide_out_ = {v_.data, lambda_.data, force_.data, totals_.data, slides_.data, slide_reach_.data};
  end_out_.push_back(totals_.data);
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
    if (slides_.size > 0 && c.steps < 2) return false;  // the next step would not start from its impulses
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
  put(q_, d.q);
  put(v_, d.v);
  put(slides_, s.problem_.slide_last);
  at(tolerance_, 0, lane) = s.tolerance_;
  const auto& works = d.totals.integrals;
  const auto& extremes = d.totals.extremes;
  at(drive_, 0, lane) = works.drive;
  at(stabilisation_, 0, lane) = works.stabilisation;
  at(totals_, lane_contact_loss, lane) = works.contact;
  at(totals_, lane_friction_loss, lane) = works.friction;
  at(totals_, lane_lcp_residual, lane) = extremes.lcp_residual;
  at(totals_, lane_lcp_residual_rate, lane) = extremes.lcp_residual_rate;
  at(totals_, lane_constraint_length, lane) = extremes.constraint_length;
  at(totals_, lane_constraint_angle, lane) = extremes.constraint_angle;
  at(totals_, lane_passed, lane) = *member.passed;
  for (int i = 0; i < ratios_.size; ++i) at(ratios_, i, lane) = 1;
  for (int k = 0; k < contacts_; ++k) {
    const auto& c = s.contacts_[k];
    if (c.steps > 0) time.contact = k;
    at(gaps_, k, lane) = c.gap;
    at(facts_, 2 * k, lane) = c.restitution;
    at(facts_, 2 * k + 1, lane) = s.tolerance_;
    const auto record = [&](int i) -> double& { return at(records_, lane_record_size * k + i, lane); };
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
  take(q_, d.q);
  take(v_, d.v);
  take(slides_, s.problem_.slide_last);
  auto& works = d.totals.integrals;
  auto& extremes = d.totals.extremes;
  works.drive = at(drive_, 0, lane);
  works.stabilisation = at(stabilisation_, 0, lane);
  works.contact = at(totals_, lane_contact_loss, lane);
  works.friction = at(totals_, lane_friction_loss, lane);
  extremes.lcp_residual = at(totals_, lane_lcp_residual, lane);
  extremes.lcp_residual_rate = at(totals_, lane_lcp_residual_rate, lane);
  extremes.constraint_length = at(totals_, lane_constraint_length, lane);
  extremes.constraint_angle = at(totals_, lane_constraint_angle, lane);
  *member.passed = at(totals_, lane_passed, lane);
  auto& work = d.totals.work;
  work.steps += time.steps;
  work.factorisations += time.steps;
  work.rhs += time.steps;
  work.lcp_solves += time.solves;
  if (slides_.size > 0) work.pivots += time.pressed;  // the first mode of each
  int ratio = 0;
  for (std::size_t block = 0; block < least_.size(); ++block) {
    least_[block] = 1;
    for (int i = 0; i < functions_.ratios[block]; ++i)
      least_[block] = std::min(least_[block], at(ratios_, ratio++, lane));
  }
  d.saddle.factored_elsewhere(least_.data());
  for (int k = 0; k < contacts_; ++k) {
    auto& c = s.contacts_[k];
    c.gap = at(gaps_, k, lane);
    if (k != time.contact) continue;
    const auto record = [&](int i) { return at(records_, lane_record_size * k + i, lane); };
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
    at(t_end_, 0, lane) = t;
    at(h_, 0, lane) = h;
    at(t_middle_, 0, lane) = time.t + 0.5 * h;
  }
}

/// The impulses of contacts and of a joint friction. Returns the bits of lanes where other contacts act than
/// the one that is closed, or where they are not solved.
unsigned LaneGroup::meet_contacts(unsigned lanes) {
  unsigned other = 0, open = lanes;
  for (int k = 0; k < contacts_; ++k) {
    const unsigned acting = lanes_where([&](int lane) { return at(reach_, k, lane) <= 0; }),
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
    at(acts_, contact, lane) = acts ? 1 : 0;
    times_[static_cast<std::size_t>(lane)].solves_now += acts ? 1 : 0;
  }
  return lanes & functions_.contacts[k](constants_, contact_in_[k].data(), contact_out_[k].data());
}

/// The impulse of the joint friction where no contact acts without it; and of a contact that acts with it.
/// Returns the bits of lanes where it is not the closed one, or where they are not solved.
unsigned LaneGroup::slide(unsigned lanes) {
  if (functions_.slides.empty() || lanes == 0) return 0;
  for (int lane = 0; lane < width_; ++lane) {
    const bool asked = (lanes >> lane & 1) != 0;
    at(slide_asked_, 0, lane) = asked ? 1 : 0;
    times_[static_cast<std::size_t>(lane)].solves_now += asked ? 1 : 0;
  }
  unsigned other = lanes & functions_.slides.front()(constants_, slide_in_.data(), slide_out_.data());
  for (int k = 0; k < contacts_; ++k)
    other |= lanes_where([&](int lane) { return at(slide_reach_, k, lane) <= 0; }) ^ closed_at(k);
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
      const bool opens = at(gaps_, k, lane) < 0;
      at(opens_, k, lane) = opens ? 1 : 0;
      if (opens) deep |= 1u << lane;
    }
    other |= deep & ~closed_at(k);
    deep &= lanes & ~other;
    if (deep == 0) continue;
    const auto which = static_cast<std::size_t>(k);
    other |= deep & functions_.opens[which](constants_, open_in_[which].data(), open_out_[which].data());
  }
  return other;
}

/// The work of the correction of positions against gravity and springs.
void LaneGroup::account_potential(unsigned lanes) {
  for (int lane = 0; lane < width_; ++lane) {
    if ((lanes >> lane & 1) == 0) continue;
    for (int i = 0; i < q_.size; ++i) {
      q_one_[static_cast<std::size_t>(i)] = at(q_, i, lane);
      q_free_one_[static_cast<std::size_t>(i)] = at(free_q_, i, lane);
    }
    const auto& system = members_[static_cast<std::size_t>(lane)].stepper->data_.system;
    const double before = system.potential(q_free_one_.data());
    at(stabilisation_, 0, lane) += system.potential(q_one_.data()) - before;
  }
}

/// Takes back the present step of these lanes.
void LaneGroup::restore(unsigned lanes) {
  const auto quantities = state_size_ / static_cast<std::size_t>(width_);
  for (int lane = 0; lane < width_; ++lane) {
    if ((lanes >> lane & 1) == 0) continue;
    for (std::size_t i = 0; i < quantities; ++i) {
      const auto place = i * static_cast<std::size_t>(width_) + static_cast<std::size_t>(lane);
      q_.data[place] = saved_q_.data[place];
    }
  }
}

void LaneGroup::record(long most) {
  const auto states = most > 0 ? static_cast<std::size_t>(most) + 1 : 0, lanes = members_.size();
  motion_.resize(states * static_cast<std::size_t>(q_.size + v_.size) * lanes);
  motion_times_.resize(states * lanes);
}

void LaneGroup::keep_motion(long step) {
  if (motion_.empty()) return;
  const auto at = static_cast<std::size_t>(step),
             size = static_cast<std::size_t>((q_.size + v_.size) * width_);
  std::memcpy(motion_.data() + at * size, q_.data, size * sizeof(double));  // and v_, which follows
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
    std::memcpy(saved_q_.data, q_.data, state_size_ * sizeof(double));
    set_times();
    auto bad = functions_.middle(constants_, middle_in_.data(), middle_out_.data());
    bad |= meet_contacts(lanes);
    if ((bad & lanes) != lanes) {
      bad |= functions_.end(constants_, end_in_.data(), end_out_.data());
      bad |= open_gaps(lanes & ~bad);
      if (potential_) account_potential(lanes & ~bad);
    }
    bad &= lanes;
    for (int lane = 0; lane < width_; ++lane) {
      if ((bad >> lane & 1) != 0) continue;
      auto& time = times_[static_cast<std::size_t>(lane)];
      time.t = at(t_end_, 0, lane);
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
