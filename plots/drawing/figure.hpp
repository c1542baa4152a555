// A figure of a result folder. It reads result files only, and leaves its data (NAME.dat), the script that
// redraws it (NAME.gp: run gnuplot on it in its own folder), the formats that style.toml asks for (a PDF without one) and a
// PNG to look at. Of cairolatex it leaves NAME_latex.tex, which a LaTeX document takes by \input, with its PDF and script.
//
// The script holds what this program wrote and no more (plots/drawing/script.hpp); numbers go to gnuplot in the data file. It is
// drawn in a folder of its own, figures/NAME.partial, by gnuplot without start-up files, and put in its place when it is
// whole. It knows
//
//     WIDTH, HEIGHT     cm on paper                   SIZE              pt of texts; SMALL, TINY: fonts of lesser ones
//     X(cm), Y(cm)      share of the page that is taken by what is so long at the usual size of texts: margins
//     C1 … C9           colours of curves; line styles 1 to 3 are those of penalty, nonsmooth, ideal, 4 of help lines
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "plots/drawing/script.hpp"
#include "plots/drawing/style.hpp"
#include "values/stop.hpp"

namespace freeplay::plots {

/// Numbers of a data file that gnuplot finds by their index: rows behind a comment that names their columns.
class Block {
 public:
  explicit Block(std::string_view heading);
  Block& row(std::initializer_list<double> values) { return row(std::vector<double>(values)); }
  Block& row(const std::vector<double>& values);
  /// A blank line: where a curve is broken, or one of a surface's ends.
  Block& gap();
  bool empty() const { return !filled_; }  ///< has no rows
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  bool filled_ = false;
};

struct Figure {
  std::string name;                     ///< of its files, as file_name() makes it
  double width_cm = 16, height_cm = 9;  ///< without a style that says otherwise
  std::vector<Block> blocks = {};
  Script script = {};                ///< commands after the style; DATA is the data file
  std::string source = {};           ///< the folder's JSON file whose provenance it names
  std::string scene_file = {};       ///< of the case, where a folder has several; else the one of the source
  std::vector<Format> formats = {};  ///< in place of the style's
  bool sized = false;                ///< its size follows the style already
};

/// The name of a figure's files: `kind`, and what it is of. Letters, digits, _ - and . alone and of bounded length, other
/// for every other text.
std::string file_name(std::string_view kind, std::string_view of);
/// What file_name puts behind the kind.
std::string safe_name(std::string_view of);

/// Distance of tics on a short axis: 1, 2, 2.5 or 5 times a power of ten, of which a range holds two to five; on a narrow
/// one at most three.
double tic_step(double range, bool narrow = false);

/// The format of a logarithmic axis.
inline constexpr Word powers{"'10^{%T}'", "'$10^{%T}$'"};

/// How wide it gets (cm).
double width_of(const Figure& figure, const Style& style);
/// Whether it has room for no more than about 60 letters beside each other, as one column of a journal.
bool is_narrow(const Figure& figure, const Style& style);

/// Writes and draws the figure into folder/figures; returns the path of its first format. Throws OutputError when gnuplot
/// fails, SceneError for a style.toml that is wrong.
std::filesystem::path draw(const Figure& figure, const std::filesystem::path& folder);

/// Figures of one kind. Each stands in a file of its own under plots/, and its name on one line of figures.def.
struct Drawing {
  std::vector<const char*> needs;  ///< result files: it is drawn where the folder has any of them
  /// Draws it from these and what stands beside them; no paths when they have nothing to show in it.
  std::vector<std::filesystem::path> (*draw)(const std::filesystem::path& folder);
};

#define FIGURES(name) extern const Drawing name;
#include "plots/figures/figures.def"
#undef FIGURES

/// All figures that the result files of a folder allow; asked to stop, it draws no further one.
std::vector<std::filesystem::path> all(const std::filesystem::path& folder);
std::vector<std::filesystem::path> all(const std::filesystem::path& folder, const StopToken& stop);

/// Removes the figures that all() has drawn of a single run in the folder. What a user has there stays: style.toml, and
/// figures of chosen columns.
void remove_of_run(const std::filesystem::path& folder);

}  // namespace freeplay::plots
