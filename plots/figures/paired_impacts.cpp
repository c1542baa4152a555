// The impacts of both formulations up to the horizon: approach speed over time, and below it the
// differences of each pair relative to the mean of both values, as in the verdict of compare (time:
// relative to the interval since the previous impact). Differences at the level of rounding errors are
// not drawn.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/files/input_file.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_paired_impacts(const std::filesystem::path& folder) {
  const JsonFile comparison(folder / "comparison.json");
  const auto* pairs = comparison.find("pairing.pairs");
  if (!pairs || !pairs->is_array()) comparison.fail("pairing.pairs", "a list");
  if (pairs->empty()) return {};

  Figure f{.name = "paired_impacts", .source = "comparison.json"};
  Block penalty("penalty: t (ms), approach speed (m/s)"),
      nonsmooth("nonsmooth: t (ms), approach speed (m/s)");
  Block difference("number, |difference| of time / interval, of approach speed, of impulse");
  double before = 0, interval = NAN, least = INFINITY, most = 0, least_share = INFINITY, most_share = 0;
  constexpr double rounding = 1e-9;  // relative; far below all differences of the formulations
  int number = 0, rounded = 0;
  for (std::size_t i = 0; i < pairs->size(); ++i) {
    const auto get = [&](const char* run, const char* key) {
      return comparison.number(fmt::format("pairing.pairs.{}.{}.{}", i, run, key));
    };
    const double tp = get("penalty", "t_s"), tn = get("nonsmooth", "t_s");
    const double vp = -get("penalty", "v_n_minus_m_per_s"), vn = -get("nonsmooth", "v_n_minus_m_per_s");
    const double Pp = get("penalty", "impact_impulse_n_N_s"), Pn = get("nonsmooth", "impact_impulse_n_N_s");
    least = std::min({least, vp, vn});
    most = std::max({most, vp, vn});
    penalty.row({1e3 * tp, vp});
    nonsmooth.row({1e3 * tn, vn});
    const auto share = [](double a, double b) {
      return a > 0 && b > 0 ? 2 * std::abs(a - b) / (a + b) : NAN;
    };
    // Simultaneous impacts share the interval before them, as in TouchComparison.
    if (tn - before > 1e-6 * tn) interval = tn - before;
    const double shown[] = {std::abs(tp - tn) / interval, share(vp, vn), share(Pp, Pn)};
    for (const double x : shown) {
      rounded += x < rounding;
      if (x >= rounding) least_share = std::min(least_share, x), most_share = std::max(most_share, x);
    }
    difference.row({static_cast<double>(++number), shown[0], shown[1], shown[2]});
    before = tn;
  }
  f.blocks = {penalty, nonsmooth, difference};
  Panel speed{.title = AxisTitle::of({"approach speed |v_N|", "approach speed $|v_N|$"}, "m/s"),
              .axis = least > 0 && most > 10 * least ? decades_of(0.8 * least, 1.25 * most)
                                                     : Axis{0, most > 0 ? 1.15 * most : 1},
              .curves = {{Script().add("DATA index 0 using 1:2 with points ls 1"), "penalty"},
                         {Script().add("DATA index 1 using 1:2 with points ls 2"), "nonsmooth"}}};
  speed.abscissa = {AxisTitle::of({"time t", "time $t$"}, "ms"),
                    {0, 1.05e3 * comparison.number("pairing.horizon_s")}};
  Panel shares{.title = AxisTitle::of("relative difference", ""),
               // a margin between points and frame
               .axis = least_share < INFINITY ? decades_of(0.8 * least_share, 1.25 * most_share)
                                              : decades_of(rounding, 1),
               .curves = {{Script().add("DATA index 2 using 1:2 with points pt 4 lc rgb C3"), "time"},
                          {Script().add("DATA index 2 using 1:3 with points pt 8 lc rgb C1"), "speed"},
                          {Script().add("DATA index 2 using 1:4 with points pt 2 lc rgb C2"), "impulse"}}};
  PanelStack stack{
      .abscissa = {AxisTitle::of("impact number", ""), {0.5, number + 0.5, std::ceil(number / 10.0)}},
      .panels = {std::move(speed), std::move(shares)},
      .each = number == 1 ? 2.6 : 3.8};
  if (rounded > 0) f.caption = fmt::format("Differences below {:g}, not drawn: {}.", rounding, rounded);
  return {draw_panels(f, folder, std::move(stack))};
}

}  // namespace

const Drawing paired_impacts{{"comparison.json"}, draw_paired_impacts};

}  // namespace freeplay::plots
