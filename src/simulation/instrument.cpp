#include "simulation/instrument.hpp"

#include <algorithm>
#include <numbers>

namespace freeplay {

LowPass::LowPass(double bandwidth, int order) {
  const double cut = 2 * std::numbers::pi * bandwidth;
  const auto pole = [&](int k) {
    return std::polar(cut, std::numbers::pi * (2 * k + order - 1) / (2.0 * order));
  };
  for (int k = 1; k <= (order + 1) / 2; ++k) {
    Complex residue = 1;
    for (int j = 1; j <= order; ++j) {
      residue *= cut;
      if (j != k) residue /= pole(k) - pole(j);
    }
    const bool real = 2 * k == order + 1;
    pole_[modes_] = real ? Complex(-cut) : pole(k);
    // a conjugate pair contributes twice its real part
    residue_[modes_++] = real ? residue.real() : 2.0 * residue;
  }
}

void LowPass::reset(double input) {
  for (int k = 0; k < modes_; ++k) z_[k] = -input / pole_[k];
}

void LowPass::prepare(double h) {
  h_ = h;
  auto known = std::ranges::find(prepared_, h, &Prepared::h);
  if (known == prepared_.end()) {
    known = prepared_.begin() + static_cast<std::ptrdiff_t>(oldest_++ % prepared_.size());
    known->h = h;
    for (int k = 0; k < modes_; ++k) {
      known->decay[k] = std::exp(pole_[k] * h);
      known->gain[k] = (known->decay[k] - 1.0) / pole_[k];
    }
  }
  decay_ = known->decay;
  gain_ = known->gain;
}

void LowPass::advance(double h, double a) {
  // Steps that differ by rounding share their coefficients.
  if (std::abs(h - h_) > 1e-9 * h) prepare(h);
  for (int k = 0; k < modes_; ++k) z_[k] = decay_[k] * z_[k] + gain_[k] * a;
}

double LowPass::output() const {
  double y = 0;
  for (int k = 0; k < modes_; ++k) y += residue_[k].real() * z_[k].real() - residue_[k].imag() * z_[k].imag();
  return y;
}

namespace {

/// SplitMix64: a hash of the counter.
std::uint64_t mixed(std::uint64_t counter) {
  std::uint64_t z = counter * 0x9e3779b97f4a7c15u + 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// Uniform in (0, 1].
double uniform(std::uint64_t counter) { return static_cast<double>((mixed(counter) >> 11) + 1) * 0x1p-53; }

/// Start of a channel's counter.
std::uint64_t stream_of(const Instrument& settings, std::uint64_t run) {
  std::uint64_t stream = mixed(settings.seed);
  for (const char c : settings.name) stream = mixed(stream ^ static_cast<unsigned char>(c));
  return mixed(stream ^ mixed(run));
}

/// A standard normal number by the Box–Muller method.
double normal(std::uint64_t stream, std::uint64_t index) {
  const std::uint64_t counter = stream + 2 * index;
  return std::sqrt(-2 * std::log(uniform(counter))) * std::cos(2 * std::numbers::pi * uniform(counter + 1));
}

}  // namespace

Channel::Channel(const Instrument& settings, std::uint64_t run)
    : settings_(settings),
      sensing_(sensing_of(settings.kind)),
      filter_(std::max(settings.bandwidth, 1.0), settings.order),
      stream_(stream_of(settings, run)) {}

void Channel::begin(double t, bool anew) {
  if (anew) {
    started_ = false;
    early_ = 0;
  }
  if (next_sample() > t) return;
  index_ = std::max(index_, static_cast<long>(std::floor(t * settings_.sampling)));
  while (next_sample() <= t) ++index_;
}

double Channel::shown(double value) const {
  if (settings_.noise) value += *settings_.noise * normal(stream_, static_cast<std::uint64_t>(index_));
  if (!settings_.resolution)
    return settings_.range ? std::clamp(value, -*settings_.range, *settings_.range) : value;
  double code = std::floor(value / *settings_.resolution);
  if (settings_.range) {
    const double last = std::floor(*settings_.range / *settings_.resolution * (1 + 1e-12));
    code = std::clamp(code, -last, last);
  }
  return *settings_.resolution * code;
}

bool Channel::feed(double t0, double t1, double v0, double v1) {
  const double h = t1 - t0;
  if (h > 0) {
    const double a = (v1 - v0) / h;
    if (!started_) {
      filter_.reset(a);
      filter_.add_jump(early_);
      early_ = 0;
    }
    started_ = true;
    filter_.advance(h, a);
  }
  if (t1 < next_sample() - near()) return false;
  ++index_;
  return true;
}

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
