// Contact and friction laws: hysteresis loops of one free impact, resulting over given restitution,
// friction over sliding speed. The key names each curve by dash and colour.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "io/files/input_file.hpp"
#include "mechanism/laws.hpp"
#include "plots/drawing/axis.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/drawing/style.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

struct Curves {
  std::vector<std::string> names;
  std::vector<Block> blocks;
};

/// One block per law, in the order of the file; x and y scaled. `contact`: of a file with such a column,
/// the rows to read; empty: all.
Curves read_curves(const std::filesystem::path& file, const std::string& x, const std::string& y, double sx,
                   double sy, const std::string& contact = "") {
  std::vector<std::string> texts{"law"};
  if (!contact.empty()) texts.emplace_back("contact");
  const ReadTable table(file, texts, {x, y});
  const auto& law = table.text("law");
  const auto &a = table.column(x), &b = table.column(y);
  Curves c;
  for (std::size_t i = 0; i < law.size(); ++i) {
    if (!contact.empty() && table.text("contact")[i] != contact) continue;
    if (c.names.empty() || c.names.back() != law[i]) {
      c.names.push_back(law[i]);
      c.blocks.emplace_back(fmt::format("{}: {}, {}", law[i], x, y));
    }
    c.blocks.back().row({sx * a[i], sy * b[i]});
  }
  return c;
}

constexpr Word law_colours[] = {"C1", "C2", "C4", "C5", "C3", "0x888888", "C8"};
constexpr Word law_dashes[] = {"1", "(14,5)", "(3,4)", "(14,4,3,4)"};

/// Colour, dash and width of a curve.
Script look_of(std::size_t style) {
  return Script().add("lc rgb {} dt {} lw 1.4", law_colours[style % std::size(law_colours)],
                      law_dashes[style % std::size(law_dashes)]);
}

/// Adds the plot command for all curves of one kind.
void plot(const Curves& c, bool (*chosen)(const std::string&), Script& script) {
  std::size_t style = 0;
  for (std::size_t i = 0; i < c.names.size(); ++i) {
    if (!chosen(c.names[i])) continue;
    script.add("{}DATA index {} using 1:2 with lines {} title {} noenhanced",
               style == 0 ? Word("plot ") : Word(", "), i, look_of(style), c.names[i]);
    ++style;
  }
  script.add("\n");
}

bool line_contact(const std::string& name) {
  const auto law = std::ranges::find(contact_laws(), name, &ContactLawFacts::text);
  return law != contact_laws().end() && law->kind == ContactKind::line;
}

/// Position of the key: beside the panel, or, in a narrow figure, below it in the columns for which
/// there is room, at most two. at(k) is that of panel k.
struct Legend {
  bool below;
  std::size_t panels, rows;

  Legend(const Figure& f, const Style& style, std::size_t panels, const std::vector<std::string>& names,
         std::size_t laws)
      : below(is_narrow(f, style)), panels(panels), rows((laws + 1) / 2) {
    constexpr double small = 0.88, sides = 1.1;  // share of the text size; cm
    const double width = width_of(f, style) * Style::usual_font_size / style.font_size - sides;
    if (key_grid(names, width / (small * letter_width)).columns < 2) rows = laws;
  }
  /// cm by which the figure is higher for a key in one column
  double more(std::size_t laws) const {
    return below && rows == laws ? 0.17 * static_cast<double>(panels * laws) : 0;
  }
  double height() const { return below ? 0.4 + 0.28 * static_cast<double>(rows) : 0; }  ///< cm
  Script at(std::size_t k) const {
    if (!below) return Script().add("set key outside right top vertical Left reverse\n");
    const auto n = static_cast<double>(panels);
    return Script().add(
        "B = Y({0}); S = Y({1}); H = (1 - Y(0.9) - B - {2}*S)/{3}\n"
        "set key at screen X(0.9), screen B + {4}*(H + S) - Y(1.25) left top vertical Left reverse "
        "maxrows {5} samplen 2 "
        "font SMALL\n",
        1.6 + height(), 2.4 + height(), n - 1, n, n - 1 - static_cast<double>(k), rows);
  }
};

/// The figure of the contacts of one group of laws.json.
std::filesystem::path impact_loops(const std::filesystem::path& folder, const JsonFile& facts,
                                   std::size_t group) {
  const auto at = fmt::format("contacts.{}.", group);
  const auto names = facts.texts(at + "names");
  if (names.empty()) facts.fail(at + "names", "must name a contact");
  const auto c = read_curves(folder / "impact_loops.csv", "delta", "force", 1e6, 1e-3, names.front());
  if (c.names.empty()) facts.fail(at + "names", "must be in impact_loops.csv");
  const bool lines = std::ranges::any_of(c.names, line_contact);
  Figure f{
      .name = facts.find("contacts")->size() > 1 ? file_name("impact_loops", names.front()) : "impact_loops",
      .height_cm = lines ? 19.0 : 10.0,
      .blocks = c.blocks,
      .source = "laws.json"};
  const auto style = style_of(folder);
  const std::size_t panels = lines ? 2 : 1;
  const auto of_lines = static_cast<std::size_t>(std::ranges::count_if(c.names, line_contact));
  const auto laws = std::max(of_lines, c.names.size() - of_lines);
  const Legend key(f, style, panels, c.names, laws);
  if (key.below) f.height_cm = 1.4 * f.height_cm + key.more(laws);
  f.caption = fmt::format("Impacts of {:.4g} kg at {:.4g} m/s in {}, given e = {:.3g}.",
                          facts.number("mass_kg"), facts.number("approach_m_per_s"), fmt::join(names, ", "),
                          facts.number(at + "restitution_asked"));
  f.script.add(
      "set multiplot layout {},1 margins X(1.7),1-X({}),Y({}),1-Y(0.9) spacing 0,Y({})\n{}set xlabel "
      "'{}'\nset ylabel "
      "'{}'\nset xrange [0:*]\nset yrange [0:*]\nset title 'point contacts'\n",
      panels, key.below ? 0.5 : 4.6, key.below ? 1.6 + key.height() : 1.15, 2.4 + key.height(), key.at(0),
      Word("penetration δ (µm)", "penetration $\\delta$ (µm)"),
      Word("normal force F_N (kN)", "normal force $F_N$ (kN)"));
  plot(
      c, [](const std::string& n) { return !line_contact(n); }, f.script);
  if (lines) {
    f.script.add("{}set title 'line contacts'\n", key.at(1));
    plot(c, line_contact, f.script);
  }
  f.script.add("unset multiplot\n");
  return draw(f, folder);
}

bool any(const std::string&) { return true; }

std::filesystem::path delivered_restitution(const std::filesystem::path& folder) {
  const auto c = read_curves(folder / "delivered.csv", "requested", "delivered", 1, 1);
  Figure f{.name = "delivered_restitution", .height_cm = 10, .blocks = c.blocks, .source = "laws.json"};
  const Legend key(f, style_of(folder), 1, c.names, c.names.size());
  if (key.below) f.height_cm = 1.4 * f.height_cm + key.more(c.names.size());
  f.script.add("{}", key.at(0));
  if (key.below) f.script.add("set bmargin at screen B\nset tmargin at screen 1-Y(0.4)\n");
  f.script.add(
      "set xlabel 'given restitution e'\n"
      "set ylabel 'restitution of a free impact'\nset xrange [0:1]\nset yrange [0:1.02]\n");
  plot(c, any, f.script);
  return draw(f, folder);
}

std::filesystem::path friction_laws(const std::filesystem::path& folder) {
  const auto c = read_curves(folder / "friction.csv", "speed", "coefficient", 1e3, 1);
  Figure f{.name = "friction_laws", .blocks = c.blocks, .source = "laws.json"};
  const ReadTable table(folder / "friction.csv", {}, {"speed", "coefficient"});
  const Limits speed(table.column("speed")), force(table.column("coefficient"));
  Panel panel{.title = AxisTitle::of({"friction force F_T/(µF_N)", "friction force $F_T/(\\mu F_N)$"}, ""),
              .axis = axis_of(std::min(force.least, -1.0), std::max(force.most, 1.0)),
              .curves = {}};
  for (std::size_t i = 0; i < c.names.size(); ++i)
    panel.curves.push_back(
        {Script().add("DATA index {} using 1:2 with lines {}", i, look_of(i)), c.names[i]});
  return draw_panels(
      f, folder,
      {.abscissa = {AxisTitle::of("sliding speed", "mm/s"), {1e3 * speed.least, 1e3 * speed.most}},
       .panels = {std::move(panel)},
       .each = 6.5});
}

std::vector<std::filesystem::path> draw_laws(const std::filesystem::path& folder) {
  const JsonFile facts(folder / "laws.json");
  const auto* groups = facts.find("contacts");
  if (!groups || !groups->is_array() || groups->empty()) facts.fail("contacts", "must be a list of contacts");
  std::vector<std::filesystem::path> figures;
  for (std::size_t i = 0; i < groups->size(); ++i) figures.push_back(impact_loops(folder, facts, i));
  figures.push_back(delivered_restitution(folder));
  figures.push_back(friction_laws(folder));
  return figures;
}

// Stiffness and damping of a lubricated joint in steady running over the Sommerfeld number.

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
  return {draw_panels(
      f, folder,
      {.abscissa = {AxisTitle::of("Sommerfeld number", ""), decades_of(across.least, across.most)},
       .panels = {panels[0], panels[1]},
       .each = 5.0})};
}

}  // namespace

const Drawing laws{{"laws.json"}, draw_laws};
const Drawing film{{"film.csv"}, draw_film};

}  // namespace freeplay::plots
