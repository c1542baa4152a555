#include "sim/recorder.hpp"

namespace freeplay {

std::atomic<bool> stop_requested{false};

Recorder::Recorder(const Scene& scene, const System& system, std::optional<std::filesystem::path> folder)
    : system_(system),
      duration_(scene.run.duration),
      output_step_(scene.run.output_step.value_or(scene.run.duration / 20000)),
      next_progress_(0),
      evaluation_(system.make_evaluation()),
      q_(system.n()),
      v_(system.n()) {
  if (const auto* drive = main_drive(scene.mechanism)) {
    crank_speed_ = drive->speed;
    crank_start_ = drive->initial_angle;
  }
  for (const auto& a : scene.instruments) channels_.emplace_back(a);
  last_velocity_.resize(channels_.size());
  events_.reserve(kept_events);
  if (!folder) return;

  // What an earlier run left here and this one will not write would be taken for its own.
  for (const auto* name : {"run.json", "trajectory.csv", "events.csv", "signals.csv"})
    std::filesystem::remove(*folder / name);
  trajectory_.emplace(*folder / "trajectory.csv");
  trajectory_->write("t");
  for (const auto& b : scene.mechanism.bodies)
    trajectory_->write(fmt::format(",{0}.x,{0}.y,{0}.theta,{0}.vx,{0}.vy,{0}.omega", b.name));
  for (int k = 0; k < system.contacts(); ++k)
    trajectory_->write(fmt::format(",{0}.ex,{0}.ey,{0}.gap", system.contact_facts(k).name));
  trajectory_->write("\n");
  if (system.contacts() > 0) {
    event_file_.emplace(*folder / "events.csv");
    event_file_->write(
        "t,joint,kind,crank_angle,v_n_minus,v_n_plus,v_t_minus,v_t_plus,impulse_n,impulse_t,duration,t_"
        "uncertainty\n");
    for (int k = 0; k < system.contacts(); ++k) joint_names_.push_back(system.contact_facts(k).name);
  }
  if (!channels_.empty()) {
    signals_.emplace(*folder / "signals.csv");
    signals_->write("channel,t,crank_angle,value\n");
  }
}

void Recorder::begin(const State& state) {
  if (!trajectory_) return;
  std::ranges::copy(state.q, q_.begin());
  std::ranges::copy(state.v, v_.begin());
  row(0);
  next_row_ = static_cast<double>(++row_index_) * output_step_;
}

void Recorder::row(double t) {
  auto& out = *trajectory_;
  out.number(t);
  const auto put = [&](double x) {
    out.write(",");
    out.number(x);
  };
  for (int b = 0; b < system_.bodies(); ++b) {
    for (int c = 3 * b; c < 3 * b + 3; ++c) put(q_[c]);
    for (int c = 3 * b; c < 3 * b + 3; ++c) put(v_[c]);
  }
  if (system_.contacts() > 0) system_.place(t, q_.data(), evaluation_);
  for (int k = 0; k < system_.contacts(); ++k) {
    const Vec2 e = system_.eccentricity(k, q_.data(), evaluation_);
    put(e.x());
    put(e.y());
    put(system_.gap(k, q_.data(), evaluation_));
  }
  out.write("\n");
}

void Recorder::event(const ContactEvent& e) {
  if (events_.size() < kept_events) events_.push_back(e);
  if (on_event) on_event(e);
  if (!event_file_) return;
  auto& out = *event_file_;
  out.number(e.t);
  out.write(",");
  out.write(joint_names_[e.joint]);
  out.write(",");
  out.write(name_of(e.kind));
  for (double x : {e.crank_angle, e.v_n_minus, e.v_n_plus, e.v_t_minus, e.v_t_plus, e.impulse_n, e.impulse_t,
                   e.duration, e.t_uncertainty}) {
    out.write(",");
    out.number(x);
  }
  out.write("\n");
}

void Recorder::sample(double t, std::size_t index, double value) {
  if (on_sample) on_sample(index, t, value);
  if (!signals_) return;
  signals_->write(channels_[index].settings().name);
  signals_->write(",");
  signals_->number(t);
  signals_->write(",");
  signals_->number(crank_start_ + crank_speed_ * t);
  signals_->write(",");
  signals_->number(value);
  signals_->write("\n");
}

void Recorder::progress(double t) {
  next_progress_ = t + duration_ / 200;
  if (on_progress) on_progress(t / duration_);
}

void Recorder::commit() {
  for (auto* file : {&trajectory_, &event_file_, &signals_})
    if (*file) (*file)->commit();
}

}  // namespace freeplay
