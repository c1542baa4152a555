// Calibration to time series: correlated residuals, their intervals in synthetic repetitions, flanks, and the
// unknowns of a friction damper from the closed form of its loop.
#include "study/calibration/series_fit.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include "numerics/quantiles.hpp"
#include "study/calibration/series_estimate.hpp"
#include "verification/references/backlash_slider.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

using test::StudyDesk, test::unknown;

Eigen::VectorXd vector_of(const std::vector<double>& x) {
  return Eigen::VectorXd::Map(x.data(), static_cast<Eigen::Index>(x.size()));
}

/// Standard normal deviates, equal on all machines.
class Noise {
 public:
  explicit Noise(unsigned seed) : generator_(seed) {}
  double operator()() { return normal_quantile((static_cast<double>(generator_() >> 11) + 0.5) * 0x1p-53); }

 private:
  std::mt19937_64 generator_;
};

/// x = amplitude sin(2π f t) at times up to `end`.
struct Stroke {
  std::vector<double> t, x;
  Stroke(double amplitude, double frequency, double rate, double end) {
    for (int i = 0; i <= static_cast<int>(std::lround(rate * end)); ++i) {
      t.push_back(i / rate);
      x.push_back(amplitude * std::sin(2 * std::numbers::pi * frequency * t.back()));
    }
  }
};

constexpr reference::BacklashSlider damper{4.5e-3, 5.8e6, 9.7e3};

/// A measured file of the closed form. The slider begins 0.5 mm behind the piston.
std::string file_of(const Stroke& stroke) {
  std::string text = "t,displacement,force\n";
  const auto forces = damper.forces(stroke.x, -5e-4);
  for (std::size_t i = 0; i < forces.size(); ++i)
    text += fmt::format("{},{},{}\n", stroke.t[i], stroke.x[i], forces[i]);
  return text;
}
std::string series(const std::string& name, const std::string& keys) {
  return test::target(
      name, "series",
      fmt::format("channel = \"actuator.fx_mean\"\ndata = \"{}.csv\"\ncolumns = [\"t\", \"force\"]\n{}", name,
                  keys));
}
const std::string damper_head = "scene = \"scene.toml\"\nrestitution = \"as-given\"\n" +
                                unknown("play", "loads.link.upper", 1e-3, 1e-2) +
                                unknown("stiffness", "loads.link.stiffness", 1e6, 5e7, "scale = \"log\"\n") +
                                unknown("friction", "loads.band.force", 2e3, 2e4);

}  // namespace

TEST_CASE("the correlation time of a residual follows from its autocovariance", "[calibrate]") {
  // c_k = (n − k)/n of a constant: the pair c₁ + c₂ is added, and the lags end.
  const auto constant = autocovariance(vector_of({1, 1, 1, 1}));
  REQUIRE(constant.size() == 3);
  CHECK(constant[1] == 0.75);
  CHECK(correlation_samples(constant) == 3.5);
  // c₁ + c₂ = 1/4 − 1/2 < 0 ends the list at once.
  const auto block = autocovariance(vector_of({1, 1, -1, -1}));
  CHECK(block.size() == 1);
  CHECK(correlation_samples(block) == 1);
}

TEST_CASE("a linear series is fitted as by its normal equations", "[calibrate]") {
  // r = ξ a − y with alternating residuals, which are anticorrelated: the interval is that of independent
  // ones.
  const int n = 64;
  Eigen::VectorXd a(n), y(n);
  for (int i = 0; i < n; ++i) {
    a[i] = 1 + 0.01 * i;
    y[i] = 0.3 * a[i] + (i % 2 == 0 ? 0.1 : -0.1);
  }
  const auto found = estimate_series(
      [&](const std::vector<Eigen::VectorXd>& points) {
        std::vector<SeriesResiduals> list;
        for (const auto& xi : points) list.push_back({xi[0] * a - y});
        return list;
      },
      1);
  const double best = a.dot(y) / a.squaredNorm();
  CHECK(found.converged);
  CHECK(found.xi[0] == Approx(best).epsilon(1e-10));  // differences of a linear function are exact
  const double variance = (best * a - y).squaredNorm() / (n - 1) / a.squaredNorm();
  CHECK(found.covariance(0, 0) == Approx(variance).epsilon(1e-9));
  CHECK(found.independent == n);
  CHECK(found.quantile == Approx(student_quantile(n - 1, 0.975)));
}

TEST_CASE("intervals of a loop's unknowns cover in 40 sets with correlated noise", "[calibrate]") {
  // Noise of 300 N (3 % of the friction) with an autocorrelation of 0.9ᵏ, thus 19 samples: intervals for
  // independent samples contain about half of the values. 120 intervals at 95 % contain 114 ± 2.4; those of
  // one set are correlated, at most ± 4.1. A residual of few independent samples underestimates its own
  // correlation, which costs some per cent. Bound: 102, 85 %.
  const Stroke stroke(25e-3, 0.5, 128, 6);
  const std::array<std::array<double, 2>, 3> ranges{{{1e-3, 1e-2}, {1e6, 2e7}, {2e3, 2e4}}};
  const std::array<double, 3> truth{damper.play, damper.stiffness, damper.friction};
  constexpr std::size_t first = 256;  // after 2 s
  const auto forces = [&](const reference::BacklashSlider& d) {
    const auto all = d.forces(stroke.x, -5e-4);
    return vector_of({all.begin() + first, all.end()});
  };
  const Eigen::VectorXd exact = forces(damper);
  Noise noise(1);
  int covered = 0, wide = 0;
  for (int set = 0; set < 40; ++set) {
    Eigen::VectorXd measured = exact;
    double e = noise();
    for (auto& x : measured) {
      x += 300 * e;
      e = 0.9 * e + std::sqrt(1 - 0.81) * noise();
    }
    const auto found = estimate_series(
        [&](const std::vector<Eigen::VectorXd>& points) {
          std::vector<SeriesResiduals> list;
          for (const auto& xi : points) {
            std::array<double, 3> p{};
            for (std::size_t j = 0; j < 3; ++j)
              p[j] =
                  ranges[j][0] + 0.5 * (xi[static_cast<Eigen::Index>(j)] + 1) * (ranges[j][1] - ranges[j][0]);
            list.push_back({(forces({p[0], p[1], p[2]}) - measured) / 8e3});
          }
          return list;
        },
        3);
    CHECK(found.converged);
    for (Eigen::Index j = 0; j < 3; ++j) {
      const auto k = static_cast<std::size_t>(j);
      const double place = 2 * (truth[k] - ranges[k][0]) / (ranges[k][1] - ranges[k][0]) - 1;
      const double half = found.quantile * std::sqrt(found.covariance(j, j));
      covered += !(std::abs(found.xi[j] - place) > half);  // without an interval no value is excluded
      wide += !(half < 0.3);                               // of the range of 2
    }
  }
  CHECK(covered >= 102);
  // An interval that excludes nothing covers, too: at most two of the sets have so little to count.
  CHECK(wide <= 6);
}

TEST_CASE("flanks are compared where both series reach the level after a change of sign", "[calibrate]") {
  // Trapezoids of period 4 between ±1 that pass 0 at even times with slope ±2: they reach 0.5 a quarter
  // later. The model is 0.1 late. A dip below the level without a change of sign is no flank.
  std::vector<double> t, measured, model;
  const auto wave = [](double at) {
    const double phase = std::fmod(at + 8, 4.0);
    return std::clamp(phase < 3 ? 2 * std::min(phase, 2 - phase) : 2 * (phase - 4), -1.0, 1.0);
  };
  for (int i = 0; i <= 1000; ++i) {
    t.push_back(0.01 * i);
    measured.push_back(i == 150 || i == 350 ? 0.3 * wave(t.back()) : wave(t.back()));
    model.push_back(wave(t.back() - 0.1));
  }
  const auto m = misfit_of(t, t, measured, model, {0.5});
  // Ends of flanks: 0.25, 2.25, 4.25, 6.25, 8.25; t = 10 begins the next one.
  CHECK(m.flanks == 5);
  CHECK(m.unpaired == 0);
  CHECK(m.flank_rms == Approx(0.1).epsilon(1e-9));
  // Late by 0.1 in t: + in the rising flanks (3), − in the falling ones (2), over five.
  CHECK(m.flank_mean == Approx(0.1 / 5).epsilon(1e-9));
}

TEST_CASE("play, stiffness and friction of the damper follow from its loop", "[calibrate]") {
  // The scene has what the closed form neglects: 2 kg at 0.25 m/s² (0.5 N) and a damping of 200 N s/m at up
  // to 0.08 m/s (16 N), together below 0.2 % of the friction. Rows are means over 3.9 ms, in which a flank of
  // 1.7 mm at up to 0.04 m/s advances by at most 0.16 mm: they round its ends by at most an eighth of that,
  // 20 µm, 0.4 % of the play. Bound: 1 % of each value.
  const StudyDesk desk("friction-damper");
  desk.put("fitted.csv", file_of(Stroke(25e-3, 0.5, 256, 4)));
  desk.put("predicted.csv", file_of(Stroke(12e-3, 0.5, 256, 4)));
  const auto keys = [](double amplitude) {
    return fmt::format(
        "set = [\"run.duration=4\", \"loads.link.damping=200\", \"curves.stroke.amplitude={}\"]\nfrom = 1\n"
        "against = \"displacement\"\nlevels = [2000, 5000]\n",
        amplitude);
  };
  const auto fit = fit_series(desk.read(damper_head + series("fitted", keys(25e-3)) +
                                        series("predicted", keys(12e-3) + "hold_out = true\n")),
                              2, {});
  CAPTURE(fit.runs, fit.iterations);
  CHECK(fit.holds());
  CHECK(fit.unknowns[0].value == Approx(damper.play).epsilon(0.01));
  CHECK(fit.unknowns[1].value == Approx(damper.stiffness).epsilon(0.01));
  CHECK(fit.unknowns[2].value == Approx(damper.friction).epsilon(0.01));
  REQUIRE(fit.series.size() == 4);  // two targets in both formulations
  int fitted = 0;
  for (const auto& one : fit.series) {
    CAPTURE(one.target, one.formulation);
    fitted += one.fitted;
    // The penalty formulation creeps below its friction bound at up to 0.1 mm/s: 0.05 mm in half a period,
    // 0.3 kN at the flanks of a third of the time. Bound: 2 % of the friction.
    CHECK(one.misfit.rms < 0.02 * damper.friction);
    CHECK(one.misfit.flank_rms < 0.1e-3);
    CHECK(one.misfit.unpaired == 0);
  }
  CHECK(fitted == 1);  // one target, in the fitted formulation
}

TEST_CASE("wrong keys of a series are refused with their position", "[calibrate]") {
  const StudyDesk desk("friction-damper");
  desk.put("fitted.csv", file_of(Stroke(25e-3, 0.5, 256, 1)));
  CHECK_THAT(desk.refusal(damper_head + series("fitted", "hold_out = true\n")),
             Contains("targets") && Contains("must have a target without hold_out"));
  CHECK_THAT(desk.refusal(damper_head + series("fitted", "levels = [5000]\n")),
             Contains("levels") && Contains("needs against"));
  CHECK_THAT(desk.refusal(damper_head + series("fitted", "against = \"displacement\"\nlevels = [2, 1]\n")),
             Contains("levels") && Contains("must be greater than 0 and increase, has 1"));
  CHECK_THAT(desk.refusal(damper_head + series("fitted", "from = 2\nuntil = 1\n")),
             Contains("until") && Contains("must be greater than from = 2, is 1"));
  CHECK_THAT(
      desk.refusal(damper_head + series("fitted", "") + test::target("peak", "peak_median", "value = 1\n")),
      Contains("a statistic") && Contains("a series of one run") && Contains("in two studies"));
  const auto refused = [&](const std::string& text) {
    return test::refusal_of<SceneError>([&] { fit_series(desk.read(damper_head + text), 1, {}); });
  };
  const std::string data = "data = \"fitted.csv\"\ncolumns = [\"t\", \"force\"]\n";
  CHECK_THAT(refused(test::target("fitted", "series", "channel = \"actuatr.fx\"\n" + data)),
             Contains("channel") && Contains("did you mean actuator.fx"));
  CHECK_THAT(refused(series("fitted", "set = [\"run.duration=0.5\"]\n")),
             Contains("until") && Contains("the run ends at 0.5 s"));
  std::string early = "t,force\n";
  for (int i = 0; i < 40; ++i) early += fmt::format("{},{}\n", 0.01 * (i - 10), i % 7);
  desk.put("early.csv", early);
  const auto beside = test::target("fitted", "series", "channel = \"actuator.fx\"\ndata = \"early.csv\"\n");
  CHECK_THAT(refused(beside), Contains("from") && Contains("the run begins at 0 s"));
  CHECK_THAT(refused(series("fitted", "set = [\"bodies.drum.mas=1\"]\n")),
             Contains("study.toml:") && Contains("bodies.drum.mas"));
  CHECK_THAT(refused(series("fitted", "from = 0.99\n")), Contains("3 samples in the compared time"));
}
