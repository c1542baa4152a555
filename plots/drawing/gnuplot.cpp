#include "plots/drawing/gnuplot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <gnuplot-iostream.h>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "io/files/child.hpp"
#include "io/files/descriptor.hpp"
#include "io/files/output_file.hpp"

namespace freeplay::plots {
namespace {

constexpr double longest = 60;  // s

/// The standard input of gnuplot: one line, short enough for the buffer of the pipe that
/// gnuplot-iostream writes to.
std::string commands(const std::string& script) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw OutputError(fmt::format("gnuplot: cannot create a pipe: {}", std::strerror(errno)));
  const Descriptor read_end(ends[0]);
  Descriptor write_end(ends[1]);
  if (std::FILE* file = fdopen(write_end.number(), "w")) {
    write_end.release();
    Gnuplot gnuplot(file);  // its destructor closes the file
    gnuplot << "load '" << script << "'\n";
  }
  write_end = Descriptor();
  std::string message(4096, ' ');
  const auto count = read(read_end.number(), message.data(), message.size());
  message.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  return message;
}

}  // namespace

std::string run_gnuplot(const std::filesystem::path& folder, const std::string& script) {
  const auto place = open_folder(folder);
  const auto message = commands(script);
  const auto end = run_child({.command = {"gnuplot", "--default-settings"},
                              .folder = fmt::format("/proc/self/fd/{}", place.number()),
                              .input = message,
                              .seconds = longest});
  if (end.late) return fmt::format("it took longer than {:.0f} s and was stopped", longest);
  if (end.status == 127) throw OutputError("gnuplot: cannot be started; is it installed?");
  if (end.status == 0) return "";
  const auto from = end.errors.find_first_not_of('\n');
  if (from == std::string::npos) return "it ended without a message";
  return end.errors.substr(from, end.errors.find('\n', from) - from);
}

}  // namespace freeplay::plots
