// Paths of joints within their clearance: journals in the clearance circle, ends of sliders and
// pins between their walls (plots/tables/clearance_joints.hpp). Each joint has a row: for a
// comparison both formulations, first turn and last two turns; for a run the same spans of this
// run. Rows that do not fit on a page go to the next page.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "plots/drawing/axis.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/tables/clearance_joints.hpp"

namespace freeplay::plots {
namespace {

constexpr std::size_t most_joints = 12;
constexpr double tallest = 23;      ///< cm, of a page with a caption on A4
constexpr double least_cell = 2.9;  ///< cm
// cm around the cells at the usual text size: edges of the page, between cells, above and below a
// line of cells.
constexpr double left = 1.5, right = 0.3, gap_between = 0.3, below = 0.85, head = 0.05, foot = 0.1;

/// Room above a cell: the name of the joint, and the title of the panel in one or two lines.
double above(bool broken) { return broken ? 0.95 : 0.65; }

struct OrbitPanel {
  std::string run, span;  ///< title
  int style;
  const PlayPath* path;
};
struct Row {
  const ClearanceJoint* joint;
  std::vector<OrbitPanel> panels;
};

/// One sentence that explains the axes of all rows.
std::string frame_of(const std::vector<Row>& rows) {
  const auto any = [&](ClearanceJoint::Kind kind) {
    return std::ranges::any_of(rows, [&](const Row& r) { return r.joint->kind == kind; });
  };
  std::string said;
  if (any(ClearanceJoint::Kind::journal)) said = "journal centre relative to bearing centre (global axes)";
  if (any(ClearanceJoint::Kind::guide) || any(ClearanceJoint::Kind::slot))
    said += fmt::format("{}walls: {}", said.empty() ? "" : "; ",
                        any(ClearanceJoint::Kind::guide)
                            ? "positions of the slider's ends across the guide (frame of "
                              "the guide)"
                            : "position of the pin across the slot (frame of the slot)");
  return said;
}

std::string shown(double clearance) {
  return clearance < 1e-3 ? fmt::format("{:.4g} µm", 1e6 * clearance)
                          : fmt::format("{:.4g} mm", 1e3 * clearance);
}

/// Commands for axes, frame and walls of a row.
Script axes_of(const Row& row) {
  Script script;
  const bool journal = row.joint->kind == ClearanceJoint::Kind::journal;
  if (journal)
    return script.add(
        "set xrange [-1.2:1.2]\nset yrange [-1.2:1.2]\nset xtics 1\nset mxtics 2\nset grid xtics mxtics "
        "ytics mytics\n"
        "set xlabel '{}' offset 0,0.6\nset parametric\nset trange [0:2*pi]\nset samples 200\n",
        Word("e_x/c", "$e_x/c$"));
  double low = INFINITY, high = -INFINITY;
  for (const auto& p : row.panels) low = std::min(low, p.path->low), high = std::max(high, p.path->high);
  const double margin = std::max(0.06 * (high - low), 1e-6 * std::max(std::abs(low), std::abs(high)) + 1e-12);
  const bool placed = !row.joint->frame_name.empty();
  return script.add(
      "unset parametric\nset xrange [{0:.6g}:{1:.6g}]\nset yrange [-1.35:1.35]\nset xtics {2:.3g}\nunset "
      "mxtics\nset grid xtics nomxtics ytics nomytics\n"
      "set xlabel '{3}' offset 0,0.6\n"
      "set object 1 rectangle from graph 0, first 1 to graph 1, graph 1 fc rgb 0xdddddd fs solid 1 "
      "noborder behind\n"
      "set object 2 rectangle from graph 0, graph 0 to graph 1, first -1 fc rgb 0xdddddd fs solid 1 "
      "noborder behind\n",
      low - margin, high + margin, tic_step(high - low + 2 * margin),
      placed ? Word("along (mm)") : Word("time (ms)"));
}

/// Plot command of one panel. Adds its blocks to the figure.
Script plot_of(const Row& row, const OrbitPanel& panel, Figure& f) {
  Script plot;
  const bool journal = row.joint->kind == ClearanceJoint::Kind::journal;
  plot.add(
      "plot {}",
      journal
          ? Word("cos(t),sin(t) with lines lc rgb 0x888888 lw 1.2 notitle")
          : Word(
                "1 with lines lc rgb 0x444444 lw 1.2 notitle, -1 with lines lc rgb 0x444444 lw 1.2 notitle"));
  for (std::size_t i = 0; i < panel.path->blocks.size(); ++i) {
    if (panel.path->fixed[i])
      plot.add(", DATA index {} using 1:2 every ::0::0 with points pt 7 ps 0.8 lc rgb C{} notitle",
               f.blocks.size(), panel.style);
    else
      plot.add(", DATA index {} using 1:2 with lines lc rgb C{} lw {} dt {} notitle", f.blocks.size(),
               panel.style, i == 0 ? 0.8 : 1.1, i == 0 ? Word("1") : Word("(6,4)"));
    f.blocks.push_back(panel.path->blocks[i]);
  }
  return plot.add("\n");
}

/// Draws one page of rows.
std::filesystem::path page(const std::vector<Row>& rows, std::size_t first, std::size_t last,
                           std::size_t across, double width, double scale, bool broken,
                           const std::string& name, const std::string& caption,
                           const std::filesystem::path& folder, const char* source) {
  const double cell = (width - scale * (left + right + gap_between * static_cast<double>(across - 1))) /
                      static_cast<double>(across);
  const std::size_t lines_each = (rows[first].panels.size() + across - 1) / across;
  const double line = cell + scale * (above(broken) + below);
  const auto lines = static_cast<double>((last - first) * lines_each);
  Figure f{.name = name,
           .width_cm = width,
           .height_cm = lines * line + scale * (head + foot),
           .source = source,
           .caption = caption,
           .sized = true};
  f.script.add("set multiplot\nunset key\nset tics font SMALL offset 0,0\nset ytics 1\nset mytics 2\n");
  double down = scale * head;
  for (std::size_t r = first; r < last; ++r)
    for (std::size_t p = 0; p < rows[r].panels.size(); ++p) {
      const auto& row = rows[r];
      const std::size_t column = p % across;
      const bool journal = row.joint->kind == ClearanceJoint::Kind::journal;
      const double x = scale * left + static_cast<double>(column) * (cell + scale * gap_between),
                   y = down + scale * above(broken);
      f.script.add(
          "unset object 1\nunset object 2\n{}set lmargin at screen {:.5f}\nset rmargin at screen "
          "{:.5f}\nset tmargin at screen "
          "{:.5f}\nset bmargin at screen {:.5f}\n",
          axes_of(row), x / width, (x + cell) / width, 1 - y / f.height_cm, 1 - (y + cell) / f.height_cm);
      if (column == 0)
        f.script.add("set format y '%g'\nset ylabel '{}' offset 0.4\n",
                     journal ? Word("e_y/c", "$e_y/c$") : Word("across/c"));
      else
        f.script.add("set format y ''\nunset ylabel\n");
      if (p == 0)
        f.script.add(
            "set label 3 {} at graph 0, graph 1 offset 0,{} noenhanced\n",
            fmt::format(
                "{}, c = {}{}", row.joint->name, shown(row.panels[0].path->clearance),
                journal || row.joint->frame_name.empty() ? "" : ", walls on " + row.joint->frame_name),
            broken ? 2.45 : 1.55);
      const auto& panel = row.panels[p];
      f.script.add(
          "set label 4 {}.{}.{} at graph 0, graph 1 offset 0,{} font SMALL tc rgb 0x555555 "
          "noenhanced\n{}unset label "
          "3\n",
          panel.run + ",", broken ? Word("\"\\n\"") : Word("' '"), panel.span, broken ? 1.4 : 0.5,
          plot_of(row, panel, f));
      if (column + 1 == across || p + 1 == row.panels.size()) down += line;
    }
  f.script.add("unset multiplot\n");
  return draw(f, folder);
}

std::vector<std::filesystem::path> draw_journal_orbit(const std::filesystem::path& folder) {
  auto runs = runs_in(folder);
  const bool compared = std::filesystem::exists(folder / "comparison.json");
  std::erase_if(runs, [](const RunFolder& run) { return run.style == 3; });
  if (runs.empty()) return {};
  const auto scene = scene_of_run(runs.front().folder);
  auto joints = clearance_joints(runs.front().folder, scene.get());
  if (joints.size() > most_joints) joints.resize(most_joints);
  if (joints.empty()) return {};

  const auto turn = turn_of(scene.get());
  std::vector<std::vector<std::vector<PlayPath>>> paths;  // [run][joint][span]
  std::vector<Span> spans;
  // A run of at most one turn has only the first span, which is shown once.
  const bool once = std::ranges::all_of(runs, [&](const RunFolder& run) {
    const double end = end_of(run.folder);
    return first_part(turn, end).to >= end;
  });
  for (const auto& run : runs) {
    const double end = end_of(run.folder);
    spans = {last_part(turn, end, 2)};
    if (!once) spans.insert(spans.begin(), first_part(turn, end));
    paths.push_back(play_paths(run.folder, joints, spans));
  }
  std::vector<Row> rows;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    auto& row = rows.emplace_back(Row{&joints[j], {}});
    for (std::size_t k = 0; k < spans.size(); ++k)
      for (std::size_t r = 0; r < runs.size(); ++r)
        row.panels.push_back({runs[r].title, spans[k].name, runs[r].style, &paths[r][j][k]});
  }

  const auto style = style_of(folder);
  const double scale = style.font_size / Style::usual_font_size;
  const std::size_t panels = rows.front().panels.size();
  const double width = style.width ? 0.1 * *style.width : panels > 2 ? 16 : 9;
  std::size_t across = panels;
  const auto cell = [&] {
    const auto n = static_cast<double>(across);
    return (width - scale * (left + right + gap_between * (n - 1))) / n;
  };
  while (across > 1 && (cell() < least_cell || panels % across != 0)) --across;
  const bool broken = std::ranges::any_of(rows.front().panels, [&](const OrbitPanel& p) {
    return 0.9 * scale * letter_width * static_cast<double>(letters(p.run + p.span) + 2) > cell();
  });
  const std::size_t lines = (panels + across - 1) / across;
  const double line = (cell() + scale * (above(broken) + below)) * static_cast<double>(lines);
  const auto each =
      static_cast<std::size_t>(std::max(1.0, std::floor((tallest - scale * (head + foot)) / line)));
  std::string said = frame_of(rows);
  for (const auto& span : spans)
    said += fmt::format("; {}: {:.4g} to {:.4g} s", span.name, span.from, span.to);
  if (std::ranges::any_of(joints,
                          [](const ClearanceJoint& j) { return j.kind == ClearanceJoint::Kind::guide; }))
    said += "; rear end solid, front end dashed";
  said += ".";
  std::vector<std::filesystem::path> made;
  for (std::size_t from = 0; from < rows.size(); from += each)
    made.push_back(page(rows, from, std::min(from + each, rows.size()), across, width, scale, broken,
                        from == 0 ? "journal_orbit" : fmt::format("journal_orbit_{}", 1 + from / each), said,
                        folder, compared ? "comparison.json" : "run.json"));
  return made;
}

}  // namespace

const Drawing journal_orbit{{"comparison.json", "run.json"}, draw_journal_orbit};

}  // namespace freeplay::plots
