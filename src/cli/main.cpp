// The program: signals, command line, and messages about failures.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>
#include <system_error>

#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/terminal.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"
#include "values/snapshot.hpp"

using namespace freeplay;

namespace {

/// Prints the reason of the failure to stderr; returns the exit status.
int report_failure(const char* what, int status, const char* who = "") {
  std::fputs(fmt::format("{}{}\n", who, what).c_str(),
             stderr);  // an error of stderr itself does not change the status
  return status;
}

/// Flushes stdout, because a full disk or a closed pipe may show only then. `refused`: error number
/// of an earlier failed output.
int with_whole_output(int status, int refused) {
  errno = refused;
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return status;
  const auto why = fmt::format("standard output: cannot be written: {}",
                               errno != 0 ? std::strerror(errno) : "part of the output was lost");
  return report_failure(why.c_str(), status == 0 ? 1 : status);
}

/// Opens closed standard streams to /dev/null (read-only). Otherwise a file that is opened later
/// could get their number and receive printed text. Printing still fails.
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
    return report_failure(e.what(), 2);
  } catch (const SnapshotError& e) {
    return report_failure(e.what(), 2);
  } catch (const OutputError& e) {
    return report_failure(e.what(), 1);
  } catch (const Interrupted& e) {
    return report_failure(e.what(), 1);
  } catch (const std::bad_alloc&) {
    return report_failure("out of memory", 1);
  } catch (const std::system_error& e) {
    if (!std::ferror(stdout)) return report_failure(e.what(), 1, "freeplay: ");
    refused = e.code().value();
    return 1;
  } catch (const std::exception& e) {
    return report_failure(e.what(), 1, "freeplay: ");
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
