#include "simulation/touches.hpp"

namespace freeplay {
namespace {

/// |a − b|/|b|; 1 if b is 0 and a is not.
double share(double a, double b) {
  const double size = b != 0 ? std::abs(b) : std::abs(a);
  return size > 0 ? std::abs(a - b) / size : 0;
}

/// The differences of one onset. The impulse of a lasting contact depends on its duration, so only those
/// of impacts are compared.
OnsetDifference one(const ContactEvent& found, const ContactEvent& reference, double interval) {
  const bool impacts = found.kind == EventKind::impact && reference.kind == EventKind::impact;
  return {share(found.t - reference.t + interval, interval), share(found.v_n_minus, reference.v_n_minus),
          impacts ? share(found.impulse_n, reference.impulse_n) : 0};
}

}  // namespace

double event_difference(const ContactEvent& found, const ContactEvent& reference, double interval) {
  return found.kind == reference.kind ? one(found, reference, interval).greatest() : INFINITY;
}

OnsetDifference onset_difference(const std::vector<ContactEvent>& found,
                                 const std::vector<ContactEvent>& reference) {
  OnsetDifference sum;
  double before = 0, since = 0;   // s, time of the last onset, and the interval before it
  std::vector<std::size_t> next;  // index into `found`, for each contact
  for (const auto& b : reference) {
    next.resize(std::max(next.size(), static_cast<std::size_t>(b.contact) + 1));
    auto& i = next[b.contact];
    while (i < found.size() && found[i].contact != b.contact) ++i;
    if (i == found.size()) {
      sum.missing = true;
      return sum;
    }
    if (b.t - before > 1e-6 * b.t) since = b.t - before;
    before = b.t;
    const auto now = one(found[i++], b, since);
    sum.time = std::max(sum.time, now.time);
    sum.speed = std::max(sum.speed, now.speed);
    sum.impulse = std::max(sum.impulse, now.impulse);
    ++sum.touches;
  }
  return sum;
}

}  // namespace freeplay
