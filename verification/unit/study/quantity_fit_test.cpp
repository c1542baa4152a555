// Calibration to quantities of one run: parameters behind times that follow from a closed form or a
// run are recovered; contradictions, a horizon and errors are reported.
#include "study/calibration/quantity_fit.hpp"

#include <Eigen/Geometry>

#include "io/scene/read_scene.hpp"
#include "verification/references/bouncing_ball.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

constexpr double restitution = 0.62, radius = 0.043;
/// The ball of verification/scenes/bouncing_ball.toml: its centre starts 0.55 m above the floor.
const reference::BouncingBall dropped{0.55 - radius, 9.81, restitution};

using test::unknown, test::StudyDesk;

/// The N-th contact event at time t (s).
std::string target(const std::string& statistic, double value, double deviation) {
  auto name = statistic;
  std::ranges::replace(name, '.', '_');
  return test::target(name, statistic, fmt::format("value = {}\ndeviation = {}\n", value, deviation));
}
std::string restitution_alone() {
  return fmt::format("scene = \"{}\"\n", test::scene_file("bouncing_ball").string()) +
         unknown("restitution", "surfaces.rubber.restitution", 0.3, 0.9);
}
std::string ball_head(double greatest_radius = 0.08) {
  return restitution_alone() + unknown("radius", "contacts.floor.radius", 0.02, greatest_radius);
}
const std::string longer = "set = [\"run.duration=2.0\"]\n";
std::string ball_times(int count, double deviation, const reference::BouncingBall& ball = dropped) {
  std::string text;
  for (int k = 1; k <= count; ++k)
    text += target(fmt::format("event.{}.t", k), reference::ball_impact(ball, k).t, deviation) + longer;
  return text;
}

/// Nelder and Mead's minimum of f over [−1, 1]² from the centre; returns the number of evaluations until
/// the simplex is smaller than `size`. Source: Computer Journal 7 (1965) 308.
int nelder_mead(const std::function<double(const Eigen::Vector2d&)>& f, double size) {
  int count = 0;
  const auto at = [&](const Eigen::Vector2d& x) {
    ++count;
    return x.cwiseAbs().maxCoeff() > 1 ? INFINITY : f(x);
  };
  std::array<std::pair<double, Eigen::Vector2d>, 3> s;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector2d x =
        k == 0 ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(0.3 * Eigen::Vector2d::Unit(k - 1));
    s[k] = {at(x), x};
  }
  const auto less = [](const auto& a, const auto& b) { return a.first < b.first; };
  for (std::ranges::sort(s, less); (s[2].second - s[0].second).norm() > size && count < 2000;
       std::ranges::sort(s, less)) {
    const Eigen::Vector2d middle = (s[0].second + s[1].second) / 2, way = middle - s[2].second;
    const auto tried = [&](double factor) {
      const Eigen::Vector2d x = middle + factor * way;
      return std::pair{at(x), x};
    };
    const auto mirrored = tried(1);
    if (mirrored.first < s[0].first) {
      const auto farther = tried(2);
      s[2] = farther.first < mirrored.first ? farther : mirrored;
    } else if (mirrored.first < s[1].first) {
      s[2] = mirrored;
    } else if (const auto nearer = tried(mirrored.first < s[2].first ? 0.5 : -0.5);
               nearer.first < s[2].first) {
      s[2] = nearer;
    } else {
      for (int k : {1, 2}) {
        const Eigen::Vector2d x = (s[0].second + s[k].second) / 2;
        s[k] = {at(x), x};
      }
    }
  }
  return count;
}

}  // namespace

TEST_CASE("restitution and radius of a ball follow from the times of its impacts", "[calibrate]") {
  const StudyDesk desk;
  const auto fit = fit_quantities(desk.read(ball_head() + ball_times(5, 1e-6)), {});
  CAPTURE(fit.squares, fit.runs, fit.iterations);
  // The times are exact to 1e-14 s. The prior moves the minimum by 0.1 ξσ² over ranges squared,
  // below 1e-9 of a range.
  CHECK(fit.unknowns[0].value == Approx(restitution).epsilon(0).margin(1e-8));
  CHECK(fit.unknowns[1].value == Approx(radius).epsilon(0).margin(1e-8));
  CHECK(fit.squares < 1e-3);
  CHECK_FALSE(fit.rejected);
  CHECK_FALSE(fit.beyond);
  CHECK(fit.horizon == 5);
  CHECK(fit.unknowns[0].low < restitution);
  CHECK(fit.unknowns[0].high > restitution);
}

TEST_CASE("a target that does not depend on the unknown does not end a fit", "[calibrate]") {
  // The first impact does not depend on the restitution; the second one determines it. The scene's radius is
  // 0.05 m.
  const reference::BouncingBall ball{0.5, 9.81, restitution};
  const StudyDesk desk;
  const auto fit = fit_quantities(desk.read(restitution_alone() + ball_times(3, 1e-6, ball)), {});
  CHECK(fit.unknowns[0].value == Approx(restitution).epsilon(0).margin(1e-8));  // as above
  CHECK_FALSE(fit.beyond);
  CHECK(fit.horizon == 3);
}

TEST_CASE("intervals of a linear problem are those of its normal equations", "[calibrate]") {
  // t₁ = √(2H/g) determines the radius alone: σ_r = σ_t |dr/dt| = σ_t g t₁. The interval is ±1.96 σ_r,
  // to the square of σ_r over the height, 1e-5.
  const StudyDesk desk;
  const double deviation = 1e-4;
  const auto fit = fit_quantities(desk.read(ball_head() + ball_times(2, deviation)), {});
  const double expected = 1.959964 * deviation * 9.81 * dropped.first_time();
  CHECK((fit.unknowns[1].high - fit.unknowns[1].low) / 2 == Approx(expected).epsilon(1e-3));
  // As many times as unknowns: the fitted motion has the deviation of the measurement.
  for (const auto& t : fit.targets) CHECK(t.model_deviation == Approx(deviation).epsilon(1e-3));
}

TEST_CASE("a misfit is rejected from the 99 % quantile of its distribution on", "[calibrate]") {
  // Three times, tₙ = t₁ (1, 1 + 2e, 1 + 2e + 2e²), and two unknowns, t₁ and e. A shift δ of the
  // last one leaves χ² = (n₃ δ/σ)²/|n|² with one degree of freedom, where n is orthogonal to the
  // derivatives of the times. The quantile is 6.635.
  const double e = restitution, t1 = dropped.first_time(), sigma = 1e-6;
  const Eigen::Vector3d n = Eigen::Vector3d(1, 1 + 2 * e, 1 + 2 * e + 2 * e * e)
                                .cross(Eigen::Vector3d(0, 2 * t1, 2 * t1 + 4 * e * t1))
                                .normalized();
  const StudyDesk desk;
  for (const double squares : {6.3, 7.0}) {
    const double shift = sigma * std::sqrt(squares) / std::abs(n[2]);
    const auto text = ball_head() + ball_times(2, sigma) +
                      target("event.3.t", reference::ball_impact(dropped, 3).t + shift, sigma) + longer;
    const auto fit = fit_quantities(desk.read(text), {});
    CHECK(fit.degrees == 1);
    CHECK(fit.squares == Approx(squares).epsilon(0.01));
    CHECK(fit.rejected == (squares > 6.635));
  }
}

TEST_CASE("intervals that reach the end of a range are named", "[calibrate]") {
  // The standard deviation of the radius is 0.3 mm, and the range ends 0.1 mm beyond the value.
  const StudyDesk desk;
  const auto fit = fit_quantities(desk.read(ball_head(radius + 1e-4) + ball_times(2, 1e-4)), {});
  CHECK_FALSE(fit.unknowns[0].open_low);
  CHECK_FALSE(fit.unknowns[0].open_high);
  CHECK_FALSE(fit.unknowns[1].open_low);
  CHECK(fit.unknowns[1].open_high);
  CHECK(fit.unknowns[1].high == Approx(radius + 1e-4).epsilon(1e-12));
}

TEST_CASE("times that no value of the unknowns gives are rejected", "[calibrate]") {
  const StudyDesk desk;
  const auto text = ball_head() + ball_times(4, 1e-6) +
                    target("event.5.t", reference::ball_impact(dropped, 5).t + 1e-3, 1e-6) + longer;
  const auto fit = fit_quantities(desk.read(text), {});
  CHECK(fit.rejected);
  CHECK(std::isnan(fit.unknowns[0].low));
}

TEST_CASE("events that earlier ones do not determine lie beyond the horizon", "[calibrate]") {
  // With σ = 40 ms for each time, the interval between the last impacts, 0.08 s, is not determined to a
  // quarter.
  const StudyDesk desk;
  const auto fit = fit_quantities(desk.read(ball_head() + ball_times(5, 0.04)), {});
  CHECK(fit.beyond);
  CHECK(fit.horizon >= 2);
  CHECK(fit.horizon < 5);
  CHECK_FALSE(fit.targets[4].used);
  CHECK(fit.targets[4].model_deviation > 0.02);
}

TEST_CASE("clearance and restitution of a slider-crank follow from its first contact events", "[calibrate]") {
  // Synthetic measurement: times of a run with known values. A fit without derivatives of the same
  // misfit needs many more runs.
  const double clearance = 0.31e-3, e = 0.52, deviation = 1e-6;
  const std::vector<std::string> settings{"nonsmooth.scheme=\"event-driven\"", "run.duration=0.03"};
  const auto run = [&](double c, double restitution) {
    auto with = settings;
    with.push_back(fmt::format("joints.gudgeon.clearance={}", c));
    with.push_back(fmt::format("surfaces.steel.restitution={}", restitution));
    return Simulation(*open_scene(test::scene_file("gudgeon"), with, true), "nonsmooth").run().events;
  };
  const auto measured = run(clearance, e);
  REQUIRE(measured.size() > 4);
  std::string text = fmt::format("scene = \"{}\"\n", test::scene_file("gudgeon").string()) +
                     unknown("clearance", "joints.gudgeon.clearance", 0.2e-3, 0.5e-3) +
                     unknown("restitution", "surfaces.steel.restitution", 0.3, 0.8);
  for (std::size_t k = 1; k <= 4; ++k)
    text += target(fmt::format("event.{}.t", k), measured[k - 1].t, deviation) +
            fmt::format("set = ['{}', \"{}\"]\n", settings[0], settings[1]);
  const StudyDesk desk;
  const auto study = desk.read(text);
  const auto fit = fit_quantities(study, {});
  CAPTURE(fit.squares, fit.runs, fit.iterations, fit.horizon);
  CHECK(fit.unknowns[0].value == Approx(clearance).epsilon(1e-6));
  CHECK(fit.unknowns[1].value == Approx(e).epsilon(1e-6));
  CHECK_FALSE(fit.rejected);
  CHECK(fit.horizon == 4);

  const auto& unknowns = study.calibration->unknowns;
  const auto misfit = [&](const Eigen::Vector2d& xi) {
    const auto events = run(unscaled(unknowns[0], xi[0]), unscaled(unknowns[1], xi[1]));
    double sum = 0.1 * xi.squaredNorm();
    for (std::size_t k = 0; k < 4; ++k)
      sum += k < events.size() ? std::pow((events[k].t - measured[k].t) / deviation, 2) : INFINITY;
    return sum;
  };
  CHECK(nelder_mead(misfit, 1e-6) > 2 * fit.runs);
}

TEST_CASE("calibrate reports errors of targets that are quantities", "[calibrate]") {
  const StudyDesk desk;
  const std::string first = "[calibrate.targets.a]\nstatistic = \"event.1.t\"\n",
                    many = "only the first 1000 contact events can be targets";
  for (const auto& [text, words] :
       {std::pair(first + "value = 0.3\n", std::string("exactly one of deviation")),
        {first + "value = 0.0\ntolerance = 0.1\n", "give deviation instead"},
        {target("event.1.time", 0.3, 1e-3), "event.1.time: must be event.N.t"},
        {target("event.90.t", 0.3, 1e-3), "does not reach event.90.t"},
        {target("event.1001.t", 0.3, 1e-3), many},
        {target("event.1000000000.t", 0.3, 1e-3), many},
        {target("event.1e300.t", 0.3, 1e-3), many},
        {target("event.1.t", 0.3, 1e-3) + "[calibrate.targets.b]\nstatistic = \"rms\"\nvalue = 1.0\n",
         "calibrate them in two studies"}}) {
    const auto call = [&desk, study = ball_head() + text] { fit_quantities(desk.read(study), {}); };
    CHECK_THAT(test::refusal_of<std::exception>(call), Contains(words));
  }
}
