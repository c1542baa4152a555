// How figures look: typed values, which a user may keep in style.toml beside the figures. It is read anew by every verb
// that draws there and never written; what is in it reaches gnuplot as numbers and quoted texts alone.
//
// Lengths are those on paper. A point is 1/72 in; 7 pt is what Elsevier's page on the sizing of artwork asks of texts.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace freeplay::plots {

enum class Format { pdf, png, svg, eps, cairolatex };

/// Each with its name; a PNG to look at is drawn whichever is asked for.
struct FormatFacts {
  Format format;
  std::string_view name;
};
inline constexpr std::array format_names{FormatFacts{Format::pdf, "pdf"}, FormatFacts{Format::png, "png"},
                                         FormatFacts{Format::svg, "svg"}, FormatFacts{Format::eps, "eps"},
                                         FormatFacts{Format::cairolatex, "cairolatex"}};

/// A width that journals ask for.
struct PageSize {
  std::string_view name;
  double width;  ///< mm
  std::string_view source;
};
std::span<const PageSize> page_sizes();

struct Style {
  static constexpr double usual_font_size = 7;  ///< pt, which the figures' margins are made for
  std::string font = "DejaVu Sans";
  double font_size = usual_font_size;  ///< pt
  double line_width = 1;               ///< times as drawn
  /// 0xRRGGBB: penalty, nonsmooth, ideal joint, and further curves. Of more curves they are taken in turn.
  std::vector<unsigned> colours{0x0b3c8c, 0xc8500a, 0x000000, 0x1b7837, 0x7b3294,
                                0x8c510a, 0x01665e, 0xb2182b, 0x3d9be0};
  bool monochrome = false;              ///< black; curves differ by dashes and marks
  std::optional<double> width, height;  ///< mm; left out: each figure's own
  std::vector<Format> formats{Format::pdf};
};

/// Of the figures of a result folder: folder/figures/style.toml, or as they look without one. Throws SceneError
/// FILE:LINE:COL: key: what is wrong.
Style style_of(const std::filesystem::path& folder);

/// Formats by their names in a list with commas. Throws SceneError for one that there is not.
std::vector<Format> formats_named(const std::vector<std::string>& names);

}  // namespace freeplay::plots
