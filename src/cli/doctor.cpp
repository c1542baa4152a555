// `freeplay doctor`: the build of this program, and the other programs that parts of it need: which
// are there, in which version, and what is missing without them.
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <regex>

#include "cli/command_line.hpp"
#include "io/files/build_identity.hpp"
#include "io/files/child.hpp"
#include "io/files/identity.hpp"
#include "mechanism/error.hpp"
#include "plots/export/export.hpp"
#include "values/diagnostic.hpp"

namespace freeplay::cli {
namespace {

/// A program that freeplay starts, and the Debian package that has it.
struct Companion {
  const char* name;
  std::vector<std::string> ask;  ///< prints its version
  const char* needed_for;
  const char* package;
};

const Companion companions[] = {
    {"gnuplot", {"gnuplot", "--version"}, "figures of all verbs", "gnuplot-nox"},
    {"DejaVu Sans",
     {"fc-match", "--format=%{family}\n", "DejaVu Sans"},
     "letters of figures",
     "fonts-dejavu-core fontconfig"},
    {"pdflatex", {"pdflatex", "--version"}, "figures in LaTeX format", "texlive-latex-recommended"},
    {"ffmpeg", {"ffmpeg", "-version"}, "films (animate --mp4, --gif)", "ffmpeg"},
    {"c++", {"c++", "--version"}, "contact laws of your own (run --law-plugin)", "g++"},
    {"cmake", {"cmake", "--version"}, "programs that use the library", "cmake"},
    {"python3", {"python3", "--version"}, "the Python package", "python3"},
    {"sbatch", {"sbatch", "--version"}, "studies on a Slurm cluster (submit)", "slurm-client"},
};

/// The first line that it prints about itself; nothing if it cannot be started or says it fails.
std::optional<std::string> version_of(const Companion& c, StopToken stop) {
  const auto end = run_child({.command = c.ask, .seconds = 20, .listen = true, .stop = stop});
  if (end.status != 0 || end.late) return {};
  auto line = end.output.substr(0, end.output.find('\n'));
  if (line.find("DejaVu") == std::string::npos && c.ask.front() == "fc-match") return {};
  return line.substr(0, 40);
}

const char* hdf5() {
  try {
    require_hdf5();
    return "found";
  } catch (const SceneError&) {
    return "missing (Debian: libhdf5-dev, build again)";
  }
}

struct DoctorRequest : Request {
  bool diagnostics = false;  ///< list them, as docs/reference/diagnostics.md does
};

int list_diagnostics() {
  for (const auto& d : diagnostics)
    fmt::print("| `{}` | {} | {} | {} |\n", d.name, d.severity == Severity::warning ? "warning" : "note",
               std::regex_replace(std::string(d.text), std::regex("\\{[^}]*\\}"), "…"), d.meaning);
  return 0;
}

int doctor(const DoctorRequest& request) {
  if (request.diagnostics) return list_diagnostics();
  fmt::print("freeplay {}\n{}\n", version_text(), program_identity());
  bool figures = true;
  for (const auto& c : companions) {
    const auto found = version_of(c, request.stop);
    fmt::print("{:<13}{:<40}  {}\n", c.name, found ? *found : fmt::format("missing (Debian: {})", c.package),
               c.needed_for);
    if (!found && std::string_view(c.name) == "gnuplot") figures = false;
  }
  fmt::print("{:<13}{:<40}  export --hdf5\n", "HDF5", hdf5());
  std::error_code error;
  const auto here = std::filesystem::current_path(error);
  const auto space = std::filesystem::space(here, error);
  if (!error)
    fmt::print("{:<13}{:.1f} GB free in this folder\n", "disk", static_cast<double>(space.available) / 1e9);
  fmt::print("\n{}\n", figures ? "Everything that runs and figures need is installed."
                               : "Runs work. Figures need gnuplot: without it none are drawn.");
  return 0;
}

}  // namespace

void doctor_verb(Program& program) {
  auto [options, request] =
      program.verb("doctor", "report versions, and which optional programs are missing", doctor);
  options.flag("--diagnostics", request.diagnostics,
               "list all notes and warnings of runs with their meaning");
}

}  // namespace freeplay::cli
