#include "plots/figure.hpp"

#include <fmt/format.h>

#include <gnuplot-iostream.h>
#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/output_file.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::string field;
  std::istringstream in(line);
  while (std::getline(in, field, ',')) fields.push_back(field);
  return fields;
}

std::string quoted(const std::filesystem::path& path) { return "'" + escaped(path.string()) + "'"; }

/// What a figure says of its origin: program, commit, case.
std::string origin(const Figure& f, const std::filesystem::path& folder) {
  const auto file = folder / f.source;
  std::ifstream in(file);
  const auto document = nlohmann::json::parse(in, nullptr, false);
  if (document.is_discarded()) throw OutputError(file.string() + ": cannot be read");
  const auto& p = document.at("provenance");
  return fmt::format("freeplay {} ({}), {}", p.at("version").get<std::string>(),
                     p.at("commit").get<std::string>(),
                     f.scene_file.empty() ? p.at("scene_file").get<std::string>() : f.scene_file);
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out;
}

Csv::Csv(const std::filesystem::path& file) : file_(file.string()) {
  std::ifstream in(file);
  std::string line;
  if (!in || !std::getline(in, line)) throw OutputError(file_ + ": cannot be read");
  names_ = split(line);
  columns_.resize(names_.size());
  while (std::getline(in, line)) {
    const auto fields = split(line);
    if (fields.size() != names_.size())
      throw OutputError(fmt::format("{}: line {} has {} fields, its header {}", file_, rows() + 2,
                                    fields.size(), names_.size()));
    for (std::size_t i = 0; i < fields.size(); ++i) columns_[i].push_back(fields[i]);
  }
}

bool Csv::has(const std::string& name) const { return std::ranges::find(names_, name) != names_.end(); }

const std::vector<std::string>& Csv::text(const std::string& name) const {
  const auto it = std::ranges::find(names_, name);
  if (it == names_.end()) throw OutputError(fmt::format("{}: has no column {}", file_, name));
  return columns_[it - names_.begin()];
}

std::vector<double> Csv::column(const std::string& name) const {
  std::vector<double> x;
  for (const auto& s : text(name)) x.push_back(std::strtod(s.c_str(), nullptr));
  return x;
}

std::string style() {
  return "set encoding utf8\n"
         "set style line 1 lc rgb '#0b3c8c' lw 1.6 dt 1 pt 6 ps 1.1\n"
         "set style line 2 lc rgb '#c8500a' lw 1.3 dt (12,5) pt 2 ps 1.0\n"
         "set style line 3 lc rgb '#000000' lw 2.2 dt (2,4)\n"
         "set style line 4 lc rgb '#888888' lw 1.0 dt 1\n"
         "set border lw 0.8\n"
         "set tics nomirror scale 0.6\n"
         "set grid lc rgb '#cccccc' lw 0.6 dt 1\n"
         "set key top right samplen 3 spacing 1.1\n";
}

std::filesystem::path draw(const Figure& f, const std::filesystem::path& folder) {
  const auto figures = folder / "figures";
  make_folder(figures);
  std::string data;
  for (const auto& block : f.blocks) data += block + "\n\n";
  if (data.empty()) throw OutputError(f.name + ": nothing to draw");
  write_file(figures / (f.name + ".dat"), data);

  std::string body = f.script;
  for (std::size_t at; (at = body.find("'DATA'")) != body.npos;) body.replace(at, 6, "'" + f.name + ".dat'");
  const auto from = origin(f, folder);
  std::string script = "# " + from + "\n# Draw again: gnuplot " + f.name + ".gp\n" + style();
  script += fmt::format(
      "set label 100 '{}' at screen 0.995, screen 0.012 right font ',6' tc rgb '#888888' noenhanced\n",
      escaped(from));
  const auto page = [&](const char* terminal, const char* suffix) {
    return fmt::format("reset session\n{}\nset output '{}.{}'\n", terminal, f.name, suffix);
  };
  const auto pdf =
      fmt::format("set terminal pdfcairo size {}cm,{}cm font 'DejaVu Sans,8'", f.width_cm, f.height_cm);
  const auto png =
      fmt::format("set terminal pngcairo size {},{} font 'DejaVu Sans,8' fontscale 2.0 linewidth 2.0",
                  static_cast<int>(100 * f.width_cm), static_cast<int>(100 * f.height_cm));
  write_file(figures / (f.name + ".gp"), page(pdf.c_str(), "pdf") + script + body + "unset output\n" +
                                             page(png.c_str(), "png") + script + body + "unset output\n");

  const auto target = figures / (f.name + ".pdf");
  std::error_code ignored;
  std::filesystem::remove(target, ignored);
  {
    Gnuplot gnuplot("gnuplot");
    gnuplot << "cd " << quoted(figures) << "\nload " << quoted(f.name + ".gp") << "\n";
  }
  for (const auto* suffix : {".pdf", ".png"}) {
    const auto made = figures / (f.name + suffix);
    if (!std::filesystem::exists(made) || std::filesystem::file_size(made) < 2000)
      throw OutputError(made.string() + ": gnuplot did not draw it");
  }
  return target;
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
