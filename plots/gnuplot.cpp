#include "plots/gnuplot.hpp"

#include <fmt/format.h>

#include <gnuplot-iostream.h>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "io/child.hpp"
#include "io/descriptor.hpp"
#include "io/output_file.hpp"

namespace freeplay::plots {
namespace {

constexpr double longest = 60;  // s

/// What gnuplot is told on its standard input.
std::string commands(const std::string& script) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* const memory = open_memstream(&text, &size);
  if (!memory) throw OutputError(fmt::format("gnuplot: cannot be told anything: {}", std::strerror(errno)));
  {
    Gnuplot gnuplot(memory);  // closes it
    gnuplot << "load '" << script << "'\n";
  }
  const std::unique_ptr<char, decltype(&std::free)> owned(text, &std::free);
  return {text, size};
}

}  // namespace

std::string run_gnuplot(const std::filesystem::path& folder, const std::string& script) {
  const auto place = open_folder(folder);
  const auto told = commands(script);
  const auto end = run_child({.command = {"gnuplot", "--default-settings"},
                              .folder = fmt::format("/proc/self/fd/{}", place.number()),
                              .input = told,
                              .seconds = longest});
  if (end.late) return fmt::format("it took longer than {:.0f} s and was ended", longest);
  if (end.status == 127) throw OutputError("gnuplot: cannot be started; is it installed?");
  if (end.status == 0) return "";
  const auto from = end.errors.find_first_not_of('\n');
  if (from == std::string::npos) return "it ended without a word";
  return end.errors.substr(from, end.errors.find('\n', from) - from);
}

}  // namespace freeplay::plots
