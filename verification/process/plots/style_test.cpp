// style.toml: reading and refusals, sizes on paper in every format, colours, and texts in TeX.
#include <regex>

#include "plots/drawing/figure.hpp"
#include "plots/drawing/style.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

void write_style(const std::filesystem::path& folder, const std::string& text) {
  make_folder(folder / "figures");
  write_file(folder / "figures/style.toml", text);
}

/// A folder with one small figure to draw.
void write_drift(const std::filesystem::path& folder) {
  make_folder(folder);
  write_file(
      folder / "drift.json",
      nlohmann::json{{"provenance", {{"version", "0"}, {"commit", "none"}, {"scene_file", "s"}}}}.dump());
  write_file(folder / "drift.csv", "stabilisation,t,length,closure\nnone,0,1e-9,1e-3\nnone,1,2e-9,2e-3\n");
}

/// Width and height of a PNG, from its header.
std::pair<int, int> pixels(const std::filesystem::path& png) {
  const auto bytes = test::file_text(png);
  REQUIRE(bytes.size() > 24);
  const auto number = [&](std::size_t at) {
    int n = 0;
    for (std::size_t i = 0; i < 4; ++i) n = 256 * n + static_cast<unsigned char>(bytes[at + i]);
    return n;
  };
  return {number(16), number(20)};
}

}  // namespace

TEST_CASE("a style is read by type, and an error in it is reported with its line", "[figures][style]") {
  test::TemporaryFolder folder;
  const auto& place = folder.path();
  CHECK(plots::style_of(place).font_size == 7);
  CHECK_FALSE(plots::style_of(place).width);
  write_style(place, R"(font = "DejaVu Serif"
font_size = 9
line_width = 1.5
colours = ["#102030", "orange"]
monochrome = true
width = "9 cm"
height = 60
format = ["svg", "cairolatex", "svg"]
)");
  const auto style = plots::style_of(place);
  CHECK(style.font == "DejaVu Serif");
  CHECK(style.font_size == 9);
  CHECK(style.line_width == 1.5);
  CHECK(style.colours == std::vector<unsigned>{0x102030, 0xffa500});
  CHECK(style.monochrome);
  CHECK(*style.width == Approx(90));
  CHECK(*style.height == 60);
  CHECK(style.formats == std::vector{plots::Format::svg, plots::Format::cairolatex});
  for (const auto& [size, width] : {std::pair{"one-column", 90.0},
                                    {"one-and-a-half-column", 140.0},
                                    {"two-column", 190.0},
                                    {"springer-one-column", 84.0},
                                    {"springer-two-column", 174.0},
                                    {"ieee-one-column", 88.9},
                                    {"ieee-two-column", 181.9},
                                    {"slide", 254.0}}) {
    write_style(place, fmt::format("size = \"{}\"\n", size));
    CHECK(*plots::style_of(place).width == width);
  }
  const std::pair<const char*, const char*> wrong[] = {
      {"fnt = 3", "style.toml:1:7: fnt: is not a key of a style; did you mean font?"},
      {"\nfont_size = \"large\"", "style.toml:2:13: font_size: must be a number"},
      {"font_size = 100", "font_size: must be between 4 and 40"},
      {"font_size = inf", "font_size: must be finite"},
      {"line_width = 0", "line_width: must be between 0.2 and 10"},
      {"font = \"No Such Family\"", "font: \"No Such Family\" is not installed"},
      {"font = \"Sans,20' tc\"", "font: must be the name of a font's family"},
      {"colours = [\"#12345\"]", "\"#12345\" is not a colour"},
      {"colours = [\"#12345g\"]", "is not a colour"},
      {"colours = [\"ornge\"]", "did you mean orange?"},
      {"colours = \"rainbow\"", "\"rainbow\" is not a palette, \"okabe-ito\" is; write a colour as a list"},
      {"colours = []", "must be 1 to 16 colours"},
      {"monochrome = \"yes\"", "monochrome: must be true or false"},
      {"size = \"three-column\"", "size: \"three-column\" is unknown"},
      {"size = \"slide\"\nwidth = 90", "style.toml:2:9: width: is already set by size"},
      {"width = \"3 kg\"", "width: \"3 kg\" is a mass"},
      {"width = 1e9", "width: must be between 30 and 1000"},
      {"format = \"jpg\"", "format: \"jpg\" is not a format of figures"},
      {"format = []", "format: must name at least one"},
      {"font_size = ", "style.toml:1:"},
  };
  for (const auto& [text, what] : wrong) {
    CAPTURE(text);
    write_style(place, std::string(text) + "\n");
    CHECK_THROWS_AS(plots::style_of(place), SceneError);
    CHECK_THROWS_WITH(plots::style_of(place), Contains(what));
  }
}

TEST_CASE("a style sets sizes on paper in every format, and is kept", "[figures][style]") {
  test::TemporaryFolder folder;
  const auto& place = folder.path();
  write_drift(place);
  const std::string style =
      "# mine\nwidth = 90\nheight = 60\nfont_size = 9\nformat = [\"pdf\", \"svg\", \"eps\", "
      "\"cairolatex\"]\n";
  write_style(place, style);
  for (int i = 0; i < 2; ++i) {
    test::succeeded("figures " + place.string());
    CHECK(test::file_text(place / "figures/style.toml") == style);
  }
  const auto figure = [&](const char* suffix) { return place / "figures" / (std::string("drift") + suffix); };
  // 90 mm by 60 mm: 100 dots a cm, 96 units an inch, 72 points an inch.
  CHECK(pixels(figure(".png")) == std::pair{900, 600});
  CHECK_THAT(test::file_text(figure(".svg")), Contains("viewBox=\"0 0 340 227\""));
  CHECK_THAT(test::file_text(figure(".eps")), Contains("%%BoundingBox: 0 0 255 170"));
  // 9 pt are 9 · 96/72 units
  CHECK_THAT(test::file_text(figure(".svg")), Contains("font-size=\"12.00\""));
  CHECK_THAT(test::file_text(figure("_latex.tex")), Contains("\\includegraphics") && Contains("drift_latex"));
  CHECK(test::file_text(figure(".pdf")).starts_with("%PDF"));
  // Each terminal is set once, by the one script that draws all formats.
  const auto script = test::file_text(figure(".gp"));
  for (const char* terminal : {"pdfcairo", "pngcairo", "epscairo", "set terminal svg"}) {
    CAPTURE(terminal);
    const auto first = script.find(terminal);
    CHECK(first != script.npos);
    CHECK(script.find(terminal, first + 1) == script.npos);
  }
  // Without it the figure has its default width again, and the height that its panels need.
  remove_file(place / "figures/style.toml");
  test::succeeded("figures " + place.string());
  CHECK(pixels(figure(".png")).first == 1600);
  CHECK(pixels(figure(".png")).second > 600);
  CHECK_THAT(test::file_text(figure(".gp")), Contains("SIZE = 7 "));
  // No file of the older style remains.
  for (const char* suffix : {".svg", ".eps", "_latex.tex", "_latex.pdf", "_latex.gp"}) {
    CAPTURE(suffix);
    CHECK_FALSE(std::filesystem::exists(figure(suffix)));
  }
}

TEST_CASE("poses, sections, diagrams and maps follow the style", "[figures][style]") {
  const test::TemporaryFolder folder;
  const auto cases = test::source_folder() / "cases";
  std::filesystem::copy_file(cases / "bistable-rotor/scene.toml", folder.path() / "scene.toml");
  write_file(
      folder.path() / "study.toml",
      "scene = \"scene.toml\"\n[axes.a]\nkey = \"bodies.rotor.angle\"\nvalues = [-0.4, 0.4]\n[axes.w]\n"
      "key = \"bodies.rotor.angular_velocity\"\nvalues = [-0.1, 0.1]\n"
      "[basin]\nsection = \"every 0.5 s\"\nperiod = 0.5\ndiscard = 10\nkeep = 4\n"
      "[bifurcation]\nsection = \"every 0.5 s\"\nperiod = 0.5\ndiscard = 10\nkeep = 4\n");
  const auto study = (folder.path() / "study.toml").string();
  const auto rotor = (cases / "bistable-rotor/scene.toml").string();
  const struct {
    std::string line;
    const char* script;
  } figures[] = {{"check " + (cases / "flores2011/scene.toml").string(), "pose.gp"},
                 {"poincare " + rotor + " --section 'every 0.5 s'", "poincare.gp"},
                 {"bifurcation " + study, "bifurcation.gp"},
                 {"basin " + study, "basin.gp"}};
  for (const auto& [line, script] : figures) {
    CAPTURE(script);
    for (const bool black : {true, false}) {
      const auto out = folder.path() / fmt::format("{}{}", script, black);
      std::filesystem::create_directories(out / "figures");
      write_file(out / "figures/style.toml",
                 black ? "monochrome = true\n" : "colours = [\"#123456\", \"#654321\"]\n");
      const auto end = test::succeeded(line + " -o " + out.string());
      const std::string text = test::file_text(out / "figures" / script);
      // Colours are those of the style, by name; only greys are added.
      const std::regex colour("rgb '?(#|0x)([0-9a-f]{6})");
      for (auto it = std::sregex_iterator(text.begin(), text.end(), colour); it != std::sregex_iterator();
           ++it) {
        const auto hex = (*it)[2].str();
        CAPTURE(hex);
        CHECK((hex == "123456" || hex == "654321" ||
               (hex.substr(0, 2) == hex.substr(2, 2) && hex[0] == hex[4]) || hex == "9aa0a6"));
      }
      CHECK_THAT(text, Catch::Contains(black ? "C1 = 0x000000" : "C1 = 0x123456"));
    }
  }
}

TEST_CASE("no text acts as a TeX command", "[security][figures]") {
  CHECK(plots::in_tex("a_b 5 % $x$ #1 & {c} ~ ^^5c \\input{f} \"q\" <|>") ==
        "a\\_b 5 \\% \\$x\\$ \\#1 \\& \\{c\\} \\textasciitilde{} \\textasciicircum{}\\textasciicircum{}5c "
        "\\textbackslash{}input\\{f\\} \\char34{}q\\char34{} \\textless{}\\textbar{}\\textgreater{}");
  plots::Script script;
  script.add("set label {} noenhanced\nset ylabel '{}'\n", std::string("\\input{x}_1"),
             plots::Word("F_x", "$F_x$"));
  CHECK_THAT(script.tex(), Contains("'$F_x$'") && !Contains("\\input") && !Contains("{x}"));
  CHECK_THAT(script.text(), Contains("'F_x'"));
}
