#include "plots/figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "io/digest.hpp"
#include "io/input_file.hpp"
#include "io/output_file.hpp"
#include "io/visible.hpp"
#include "plots/gnuplot.hpp"

namespace freeplay::plots {
namespace {

/// What a figure says of its origin: program, commit, case.
std::string origin(const Figure& f, const std::filesystem::path& folder) {
  const JsonFile source(folder / f.source);
  return fmt::format("freeplay {} ({}), {}", source.text("provenance.version"),
                     source.text("provenance.commit"),
                     f.scene_file.empty() ? source.text("provenance.scene_file") : f.scene_file);
}

/// Line styles that differ in dash and width as well as in colour: 1 penalty, 2 nonsmooth, 3 ideal, 4 help
/// lines.
constexpr Word style =
    "set encoding utf8\n"
    "set style line 1 lc rgb '#0b3c8c' lw 1.6 dt 1 pt 6 ps 1.1\n"
    "set style line 2 lc rgb '#c8500a' lw 1.3 dt (12,5) pt 2 ps 1.0\n"
    "set style line 3 lc rgb '#000000' lw 2.2 dt (2,4)\n"
    "set style line 4 lc rgb '#888888' lw 1.0 dt 1\n"
    "set border lw 0.8\n"
    "set tics nomirror scale 0.6\n"
    "set grid lc rgb '#cccccc' lw 0.6 dt 1\n"
    "set key top right samplen 3 spacing 1.1\n";

/// The whole script: the same figure as a PDF and as a PNG.
Script script_of(const Figure& f, const std::filesystem::path& folder) {
  Script script;
  script.add("# Draw again: run gnuplot on this file, in its own folder.\n");
  const auto page = [&](const Script& terminal, Word suffix) {
    script.add("reset session\n{}\nset output {}\nDATA = {}\n{}", terminal, f.name + "." + suffix.text(),
               f.name + ".dat", style);
    script.add("set label 100 {} at screen 0.995, screen 0.012 right font ',6' tc rgb '#888888' noenhanced\n",
               origin(f, folder));
    script.add("{}unset output\n", f.script);
  };
  page(Script().add("set terminal pdfcairo size {}cm,{}cm font 'DejaVu Sans,8'", f.width_cm, f.height_cm),
       "pdf");
  page(Script().add("set terminal pngcairo size {},{} font 'DejaVu Sans,8' fontscale 2.0 linewidth 2.0",
                    static_cast<int>(100 * f.width_cm), static_cast<int>(100 * f.height_cm)),
       "png");
  return script;
}

/// A folder to draw in, which goes with what is left in it.
class DrawingPlace {
 public:
  explicit DrawingPlace(const std::filesystem::path& folder) : folder_(folder) {
    make_folder(folder.parent_path());
    std::filesystem::remove_all(folder);  // of a drawing that was killed
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
  constexpr std::size_t longest = 60;
  std::string name(of.substr(0, longest));
  for (char& c : name)
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
          c == '-' || c == '.'))
      c = '_';
  if (name != of) name += fmt::format("_{:016x}", checksum(of));
  return fmt::format("{}_{}", kind, name);
}

std::filesystem::path draw(const Figure& f, const std::filesystem::path& folder) {
  if (f.blocks.empty()) throw OutputError(f.name + ": nothing to draw");
  const auto script = script_of(f, folder);
  std::string data;
  for (const auto& block : f.blocks)  // gnuplot does not count a block without rows
    data += block.text() + (block.empty() ? "NaN NaN\n" : "") + "\n\n";
  const auto figures = folder / "figures";
  const DrawingPlace place(figures / (f.name + ".partial"));
  write_file(place / (f.name + ".dat"), data);
  write_file(place / (f.name + ".gp"), script.text());
  const auto said = run_gnuplot(place.path(), f.name + ".gp");
  for (const auto* suffix : {".pdf", ".png"})
    if (const auto made = place / (f.name + suffix);
        !said.empty() || !std::filesystem::exists(made) || std::filesystem::file_size(made) < 2000)
      throw OutputError(fmt::format("{}: gnuplot did not draw it{}", (figures / (f.name + suffix)).string(),
                                    said.empty() ? "" : ": " + said));
  for (const auto* suffix : {".dat", ".gp", ".png", ".pdf"})
    move_file(place.path(), figures, f.name + suffix);
  return figures / (f.name + ".pdf");
}

std::vector<std::filesystem::path> all(const std::filesystem::path& folder) {
  const Drawing* const drawings[] = {
#define FIGURES(name) &(name),
#include "plots/figures.def"
#undef FIGURES
  };
  std::vector<std::filesystem::path> made;
  for (const auto* drawing : drawings) {
    if (std::ranges::none_of(drawing->needs,
                             [&](const char* f) { return std::filesystem::exists(folder / f); }))
      continue;
    const auto paths = drawing->draw(folder);
    made.insert(made.end(), paths.begin(), paths.end());
  }
  return made;
}

}  // namespace freeplay::plots
