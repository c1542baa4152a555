// Convergence of the Lyapunov exponents: their means from the end of the transient to each time.
#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "plots/drawing/figure.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

/// Curves beyond this number are not distinguished; the file has all.
constexpr int most_exponents = 9;

std::vector<std::filesystem::path> draw_lyapunov(const std::filesystem::path& folder) {
  Rows rows(folder / "lyapunov.csv");
  const auto t = rows.place("t"), sum = rows.place("sum"), predicted = rows.place("sum_predicted");
  std::vector<std::size_t> places;
  for (int i = 1; i <= most_exponents && rows.has(fmt::format("exponent_{}", i)); ++i)
    places.push_back(rows.place(fmt::format("exponent_{}", i)));
  Figure f{.name = "lyapunov", .height_cm = 9, .source = "lyapunov.json"};
  f.blocks.emplace_back("t (s), means of the exponents (1/s), of their sum, predicted sum");
  std::vector<bool> any(places.size() + 2);
  while (rows.next()) {
    std::vector<double> line{rows.number(t)};
    for (const auto place : places) line.push_back(rows.maybe_number(place));
    line.push_back(rows.maybe_number(sum));
    line.push_back(rows.maybe_number(predicted));
    for (std::size_t i = 0; i < any.size(); ++i) any[i] = any[i] || std::isfinite(line[i + 1]);
    f.blocks.back().row(line);
  }
  Script plot;
  const auto add = [&](std::size_t i, Script how) {
    if (any[i])
      plot.add("{}DATA index 0 using 1:{} {}", plot.empty() ? Word("plot ") : Word(", "), i + 2, how);
  };
  for (std::size_t i = 0; i < places.size(); ++i)
    add(i, Script().add("with lines lw 1.5 lc rgb C{} title {} noenhanced", i + 1,
                        fmt::format("exponent {}", i + 1)));
  add(places.size(), Script().add("with lines lw 1.5 lc rgb 0x444444 title 'sum'"));
  add(places.size() + 1,
      Script().add("every 8 with points pt 6 ps 0.7 lc rgb 0x444444 title 'sum predicted'"));
  if (plot.empty()) return {};
  f.script.add(
      "set xlabel 'Time (s)'\nset ylabel 'Mean since the transient (1/s)'\n"
      "set arrow 1 from graph 0, first 0 to graph 1, first 0 nohead lc rgb 0x888888 dt 3\n"
      "set key outside top center horizontal font SMALL\n{}\n",
      plot);
  return {draw(f, folder)};
}

}  // namespace

const Drawing lyapunov{{"lyapunov.json"}, draw_lyapunov};

}  // namespace freeplay::plots
