#include "sim/sensors.hpp"

#include <algorithm>

namespace freeplay {

Sensors::Sensors(const std::vector<Instrument>& instruments, const Layout& layout, std::size_t coordinates)
    : elements_(instruments.size()), last_velocity_(instruments.size()), q_(coordinates), v_(coordinates) {
  forces_.elements.resize(layout.forces.size());
  forces_.acceleration.resize(coordinates);
  for (std::size_t i = 0; i < instruments.size(); ++i) {
    channels_.emplace_back(instruments[i]);
    if (channels_[i].sensing() != Sensing::force) continue;
    any_force_ = true;
    with_kind(instruments[i].kind, [&](auto kind) {
      if constexpr (requires { kind.watches(instruments[i], layout.forces[0]); })
        for (std::size_t e = 0; e < layout.forces.size(); ++e)
          if (kind.watches(instruments[i], layout.forces[e])) elements_[i].push_back(static_cast<int>(e));
    });
  }
}

void Sensors::begin(double t, double end) {
  end_ = end;
  const bool rested = t != until_;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    channels_[i].begin(t, rested);
    if (rested) last_velocity_[i].reset();
  }
}

void Sensors::step(const Step& step, const Sink& sink) {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    switch (channels_[i].sensing()) {
      case Sensing::velocity:
        feed(step, channels_[i], i, sink);
        break;
      case Sensing::force:
        feed_force(step, channels_[i], i, sink);
        break;
      case Sensing::position:
        read(step, channels_[i], i, sink);
        break;
    }
  }
  until_ = step.t1;
}

void Sensors::read(const Step& step, Channel& channel, std::size_t index, const Sink& sink) {
  // A sample that falls on the run's end but for rounding is taken there, and not lost behind it.
  const double last = step.t1 == end_ ? end_ + 1e-9 / channel.settings().sampling : step.t1;
  for (double t = channel.next_sample(); t <= last && !step.stopped(); t = channel.next_sample()) {
    t = std::min(t, step.t1);
    step.state(t, q_, v_);
    sink(index, t, channel.take(channel.measure(q_.data())));
  }
}

void Sensors::feed(const Step& step, Channel& channel, std::size_t index, const Sink& sink) {
  double v = channel.measure(step.v0.data());
  // What an impact between two steps, or a projection, did to the velocity.
  if (last_velocity_[index]) channel.jump(v - *last_velocity_[index]);
  channel.pieces(step.t0, step.t1, [&](double t, double to) {
    double v_to;
    if (to < step.t1) {
      step.state(to, q_, v_);
      v_to = channel.measure(v_.data());
    } else {
      v_to = channel.measure(step.v1.data());
    }
    if (channel.feed(t, to, v, v_to)) sink(index, to, channel.output());
    v = v_to;
  });
  last_velocity_[index] = v;
}

double Sensors::measured(const Channel& channel, const Forces& forces) const {
  double sum = 0;
  for (const int e : elements_[static_cast<std::size_t>(&channel - channels_.data())])
    sum += channel.measure(forces.elements[static_cast<std::size_t>(e)]);
  return sum;
}

/// The force as its mean over each piece; impulses before the step as such, those within it spread over it.
void Sensors::feed_force(const Step& step, Channel& channel, std::size_t index, const Sink& sink) {
  channel.jump(measured(channel, step.before()));
  const double h = step.t1 - step.t0;
  if (h == 0) channel.jump(measured(channel, step.within()));
  const double within = h > 0 ? measured(channel, step.within()) / h : 0;
  channel.pieces(step.t0, step.t1, [&](double t, double to) {
    forces_.clear();
    step.add_impulse(t, to, forces_);
    const double impulse = measured(channel, forces_) + within * (to - t);
    if (channel.feed(t, to, 0, impulse)) sink(index, to, channel.output());
  });
}

}  // namespace freeplay
