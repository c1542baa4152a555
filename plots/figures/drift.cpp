// Constraint error and residual of the energy balance over time, for every stabilisation.
#include <fmt/format.h>

#include <cmath>

#include "plots/drawing/figure.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_drift(const std::filesystem::path& folder) {
  const Table table(folder / "drift.csv", {"stabilisation"}, {"t", "length", "closure"});
  const auto& kind = table.text("stabilisation");
  const auto &t = table.column("t"), &length = table.column("length"), &closure = table.column("closure");
  Figure f{.name = "drift", .height_cm = 13, .source = "drift.json"};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kind.size(); ++i) {
    if (names.empty() || names.back() != kind[i]) {
      names.push_back(kind[i]);
      f.blocks.emplace_back(kind[i] + ": t (s), constraint error (m), |closure| (J)");
    }
    f.blocks.back().row({t[i], length[i], std::abs(closure[i])});
  }
  const auto curves = [&](int column) {
    f.script.add("plot ");
    for (std::size_t i = 0; i < names.size(); ++i)
      // A logarithmic axis cannot show zero: the rounding error of a position replaces it.
      f.script.add(
          "{0}DATA index {1} using 1:(${2} > 1e-17 ? ${2} : 1e-17) with lines ls {3} title {4} noenhanced",
          i ? Word(", ") : Word(""), i, column, i + 1, names[i]);
    f.script.add("\n");
  };
  f.script.add(
      "set multiplot layout 2,1 margins X(1.9),1-X(0.4),Y(1.15),1-Y(0.9) spacing 0,Y(1.9)\nset logscale y\nset format y {}\n"
      "set key center at graph 0.5, graph 1.08 horizontal maxrows 2 samplen 2 font SMALL\nset xlabel 'time t (s)'\nset ylabel "
      "'constraint error (m)'\n",
      powers);
  curves(2);
  f.script.add("set ylabel 'error of energy (J)'\n");
  curves(3);
  f.script.add("unset multiplot\n");
  return {draw(f, folder)};
}

}  // namespace

const Drawing drift{{"drift.json"}, draw_drift};

}  // namespace freeplay::plots
