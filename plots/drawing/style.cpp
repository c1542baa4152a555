#include "plots/drawing/style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "io/files/child.hpp"
#include "io/files/escaping.hpp"
#include "io/files/input_file.hpp"
#include "io/scene/keys_list.hpp"
#include "io/scene/section.hpp"

namespace freeplay::plots {
namespace {

/// Column widths from the publishers' pages for authors.
struct PageSize {
  std::string_view name;
  double width;  ///< mm
  std::string_view source;
};
constexpr PageSize sizes[] = {
    {"one-column", 90, "Elsevier, artwork sizing: single column"},
    {"one-and-a-half-column", 140, "Elsevier: 1.5 column"},
    {"two-column", 190, "Elsevier: double column"},
    {"springer-one-column", 84, "Springer, large journals: one column"},
    {"springer-two-column", 174, "Springer, large journals: two columns"},
    {"ieee-one-column", 88.9, "IEEE: 3.5 in"},
    {"ieee-two-column", 181.9, "IEEE: 7.16 in"},
    {"slide", 254, "a slide of 10 in"},
};

struct NamedColour {
  std::string_view name;
  unsigned value;
};
/// The palette of Okabe and Ito (2008), which colour-blind readers can distinguish, and basic names
/// of CSS Color Level 4.
constexpr NamedColour named_colours[] = {
    {"black", 0x000000},   {"grey", 0x808080},      {"silver", 0xc0c0c0},    {"red", 0xff0000},
    {"maroon", 0x800000},  {"olive", 0x808000},     {"green", 0x008000},     {"teal", 0x008080},
    {"blue", 0x0000ff},    {"navy", 0x000080},      {"purple", 0x800080},    {"brown", 0xa52a2a},
    {"orange", 0xffa500},  {"magenta", 0xff00ff},   {"cyan", 0x00ffff},      {"gold", 0xffd700},
    {"crimson", 0xdc143c}, {"steelblue", 0x4682b4}, {"darkgreen", 0x006400}, {"darkorange", 0xff8c00},
};
constexpr unsigned okabe_ito[] = {0x0072b2, 0xd55e00, 0x000000, 0x009e73,
                                  0xcc79a7, 0xe69f00, 0x56b4e9, 0xf0e442};
constexpr std::size_t most_colours = 16;

constexpr Range text_size{[](double x) { return x >= 4 && x <= 40; }, "between 4 and 40"};
constexpr Range times{[](double x) { return x >= 0.2 && x <= 10; }, "between 0.2 and 10"};
constexpr Range paper{[](double x) { return x >= 30 && x <= 1000; }, "between 30 and 1000"};

std::vector<std::string> words(const auto& all) {
  std::vector<std::string> list;
  for (const auto& one : all) list.emplace_back(one.name);
  return list;
}

/// Parses #rrggbb or a name.
std::optional<unsigned> colour(std::string_view text) {
  const auto named = std::ranges::find(named_colours, text, &NamedColour::name);
  if (named != std::end(named_colours)) return named->value;
  if (text.size() != 7 || text.front() != '#') return std::nullopt;
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data() + 1, text.data() + text.size(), value, 16);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

/// "; did you mean …?", or the list of all names.
std::string remedy(std::string_view word, const std::vector<std::string>& known) {
  const auto near = nearest_word(word, known);
  return near.empty() ? listed("there are", known) : fmt::format("; did you mean {}?", near);
}

/// Whether fontconfig, which supplies the fonts of gnuplot, has a family; true if fontconfig cannot
/// be queried. For an unknown family it would silently substitute another one.
bool installed(const std::string& font) {
  std::string pattern = ":family=";
  for (const char c : font) pattern += c == '-' ? std::string("\\-") : std::string(1, c);
  return run_child({.command = {"fc-list", "-q", pattern}, .seconds = 10}).status != 1;
}

std::string read_font(Section& s, std::string_view key) {
  const auto name = s.text(key);
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == ' ' || c == '-';
  };
  if (name.empty() || name.size() > 60 || name.front() == ' ' || name.front() == '-' ||
      !std::ranges::all_of(name, plain))
    s.fail(key, fmt::format("must be the name of a font's family, letters, digits, spaces and -, is \"{}\"",
                            visible_brief(name, 40)));
  if (!installed(name))
    s.fail(key, fmt::format("\"{}\" is not installed; `fc-list : family` lists the installed fonts", name));
  return name;
}

std::vector<unsigned> read_colours(Section& s, std::string_view key) {
  if (s.is_text(key)) {
    const auto name = s.text(key);
    if (name == "okabe-ito") return {std::begin(okabe_ito), std::end(okabe_ito)};
    s.fail(key, fmt::format("\"{0}\" is not a palette, \"okabe-ito\" is; write a colour as a list, [\"{0}\"]",
                            visible_brief(name, 40)));
  }
  const auto list = s.names(key);
  if (list.empty() || list.size() > most_colours)
    s.fail(key, fmt::format("must be 1 to {} colours, is a list of {}", most_colours, list.size()));
  std::vector<unsigned> values;
  for (const auto& name : list) {
    const auto value = colour(name);
    if (!value)
      s.fail(key, fmt::format("\"{}\" is not a colour: use \"#rrggbb\" or a name{}", visible_brief(name, 40),
                              remedy(name, words(named_colours))));
    values.push_back(*value);
  }
  return values;
}

std::vector<Format> read_formats(Section& s, std::string_view key) {
  const auto list = s.name_or_names(key);
  if (list.empty()) s.fail(key, "must name at least one");
  try {
    return formats_named(list);
  } catch (const SceneError& e) {
    s.fail(key, e.what());
  }
}

double read_page_width(Section& s, std::string_view key) {
  return sizes[static_cast<std::size_t>(s.choice(key, words(sizes)))].width;
}

double read_length(Section& s, std::string_view key) { return s.number(Key{key, "mm", ""}, paper); }

/// "\"one-column\" (90 mm), ...", for the documentation.
std::string sizes_text() {
  std::string list;
  for (const auto& size : sizes)
    list += fmt::format("{}\"{}\" ({}{})", list.empty() ? "" : ", ", size.name, size.width,
                        list.empty() ? " mm" : "");
  return list;
}

}  // namespace

std::vector<Format> formats_named(const std::vector<std::string>& names) {
  std::vector<Format> list;
  for (const auto& name : names) {
    const auto it = std::ranges::find(format_names, name, &FormatFacts::name);
    if (it == format_names.end())
      throw SceneError(fmt::format("\"{}\" is not a format of figures{}", visible_brief(name, 40),
                                   listed("there are", words(format_names))));
    if (std::ranges::find(list, it->format) == list.end()) list.push_back(it->format);
  }
  return list;
}

void Style::keys(auto& k, auto& x) {
  k.other({"font", "", "installed font family of texts", "\"DejaVu Sans\""}, "text", x.font, read_font);
  k.take({"font_size", "", "font size on paper, in points of 1/72 in, 4 to 40"}, x.font_size, text_size);
  k.take({"line_width", "", "factor of the default line widths, 0.2 to 10"}, x.line_width, times);
  k.other({"colours", "",
           "of penalty, nonsmooth, the ideal joint and further curves, taken in turn: \"#rrggbb\" or names; "
           "or \"okabe-ito\""},
          "text or names", x.colours, read_colours);
  k.take({"monochrome", "", "black lines, distinguished by dashes and marks"}, x.monochrome);
  static const auto widths = "width required by a journal: " + sizes_text();
  k.other({"size", "", widths}, "text", x.width, read_page_width);
  k.check(!(k.when_given("size") && k.when_given("width")), "width",
          "is already set by size; give only one of them");
  k.other({"width", "", "width on paper in mm, or with its unit, \"9 cm\"; or size", "each figure's own"},
          "number", x.width, read_length);
  k.other({"height", "", "height on paper in mm, likewise", "each figure's own"}, "number", x.height,
          read_length);
  k.other({"format", "",
           "for papers: \"pdf\", \"svg\", \"eps\", \"cairolatex\"; \"png\" for no other. A PNG is drawn in "
           "any case",
           "\"pdf\""},
          "text or names", x.formats, read_formats);
}

const Schema& style_schema() {
  static const Schema schema = [] {
    KeysList list;
    list.facts<Style>("style", "a style");
    return list.schema("style");
  }();
  return schema;
}

namespace {

Style parse_style(const std::string& text, const std::string& name) {
  Style style;
  const SceneSource source{.name = name, .schema = &style_schema()};
  const toml::table document = parse_toml(text, name);
  refuse_unknown_keys(document, "style", source);
  Section section(document, "", "style", source);
  SectionReader reader(section);
  Style::keys(reader, style);
  section.done("a style");
  return style;
}

bool is_there(const std::filesystem::path& file) {
  std::error_code none;
  return std::filesystem::exists(std::filesystem::symlink_status(file, none));
}

/// The path of the scene that the results in a folder record; empty if there is none.
std::filesystem::path recorded_scene(const std::filesystem::path& folder) {
  for (const char* name : {"comparison.json", "run.json", "validation.json", "points.json", "laws.json",
                           "orbit.json", "continue.json", "lyapunov.json", "play.json"}) {
    if (!std::filesystem::exists(folder / name)) continue;
    try {
      return JsonFile(folder / name).text("provenance.scene_file");
    } catch (const SceneError&) {
      return {};  // the figure that reads the file reports it
    }
  }
  return {};
}

/// The style chosen for this process. A command draws in one style.
std::optional<Style>& chosen_style() {
  static std::optional<Style> style;
  return style;
}

/// A style by name, for --style.
struct StylePreset {
  std::string_view name;
  std::string_view text;  ///< of a style.toml
};
constexpr StylePreset presets[] = {
    {"journal-single", "size = \"springer-one-column\"\nfont_size = 8\n"},
    {"journal-double", "size = \"springer-two-column\"\nfont_size = 8\n"},
    {"slides", "size = \"slide\"\nfont_size = 18\nline_width = 2\n"},
};

}  // namespace

void choose_style(const std::string& preset_or_file) {
  const auto preset = std::ranges::find(presets, preset_or_file, &StylePreset::name);
  if (preset != std::end(presets)) {
    chosen_style() = parse_style(std::string(preset->text), preset_or_file);
    return;
  }
  std::error_code none;
  if (!std::filesystem::exists(preset_or_file, none))
    throw SceneError(fmt::format("--style {}: is neither a file nor a preset{}",
                                 visible_brief(preset_or_file, 80), remedy(preset_or_file, words(presets))));
  chosen_style() = parse_style(read_text(preset_or_file), preset_or_file);
}

Style style_of(const std::filesystem::path& folder, const std::filesystem::path& scene) {
  if (chosen_style()) return *chosen_style();
  if (const auto file = folder / "figures" / "style.toml"; is_there(file))
    return parse_style(read_text(file), file.string());
  const auto scene_file = scene.empty() ? recorded_scene(folder) : scene;
  if (scene_file.empty()) return {};
  const auto beside = scene_file.parent_path() / "style.toml";
  std::error_code none;
  if (!std::filesystem::is_regular_file(beside, none)) return {};
  return parse_style(read_text(beside), beside.string());
}

}  // namespace freeplay::plots
