#include "formulations/penalty/penalty_variation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/integrators/crossing.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

/// Least tolerance with which a step is repeated; rounding errors are below it.
constexpr double least_closure = 1e-11;
/// Distances from a kink of a contact force at which parts of a step end, over the step. Each part has its
/// stages on one side of the kink, since their error is a smaller share of a shorter part. In the last part,
/// around the kink, the weights of the stages give 0.54 to its first half: an error of 0.04 times its length.
constexpr double kink_shares[] = {3e-3, 9e-6, 2.7e-8};
/// Number of steps within which a gap is near its zero.
constexpr double near_steps = 30;
/// Parts of a step at most; a step that needs more is too stiff for an explicit method.
constexpr int most_parts = 1024;
/// Error of repeated parts against the run's own step, over its tolerance: the run has an error, too.
constexpr double agreement_with_step = 10;
/// The same against half as many parts, where the run's method has a greater error.
constexpr double agreement_with_half = 1;
/// Change of a gap by a nominal change of a parameter, over the scene's length, that is rounding.
constexpr double start_rounding = 1e-9;
/// Least part of a step on either side of a kink; the step is not divided nearer to its ends.
constexpr double least_kink_part = 1e-6;
/// Least rate of a gap near its zero, over the scene's speed; slower ones do not pass it within the steps.
constexpr double least_gap_rate = 1e-6;

}  // namespace

PenaltyVariation::PenaltyVariation(const PenaltyParts& run, const Scene& scene, const State& start,
                                   const std::vector<VariedKey>& keys, std::vector<Column> integrands,
                                   double length, double duration)
    : VariedColumns(
          std::make_unique<ExtendedPenalty>(run.steps->dynamics().twin(), run.speed_scale), keys,
          [&](ExtendedPenalty& probe, const VariedKey& key, std::size_t i) {
            return std::make_unique<ExtendedPenalty>(
                displaced_penalty(run.steps->dynamics(), *key.scenes[i], *key.systems[i], start),
                run.speed_scale, &probe);
          },
          std::move(integrands), length, duration),
      run_(*run.steps),
      norm_(run.norm),
      v0_floor_(run.v0_floor),
      after_(std::make_unique<ExtendedPenalty>(run_.dynamics().twin(), run.speed_scale)),
      impulses_(run_.dynamics().contacts().size()) {
  begin(scene, start.t, run.resumed);
}

void PenaltyVariation::trace(TracedEquations& traced, const State& near) {
  std::vector<PenaltyDynamics::DisplacedLaws> laws;
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    auto& displaced = laws.emplace_back();
    displaced.spacing = keys_[c].spacing;
    for (std::size_t i = 0; i < displaced.at.size(); ++i)
      if (displaced_[c][i]) displaced.at[i] = &displaced_[c][i]->dynamics();
  }
  probe_->dynamics().use_tangent(traced.of(probe_->system, keys_, near, SystemTangent::Use::penalty),
                                 std::move(laws));
}

/// The derivatives of the start: contacts that are closed there.
void PenaltyVariation::begin(const Scene& scene, double t, bool resumed) {
  const auto& d = run_.dynamics();
  const auto& system = d.system();
  floor_given_ = scene.penalty.v0_floor.has_value();
  if (std::ranges::any_of(d.contacts(), [](const auto& c) { return c.shear.has_value(); }))
    refuse("penalty.friction = \"mindlin\" has no derivatives: its friction depends on its history");
  if (scene.penalty.own) refuse("a contact law of a program has no derivatives");
  if (d.projects()) refuse("penalty.stabilisation = \"projection\" has no derivatives; use \"baumgarte\"");
  take_mode(d);
  const auto x = this->x();
  const Side still{Vector(x.size()), Vector(integrands_.size())};
  const int own = 2 * system.n() + system.states();
  const auto given = static_cast<std::size_t>(own);
  for (std::size_t c = 0; c < keys_.size(); ++c)
    for (std::size_t i = given; open(c) && i < keys_[c].start.size(); ++i)
      S_[c][static_cast<std::size_t>(d.size()) + i - given] = keys_[c].start[i];
  if (resumed && d.bristles() > 0 &&
      std::ranges::any_of(d.contacts(), [](const auto& c) { return c.closed; }))
    refuse("bristles of closed contacts have no derivatives at the start of a continued run");
  for (int k = 0; !resumed && k < system.contacts(); ++k) {
    if (!d.contacts()[k].closed) continue;
    const double gap = probe_->row(k, x, t).gap;
    if (std::abs(gap) <= 4 * gap_rounding(system, k, x.data())) {
      const Function value = [k](ExtendedPenalty& f, const Vector& y, double at) {
        return Vector{f.row(k, y, at).gap};
      };
      for (std::size_t c = 0; c < keys_.size(); ++c)
        if (open(c) &&
            std::abs(total(c, value, x, t, S_[c], 0, probe_->speed_scale())[0]) * keys_[c].scale() >
                start_rounding * length_)
          refuse(c, fmt::format("t = {:.9g} s: contact {} closes at the start, so that {} has only a "
                                "one-sided derivative",
                                t, system.contact_facts(k).name, keys_[c].name));
    }
    begin_contact(k, event_at(x, t, still, still));
  }
  // The work done on contacts that are compressed at the start.
  const Function stored = [](ExtendedPenalty& f, const Vector& y, double at) {
    return Vector{f.stored_energy(y, at)};
  };
  const auto work =
      static_cast<std::size_t>(d.integral_offset()) + static_cast<std::size_t>(PenaltyDynamics::contact_work);
  for (std::size_t c = 0; c < keys_.size(); ++c)
    if (open(c)) S_[c][work] = total(c, stored, x, t, S_[c], 0, curved_speed(*probe_, x))[0];
}

PenaltyVariation::Vector PenaltyVariation::with_retained(const PenaltyDynamics& d) const {
  auto x = run_.x();
  for (const auto& c : d.contacts()) x.insert(x.end(), {c.v0, c.mass});
  return x;
}

void PenaltyVariation::begin_step() {
  const auto& d = run_.dynamics();
  take_mode(d);
  retained_.clear();
  for (const auto& c : d.contacts()) retained_.insert(retained_.end(), {c.v0, c.mass});
}

void PenaltyVariation::end_step() {
  const double t_old = run_.t_old(), h = run_.t() - t_old;
  const bool needed = !idle();
  if (h > 0 && needed) {
    take_knot(probe_->system, t_old, run_.dynamics().knot);
    auto x = run_.x_old();
    x.insert(x.end(), retained_.begin(), retained_.end());
    const int count = part_count(x, t_old, h, run_.x());
    if (count > most_parts)
      refuse(
          fmt::format("t = {:.9g} s: the motion is too stiff for the explicit method of derivatives", t_old));
    const int used = std::min(count, most_parts);
    double done = 0;
    if (const auto clamp = clamp_within(x, t_old, h, run_.x())) {
      Vector ends;
      for (const double share : kink_shares)
        for (const double side : {-1, 1}) ends.push_back(*clamp + side * share * h);
      std::ranges::sort(ends);
      for (const double to : ends)
        if (to > done && to < h) {
          advance(x, t_old + done, to - done, used);
          done = to;
        }
    }
    advance(x, t_old + done, h - done, used);
  }
  cross_events();
}

/// The time from t at which a contact force reaches or leaves its clamp at zero, a kink of f, in a step from
/// x to `end`.
std::optional<double> PenaltyVariation::clamp_within(const Vector& x, double t, double h, const Vector& end) {
  auto last = end;
  last.resize(x.size());
  std::copy(x.begin() + static_cast<long>(end.size()), x.end(), last.begin() + static_cast<long>(end.size()));
  for (int k = 0; k < probe_->system.contacts(); ++k) {
    const auto& c = probe_->contacts()[k];
    if (!c.closed || !c.law.dissipates()) continue;
    const double before = probe_->unclamped_force(k, x, t), after = probe_->unclamped_force(k, last, t + h);
    if (before == 0 || after == 0 || (before < 0) == (after < 0)) continue;
    const double s = bracketed_root(
        [&](double length) { return probe_->unclamped_force(k, flow(x, t, length), t + length); }, 0.0, h,
        before, after);
    if (s > least_kink_part * h && s < (1 - least_kink_part) * h) return s;
  }
  return {};
}

/// Advances x and S in equal parts.
void PenaltyVariation::advance(Vector& x, double t, double h, int count) {
  const bool shifted = choose_shifts(x, t, h);
  if (shifted) shift(x, t, 1);
  for (int i = 0; i < count; ++i) {
    const double length = h / count;
    x = advance_watched(t + i * length, x, length);
  }
  if (shifted) shift(x, t + h, -1);
}

/// dt of each column for the next step: that of the gap nearest to its zero, if it is near.
bool PenaltyVariation::choose_shifts(const Vector& x, double t, double h) {
  int nearest = -1;
  double least = near_steps * h;
  for (int k = 0; k < probe_->system.contacts(); ++k) {
    if (!probe_->contacts()[k].closed) continue;
    const double away = std::abs(probe_->row(k, x, t).gap), rate = std::abs(probe_->gap_rate(k, x, t));
    if (rate > least_gap_rate * probe_->speed_scale() && away < least * rate) {
      least = away / rate;
      nearest = k;
    }
  }
  std::ranges::fill(shifts_, 0.0);
  if (nearest < 0) return false;
  const auto normal = probe_->row(nearest, x, t).normal;
  const double rate = probe_->gap_rate(nearest, x, t);
  const Function gap = [nearest](ExtendedPenalty& f, const Vector& y, double at) {
    return Vector{f.row(nearest, y, at).gap};
  };
  const auto centre = gap(*probe_, x, t);
  for (std::size_t c = 0; c < keys_.size(); ++c)
    if (open(c)) shifts_[c] = -(normal.dot(S_[c].data()) + across(c, gap, centre, x, t).slope[0]) / rate;
  return true;
}

void PenaltyVariation::shift(const Vector& x, double t, double sign) {
  probe_->touch(true);
  const auto here = side(*probe_, x, t);
  probe_->touch(false);
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c)) continue;
    add_multiple(S_[c], sign * shifts_[c], here.f);
    add_multiple(integral_rates_[c], sign * shifts_[c], here.integrands);
    if (peaks_.any()) peaks_.shift(c, sign * shifts_[c], here.f);
  }
  if (sign < 0) std::ranges::fill(shifts_, 0.0);
}

/// The number of equal parts, a power of two, in which Dormand and Prince's stages repeat the step to
/// `end`, or agree with themselves where the run's method has a greater error.
int PenaltyVariation::part_count(const Vector& x, double t, double h, const Vector& end) {
  Vector last;
  const double tolerance = std::max(norm_.tolerance, least_closure);
  const auto error = [&](const Vector& a, const Vector& b) {
    double most = 0;
    for (std::size_t i = 0; i < norm_.absolute.size(); ++i) {
      const double e =
          std::abs(a[i] - b[i]) / (tolerance * (norm_.absolute[i] + norm_.relative[i] * std::abs(b[i])));
      most = e <= most ? most : e;  // keeps a NaN
    }
    return most;
  };
  for (int count = 1; count <= most_parts; count *= 2) {
    auto y = x;
    const double length = h / count;
    for (int i = 0; i < count; ++i) y = flow(y, t + i * length, length);
    if (error(y, end) <= agreement_with_step || (!last.empty() && error(y, last) <= agreement_with_half))
      return count;
    last = std::move(y);
  }
  return 2 * most_parts;
}

}  // namespace freeplay
