// Random scenes of single elements: their references against closed forms, and scenes by every method.
#include "verification/random_scenes/checks/checks.hpp"
#include "verification/random_scenes/runner.hpp"
#include "verification/references/disc_on_outline.hpp"
#include "verification/references/dry_coordinate.hpp"
#include "verification/references/sampled_loop.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using namespace freeplay::verification::random_scenes;
namespace reference = freeplay::reference;

namespace {

const std::vector<std::string> element_kinds{"ratio-trains", "freewheels", "stribeck", "mesh-losses",
                                             "outlines",     "sampled",    "yielding"};

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
  CHECK(rows.size() == static_cast<std::size_t>(count) * ways(Suite::rows).size());
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
                           "yield_speed",         "restitution_table"}) {
    CAPTURE(word);
    CHECK(all.find(word) != all.npos);
  }
}

TEST_CASE("random scenes of single elements are correct in every method", "[random-scenes]") {
  for (const auto& kind : element_kinds) check_scenes(kind, 5);
}

TEST_CASE("two hundred random scenes of each element are correct in every method", "[random-scenes][long]") {
  for (const auto& kind : element_kinds) check_scenes(kind, 200);
}
