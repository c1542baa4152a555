// Bifurcations of periodic motions on branches over one key, against closed forms.
#include <complex>

#include "analysis/continuation.hpp"
#include "verification/claims/claim.hpp"
#include "verification/claims/orbit_scenes.hpp"
#include "verification/references/orbits.hpp"
#include "verification/references/two_mass_oscillator.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

constexpr double eight_digits = 1e-8;
const char* const required = "required: eight digits; tolerance 1e-12 per step";
const char* const enough_digits = "required: eight digits; tolerance 1e-10 per step";

struct BranchCase {
  Findings& f;
  std::string subject;
  Branches found;

  std::string name(const std::string& quantity) const {
    return claim_name(subject, quantity, "event-driven");
  }
  std::vector<const Bifurcation*> of(BifurcationKind kind, int branch) const {
    std::vector<const Bifurcation*> list;
    for (const auto& b : found.bifurcations)
      if (b.kind == kind && b.at.branch == branch) list.push_back(&b);
    return list;
  }
  /// The only bifurcation of its kind on a branch; null if there are none or several.
  const Bifurcation* only(BifurcationKind kind, const std::string& source, int branch = 1) const {
    const auto list = of(kind, branch);
    f.within(name(fmt::format("number of bifurcations of kind {}",
                              bifurcation_names[static_cast<std::size_t>(kind)])),
             "", static_cast<double>(list.size()), 1, 0, source, "counted");
    return list.size() == 1 ? list.front() : nullptr;
  }
  void expect(const Bifurcation* b, const std::string& quantity, const char* unit, long double value,
              const std::string& source, double bound = eight_digits, const char* why = required) const {
    f.relative(name(quantity), unit, b ? b->at.parameter : NAN, static_cast<double>(value), bound, source,
               why);
  }
  void expect_multiplier(const Bifurcation* b, const std::string& at, double value,
                         const std::string& source) const {
    const bool has = b && !b->at.orbit.multipliers.empty();
    f.within(name("multiplier at the " + at), "", has ? b->at.orbit.multipliers.front().real() : NAN, value,
             eight_digits, source, required);
  }
  /// Multipliers of all motions of a branch against those at the same value of the key.
  template <class Expected>
  void expect_path(int branch, Expected expected, const std::string& quantity, double bound,
                   const std::string& source, const char* why) const {
    double worst = found.points.empty() ? NAN : 0;
    for (const auto& p : found.points) {
      if (p.branch != branch) continue;
      const double value = expected(p);
      worst = std::isfinite(value) ? std::max(worst, value) : NAN;
    }
    f.at_most(name(quantity), "", worst, bound, source, why);
  }
};

void shaken_ball(Findings& f, const char* subject, const reference::ShakenBall& ball) {
  const std::string source = "flight and impact in closed form";
  const auto scene = parse_scene(scenes::shaken_ball(ball, 1e-4L), "ball");
  const auto request = [&](long double to) {
    return ContinuationRequest{.key = "curves.shake.amplitude",
                               .from = static_cast<double>(ball.amplitude),
                               .to = static_cast<double>(to),
                               .periods = ball.number,
                               .settle = 0};
  };
  // Downwards round the fold and back to the start on the unstable side.
  const BranchCase down{f, fmt::format("{}, amplitude lowered", subject),
                        continue_orbit(scene, request(ball.fold() * 0.9L))};
  const auto* fold = down.only(BifurcationKind::fold, source);
  down.expect(fold, "amplitude of the fold", "m", ball.fold(), source);
  down.expect_multiplier(fold, "fold", 1, source);
  down.expect_path(
      1,
      [&](const BranchPoint& p) {
        auto same = ball;
        same.amplitude = p.parameter;
        same.rising = fold && p.number < fold->at.number;
        if (p.orbit.multipliers.size() != 2) return static_cast<double>(NAN);
        const auto sum = p.orbit.multipliers[0] + p.orbit.multipliers[1];
        return std::abs(sum.real() - static_cast<double>(same.trace()));
      },
      "greatest error of the sum of multipliers along the branch", 1e-6, source,
      "1e-8 of the map, which next to the fold depends on the root of the distance to it");
  const BranchCase up{f, fmt::format("{}, amplitude raised", subject),
                      continue_orbit(scene, request(ball.flip() * 1.1L))};
  const auto* flip = up.only(BifurcationKind::flip, source);
  up.expect(flip, "amplitude of the period doubling", "m", ball.flip(), source);
  up.expect_multiplier(flip, "period doubling", -1, source);
  const auto doubled = std::ranges::find(up.found.points, 2, &BranchPoint::branch);
  const bool has = doubled != up.found.points.end();
  f.within(up.name("periods of the branch that begins at the period doubling"), "",
           has ? static_cast<double>(doubled->orbit.periods) : NAN, 2 * ball.number, 0, "definition",
           "counted");
  f.within(up.name("stability of the first motion of doubled period"), "", has ? doubled->orbit.stable : NAN,
           1, 0, "the bifurcation is supercritical: the attractors of the sweep double there", "yes or no");
}

void ball_each_period(Findings& f) {
  shaken_ball(f, "ball on a shaken table, e = 0.5", {0.0032L, 20 * reference::ShakenBall::pi(), 9.81L, 0.5L});
}
void ball_each_second_period(Findings& f) {
  shaken_ball(f, "ball that meets a shaken table in each second period, e = 0.6",
              {0.0043L, 20 * reference::ShakenBall::pi(), 9.81L, 0.6L, 2});
}

void impact_oscillator(Findings& f) {
  const std::string source = "linear oscillation with two matching conditions";
  const reference::ImpactOscillator o{0.5L, 1, 200, 6, 30, 0.02L, 0.7L};
  long double impact = 0;
  const auto scene = parse_scene(scenes::impact_oscillator(o, impact), "oscillator");
  const BranchCase c{
      f, "oscillator with a stop at 20 mm, 30 rad/s, force lowered",
      continue_orbit(scene, {.key = "curves.force.amplitude", .from = 6, .to = 0.5, .settle = 0})};
  const auto* fold = c.only(BifurcationKind::fold, source);
  c.expect(fold, "force of the fold", "N", o.fold(), source);
  c.expect_multiplier(fold, "fold", 1, source);
  const auto* grazing = c.only(BifurcationKind::grazing, source);
  c.expect(grazing, "force of the grazing impact", "N", o.grazing(), source, 1e-7,
           "extrapolated from approach speeds of 1e-3 of the greatest speed");
  const bool without = grazing && grazing->new_branch > 0;
  f.within(c.name("branch without impact begins there"), "", without ? 1 : 0, 1, 0, source, "yes or no");
  c.expect_path(
      without ? grazing->new_branch : 0,
      [](const BranchPoint& p) { return static_cast<double>(p.orbit.impacts.size()); },
      "impacts on the branch after the grazing impact", 0, source, "counted");

  // Raised from a motion without impact: it begins to touch the stop, where the branch with impact
  // turns back to the same fold.
  const BranchCase r{
      f, "oscillator with a stop at 20 mm, 30 rad/s, force raised",
      continue_orbit(scene, {.key = "curves.force.amplitude", .from = 1, .to = 6, .settle = 20})};
  const auto* touch = r.only(BifurcationKind::grazing, source);
  r.expect(touch, "force at which the motion begins to touch", "N", o.grazing(), source, 1e-7,
           "steps are halved to 2e-10 of the range, and impacts are resolved from penetrations of 1e-6 m on");
  const int next = touch ? touch->new_branch : 0;
  const auto* turn = r.only(BifurcationKind::fold, source, next);
  r.expect(turn, "force of the fold on the branch that begins there", "N", o.fold(), source);
}

void liftoffs(Findings& f) {
  const std::string source = "forced linear oscillation in closed form";
  for (const auto& one :
       {std::pair<const char*, reference::LoadedTable>{"body on a shaken table", {60, 9.81L, 0.3L}},
        {"body with a sprung second one on a shaken table", {60, 9.81L, 0.3L, 0.2L, 1000, 0.8L}}}) {
    const char* subject = one.first;
    const auto& table = one.second;
    const long double expected = table.liftoff();
    const BranchCase c{f, subject,
                       continue_orbit(parse_scene(scenes::loaded_table(table, 0.8L * expected), "table"),
                                      {.key = "curves.shake.amplitude",
                                       .from = static_cast<double>(0.8L * expected),
                                       .to = static_cast<double>(1.2L * expected),
                                       .step = static_cast<double>(0.2L * expected),
                                       .settle = 0})};
    const auto* liftoff = c.only(BifurcationKind::liftoff, source);
    c.expect(liftoff, "amplitude at which the contact lifts off", "m", expected, source);
    // The least force falls linearly with the amplitude.
    c.expect_path(
        1,
        [&](const BranchPoint& p) {
          const auto weight = static_cast<double>((table.mass + table.upper) * table.gravity);
          const double force = weight * (1 - p.parameter / static_cast<double>(expected));
          return p.orbit.lasting.size() == 1 ? std::abs(p.orbit.lasting[0].least_force - force) / weight
                                             : NAN;
        },
        "greatest error of the least force over the weight along the branch", eight_digits, source, required);
    if (table.upper > 0 && liftoff) {
      const auto exact = std::complex<double>(table.multiplier());
      const auto& found = liftoff->at.orbit.multipliers;
      f.within(c.name("distance of the multiplier from the oscillator's"), "",
               found.size() == 2 ? std::abs(std::complex<double>(found[0].real(), std::abs(found[0].imag())) -
                                            std::complex<double>(exact.real(), std::abs(exact.imag())))
                                 : NAN,
               0, eight_digits, source, required);
    }
  }
}

/// Greatest relative error of the first key along the only curve of a kind; NaN if there is not exactly one.
template <class Expected>
double curve_error(const Branches& found, BifurcationKind kind, std::size_t fewest, Expected expected) {
  if (found.curves.size() != 1 || found.curve_points.size() < fewest) return NAN;
  double worst = 0;
  for (const auto& p : found.curve_points) {
    if (p.kind != kind) return NAN;
    const auto value = static_cast<double>(expected(p.second));
    worst = greatest(worst, std::abs(p.parameter / value - 1));
  }
  return worst;
}

void curves(Findings& f) {
  const reference::ShakenBall ball{0.0032L, 20 * reference::ShakenBall::pi(), 9.81L, 0.5L};
  const auto with = [&](double e) {
    auto same = ball;
    same.restitution = e;
    return same;
  };
  const std::vector<std::string> enough{"nonsmooth.tolerance=1e-10"};
  // From a motion beside the bifurcation at e = 0.5 over it, then along the curve.
  const auto branch = [&](long double at, long double side, BifurcationKind kind) {
    auto near = ball;
    near.amplitude = (1 + 0.02L * side) * at;
    return continue_orbit(parse_scene(scenes::shaken_ball(near, 1e-6L), "ball", enough),
                          {.key = "curves.shake.amplitude",
                           .from = static_cast<double>(near.amplitude),
                           .to = static_cast<double>((1 - 0.02L * side) * at),
                           .settle = 0,
                           .follow_doubled = 0,
                           .second = SecondKey{"surfaces.hard.restitution", 0.5, 0.52, 0.02, {kind}}});
  };
  const std::string source = "flight and impact in closed form";
  f.at_most(
      "ball on a shaken table: greatest relative error of the amplitude of the fold, restitution 0.5 to 0.52 "
      "[event-driven]",
      "",
      curve_error(branch(ball.fold(), 1, BifurcationKind::fold), BifurcationKind::fold, 4,
                  [&](double e) { return with(e).fold(); }),
      eight_digits, source, enough_digits);
  f.at_most(
      "ball on a shaken table: greatest relative error of the amplitude of the period doubling, restitution "
      "0.5 to 0.52 [event-driven]",
      "",
      curve_error(branch(ball.flip(), -1, BifurcationKind::flip), BifurcationKind::flip, 4,
                  [&](double e) { return with(e).flip(); }),
      eight_digits, source, enough_digits);
  const reference::LoadedTable table{60, 9.81L, 0.3L, 0.2L, 1000, 0.8L};
  const auto loaded = [&](double period) {
    auto same = table;
    same.frequency = 2 * reference::LoadedTable::pi() / period;
    return same;
  };
  const double period = static_cast<double>(table.period());
  f.at_most(
      "body with a sprung second one on a shaken table: greatest relative error of the amplitude at "
      "which the "
      "contact lifts off, period raised by 5 % [event-driven]",
      "",
      curve_error(continue_orbit(
                      parse_scene(scenes::loaded_table(table, 0.9L * table.liftoff()), "table", enough),
                      {.key = "curves.shake.amplitude",
                       .from = static_cast<double>(0.9L * table.liftoff()),
                       .to = static_cast<double>(1.6L * table.liftoff()),
                       .step = static_cast<double>(0.2L * table.liftoff()),
                       .settle = 0,
                       .second = SecondKey{"curves.shake.period", period, 1.05 * period, 0.05 * period, {}}}),
                  BifurcationKind::liftoff, 4, [&](double T) { return loaded(T).liftoff(); }),
      eight_digits, "forced linear oscillation in closed form", enough_digits);
}

/// Curves of grazing impacts, from a branch whose impact becomes slow, and from one that begins to
/// touch the stop.
void grazing_curves(Findings& f) {
  const reference::ImpactOscillator o{0.5L, 1, 200, 4.9L, 30, 0.02L, 0.7L, 1, false};
  const auto period = static_cast<double>(o.period());
  long double impact = 0;
  const auto text = scenes::impact_oscillator(o, impact);
  const std::string tolerance = "nonsmooth.tolerance=1e-10";
  // The steady oscillation without impacts, F/(k - m w² + i c w), at the start of the scene.
  const auto steady =
      static_cast<double>(o.force) /
      std::complex<double>(static_cast<double>(o.stiffness - o.mass * o.frequency * o.frequency),
                           static_cast<double>(o.damping * o.frequency));
  const std::vector<std::string> without{
      tolerance, fmt::format("bodies.mass.position=[{:.17g}, 0]", steady.imag()),
      fmt::format("bodies.mass.velocity=[{:.17g}, 0]", static_cast<double>(o.frequency) * steady.real())};
  for (const auto& [subject, options] :
       {std::pair("with impact", std::vector{tolerance}), std::pair("without impact", without)})
    f.at_most(
        fmt::format("oscillator with a stop, from a motion {}: greatest relative error of the force of the "
                    "grazing impact, period raised by 1 % [event-driven]",
                    subject),
        "",
        curve_error(continue_orbit(parse_scene(text, "oscillator", options),
                                   {.key = "curves.force.amplitude",
                                    .from = static_cast<double>(o.force),
                                    .to = 5.06,
                                    .step = 0.01,
                                    .settle = 0,
                                    .second = SecondKey{"curves.force.period",
                                                        period,
                                                        1.01 * period,
                                                        0.01 * period,
                                                        {BifurcationKind::grazing}}}),
                    BifurcationKind::grazing, 4,
                    [&](double T) {
                      auto other = o;
                      other.frequency = 2 * reference::LoadedTable::pi() / T;
                      return other.grazing();
                    }),
        1e-7, "steady oscillation of the amplitude of the stop",
        "extrapolated by polynomials with errors of the order of 1e-8");
}

void torus(Findings& f) {
  const std::string source = "matrix exponential, and Hurwitz's condition for the characteristic polynomial";
  const reference::TwoMassOscillator o{1, 3, 2, 2, 0.2L, 0.2L, 1, 1.7135L, 0.742L};
  const BranchCase c{f, "two masses with a stop, restitution raised",
                     continue_orbit(parse_scene(scenes::two_mass_oscillator(o), "masses"),
                                    {.key = "surfaces.hard.restitution",
                                     .from = static_cast<double>(o.restitution),
                                     .to = 0.755,
                                     .step = 0.01,
                                     .settle = 0})};
  const auto* torus = c.only(BifurcationKind::torus, source);
  c.expect(torus, "restitution at which a torus begins", "", o.torus(0.7L, 0.8L), source);
  const bool has = torus && !torus->at.orbit.multipliers.empty();
  f.within(c.name("modulus of the multiplier at the torus"), "",
           has ? std::abs(torus->at.orbit.multipliers.front()) : NAN, 1, eight_digits, source, required);
  // Coefficients of the characteristic polynomial of all multipliers.
  c.expect_path(
      1,
      [&](const BranchPoint& p) {
        auto same = o;
        same.restitution = p.parameter;
        const auto expected = same.motion().polynomial;
        std::array<std::complex<double>, 5> found{1};
        for (const auto& x : p.orbit.multipliers)
          for (std::size_t i = 4; i > 0; --i) found[i] -= x * found[i - 1];
        double worst = p.orbit.multipliers.size() == 4 ? 0 : NAN;
        for (std::size_t i = 1; i < 5; ++i)
          worst = std::max(worst, std::abs(found[i] - static_cast<double>(expected[i])));
        return worst;
      },
      "greatest error of the characteristic polynomial along the branch", eight_digits, source, required);
  const auto period = static_cast<double>(o.period());
  f.at_most(
      "two masses with a stop: greatest relative error of the restitution at which a torus begins, "
      "period raised "
      "by 0.2 % [event-driven]",
      "",
      curve_error(
          continue_orbit(
              parse_scene(scenes::two_mass_oscillator(o), "masses", {"nonsmooth.tolerance=1e-10"}),
              {.key = "surfaces.hard.restitution",
               .from = static_cast<double>(o.restitution),
               .to = 0.755,
               .step = 0.01,
               .settle = 0,
               .second = SecondKey{"curves.force.period", period, 1.002 * period, 0.002 * period, {}}}),
          BifurcationKind::torus, 4,
          [&](double T) {
            auto other = o;
            other.frequency = 2 * reference::TwoMassOscillator::pi() / T;
            return other.torus(0.7L, 0.8L);
          }),
      eight_digits, source, enough_digits);
}

}  // namespace

Parts branches() {
  return {
      {ball_each_period, 9}, {ball_each_second_period, 9}, {impact_oscillator, 11}, {liftoffs, 7}, {torus, 5},
      {curves, 3},           {grazing_curves, 2}};
}

}  // namespace freeplay::verification
