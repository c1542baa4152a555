// Terminal: guard of standard output and error, wrapped text, progress. Printed names and titles
// may be of unknown origin, so all output passes through a guard that escapes control characters and
// direction marks, except line ends and tabs.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "io/files/escaping.hpp"

namespace freeplay::cli {

/// Installs the guard on stdout and stderr. Errors of writing are reported by the streams as usual.
void guard_terminal();

/// Writes to stderr without the guard, for the program's own control characters (progress line).
void redraw(const std::string& text);

// Wraps text for a terminal of 80 columns.

/// `text` with lines longer than 80 columns (UTF-8 without wide characters) broken at spaces.
/// Continuation lines are indented by `indent` columns.
inline std::string wrapped(std::string_view text, std::size_t indent = 2) {
  std::string out;
  // `word`: columns since the last space.
  std::size_t column = 0, space = std::string::npos, word = 0;
  for (const char c : text) {
    out += c;
    if ((c & 0xC0) == 0x80) continue;
    ++column, ++word;
    if (c == '\n') column = 0, space = std::string::npos;
    if (c == ' ' && column > indent + 1) space = out.size() - 1, word = 0;
    if (column <= 80 || space == std::string::npos) continue;
    out.replace(space, 1, "\n" + std::string(indent, ' '));
    column = indent + word;
    space = std::string::npos;
  }
  return out;
}

// Progress: a line that is redrawn on a terminal; into a pipe or a file, lines of their own.

/// When a line is due in a pipe: a pause after the beginning, and after each line.
class LinePace {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds pause{60};

  explicit LinePace(Clock::time_point begin = Clock::now()) : last_(begin) {}
  bool due(Clock::time_point now = Clock::now()) {
    if (now - last_ < pause) return false;
    last_ = now;
    return true;
  }

 private:
  Clock::time_point last_;
};

/// A label and a percentage, on stderr. A terminal's line is redrawn when they change; otherwise at most one
/// line a minute is written, so a short command writes none.
class Progress {
 public:
  /// `done`: completed fraction, if it is known.
  void show(const std::string& what, std::optional<double> done = {}) {
    const auto percent = done ? fmt::format("{} %", static_cast<int>(100 * *done)) : "";
    if (!terminal_) {
      if (pace_.due()) fmt::print(stderr, "{}{}{}\n", what, percent.empty() ? "" : ": ", percent);
      return;
    }
    if (what == what_ && percent == percent_) return;
    what_ = what;
    percent_ = percent;
    redraw(fmt::format("\r{:<12} {:>5}", visible(what), percent));
  }
  /// A function that shows the progress of a study's runs after a label.
  auto of_runs(const std::string& label = "") {
    return [this, label](const auto& p) {
      show(fmt::format("{}{} of {} runs, {:.0f} s left", label, p.done, p.total, p.seconds_left),
           static_cast<double>(p.done) / static_cast<double>(p.total));
    };
  }
  void clear() {
    if (terminal_) redraw(fmt::format("\r{:60}\r", ""));
  }

 private:
  const bool terminal_ = isatty(2);
  LinePace pace_;
  std::string what_, percent_;
};

}  // namespace freeplay::cli
