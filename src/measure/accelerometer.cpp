#include "measure/accelerometer.hpp"

#include <cmath>
#include <numbers>

namespace freeplay {

LowPass::LowPass(double bandwidth) : sigma_(2 * std::numbers::pi * bandwidth / std::numbers::sqrt2) {}

void LowPass::reset(double input) {
  y_ = input;
  rate_ = 0;
}

void LowPass::advance(double h, double a) {
  if (std::abs(h - h_) > 1e-9 * h) {  // steps that differ by rounding share their coefficients
    h_ = h;
    const double decay = std::exp(-sigma_ * h);
    decay_cos_ = decay * std::cos(sigma_ * h);
    decay_sin_ = decay * std::sin(sigma_ * h);
  }
  const double z = y_ - a, w = rate_ / sigma_ + z;
  // z(h) and ż(h); ż = −σ (z − w')  with w' the derivative of the bracket
  const double z1 = z * decay_cos_ + w * decay_sin_;
  rate_ = sigma_ * (-z1 - z * decay_sin_ + w * decay_cos_);
  y_ = a + z1;
}

AccelerometerChannel::AccelerometerChannel(const Accelerometer& settings)
    : settings_(settings), filter_(settings.bandwidth) {}

double AccelerometerChannel::velocity(const double* v) const {
  return settings_.axis.x() * v[3 * settings_.body] + settings_.axis.y() * v[3 * settings_.body + 1];
}

bool AccelerometerChannel::feed(double t0, double t1, double v0, double v1) {
  const double h = t1 - t0;
  if (h > 0) {
    const double a = (v1 - v0) / h;
    if (!started_) filter_.reset(a);
    started_ = true;
    filter_.advance(h, a);
  }
  if (t1 < next_sample() - 1e-9 / settings_.sampling) return false;
  ++index_;
  return true;
}

}  // namespace freeplay
