// Bodies that touch without load: columns, rows and grids of beads in flight, whose gaps and gap
// rates are zero to rounding. The sign of the rounding error must not decide the motion: the same
// scene from another height, rotated, in other units and in another order moves alike.
#include <numeric>
#include <span>

#include "verification/property/comparison/snapshot_check.hpp"
#include "verification/references/touching_row.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using test::notes_of;

namespace {

constexpr double g = 9.81, mass = 0.1, young = 207e9, poisson = 0.3;

/// Columns of beads of radius 5 mm times `scale`, side by side, each touching its neighbours; their
/// lowest points are `drop` above a floor, up is at `angle` from the y axis. Lengths and times
/// scale so that gravity is unchanged; so does Young's modulus, so that indentations scale as well.
struct Beads {
  int rows = 10, columns = 1;
  // m, rad, s: at scale 1
  double drop = 0.051, restitution = 1, angle = 0, scale = 1, duration = 1;
  // m/s, of row 0 alone, upwards
  double speed = 0;
  // m, between rows 0 and 1
  double apart = 0;
  bool floor = true, weight = true, reversed = false;

  double radius() const { return 0.005 * scale; }
  double time() const { return std::sqrt(scale); }
  Vec2 up() const { return {-std::sin(angle), std::cos(angle)}; }
  Vec2 place(int row, int column) const {
    const Vec2 along{std::cos(angle), std::sin(angle)};
    return (scale * drop + radius() * (1 + 2 * row) + (row > 0 ? scale * apart : 0)) * up() +
           2 * radius() * column * along;
  }
  std::string text() const {
    const auto up = this->up();
    std::string s =
        fmt::format("gravity = [{:.17g}, {:.17g}]\n", weight ? -g * up.x() : 0.0, weight ? -g * up.y() : 0.0);
    std::vector<int> order(static_cast<std::size_t>(rows * columns));
    std::iota(order.begin(), order.end(), 0);
    if (reversed) std::ranges::reverse(order);
    const auto contact = [&](char kind, int a, int b) {
      return test::discs(fmt::format("{}{}", kind, b), fmt::format("b{}", a), fmt::format("b{}", b), radius(),
                         radius());
    };
    const double m = mass * scale * scale * scale;
    for (const int k : order) {
      const int row = k / columns, column = k % columns;
      const Vec2 at = place(row, column), v = (row == 0 ? speed * time() : 0.0) * up;
      s +=
          test::body(fmt::format("b{}", k), m, 0.4 * m * radius() * radius(),
                     fmt::format("position = [{}, {}]\nvelocity = [{}, {}]\n", at.x(), at.y(), v.x(), v.y()));
    }
    for (const int k : order) {
      const int row = k / columns, column = k % columns;
      if (row == 0 && floor)
        s += test::plane(fmt::format("f{}", k), "ground", fmt::format("b{}", k), radius(), "s",
                         fmt::format("axis = [{:.17g}, {:.17g}]\n", up.y(), -up.x()));
      if (row > 0) s += contact('c', k - columns, k);
      if (column > 0) s += contact('h', k - 1, k);
    }
    return s +
           test::surface("s", restitution,
                         fmt::format("young = {:.17g}\npoisson = {}\n", young * scale, poisson)) +
           test::run_for(duration * time(), "start = \"given\"\n");
  }
  Scene scene() const { return parse_scene(text(), "beads.toml"); }
  /// Displacement and velocity upwards of bead k, in the units of scale 1.
  double height(const State& state, int k) const {
    const auto i = 3 * static_cast<std::size_t>(reversed ? rows * columns - 1 - k : k);
    const Vec2 at = place(k / columns, k % columns);
    return ((state.q[i] - at.x()) * up().x() + (state.q[i + 1] - at.y()) * up().y()) / scale;
  }
  double rise(const State& state, int k) const {
    const auto i = 3 * static_cast<std::size_t>(reversed ? rows * columns - 1 - k : k);
    return (state.v[i] * up().x() + state.v[i + 1] * up().y()) / time();
  }
};

Result run(const Beads& beads, Scheme scheme, ImpactLaw law = ImpactLaw::newton) {
  auto scene = beads.scene();
  scene.nonsmooth.scheme = scheme;
  scene.nonsmooth.impact_law = law;
  if (scheme == Scheme::moreau_jean) scene.nonsmooth.step = 1e-5 * beads.time();
  return test::finished(scene, Family::nonsmooth);
}

/// All beads move as a single ball.
void check_column(const Beads& beads, const Result& run, double height, double speed) {
  const auto expected = reference::elastic_column(beads.drop, g, beads.duration);
  for (int k = 0; k < beads.rows * beads.columns; ++k) {
    CAPTURE(k);
    CHECK(beads.height(run.final_state, k) == Approx(expected.height - beads.drop).margin(height).epsilon(0));
    CHECK(beads.rise(run.final_state, k) == Approx(expected.speed).margin(speed).epsilon(0));
  }
}

// A flight is a parabola, which the integrator reproduces exactly; an impact is located to rounding
// of its gap, some 1e-16 m, and of its time. Five impacts, each displaced by 1e-15 s at 1 m/s,
// cause 1e-14 m; the bound is a thousand times that.
constexpr double near = 1e-11;

}  // namespace

TEST_CASE("a column of touching beads bounces as one body from any height",
          "[cross][event-driven][unloaded]") {
  for (const auto scheme : {Scheme::event_driven, Scheme::automatic})
    for (const double drop : {0.0501, 0.051, 0.055, 0.3}) {
      const Beads beads{.drop = drop};
      CAPTURE(static_cast<int>(scheme), drop);
      const auto result = run(beads, scheme);
      check_column(beads, result, near, 10 * near);
      CHECK(result.ledger.kinetic + result.ledger.potential == Approx(result.ledger.initial).epsilon(1e-12));
      CHECK(result.extremes.gains == 0);
    }
}

TEST_CASE("a column of touching beads: rotation, other units and another order of bodies",
          "[cross][event-driven][unloaded]") {
  for (const double scale : {1e-3, 1.0, 2000.0})
    for (const double angle : {0.0, 0.5 * M_PI, M_PI, 0.3})
      for (const bool reversed : {false, true}) {
        // In an oblique column, rounding puts the centres out of line by 1e-16, and a column is not
        // stable: an impact and the flight after it multiply that by some hundreds. Two impacts
        // keep it negligible.
        const Beads beads{
            .angle = angle, .scale = scale, .duration = angle == 0.3 ? 0.5 : 1, .reversed = reversed};
        CAPTURE(scale, angle, reversed);
        check_column(beads, run(beads, Scheme::event_driven), near, 10 * near);
      }
}

TEST_CASE("a column of touching beads: the other impact laws, and time stepping", "[cross][unloaded]") {
  for (const auto law : {ImpactLaw::poisson, ImpactLaw::energetic}) {
    CAPTURE(static_cast<int>(law));
    const Beads beads;
    const auto result = run(beads, Scheme::event_driven, law);
    check_column(beads, result, near, 10 * near);
    CHECK_THAT(notes_of(result), !Contains("Poisson's hypothesis"));
  }
  // A fixed step displaces each of five impacts by up to a step, and with it the height by 2 v h.
  const Beads beads;
  check_column(beads, run(beads, Scheme::moreau_jean), 5 * 2 * 1.0 * 1e-5, 5 * 2 * g * 1e-5);
}

TEST_CASE("a grid of touching beads bounces as one body", "[cross][event-driven][unloaded]") {
  const Beads beads{.rows = 4, .columns = 3};
  check_column(beads, run(beads, Scheme::event_driven), near, 10 * near);
}

TEST_CASE("an impact of a bead on a row of touching beads involves the whole row",
          "[cross][event-driven][unloaded]") {
  for (const double angle : {0.0, 0.7, -0.5 * M_PI})
    for (const double e : {1.0, 0.5}) {
      const Beads beads{.rows = 6,
                        .restitution = e,
                        .angle = angle,
                        .duration = 0.05,
                        .speed = 0.7,
                        .apart = 0.013,
                        .floor = false,
                        .weight = false};
      CAPTURE(angle, e);
      const auto expected = reference::row_impact(5, beads.speed, e);
      const auto result = run(beads, Scheme::event_driven);
      CHECK(beads.rise(result.final_state, 0) == Approx(expected.arriving).margin(near).epsilon(0));
      for (int k = 1; k < 6; ++k)
        CHECK(beads.rise(result.final_state, k) == Approx(expected.row).margin(near).epsilon(0));
    }
}

TEST_CASE("only an impact decided by rounding of gaps is reported as such",
          "[cross][event-driven][unloaded]") {
  const auto notes = [](const Beads& beads) { return notes_of(run(beads, Scheme::event_driven)); };
  CHECK_THAT(notes({.duration = 0.3}), Contains("9 unloaded contacts") && Contains("t = 0.101968 s") &&
                                           Contains("c1") && !Contains("warning: "));
  CHECK_THAT(notes({.rows = 1, .duration = 0.3}), !Contains("unloaded"));
  CHECK_THAT(notes({.rows = 2, .duration = 0.3, .apart = 1e-6}), !Contains("unloaded"));
}

TEST_CASE("a column of touching beads continues from a snapshot bit for bit", "[snapshot][unloaded]") {
  const Beads high{.rows = 3, .duration = 0.4}, low{.rows = 3, .drop = 0.001, .duration = 0.03};
  snapshots::check({high.text() + "[nonsmooth]\nscheme = \"event-driven\"\n", "nonsmooth"});
  snapshots::check({low.text() + "[penalty]\ncontact = \"hertz\"\n", "penalty"});
}

namespace {

/// Beads with Hertz's law against the chain of one of their columns by the reference.
void check_chain(const Beads& beads, Integrator integrator) {
  CAPTURE(static_cast<int>(integrator), beads.angle, beads.scale);
  auto scene = beads.scene();
  scene.penalty.contact = ContactLaw::hertz;
  scene.penalty.integrator = integrator;
  // With fixed steps a contact of 1e-4 s has 200.
  if (integrator == Integrator::rk4) scene.penalty.step = 5e-7 * beads.time();
  const auto result = test::finished(scene, Family::penalty);
  // At scale 1, Hertz's stiffness of two spheres, or of one on a plane with R its radius.
  const auto stiffness = [](double R) {
    return 4.0 / 3 * young / (2 * (1 - poisson * poisson)) * std::sqrt(R);
  };
  const double R = 0.005;
  const auto count = static_cast<std::size_t>(beads.rows);
  reference::TouchingRow chain{.mass = std::vector(count, mass),
                               .x = {},
                               .v = std::vector(count, 0.0),
                               .reach = std::vector(count, R),
                               .floor = beads.floor,
                               .gravity = beads.weight ? g : 0,
                               .stiffness = std::vector(count - (beads.floor ? 0 : 1), stiffness(0.5 * R))};
  for (int row = 0; row < beads.rows; ++row)
    chain.x.push_back(beads.drop + R * (1 + 2 * row) + (row > 0 ? beads.apart : 0));
  chain.v[0] = beads.speed;
  if (beads.floor) chain.stiffness[0] = stiffness(R);
  const auto energy = [&](const std::vector<double>& x, const std::vector<double>& v) {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += 0.5 * mass * v[i] * v[i] + mass * chain.gravity * x[i];
    for (std::size_t c = 0; c < chain.contacts(); ++c)
      sum += 0.4 * chain.stiffness[c] * std::pow(std::max(-chain.gap(c, x), 0.0), 2.5);
    return sum;
  };
  // A contact of 1e-4 s in 500 steps: an error of (1/500)^{5/2} of its depth at its onset, 2e-7.
  const auto rows = chain.compliant({beads.duration}, 2e-7);
  const auto &x = rows.x[0], &v = rows.v[0];
  REQUIRE(energy(x, v) == Approx(energy(chain.x, chain.v)).epsilon(2e-6));
  double greatest = 0;
  for (const double speed : v) greatest = std::max(greatest, std::abs(speed));
  for (int k = 0; k < beads.rows * beads.columns; ++k) {
    const auto row = static_cast<std::size_t>(k / beads.columns);
    CAPTURE(k);
    // Tolerance 1e-9 a step, some thousand steps; successive impacts of a chain multiply an error
    // by about ten.
    CHECK(beads.rise(result.final_state, k) == Approx(v[row]).margin(1e-4 * greatest).epsilon(0));
    CHECK(beads.height(result.final_state, k) ==
          Approx(x[row] - chain.x[row]).margin(1e-4 * greatest * beads.duration).epsilon(0));
  }
  const auto& l = result.ledger;
  CHECK(l.kinetic + l.potential + l.elastic == Approx(l.initial).epsilon(1e-6));
  CHECK_THAT(notes_of(result), !Contains("free flights before them"));
}

constexpr Integrator all_integrators[] = {Integrator::rk4, Integrator::dopri5, Integrator::bulirsch_stoer,
                                          Integrator::rosenbrock4, Integrator::adams_bashforth_moulton};

}  // namespace

TEST_CASE("a column of touching elastic beads falls on a floor: Hertzian chain",
          "[cross][penalty][unloaded]") {
  for (const auto integrator : all_integrators)
    check_chain({.rows = 5, .drop = 0.001, .duration = 0.016}, integrator);
  // a hundred times as long in flight
  check_chain({.rows = 5, .drop = 0.051, .duration = 0.104}, Integrator::dopri5);
}

TEST_CASE("touching elastic beads rotated, in other units and side by side: Hertzian chain",
          "[cross][penalty][unloaded]") {
  for (const double scale : {1e-3, 2000.0})
    for (const double angle : {M_PI, 0.3})
      check_chain({.rows = 3, .drop = 0.001, .angle = angle, .scale = scale, .duration = 0.016},
                  Integrator::dopri5);
  check_chain({.rows = 3, .columns = 3, .drop = 0.001, .duration = 0.016}, Integrator::dopri5);
}

TEST_CASE("a row of touching elastic beads without weight: Hertzian chain", "[cross][penalty][unloaded]") {
  for (const double angle : {0.0, 0.5 * M_PI})
    for (const auto integrator : all_integrators)
      check_chain({.rows = 6,
                   .angle = angle,
                   .duration = 0.007,
                   .speed = 0.2,
                   .apart = 0.001,
                   .floor = false,
                   .weight = false},
                  integrator);
}

TEST_CASE("in a grid of touching elastic discs in flight, rounding opens and closes no contact",
          "[cross][penalty][unloaded]") {
  // A disc hits nine touching ones. After it has separated from them, the only forces are at
  // indentations of 1e-17 m, which once opened and closed two contacts in turn without time passing.
  auto scene = read_scene(test::scene_file("tests/disc_on_grid"));
  for (const auto integrator :
       std::span(all_integrators).subspan(1)) {  // rk4 is first: its steps are the user's
    CAPTURE(static_cast<int>(integrator));
    scene.penalty.integrator = integrator;
    CHECK_NOTHROW(test::finished(scene, Family::penalty));
  }
}
