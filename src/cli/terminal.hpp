// Standard output and error of the program. Printed names and titles may be of unknown origin, so
// all output passes through a guard that escapes control characters and direction marks, except
// line ends and tabs.
#pragma once

#include <string>

namespace freeplay::cli {

/// Installs the guard on stdout and stderr. Errors of writing are reported by the streams as usual.
void guard_terminal();

/// Writes to stderr without the guard, for the program's own control characters (progress line).
void redraw(const std::string& text);

}  // namespace freeplay::cli
