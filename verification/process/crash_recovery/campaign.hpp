// Crash-recovery tests of commands: each is killed at random instants, or before each change on the
// disk, and called again as a user would. After every kill and at the end these conditions are
// checked:
//
//     no finished result is lost   results under replacement are complete, either the older or the
//                                  new ones; stored runs are unchanged
//     the command resumes          the next call ends normally
//     the results are the same     they equal those of an undisturbed call
//     nothing is left over         no incomplete file, no lock, no checkpoint of a finished run
#pragma once

#include <sys/types.h>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace freeplay::killed {

// The program as a process that is killed after a time, or before the n-th change that it makes to
// the disk.

using Words = std::vector<std::string>;

/// How a process ended.
struct End {
  bool killed = false;  ///< by the test; else by itself
  int status = 0;       ///< if by itself
  double seconds = 0;
  /// of names in folders, made or, for the last one, prevented; counted by kill_before alone
  int changes = 0;
};

/// Runs `freeplay WORDS` to its end.
End let_end(const Words& words);
/// Kills it after so many seconds.
End kill_after(const Words& words, double seconds);
/// Kills it before it makes its n-th file, folder, new name or removal: between two of these the
/// disk has the same names, so that the n from 1 on cover all instants. Needs the right to trace
/// its own child.
End kill_before(const Words& words, int n);

// The content of a result folder without machine-dependent parts: for comparing results and
// detecting losses.

using Path = std::filesystem::path;
/// By the names of files below a folder, or of runs in a database.
using Contents = std::map<std::string, std::string>;

/// The result files of a folder and of those below it, except figures, databases, hidden files and
/// incomplete files (.partial, run.checkpoint).
Contents results_in(const Path& folder);

/// Every run of a study's database by its key: all its stored values except times, in the order in
/// which a run is stored. Equal texts mean equal runs, whichever process made them and whenever.
Contents runs_in(const Path& database);

/// Names below a folder that a completed call does not leave.
std::string leftovers_in(const Path& folder);

/// A command as it is called here.
struct Verb {
  std::string name;
  Words words;                ///< all except the folder
  Words older = {};           ///< another call, whose finished results exist at the beginning
  std::string database = {};  ///< in the folder, whose runs it adds to
  bool resumes = false;       ///< resumes with `run --resume` if there is a checkpoint
  bool in_folder = false;     ///< takes the folder as its last argument, not by -o
};

/// Results of the campaign for a command.
struct Tally {
  int kills = 0, calls = 0, lost = 0, stuck = 0, other = 0, left_over = 0;
  std::vector<std::string> findings;  ///< violations, a line each
};

class Campaign {
 public:
  /// Makes the results of the undisturbed command and of the older call in this folder first.
  Campaign(const Verb& verb, const Path& folder);
  /// Kills at random instants of its duration, until this number of kills has taken effect.
  void at_random(int kills, unsigned seed);
  /// Kills before each `every`-th change of names in a folder, from the first on, until it ends.
  void at_changes(int first, int every);
  const Tally& tally() const { return tally_; }

 private:
  Words words() const;
  void prepare();
  void finish();
  /// Checks the folder after a kill.
  void assess(const std::string& when);
  void wrong(int& count, const std::string& what);

  Verb verb_;
  Path whole_, older_, shot_;
  Contents expected_, before_, expected_runs_, stored_;
  double seconds_ = 0;
  Tally tally_;
};

/// The commands of the campaign, small ones. `folder`: for their studies.
std::vector<Verb> verbs(const Path& folder);

}  // namespace freeplay::killed
