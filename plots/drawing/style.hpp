// The style of figures: typed values, which a user may set in style.toml in the folder of the
// figures. Every command that draws there reads the file; none writes it. Its values reach gnuplot
// only as numbers and quoted texts.
//
// Lengths are those on paper. A point is 1/72 in; Elsevier's page on artwork sizing requires texts
// of 7 pt.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/scene/schema.hpp"

namespace freeplay::plots {

enum class Format { pdf, png, svg, eps, cairolatex };

/// The file formats and their names. A PNG for viewing is always drawn.
struct FormatFacts {
  Format format;
  std::string_view name;
};
inline constexpr std::array format_names{FormatFacts{Format::pdf, "pdf"}, FormatFacts{Format::png, "png"},
                                         FormatFacts{Format::svg, "svg"}, FormatFacts{Format::eps, "eps"},
                                         FormatFacts{Format::cairolatex, "cairolatex"}};

struct Style {
  /// pt, for which the margins of the figures are chosen
  static constexpr double usual_font_size = 7;
  std::string font = "DejaVu Sans";
  double font_size = usual_font_size;  ///< pt
  double line_width = 1;               ///< factor on all line widths
  /// 0xRRGGBB: penalty, nonsmooth, ideal joint, and further curves. Further curves reuse the
  /// colours cyclically.
  std::vector<unsigned> colours{0x0b3c8c, 0xc8500a, 0x000000, 0x1b7837, 0x7b3294,
                                0x8c510a, 0x01665e, 0xb2182b, 0x3d9be0};
  bool monochrome = false;              ///< all black; curves differ by dashes and marks
  std::optional<double> width, height;  ///< mm; absent: the size of each figure
  std::vector<Format> formats{Format::pdf};

  static void keys(auto& k, auto& x);
};
/// The schema of styles.
const Schema& style_schema();

/// Draws all figures of this process in the style of a preset or a file, as --style requests.
/// Throws SceneError for an invalid style, and for a name that is neither.
void choose_style(const std::string& preset_or_file);

/// Style of a result folder: the chosen one, else folder/figures/style.toml, else style.toml beside
/// the scene of the results, else the default. `scene`: path of the scene; empty: the one that the
/// results record. Throws SceneError with FILE:LINE:COL, the key and the error.
Style style_of(const std::filesystem::path& folder, const std::filesystem::path& scene = {});

/// Parses a comma-separated list of formats. Throws SceneError for an unknown format.
std::vector<Format> formats_named(const std::vector<std::string>& names);

}  // namespace freeplay::plots
