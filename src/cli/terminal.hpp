// Where text leaves the program. Names and titles come from files of strangers: whatever is printed, by whomever, has its
// control characters and direction marks spelt out here, but for line ends and tabs.
#pragma once

#include <string>

namespace freeplay::cli {

/// From now on stdout and stderr show what they are given. Errors of writing are those of the streams, as ever.
void guard_terminal();

/// Writes to stderr past the guard: control characters of the program's own, such as those that redraw a line of progress.
void redraw(const std::string& text);

}  // namespace freeplay::cli
