#include "simulation/statistics.hpp"
#include "values/diagnostic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace freeplay {

int LogHistogram::bin(double x) {
  const int b = static_cast<int>(std::floor((std::log10(x) - lowest) * per_decade));
  return std::clamp(b, 0, per_decade * decades - 1);
}

void LogHistogram::add(double x) {
  if (!(x > 0)) return;
  ++count_[bin(x)];
  ++total_;
  greatest_ = std::max(greatest_, x);
}

void FastOnes::add(double x, long count) {
  greatest_ = std::max(greatest_, x);
  if (!(x > 0) || x < 0.1 * greatest_) return;
  if (kept_.size() == most) {
    std::erase_if(kept_, [this](const Kept& k) { return k.value < 0.1 * greatest_; });
    std::ranges::sort(kept_, {}, &Kept::value);
    if (kept_.size() > most / 2) {
      for (std::size_t i = 0; i + 1 < kept_.size(); i += 2) {
        const auto &a = kept_[i], &b = kept_[i + 1];
        const auto both = static_cast<double>(a.count + b.count);
        kept_[i / 2] = {a.value + (b.value - a.value) * static_cast<double>(b.count) / both,
                        a.count + b.count};
      }
      if (kept_.size() % 2 == 1) kept_[kept_.size() / 2] = kept_.back();
      kept_.resize((kept_.size() + 1) / 2);
    }
  }
  reserve();
  kept_.push_back({x, count});
}

long FastOnes::at_least(double x) const {
  long count = 0;
  for (const auto& k : kept_) count += k.value >= x ? k.count : 0;
  return count;
}

void FastOnes::add(const FastOnes& other) {
  greatest_ = std::max(greatest_, other.greatest_);
  for (const auto& k : other.kept_) add(k.value, k.count);
}

double LogHistogram::quantile(double p) const {
  long below = 0;
  for (int b = 0; b < per_decade * decades; ++b) {
    below += count_[b];
    if (below > 0 && static_cast<double>(below) >= p * static_cast<double>(total_))
      return std::pow(10, lowest + (b + 0.5) / per_decade);
  }
  return 0;
}

void LogHistogram::add(const LogHistogram& other) {
  for (std::size_t b = 0; b < count_.size(); ++b) count_[b] += other.count_[b];
  total_ += other.total_;
  greatest_ = std::max(greatest_, other.greatest_);
}

void ContactStatistics::begin(const Layout& layout, const State&) {
  contacts_ = layout.contacts.size();
  const auto all = contacts_ + layout.families.size();
  if (tallies_.size() == all) return;  // a continued run
  tallies_.assign(all, {});
  for (auto& tally : tallies_) tally.fast.reserve();
  since_.assign(all, std::nan(""));
  left_ = since_;
}

void ContactStatistics::count(const ContactEvent& e, std::vector<ContactTally>& tallies,
                              std::vector<double>& since, std::vector<double>& left) const {
  auto& tally = tallies[e.contact];
  // Of a family: number and strength of impacts, no durations.
  if (static_cast<std::size_t>(e.contact) >= contacts_) {
    if (e.kind != EventKind::impact || e.t < discard_) return;
    tally.approach.add(-e.v_n_minus);
    tally.fast.add(-e.v_n_minus);
    tally.impulse.add(e.impulse_n);
    return;
  }
  switch (e.kind) {
    case EventKind::contact:
      since[e.contact] = e.t;
      return;
    case EventKind::separation:
      tally.lasting_time += std::max(0.0, e.t - std::max(discard_, since[e.contact]));
      since[e.contact] = std::nan("");
      left[e.contact] = e.t;
      return;
    case EventKind::impact:
      if (const double flight = e.t - left[e.contact]; flight > 0 && e.t >= discard_) {
        tally.in_impact += e.impulse_n * e.duration;
        tally.flown += e.impulse_n * flight;
      }
      left[e.contact] = e.t + e.duration;
      tally.impact_time += std::max(0.0, e.t + e.duration - std::max(discard_, e.t));
      if (e.t < discard_) return;
      tally.approach.add(-e.v_n_minus);
      tally.fast.add(-e.v_n_minus);
      tally.impulse.add(e.impulse_n);
      return;
  }
}

void ContactStatistics::end(const RunEnd& end) {
  at_end_ = tallies_;
  auto since = since_, left = left_;
  for (const auto& e : end.held_back) count(e, at_end_, since, left);
  for (std::size_t k = 0; k < std::min(contacts_, at_end_.size()); ++k) {
    const auto so_far = [&](double from) { return std::max(0.0, end.t - std::max(discard_, from)); };
    at_end_[k].time = std::max(0.0, end.t - discard_);
    if (!std::isnan(since[k])) at_end_[k].lasting_time += so_far(since[k]);
    if (!std::isnan(end.undecided_since[k])) at_end_[k].impact_time += so_far(end.undecided_since[k]);
  }
}

void ContactStatistics::into(Result& result) const {
  const double per = result.revolutions > 0 ? result.revolutions : result.observed;
  for (std::size_t k = 0; k < at_end_.size(); ++k) {
    const auto& tally = at_end_[k];
    auto& c = result.contacts[k];
    if (tally.time > 0) {
      c.impact_fraction = tally.impact_time / tally.time;
      c.lasting_fraction = tally.lasting_time / tally.time;
      c.flight_fraction = 1 - c.impact_fraction - c.lasting_fraction;
    }
    c.impacts = tally.approach.total();
    c.counted_impacts = tally.fast.at_least(0.1 * tally.fast.greatest());
    c.impacts_per_revolution = per > 0 ? static_cast<double>(c.counted_impacts) / per : 0;
    c.fastest_approach = tally.approach.greatest();
    c.median_approach = tally.approach.quantile(0.5);
    c.median_impulse = tally.impulse.quantile(0.5);
    c.greatest_impulse = tally.impulse.greatest();
    if (tally.flown > 0) c.impact_over_flight = tally.in_impact / tally.flown;
    // Without a clearance, the flights limit the duration of an impact: beyond that it is not an
    // impact.
    if (!c.has_clearance() && c.impact_over_flight > 0.5)
      result.notes.push_back(diagnostic<Diagnostic::soft_contact>(c.name, c.impact_over_flight));
  }
}

}  // namespace freeplay
