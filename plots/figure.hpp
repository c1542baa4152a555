// A figure of a result folder. It reads result files only, and leaves its data (NAME.dat), the script that
// redraws it (NAME.gp: run gnuplot on it in its own folder), a PDF for papers and a PNG to look at.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freeplay::plots {

/// Numbers of a CSV file by the names in its header.
class Csv {
 public:
  /// Throws OutputError when the file cannot be read or a line has too few fields.
  explicit Csv(const std::filesystem::path& file);
  bool has(const std::string& name) const;
  /// Column as text; throws when there is none of that name.
  const std::vector<std::string>& text(const std::string& name) const;
  std::vector<double> column(const std::string& name) const;
  std::size_t rows() const { return columns_.empty() ? 0 : columns_.front().size(); }
  const std::vector<std::string>& names() const { return names_; }

 private:
  std::string file_;
  std::vector<std::string> names_;
  std::vector<std::vector<std::string>> columns_;
};

struct Figure {
  std::string name;
  double width_cm = 16, height_cm = 9;
  /// Blocks of the data file, separated for gnuplot's `index`; each starts with a comment that names its
  /// columns.
  std::vector<std::string> blocks;
  /// Commands after the style; 'DATA' stands for the data file.
  std::string script;
  std::string source;      ///< the folder's JSON file whose provenance it names
  std::string scene_file;  ///< of the case, where a folder has several; else the one of the source
};

/// Line styles that differ in dash and width as well as in colour: 1 penalty, 2 nonsmooth, 3 ideal, 4 help
/// lines.
std::string style();

/// A text within gnuplot's single quotes.
std::string escaped(const std::string& text);

/// Writes and draws the figure into folder/figures; returns the PDF's path. Throws OutputError when gnuplot
/// fails.
std::filesystem::path draw(const Figure& figure, const std::filesystem::path& folder);

/// Figures of one kind. Each stands in a file of its own under plots/, and its name on one line of figures.def.
struct Drawing {
  std::vector<const char*> needs;  ///< result files: it is drawn where the folder has any of them
  /// Draws it from these and what stands beside them; no paths when they have nothing to show in it.
  std::vector<std::filesystem::path> (*draw)(const std::filesystem::path& folder);
};

#define FIGURES(name) extern const Drawing name;
#include "plots/figures.def"
#undef FIGURES

/// All figures that the result files of a folder allow.
std::vector<std::filesystem::path> all(const std::filesystem::path& folder);

}  // namespace freeplay::plots
