// Streams what a scene asks to be recorded while a formulation steps: rows of trajectory.csv, settled events,
// samples of the instruments. Memory does not grow with the length of the run. Without a folder nothing is
// written.
#pragma once

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "measure/instrument.hpp"
#include "model/scene.hpp"
#include "model/system.hpp"
#include "sim/contact_log.hpp"
#include "sim/output_file.hpp"

namespace freeplay {

/// Set by a signal handler: the run ends after the present step with whole files.
extern std::atomic<bool> stop_requested;

class Recorder {
 public:
  /// How many events are kept in memory for comparisons.
  static constexpr std::size_t kept_events = 4096;

  Recorder(const Scene& scene, const System& system, std::optional<std::filesystem::path> folder);

  /// After each accepted step. A Stepper has t_old(), t(), v_old(), v() and interpolate(t, q, v) within its
  /// last step.
  template <class Stepper>
  void accept(const Stepper& stepper, ContactLog& log) {
    if (log.has_pending()) log.drain([&](const ContactEvent& e) { event(e); });
    if (trajectory_)
      for (; next_row_ <= stepper.t() && !stop_requested;
           next_row_ = static_cast<double>(++row_index_) * output_step_) {
        stepper.interpolate(next_row_, q_.data(), v_.data());
        row(next_row_);
      }
    for (std::size_t i = 0; i < channels_.size(); ++i)
      if (channels_[i].is_accelerometer())
        feed(stepper, channels_[i], i);
      else
        read(stepper, channels_[i], i);
    if (stepper.t() >= next_progress_) progress(stepper.t());
  }
  void event(const ContactEvent& event);
  /// First row of the trajectory and the start of the instruments.
  void begin(const State& state);
  /// Puts the files in their places.
  void commit();

  const std::vector<ContactEvent>& events() const { return events_; }
  /// Called now and then with the fraction done.
  std::function<void(double)> on_progress;
  /// Called with every settled event, in the order of t.
  std::function<void(const ContactEvent&)> on_event;
  /// Called with every sample of every channel: (channel in the scene's order, t in s, value).
  std::function<void(std::size_t, double, double)> on_sample;

 private:
  template <class Stepper>
  void read(const Stepper& stepper, Channel& channel, std::size_t index) {
    for (double t = channel.next_sample(); t <= stepper.t() && !stop_requested; t = channel.next_sample()) {
      stepper.interpolate(t, q_.data(), v_.data());
      sample(t, index, channel.take(channel.reading(q_.data())));
    }
  }
  template <class Stepper>
  void feed(const Stepper& stepper, Channel& channel, std::size_t index) {
    const double t_end = stepper.t(), longest = channel.longest_piece() * (1 + 1e-6), tiny = 1e-6 * longest;
    double t = stepper.t_old(), v = channel.velocity(stepper.v_old());
    // What an impact between two steps, or a projection, did to the velocity.
    if (last_velocity_[index]) channel.jump(v - *last_velocity_[index]);
    while (t < t_end) {
      double to = t_end - t > longest ? t + longest : t_end;
      if (const double due = channel.next_sample(); due > t + tiny && due < to - tiny) to = due;
      double v_to;
      if (to < t_end) {
        stepper.interpolate(to, q_.data(), v_.data());
        v_to = channel.velocity(v_.data());
      } else {
        v_to = channel.velocity(stepper.v());
      }
      if (channel.feed(t, to, v, v_to)) sample(to, index, channel.output());
      t = to;
      v = v_to;
    }
    last_velocity_[index] = v;
  }
  void row(double t);
  void sample(double t, std::size_t index, double value);
  void progress(double t);

  const System& system_;
  std::vector<std::string> joint_names_;
  double duration_, output_step_, next_row_ = 0, next_progress_;
  double crank_start_ = 0, crank_speed_ = 0;  // rad, rad/s
  long row_index_ = 0;
  std::optional<OutputFile> trajectory_, event_file_, signals_;
  std::vector<Channel> channels_;
  std::vector<std::optional<double>> last_velocity_;  // of each channel, at the end of the last step
  Evaluation evaluation_;
  std::vector<double> q_, v_;
  std::vector<ContactEvent> events_;
};

}  // namespace freeplay
