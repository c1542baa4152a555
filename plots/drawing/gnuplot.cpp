#include "plots/drawing/gnuplot.hpp"

#include <fcntl.h>
#include <gnuplot-iostream.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>

#include "io/files/access.hpp"
#include "io/files/child.hpp"
#include "io/files/escaping.hpp"
#include "io/files/output_file.hpp"

namespace freeplay::plots {
namespace {

/// Whether a character has no special meaning to gnuplot within double quotes.
bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         std::string_view(" ,.:_+-=()/").find(c) != std::string_view::npos;
}

constexpr std::size_t most_shown = 200;  ///< characters of a text

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  bool escaped = false;
  for (const char c : text) {
    // gnuplot reads a digit after \ooo as part of the number.
    const bool plain = is_plain(c) && !(escaped && c >= '0' && c <= '9');
    if (plain)
      out += c;
    else
      fmt::format_to(std::back_inserter(out), "\\{:03o}", static_cast<unsigned char>(c));
    escaped = !plain;
  }
  return out + "\"";
}

std::string doubled(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '%' ? std::string("%%") : std::string(1, c);
  return out;
}

}  // namespace

std::string literal(std::string_view text) { return in_quotes(visible_brief(text, most_shown)); }

std::string marked_literal(std::string_view text) {
  std::string out;
  for (const char c : visible_brief(text, most_shown)) {
    if (std::string_view("_^{}@&~\\").find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return in_quotes(out);
}

std::string in_tex(std::string_view text) {
  std::string out;
  for (const char c : visible_brief(text, most_shown)) {
    const auto at = std::string_view("\\{}$&#_%~^\"<>|").find(c);
    constexpr const char* spelt[] = {"\\textbackslash{}",
                                     "\\{",
                                     "\\}",
                                     "\\$",
                                     "\\&",
                                     "\\#",
                                     "\\_",
                                     "\\%",
                                     "\\textasciitilde{}",
                                     "\\textasciicircum{}",
                                     "\\char34{}",
                                     "\\textless{}",
                                     "\\textgreater{}",
                                     "\\textbar{}"};
    if (at == std::string_view::npos)
      out += c;
    else
      out += spelt[at];
  }
  return out;
}

std::string tex_literal(std::string_view text) { return in_quotes(in_tex(text)); }

double finite(double x) {
  if (!std::isfinite(x)) throw OutputError(fmt::format("a figure cannot hold {}", x));
  return x;
}

Script& Script::add_tic(std::string_view text, double at) {
  text_ += fmt::format("{} {:.12g}", in_quotes(doubled(visible_brief(text, most_shown))), finite(at));
  tex_ += fmt::format("{} {:.12g}", in_quotes(doubled(in_tex(text))), at);
  return *this;
}

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
