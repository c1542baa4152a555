// Stiffness and damping of a lubricated joint in steady running over the Sommerfeld number.
#include <cmath>
#include <iterator>

#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_film(const std::filesystem::path& folder) {
  if (!std::filesystem::exists(folder / "film.csv")) return {};  // of a single load
  const ReadTable table(
      folder / "film.csv", {},
      {"sommerfeld_number", "K_xx", "K_xy", "K_yx", "K_yy", "C_xx", "C_xy", "C_yx", "C_yy"});
  Figure f{.name = "film_coefficients", .source = "film.json"};
  f.blocks.emplace_back("Sommerfeld number, magnitudes of K c/W (4) and C cω/W (4)");
  struct Coefficient {
    const char* name;
    Word symbol;
  };
  constexpr Coefficient all[] = {{"K_xx", {"K_{xx}", "$K_{xx}$"}},     {"K_xy", {"K_{xy}", "$K_{xy}$"}},
                                 {"K_yx", {"|K_{yx}|", "$|K_{yx}|$"}}, {"K_yy", {"K_{yy}", "$K_{yy}$"}},
                                 {"C_xx", {"C_{xx}", "$C_{xx}$"}},     {"C_xy", {"C_{xy}", "$C_{xy}$"}},
                                 {"C_yx", {"C_{yx}", "$C_{yx}$"}},     {"C_yy", {"C_{yy}", "$C_{yy}$"}}};
  Panel panels[] = {{.title = AxisTitle::of("stiffness", "W/c"), .axis = {}, .curves = {}},
                    {.title = AxisTitle::of("damping", "W/(c ω)"), .axis = {}, .curves = {}}};
  Limits across, up[2];
  for (std::size_t i = 0; i < table.rows(); ++i) {
    std::vector<double> row{table.column("sommerfeld_number")[i]};
    across.hold(row[0]);
    for (std::size_t k = 0; k < std::size(all); ++k) {
      row.push_back(std::abs(table.column(all[k].name)[i]));
      if (row.back() > 0) up[k / 4].hold(row.back());
    }
    f.blocks.back().row(row);
  }
  for (std::size_t k = 0; k < std::size(all); ++k)
    panels[k / 4].curves.push_back(
        {Script().add("DATA index 0 using 1:{} with lines ls {}", k + 2, k % 4 + 1), all[k].name,
         all[k].symbol});
  for (std::size_t k = 0; k < 2; ++k) panels[k].axis = decades_of(up[k].least, up[k].most);
  add_panels(f, style_of(folder),
             {.abscissa = {AxisTitle::of("Sommerfeld number", ""), decades_of(across.least, across.most)},
              .panels = {panels[0], panels[1]},
              .each = 5.0});
  return {draw(f, folder)};
}

}  // namespace

const Drawing film{{"film.csv"}, draw_film};

}  // namespace freeplay::plots
