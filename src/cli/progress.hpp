// Progress line on a terminal. Prints nothing if stderr is not a terminal.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <string>

#include "cli/terminal.hpp"
#include "io/files/visible.hpp"

namespace freeplay::cli {

/// Shows a label and a percentage, and redraws the line when they change.
class Progress {
 public:
  void show(const std::string& what, double done) {
    const int percent = static_cast<int>(100 * done);
    if (!terminal_ || (what == what_ && percent == percent_)) return;
    what_ = what;
    percent_ = percent;
    redraw(fmt::format("\r{:<12} {:>3} %", visible(what), percent));
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
  std::string what_;
  int percent_ = -1;
};

}  // namespace freeplay::cli
