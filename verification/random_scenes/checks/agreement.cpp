// Agreement of a run with other runs: a finer tolerance, another method, the same scene
// transformed.
#include "dynamics/system.hpp"
#include "values/warning.hpp"
#include "verification/random_scenes/checks/checks.hpp"
#include "verification/random_scenes/numbers.hpp"
#include "verification/random_scenes/transform.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::random_scenes {

namespace {

/// The run reports a motion that friction does not determine.
constexpr std::string_view paradox = "Painlevé";

/// Accumulated error of a run in tolerances: that of its steps, a thousand at least.
double steps(const Subject& s) { return std::max(1e3, static_cast<double>(s.sight.result.work.steps)); }

/// The relative change of the parameters that is equivalent to the errors of the method within its
/// steps.
Allowed allowed(const Subject& s, double tolerance) {
  if (!s.way.stepped) return {.share = steps(s) * tolerance, .own = 10 * tolerance};
  return {.share = 2 * *s.scene.nonsmooth.step, .late = 2 * *s.scene.nonsmooth.step, .speeds = false};
}

/// s, the last kink in time before t of the curves that drive and load the scene.
double last_change(const Scene& scene, double t) {
  const System system(scene.mechanism);
  double last = 0;
  for (double next = system.next_knot(0); next < t; next = system.next_knot(next)) last = next;
  return last;
}

/// Time that a run reached before it stopped.
double reached(const Sight& sight) { return sight.result.t_end; }

}  // namespace

std::optional<std::string> off_reference(const Sight& found, const Reference& r, const Allowed& allowed,
                                         double until) {
  if (!r.way) return {};
  // For time steps the share is a time, compared with the time since the previous contact.
  const bool stepped = allowed.late > 0;
  const auto share = [&](std::size_t k) {
    return stepped ? allowed.share / (r.touches.empty() ? r.duration : r.shortest_interval(k))
                   : allowed.share;
  };
  // Time stepping has no defined accuracy within its first steps, nor within those of a pulse,
  // which acts, like a contact, from some instant within a step on.
  if (!found.at.q.empty() && !r.at.q.empty() && !(r.at.t - allowed.since < allowed.late)) {
    const double of = stepped ? allowed.share / (r.at.t - allowed.since) : allowed.share;
    for (std::size_t i = 0; i < r.at.q.size(); ++i) {
      const bool angle = i % 3 == 2;
      const double bound = of * (r.sensitivity_q[i] + (angle ? r.angle : r.length)) +
                           (1e-11 + allowed.own) * (angle ? 1 : r.position) +
                           (i < allowed.halved.size() ? 2 * allowed.halved[i] : 0);
      const double off = std::abs(found.at.q[i] - r.at.q[i]);
      if (!(off <= bound))
        return fmt::format(
            "at t = {:.6g} s, before the first touch, coordinate {} is {:.2g} off, above {:.2g}", r.at.t, i,
            off, bound);
    }
  }
  std::vector<std::size_t> seen(r.touches.size());
  // A contact with little load opens for a single time step occasionally: its contact onset is
  // slow.
  const double slow = stepped ? 0.01 * r.greatest_speed : 0;
  double fastest = 0;  // m/s
  for (std::size_t i = 0; i < r.at.v.size(); ++i)
    if (i % 3 != 2) fastest = std::max(fastest, std::abs(r.at.v[i]));
  double last = 0, room = 0;
  for (std::size_t k = 0; k < r.touches.size(); ++k) {
    const auto& touch = r.touches[k];
    if (touch.speed < 2 * slow) return {};
    const double rounding = 1e-13 * r.position / std::max(touch.speed, 1e-300);
    const double bound =
        share(k) * (r.sensitivity_t[k] + touch.t) + allowed.late + 1e-12 * touch.t + rounding;
    // A grazing contact of depth d has v² = 2 g̈ d: C = R/v, C′ = g̈ R/v for a length R, and it
    // lasts 2v/g̈ = 2 v C/C′. Time stepping may miss one that lasts no longer than a few steps.
    if (stepped && 2 * touch.speed * r.sensitivity_t[k] < 4 * allowed.late * r.sensitivity_speed[k])
      return {};
    const double bound_v = share(k) * (r.sensitivity_speed[k] + r.greatest_speed) + 1e-12 * r.greatest_speed +
                           allowed.own * fastest;
    // A contact with a speed below the error of the bodies' speeds may be absent.
    if (allowed.speeds && touch.speed <= bound_v + share(k) * fastest) return {};
    // A contact is not compared if its time error exceeds half of the flight.
    if (!(bound < 0.5 * r.shortest_interval(k)) || touch.t + bound >= until) return {};
    // The contact onset of the same contact with the same number.
    std::size_t number = 0;
    for (std::size_t i = 0; i < k; ++i) number += r.touches[i].contact == touch.contact;
    const ContactOnset* other = nullptr;
    for (const auto& f : found.touches)
      if (f.contact == touch.contact && !(f.speed < slow) && number-- == 0) {
        other = &f;
        break;
      }
    if (!other)
      return fmt::format("touch {} of {} at t = {:.9g} s is missing", k + 1, touch.contact, touch.t);
    const double dt = std::abs(other->t - touch.t), dv = std::abs(other->speed - touch.speed);
    if (!(dt <= bound))
      return fmt::format("touch {} ({}, t = {:.9g} s) is {:.2g} s off, above {:.2g} s", k + 1, touch.contact,
                         touch.t, dt, bound);
    if (allowed.speeds && dv > bound_v)
      return fmt::format("touch {} ({}, t = {:.9g} s) has a speed {:.2g} m/s off, above {:.2g} m/s", k + 1,
                         touch.contact, touch.t, dv, bound_v);
    last = touch.t;
    room = bound;
  }
  const auto early = [&](double end) {
    return std::ranges::count_if(found.touches,
                                 [&](const ContactOnset& f) { return f.t < end && !(f.speed < slow); });
  };
  // Errors of time steps at earlier contacts may turn a near miss into a contact; twins that differ
  // by 1e-6 do not show that.
  const bool all = r.all && !stepped;
  const double end = all ? 0.99 * std::min(until, r.duration) : last - room;
  const auto expected =
      all ? std::ranges::count_if(r.touches, [&](const ContactOnset& f) { return f.t < end; })
          : static_cast<std::ptrdiff_t>(r.touches.size());
  if (early(end) > expected)
    return fmt::format("{} touches until t = {:.6g} s, where there are {}", early(end), end, expected);
  return {};
}

namespace {

std::optional<std::string> against_reference(Subject& s) {
  auto a = allowed(s, s.tolerance());
  if (s.way.stepped && !s.reference.at.q.empty()) a.since = last_change(s.scene, s.reference.at.t);
  const bool own = s.reference.way && s.reference.way->family == s.way.family;
  // Another formulation has only the first contact onset in common: it models the impact
  // differently.
  auto r = s.reference;
  if (!own && !r.touches.empty()) {
    r.touches.resize(1);
    r.all = false;
  }
  const auto what = off_reference(s.sight, r, a, reached(s.sight));
  // A time-stepping run that estimates the error of its first contacts is compared with that
  // estimate.
  const auto& said = s.sight.result.first_touches;
  if (what && s.way.stepped && said && !said->missing) {
    a.late =
        std::max(a.late, said->time * (r.touches.empty() ? 0 : r.shortest_interval(r.touches.size() - 1)));
    return off_reference(s.sight, r, a, reached(s.sight));
  }
  // Squeezing of a film is not a contact onset: an error of order p is 2^p/(2^p − 1) ≤ 2 times the
  // change on halving the step.
  if (what && s.way.stepped && s.lubricated() && r.at.t < reached(s.sight)) {
    auto scene = s.scene;
    *scene.nonsmooth.step *= 0.5;
    const auto finer = look(scene, s.way, {.until = r.at.t, .at = r.at.t});
    for (std::size_t i = 0; i < std::min(finer.at.q.size(), s.sight.at.q.size()); ++i)
      a.halved.push_back(std::abs(finer.at.q[i] - s.sight.at.q[i]));
    return off_reference(s.sight, r, a, reached(s.sight));
  }
  return what;
}

std::optional<std::string> coarser(Subject& s) {
  if (s.way.stepped || !s.reference.way) return {};
  auto scene = s.scene;
  const double tolerance = 1e-8;
  scene.nonsmooth.tolerance = scene.penalty.tolerance = tolerance;
  auto r = s.reference;
  if (r.way->family != s.way.family)
    r.touches.resize(std::min<std::size_t>(r.touches.size(), 1)), r.all = false;
  const double until = r.touches.empty() ? r.duration : std::min(r.duration, 1.5 * r.touches.back().t);
  const auto found = look(scene, s.way, {.until = until, .at = r.at.t});
  // The notes of that run count, not those of the run under assessment.
  for (const auto& note : found.result.notes)
    if (is_warning(note) || note.find(paradox) != note.npos) return {};
  // Where it handed over to time stepping that has a tolerance of its own.
  const double least = found.result.work.handovers > 0 ? scene.nonsmooth.step_tolerance : s.tolerance();
  return off_reference(found, r, allowed(s, std::max(tolerance, least)), reached(found));
}

std::optional<std::string> stiffer(Subject& s) {
  const auto& r = s.reference;
  if (s.way.family != Family::penalty || r.touches.size() < 2 || s.lubricated() || s.touching()) return {};
  auto scene = s.scene;
  for (auto& surface : scene.mechanism.surfaces) *surface.young *= 100;
  const auto found = look(scene, s.way, {.until = std::min(r.duration, 1.3 * r.touches.back().t)});
  double spent = 0, turned = 0;
  for (std::size_t k = 0; k < std::min({r.touches.size(), s.sight.touches.size(), found.touches.size()});
       ++k) {
    const auto &a = s.sight.touches[k], &b = found.touches[k];
    if (a.contact != r.touches[k].contact || b.contact != a.contact) return {};
    // A contact that takes a share of the time between two contacts has the effect of parameters
    // that differ by that share; so does a contact whose normal rotates with the sliding meanwhile.
    const double bound = 3 * spent + steps(s) * s.tolerance() * (r.sensitivity_t[k] + a.t) +
                         (k ? 10 * (spent / r.shortest_interval(k) + turned) * r.sensitivity_t[k] : 0) +
                         1e-12 * a.t;
    if (!(bound < 0.5 * r.shortest_interval(k))) return {};
    if (!(std::abs(a.t - b.t) <= bound))
      return fmt::format("touch {} ({}, t = {:.9g} s) is {:.2g} s off with E times 100, above {:.2g} s",
                         k + 1, a.contact, a.t, std::abs(a.t - b.t), bound);
    if (!a.impact || !b.impact) return {};
    spent += std::max(a.duration, b.duration);
    for (std::size_t c = 0; c < s.sight.contacts.size(); ++c)
      if (s.sight.contacts[c] == a.contact) turned += std::max(a.slid, b.slid) / s.sight.measure[c];
  }
  return {};
}

/// The same scene, transformed, by the same method: its contact onsets against those of the run.
std::optional<std::string> otherwise(Subject& s, const Scene& scene, double time, const char* how) {
  const auto& r = s.reference;
  if (!r.way || r.touches.empty()) return {};
  const double until = std::min(r.duration, 1.3 * r.touches.back().t);
  Sight found;
  try {
    found = look(scene, s.way, {.until = time * until});
  } catch (const SceneError& e) {
    return fmt::format("{}: refused: {}", how, e.what());
  }
  // Two runs of one method share their error except for the part within one step.
  const double h = s.way.stepped ? *s.scene.nonsmooth.step : 0;
  for (std::size_t k = 0; k < std::min(r.touches.size(), s.sight.touches.size()); ++k) {
    const auto& a = s.sight.touches[k];
    const double share = s.way.stepped ? 2 * h / r.shortest_interval(k) : steps(s) * s.tolerance();
    const double bound = share * (r.sensitivity_t[k] + a.t) + h + 1e-12 * a.t +
                         1e-13 * r.position / std::max(r.touches[k].speed, 1e-300);
    if (!(bound < 0.5 * r.shortest_interval(k)) || a.t + bound >= until) return {};
    if (r.way->family != s.way.family && k > 0) return {};
    if (k >= found.touches.size()) {
      if (found.result.t_end < time * until * (1 - 1e-9)) return {};  // it stopped and reported it
      return fmt::format("{}: touch {} at t = {:.9g} s is missing", how, k + 1, a.t);
    }
    const double off = std::abs(found.touches[k].t / time - a.t);
    if (!(off <= bound))
      return fmt::format("{}: touch {} (t = {:.9g} s) is {:.2g} s off, above {:.2g} s", how, k + 1, a.t, off,
                         bound);
  }
  return {};
}

std::optional<std::string> mirror(Subject& s) {
  if (s.reduced() || chosen(s, 3) != 0) return {};
  return otherwise(s, mirrored(by_pieces(s.scene)), 1, "in a mirror");
}
std::optional<std::string> units(Subject& s) {
  if (s.reduced() || chosen(s, 3) != 1) return {};
  Draw draw(s.drawn.seed, static_cast<std::uint64_t>(s.drawn.index) + 1000003);
  const auto power = [&] { return std::ldexp(1.0, draw.whole(-12, 12)); };
  Units u{power(), power(), power()};
  // Numbers beyond the speed of light are refused in any unit.
  double fastest = 0;
  for (const auto& b : s.scene.mechanism.bodies)
    fastest = std::max(fastest, b.velocity.value_or(Vec2{}).norm());
  while (fastest * u.length / u.time > 1e8) u.time *= 2;
  return otherwise(s, rescaled(by_pieces(s.scene), u), u.time,
                   fmt::format("lengths × {}, masses × {}, times × {}", u.length, u.mass, u.time).c_str());
}
std::optional<std::string> order(Subject& s) {
  if (s.reduced() || chosen(s, 3) != 2) return {};
  return otherwise(s, reordered(by_pieces(s.scene)), 1, "in the opposite order");
}

std::optional<std::string> backwards(Subject& s) {
  const auto& r = s.reference;
  if (s.way.stepped || !r.way || !s.conservative()) return {};
  // Up to a time between the last known contact and the next.
  double until = r.touches.empty() ? r.duration : r.touches.back().t;
  if (!r.touches.empty()) {
    const auto n = r.touches.size();
    until =
        n < s.sight.touches.size() ? 0.5 * (s.sight.touches[n].t + until) : std::min(1.2 * until, r.duration);
  }
  if (!(until <= reached(s.sight)) || !(until > 0)) return {};
  Simulation forth(s.scene, name_of(s.way.family));
  const State start = forth.state();
  if (forth.run({.until = until}).ending.status != Ending::Status::finished) return {};
  const auto back = [&](double nudge) {
    State turned = forth.state();
    turned.t = 0;
    for (std::size_t i = 0; i < turned.v.size(); ++i) turned.v[i] *= i % 2 ? -1 - nudge : -1 + nudge;
    Simulation run(s.scene, name_of(s.way.family), {.start = turned});
    run.run({.until = until});
    return run.state();
  };
  const auto end = back(0), twin = back(Reference::nudge);
  if (end.t < until * (1 - 1e-9)) return {};
  double size[2] = {0, 0};
  for (std::size_t i = 0; i < start.q.size(); ++i)
    size[i % 3 == 2] = std::max({size[i % 3 == 2], std::abs(start.q[i]), std::abs(start.v[i]) * until});
  double most[2] = {0, 0};
  for (std::size_t i = 0; i < start.q.size(); ++i)
    most[i % 3 == 2] = std::max(most[i % 3 == 2], std::abs(twin.q[i] - end.q[i]) / Reference::nudge);
  for (std::size_t i = 0; i < start.q.size(); ++i) {
    const double bound = 2 * steps(s) * s.tolerance() * (size[i % 3 == 2] + most[i % 3 == 2]);
    const double off = std::abs(end.q[i] - start.q[i]);
    if (most[i % 3 == 2] * Reference::nudge > 1e-2 * size[i % 3 == 2]) return {};
    if (!(off <= bound))
      return fmt::format("turned back at t = {:.6g} s coordinate {} ends {:.2g} off its start, above {:.2g}",
                         until, i, off, bound);
  }
  return {};
}

}  // namespace

std::span<const Check> agreement_checks() {
  static constexpr Check all[] = {
      {"first touches",
       "positions before the first touch, times and speeds of up to three touches, against the same "
       "way (penalty: its first touch, against event-driven) at a tolerance of 1e-11",
       "1000 tolerance (C + t); Moreau–Jean 2h + 2h (C + t)/interval, "
       "or what the run says of its first touches; its positions "
       "2h (C + length)/(t since the last kink in time); "
       "positions in films also twice what half the step changes",
       "C is three times what two twins whose facts differ by 1e-6 do to the touch, "
       "so it has what impacts and grazing multiply; a "
       "thousand steps; "
       "a touch acts somewhere within its step and is then a fact that differs by h over the flight, "
       "and so does a "
       "pulse over its time; a film's squeeze has an order of "
       "its own, of which no fact's twin knows",
       against_reference, paradox},
      {"tolerance", "the same at a tolerance of 1e-8", "1e-5 (C + t)", "as above", coarser, paradox},
      {"stiffness", "penalty: the first three touches with a modulus 100 times as high",
       "3 d + 10 (d/interval + d v_t/R) C, d the duration of the impacts before, R radius or clearance",
       "an impact takes d in place of an instant; loads act on it and its normal turns meanwhile", stiffer,
       paradox},
      {"mirror", "the scene mirrored, x → −x: touches at the same times",
       "1000 tolerance (C + t); Moreau–Jean h + 2h (C + t)/interval",
       "the same motion; a touch may fall into the next step", mirror, paradox},
      {"units",
       "lengths, masses and times in units of powers of two, up to 4096 either way, "
       "absolute options with them",
       "as above", "the same digits but for absolute constants in the program", units, paradox},
      {"order", "bodies, joints, contacts, drives and loads in the opposite order", "as above",
       "asked only while touches are single", order, paradox},
      {"backwards",
       "where e = 1, µ = 0 and nothing acts but gravity and springs: velocities turned round, "
       "as long again, is the start",
       "2000 tolerance (C + size)", "two runs; C by a twin whose velocities differ by 1e-6, to and fro",
       backwards, paradox},
  };
  return all;
}

}  // namespace freeplay::verification::random_scenes
