// The program: signals, the command line, and how a failure is told.
#include <fmt/format.h>

#include <atomic>
#include <csignal>
#include <new>

#include "cli/terminal.hpp"
#include "cli/verb.hpp"
#include "io/output_file.hpp"
#include "model/error.hpp"
#include "values/snapshot.hpp"

using namespace freeplay;

namespace {

/// Set by a signal: runs end after their present step, with whole files. The program's own; the library has none.
std::atomic<bool> stop_requested{false};

}  // namespace

int main(int argc, char** argv) {
  // The first signal asks to stop; a second one ends the program.
  const auto stop = [](int signal) {
    stop_requested = true;
    std::signal(signal, SIG_DFL);
  };
  std::signal(SIGINT, stop);
  std::signal(SIGTERM, stop);
  std::signal(SIGPIPE, SIG_IGN);

  cli::guard_terminal();
  cli::Program program{StopToken(stop_requested)};
  try {
    return program.run(argc, argv);
  } catch (const ModelError& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 2;
  } catch (const SnapshotError& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 2;
  } catch (const OutputError& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "out of memory\n");
    return 1;
  } catch (const std::exception& e) {
    fmt::print(stderr, "freeplay: {}\n", e.what());
    return 1;
  }
}
