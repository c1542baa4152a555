#include "analysis/branch_events.hpp"

#include <algorithm>
#include <complex>
#include <limits>
#include <utility>

namespace freeplay {
namespace {

using Eigen::VectorXd;

constexpr int most_locations = 40;
/// The test function has reached its errors if it is not halved by this number of motions.
constexpr int most_idle = 4;
/// A bifurcation is located to this share of the bracket, or until the test function vanishes to rounding.
constexpr double located_share = 1e-12;
/// A pair with a smaller imaginary part is real: no torus begins there.
constexpr double complex_part = 1e-6;
/// Least modulus of an eigenvalue of a regular system.
constexpr double least_eigenvalue = 1e-6;
/// Greatest share of the ends of a bracket that is left at a zero.
constexpr double jump_share = 0.1;
/// Most motions in an extrapolation to a grazing impact or lift-off.
constexpr std::size_t most_extrapolated = 6;
/// Least ratio of their approach speeds or forces.
constexpr double least_ratio = 1.25;
/// Distances from a grazing impact at which the motions that follow are searched, relative to the range.
constexpr double distances_beside[] = {1e-4, 1e-3, 1e-2};

/// Multipliers without that of a shift along the motion.
std::vector<std::complex<double>> decisive(const BranchSolver& solver, const BranchMotion& m) {
  auto list = m.multipliers.values;
  if (solver.setup().autonomous && !list.empty())
    list.erase(std::ranges::min_element(list, {}, [](const auto& x) { return std::abs(x - 1.0); }));
  return list;
}

double fold_test(const BranchMotion& m) { return m.tangent_key(); }

double flip_test(const BranchSolver& solver, const BranchMotion& m) {
  std::complex<double> product = 1;
  for (const auto& x : decisive(solver, m)) product *= (1.0 + x) / (1 + std::abs(x));
  return product.real();
}

/// The least modulus of the eigenvalues, with the sign of the determinant.
double crossing_test(const BranchSolver& solver, const BranchMotion& m) {
  if (solver.setup().autonomous) return NAN;  // the phase of the motion is free
  std::complex<double> sign = 1;
  double least = INFINITY;
  for (const auto& x : general_eigen(solver.equations(m)).values) {
    least = std::min(least, std::abs(x));
    sign *= x / std::abs(x);
  }
  return std::copysign(least, sign.real());
}

double torus_test(const BranchSolver& solver, const BranchMotion& m) {
  const auto list = decisive(solver, m);
  std::complex<double> product = 1;
  for (std::size_t i = 0; i < list.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const auto pair = list[i] * list[j];
      product *= (1.0 - pair) / (1 + std::abs(pair));
    }
  return product.real();
}

/// The zero of a test function between arclengths 0 and `distance` by the Illinois method.
template <class Test>
std::optional<BranchEvent> locate(const BranchSolver& solver, const BranchMotion& base, double distance,
                                  double at_base, double at_next, Test test) {
  double a = 0, fa = at_base, b = distance, fb = at_next;
  std::optional<BranchEvent> best;
  std::string reason;
  double halved = INFINITY;  // the value from which the next one has to be halved
  int idle = 0;
  for (int i = 0; i < most_locations && idle < most_idle && b - a > located_share * distance; ++i) {
    double s = (a * fb - b * fa) / (fb - fa);
    if (!(s > a && s < b)) s = 0.5 * (a + b);
    auto m = solver.along(base, s, reason);
    if (!m) return best;
    const double f = test(*m);
    const double last = best ? best->residual : INFINITY, before = best ? best->distance : INFINITY;
    if (std::abs(f) <= std::abs(last) || !best)
      best = BranchEvent{.distance = s, .motion = std::move(*m), .residual = f};
    if (f == 0 || std::abs(s - before) < located_share * distance) break;
    ++idle;
    if (std::abs(f) < 0.5 * halved) {
      halved = std::abs(f);
      idle = 0;
    }
    if ((f > 0) == (fb > 0)) {
      b = s;
      fb = f;
      fa *= 0.5;
    } else {
      a = b;
      fa = fb;
      b = s;
      fb = f;
    }
    if (a > b) {
      std::swap(a, b);
      std::swap(fa, fb);
    }
  }
  return best;
}

}  // namespace

bool has_complex_pair(const BranchSolver& solver, const BranchMotion& m) {
  const auto list = decisive(solver, m);
  double least = INFINITY;
  bool is_complex = false;
  for (std::size_t i = 0; i < list.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (const double beside = std::abs(1.0 - list[i] * list[j]); beside < least) {
        least = beside;
        is_complex = std::abs(list[i].imag()) > complex_part;
      }
  return is_complex;
}

double bifurcation_test(BifurcationKind kind, const BranchSolver& solver, const BranchMotion& m) {
  if (kind == BifurcationKind::flip) return flip_test(solver, m);
  if (kind == BifurcationKind::torus) return torus_test(solver, m);
  if (kind == BifurcationKind::crossing) return crossing_test(solver, m);
  return fold_test(m);
}

std::vector<BranchEvent> events_between(BranchSolver& solver, const BranchMotion& base, double distance,
                                        BranchMotion& next, const std::vector<BranchTest>& further) {
  std::vector<BranchEvent> list;
  bool refined = false;
  auto tests = further;
  for (const auto kind :
       {BifurcationKind::fold, BifurcationKind::flip, BifurcationKind::torus, BifurcationKind::crossing})
    tests.push_back(
        {kind, "", [&, kind](const BranchMotion& m) { return bifurcation_test(kind, solver, m); }});
  for (const auto& test : tests) {
    const double before = test.value(base), after = test.value(next);
    if (!(before * after < 0)) continue;
    // A family of motions has a vanishing determinant, whose sign is that of
    // rounding errors.
    const bool crosses = test.kind == BifurcationKind::crossing;
    if (crosses && std::min(std::abs(before), std::abs(after)) < least_eigenvalue) continue;
    if (!refined && !solver.refine_motion(next).empty()) continue;
    refined = true;
    auto found = locate(solver, base, distance, before, after, test.value);
    if (!found || (test.kind == BifurcationKind::torus && !has_complex_pair(solver, found->motion))) continue;
    // A function that jumps has no zero.
    const bool jumps =
        !(std::abs(found->residual) <= jump_share * std::max(std::abs(before), std::abs(after)));
    if (jumps && (crosses || test.kind == BifurcationKind::event)) continue;
    found->kind = test.kind;
    found->name = test.name;
    list.push_back(std::move(*found));
  }
  std::ranges::stable_sort(list, {}, &BranchEvent::distance);
  return list;
}

VectorXd crossing_direction(const BranchSolver& solver, const BranchMotion& m) {
  const auto eigen = general_eigen(solver.equations(m));
  Eigen::Index least = 0;
  for (Eigen::Index i = 1; i < eigen.values.size(); ++i)
    if (std::abs(eigen.values[i]) < std::abs(eigen.values[least])) least = i;
  VectorXd direction = eigen.vectors.col(least).real();
  direction /= length_of(direction, m.model->map.size());
  return direction;
}

std::optional<BranchEvent> reach_key(const BranchSolver& solver, const BranchMotion& base, double distance,
                                     const BranchMotion& next, double value) {
  const auto beside = [&](const BranchMotion& m) { return (m.parameter - value) / solver.setup().range(); };
  return locate(solver, base, distance, beside(base), beside(next), beside);
}

std::optional<BranchMotion> doubled_motion(const BranchSolver& solver, const BranchMotion& flip) {
  const auto eigen = general_eigen(flip.point.map);
  Eigen::Index nearest = 0;
  for (Eigen::Index i = 1; i < eigen.values.size(); ++i)
    if (std::abs(eigen.values[i] + 1.0) < std::abs(eigen.values[nearest] + 1.0)) nearest = i;
  const VectorXd direction = eigen.vectors.col(nearest).real().normalized();
  BranchMotion base;
  base.parameter = flip.parameter;
  base.point.state = flip.point.state;
  base.model = solver.model(flip.parameter, &flip.model->map, 2 * flip.model->map.length());
  auto& map = base.model->map;
  map.chart(base.point.state);
  base.tangent = VectorXd::Zero(flip.tangent.size());
  base.tangent.head(map.size()) = map.local(flip.model->map.displacement(direction)).normalized();
  for (const double amplitude : first_amplitudes) {
    std::string reason;
    auto m = solver.along(base, amplitude, reason);
    if (!m || m->sequence().size() != 2 * flip.sequence().size()) continue;
    const auto half = m->model->map.until(m->point.state, m->point.state.t + 0.5 * m->model->map.length(),
                                          solver.steps(), nullptr);
    if (!half.failure.empty()) continue;
    auto change = list_of({half.end.state, half.end.contacts});
    const auto start = list_of(m->point.state);
    for (std::size_t i = 0; i < change.size(); ++i) change[i] -= start[i];
    if (!(m->model->map.local(change).norm() < 0.1 * amplitude * solver.scale())) return m;
  }
  return {};
}

double greatest_speed(const BranchMotion& m) {
  double fastest = m.point.end.fastest;
  for (const auto& onset : m.point.end.onsets) fastest = std::max(fastest, -onset.rate);
  return fastest;
}

std::vector<Positive> positive_quantities(const BranchMotion& m) {
  std::vector<Positive> list;
  const double fastest = greatest_speed(m);
  for (std::size_t i = 0; i < m.point.end.onsets.size(); ++i) {
    const double speed = -m.point.end.onsets[i].rate;
    list.push_back({BifurcationKind::grazing, i, speed, speed / fastest});
  }
  for (std::size_t i = 0; i < m.point.end.lasting.size(); ++i) {
    const auto& contact = m.point.end.lasting[i];
    list.push_back({BifurcationKind::liftoff, i, contact.least, contact.least / contact.greatest});
  }
  return list;
}

Positive least_positive(const BranchMotion& m) {
  const auto list = positive_quantities(m);
  return list.empty() ? Positive() : *std::ranges::min_element(list, {}, &Positive::share);
}

bool falling(const std::vector<BranchMotion>& motions, const Positive& last) {
  if (motions.size() < 2) return false;
  return std::ranges::any_of(positive_quantities(motions[motions.size() - 2]), [&](const Positive& before) {
    return before.same(last) && last.value < before.value;
  });
}

double slope_of(const BranchSolver& solver, const BranchMotion& m, const BranchMotion& before,
                const Positive& quantity) {
  for (const auto& p : positive_quantities(before))
    if (p.same(quantity)) return (p.share - quantity.share) / solver.distance(m, before);
  return 0;
}

std::string contact_name(const BranchMotion& m, const Positive& p) {
  const auto& end = m.point.end;
  return m.model->system
      .contact_facts(p.kind == BifurcationKind::grazing ? end.onsets[p.index].contact
                                                        : end.lasting[p.index].contact)
      .name;
}

Orbit branch_orbit(int periods, const BranchMotion& m) {
  Orbit o;
  o.periods = periods;
  o.period = m.model->map.length() / periods;
  o.residual = m.point.greatest;
  o.state = m.point.state;
  const auto& system = m.model->system;
  for (const auto& onset : m.point.end.onsets)
    o.impacts.push_back({onset.t, system.contact_facts(onset.contact).name, -onset.rate});
  for (const auto& contact : m.point.end.lasting)
    o.lasting.push_back({system.contact_facts(contact.contact).name, contact.least, contact.t});
  o.multipliers = m.multipliers.values;
  o.stable = m.multipliers.stable;
  o.iterations = m.iterations;
  return o;
}

Vanished extrapolated(const std::vector<BranchMotion>& motions, const Positive& quantity) {
  // The last motion, and earlier ones of increasing values that are well apart.
  std::vector<const BranchMotion*> chosen;
  std::vector<double> v;
  for (auto m = motions.rbegin(); m != motions.rend() && chosen.size() < most_extrapolated; ++m) {
    const double value = quantity.kind == BifurcationKind::grazing
                             ? -m->point.end.onsets[quantity.index].rate
                             : m->point.end.lasting[quantity.index].least;
    if (!v.empty() && value < least_ratio * v.back()) continue;
    chosen.push_back(&*m);
    v.push_back(value);
  }
  std::ranges::reverse(chosen);
  std::ranges::reverse(v);
  const auto count = chosen.size();
  // Neville's scheme at v = 0; `error`: change by the last motion.
  double change = 0;
  const auto at_zero = [&](auto value) {
    std::vector<double> y(count);
    for (std::size_t i = 0; i < count; ++i) y[i] = value(*chosen[i]);
    change = std::numeric_limits<double>::infinity();
    for (std::size_t k = 1; k < count; ++k) {
      const double before = y[count - k];
      for (std::size_t i = 0; i + k < count; ++i)
        y[i] = (v[i] * y[i + 1] - v[i + k] * y[i]) / (v[i] - v[i + k]);
      change = std::abs(y[count - 1 - k] - before);
    }
    return y.front();
  };
  Vanished g{.state = motions.back().point.state};
  g.parameter = at_zero([](const BranchMotion& m) { return m.parameter; });
  g.error = change;
  g.period = at_zero([](const BranchMotion& m) { return m.model->map.length(); });
  for (std::size_t i = 0; i < g.state.q.size(); ++i) {
    g.state.q[i] = at_zero([&](const BranchMotion& m) { return m.point.state.q[i]; });
    g.state.v[i] = at_zero([&](const BranchMotion& m) { return m.point.state.v[i]; });
  }
  for (std::size_t i = 0; i < g.state.z.size(); ++i)
    g.state.z[i] = at_zero([&](const BranchMotion& m) { return m.point.state.z[i]; });
  return g;
}

std::optional<BranchMotion> motion_beside(const BranchSolver& solver, const BranchMotion& m,
                                          const Vanished& g, double side, const std::vector<int>& sequence) {
  for (const double share : distances_beside) {
    std::string reason;
    const double key = g.parameter + side * solver.setup().range() * share;
    auto motion = solver.at_key(m, {{g.state, m.point.state.contacts}, key, g.period}, reason);
    if (motion && motion->sequence() == sequence) return motion;
  }
  return {};
}

namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

/// Distances of the runs beside a motion, in units of σ and of the range.
constexpr double displaced[] = {1e-5, 1e-4};
/// Approach speeds of the first motion with an impact, over the greatest speed.
constexpr double first_speeds[] = {2e-2, 5e-2, 1e-1};
/// A contact is just touched if its approach speed is below this share of the greatest speed.
constexpr double grazing_speed = 0.05;

/// The onset of `longer` without which both lists are equal.
std::optional<std::size_t> added(const std::vector<int>& shorter, const std::vector<int>& longer) {
  if (longer.size() != shorter.size() + 1) return {};
  const auto [a, b] = std::ranges::mismatch(shorter, longer);
  const auto at = b - longer.begin();
  return std::equal(a, shorter.end(), b + 1) ? std::optional(static_cast<std::size_t>(at)) : std::nullopt;
}

std::optional<NewContact> new_contact_of(const BranchMotion& m, const EndState& end) {
  std::vector<int> sequence;
  for (const auto& onset : end.onsets) sequence.push_back(onset.contact);
  const auto at = added(m.sequence(), sequence);
  if (!at) return {};
  return NewContact{*at, sequence[*at], -end.onsets[*at].rate};
}

}  // namespace

std::optional<NewContact> new_contact_ahead(const BranchSolver& solver, const BranchMotion& m,
                                            double distance) {
  const auto f = m.model->map.size();
  for (const double factor : {1.0, 4.0, 16.0, 64.0, 256.0, 4096.0}) {
    const auto end =
        solver.beside(m, factor * distance * m.tangent.head(f), factor * distance * m.tangent_key());
    if (!end) continue;
    if (const auto grazed = new_contact_of(m, *end);
        grazed && grazed->speed < grazing_speed * greatest_speed(m))
      return grazed;
  }
  return {};
}

std::optional<BranchMotion> first_with_impact(const BranchSolver& solver, const BranchMotion& m,
                                              const NewContact& grazed, std::string& reason) {
  const auto& map = m.model->map;
  const auto f = map.size();
  const double range = solver.setup().range(), scale = solver.scale();
  VectorXd kappa = VectorXd::Zero(f + 1), c = VectorXd::Zero(f);
  double fastest = 0;  // of the impacts in these runs; the slowest ones know c best
  for (Eigen::Index k = 0; k <= f; ++k)
    for (const double sign : {1.0, -1.0})
      for (const double size : displaced) {
        if (kappa[k] != 0) break;
        VectorXd u = VectorXd::Zero(f);
        double xi = 0;
        (k < f ? u[k] : xi) = sign * size;
        const auto end = solver.beside(m, u, xi);
        const auto found = end ? new_contact_of(m, *end) : std::nullopt;
        if (!found || found->contact != grazed.contact) continue;
        kappa[k] = found->speed * found->speed / (sign * size);
        if (fastest > 0 && found->speed > fastest) continue;
        fastest = found->speed;
        auto list = list_of({end->state, end->contacts});
        const auto from = list_of({m.point.end.state, m.point.end.contacts});
        for (std::size_t i = 0; i < list.size(); ++i) list[i] -= from[i];
        const VectorXd smooth = m.point.map * u + m.point.by_key * (xi * range / scale);
        c = (map.local(list) / scale - smooth) / found->speed;
      }
  if (fastest == 0) {
    reason = "no motion beside it touches the contact";
    return {};
  }
  MatrixXd A(f + 1, f + 1);
  A.topLeftCorner(f, f) = MatrixXd::Identity(f, f) - m.point.map;
  A.topRightCorner(f, 1) = -m.point.by_key * (range / scale);
  A.bottomRows(1) = kappa.transpose();
  VectorXd rest(f + 1);
  rest << c, 0;
  const VectorXd slope = MinimumNorm(A).solve(rest);
  for (const double share : first_speeds) {
    const double distance = share * greatest_speed(m) * slope.norm();
    BranchMotion base = m;
    base.tangent = VectorXd::Zero(m.tangent.size());
    base.tangent.head(f) = slope.head(f) / slope.norm();
    base.tangent[m.tangent.size() - 1] = slope[f] / slope.norm();
    auto motion = solver.along(base, distance, reason);
    if (motion && added(m.sequence(), motion->sequence())) return motion;
    if (motion) reason = "Newton's method finds motions without the impact only";
  }
  return {};
}

}  // namespace freeplay
