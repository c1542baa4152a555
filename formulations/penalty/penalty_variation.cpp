#include "formulations/penalty/penalty_variation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/integrators/crossing.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

/// Share of a contact's measure up to which a contact counts as grazing.
constexpr double least_approach = 1e-6;
/// Least tolerance with which a step is repeated; rounding errors are below it.
constexpr double least_closure = 1e-11;
/// Half length of the part of a step around a kink of a contact force, over the step.
constexpr double kink_share = 2e-3;
/// Number of steps within which a gap is near its zero.
constexpr double near_steps = 30;
/// Parts of a step at most; a step that needs more is too stiff for an explicit method.
constexpr int most_parts = 1024;

bool same_pieces(const System& system, const Phases& a, const Phases& b) {
  for (int k = 0; k < system.phases(); ++k)
    if (a.pieces()[k].low != b.pieces()[k].low || a.pieces()[k].high != b.pieces()[k].high) return false;
  return true;
}

std::string contact_name(const System& system, int k) { return system.contact_facts(k).name; }

}  // namespace

PenaltyVariation::Twins PenaltyVariation::make_twins(const PenaltyParts& run, const State& start,
                                                     const std::vector<VariedKey>& keys) {
  const auto& d = run.steps->dynamics();
  Twins twins{std::make_unique<ExtendedPenalty>(d.twin(), run.speed_scale), {}};
  for (const auto& key : keys) {
    auto& displaced = twins.displaced.emplace_back();
    for (std::size_t i = 0; i < displaced.size(); ++i)
      if (key.systems[i])
        displaced[i] = std::make_unique<ExtendedPenalty>(
            displaced_penalty(d, *key.scenes[i], *key.systems[i], start), run.speed_scale, twins.probe.get());
  }
  return twins;
}

PenaltyVariation::PenaltyVariation(const PenaltyParts& run, const Scene& scene, const State& start,
                                   const std::vector<VariedKey>& keys, std::vector<Column> integrands,
                                   double length, double duration)
    : PenaltyVariation(make_twins(run, start, keys), run, keys, std::move(integrands), length, duration) {
  begin(scene, start.t);
}

PenaltyVariation::PenaltyVariation(Twins twins, const PenaltyParts& run, const std::vector<VariedKey>& keys,
                                   std::vector<Column> integrands, double length, double duration)
    : VariedColumns(std::move(twins.probe), keys, std::move(twins.displaced), std::move(integrands), length,
                    duration),
      run_(*run.steps),
      norm_(run.norm),
      v0_floor_(run.v0_floor),
      after_(std::make_unique<ExtendedPenalty>(run_.dynamics().twin(), run.speed_scale)),
      impulses_(run_.dynamics().contacts().size()) {
  strict_integrands_ = false;
}

/// The derivatives of the start: contacts that are closed there.
void PenaltyVariation::begin(const Scene& scene, double t) {
  const auto& d = run_.dynamics();
  const auto& system = d.system();
  floor_given_ = scene.penalty.v0_floor.has_value();
  if (std::ranges::any_of(d.contacts(), [](const auto& c) { return c.shear.has_value(); }))
    refuse("penalty.friction = \"mindlin\" has no derivatives: its friction depends on its history");
  if (scene.penalty.own) refuse("a contact law of a program has no derivatives");
  if (d.projects()) refuse("penalty.stabilisation = \"projection\" has no derivatives; use \"baumgarte\"");
  if (system.limiters() > 0)
    refuse("controllers with a limit have no derivatives in the penalty formulation");
  take_mode(d);
  const auto x = this->x();
  const Side still{Vector(x.size()), Vector(integrands_.size())};
  const Vector dt(keys_.size());
  for (int k = 0; k < system.contacts(); ++k) {
    if (!d.contacts()[k].closed) continue;
    const double gap = probe_->row(k, x, t).gap;
    if (std::abs(gap) <= 4 * gap_rounding(system, k, x.data())) {
      const Function value = [k](ExtendedPenalty& f, const Vector& y, double at) {
        return Vector{f.row(k, y, at).gap};
      };
      for (std::size_t c = 0; c < keys_.size(); ++c)
        if (open(c) &&
            std::abs(total(c, value, x, t, S_[c], 0, probe_->speed_scale())[0]) * keys_[c].scale() >
                1e-9 * length_)
          refuse(c, fmt::format("t = {:.9g} s: contact {} closes at the start, so that {} has only a "
                                "one-sided derivative",
                                t, contact_name(system, k), keys_[c].name));
    }
    begin_contact(k, x, t, still, dt);
  }
  // The work done on contacts that are compressed at the start.
  const Function stored = [](ExtendedPenalty& f, const Vector& y, double at) {
    return Vector{f.stored_energy(y, at)};
  };
  const auto work = static_cast<std::size_t>(d.integral_offset() + PenaltyDynamics::contact_work);
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
  const bool needed = !all_closed() || !integrands_.empty();
  if (h > 0 && needed) {
    take_knot(probe_->system, t_old, run_.dynamics().knot);
    auto x = run_.x_old();
    x.insert(x.end(), retained_.begin(), retained_.end());
    const int count = parts(x, t_old, h, run_.x());
    if (count > most_parts)
      refuse(
          fmt::format("t = {:.9g} s: the motion is too stiff for the explicit method of derivatives", t_old));
    const int used = std::min(count, most_parts);
    double done = 0;
    // A short part around a kink, with stages on both of its sides.
    if (const auto clamp = clamp_within(x, t_old, h, run_.x()))
      for (const double to : {*clamp - kink_share * h, *clamp + kink_share * h})
        if (to > done && to < h) {
          advance(x, t_old + done, to - done, used);
          done = to;
        }
    advance(x, t_old + done, h - done, used);
  }
  pass();
}

/// Dormand and Prince's stages of a step of x.
void PenaltyVariation::stages(const Vector& x, double t, double h, std::array<Vector, 6>& f) {
  Vector stage;
  for (std::size_t s = 0; s < f.size(); ++s) {
    stage = x;
    for (std::size_t j = 0; j < s; ++j) add_multiple(stage, h * DormandPrince::a[s][j], f[j]);
    f[s].resize(x.size());
    (*probe_)(stage, f[s], t + DormandPrince::c[s] * h);
  }
  evaluations_ += 6;
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
        [&](double length) {
          stages(x, t, length, trial_);
          auto y = x;
          for (std::size_t i = 0; i < trial_.size(); ++i)
            add_multiple(y, length * DormandPrince::b[i], trial_[i]);
          return probe_->unclamped_force(k, y, t + length);
        },
        0.0, h, before, after);
    if (s > 1e-6 * h && s < (1 - 1e-6) * h) return s;
  }
  return {};
}

/// Advances x and S in equal parts.
void PenaltyVariation::advance(Vector& x, double t, double h, int count) {
  const bool shifted = choose_shifts(x, t, h);
  if (shifted) shift(x, t, 1);
  for (int i = 0; i < count; ++i) {
    const double length = h / count;
    advance_stages(t + i * length, x, length);
    for (std::size_t s = 0; s < f_.size(); ++s) add_multiple(x, length * DormandPrince::b[s], f_[s]);
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
    if (rate > 1e-6 * probe_->speed_scale() && away < least * rate) {
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
  }
  if (sign < 0) std::ranges::fill(shifts_, 0.0);
}

/// The number of equal parts, a power of two, in which Dormand and Prince's stages repeat the step to
/// `end`, or agree with themselves where the run's method has a greater error.
int PenaltyVariation::parts(const Vector& x, double t, double h, const Vector& end) {
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
    for (int i = 0; i < count; ++i) {
      stages(y, t + i * length, length, trial_);
      for (std::size_t s = 0; s < trial_.size(); ++s)
        add_multiple(y, length * DormandPrince::b[s], trial_[s]);
    }
    if (error(y, end) <= 10 || (!last.empty() && error(y, last) <= 1)) return count;
    last = std::move(y);
  }
  return 2 * most_parts;
}

/// dt of each column for a root of the function.
PenaltyVariation::Vector PenaltyVariation::event_times(const Function& value, const Vector& x, double t,
                                                       const Vector& f) {
  const auto centre = value(*probe_, x, t);
  const double speed = curved_speed(*probe_, x);
  const double rate = along(*probe_, value, centre, x, t, f, 1, speed).slope[0];
  Vector dt(keys_.size());
  for (std::size_t c = 0; c < keys_.size(); ++c)
    if (open(c))
      dt[c] = -(along(*probe_, value, centre, x, t, S_[c], 0, speed).slope[0] +
                across(c, value, centre, x, t).slope[0]) /
              rate;
  return dt;
}

void PenaltyVariation::pass() {
  const auto& d = run_.dynamics();
  const double t = run_.t();
  struct Changed {
    int contact;
    bool gap;
  };
  std::vector<Changed> changes;
  for (int k = 0; k < d.system().contacts(); ++k) {
    const auto &was = probe_->contacts()[k], &now = d.contacts()[k];
    if (was.closed != now.closed)
      changes.push_back({k, true});
    else if (was.closed && was.in_impact != now.in_impact)
      changes.push_back({k, false});
  }
  const bool same = same_pieces(d.system(), probe_->phases(), d.phases);
  if (changes.empty() && same) return;
  auto x = run_.x();
  x.insert(x.end(), retained_.begin(), retained_.end());
  after_->take_mode(d);
  probe_->touch(true);
  after_->touch(true);
  const auto before = side(*probe_, x, t), after = side(*after_, with_retained(d), t);
  const int n = d.system().n();
  double change = 0, scale = 0;
  for (int i = n; i < 2 * n; ++i) {
    change = std::max(change, std::abs(after.f[i] - before.f[i]));
    scale = std::max({scale, std::abs(after.f[i]), std::abs(before.f[i])});
  }
  const bool jumps = !(change <= 1e-7 * scale);
  if (jumps && !same)
    refuse(
        fmt::format("t = {:.9g} s: a force of an element jumps there; derivatives across such jumps are not "
                    "available",
                    t));
  if (jumps && changes.size() > 1)
    refuse(fmt::format(
        "t = {:.9g} s: contacts {} and {} change at the same time, and a contact force jumps; "
        "the motion there depends on their order",
        t, contact_name(d.system(), changes[0].contact), contact_name(d.system(), changes[1].contact)));
  for (const auto& [k, gap] : changes) {
    if (!gap) {
      change_impact(k, x, t, before, after, jumps);
      continue;
    }
    const bool onset = d.contacts()[k].closed;
    const auto& row = probe_->row(k, x, t);
    const auto normal = row.normal;
    const Function value = [k = k](ExtendedPenalty& f, const Vector& y, double at) {
      return Vector{f.row(k, y, at).gap};
    };
    const Vector centre{row.gap};
    const double rate = normal.dot(x.data() + n), away = probe_->gap_acceleration(k, x, before.f, t);
    const auto& facts = d.system().contact_facts(k);
    const double measure = facts.measure() > 0 ? facts.measure() : length_;
    if (onset && away > 0 && rate * rate < 2 * away * least_approach * measure)
      refuse(
          fmt::format("t = {:.9g} s: contact {} grazes (approach {:.2g} m/s); grazing contacts have no "
                      "derivative",
                      t, facts.name, -rate));
    const bool steady = std::abs(rate) > 1e-12 * probe_->speed_scale();
    if (!steady && jumps)
      refuse(
          fmt::format("t = {:.9g} s: contact {} opens or closes without relative speed, and its force jumps",
                      t, facts.name));
    Vector dt(keys_.size());
    for (std::size_t c = 0; c < keys_.size(); ++c)
      if (open(c) && steady)
        dt[c] = -(normal.dot(S_[c].data()) + across(c, value, centre, x, t).slope[0]) / rate;
    if (onset)
      begin_contact(k, x, t, before, dt);
    else
      end_contact(k, x, before, dt);
    if (onset && !steady) {
      auto& last = onsets_.back();
      last.dt = last.drate = Vector(keys_.size(), NAN);
      for (auto& reason : last.reasons)
        if (reason.empty())
          reason = fmt::format("t = {:.9g} s: contact {} closes without approach", t, facts.name);
    }
    if (jumps) jump(before, after, dt);
    if (d.bristles() == 0) continue;
    const auto bristle = static_cast<std::size_t>(d.bristle_offset() + k);
    if (onset && !steady && after.f[bristle] != 0)
      refuse(fmt::format(
          "t = {:.9g} s: contact {} closes without approach, so that its bristle has no derivative", t,
          facts.name));
    for (std::size_t c = 0; c < keys_.size(); ++c)
      if (open(c)) S_[c][bristle] = onset ? -after.f[bristle] * dt[c] : 0;
  }
  probe_->touch(false);
  after_->touch(false);
}

/// S across an event where f jumps.
void PenaltyVariation::jump(const Side& before, const Side& after, const Vector& dt) {
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c)) continue;
    for (std::size_t i = 0; i < size_; ++i) S_[c][i] += dt[c] * (before.f[i] - after.f[i]);
    for (std::size_t i = 0; i < integrands_.size(); ++i)
      integral_rates_[c][i] += dt[c] * (before.integrands[i] - after.integrands[i]);
  }
}

/// Derivatives of v₀, which is the value `speed` of a function or else the floor, and of a new mass.
void PenaltyVariation::retain(int k, const Vector& x, double t, const Vector& f, const Vector& dt,
                              double speed, const Function& speed_of, bool new_mass) {
  const auto& d = run_.dynamics();
  const auto slot = static_cast<std::size_t>(d.size() + 2 * k);
  const bool floored = !(speed > v0_floor_);
  if (!(d.contacts()[k].law.chi > 0)) return;  // the force does not depend on them
  if (floored && !floor_given_)
    refuse(fmt::format(
        "t = {:.9g} s: contact {} begins below the least v₀, which depends on the scene's speeds; "
        "set penalty.v0_floor for derivatives",
        t, contact_name(d.system(), k)));
  const Function mass_of = [k](ExtendedPenalty& g, const Vector& y, double at) {
    return Vector{g.effective_mass(k, y, at)};
  };
  const double scale = std::max(std::abs(speed), v0_floor_);
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c)) continue;
    auto dx = S_[c];
    add_multiple(dx, dt[c], f);
    const double change = floored ? 0 : total(c, speed_of, x, t, dx, dt[c], scale)[0];
    double mass = S_[c][slot + 1];
    if (new_mass) mass = total(c, mass_of, x, t, dx, dt[c], scale)[0];
    if (!open(c)) continue;
    S_[c][slot] = change;
    S_[c][slot + 1] = mass;
  }
}

void PenaltyVariation::begin_contact(int k, const Vector& x, double t, const Side& before, const Vector& dt) {
  const auto& d = run_.dynamics();
  const auto slot = static_cast<std::size_t>(d.impulse_offset() + 2 * k);
  const double rate = probe_->gap_rate(k, x, t);
  const Function rate_of = [k](ExtendedPenalty& f, const Vector& y, double at) {
    return Vector{f.gap_rate(k, y, at)};
  };
  const Function approach_of = [k](ExtendedPenalty& f, const Vector& y, double at) {
    return Vector{-f.gap_rate(k, y, at)};
  };
  Onset onset{k, true, t, rate, NAN, {}, {}, {}, {}};
  Impulse impulse{onsets_.size(), x[slot], {}};
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    onset.drate.push_back(NAN);
    if (open(c)) {
      auto dx = S_[c];
      add_multiple(dx, dt[c], before.f);
      onset.drate[c] = total(c, rate_of, x, t, dx, dt[c], std::max(std::abs(rate), v0_floor_))[0];
    }
    impulse.slope.push_back(S_[c][slot] + dt[c] * before.f[slot]);
  }
  retain(k, x, t, before.f, dt, -rate, approach_of, true);
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    onset.dt.push_back(open(c) ? dt[c] : NAN);
    onset.dimpulse.push_back(NAN);
    if (!open(c)) onset.drate[c] = NAN;
    onset.reasons.push_back(reasons_[c]);
  }
  onsets_.push_back(std::move(onset));
  impulses_[static_cast<std::size_t>(k)] = std::move(impulse);
}

void PenaltyVariation::end_contact(int k, const Vector& x, const Side& before, const Vector& dt) {
  const auto& d = run_.dynamics();
  const auto slot = static_cast<std::size_t>(d.impulse_offset() + 2 * k),
             retained = static_cast<std::size_t>(d.size() + 2 * k);
  auto& impulse = impulses_[static_cast<std::size_t>(k)];
  if (impulse) {
    auto& onset = onsets_[impulse->onset];
    onset.lasting = false;
    onset.impulse = x[slot] - impulse->begin;
    for (std::size_t c = 0; c < keys_.size(); ++c) {
      if (open(c)) onset.dimpulse[c] = S_[c][slot] + dt[c] * before.f[slot] - impulse->slope[c];
    }
    impulse.reset();
  }
  for (std::size_t c = 0; c < keys_.size(); ++c) S_[c][retained] = S_[c][retained + 1] = 0;
}

/// An impact on a closed contact begins or ends.
void PenaltyVariation::change_impact(int k, const Vector& x, double t, const Side& before, const Side& after,
                                     bool jumps) {
  const auto& d = run_.dynamics();
  const bool begins = d.contacts()[k].in_impact;
  const double rate = probe_->gap_rate(k, x, t), w = probe_->touch_speed(k, x, t);
  const Function touch_speed_of = [k](ExtendedPenalty& f, const Vector& y, double at) {
    return Vector{f.touch_speed(k, y, at)};
  };
  Vector dt(keys_.size());
  if (begins) {
    // It begins where the contact is compressed again, or where w exceeds v₀. The mass is that of this
    // instant. At its end, w does not change with time.
    const auto slot = static_cast<std::size_t>(d.size() + 2 * k);
    const bool turns = std::abs(rate) <= 1e-6 * w;
    if (!turns && std::abs(w - x[slot]) > 1e-6 * w)
      refuse(fmt::format("t = {:.9g} s: an impact on contact {} begins between steps", t,
                         contact_name(d.system(), k)));
    const Function value = [k, slot, turns](ExtendedPenalty& f, const Vector& y, double at) {
      return Vector{turns ? f.gap_rate(k, y, at) : f.touch_speed(k, y, at) - y[slot]};
    };
    dt = event_times(value, x, t, before.f);
  } else if (jumps) {
    refuse(fmt::format("t = {:.9g} s: the damping of contact {} jumps during contact", t,
                       contact_name(d.system(), k)));
  }
  retain(k, x, t, before.f, dt, w, touch_speed_of, begins);
  if (jumps) jump(before, after, dt);
}

}  // namespace freeplay
