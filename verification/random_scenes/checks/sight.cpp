#include "verification/random_scenes/checks/checks.hpp"

#include <atomic>

#include "dynamics/system.hpp"
#include "facade/assess.hpp"
#include "simulation/clock.hpp"
#include "simulation/statistics.hpp"
#include "simulation/touches.hpp"
#include "verification/claims/force_balance.hpp"
#include "verification/random_scenes/transform.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::random_scenes {
namespace {

/// Observes each step, and requests the end of the run when enough is seen or the time limit is
/// reached.
class Onlooker final : public Observer {
 public:
  Onlooker(Sight& sight, const LookRequest& request, bool ends_only)
      : sight_(sight), request_(request), ends_only_(ends_only), began_(thread_seconds()) {}
  StopToken token() const { return StopToken(done_); }

  void begin(const Layout& layout, const State& state) override {
    sight_.start = state;
    sight_.contacts = layout.contacts;
    for (const auto& place : layout.start) sight_.start_gap.push_back(place.gap);
    sight_.depth.assign(layout.contacts.size(), 0);
    places_.resize(layout.contacts.size());
    q_ = state.q;
    v_ = state.v;
  }
  void event(const Event& e) override {
    if (is_onset(e) && ++touches_ >= request_.most_touches) done_ = true;
  }
  /// Contacts not yet classified as impacts, and later contacts waiting for them.
  void end(const RunEnd& end) override {
    for (const auto& e : end.held_back)
      if (is_onset(e))
        open.push_back({sight_.contacts[static_cast<std::size_t>(e.contact)], e.t, -e.v_n_minus, e.duration,
                        e.kind == EventKind::impact});
    for (std::size_t k = 0; k < end.undecided_since.size(); ++k)
      if (end.undecided_since[k] > 0)
        open.push_back({sight_.contacts[k], end.undecided_since[k], NAN, 0, false});
  }
  std::vector<ContactOnset> open;
  void step(const Step& step) override {
    const double h = step.t1 - step.t0;
    if (h > 0 && !places_.empty() && !request_.rows)
      for (const double share : {0.21, 0.5, 0.79, 1.0}) {
        if (ends_only_ && share < 1) continue;
        const double t = share < 1 ? step.t0 + share * h : step.t1;
        step.state(t, q_, v_);
        step.contacts(t, q_, places_);
        for (std::size_t k = 0; k < places_.size(); ++k)
          sight_.depth[k] = std::max(sight_.depth[k], -places_[k].gap);
      }
    if (request_.at && sight_.at.q.empty() && *request_.at <= step.t1 && *request_.at >= step.t0) {
      sight_.at.t = *request_.at;
      sight_.at.q.resize(q_.size());
      sight_.at.v.resize(v_.size());
      step.state(*request_.at, sight_.at.q, sight_.at.v);
    }
    if (++steps_ % 64 != 0) return;
    const double cpu = thread_seconds() - began_;
    if (cpu < 0.5 * request_.limit) half_ = step.t1;
    if (cpu < request_.limit) return;
    sight_.overtime = done_ = true;
    sight_.went_on = step.t1 - half_;
  }

 private:
  Sight& sight_;
  const LookRequest& request_;
  bool ends_only_;
  double began_, half_ = 0;
  std::size_t touches_ = 0;
  long steps_ = 0;
  std::atomic<bool> done_ = false;
  std::vector<double> q_, v_;
  std::vector<ContactPlace> places_;
};

/// Change of momentum over the run minus all impulses, relative to the greatest momentum in the
/// mechanism (linear, angular), or to that which the energy would give a body.
double momentum_left(const Simulation& simulation, const BalanceWatch& watch, const Sight& sight) {
  const ForceBalance balance(simulation.scene().mechanism, simulation.layout());
  const auto &before = sight.start.v, &after = sight.result.final_state.v;
  const double seconds = sight.result.t_end - sight.start.t;
  auto change = after;
  double scale[2] = {0, 0}, most[2] = {0, 0};
  const auto& ledger = sight.result.ledger;
  const double kinetic = std::max(ledger.kinetic, ledger.scale());
  for (std::size_t i = 0; i < change.size(); ++i) {
    const auto& body = simulation.scene().mechanism.bodies[i / 3];
    const bool turn = i % 3 == 2;
    change[i] -= before[i];
    scale[turn] = std::max(scale[turn], std::sqrt(2 * (turn ? body.inertia : body.mass) * kinetic));
    scale[turn] =
        std::max(scale[turn], (turn ? body.inertia : body.mass) * (std::abs(before[i]) + std::abs(after[i])));
  }
  for (const auto& e : watch.total.elements) {
    scale[0] = std::max({scale[0], std::abs(e.fx), std::abs(e.fy)});
    scale[1] = std::max({scale[1], std::abs(e.m_first), std::abs(e.m_second)});
  }
  const auto left = balance.momentum_left(watch.total, change, seconds);
  for (std::size_t i = 0; i < left.size(); ++i)
    most[i % 3 == 2] = std::max(most[i % 3 == 2], std::abs(left[i]));
  const auto share = [&](int k) { return most[k] > 0 ? most[k] / scale[k] : 0; };
  return std::max(share(0), share(1));
}

double off(double a, double b) { return std::abs(a - b); }

}  // namespace

Sight look(Scene scene, const Way& way, const LookRequest& request) {
  Sight sight;
  const System system(scene.mechanism);
  for (int k = 0; k < system.contacts(); ++k) sight.measure.push_back(system.contact_facts(k).measure());
  Onlooker onlooker(sight, request, way.stepped);
  ContactStatistics statistics(0);
  std::vector<Observer*> observers{&onlooker};
  observers.push_back(request.rows ? static_cast<Observer*>(&sight.rows) : &statistics);
  std::unique_ptr<BalanceWatch> balance;
  const double until = request.until.value_or(scene.run.duration);
  if (request.forces) {
    balance = std::make_unique<BalanceWatch>(scene.mechanism, way.means, until / 50, 7);
    observers.push_back(balance.get());
  }
  Simulation simulation(scene, name_of(way.family), {.start = request.start});
  sight.result = simulation.run({.until = until, .observers = observers, .stop = onlooker.token()});
  if (request.rows) return sight;
  statistics.into(sight.result);
  for (const auto& e : sight.result.events)
    if (is_onset(e))
      sight.touches.push_back({e.joint, e.t, -e.v_n_minus, e.duration, e.kind == EventKind::impact,
                               std::abs(e.v_t_minus) * e.duration});
  sight.touches.insert(sight.touches.end(), onlooker.open.begin(), onlooker.open.end());
  std::ranges::sort(sight.touches, {}, &ContactOnset::t);
  if (balance) {
    // By reported moments and by lever arms: one has rounding where moments cancel, the other where
    // joints have drifted.
    sight.newton = std::min(balance->worst.own, balance->worst.anew);
    sight.momentum = momentum_left(simulation, *balance, sight);
  }
  return sight;
}

double Reference::shortest_interval(std::size_t k) const {
  double least = interval(0);
  for (std::size_t i = 1; i <= k; ++i) least = std::min(least, interval(i));
  return least;
}

Reference make_reference(const Scene& scene, const Way& way) {
  Scene tight = scene;
  if (way.choose) way.choose(tight);
  tight.nonsmooth.tolerance = tight.penalty.tolerance = Reference::tolerance;
  Reference r;
  r.duration = scene.run.duration;
  // Three more contacts than requested: simultaneous ones may be in any order.
  const auto failed = [](const Sight& s) {
    return s.result.ending.status == Ending::Status::failed || s.overtime;
  };
  LookRequest request{.most_touches = Reference::most + 3};
  const auto base = look(tight, way, request);
  if (base.overtime || (failed(base) && base.touches.empty())) return r;
  r.way = &way;
  request.at = base.touches.empty() ? 0.9 * base.result.t_end : 0.9 * base.touches[0].t;
  const auto again = look(tight, way, {.until = *request.at, .at = request.at});
  std::vector<Sight> twins;
  for (const int which : {1, 2}) twins.push_back(look(nudged(tight, Reference::nudge, which), way, request));

  r.at = again.at;
  for (std::size_t i = 0; i < r.at.q.size(); ++i) {
    const double came = off(r.at.q[i], again.start.q[i]) + std::abs(again.start.v[i]) * r.at.t;
    (i % 3 == 2 ? r.angle : r.length) = std::max(i % 3 == 2 ? r.angle : r.length, came);
    if (i % 3 != 2) r.position = std::max({r.position, std::abs(r.at.q[i]), std::abs(again.start.q[i])});
    double moved = 0;
    for (const auto& twin : twins)
      // A twin with an earlier impact gives no information on smooth motion.
      moved = twin.at.q.empty() || (!twin.touches.empty() && twin.touches[0].t < r.at.t)
                  ? INFINITY
                  : std::max(moved, off(twin.at.q[i] - twin.start.q[i], r.at.q[i] - again.start.q[i]));
    r.sensitivity_q.push_back(Reference::worst * moved / Reference::nudge);
  }
  const std::size_t most = std::min<std::size_t>(base.touches.size(), Reference::most);
  for (std::size_t k = 0; k < most; ++k) {
    const auto& touch = base.touches[k];
    const double interval = touch.t - (k ? base.touches[k - 1].t : 0);
    double dt = 0, dv = 0;
    bool kept = true;
    for (const auto& twin : twins) {
      kept = kept && k < twin.touches.size() && twin.touches[k].contact == touch.contact &&
             off(twin.touches[k].t, touch.t) <= 1e-2 * interval;
      if (!kept) break;
      dt = std::max(dt, off(twin.touches[k].t, touch.t));
      dv = std::max(dv, off(twin.touches[k].speed, touch.speed));
    }
    // Contacts simultaneous with the next one have no order.
    if (k + 1 < base.touches.size() && base.touches[k + 1].t - touch.t < 1e-6 * touch.t) kept = false;
    if (!kept) break;
    r.touches.push_back(touch);
    r.sensitivity_t.push_back(Reference::worst * dt / Reference::nudge);
    r.sensitivity_speed.push_back(Reference::worst * dv / Reference::nudge);
    r.greatest_speed = std::max(r.greatest_speed, touch.speed);
  }
  r.all = r.touches.size() == base.touches.size() && !failed(base) &&
          std::ranges::all_of(
              twins, [&](const Sight& t) { return !failed(t) && t.touches.size() == base.touches.size(); });
  return r;
}

}  // namespace freeplay::verification::random_scenes
