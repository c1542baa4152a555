// Constraint error and closure of the energy balance over time, for every stabilisation.
#include <fmt/format.h>

#include <cmath>

#include "plots/figure.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_all(const std::filesystem::path& folder) {
  const Csv csv(folder / "drift.csv");
  const auto& kind = csv.text("stabilisation");
  const auto t = csv.column("t"), length = csv.column("length"), closure = csv.column("closure");
  Figure f;
  f.name = "drift";
  f.source = "drift.json";
  f.height_cm = 13;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kind.size(); ++i) {
    if (names.empty() || names.back() != kind[i]) {
      names.push_back(kind[i]);
      f.blocks.push_back("# " + kind[i] + ": t (s), constraint error (m), |closure| (J)\n");
    }
    f.blocks.back() += fmt::format("{} {} {}\n", t[i], length[i], std::abs(closure[i]));
  }
  const auto curves = [&](int column) {
    std::string text = "plot ";
    for (std::size_t i = 0; i < names.size(); ++i)
      // Zero has no place on a logarithmic axis: the rounding of a position stands in for it.
      text += fmt::format(
          "{0}'DATA' index {1} using 1:(${2} > 1e-17 ? ${2} : 1e-17) with lines ls {3} title '{4}'",
          i ? ", " : "", i, column, i + 1, names[i]);
    return text + "\n";
  };
  f.script =
      "set multiplot layout 2,1 margins 0.12,0.97,0.09,0.94 spacing 0,0.12\nset logscale y\nset format y "
      "'10^{%T}'\nset key center at graph 0.5, graph 1.07 horizontal\nset xlabel 'Time (s)' offset "
      "0,0.4\nset ylabel 'Constraint error (m)'\n" +
      curves(2) + "unset label 100\nset ylabel 'Energy balance, error (J)'\n" + curves(3) +
      "unset multiplot\n";
  return {draw(f, folder)};
}

}  // namespace

const Drawing drift{{"drift.json"}, draw_all};

}  // namespace freeplay::plots
