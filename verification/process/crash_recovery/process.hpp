// The program as a process that is killed after a time, or before the n-th change that it makes to
// the disk.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace freeplay::killed {

using Words = std::vector<std::string>;

/// How a process ended.
struct End {
  bool killed = false;  ///< by the test; else by itself
  int status = 0;       ///< if by itself
  double seconds = 0;
  int changes =
      /// of names in folders, made or, for the last one, prevented; counted by kill_before alone
      0;
};

/// Runs `freeplay WORDS` to its end.
End let_end(const Words& words);
/// Kills it after so many seconds.
End kill_after(const Words& words, double seconds);
/// Kills it before it makes its n-th file, folder, new name or removal: between two of these the
/// disk has the same names, so that the n from 1 on cover all instants. Needs the right to trace
/// its own child.
End kill_before(const Words& words, int n);

}  // namespace freeplay::killed
