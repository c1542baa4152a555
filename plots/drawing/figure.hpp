// A figure of a result folder. It reads result files only. It writes its data (NAME.dat), the
// script that redraws it (NAME.gp: run gnuplot on it in its own folder), the formats listed in
// style.toml (default: PDF), and a PNG for viewing. The format cairolatex writes NAME_latex.tex,
// which a LaTeX document includes by \input, with its PDF and script.
//
// The script contains only text that this program wrote (plots/drawing/gnuplot.hpp); numbers reach
// gnuplot in the data file. gnuplot runs without start-up files in a folder of its own,
// figures/NAME.partial; the files are moved to their place when they are complete. The script
// defines
//
//     WIDTH, HEIGHT     cm on paper
//     SIZE              pt of texts; SMALL, TINY: fonts
//     X(cm), Y(cm)      share of the page of a length in cm at the usual text size, for margins
//     ORIGIN, CAPTION   program, commit and scene; what the figure shows
//     C1 … C9           colours of curves; line styles: 1 penalty, 2 nonsmooth, 3 ideal,
//                       4 auxiliary lines
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "plots/drawing/gnuplot.hpp"
#include "plots/drawing/style.hpp"
#include "values/stop.hpp"

namespace freeplay::plots {

/// A block of the data file, which gnuplot addresses by its index: a comment with the names of the
/// columns, then rows.
class Block {
 public:
  explicit Block(std::string_view heading);
  Block& row(std::initializer_list<double> values) { return row(std::vector<double>(values)); }
  Block& row(const std::vector<double>& values);
  /// Adds a blank line: a gap in a curve, or the end of one line of a surface.
  Block& gap();
  bool empty() const { return !filled_; }  ///< whether there are no rows
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  bool filled_ = false;
};

struct Figure {
  std::string name;                     ///< of the files, made by file_name()
  double width_cm = 16, height_cm = 9;  ///< used unless the style overrides it
  std::vector<Block> blocks = {};
  Script script = {};       ///< commands after the style; DATA is the data file
  std::string source = {};  ///< JSON file of the folder with the provenance
  /// What the figure shows, for the script and the properties of the PDF: spans, means, points
  /// outside the ranges. Figures hold no sentences of their own, because papers have captions.
  std::string caption = {};
  std::string title = {};  ///< above the panels of add_panels(); empty: none
  /// scene file if a folder has several; empty: that of the source
  std::string scene_file = {};
  std::vector<Format> formats = {};  ///< replaces the formats of the style
  bool sized = false;                ///< whether its size already follows the style
};

/// The name of a figure's files: `kind` and the safe_name() of its subject `of`.
std::string file_name(std::string_view kind, std::string_view of);

/// Distance of tics on a short axis: 1, 2, 2.5 or 5 times a power of ten, such that the range has
/// two to five tics, on a narrow figure at most three.
double tic_step(double range, bool narrow = false);

/// Width of the figure with this style (cm).
double width_of(const Figure& figure, const Style& style);
/// Whether the figure has room for at most about 60 letters per line, like one column of a journal.
bool is_narrow(const Figure& figure, const Style& style);

/// Writes and draws the figure into folder/figures; returns the path of its first format. Throws
/// OutputError if gnuplot fails, SceneError for an invalid style.toml.
std::filesystem::path draw(const Figure& figure, const std::filesystem::path& folder);

/// Figures of one kind. Each kind has one line in figures.def.
struct Drawing {
  std::vector<const char*> needs;  ///< result files; drawn if the folder has any of them
  /// Draws the figures of a folder and returns their paths; empty if the folder has nothing to
  /// show.
  std::vector<std::filesystem::path> (*draw)(const std::filesystem::path& folder);
};

#define FIGURES(name) extern const Drawing name;
#include "plots/figures/figures.def"
#undef FIGURES

/// Draws all figures that the result files of a folder allow, kinds of figures on all cores. After a
/// stop request no further kind is begun. If figures fail, the others are drawn before the error of
/// the first one, in the order of figures.def, is thrown.
std::vector<std::filesystem::path> all(const std::filesystem::path& folder, const StopToken& stop = {});

/// Removes the figures that all() has drawn of a single run in the folder. Files of the user
/// remain: style.toml and figures of chosen columns.
void remove_of_run(const std::filesystem::path& folder);

}  // namespace freeplay::plots
