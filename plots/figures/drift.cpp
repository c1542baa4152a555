// Constraint error and residual of the energy balance over time, for every stabilisation.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_drift(const std::filesystem::path& folder) {
  const ReadTable table(folder / "drift.csv", {"stabilisation"}, {"t", "length", "closure"});
  const auto& kind = table.text("stabilisation");
  const auto &t = table.column("t"), &length = table.column("length"), &closure = table.column("closure");
  // A logarithmic axis cannot show zero: the rounding error of a position replaces it.
  constexpr double least = 1e-17;
  Figure f{.name = "drift", .source = "drift.json"};
  std::vector<std::string> names;
  Limits time, lengths, closures;
  for (std::size_t i = 0; i < kind.size(); ++i) {
    if (names.empty() || names.back() != kind[i]) {
      names.push_back(kind[i]);
      f.blocks.emplace_back(kind[i] + ": t (s), constraint error (m), |closure| (J)");
    }
    f.blocks.back().row({t[i], length[i], std::abs(closure[i])});
    time.hold(t[i]);
    lengths.hold(std::max(length[i], least));
    closures.hold(std::max(std::abs(closure[i]), least));
  }
  const auto panel = [&](AxisTitle title, const Limits& limits, int column) {
    Panel p{.title = std::move(title), .axis = decades_of(limits.least, limits.most), .curves = {}};
    for (std::size_t i = 0; i < names.size(); ++i)
      p.curves.push_back({Script().add("DATA index {0} using 1:(${1} > {2} ? ${1} : {2}) with lines ls {3}",
                                       i, column, least, i + 1),
                          column == 2 ? names[i] : ""});
    return p;
  };
  add_panels(f, style_of(folder),
             {.abscissa = {time_title(), {time.least, time.most}},
              .panels = {panel(AxisTitle::of("constraint error", "m"), lengths, 2),
                         panel(AxisTitle::of("error of energy", "J"), closures, 3)},
              .each = 4.6});
  return {draw(f, folder)};
}

}  // namespace

const Drawing drift{{"drift.json"}, draw_drift};

}  // namespace freeplay::plots
