// The impacts of both formulations up to the horizon: approach speed over time, and below it what each pair
// differs by, as shares of the nonsmooth value (time: of the interval since the previous impact).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/input_file.hpp"
#include "plots/figure.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_all(const std::filesystem::path& folder) {
  const JsonFile comparison(folder / "comparison.json");
  const auto* pairs = comparison.find("pairing.pairs");
  if (!pairs || !pairs->is_array()) comparison.fail("pairing.pairs", "a list");
  if (pairs->empty()) return {};

  Figure f{.name = "paired_impacts", .height_cm = 12, .source = "comparison.json"};
  Block penalty("penalty: t (ms), approach speed (m/s)"), nonsmooth("nonsmooth: the same");
  Block difference("number, |difference| of time / interval, of approach speed, of impulse");
  double before = 0, interval = NAN, least = INFINITY, most = 0;
  int number = 0;
  for (std::size_t i = 0; i < pairs->size(); ++i) {
    const auto get = [&](const char* run, const char* key) {
      return comparison.number(fmt::format("pairing.pairs.{}.{}.{}", i, run, key));
    };
    const double tp = get("penalty", "t_s"), tn = get("nonsmooth", "t_s");
    const double vp = -get("penalty", "v_n_minus_m_per_s"), vn = -get("nonsmooth", "v_n_minus_m_per_s");
    const double Pp = get("penalty", "impulse_n_N_s"), Pn = get("nonsmooth", "impulse_n_N_s");
    least = std::min({least, vp, vn});
    most = std::max({most, vp, vn});
    penalty.row({1e3 * tp, vp});
    nonsmooth.row({1e3 * tn, vn});
    const auto share = [](double a, double b) { return a > 0 && b > 0 ? std::abs(a / b - 1) : NAN; };
    // Contacts that strike at once share the interval before them, as TouchComparison has it.
    if (tn - before > 1e-6 * tn) interval = tn - before;
    difference.row(
        {static_cast<double>(++number), std::abs(tp - tn) / interval, share(vp, vn), share(Pp, Pn)});
    before = tn;
  }
  f.blocks = {penalty, nonsmooth, difference};
  // Of one pair gnuplot would find an empty range.
  Script range;
  if (least > 0)
    range.add("[{:.4g}:{:.4g}]", 0.9 * least, 1.1 * most);
  else
    range.add("[*:*]");
  f.script.add(
      "set multiplot layout 2,1 margins 0.1,0.97,0.1,0.95 spacing 0,0.19\nset key center at graph 0.5, "
      "graph 1.09 horizontal\nset pointsize 1.1\nset xlabel 'Time (ms)' offset 0,0.4\nset ylabel 'Approach "
      "speed (m/s)'\nset logscale y\nset format y '%g'\nset yrange {}\nset xrange [0:{:.4g}]\nplot DATA index 0 using "
      "1:2 with points ls 1 title 'penalty', DATA index 1 using 1:2 with points ls 2 title "
      "'nonsmooth'\nunset label 100\nset xlabel 'Number of the impact' offset 0,0.4\nset ylabel 'Difference "
      "(share)'\nset format y '10^{{%T}}'\nset yrange [*:*]\nset xrange [0.5:{}]\nset xtics {}\nplot DATA index 2 using 1:2 "
      "with points pt 4 lc rgb '#000000' title 'time / interval before it', '' index 2 using 1:3 with "
      "points pt 8 lc rgb '#0b3c8c' title 'approach speed', '' index 2 using 1:4 with points pt 2 lc rgb "
      "'#c8500a' title 'impulse'\nunset multiplot\n",
      range, 1.05e3 * comparison.number("pairing.horizon_s"), number + 0.5, number > 20 ? number / 10 : 1);
  return {draw(f, folder)};
}

}  // namespace

const Drawing paired_impacts{{"comparison.json"}, draw_all};

}  // namespace freeplay::plots
