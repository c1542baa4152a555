#include "plots/drawing/figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <iterator>

#include "io/files/escaping.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"
#include "study/runs/executor.hpp"

namespace freeplay::plots {
namespace {

/// A text string in UTF-16 with its byte order mark, written in hexadecimal digits: nothing in it
/// is syntax of PDF.
std::string text_string(std::string_view utf8) {
  std::string out = "<FEFF";
  for (std::size_t i = 0; i < utf8.size();) {
    const auto byte = [&](std::size_t k) {
      return k < utf8.size() ? static_cast<unsigned char>(utf8[k]) : 0u;
    };
    const unsigned first = byte(i);
    const int more = first < 0x80 ? 0 : first < 0xE0 ? 1 : first < 0xF0 ? 2 : 3;
    unsigned code = more == 0 ? first : first & (0x3Fu >> more);
    for (int k = 1; k <= more; ++k) code = code << 6 | (byte(i + static_cast<std::size_t>(k)) & 0x3Fu);
    i += static_cast<std::size_t>(more) + 1;
    if (code >= 0x10000)
      fmt::format_to(std::back_inserter(out), "{:04X}{:04X}", 0xD800 + ((code - 0x10000) >> 10 & 0x3FF),
                     0xDC00 + (code & 0x3FF));
    else
      fmt::format_to(std::back_inserter(out), "{:04X}", code);
  }
  return out + ">";
}

/// The text between two marks behind a position; empty if they are absent.
std::string text_between(const std::string& pdf, std::size_t from, std::string_view mark,
                         std::string_view end) {
  const auto at = pdf.find(mark, from);
  const auto to = at == pdf.npos ? at : pdf.find(end, at + mark.size());
  return to == pdf.npos ? "" : pdf.substr(at + mark.size(), to - at - mark.size());
}

/// Facts of a PDF file: title, subject, keywords and program in its document information dictionary
/// (ISO 32000-1, 14.3.3), where pdfinfo and viewers show them. Texts in UTF-8; empty ones are omitted.
struct PdfFacts {
  std::string title, subject, keywords, creator;
};

/// The file with the facts, added by an incremental update (ISO 32000-1, 7.5.6). A file without a
/// cross-reference table at its end, which other versions of cairo may write, is returned as it is.
std::string with_facts(const std::string& pdf, const PdfFacts& facts) {
  const auto trailer = pdf.rfind("trailer");
  if (trailer == pdf.npos) return pdf;
  const long size = std::strtol(text_between(pdf, trailer, "/Size ", "\n").c_str(), nullptr, 10),
             table = std::strtol(text_between(pdf, trailer, "startxref\n", "\n").c_str(), nullptr, 10);
  const auto root = text_between(pdf, trailer, "/Root ", "R");
  if (size <= 0 || table <= 0 || root.empty()) return pdf;
  std::string out = pdf;
  if (!out.ends_with('\n')) out += '\n';
  const auto object = out.size();
  out += fmt::format("{} 0 obj\n<<", size);
  for (const auto& [key, text] : {std::pair<const char*, const std::string&>{"Title", facts.title},
                                  {"Subject", facts.subject},
                                  {"Keywords", facts.keywords},
                                  {"Creator", facts.creator}})
    if (!text.empty()) out += fmt::format(" /{} {}\n", key, text_string(text));
  out += ">>\nendobj\n";
  const auto xref = out.size();
  out += fmt::format(
      "xref\n{0} 1\n{1:010} 00000 n \ntrailer\n"
      "<< /Size {2} /Root {3}R /Info {0} 0 R /Prev {4} >>\nstartxref\n{5}\n%%EOF\n",
      size, object, size + 1, root, table, xref);
  return out;
}

/// The origin of a figure: program, commit, case.
std::string origin(const Figure& f, const std::filesystem::path& folder) {
  const JsonFile source(folder / f.source);
  return fmt::format("freeplay {} ({}), {}", source.text("provenance.version"),
                     source.text("provenance.commit"),
                     f.scene_file.empty() ? source.text("provenance.scene_file") : f.scene_file);
}

/// Line styles that differ in dash and width as well as in colour: 1 penalty, 2 nonsmooth, 3 ideal,
/// 4 auxiliary lines.
constexpr Word look =
    "set style line 1 lc rgb C1 lw 1.6 dt 1 pt 6 ps 1.1\n"
    "set style line 2 lc rgb C2 lw 1.3 dt (12,5) pt 2 ps 1.0\n"
    "set style line 3 lc rgb C3 lw 2.2 dt (2,4)\n"
    "set style line 4 lc rgb 0x888888 lw 1.0 dt 1\n"
    "set border lw 0.8\n"
    "set tics nomirror scale 0.6\n"
    "set grid lt 1 lc rgb 0xd4d4d4 lw 0.7\n"
    "set key outside top center horizontal samplen 3 spacing 1.1\n"
    "set pointsize 1\n"
    "set bmargin at screen Y(1.15)\n";

/// A file format: its gnuplot terminal, and the suffix of its file after NAME.
struct Terminal {
  Format format;
  const char* suffix;
  double unit;        ///< units of the size per cm
  double font_scale;  ///< makes 1 pt = 1/72 in on paper; cairo: 4/3 pt at scale 1, SVG: 96 units/in
  double line_scale;
};
constexpr std::uint64_t most_bytes = 1u << 30;  ///< of a PDF
constexpr double dots = 100;                    ///< per cm, of a PNG
constexpr Terminal terminals[] = {
    {Format::pdf, ".pdf", 1, 0.75, 1},
    {Format::png, ".png", dots, 0.75 * 2.54 * dots / 72, 2},
    {Format::svg, ".svg", 96 / 2.54, 96.0 / 72, 1},
    {Format::eps, ".eps", 1, 0.75, 1},
    {Format::cairolatex, "_latex.tex", 1, 1, 1},
};
const Terminal& terminal_of(Format format) {
  return *std::ranges::find(terminals, format, &Terminal::format);
}

struct Paper {
  double width, height;  ///< cm
};

/// A narrower figure keeps its text size. It therefore shrinks less in height than in width.
Paper paper_of(const Figure& f, const Style& style) {
  if (f.sized) return {f.width_cm, f.height_cm};
  const double width = width_of(f, style);
  const double taller =
      std::sqrt(width / f.width_cm * std::max(1.0, style.font_size / Style::usual_font_size));
  return {width, style.height ? 0.1 * *style.height : f.height_cm * taller};
}

Script terminal(const Terminal& t, const Paper& paper, const Style& style) {
  const auto font = fmt::format("{},{}", style.font, style.font_size);
  const double width = t.unit * paper.width, height = t.unit * paper.height;
  Script size;
  switch (t.format) {
    case Format::pdf:
      size.add("pdfcairo size {:.6g}cm,{:.6g}cm", width, height);
      break;
    case Format::eps:
      size.add("epscairo size {:.6g}cm,{:.6g}cm", width, height);
      break;
    case Format::png:
      size.add("pngcairo size {:.0f},{:.0f}", width, height);
      break;
    case Format::svg:
      size.add("svg size {:.0f},{:.0f}", width, height);
      break;
    case Format::cairolatex:  // the document sets the texts
      return size.add("cairolatex pdf size {:.6g}cm,{:.6g}cm linewidth {:.6g}", width, height,
                      t.line_scale * style.line_width);
  }
  return size.add(" font {} fontscale {:.6g} linewidth {:.6g}", font, t.font_scale,
                  t.line_scale * style.line_width);
}

/// Commands independent of the format: sizes, colours, line styles.
Script beginning(const Paper& paper, const Style& style, double font_size) {
  Script script;
  script.add(
      "set encoding utf8\nWIDTH = {:.6g}; HEIGHT = {:.6g}  # cm\nSIZE = {:.6g}  # pt\n"
      "X(cm) = cm*SIZE/{:.1f}/WIDTH; Y(cm) = cm*SIZE/{:.1f}/HEIGHT\n"
      "SMALL = sprintf(',%g', 0.88*SIZE); TINY = sprintf(',%g', 0.8*SIZE)\n",
      paper.width, paper.height, font_size, Style::usual_font_size, Style::usual_font_size);
  script.add("MONO = {}\n", style.monochrome ? 1 : 0);
  for (std::size_t i = 0; i < 9; ++i)
    script.add("C{} = 0x{:06x}\n", i + 1, style.monochrome ? 0u : style.colours[i % style.colours.size()]);
  return script.add("{}", look);
}

/// A long text as an expression of gnuplot: literals joined by dots.
Script long_text(const std::string& text) {
  constexpr std::size_t piece = 190;  // bytes
  Script script;
  for (std::size_t at = 0; at < text.size() || at == 0;) {
    auto to = std::min(at + piece, text.size());
    while (to < text.size() && (static_cast<unsigned char>(text[to]) & 0xC0) == 0x80) ++to;
    script.add("{}{}", at == 0 ? Word("") : Word("."), text.substr(at, to - at));
    at = std::max(to, at + 1);
  }
  return script;
}

/// Variables that state the origin and the content of the figure. Nothing draws them.
Script facts_of(const Figure& f, const std::string& origin) {
  return Script().add("ORIGIN = {}\nCAPTION = {}\n", long_text(origin), long_text(f.caption));
}

/// The script for all formats except LaTeX. gnuplot runs the script once per format (PASS).
std::string script_of(const Figure& f, const std::vector<Format>& formats, const Style& style,
                      const std::string& from) {
  const auto paper = paper_of(f, style);
  Script script;
  script.add(
      "# Draw again: run gnuplot on this file, in its own folder.\nif (!exists(\"PASS\")) PASS = 1\nreset\n");
  std::size_t pass = 0;
  for (const auto format : formats) {
    const auto& t = terminal_of(format);
    script.add("if (PASS == {}) set terminal {}; set output {}\n", ++pass, terminal(t, paper, style),
               f.name + t.suffix);
  }
  script.add("DATA = {}\n{}{}{}unset output\nPASS = PASS + 1\nif (PASS <= {}) load {}\n", f.name + ".dat",
             facts_of(f, from), beginning(paper, style, style.font_size), f.script, pass, f.name + ".gp");
  return script.text();
}

/// The script for LaTeX, which sets the texts in the font of the document, usually of 10 pt.
std::string latex_script(const Figure& f, const Style& style) {
  const auto paper = paper_of(f, style);
  const auto& t = terminal_of(Format::cairolatex);
  Script name, data;
  name.add("{}", f.name + t.suffix);
  data.add("{}", f.name + ".dat");
  Script script;
  script.add(
      "# Draw again: run gnuplot on this file, in its own folder. "
      "Then \\input the .tex in a LaTeX document.\n");
  script.add("set terminal {}\n", terminal(t, paper, style));
  // no texts for TeX
  const auto files = fmt::format("set output {}\nDATA = {}\n", name.text(), data.text());
  Script body;
  body.add("{}{}unset output\n", beginning(paper, style, f.sized ? style.font_size : 10), f.script);
  return script.text() + files + body.tex();
}

/// A temporary folder for drawing. The destructor removes it with its remaining files.
class DrawingPlace {
 public:
  explicit DrawingPlace(const std::filesystem::path& folder) : folder_(folder) {
    make_folder(folder.parent_path());
    std::filesystem::remove_all(folder);  // left by a drawing that was killed
    make_folder(folder);
  }
  ~DrawingPlace() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  DrawingPlace(const DrawingPlace&) = delete;
  DrawingPlace& operator=(const DrawingPlace&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
  const std::filesystem::path& path() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

}  // namespace

Block::Block(std::string_view heading) : text_("# " + visible(heading) + "\n") {}

Block& Block::row(const std::vector<double>& values) {
  fmt::format_to(std::back_inserter(text_), "{}\n", fmt::join(values, " "));
  filled_ = true;
  return *this;
}

Block& Block::gap() {
  text_ += "\n";
  return *this;
}

std::string file_name(std::string_view kind, std::string_view of) {
  return fmt::format("{}_{}", kind, safe_name(of));
}

double tic_step(double range, bool narrow) {
  const double part = std::max(range, 1e-300) / (narrow ? 3.4 : 5),
               power = std::pow(10, std::floor(std::log10(part)));
  for (const double step : {1.0, 2.0, 2.5, 5.0})
    if (part <= step * power) return step * power;
  return 10 * power;
}

bool is_narrow(const Figure& f, const Style& style) {
  return width_of(f, style) < 12 * style.font_size / Style::usual_font_size;
}

double width_of(const Figure& f, const Style& style) { return style.width ? 0.1 * *style.width : f.width_cm; }

std::filesystem::path draw(const Figure& f, const std::filesystem::path& folder) {
  if (f.blocks.empty()) throw OutputError(f.name + ": nothing to draw");
  const auto style = style_of(folder);
  auto formats = f.formats.empty() ? style.formats : f.formats;
  const auto first = formats.front();
  const bool latex = std::erase(formats, Format::cairolatex) > 0;
  if (std::ranges::find(formats, Format::png) == formats.end()) formats.push_back(Format::png);
  const auto from = origin(f, folder);
  std::string data;
  for (const auto& block : f.blocks)  // gnuplot skips a block without rows
    data += block.text() + (block.empty() ? "NaN NaN\n" : "") + "\n\n";
  const auto figures = folder / "figures";
  const DrawingPlace place(figures / (f.name + ".partial"));
  const auto draw_by = [&](const std::string& script, const std::string& text, std::vector<std::string> makes,
                           std::uintmax_t least) {
    write_file(place / script, text);
    const auto said = run_gnuplot(place.path(), script);
    for (const auto& name : makes)
      if (const auto made = place / name;
          !said.empty() || !std::filesystem::exists(made) || std::filesystem::file_size(made) < least)
        throw OutputError(fmt::format("{}: gnuplot did not draw it{}", (figures / name).string(),
                                      said.empty() ? "" : ": " + said));
    for (const auto& name : makes)
      if (name.ends_with(".pdf"))
        write_file(place / name,
                   with_facts(read_file(place / name, most_bytes),
                              {f.title.empty() ? f.name : f.title, f.caption, from, "freeplay"}));
    makes.push_back(script);
    for (const auto& name : makes) move_file(place.path(), figures, name);
  };
  write_file(place / (f.name + ".dat"), data);
  std::vector<std::string> files;
  for (const auto format : formats) files.push_back(f.name + terminal_of(format).suffix);
  draw_by(f.name + ".gp", script_of(f, formats, style, from), files, 2000);
  if (latex)
    draw_by(f.name + "_latex.gp", latex_script(f, style), {f.name + "_latex.tex", f.name + "_latex.pdf"},
            500);  // small: without texts and fonts, which LaTeX adds
  move_file(place.path(), figures, f.name + ".dat");
  if (!f.formats.empty()) return figures / (f.name + terminal_of(first).suffix);
  // Removes files of formats that the style no longer lists: they would show another run or style.
  std::error_code ignored;
  for (const auto& t : terminals)
    if (t.format != Format::cairolatex && std::ranges::find(formats, t.format) == formats.end())
      std::filesystem::remove(figures / (f.name + t.suffix), ignored);
  if (!latex)
    for (const char* suffix : {"_latex.gp", "_latex.tex", "_latex.pdf"})
      std::filesystem::remove(figures / (f.name + suffix), ignored);
  return figures / (f.name + terminal_of(first).suffix);
}

void remove_of_run(const std::filesystem::path& folder) {
  constexpr const char* kinds[] = {"motion",        "phase_portrait", "signals",       "spectra",
                                   "journal_orbit", "reaction_",      "bearing_load_", "drive_torque"};
  constexpr const char* files[] = {".dat", ".gp", ".pdf", ".png", ".svg", ".eps", ".tex"};
  const auto figures = folder / "figures";
  std::error_code none;
  if (!std::filesystem::is_directory(std::filesystem::symlink_status(figures, none))) return;
  std::vector<std::filesystem::path> old;
  for (const auto& entry : std::filesystem::directory_iterator(figures)) {
    const auto name = entry.path().filename().string();
    if (std::ranges::any_of(kinds, [&](const char* kind) { return name.starts_with(kind); }) &&
        std::ranges::any_of(files, [&](const char* end) { return name.ends_with(end); }))
      old.push_back(entry.path());
  }
  for (const auto& path : old) remove_file(path);
}

std::vector<std::filesystem::path> all(const std::filesystem::path& folder, const StopToken& stop) {
  const Drawing* const drawings[] = {
#define FIGURES(name) &(name),
#include "plots/figures/figures.def"
#undef FIGURES
  };
  std::vector<std::filesystem::path> made[std::size(drawings)], list;
  std::exception_ptr failures[std::size(drawings)];
  execute_jobs(0, std::size(drawings), stop, [&](std::size_t i) {
    if (std::ranges::none_of(drawings[i]->needs,
                             [&](const char* f) { return std::filesystem::exists(folder / f); }))
      return;
    try {
      made[i] = drawings[i]->draw(folder);
    } catch (...) {  // the others are drawn all the same
      failures[i] = std::current_exception();
    }
  });
  for (const auto& failure : failures)
    if (failure) std::rethrow_exception(failure);
  for (const auto& paths : made) list.insert(list.end(), paths.begin(), paths.end());
  return list;
}

}  // namespace freeplay::plots
