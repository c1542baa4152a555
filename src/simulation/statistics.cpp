#include "simulation/statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "values/diagnostic.hpp"

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

namespace {

using EnergyTerms = std::array<double, energy_terms.size()>;

EnergyTerms difference(const EnergyLedger& from, const EnergyLedger& to) {
  const auto stored = [](const EnergyLedger& l) { return l.kinetic + l.potential + l.elastic; };
  return {to.drive - from.drive,
          to.load - from.load,
          to.damping - from.damping,
          to.contact - from.contact,
          to.friction - from.friction,
          to.film - from.film,
          to.stabilisation - from.stabilisation,
          stored(to) - stored(from),
          to.closure() - from.closure()};
}

/// Linear interpolation between two ledgers.
EnergyLedger between(const EnergyLedger& from, const EnergyLedger& to, double share) {
  EnergyLedger l = to;
  for (const auto term :
       {&EnergyLedger::kinetic, &EnergyLedger::potential, &EnergyLedger::elastic, &EnergyLedger::drive,
        &EnergyLedger::load, &EnergyLedger::damping, &EnergyLedger::contact, &EnergyLedger::friction,
        &EnergyLedger::film, &EnergyLedger::stabilisation})
    l.*term = from.*term + share * (to.*term - from.*term);
  return l;
}

double standard_error(const std::vector<double>& x) {
  const auto n = static_cast<double>(x.size());
  double mean = 0, sum = 0;
  for (const double value : x) mean += value / n;
  for (const double value : x) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / (n * (n - 1)));
}

}  // namespace

void WindowStatistics::begin(const Layout& layout, const State&) {
  if (length_ > 0) return;  // a continued run
  const double turn = layout.crank_speed != 0 ? 2 * std::numbers::pi / std::abs(layout.crank_speed) : 0;
  length_ = turn > 0 ? turn : std::max((end_ - discard_) / 16, 1e-300);
  batches_.assign(most, Batch(layout.contacts.size()));
  since_.assign(layout.contacts.size(), std::nan(""));
}

void WindowStatistics::Part::add(const Part& other) {
  lasting_time += other.lasting_time;
  impact_time += other.impact_time;
  approach.add(other.approach);
}

/// Merges pairs of batches into batches of twice the length.
void WindowStatistics::join() {
  for (std::size_t i = 0; i < most / 2; ++i)
    for (std::size_t k = 0; k < batches_[i].size(); ++k) {
      auto sum = batches_[2 * i][k];
      sum.add(batches_[2 * i + 1][k]);
      batches_[i][k] = sum;
    }
  for (std::size_t i = most / 2; i < most; ++i) batches_[i].assign(since_.size(), {});
  std::size_t kept = 0;
  for (std::size_t i = 0; i < marks_.size(); i += 2) marks_[kept++] = marks_[i];
  marks_.resize(kept);
  length_ *= 2;
}

void WindowStatistics::fit(double t) {
  while (t >= start_of(most)) join();
}

void WindowStatistics::step(const Step& step) {
  fit(step.t1);
  const Mark now{step.t1, step.ledger()};
  if (std::isnan(before_.t)) {  // no work is done yet; only the sum of the stored energies matters
    before_.t = step.t0;
    before_.ledger.kinetic = before_.ledger.initial = now.ledger.initial;
  }
  while (now.t >= start_of(marks_.size())) {
    const double at = std::max(start_of(marks_.size()), before_.t);
    const double share = now.t > before_.t ? (at - before_.t) / (now.t - before_.t) : 1;
    marks_.push_back({at, between(before_.ledger, now.ledger, share)});
  }
  before_ = now;
}

void WindowStatistics::spread(double from, double to, int contact, double Part::*time,
                              std::vector<Batch>& batches) {
  from = std::max(from, discard_);
  if (!(to > from)) return;
  const auto batch_at = [&](double t) {
    return std::min(static_cast<std::size_t>((t - discard_) / length_), std::size_t{most - 1});
  };
  for (std::size_t i = batch_at(from); i <= batch_at(to); ++i) {
    const double share = std::min(to, start_of(i + 1)) - std::max(from, start_of(i));
    batches[i][contact].*time += std::max(0.0, share);
  }
}

void WindowStatistics::count(const ContactEvent& e, std::vector<Batch>& batches, std::vector<double>& since) {
  if (static_cast<std::size_t>(e.contact) >= since.size()) return;  // of a family
  switch (e.kind) {
    case EventKind::contact:
      since[e.contact] = e.t;
      return;
    case EventKind::separation:
      spread(since[e.contact], e.t, e.contact, &Part::lasting_time, batches);
      since[e.contact] = std::nan("");
      return;
    case EventKind::impact:
      spread(e.t, e.t + e.duration, e.contact, &Part::impact_time, batches);
      if (e.t < discard_) return;
      const auto i = static_cast<std::size_t>((e.t - discard_) / length_);
      batches[std::min(i, std::size_t{most - 1})][e.contact].approach.add(-e.v_n_minus);
      return;
  }
}

void WindowStatistics::end(const RunEnd& end) {
  fit(end.t);
  at_end_ = batches_;
  auto since = since_;
  for (const auto& e : end.held_back) count(e, at_end_, since);
  for (std::size_t k = 0; k < since.size(); ++k) {
    const int contact = static_cast<int>(k);
    spread(since[k], end.t, contact, &Part::lasting_time, at_end_);
    spread(end.undecided_since[k], end.t, contact, &Part::impact_time, at_end_);
  }
}

void WindowStatistics::into(Result& r) const {
  Window w{.from = discard_, .to = r.t_end, .batch = length_, .batches = 0, .energy = {}, .error = {}};
  if (!(w.to > w.from) || marks_.empty()) return;
  // A last batch that is short by rounding counts as complete. Its end needs no mark: the run's
  // final ledger is used.
  const double length = w.to - w.from;
  const auto n = std::min(static_cast<std::size_t>(length / length_ + 1e-6), marks_.size());
  w.energy = difference(marks_[0].ledger, r.ledger);
  if (n >= fewest) {
    w.batches = static_cast<int>(n);
    std::array<std::vector<double>, energy_terms.size()> power;
    for (std::size_t i = 0; i < n; ++i) {
      const auto& from = marks_[i];
      const Mark to = i + 1 < marks_.size() ? marks_[i + 1] : Mark{r.t_end, r.ledger};
      const auto done = difference(from.ledger, to.ledger);
      for (std::size_t j = 0; j < done.size(); ++j) power[j].push_back(done[j] / (to.t - from.t));
    }
    for (std::size_t j = 0; j < w.error.size(); ++j) w.error[j] = length * standard_error(power[j]);
  }
  r.window = w;
  if (w.batches == 0) return;
  // Rate of revolutions, or 1: impacts are counted over it, in 1/s.
  const double per = r.revolutions > 0 ? r.revolutions / r.observed : 1;
  for (std::size_t k = 0; k < std::min(since_.size(), r.contacts.size()); ++k) {
    auto& c = r.contacts[k];
    std::vector<double> flight, impact, lasting, impacts;
    for (std::size_t i = 0; i < n; ++i) {
      const auto& tally = at_end_[i][k];
      impact.push_back(tally.impact_time / length_);
      lasting.push_back(tally.lasting_time / length_);
      flight.push_back(1 - impact.back() - lasting.back());
      impacts.push_back(static_cast<double>(tally.approach.at_least(0.1 * c.fastest_approach)) /
                        (length_ * per));
    }
    c.flight_error = standard_error(flight);
    c.impact_error = standard_error(impact);
    c.lasting_error = standard_error(lasting);
    c.impacts_error = standard_error(impacts);
  }
}

}  // namespace freeplay
