// The program: signals, the command line, and how a failure is told.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>
#include <system_error>

#include "cli/stop_signal.hpp"
#include "cli/terminal.hpp"
#include "cli/verb.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"
#include "values/snapshot.hpp"

using namespace freeplay;

namespace {

/// Says on stderr why it ended; the exit status.
int told(const char* what, int status, const char* who = "") {
  std::fputs(fmt::format("{}{}\n", who, what).c_str(),
             stderr);  // a closed stderr is no reason to fail otherwise
  return status;
}

/// What was printed may still lie in a buffer, and a full disk or a closed pipe shows when it leaves. `refused`: why
/// some of it could not be printed before.
int with_whole_output(int status, int refused) {
  errno = refused;
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return status;
  const auto why = fmt::format("standard output: cannot be written: {}",
                               errno != 0 ? std::strerror(errno) : "some of it was lost");
  return told(why.c_str(), status == 0 ? 1 : status);
}

/// Files that are opened later must not have the numbers of standard streams that are closed, or what is printed would go
/// into them. Printing still fails.
void hold_standard_streams() {
  int number = 0;
  while (number >= 0 && number <= 2) number = open("/dev/null", O_RDONLY);
  if (number > 2) close(number);
}

int run(int argc, char** argv, int& refused) {
  cli::Program program{cli::listen_for_signals()};
  try {
    return program.run(argc, argv);
  } catch (const ModelError& e) {
    return told(e.what(), 2);
  } catch (const SnapshotError& e) {
    return told(e.what(), 2);
  } catch (const OutputError& e) {
    return told(e.what(), 1);
  } catch (const Interrupted& e) {
    return told(e.what(), 1);
  } catch (const std::bad_alloc&) {
    return told("out of memory", 1);
  } catch (const std::system_error& e) {
    if (!std::ferror(stdout)) return told(e.what(), 1, "freeplay: ");
    refused = e.code().value();
    return 1;
  } catch (const std::exception& e) {
    return told(e.what(), 1, "freeplay: ");
  }
}

}  // namespace

int main(int argc, char** argv) {
  hold_standard_streams();
  cli::guard_terminal();
  int refused = 0;
  const int status = run(argc, argv, refused);
  return with_whole_output(status, refused);
}
