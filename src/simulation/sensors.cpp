#include "simulation/sensors.hpp"

#include <algorithm>

namespace freeplay {

Sensors::Sensors(const std::vector<Instrument>& instruments, const Layout& layout, std::size_t coordinates,
                 std::uint64_t run)
    : elements_(instruments.size()), last_velocity_(instruments.size()), q_(coordinates), v_(coordinates) {
  forces_.elements.resize(layout.forces.size());
  forces_.acceleration.resize(coordinates);
  for (std::size_t i = 0; i < instruments.size(); ++i) {
    channels_.emplace_back(instruments[i], run);
    if (channels_[i].sensing() != Sensing::force) continue;
    any_force_ = true;
    with_kind(instruments[i].kind, [&](auto kind) {
      if constexpr (requires { kind.watches(instruments[i], layout.forces[0]); })
        for (std::size_t e = 0; e < layout.forces.size(); ++e)
          if (kind.watches(instruments[i], layout.forces[e])) elements_[i].push_back(static_cast<int>(e));
    });
  }
}

void Sensors::begin(const State& state, double end) {
  end_ = end;
  const bool rested = state.t != until_;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    channels_[i].begin(state.t, rested);
    if (rested && channels_[i].sensing() == Sensing::velocity)
      last_velocity_[i] = channels_[i].measure(state.v.data());
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
  // A sample at the end of the run up to rounding is taken there, so that it is not lost.
  const double last = step.t1 == end_ ? end_ + channel.near() : step.t1;
  for (double t = channel.next_sample(); t <= last && !step.stopped(); t = channel.next_sample()) {
    t = std::min(t, step.t1);
    step.state(t, q_, v_);
    sink(index, t, channel.take(channel.measure(q_.data())));
  }
}

/// Calls f(from, to) over the step up to the instant of its impacts, then `jump`, then f over the
/// remainder.
template <class F, class Jump>
void around(const Step& step, double in_impact, F f, Jump jump) {
  f(step.t0, in_impact);
  jump();
  f(in_impact, step.t1);
}

void Sensors::feed(const Step& step, Channel& channel, std::size_t index, const Sink& sink) {
  double v = channel.measure(step.v0.data());
  // Change of the velocity by an impact or projection between two steps.
  channel.jump(v - last_velocity_[index]);
  // The step's own impacts appear in the interpolated velocities as a ramp, which is subtracted.
  const auto in_impact = step.in_impact();
  const double dv = in_impact.v.empty() ? 0 : channel.measure(in_impact.v.data());
  const double ramp = step.t1 > step.t0 ? dv / (step.t1 - step.t0) : 0;
  const auto feed = [&](double from, double until) {
    channel.pieces(from, until, [&](double t, double to) {
      double v_to;
      if (to < step.t1) {
        step.state(to, q_, v_);
        v_to = channel.measure(v_.data());
      } else {
        v_to = channel.measure(step.v1.data());
      }
      if (channel.feed(t, to, v, v_to - ramp * (to - t))) sink(index, to, channel.output());
      v = v_to;
    });
  };
  if (dv == 0)
    feed(step.t0, step.t1);
  else
    around(step, in_impact.t, feed, [&] { channel.jump(dv); });
  last_velocity_[index] = channel.measure(step.v1.data());
}

double Sensors::measured(const Channel& channel, const Forces& forces) const {
  double sum = 0;
  for (const int e : elements_[static_cast<std::size_t>(&channel - channels_.data())])
    sum += channel.measure(forces.elements[static_cast<std::size_t>(e)]);
  return sum;
}

/// The force enters as its mean over each interval; impulses before and within the step as
/// impulses.
void Sensors::feed_force(const Step& step, Channel& channel, std::size_t index, const Sink& sink) {
  channel.jump(measured(channel, step.before()));
  const auto feed = [&](double from, double until) {
    channel.pieces(from, until, [&](double t, double to) {
      forces_.clear();
      step.add_impulse(t, to, forces_);
      if (channel.feed(t, to, 0, measured(channel, forces_))) sink(index, to, channel.output());
    });
  };
  around(step, step.in_impact().t, feed, [&] { channel.jump(measured(channel, step.within())); });
}

}  // namespace freeplay
