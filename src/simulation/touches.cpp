#include "simulation/touches.hpp"

namespace freeplay {
namespace {

/// |a − b|/|b|; 1 if b is 0 and a is not.
double share(double a, double b) {
  const double size = b != 0 ? std::abs(b) : std::abs(a);
  return size > 0 ? std::abs(a - b) / size : 0;
}

}  // namespace

double touch_off(const ContactEvent& found, const ContactEvent& reference, double interval) {
  if (found.kind != reference.kind) return INFINITY;
  const double time = share(found.t - reference.t + interval, interval),
               speed = share(found.v_n_minus, reference.v_n_minus);
  const double impulse = found.kind == EventKind::impact ? share(found.impulse_n, reference.impulse_n) : 0;
  return std::max({time, speed, impulse});
}

void OnsetComparison::add(const ContactEvent& found, const ContactEvent& reference) {
  if (reference.t - before_ > 1e-6 * reference.t) since_ = reference.t - before_;
  before_ = reference.t;
  const double time = share(found.t - reference.t + since_, since_),
               speed = share(found.v_n_minus, reference.v_n_minus);
  // The impulse of a lasting contact depends on its duration, so only impacts are compared.
  const bool impacts = found.kind == EventKind::impact && reference.kind == EventKind::impact;
  const double impulse = impacts ? share(found.impulse_n, reference.impulse_n) : 0;
  last_ = std::max({time, speed, impulse});
  sum_.time = std::max(sum_.time, time);
  sum_.speed = std::max(sum_.speed, speed);
  sum_.impulse = std::max(sum_.impulse, impulse);
  ++sum_.touches;
}

OnsetDifference onset_difference(const std::vector<ContactEvent>& found,
                                 const std::vector<ContactEvent>& reference) {
  OnsetComparison comparison;
  std::vector<std::size_t> next;  // index into `found`, for each contact
  for (const auto& b : reference) {
    next.resize(std::max(next.size(), static_cast<std::size_t>(b.contact) + 1));
    auto& i = next[b.contact];
    while (i < found.size() && found[i].contact != b.contact) ++i;
    if (i == found.size()) {
      auto cut = comparison.so_far();
      cut.missing = true;
      return cut;
    }
    comparison.add(found[i++], b);
  }
  return comparison.so_far();
}

}  // namespace freeplay
