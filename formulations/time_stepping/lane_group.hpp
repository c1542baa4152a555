// LaneGroup: makes fixed steps of several MoreauSteppers together, by the functions of lane_functions.hpp.
// Each stepper has a lane while its steps are ordinary: at most one contact acts, which is closed before and
// after the step. All its data that such steps change are then in the group. If a step needs more than one
// contact, or a contact opens or closes, its lane is copied back and the stepper makes the step. Both ways
// give bitwise identical results. LaneScheduler decides which lane leaves and returns.
//
// Usage: enter() gives a lane its stepper; ready() tells whether it may be loaded; load(), advance(),
// store().
#pragma once

#include <vector>

#include "formulations/time_stepping/lane_functions.hpp"

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
  struct Times {
    double t = 0, t_start = 0, step = 1;  // s
    long index = 0;
    long steps = 0, pressed = 0;      // since load(): all steps, and those of a contact
    long solves = 0, solves_now = 0;  // of the problem of contacts and friction; in the present step
    int contact = -1;                 // that is closed
  };
  int size(LaneArray array) const { return sizes_[static_cast<std::size_t>(array)]; }
  double& at(LaneArray array, int i, int lane) const {
    return table_[static_cast<std::size_t>(array)][i * width_ + lane];
  }
  unsigned call(CompiledFunction function) {
    return static_cast<unsigned>(function(constants_, table_.data(), table_.data()));
  }
  void move(MoreauStepper& stepper, int lane, double& passed, auto copy) const;
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
  void accumulate_potential(unsigned lanes);
  void restore(unsigned lanes);
  void keep_motion(long step);

  LaneFunctions functions_;
  std::vector<Member> members_;
  int width_, contacts_;
  std::vector<Times> times_;
  std::vector<double> constants_room_, room_;
  double* constants_ = nullptr;
  LaneTable table_{};
  std::vector<int> sizes_;
  std::size_t state_size_ = 0;  // numbers from q to ratios, and as many from q_old on before the step
  bool potential_ = false;
  std::vector<double> q_one_, q_free_one_, least_;  // of one lane
  long done_ = 0;
  std::vector<double> motion_, motion_times_;  // of recorded steps; empty: none
};

}  // namespace freeplay
