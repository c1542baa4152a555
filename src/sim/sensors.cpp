#include "sim/sensors.hpp"

namespace freeplay {

Sensors::Sensors(const std::vector<Instrument>& instruments, const Layout& layout, std::size_t coordinates)
    : elements_(instruments.size()), last_velocity_(instruments.size()), q_(coordinates), v_(coordinates) {
  forces_.elements.resize(layout.forces.size());
  forces_.acceleration.resize(coordinates);
  for (std::size_t i = 0; i < instruments.size(); ++i) {
    channels_.emplace_back(instruments[i]);
    const auto kind = instruments[i].kind;
    if (!measures_force(kind)) continue;
    any_force_ = true;
    using Kind = ForceElement::Kind;
    for (std::size_t e = 0; e < layout.forces.size(); ++e) {
      const auto& element = layout.forces[e];
      // Its ideal reaction, its contacts and the friction of its preload; a drive turns it, with no force.
      const bool of_joint = element.kind != Kind::drive;
      if (kind == Instrument::Kind::load_cell
              ? of_joint && element.joint == instruments[i].joint
              : element.kind == Kind::drive && element.name == instruments[i].drive)
        elements_[i].push_back(static_cast<int>(e));
    }
  }
}

void Sensors::begin(double t) {
  const bool rested = t != until_;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    channels_[i].begin(t, rested);
    if (rested) last_velocity_[i].reset();
  }
}

void Sensors::step(const Step& step, const Sink& sink) {
  for (std::size_t i = 0; i < channels_.size(); ++i) switch (channels_[i].settings().kind) {
      case Instrument::Kind::accelerometer:
        feed(step, channels_[i], i, sink);
        break;
      case Instrument::Kind::load_cell:
      case Instrument::Kind::torque:
        feed_force(step, channels_[i], i, sink);
        break;
      case Instrument::Kind::lvdt:
      case Instrument::Kind::encoder:
        read(step, channels_[i], i, sink);
        break;
    }
  until_ = step.t1;
}

void Sensors::read(const Step& step, Channel& channel, std::size_t index, const Sink& sink) {
  for (double t = channel.next_sample(); t <= step.t1 && !step.stopped(); t = channel.next_sample()) {
    step.state(t, q_, v_);
    sink(index, t, channel.take(channel.reading(q_.data())));
  }
}

void Sensors::feed(const Step& step, Channel& channel, std::size_t index, const Sink& sink) {
  double v = channel.velocity(step.v0.data());
  // What an impact between two steps, or a projection, did to the velocity.
  if (last_velocity_[index]) channel.jump(v - *last_velocity_[index]);
  channel.pieces(step.t0, step.t1, [&](double t, double to) {
    double v_to;
    if (to < step.t1) {
      step.state(to, q_, v_);
      v_to = channel.velocity(v_.data());
    } else {
      v_to = channel.velocity(step.v1.data());
    }
    if (channel.feed(t, to, v, v_to)) sink(index, to, channel.output());
    v = v_to;
  });
  last_velocity_[index] = v;
}

double Sensors::measured(const Channel& channel, const Forces& forces) const {
  double sum = 0;
  const auto& settings = channel.settings();
  for (const int e : elements_[static_cast<std::size_t>(&channel - channels_.data())]) {
    const auto& f = forces.elements[e];
    sum += settings.kind == Instrument::Kind::load_cell ? settings.axis.x() * f.fx + settings.axis.y() * f.fy
                                                        : f.m;
  }
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
