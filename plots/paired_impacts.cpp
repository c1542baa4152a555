// The impacts of both formulations up to the horizon: approach speed over time, and below it what each pair
// differs by, as shares of the nonsmooth value (time: of the interval since the previous impact).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "plots/figure.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_all(const std::filesystem::path& folder) {
  std::ifstream in(folder / "comparison.json");
  const auto document = nlohmann::json::parse(in);
  const auto& pairing = document.at("pairing");
  const auto& pairs = pairing.at("pairs");
  if (pairs.empty()) return {};

  Figure f;
  f.name = "paired_impacts";
  f.source = "comparison.json";
  f.height_cm = 12;
  std::string penalty = "# penalty: t (ms), approach speed (m/s)\n", nonsmooth = "# nonsmooth: the same\n";
  std::string difference = "# number, |difference| of time / interval, of approach speed, of impulse\n";
  double before = 0, interval = NAN, least = INFINITY, most = 0;
  int number = 0;
  for (const auto& pair : pairs) {
    const auto get = [&](const char* run, const char* key) { return pair.at(run).at(key).get<double>(); };
    const double tp = get("penalty", "t_s"), tn = get("nonsmooth", "t_s");
    const double vp = -get("penalty", "v_n_minus_m_per_s"), vn = -get("nonsmooth", "v_n_minus_m_per_s");
    const double Pp = get("penalty", "impulse_n_N_s"), Pn = get("nonsmooth", "impulse_n_N_s");
    least = std::min({least, vp, vn});
    most = std::max({most, vp, vn});
    penalty += fmt::format("{} {}\n", 1e3 * tp, vp);
    nonsmooth += fmt::format("{} {}\n", 1e3 * tn, vn);
    const auto share = [](double a, double b) {
      return a > 0 && b > 0 ? fmt::format("{}", std::abs(a / b - 1)) : "NaN";
    };
    // Contacts that strike at once share the interval before them, as TouchComparison has it.
    if (tn - before > 1e-6 * tn) interval = tn - before;
    difference +=
        fmt::format("{} {} {} {}\n", ++number, std::abs(tp - tn) / interval, share(vp, vn), share(Pp, Pn));
    before = tn;
  }
  f.blocks = {penalty, nonsmooth, difference};
  // Of one pair gnuplot would find an empty range.
  const auto range = least > 0 ? fmt::format("[{:.4g}:{:.4g}]", 0.9 * least, 1.1 * most) : "[*:*]";
  f.script = fmt::format(
      "set multiplot layout 2,1 margins 0.1,0.97,0.1,0.95 spacing 0,0.19\nset key center at graph 0.5, "
      "graph 1.09 horizontal\nset pointsize 1.1\nset xlabel 'Time (ms)' offset 0,0.4\nset ylabel 'Approach "
      "speed (m/s)'\nset logscale y\nset format y '%g'\nset yrange {}\nset xrange [0:{:.4g}]\nplot 'DATA' index 0 using "
      "1:2 with points ls 1 title 'penalty', 'DATA' index 1 using 1:2 with points ls 2 title "
      "'nonsmooth'\nunset label 100\nset xlabel 'Number of the impact' offset 0,0.4\nset ylabel 'Difference "
      "(share)'\nset format y '10^{{%T}}'\nset yrange [*:*]\nset xrange [0.5:{}]\nset xtics {}\nplot 'DATA' index 2 using 1:2 "
      "with points pt 4 lc rgb '#000000' title 'time / interval before it', '' index 2 using 1:3 with "
      "points pt 8 lc rgb '#0b3c8c' title 'approach speed', '' index 2 using 1:4 with points pt 2 lc rgb "
      "'#c8500a' title 'impulse'\nunset multiplot\n",
      range, 1.05e3 * pairing.at("horizon_s").get<double>(), number + 0.5, number > 20 ? number / 10 : 1);
  return {draw(f, folder)};
}

}  // namespace

const Drawing paired_impacts{{"comparison.json"}, draw_all};

}  // namespace freeplay::plots
