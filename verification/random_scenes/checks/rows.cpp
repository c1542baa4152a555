// Compares every row of a trajectory with its reference: a small independent integration, a closed
// form, a curve, the energy, or runs at a tight tolerance. expected_of() computes the references,
// bounds_of() the permitted errors of a method, compare() counts the rows outside these bounds, and
// KnownRows::assess() combines them into a verdict.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "values/warning.hpp"
#include "verification/random_scenes/checks/checks.hpp"
#include "verification/random_scenes/numbers.hpp"

namespace freeplay::verification::random_scenes {
namespace {

/// Sets X and V, the scales of the motion.
void measure(ExpectedRows& e) {
  for (std::size_t k = 0; k < e.x.size(); ++k) {
    e.X = std::max(e.X, std::abs(e.x[k] - e.x[0]));
    e.V = std::max(e.V, std::abs(e.v[k]));
  }
}
/// Raises the sensitivity to that of a reference with parameters changed by `nudge`: three times
/// the running maximum of |Δx|/nudge.
void twin(ExpectedRows& e, std::span<const double> other, double nudge) {
  const auto n = std::min(e.x.size(), other.size());
  e.sensitivity.resize(std::min(e.sensitivity.empty() ? n : e.sensitivity.size(), n));
  double most = 0;
  for (std::size_t k = 0; k < e.sensitivity.size(); ++k) {
    most = std::max(most, 3 * std::abs(other[k] - e.x[k]) / nudge);
    e.sensitivity[k] = std::max(e.sensitivity[k], most);
  }
}
/// Sets the error of the reference: the running maximum of its deviation from a second
/// computation.
void check(ExpectedRows& e, std::span<const double> finer) {
  const auto n = std::min(e.x.size(), finer.size());
  e.x.resize(n), e.v.resize(n);
  e.error.assign(n, 0);
  double most = 0;
  for (std::size_t k = 0; k < n; ++k) e.error[k] = most = std::max(most, std::abs(finer[k] - e.x[k]));
}

constexpr double nudge = 1e-7;  // relative change of parameters

/// Expected values by a reference, as found under a change of it.
ExpectedRows expected_by(
    std::size_t coordinate,
    const std::function<reference::OneCoordinate::Rows(const reference::Change&)>& found) {
  const auto base = found({}), fine = found({.fine = 0.5});
  ExpectedRows e{coordinate, fine.x, fine.v};
  check(e, base.x);
  measure(e);
  e.sensitivity.assign(e.x.size(), 0);
  twin(e, found({.x = nudge * e.X}).x, nudge);
  twin(e, found({.v = nudge * e.V}).x, nudge);
  // After a state of rest, the motion no longer depends on the start, but it still depends on the
  // loads. The sensitivity therefore includes a change of the acceleration.
  twin(e, found({.load = nudge}).x, nudge);
  return e;
}
ExpectedRows expected_of(const Moving& m, Family family, const std::vector<double>& instants) {
  const auto& one = family == Family::penalty ? m.compliant : m.rigid;
  return expected_by(m.coordinate,
                     [&](const reference::Change& change) { return one.under(change).at(instants); });
}
ExpectedRows expected_of(const Derived& d, Family family, const std::vector<double>& instants) {
  return expected_by(d.coordinate,
                     [&](const reference::Change& change) { return d.rows(family, instants, change); });
}

std::vector<ExpectedRows> expected_of(const BodiesInLine& r, Family family,
                                      const std::vector<double>& instants) {
  const auto found =
      family == Family::penalty ? r.row.compliant(instants, r.compliant_step) : r.row.at(instants, 2000);
  auto faster = r.row;
  for (auto& v : faster.v) v *= 1 + nudge;
  for (std::size_t i = 0; i < faster.mass.size(); ++i) faster.mass[i] *= 1 + nudge * (i % 2 ? 0.7 : -0.4);
  faster.gravity *= 1 + nudge;
  const auto twins =
      family == Family::penalty ? faster.compliant(instants, r.compliant_step) : faster.at(instants, 2000);
  const auto finer = family == Family::penalty ? r.row.compliant(instants, 0.5 * r.compliant_step) : found;
  std::vector<ExpectedRows> list;
  for (std::size_t i = 0; i < r.row.mass.size(); ++i) {
    ExpectedRows e{3 * (r.first + i) + r.along};
    std::vector<double> other, fine;
    for (std::size_t k = 0; k < found.known; ++k) e.x.push_back(found.x[k][i]), e.v.push_back(found.v[k][i]);
    for (std::size_t k = 0; k < twins.known; ++k) other.push_back(twins.x[k][i]);
    for (std::size_t k = 0; k < finer.known; ++k) fine.push_back(finer.x[k][i]);
    check(e, fine);
    measure(e);
    e.sensitivity.assign(e.x.size(), 0);
    twin(e, other, nudge);
    list.push_back(std::move(e));
  }
  return list;
}

/// Whether the line of bodies has a reference of its own: its compliant contacts are modelled
/// without dissipation only (references/touching_row.hpp).
bool knows(const BodiesInLine& r, Family family) {
  return family == Family::nonsmooth || r.row.restitution == 1;
}

/// Runs a scene by a method within the time limit of one run.
Sight rows_of(const Scene& scene, const Way& way) {
  return look(scene, way, {.rows = true, .limit = run_limit(Suite::rows)});
}

/// References of coordinates that only other runs provide: event-driven runs at tolerances 1e-12
/// and 1e-11, or penalty runs by two integrators at 1e-12. The difference of the two runs is the
/// error of the reference.
std::vector<ExpectedRows> expected_of_runs(const RandomScene& scene, Family family) {
  std::vector<ExpectedRows> list;
  auto others = scene.others;
  if (scene.line && !knows(*scene.line, family))
    for (std::size_t i = 0; i < scene.line->row.mass.size(); ++i)
      others.push_back(3 * (scene.line->first + i) + scene.line->along);
  if (others.empty()) return list;
  const bool penalty = family == Family::penalty;
  const auto way = [&](std::string_view integrator) -> const Way& {
    return *std::ranges::find(ways(Suite::rows), penalty ? integrator : "event-driven", &Way::name);
  };
  const auto &one = way("adams_bashforth_moulton"), &other = way("dopri5");
  auto first = scene_for(scene, one), second = scene_for(scene, other);
  for (auto* s : {&first, &second}) (penalty ? s->penalty.tolerance : s->nonsmooth.tolerance) = 1e-12;
  if (!penalty) second.nonsmooth.tolerance = 1e-11;
  auto near = first;
  Draw draw(20261124, 1);
  for (auto& b : near.mechanism.bodies) {
    b.mass *= 1 + nudge * draw.either_way(1);
    const double faster = 1 + nudge * draw.either_way(1);
    if (b.velocity) b.velocity = faster * *b.velocity;
  }
  Sight a, b, c;
  try {
    a = rows_of(first, one), b = rows_of(second, other), c = rows_of(near, one);
  } catch (const std::exception&) {
    return list;
  }
  const auto column = [](const Sight& s, std::size_t i, bool rate) {
    std::vector<double> x;
    for (std::size_t k = 0; k < s.rows.size(); ++k) x.push_back(rate ? s.rows.v(k)[i] : s.rows.q(k)[i]);
    return x;
  };
  for (const auto i : others) {
    ExpectedRows e{i, column(a, i, false), column(a, i, true)};
    check(e, column(b, i, false));
    measure(e);
    e.sensitivity.assign(e.x.size(), 0);
    twin(e, column(c, i, false), nudge);
    list.push_back(std::move(e));
  }
  // The largest motion of all coordinates scales each position, because a coordinate at rest has no
  // scale of its own. Angles keep their scale.
  double X = 0, V = 0;
  for (const auto& e : list) X = std::max(X, e.X), V = std::max(V, e.V);
  for (auto& e : list)
    if (e.coordinate % 3 != 2) e.X = X, e.V = V, e.floor = X;
  return list;
}

/// Permitted errors of a method, relative to the size of the motion:
///
///  - adaptive integrators: 10⁵ times the tolerance (1e-10 event-driven, 1e-9 penalty);
///  - adaptive time stepping: 10⁴ times the tolerance (1e-6), a hundredth of the motion;
///  - time stepping with fixed steps h: 4 h/T with the shortest time T of the scene (first order);
///  - rk4 in the penalty formulation: 1e-3, which it keeps with 40 steps in a contact.
///
/// The factors of adaptive methods have three reasons: a run has up to some thousand steps, its
/// coordinates have different scales, and its rows come from a dense output of lower order.
struct Bounds {
  double share = 0;       ///< of positions
  double speeds = 0;      ///< of rates
  double late = 0;        ///< s, of the time of an event, which may lie anywhere in a fixed step
  double prescribed = 0;  ///< of a prescribed coordinate's size, and of its rate
  double energy = 0;      ///< of the greatest kinetic energy
  double step = 0;        ///< s, of fixed steps
  Bounds tenth() const {
    return {0.1 * share, 0.1 * speeds, 0.1 * late, 0.1 * prescribed, 0.1 * energy, step};
  }
};
Bounds bounds_of(const RandomScene& scene, const Way& way, const Result& result) {
  if (way.family == Family::penalty && way.stepped) return {1e-3, 1e-2, 0, 1e-4, 1e-2, scene.contact_step};
  if (way.family == Family::penalty) return {1e-4, 1e-3, 0, 1e-4, 1e-3, 0};
  if (way.stepped)
    return {4 * scene.step / scene.shortest,
            8 * scene.step / scene.shortest,
            2 * scene.step,
            1e-5,
            0.1,
            scene.step};
  const bool stepped = way.name == std::string("moreau-jean adaptive") || result.work.handovers > 0;
  if (stepped) return {1e-2, 5e-2, 0, 1e-3, 5e-2, 0};
  return {1e-5, 1e-4, 0, 1e-5, 1e-4, 0};
}

struct Comparison {
  double known = 1;      ///< share of the rows
  std::string worst;     ///< the first row outside the bound
  long off = 0, of = 0;  ///< rows
};
void add(Comparison& c, bool off, const std::function<std::string()>& what) {
  ++c.of;
  if (!off) return;
  if (++c.off == 1) c.worst = what();
}

void compare(Comparison& all, const ExpectedRows& e, const Trajectory& rows, const Bounds& b) {
  double S = 0, V = 0;
  const auto n = std::min({e.x.size(), rows.size(), e.sensitivity.size()});
  std::size_t k = 0;
  for (; k < n; ++k) {
    const double spacing = k > 0 ? rows.t(k) - rows.t(k - 1) : rows.t(k + 1 < n ? k + 1 : k) - rows.t(k);
    S = std::max({S, std::abs(e.x[k] - e.x[0]) + 1e-9 * e.X, e.floor});
    const auto ahead = std::min(n - 1, k + 1 + static_cast<std::size_t>(std::min(1e6, b.late / spacing)));
    for (std::size_t i = k; i <= ahead; ++i) V = std::max(V, std::abs(e.v[i]));
    const double size = S + e.sensitivity[k], rounding = 1e-12 * (std::abs(e.x[k]) + e.X);
    const double bound = b.share * size + b.late * V + rounding;
    if (b.share * e.sensitivity[k] > 0.1 * e.X || e.error[k] > 0.3 * bound) break;
    const double off = std::abs(rows.q(k)[e.coordinate] - e.x[k]);
    // A velocity is correct if it lies between the least and greatest reference velocity within m
    // rows: an error in time that the bound of positions permits is not an error of velocity.
    const auto m = static_cast<std::size_t>(
        std::min(50.0, 1 + std::ceil((V > 0 ? bound / (V * spacing) : 0) + b.late / spacing)));
    double low = INFINITY, high = -INFINITY;
    for (std::size_t i = k > m ? k - m : 0; i <= std::min(k + m, n - 1); ++i)
      low = std::min(low, e.v[i]), high = std::max(high, e.v[i]);
    const double v = rows.v(k)[e.coordinate],
                 rate = b.speeds * e.V * (1 + (e.X > 0 ? e.sensitivity[k] / e.X : 0)) + 1e-12 * e.V;
    add(all, !(off <= bound), [&] {
      return fmt::format(
          "coordinate {} at t = {:.6g} s (row {}) is {:.2g} off {:.6g}, above {:.2g}; "
          "its motion amounts to {:.2g}",
          e.coordinate, rows.t(k), k, off, e.x[k], bound, e.X);
    });
    const double beyond = std::max({low - v, v - high, 0.0});
    add(all, !(beyond <= rate), [&] {
      return fmt::format("rate {} at t = {:.6g} s (row {}) is {:.2g} off {:.6g}, above {:.2g}", e.coordinate,
                         rows.t(k), k, beyond, e.v[k], rate);
    });
  }
  all.known = std::min(all.known, static_cast<double>(k) / static_cast<double>(random_scenes::rows + 1));
}

/// `least`: displacement that is always permitted, because it counts as rest.
void compare(Comparison& all, const Prescribed& p, const Trajectory& rows, const Bounds& b, double least) {
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto m = p.motion(rows.t(k), rows.q(k), rows.v(k));
    const double off = std::abs(rows.q(k)[p.coordinate] - m.y),
                 late = std::abs(rows.v(k)[p.coordinate] - m.slope);
    const double bound =
        b.prescribed * p.size + 0.25 * p.bend * b.step * b.step + 1e-12 * (std::abs(m.y) + p.size) + least;
    const double rate = std::max(10 * b.prescribed, b.speeds) * p.rate + 2 * p.bend * b.step + 1e-12 * p.rate;
    add(all, !(off <= bound), [&] {
      return fmt::format(
          "prescribed coordinate {} at t = {:.6g} s (row {}) is {:.2g} off {:.6g}, above {:.2g}; "
          "its motion amounts to {:.2g}",
          p.coordinate, rows.t(k), k, off, m.y, bound, p.size);
    });
    if (p.rate > 0)
      add(all, !(late <= rate), [&] {
        return fmt::format("prescribed rate {} at t = {:.6g} s (row {}) is {:.2g} off {:.6g}, above {:.2g}",
                           p.coordinate, rows.t(k), k, late, m.slope, rate);
      });
  }
}

void compare_energy(Comparison& all, const RandomScene& s, const Trajectory& rows, const Bounds& b) {
  const double first = s.energy(rows.q(0), rows.v(0));
  double size = std::abs(first);
  // In a time step with an impact, the velocity of a row lies between those before and after the
  // impact. The energies of two rows on each side are therefore accepted, too.
  const std::size_t m = b.energy > 2e-2 ? 2 : 0;
  std::vector<double> energies;
  for (std::size_t k = 0; k < rows.size(); ++k) energies.push_back(s.energy(rows.q(k), rows.v(k)));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double now = energies[k];
    double off = INFINITY;
    for (std::size_t i = k > m ? k - m : 0; i <= std::min(k + m, rows.size() - 1); ++i)
      off = std::min(off, std::abs(energies[i] - first));
    size = std::max(size, std::abs(now));
    add(all, !(off <= b.energy * size), [&] {
      return fmt::format("energy at t = {:.6g} s (row {}) is {:.6g} J, at the start {:.6g} J", rows.t(k), k,
                         now, first);
    });
  }
}

/// The instants of the rows, on the output grid of the program.
std::vector<double> instants_of(const RandomScene& scene) {
  std::vector<double> instants{0};
  const double spacing = exact(scene.duration / rows);
  for (int k = 1; k <= rows; ++k) instants.push_back(k * spacing);
  if (instants.back() > scene.duration || std::abs(instants.back() - scene.duration) < 1e-9 * spacing)
    instants.back() = scene.duration;
  return instants;
}

std::vector<ExpectedRows> expected_of(const RandomScene& scene, Family family) {
  const auto instants = instants_of(scene);
  std::vector<ExpectedRows> list;
  for (const auto& m : scene.moving) list.push_back(expected_of(m, family, instants));
  for (const auto& d : scene.derived) list.push_back(expected_of(d, family, instants));
  if (scene.line && knows(*scene.line, family))
    for (auto& e : expected_of(*scene.line, family, instants)) list.push_back(std::move(e));
  for (auto& e : expected_of_runs(scene, family)) list.push_back(std::move(e));
  // A coordinate that friction holds has no scale of its own.
  for (auto& e : list) {
    e.floor = std::max(e.floor, 1e-9 * scene.speed * scene.shortest);
    e.V = std::max(e.V, 1e-9 * scene.speed);
  }
  return list;
}

}  // namespace

Verdict KnownRows::assess(const Way& way, const std::function<void(Sight&)>& falsify) {
  if (family_ != way.family) known_ = expected_of(scene_, way.family), family_ = way.family;
  Sight sight;
  try {
    sight = rows_of(scene_for(scene_, way), way);
  } catch (const std::exception& e) {
    return {Outcome::refused, e.what()};
  }
  if (falsify) falsify(sight);
  const auto& run = sight.result;
  const auto compared = [&](const Bounds& bounds) {
    Comparison c;
    for (const auto& p : scene_.prescribed)
      compare(c, p, sight.rows, bounds, 1e-10 * scene_.speed * scene_.shortest);
    for (const auto& e : known_) compare(c, e, sight.rows, bounds);
    if (scene_.energy && !(scene_.energy_of_rigid_only && way.family == Family::penalty))
      compare_energy(c, scene_, sight.rows, bounds);
    return c;
  };
  const auto bounds = bounds_of(scene_, way, run);
  auto c = compared(bounds);
  if (known_.size() <
      scene_.moving.size() + scene_.derived.size() + scene_.others.size() + (scene_.line ? 1 : 0))
    c.known = 0;
  Verdict v{.known = c.known, .cpu = run.cpu_seconds};
  const bool failed = run.ending.status == Ending::Status::failed;
  const auto note =
      std::find_if(run.notes.rbegin(), run.notes.rend(), [](const auto& n) { return is_warning(n); });
  const bool doubtful = note != run.notes.rend();
  if (c.off > 0) {
    v.outcome = doubtful ? Outcome::doubted : Outcome::silent;
    v.detail = fmt::format("{} of {} comparisons off: {}", c.off, c.of, c.worst);
    if (failed) v.detail += "; then stopped: " + run.ending.reason;
    if (doubtful) v.detail += "; run says: " + *note;
  } else if (sight.overtime) {
    v.outcome = Outcome::hung;
    v.detail = fmt::format("after {:.0f} s of CPU at t = {:.3g} of {:.3g} s", run_limit(Suite::rows),
                           run.t_end, scene_.duration);
  } else if (failed) {
    v.outcome = Outcome::refused;
    v.detail = run.ending.reason;
  } else if (doubtful) {
    // Time stepping warns of errors of a thousandth or more (docs/reference/results.md), a tenth of
    // its bounds here. A warning is false only if the errors are also below a tenth of the bounds.
    const bool stepped = bounds.share >= 1e-2 || way.stepped;
    const bool right = !stepped || compared(bounds.tenth()).off == 0;
    v.outcome = c.known > 0.999 && right ? Outcome::falsely_doubted : Outcome::doubted;
    v.detail = *note;
  }
  return v;
}

}  // namespace freeplay::verification::random_scenes
