#include "plots/drawing/panels.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

namespace freeplay::plots {
namespace {

// cm at the usual text size
constexpr double edge = 0.12;                       // page to text
constexpr double tic_gap = 0.2;                     // tics' labels to the frame
constexpr double between = 0.28;                    // panels without texts between them
constexpr double key_line = 0.3, name_line = 0.36;  // gnuplot's lines of a key are 0.288 apart
constexpr double tic_line = 0.42;                   // labels of a horizontal axis
constexpr double least_panel = 1.1;
constexpr double small = 0.88;              // size of SMALL letters
constexpr std::size_t long_key = 4;         // rows from which on a key has small letters
constexpr double second_line = 0.12;        // more room for a title of two lines
constexpr double bar_gap = 0.2, bar = 0.3;  // scale of colours
constexpr std::size_t most_title_lines = 3;
constexpr int title_label = 91;    // first number of the labels of the figure's title
constexpr std::size_t sample = 5;  // letters that gnuplot adds to a title of a key: sample and gaps

/// Letters of a line of this length (cm at the usual text size).
std::size_t letters_in(double length) {
  return static_cast<std::size_t>(std::max(length / letter_width, 3.0));
}

std::vector<std::string> titles_of(const std::vector<PanelCurve>& curves) {
  std::vector<std::string> list;
  for (const auto& curve : curves)
    if (!curve.title.empty()) list.push_back(curve.title);
  return list;
}

/// A plot command; with `keyed`, of the key alone. `most`: letters of a title.
Script curves_of(const std::vector<PanelCurve>& curves, std::size_t most, bool keyed = false) {
  Script plot;
  if (keyed) plot.add("plot -1 notitle");
  for (const auto& curve : curves) {
    plot.add("{}{}{} ", plot.empty() ? Word("plot ") : Word(", "), keyed ? Word("keyentry ") : Word(""),
             curve.what);
    if (curve.title.empty())
      plot.add("notitle");
    else if (*curve.symbol.text())
      plot.add("title '{}'", curve.symbol);
    else
      plot.add("title {} noenhanced", shortened(curve.title, most));
  }
  return plot.add("\n");
}

/// The lines of a title, broken at spaces, each of at most `most` letters; the last one is shortened.
std::vector<std::string> title_lines(const std::string& title, std::size_t most) {
  std::vector<std::string> lines;
  std::istringstream words(title);
  for (std::string word; words >> word;) {
    const bool fits = !lines.empty() && letters(lines.back()) + 1 + letters(word) <= most;
    if (fits || lines.size() == most_title_lines)
      lines.back() += " " + word;
    else
      lines.push_back(word);
  }
  for (auto& line : lines) line = shortened(line, most);
  return lines;
}

bool same(const AxisTitle& a, const AxisTitle& b) {
  return a.text.text() == b.text.text() && a.unit == b.unit;
}

/// The sizes of a grid of panels, cm at the usual text size. The margins depend on the labels, and
/// these on the size of the panels.
class Grid {
 public:
  /// `width`, `height`: of the page; `each`: of a panel.
  Grid(PanelStack& stack, const std::string& title, std::size_t columns, double width, double each,
       std::optional<double> height)
      : stack_(stack),
        title_(title_lines(title, letters_in(width - 4 * edge))),
        width_(width),
        columns_(columns),
        sides_(columns) {
    const auto& panels = stack.panels;
    height_ = each;
    for (const auto& panel : panels)  // grow for titles that do not fit even without their unit
      for (const auto* title : {&panel.title, panel.colours ? &panel.colours->title : nullptr})
        if (const double needs = title ? letter_width * static_cast<double>(title->length + 1) : 0;
            needs > height_)
          height_ = std::min(needs, 2 * each);
    for (int pass = 0; pass < 3; ++pass) measure(height);
    if (stack.equal_scales) extend_axes();
  }

  /// Whether the labels below the panels and the names above them have room.
  bool has_room() const {
    for (std::size_t i = 0; i < stack_.panels.size(); ++i) {
      const auto axis = across(i);
      const double room = plot() + 2 * least_right, name = plot() + sides_[column(i)].right - edge;
      if (plot() < letter_width * (2 * static_cast<double>(longest_label(axis)) + 3.4) ||
          room < letter_width * static_cast<double>(abscissa(i).title.length) ||
          name < letter_width * static_cast<double>(letters(stack_.panels[i].name)))
        return false;
    }
    return true;
  }

  double page_height() const { return fixed() + static_cast<double>(bands_.size()) * height_; }

  /// Adds the commands of all panels.
  void add(Script& script) const;

 private:
  static constexpr double least_right = 0.3;
  struct Side {
    double left = 1.6, right = 0.45;
  };
  /// Bands of a row above and below its frames.
  struct Band {
    double above = 0, below = 0, key = 0;
    bool named = false;
  };

  std::size_t column(std::size_t i) const { return i % columns_; }
  const Abscissa& abscissa(std::size_t i) const {
    const auto& panel = stack_.panels[i];
    return panel.abscissa ? *panel.abscissa : stack_.abscissa;
  }
  bool labelled(std::size_t i) const {
    return stack_.panels[i].abscissa || i + columns_ >= stack_.panels.size();
  }
  /// Whether the panel has a title of its ordinate.
  bool titled(std::size_t i) const {
    return column(i) == 0 || !same(stack_.panels[i].title, stack_.panels[i - 1].title);
  }
  /// Whether the panel has a bar of its colours.
  bool barred(std::size_t i) const {
    const auto& mine = stack_.panels[i].colours;
    if (!mine) return false;
    if (i + 1 == stack_.panels.size() || column(i + 1) == 0) return true;
    const auto& next = stack_.panels[i + 1].colours;
    return !next || !same(mine->title, next->title) || mine->axis.low != next->axis.low ||
           mine->axis.high != next->axis.high;
  }
  double sides() const {
    double sum = 0;
    for (const auto& side : sides_) sum += side.left + side.right;
    return sum;
  }
  double fixed() const {
    double sum = top();
    for (const auto& band : bands_) sum += band.above + band.below;
    return sum;
  }
  double plot() const { return std::max((width_ - sides()) / static_cast<double>(columns_), 1.0); }
  /// Letters of a title below a panel; side by side, it may extend over the margins.
  std::size_t letters_below() const { return letters_in(plot() + (columns_ > 1 ? 2 * least_right : 0)); }
  Axis across(std::size_t i) const { return with_tics(abscissa(i).axis, 10, plot() / letter_width); }
  Axis up(const Axis& axis) const { return with_tics(axis, height_ / (1.45 * line_height)); }
  double lines_of(const AxisTitle& title) const { return title.fits(letters_in(height_)) ? 1 : 2; }
  /// A key: its rows and columns, in letters of this size.
  struct Key {
    KeyGrid grid;
    double size = 1;
    double height() const { return key_line * size * static_cast<double>(grid.rows); }
    Word font() const { return size < 1 ? Word(" font SMALL") : Word(""); }
  };
  /// The key above a plot of this width (cm). Letters are small if it is long, or has several columns in
  /// small letters only.
  static Key key_over(const std::vector<PanelCurve>& curves, double width) {
    const auto titles = titles_of(curves);
    const auto usual = key_grid(titles, width / letter_width),
               dense = key_grid(titles, width / (small * letter_width));
    if (usual.rows >= long_key || (usual.columns == 1 && dense.columns > 1)) return {dense, small};
    return {usual};
  }
  Key key_of(std::size_t i) const { return key_over(stack_.panels[i].curves, plot()); }
  /// The key of the whole figure.
  Key top_key() const { return key_over(stack_.key, width_ - 4 * edge); }
  double heading() const { return title_.empty() ? 0 : name_line * static_cast<double>(title_.size()) + 0.1; }
  double top() const { return heading() + (stack_.key.empty() ? 0 : top_key().height() + 0.1); }

  /// From the top of a band to its first text.
  double pad(const Band& band) const { return &band == bands_.data() ? 0.1 : band.key > 0 ? 0.12 : 0; }

  /// One pass: margins for the present size of the panels.
  void measure(std::optional<double> page) {
    const double plot = this->plot();
    if (stack_.equal_scales) {
      const auto &x = stack_.abscissa.axis, &y = stack_.panels.front().axis;
      height_ = std::clamp(plot * (y.high - y.low) / (x.high - x.low), 0.3 * plot, 1.2 * plot);
    }
    bands_.assign((stack_.panels.size() + columns_ - 1) / columns_, {});
    std::vector<Side> next(columns_, {0, least_right});
    for (std::size_t i = 0; i < stack_.panels.size(); ++i) {
      const auto& panel = stack_.panels[i];
      auto& band = bands_[i / columns_];
      band.key = std::max(band.key, key_of(i).height());
      band.named = band.named || !panel.name.empty();
      const double title_lines = abscissa(i).title.fits(letters_below()) ? 1 : 2;
      band.below =
          std::max(band.below, labelled(i) ? tic_line + line_height * title_lines + edge + 0.1 : between);
      auto& side = next[column(i)];
      const auto label = [](const Axis& axis) {
        return letter_width * static_cast<double>(longest_label(axis));
      };
      const double lines = titled(i) ? lines_of(panel.title) : 0;
      side.left = std::max(side.left, label(up(panel.axis)) + line_height * lines +
                                          (lines > 1 ? second_line : 0) + tic_gap + edge + 0.18);
      side.right = std::max(side.right, 0.5 * label(across(i)) + edge);
      if (barred(i))
        side.right = std::max(side.right, bar_gap + bar + tic_gap + label(up(panel.colours->axis)) +
                                              line_height * lines_of(panel.colours->title) + edge + 0.18);
    }
    for (auto& band : bands_) {
      const bool first = &band == bands_.data();
      band.above = pad(band) + (first ? 0.15 : 0.1) + band.key + (band.named ? name_line : 0) +
                   (band.key > 0 || band.named ? 0.08 : 0);
    }
    const auto rows = static_cast<double>(bands_.size());
    if (page) height_ = std::max(*page - fixed(), least_panel * rows) / rows;
    sides_ = std::move(next);
  }

  /// The axis with room to spare becomes longer, for equal scales.
  void extend_axes() {
    auto &x = stack_.abscissa.axis, &y = stack_.panels.front().axis;
    const double per_cm = std::max((x.high - x.low) / plot(), (y.high - y.low) / height_);
    for (auto& [axis, length] : {std::pair<Axis&, double>(x, plot()), {y, height_}}) {
      const double more = 0.5 * (per_cm * length - (axis.high - axis.low));
      axis.low -= more, axis.high += more;
    }
  }

  PanelStack& stack_;
  std::vector<std::string> title_;  // lines
  double width_, height_ = 0;
  std::size_t columns_;
  std::vector<Side> sides_;
  std::vector<Band> bands_;
};

void Grid::add(Script& script) const {
  script.add("set multiplot\nPANEL = (1 - Y({:.4g}))/{}\nACROSS = (1 - X({:.4g}))/{}\n", fixed(),
             bands_.size(), sides(), columns_);
  Script untitled;  // every plot would draw the title again
  for (std::size_t i = 0; i < title_.size(); ++i) {
    script.add("set label {} {} at screen 0.5, screen 1 - Y({:.4g}) center noenhanced\n", title_label + i,
               title_[i], 0.1 + name_line * (static_cast<double>(i) + 0.5));
    untitled.add("unset label {}\n", title_label + i);
  }
  if (!stack_.key.empty()) {
    const auto key = top_key();
    script.add(
        "set lmargin at screen X({0:.4g})\nset rmargin at screen 1 - X({0:.4g})\nset tmargin at screen "
        "1\nset bmargin at screen 0\n"
        "unset border\nunset tics\nset xrange [0:1]\nset yrange [0:1]\nset key at screen 0.5, screen 1 - "
        "Y({1:.4g}) center top "
        "horizontal maxcols {2} maxrows {3} samplen 2 spacing 1{5}\n{4}set border\nset xtics nomirror\nset "
        "ytics nomirror\n{6}",
        edge, heading() + 0.1, key.grid.columns, key.grid.rows,
        curves_of(stack_.key, letters_in(width_) - sample, true).add("{}", std::exchange(untitled, {})),
        key.font(), key.size < 1 ? Word("set key font ''\n") : Word(""));
  }
  double down = top(), right = 0;
  for (std::size_t i = 0; i < stack_.panels.size(); ++i) {
    const auto& panel = stack_.panels[i];
    const auto row = i / columns_, k = column(i);
    const auto& band = bands_[row];
    if (k == 0) {
      right = 0;
      down += band.above + (row > 0 ? bands_[row - 1].below : 0);
    }
    right += sides_[k].left + (k > 0 ? sides_[k - 1].right : 0);
    script.add(
        "set lmargin at screen X({0:.4g}) + {1}*ACROSS\nset rmargin at screen X({0:.4g}) + {2}*ACROSS\n"
        "set tmargin at screen 1 - Y({3:.4g}) - {4}*PANEL\nset bmargin at screen 1 - Y({3:.4g}) - "
        "{5}*PANEL\n",
        right, k, k + 1, down, row, row + 1);
    const double name_top = down - band.above + pad(band);
    const double key_top = name_top + (band.named ? name_line : 0);
    const auto key = key_of(i);
    if (key.grid.rows > 0)
      script.add(
          "set key at graph 0.5, screen 1 - Y({:.4g}) - {}*PANEL center top horizontal maxcols {} maxrows "
          "{} samplen 2 spacing 1{}\n",
          key_top, row, key.grid.columns, key.grid.rows, key.size < 1 ? key.font() : Word(" font ''"));
    else
      script.add("unset key\n");
    if (!panel.name.empty())
      script.add("set label 1 {} at graph 0, screen 1 - Y({:.4g}) - {}*PANEL left noenhanced\n",
                 shortened(panel.name, letters_in(plot() + sides_[k].right - edge)),
                 name_top + 0.5 * name_line, row);
    auto x = across(i);
    if (!labelled(i))
      for (auto& tic : x.tics) tic.label.clear();
    script.add("{}", commands(x, "x"));
    if (labelled(i))
      script.add("set xlabel {}\n", abscissa(i).title.label(letters_below()));
    else
      script.add("set format x ''\nunset xlabel\n");
    script.add("{}", commands(up(panel.axis), "y"));
    if (titled(i))
      script.add("set ylabel {}{}\n", panel.title.label(letters_in(height_)),
                 lines_of(panel.title) > 1 ? Word(" offset -0.6") : Word(" offset 0"));
    else
      script.add("unset ylabel\n");
    if (barred(i))
      script.add(
          "set colorbox user origin screen X({:.4g}) + {}*ACROSS, screen 1 - Y({:.4g}) - {}*PANEL size "
          "screen X({}), screen PANEL\n"
          "set cblabel {} offset 0.8\n",
          right + bar_gap, k + 1, down, row + 1, bar, panel.colours->title.label(letters_in(height_)));
    else if (panel.colours)
      script.add("unset colorbox\n");
    if (panel.colours) script.add("{}", commands(up(panel.colours->axis), "cb"));
    script.add("{}{}", panel.before, curves_of(panel.curves, letters_in(plot()) - sample));
    if (!panel.name.empty()) script.add("unset label 1\n");
    script.add("{}", std::exchange(untitled, {}));
  }
  script.add("unset multiplot\n");
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

void add_curve(Figure& figure, Panel& panel, Block block, const Script& how, std::string title) {
  if (block.empty()) return;
  panel.curves.push_back({Script().add("DATA index {} {}", figure.blocks.size(), how), std::move(title)});
  figure.blocks.push_back(std::move(block));
}

AxisTitle time_title() { return AxisTitle::of({"time t", "time $t$"}, "s"); }

AxisTitle crank_title() { return AxisTitle::of("crank angle", "°"); }

void add_panels(Figure& f, const Style& style, PanelStack stack) {
  const double scale = style.font_size / Style::usual_font_size;
  const double width = width_of(f, style) / scale;  // all lengths are cm at the usual text size
  const double each = stack.each * std::min(1.0, std::sqrt(width / f.width_cm));
  std::optional<double> height;
  if (style.height) height = 0.1 * *style.height / scale;
  auto columns = std::clamp<std::size_t>(stack.columns, 1, stack.panels.size());
  while (columns > 1 && !Grid(stack, f.title, columns, width, each, height).has_room()) --columns;
  const Grid grid(stack, f.title, columns, width, each, height);
  f.width_cm = width_of(f, style);
  f.height_cm = height ? 0.1 * *style.height : scale * grid.page_height();
  f.sized = true;
  grid.add(f.script);
}

std::filesystem::path draw_panels(Figure& f, const std::filesystem::path& folder, PanelStack stack) {
  add_panels(f, style_of(folder), std::move(stack));
  return draw(f, folder);
}

}  // namespace freeplay::plots
