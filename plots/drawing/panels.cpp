#include "plots/drawing/panels.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay::plots {
namespace {

// cm at the usual text size
constexpr double edge = 0.12;     // page to text
constexpr double tic_gap = 0.2;   // tics' labels to the frame
constexpr double between = 0.28;  // panels without texts between them
constexpr double key_line = 0.34, name_line = 0.36;
constexpr double tic_line = 0.42;  // labels of a horizontal axis
constexpr double least_panel = 1.1;
constexpr std::size_t sample = 5;  // letters that gnuplot adds to a title of a key: sample and gaps

/// Bands of a panel above and below its frame (cm at the usual text size).
struct Band {
  double above, below;
  KeyGrid key;
};

/// Letters of a line of this length (cm at the usual text size).
std::size_t letters_in(double length) {
  return static_cast<std::size_t>(std::max(length / letter_width, 3.0));
}

std::vector<std::string> titles_of(const Panel& panel) {
  std::vector<std::string> list;
  for (const auto& curve : panel.curves)
    if (!curve.title.empty()) list.push_back(curve.title);
  return list;
}

Script curves_of(const Panel& panel, std::size_t most) {
  Script plot;
  for (const auto& curve : panel.curves) {
    plot.add("{}{} ", plot.empty() ? Word("plot ") : Word(", "), curve.what);
    if (curve.title.empty())
      plot.add("notitle");
    else
      plot.add("title {} noenhanced", shortened(curve.title, most));
  }
  return plot.add("\n");
}

}  // namespace

KeyGrid key_grid(const std::vector<std::string>& titles, double width) {
  if (titles.empty()) return {};
  std::size_t longest = 0;
  for (const auto& title : titles) longest = std::max(longest, letters(title));
  const auto columns = std::clamp<std::size_t>(
      static_cast<std::size_t>(width / static_cast<double>(longest + sample)), 1, titles.size());
  return {(titles.size() + columns - 1) / columns, columns};
}

AxisTitle time_title() { return AxisTitle::of({"time t", "time $t$"}, "s"); }

AxisTitle crank_title() { return AxisTitle::of("crank angle", "°"); }

void add_panels(Figure& f, const Style& style, PanelStack stack) {
  const double scale = style.font_size / Style::usual_font_size;
  const double width = width_of(f, style) / scale;  // all lengths are cm at the usual text size
  const auto count = static_cast<double>(stack.panels.size());
  const double shrink = std::min(1.0, std::sqrt(width / f.width_cm));
  double height = stack.each * shrink;
  // Titles that do not fit beside their panel break before their unit, and the panel grows up to
  // twice its height for the rest.
  for (const auto& panel : stack.panels)
    if (const double needs = letter_width * static_cast<double>(panel.title.length + 1); needs > height)
      height = std::min(needs, 2 * stack.each * shrink);

  // The margins depend on the labels, and these on the size of the panels.
  double left = 1.6, right = 0.45;
  std::vector<Band> bands;
  double fixed = 0;
  for (int pass = 0; pass < 3; ++pass) {
    const double plot = std::max(width - left - right, 1.0);
    auto across = stack.abscissa;
    across.axis = with_tics(across.axis, 10, plot / letter_width);
    if (stack.equal_scales) {
      auto &x = across.axis, &y = stack.panels.front().axis;
      const double tall = std::clamp(plot * (y.high - y.low) / (x.high - x.low), 0.3 * plot, 1.2 * plot);
      height = tall;
    }
    bands.clear();
    fixed = 0;
    double widest = 0;
    for (std::size_t i = 0; i < stack.panels.size(); ++i) {
      auto& panel = stack.panels[i];
      const bool labelled = panel.abscissa || i + 1 == stack.panels.size();
      const auto key = key_grid(titles_of(panel), plot / letter_width);
      const auto& below = panel.abscissa ? *panel.abscissa : stack.abscissa;
      const double title_lines = below.title.fits(letters_in(plot)) ? 1 : 2;
      bands.push_back({(i == 0 ? 0.25 : 0.1) + key_line * static_cast<double>(key.rows) +
                           (panel.name.empty() ? 0 : name_line) +
                           (key.rows > 0 || !panel.name.empty() ? 0.08 : 0),
                       labelled ? tic_line + line_height * title_lines + edge + 0.1 : between, key});
      fixed += bands.back().above + bands.back().below;
      auto axis = with_tics(panel.axis, height / (1.45 * line_height));
      const double lines = panel.title.fits(letters_in(height)) ? 1 : 2;
      widest =
          std::max(widest, letter_width * static_cast<double>(longest_label(axis)) + line_height * lines);
    }
    if (style.height) height = std::max(0.1 * *style.height / scale - fixed, least_panel * count) / count;
    left = widest + tic_gap + edge + 0.18;
    right = std::max(0.3, 0.5 * letter_width * static_cast<double>(longest_label(across.axis)) + edge);
    for (const auto& panel : stack.panels)
      if (panel.abscissa) {
        const auto axis = with_tics(panel.abscissa->axis, 10, plot / letter_width);
        right = std::max(right, 0.5 * letter_width * static_cast<double>(longest_label(axis)) + edge);
      }
  }
  const double plot = std::max(width - left - right, 1.0);
  if (stack.equal_scales) {  // the axis with room to spare becomes longer
    auto &x = stack.abscissa.axis, &y = stack.panels.front().axis;
    const double per_cm = std::max((x.high - x.low) / plot, (y.high - y.low) / height);
    const auto widen = [](Axis& axis, double range) {
      const double more = 0.5 * (range - (axis.high - axis.low));
      axis.low -= more, axis.high += more;
    };
    widen(x, per_cm * plot);
    widen(y, per_cm * height);
  }
  f.width_cm = width_of(f, style);
  f.height_cm = style.height ? 0.1 * *style.height : scale * (fixed + count * height);
  f.sized = true;

  f.script.add(
      "set multiplot\nset lmargin at screen X({:.4g})\nset rmargin at screen 1-X({:.4g})\nPANEL = (1 - Y({:.4g}))/{}\n",
      left, right, fixed, stack.panels.size());
  double down = 0;
  for (std::size_t i = 0; i < stack.panels.size(); ++i) {
    const auto& panel = stack.panels[i];
    const auto& band = bands[i];
    down += band.above;
    f.script.add(
        "set tmargin at screen 1 - Y({0:.4g}) - {1}*PANEL\nset bmargin at screen 1 - Y({0:.4g}) - {2}*PANEL\n",
        down, i, i + 1);
    const double key_top = down - band.above + (i == 0 ? 0.1 : 0) + (panel.name.empty() ? 0 : name_line);
    if (band.key.rows > 0)
      f.script.add(
          "set key at graph 0.5, screen 1 - Y({:.4g}) - {}*PANEL center top horizontal maxcols {} maxrows {} samplen 2 spacing 1\n",
          key_top, i, band.key.columns, band.key.rows);
    else
      f.script.add("unset key\n");
    if (!panel.name.empty())
      f.script.add("set label 1 {} at graph 0, screen 1 - Y({:.4g}) - {}*PANEL left noenhanced\n",
                   shortened(panel.name, letters_in(plot)), key_top - 0.5 * name_line, i);
    const auto& below = panel.abscissa ? *panel.abscissa : stack.abscissa;
    f.script.add("{}", commands(with_tics(below.axis, 10, plot / letter_width), "x"));
    if (panel.abscissa || i + 1 == stack.panels.size())
      f.script.add("set xlabel {}\n", below.title.label(letters_in(plot)));
    else
      f.script.add("set format x ''\nunset xlabel\n");
    f.script.add("{}set ylabel {}\n{}", commands(with_tics(panel.axis, height / (1.45 * line_height)), "y"),
                 panel.title.label(letters_in(height)), curves_of(panel, letters_in(plot) - sample));
    if (!panel.name.empty()) f.script.add("unset label 1\n");
    down += band.below;
  }
  f.script.add("unset multiplot\n");
}

}  // namespace freeplay::plots
