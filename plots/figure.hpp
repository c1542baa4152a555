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
  std::string scene_file;  ///< of the case, where a folder has several; else the folder's own
};

/// What every figure says of its origin: program, commit, case.
std::string origin(const std::filesystem::path& folder, const std::string& scene_file = {});

/// Line styles that differ in dash and width as well as in colour: 1 penalty, 2 nonsmooth, 3 ideal, 4 help
/// lines.
std::string style();

/// A text within gnuplot's single quotes.
std::string escaped(const std::string& text);

/// Writes and draws the figure into folder/figures; returns the PDF's path. Throws OutputError when gnuplot
/// fails.
std::filesystem::path draw(const Figure& figure, const std::filesystem::path& folder);

/// Each makes one figure of a compared scene, or returns an empty path when the scene has nothing to show in
/// it.
std::filesystem::path acceleration(const std::filesystem::path& folder);
std::filesystem::path journal_orbit(const std::filesystem::path& folder);
std::filesystem::path paired_impacts(const std::filesystem::path& folder);

/// What joints and drives carry, of a compared scene or of one run: reaction_NAME of every joint,
/// bearing_load_NAME of the revolute ones, drive_torque. None without forces.csv.
std::vector<std::filesystem::path> forces(const std::filesystem::path& folder);

/// Figures of a folder made by `freeplay laws SCENE`.
std::filesystem::path impact_loops(const std::filesystem::path& folder);
std::filesystem::path delivered_restitution(const std::filesystem::path& folder);
std::filesystem::path friction_laws(const std::filesystem::path& folder);

/// Figure of a folder made by `freeplay validate SCENE --data FILE`.
std::filesystem::path overlay(const std::filesystem::path& folder);

/// Figures of a folder made by `freeplay validate STUDY`, of its calibrated variant or else its first.
std::vector<std::filesystem::path> experiment(const std::filesystem::path& folder);

/// Figure of a folder made by `freeplay extremes`.
std::filesystem::path extremes(const std::filesystem::path& folder);

/// Figures of a folder made by `freeplay tradeoff`, one for each scene.
std::vector<std::filesystem::path> tradeoff(const std::filesystem::path& folder);

/// Figure of a folder made by `freeplay drift`.
std::filesystem::path drift(const std::filesystem::path& folder);

/// All figures that the result files of a folder allow.
std::vector<std::filesystem::path> all(const std::filesystem::path& folder);

}  // namespace freeplay::plots
