// freeplay report: writes an interactive HTML report of a result folder, with animation.
#include "plots/report/report.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "cli/command_line.hpp"
#include "cli/folders.hpp"
#include "mechanism/error.hpp"

namespace freeplay::cli {
namespace {

struct ReportRequest : Request {
  std::string folder;
  std::string output;  ///< file
};

int make_report(const ReportRequest& request) {
  const auto folder = named_results(request.folder);
  std::filesystem::path file = folder / "report.html";
  if (!request.output.empty()) {
    const std::filesystem::path requested(request.output);
    if (!requested.has_filename() || std::filesystem::is_directory(requested))
      throw SceneError(request.output +
                       ": is a folder; -o names the file of the report, such as "
                       "report.html");
    file = real_folder(requested.has_parent_path() ? requested.parent_path() : ".") / requested.filename();
  }
  const auto lock = lock_results(folder, "report", file.parent_path() == folder);
  const auto page = report::report_page(folder);
  make_folder(file.parent_path());
  write_file(file, page);
  fmt::print("{}: {:.2f} MB\n", file.string(), 1e-6 * static_cast<double>(page.size()));
  return 0;
}

}  // namespace

void report_verb(Program& program) {
  auto [options, request] = program.verb(
      "report", "write an interactive HTML report of a result folder, with animation", make_report);
  options
      .add("folder", request.folder,
           "folder made by run, compare, orbit, lyapunov, continue, sweep, bifurcation or basin")
      .required();
  options.add("-o,--output", request.output, "file of the report; default report.html in the folder")
      .takes("FILE");
}

}  // namespace freeplay::cli
