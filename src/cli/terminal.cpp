#include "cli/terminal.hpp"

#include <cerrno>
#include <cstdio>

namespace freeplay::cli {
namespace {

/// Replacement of a standard stream that escapes its text.
struct Guard {
  int descriptor;
  VisibleStream visible{"\n\t"};
};

bool write_all(int descriptor, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const auto count = write(descriptor, text.data() + done, text.size() - done);
    if (count < 0 && errno != EINTR) return false;
    if (count > 0) done += static_cast<std::size_t>(count);
  }
  return true;
}

/// Returns `size`, or 0 on an error, as fopencookie() requires.
ssize_t write_guarded(void* guard, const char* text, std::size_t size) {
  auto& g = *static_cast<Guard*>(guard);
  return write_all(g.descriptor, g.visible.pass({text, size})) ? static_cast<ssize_t>(size) : 0;
}

/// The guarded stream, or null without memory.
std::FILE* guarded(Guard& guard, int buffering) {
  std::FILE* stream = fopencookie(&guard, "w", {nullptr, write_guarded, nullptr, nullptr});
  if (stream) std::setvbuf(stream, nullptr, buffering, BUFSIZ);
  return stream;
}

}  // namespace

void guard_terminal() {
  // Never destroyed: the streams are flushed after all destructors.
  static auto& out = *new Guard{1};
  static auto& err = *new Guard{2};
  std::fflush(stdout);
  if (auto* stream = guarded(out, isatty(1) ? _IOLBF : _IOFBF)) stdout = stream;
  if (auto* stream = guarded(err, _IOLBF)) stderr = stream;
}

void redraw(const std::string& text) {
  std::fflush(stderr);
  write_all(2, text);
}

}  // namespace freeplay::cli
