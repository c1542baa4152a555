#include "formulations/automatic/handover.hpp"

namespace freeplay {

void HandoverTimes::take_over(double t, const std::string& why, double time_scale) {
  since_ = t;
  ++count_;
  // The last return did not last: wait longer before the next.
  wait_ = since_ - returned_ < wait_ && count_ > 1 ? std::min(2 * wait_, 1e3 * time_scale) : 0.1 * time_scale;
  const auto colon = why.find("s: ");
  const auto reason = colon == std::string::npos ? why : why.substr(colon + 3);
  constexpr std::size_t most = 400;  // characters of all reasons together
  if (reasons_.find(reason) == std::string::npos && reasons_.size() + reason.size() < most)
    reasons_ += (reasons_.empty() ? "" : "; ") + reason;
}

void HandoverTimes::give_back(double t) {
  returned_ = t;
  longest_ = std::max(longest_, returned_ - since_);
}

void StepShrinkage::begin(double t, long events) {
  steps_ = 0;
  from_ = t;
  events_ = events;
}

bool StepShrinkage::shrunk(double t, long events, bool crowded, double time_scale) {
  const double passed = t - from_;
  const bool many = events - events_ >= 100;
  const double usual = best_ > 0 ? std::min(best_, time_scale) : 1e-2 * time_scale;
  best_ = std::max(best_, passed);
  begin(t, events);
  return (many || crowded) && passed < 1e-2 * usual;
}

void SchemeCosts::end_events(const SchemeProgress& now) {
  events_time_ += now.t - from_.t;
  events_cost_ += now.cost - from_.cost;
  if (trial_) end_trial(now);
}

bool SchemeCosts::stepping_costs_more(const SchemeProgress& now) {
  const long cost = now.cost - from_.cost;
  if (cost < patience_) return false;
  stepping_pace_ = (now.t - from_.t) / static_cast<double>(cost);
  if (stepping_pace_ * static_cast<double>(events_cost_) < events_time_) return true;
  begin(now);
  return false;
}

void SchemeCosts::begin_trial() {
  trial_ = true;
  ++trials_;
}

bool SchemeCosts::trial_failed(const SchemeProgress& events) {
  if (!trial_ || events.cost - from_.cost < patience_ / 10) return false;
  if (!pays(events)) return true;
  end_trial(events);
  return false;
}

bool SchemeCosts::pays(const SchemeProgress& events) const {
  return events.t - from_.t > stepping_pace_ * static_cast<double>(events.cost - from_.cost);
}

void SchemeCosts::end_trial(const SchemeProgress& events) {
  const bool paid = pays(events);
  patience_ = paid ? std::max(least_patience, patience_ / 2) : 2 * patience_;
  won_ += paid;
  trial_ = false;
}

}  // namespace freeplay
