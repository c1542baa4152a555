// Processor time per step over the size of the mechanism, with the slopes predicted by the
// algorithms.
#include <cmath>

#include "plots/drawing/figure.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_scaling(const std::filesystem::path& folder) {
  Rows rows(folder / "scaling.csv");
  const auto scene = rows.place("scene"), count = rows.place("count"), cost = rows.place("microseconds"),
             predicted = rows.place("predicted");
  Figure f{.name = "scaling", .height_cm = 10, .source = "scaling.json"};
  std::vector<std::string> names;
  while (rows.next()) {
    if (names.empty() || names.back() != rows.name(scene)) {
      names.push_back(rows.name(scene));
      f.blocks.emplace_back(names.back() + ": count, processor time (us), predicted (us)");
    }
    f.blocks.back().row({rows.number(count), rows.number(cost), rows.maybe_number(predicted)});
  }
  if (names.empty()) return {};
  f.script.add(
      "set logscale xy\nset format y {}\nset xlabel 'Joints, links or bodies'\n"
      "set ylabel 'Processor time per step (µs)'\nset key top left\nplot ",
      powers);
  for (std::size_t i = 0; i < names.size(); ++i)
    f.script.add(
        "{0}DATA index {1} using 1:2 with linespoints lw 1.5 pt 7 ps 0.5 lc rgb C{2} title {3} noenhanced, "
        "'' index {1} using 1:3 with lines ls 4 dt 2 {4}",
        i ? Word(", ") : Word(""), i, i + 1, names[i], i ? Word("notitle") : Word("title 'predicted'"));
  f.script.add("\n");
  return {draw(f, folder)};
}

}  // namespace

const Drawing scaling{{"scaling.csv"}, draw_scaling};

}  // namespace freeplay::plots
