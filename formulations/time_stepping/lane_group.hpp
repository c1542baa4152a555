// LaneGroup: makes ordinary fixed steps of several MoreauSteppers together, by the functions of
// dynamics/lane_functions.hpp. Each stepper has a lane while its steps are ordinary; all its data that
// such steps change are then in the group. A lane whose next step is not ordinary is stored back, and
// the stepper makes that step itself. Both ways give the same digits.
//
// Usage: enter() gives a lane its stepper; ready() tells whether it may be loaded; load(), advance(),
// store().
#pragma once

#include <cstdint>
#include <vector>

#include "dynamics/lane_functions.hpp"

namespace freeplay {

class MoreauStepper;

class LaneGroup {
 public:
  /// A stepper, the constants of its functions, and its greatest energy (EnergyLedger::passed), which
  /// its owner keeps. Pointers, not owned.
  struct Member {
    MoreauStepper* stepper;
    const std::vector<double>* constants;
    double* passed;
  };
  /// `like`: any of the steppers.
  LaneGroup(LaneFunctions functions, const MoreauStepper& like);
  LaneGroup(const LaneGroup&) = delete;

  /// Whether steps of this stepper can be in a group at all.
  static bool fits(const MoreauStepper& stepper);
  void enter(int lane, const Member& member);
  /// Whether the next step may be ordinary: no contact has only just closed or opened.
  bool ready(int lane) const;
  void load(int lane);
  void store(int lane);
  /// Makes steps of these lanes (a bit for each) until `most` are done or a lane's step is not
  /// ordinary. Returns the bits of those lanes; the other lanes have made that step.
  unsigned advance(unsigned lanes, long most);
  /// Number of steps of the last advance() that all its lanes have made.
  long done() const { return done_; }
  /// Whether advance() records the motion of its steps, of which there are at most `most`; 0: no.
  void record(long most);
  /// The motion of a lane after `step` steps of the last advance(), 0 for its beginning. Returns the
  /// time, s.
  double recorded(long step, int lane, std::vector<double>& q, std::vector<double>& v) const;

 private:
  /// An array of the functions: `size` quantities of all lanes.
  struct Block {
    double* data = nullptr;
    int size = 0;
    operator double*() const { return data; }
  };
  /// Quantities that steps change.
  struct State {
    Block q, v, drive, stabilisation, gaps, records, totals, slides, ratios;
  };
  /// Quantities of one step.
  struct Work {
    Block middle_q, cosine, sine, phi_t, G, gamma, factors, force, lambda, middle_gap, normal, tangent,
        gamma_n, gamma_t, rates, reach, free_q, t_middle, t_end, h, acts, opens, facts, slide_row,
        slide_gamma, slide_asked, slide_reach, tolerance, unused;
  };
  /// Arguments of a function.
  struct Call {
    std::vector<const double*> in;
    std::vector<double*> out;
  };
  struct Times {
    double t = 0, t_start = 0, step = 1;  // s
    long index = 0;
    long steps = 0, pressed = 0;      // since load(): all steps, and those of a contact
    long solves = 0, solves_now = 0;  // of the problem of contacts and friction; in the present step
    int contact = -1;                 // that is closed
  };
  void divide(std::vector<double>& room, const std::vector<std::pair<Block*, int>>& blocks) const;
  void connect();
  double& at(const Block& block, int i, int lane) const { return block.data[i * width_ + lane]; }
  void set_times();
  unsigned meet_contacts(unsigned lanes);
  /// The bits of the lanes for which f(lane) holds.
  unsigned lanes_where(auto f) const {
    unsigned bits = 0;
    for (int lane = 0; lane < width_; ++lane)
      if (f(lane)) bits |= 1u << lane;
    return bits;
  }
  unsigned closed_at(int contact) const {
    return lanes_where([&](int lane) { return times_[static_cast<std::size_t>(lane)].contact == contact; });
  }
  unsigned press(int contact, unsigned lanes);
  unsigned slide(unsigned lanes);
  unsigned open_gaps(unsigned lanes);
  void account_potential(unsigned lanes);
  void restore(unsigned lanes);
  void keep_motion(long step);

  LaneFunctions functions_;
  std::vector<Member> members_;
  int width_, contacts_;
  std::vector<Times> times_;
  std::vector<double> constants_room_, state_room_, saved_room_, work_room_;
  std::size_t state_size_ = 0;
  double* constants_ = nullptr;
  State now_, saved_;  // after the present step, and before it
  Work work_;
  Call middle_, end_, slide_;
  std::vector<Call> contact_calls_, open_calls_;  // of each contact
  bool potential_ = false;
  std::vector<double> q_one_, q_free_one_, least_;  // of one lane
  long done_ = 0;
  std::vector<double> motion_, motion_times_;  // of recorded steps; empty: none
};

}  // namespace freeplay
