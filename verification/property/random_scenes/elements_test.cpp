// Random scenes of single elements: their references against closed forms, and scenes by every method.
#include "verification/random_scenes/checks/checks.hpp"
#include "verification/random_scenes/runner.hpp"
#include "verification/references/disc_on_outline.hpp"
#include "verification/references/dry_coordinate.hpp"
#include "verification/references/profiled_journal.hpp"
#include "verification/references/ring_and_journal.hpp"
#include "verification/references/sampled_loop.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using namespace freeplay::verification::random_scenes;
namespace reference = freeplay::reference;

namespace {

const std::vector<std::string> element_kinds{"ratio-trains", "freewheels", "stribeck", "mesh-losses",
                                             "outlines",     "sampled",    "yielding", "profiles"};

/// Scenes of one kind by every method: none is wrong without a warning, none crashes, and at most a
/// twentieth of the runs has another defect (refused, falsely doubted or slow).
void check_scenes(const std::string& kind, int count) {
  std::vector<Row> rows;
  if (count > 5) {  // on all cores
    const test::TemporaryFolder folder;
    rows = judge_all({.seed = 69, .count = count, .kinds = kind}, folder.path(), {});
  }
  for (int i = 0; i < count && count <= 5; ++i) {
    const auto scene = draw(69, i, kind);
    std::vector<const Way*> by;
    for (const auto& way : ways(Suite::rows))
      if (has_model(scene, way)) by.push_back(&way);
    std::size_t n = 0;
    assess(scene, by, [&](const Verdict& v) { rows.push_back({i, scene.kind, by[n++]->name, v}); });
  }
  std::size_t runs = 0;
  for (int i = 0; i < count; ++i)
    runs += static_cast<std::size_t>(std::ranges::count_if(
        ways(Suite::rows), [scene = draw(69, i, kind)](const Way& way) { return has_model(scene, way); }));
  CHECK(rows.size() == runs);
  CHECK(runs >= 4 * static_cast<std::size_t>(count));  // the nonsmooth schemes have a model of each scene
  std::size_t defects = 0, known = 0;
  for (const auto& r : rows) {
    INFO(r.index << " (" << r.kind << ", " << r.way << "): " << r.verdict.detail);
    CHECK(r.verdict.outcome < Outcome::silent);
    defects += is_defect(r.verdict.outcome, Suite::rows);
    known += r.way == "event-driven" && r.verdict.known > 0.999;
  }
  CAPTURE(kind, defects, known, rows.size());
  CHECK(static_cast<double>(defects) <= 0.05 * static_cast<double>(rows.size()));
  // References end where the motion no longer depends on its start: balls on moved tables.
  CHECK(5 * known >= static_cast<std::size_t>(count));
}

using OutlinePoint = reference::DiscOnOutline::Point;
double apart(const OutlinePoint& a, const OutlinePoint& b) { return std::hypot(a.x - b.x, a.y - b.y); }

}  // namespace

// ẋ = w at rest on the support, x = F t²/2 beyond the static bound: a = 3 t passes the bound 2 at t = 2/3;
// then ẍ = 3 t − 1 against the sliding bound 1, ẋ = 3/2 (t² − t₀²) − (t − t₀).
TEST_CASE("reference integrator: dry friction holds up to its static bound", "[random-scenes]") {
  reference::DryCoordinate one;
  one.acceleration = [](int side, double t, double, double v) { return 3 * t - side * (v == 0 ? 2.0 : 1.0); };
  one.step = 1e-3;
  const double t0 = 2.0 / 3, t = 1.5;
  const auto rows = one.at({0.6, t});
  REQUIRE(rows.known == 2);
  CHECK(rows.x[0] == 0);
  // Linear accelerations are exact in the Runge–Kutta method, but for the first stage after the start of
  // slip, which has the static bound: h/6 (2 − 1) of one step.
  CHECK(std::abs(rows.v[1] - (1.5 * (t * t - t0 * t0) - (t - t0))) < 2e-4);
}

// A rotor at 1 rad/s on a freewheel with the capacity 2, under −1: it overruns, θ̈ = −1, up to rest at 1 s, and
// is held; with the capacity 1/2 it slips from there with θ̈ = −1/2.
TEST_CASE("reference integrator: friction with a bound in one direction holds or slips", "[random-scenes]") {
  for (const double capacity : {2.0, 0.5}) {
    reference::DryCoordinate one;
    one.acceleration = [capacity](int side, double, double, double) { return side > 0 ? -1 : -1 + capacity; };
    one.v = 1, one.step = 0.3;
    const auto rows = one.at({0.5, 3});
    REQUIRE(rows.known == 2);
    // Constant accelerations are exact; the instant of rest is bisected to rounding.
    CHECK(std::abs(rows.x[0] - 0.375) < 1e-12);
    CHECK(std::abs(rows.x[1] - (capacity > 1 ? 0.5 : 0.5 - 0.25 * 4)) < 1e-12);
    CHECK(std::abs(rows.v[1] + (capacity > 1 ? 0 : 1.0)) < 1e-12);
  }
}

// A square of side 2 with rounded corners (r = 0.1), a disc of radius 0.2: on the right face g = x − 1.2; on the
// corner (0.9, 0.9) at 45° g = |p − c| − 0.3, and a head-on impact reverses the velocity, times e.
TEST_CASE("reference of a disc on an outline: face and corner", "[random-scenes]") {
  reference::DiscOnOutline one;
  one.centres = {{-0.9, -0.9}, {0.9, -0.9}, {0.9, 0.9}, {-0.9, 0.9}};
  one.reach = 0.3, one.restitution = 0.5, one.step = 1e-2;
  one.at = {2.2, 0.3}, one.velocity = {-1, 0.1};
  auto rows = one.rows({1.5});
  REQUIRE(rows.p.size() == 1);
  CHECK(std::abs(rows.onsets[0] - 1) < 1e-12);
  CHECK(apart(rows.p[0], {1.2 + 0.25, 0.45}) < 1e-12);
  const double s = std::sqrt(0.5);
  one.at = {0.9 + 1.3 * s, 0.9 + 1.3 * s}, one.velocity = {-s, -s};
  rows = one.rows({2});
  REQUIRE(rows.p.size() == 1);
  CHECK(apart(rows.v[0], {0.5 * s, 0.5 * s}) < 1e-12);
  // A compliant contact delivers the same restitution: of fourth order in some hundred steps.
  one.stiffness = 1e4, one.step_in_contact = 1e-4;
  rows = one.rows({2});
  REQUIRE(rows.p.size() == 1);
  CHECK(apart(rows.v[0], {0.5 * s, 0.5 * s}) < 1e-6);
}

// Proportional control of a mass, m = k_p = 1, with h = 1 from x = 1: u = −x_k over each second,
// x_{k+1} = x_k/2 + v_k, v_{k+1} = v_k − x_k; with a dead time of one half, u acts from t_k + 1/2 on.
TEST_CASE("reference of a sampled loop: zero-order hold and dead time by hand", "[random-scenes]") {
  reference::SampledLoop loop;
  loop.x = 1;
  loop.target = [](double) { return 0.0; };
  auto rows = loop.at({1, 2, 2.5});
  CHECK(rows.x == std::vector<double>{0.5, -0.75, -1.40625});  // v: −1, −1.5, −1.125
  CHECK(rows.v == std::vector<double>{-1, -1.5, -1.125});
  loop.dead = 0.5;
  rows = loop.at({0.5, 1, 1.5});
  CHECK(rows.x == std::vector<double>{1, 0.875, 0.5});
  CHECK(rows.v == std::vector<double>{0, -0.5, -1});
}

// The periodic spline through 36 points of a cosine, between them: 5/384 p″″ h⁴ = 5/384 · 16 (2π/36)⁴ = 1.9e-4, the
// slope h³/24 · 16, the second derivative h²/12 · 16 of the cosine's amplitude.
TEST_CASE("reference of a surface: a periodic spline through points of a harmonic", "[random-scenes]") {
  std::vector<std::pair<double, double>> points;
  const double h = 2 * M_PI / 36;
  for (int k = 0; k < 36; ++k) points.emplace_back(0.3 + h * k, std::cos(2 * (0.3 + h * k)));
  const reference::SurfaceDeviation spline({}, points), series({{2, 1, 0}});
  for (int k = 0; k < 1000; ++k) {
    const double phi = -7 + 0.02 * k;
    CAPTURE(phi);
    CHECK(spline.at(phi).p == Approx(series.at(phi).p).margin(2e-4));
    CHECK(spline.at(phi).slope == Approx(series.at(phi).slope).margin(16 * h * h * h / 24));
    CHECK(spline.at(phi).bend == Approx(series.at(phi).bend).margin(16 * h * h / 12));
  }
}

// Round surfaces: five impacts by the closed form of two free bodies.
TEST_CASE("reference of a profiled journal: round surfaces as a ring and a journal", "[random-scenes]") {
  const reference::RingAndJournal pair{3, 2, 1e-3, 0.8};
  reference::PairState state{0, {0, 0}, {2e-4, 1e-4}, {0.01, 0.02}, {0.3, -0.1}};
  reference::ProfiledJournal one;
  one.clearance = pair.clearance, one.radius = 0.02, one.restitution = pair.restitution, one.step = 1e-4;
  one.inverse = {1.0 / 3, 1.0 / 3, 1e3, 0.5, 0.5, 1e4};
  one.start = {0, {0, 0, 0, 2e-4, 1e-4, 0}, {0.01, 0.02, 5, 0.3, -0.1, -4}};
  std::vector<double> onsets;
  for (int k = 0; k < 5; ++k) {
    state = reference::after_flight(
        state, *reference::time_to_contact(state.eccentricity(), state.rate(), pair.clearance));
    onsets.push_back(state.t);
    state = reference::pair_impact(pair, state).after;
  }
  const auto found = one.rows({state.t + 1e-5});
  REQUIRE(found.onsets.size() == 5);
  // The gap is located to 1e-12 of the clearance.
  for (std::size_t k = 0; k < 5; ++k) CHECK(found.onsets[k] == Approx(onsets[k]).epsilon(1e-9));
  for (const std::size_t i : {0, 1}) {
    CHECK(found.states[0].v[i] == Approx(state.bearing_velocity[i]).margin(1e-9));
    CHECK(found.states[0].v[3 + i] == Approx(state.journal_velocity[i]).margin(1e-9));
  }
  CHECK(found.states[0].v[5] == -4);
}

// A journal with spin that slides around a round bearing without gravity: normal force m u²/c with the speed u of
// its centre, u̇ = −s μ u²/c and J ω̇ = −s μ m R_j u²/c with the sense s of v_T = u + R_j ω, up to v_T = 0.
TEST_CASE("reference of a profiled journal: slip that ends in rolling", "[random-scenes]") {
  const double c = 1e-3, R = 0.02, m = 2, J = 4e-4, mu = 0.1, u0 = 0.1, Rj = R - c;
  reference::ProfiledJournal one;
  one.clearance = c, one.radius = R, one.restitution = 0, one.friction = mu, one.rest = 1e-9;
  one.inverse = {0, 0, 0, 1 / m, 1 / m, 1 / J};
  // At the right, upwards, pressed outwards by its own motion: v_T = u0 > 0.
  one.start = {0, {0, 0, 0, c * (1 - 1e-13), 0, 0}, {0, 0, 0, 0, u0, 0}};
  one.step = 1e-5;
  // u decreases to u₁ and ω to −u₁/R_j: u₀ − u₁ = (J/m R_j) |ω| gives u₁ = u₀/(1 + J/(m R_j²)).
  const double u1 = u0 / (1 + J / (m * Rj * Rj)), slides = c / mu * (1 / u1 - 1 / u0);
  const auto found = one.rows({0.5 * slides, 3 * slides});
  REQUIRE(found.states.size() == 2);
  CHECK(found.lasting);
  const auto speed = [&](std::size_t k) { return std::hypot(found.states[k].v[3], found.states[k].v[4]); };
  CHECK(speed(0) == Approx(1 / (1 / u0 + mu * 0.5 * slides / c)).epsilon(1e-6));
  CHECK(speed(1) == Approx(u1).epsilon(1e-6));
  CHECK(found.states[1].v[5] == Approx(-u1 / Rj).epsilon(1e-6));
}

TEST_CASE("reference of a profiled journal: velocities are the rates of the gap", "[random-scenes]") {
  reference::ProfiledJournal one;
  one.bearing = reference::SurfaceDeviation({{2, 1e-4, 5e-5}, {3, 2e-5, 0}});
  one.journal = reference::SurfaceDeviation({{4, 0, 1e-5}});
  one.clearance = 1e-3, one.radius = 0.02;
  one.arms = {{{1e-3, 2e-3}, {-2e-3, 1e-3}}};
  one.tabulate();
  const reference::ProfiledJournal::Six q{1e-4, 0, 0.4, 2.5e-3, 2e-3, 1.3}, v{0.1, -0.2, 3, 0.05, 0.1, -4};
  const auto moved = [&](double t) {
    auto x = q;
    for (std::size_t i = 0; i < 6; ++i) x[i] += t * v[i];
    return one.place(x).gap;
  };
  const double h = 1e-6;
  // h²/6 of the third derivative, some c (v/c)³ = 1e4 m/s³; rounding 1e-16/h
  CHECK(one.times(one.place(q).normal, v) == Approx((moved(h) - moved(-h)) / (2 * h)).margin(1e-8));
}

TEST_CASE("kinds of single elements are drawn by their selection alone", "[random-scenes]") {
  std::set<std::string> seen;
  std::string all;
  for (int i = 0; i < 500; ++i) {
    const auto drawn = draw(1, i, "elements");
    CAPTURE(i, drawn.text);
    seen.insert(drawn.kind);
    all += drawn.text;
    CHECK_NOTHROW(parse_scene(drawn.text, "random scene"));
    CHECK(std::ranges::find(element_kinds, draw(1, i, "new").kind) == element_kinds.end());
  }
  CHECK(seen == std::set<std::string>(element_kinds.begin(), element_kinds.end()));
  for (const char* word : {"\"ratio\"",           "\"elastic-ratio\"", "backlash",
                           "\"freewheel\"",       "\"backward\"",      "static_force",
                           "static_torque",       "stribeck_exponent", "back_efficiency",
                           "lead_angle",          "internal = true",   "\"outline\"",
                           "corner_radius = 0\n", "\nradius = 0\n",    "dead_time",
                           "resolution",          "tracking_time",     "lag",
                           "yield_speed",         "restitution_table", "bearing_profile",
                           "journal_profile",     "harmonics",         "points = [[-"}) {
    CAPTURE(word);
    CHECK(all.find(word) != all.npos);
  }
}

TEST_CASE("random scenes of single elements are correct in every method", "[random-scenes]") {
  for (const auto& kind : element_kinds) check_scenes(kind, 5);
}

TEST_CASE("random scenes on surfaces with a static value of friction are correct in every method",
          "[random-scenes]") {
  for (int i = 0; i < 100; ++i) CHECK_NOTHROW(parse_scene(draw(1, i, "surfaces").text, "random scene"));
  check_scenes("gripping", 5);
}

TEST_CASE("two hundred random scenes of each element are correct in every method", "[random-scenes][long]") {
  for (const auto& kind : element_kinds) check_scenes(kind, 200);
  check_scenes("gripping", 200);
}
