// Division of a study among machines. A study consists of units that are computed independently:
// runs of a sweep, chains of a bifurcation diagram, starts of an ensemble. Each is identified by a
// digest of everything it depends on. The order of units is pseudorandom,
//
//     place(u) = mix(checksum(u)),      shard k of N has the ranks  (k − 1)·n/N ≤ rank < k·n/N,
//
// so shards have equal size for any order of the runs in the study, and the runs are the same for
// any N. Files in the result folder DIR:
//
//     shards/manifest.json     the plan: verb, arguments, N, digests of study, program and units
//     shards/units.txt         the units in their order: digest and number, lines of equal length
//     shards/K.json            seal of shard K: name, size and checksum of its file, statistics
//     shards/K-CHECKSUM.db     database of shard K, as one process would make it of these units
//     shards/K.part.db         copy of an unfinished shard, from which another machine can continue
//     shards/K.state.json      progress of the shard, or reason of its failure
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/files/folder_lock.hpp"
#include "values/stop.hpp"

namespace freeplay {

// Atomic files on shared folders: written under a temporary name, flushed to the disk, then
// renamed. Locks are not used, because network file systems do not provide them reliably; an
// existing file is complete.

/// 64-bit checksum over blocks of one megabyte, as 16 hexadecimal digits. Throws SceneError unless
/// the file is a regular file of at most most_of_a_database (io/files/input_file.hpp).
std::string file_checksum(const std::filesystem::path& file);

/// Copies a regular file of at most most_of_a_database atomically, possibly to another file system.
/// Throws SceneError for any other file, and OutputError if there is not enough space.
void copy_whole(const std::filesystem::path& from, const std::filesystem::path& to);

/// Copies a database that another process may be writing, as of one instant, into one file. Throws
/// OutputError.
void copy_database(const std::filesystem::path& from, const std::filesystem::path& to);

/// One unit: its digest, and its number in the study.
struct Unit {
  std::string key;
  std::size_t number = 0;
};

/// Options for the computation of units. `threads` 0: all cores. `on_progress` receives the number
/// of completed units.
struct MakeUnits {
  int threads = 0;
  StopToken stop = {};
  std::function<void(std::size_t)> on_progress = {};
};

/// Outcome of the computation of units.
struct MadeUnits {
  std::size_t failed = 0;            ///< failed runs; they are stored with their reasons
  std::vector<std::string> reasons;  ///< the first five
  bool interrupted = false;
  void add_failure(std::string why) {
    if (++failed <= 5) reasons.push_back(std::move(why));
  }
};

/// A divisible study: everything that the functions below require of its verb.
struct Division {
  std::string verb;  ///< the database is VERB.db
  /// Arguments of the command line, without the verb, -o and the options of the division.
  std::vector<std::string> arguments;
  std::string subject;  ///< digest of the study and of all files it names
  std::function<std::vector<Unit>()> units;
  /// Computes those of these units that are missing in VERB.db of the locked folder.
  std::function<MadeUnits(const FolderLock&, const std::vector<Unit>&, const MakeUnits&)> make;
  /// Post-processing of the merged database in this folder; may be empty.
  std::function<void(const std::filesystem::path&)> finish = {};
};

/// The plan of a division.
struct Manifest {
  static constexpr std::size_t current = 1;
  std::string plan;  ///< digest of the following members
  std::string verb;
  std::vector<std::string> arguments;
  std::string subject, program, units_digest;
  std::size_t shards = 0, units = 0;
  std::size_t format = current;
};

/// The seal of a complete shard.
struct Seal {
  std::string plan, file, checksum;
  std::uintmax_t bytes = 0;
  std::size_t units = 0, failed = 0;
  std::vector<std::string> reasons;
  double seconds = 0;  ///< s, computing time, all attempts
  std::string host;
};

/// The folder DIR/shards of a result folder DIR.
std::filesystem::path shards_folder(const std::filesystem::path& folder);

/// Divides a study into shards and writes the manifest. Repeating the same plan changes nothing.
/// Throws SceneError if the folder contains shards of another plan, or if there are fewer units
/// than shards.
Manifest make_plan(const Division& study, const std::filesystem::path& folder, std::size_t shards);

/// Name of a plan: digest of all members except the number of units, which units_digest determines.
std::string plan_digest(const Manifest& manifest);

/// Reads the manifest of a folder. Throws SceneError if there is none, or if it is invalid.
Manifest read_manifest(const std::filesystem::path& folder);

/// Throws SceneError, which names the difference, unless the manifest is of this study and this
/// program.
void require_same(const Manifest& manifest, const Division& study, const std::filesystem::path& folder);

/// The units of shard k, 1 … N.
std::vector<Unit> units_of(const Manifest& manifest, const std::filesystem::path& folder, std::size_t shard);

/// The command of the plan with further options, for messages: "freeplay sweep study.toml --shard
/// 3/24 -o out".
std::string command_for(const Manifest& manifest, const std::vector<std::string>& more);

/// The seal of a shard, valid or not; nullopt if there is none.
std::optional<Seal> read_seal(const std::filesystem::path& folder, std::size_t shard);
/// Reason why a sealed shard cannot be used, or "". `deep`: verify the checksum of its file.
std::string fault_of(const Seal& seal, const Manifest& manifest, const std::filesystem::path& folder,
                     bool deep);

}  // namespace freeplay
