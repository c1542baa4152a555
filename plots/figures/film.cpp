// Stiffness and damping of a lubricated joint in steady running over the Sommerfeld number.
#include <cmath>

#include "plots/drawing/figure.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_film(const std::filesystem::path& folder) {
  if (!std::filesystem::exists(folder / "film.csv")) return {};  // of a single load
  const Table table(folder / "film.csv", {},
                    {"sommerfeld_number", "K_xx", "K_xy", "K_yx", "K_yy", "C_xx", "C_xy", "C_yx", "C_yy"});
  Figure f{.name = "film_coefficients", .height_cm = 14, .source = "film.json"};
  f.blocks.emplace_back("Sommerfeld number, magnitudes of K c/W (4) and C cω/W (4)");
  for (std::size_t i = 0; i < table.column("K_xx").size(); ++i)
    f.blocks.back().row({table.column("sommerfeld_number")[i], std::abs(table.column("K_xx")[i]),
                         std::abs(table.column("K_xy")[i]), std::abs(table.column("K_yx")[i]),
                         std::abs(table.column("K_yy")[i]), std::abs(table.column("C_xx")[i]),
                         std::abs(table.column("C_xy")[i]), std::abs(table.column("C_yx")[i]),
                         std::abs(table.column("C_yy")[i])});
  const Word names[] = {Word("K_{xx}", "$K_{xx}$"),     Word("K_{xy}", "$K_{xy}$"),
                        Word("|K_{yx}|", "$|K_{yx}|$"), Word("K_{yy}", "$K_{yy}$"),
                        Word("C_{xx}", "$C_{xx}$"),     Word("C_{xy}", "$C_{xy}$"),
                        Word("C_{yx}", "$C_{yx}$"),     Word("C_{yy}", "$C_{yy}$")};
  const auto curves = [&](int first) {
    f.script.add("plot ");
    for (int k = 0; k < 4; ++k)
      f.script.add("{}DATA index 0 using 1:{} with lines ls {} title '{}'", k > 0 ? Word(", ") : Word(""),
                   first + k, k + 1, names[first + k - 2]);
    f.script.add("\n");
  };
  f.script.add(
      "set multiplot layout 2,1 margins X(1.9),1-X(0.4),Y(1.5),1-Y(0.9) spacing 0,Y(1.9)\nset logscale xy\nset format x {}\n"
      "set key center at graph 0.5, graph 1.08 horizontal maxrows 1 samplen 2 font SMALL\n"
      "set xlabel 'Sommerfeld number'\nset ylabel 'Stiffness (W/c)'\n",
      powers);
  curves(2);
  f.script.add("unset label 100\nset ylabel '{}'\n", Word("Damping (W/(c ω))", "Damping ($W/(c\\omega)$)"));
  curves(6);
  f.script.add("unset multiplot\n");
  return {draw(f, folder)};
}

}  // namespace

const Drawing film{{"film.csv"}, draw_film};

}  // namespace freeplay::plots
