// A study divided for many machines. It consists of units, each made by itself and named by a digest of all that it depends on: a
// run of a sweep, a chain of a bifurcation, a start of an ensemble. The order of units is by content,
//
//     place(u) = mix(checksum(u)),      shard k of N holds the ranks  (k − 1)·n/N ≤ rank < k·n/N,
//
// so that shards are of one size, whatever order a study states its runs in, and the runs made are the same for any N. Below the
// result folder DIR:
//
//     shards/manifest.json     what was planned: verb, its arguments, N, digests of the study, the program and all units
//     shards/units.txt         the units in their order: digest and number, a line of one length each
//     shards/K.json            the seal of shard K: name, size and checksum of its file, and how its making went
//     shards/K-CHECKSUM.db     the file of shard K, a database as one process would have made it of these units
//     shards/K.part.db         a copy of a shard that is being made, from which it goes on elsewhere
//     shards/K.state.json      how far it is, or why it gave up
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/files/folder_lock.hpp"
#include "values/stop.hpp"

namespace freeplay {

/// One unit: its digest, and the number by which its verb finds it in the study.
struct Unit {
  std::string key;
  std::size_t number = 0;
};

/// How units are made: with how many threads (0: all cores), until when, and who is told of progress (units done).
struct MakeUnits {
  int threads = 0;
  StopToken stop = {};
  std::function<void(std::size_t)> on_progress = {};
};

/// How the making of units went.
struct MadeUnits {
  std::size_t failed = 0;            ///< runs that gave up; they are stored, with their reasons
  std::vector<std::string> reasons;  ///< the first few
  bool interrupted = false;
  void add_failure(std::string why) {
    if (++failed <= 5) reasons.push_back(std::move(why));
  }
};

/// What a verb has to say so that its study can be divided.
struct Division {
  std::string verb;                    ///< its database is VERB.db
  std::vector<std::string> arguments;  ///< of the command line, without the verb, -o and what divides
  std::string subject;                 ///< digest of the study and of every file that it names
  std::function<std::vector<Unit>()> units;
  /// Makes of these what is missing in VERB.db of the locked folder.
  std::function<MadeUnits(const FolderLock&, const std::vector<Unit>&, const MakeUnits&)> make;
  /// What is computed of the merged database in this folder; may be none.
  std::function<void(const std::filesystem::path&)> finish = {};
};

/// What was planned.
struct Manifest {
  static constexpr std::size_t current = 1;
  std::string plan;  ///< digest of what follows
  std::string verb;
  std::vector<std::string> arguments;
  std::string subject, program, units_digest;
  std::size_t shards = 0, units = 0;
  std::size_t format = current;
};

/// The seal of a shard that is whole.
struct Seal {
  std::string plan, file, checksum;
  std::uintmax_t bytes = 0;
  std::size_t units = 0, failed = 0;
  std::vector<std::string> reasons;
  double seconds = 0;  ///< of its making, all attempts
  std::string host;
};

std::filesystem::path shards_folder(const std::filesystem::path& folder);

/// Cuts a study into shards and writes the manifest; the same plan again changes nothing. Throws SceneError where the folder
/// holds shards of another plan, or more shards than units are asked for.
Manifest make_plan(const Division& study, const std::filesystem::path& folder, std::size_t shards);

/// What a plan is called: of all that it says but the number of its units, which their digest tells.
std::string plan_digest(const Manifest& manifest);

/// The manifest of a folder. Throws SceneError where there is none, or it is no manifest.
Manifest read_manifest(const std::filesystem::path& folder);

/// Throws SceneError unless the manifest is of this study and of this program, saying which is another.
void require_same(const Manifest& manifest, const Division& study, const std::filesystem::path& folder);

/// The units of shard k, 1 … N.
std::vector<Unit> units_of(const Manifest& manifest, const std::filesystem::path& folder, std::size_t shard);

/// The plan's verb with its arguments and more, for messages: "freeplay sweep study.toml --shard 3/24 -o out".
std::string command_for(const Manifest& manifest, const std::vector<std::string>& more);

/// The seal of a shard, whole or not; none where there is no seal.
std::optional<Seal> read_seal(const std::filesystem::path& folder, std::size_t shard);
/// Why a sealed shard cannot be used: "" when it can. `deep`: its bytes are read.
std::string fault_of(const Seal& seal, const Manifest& manifest, const std::filesystem::path& folder,
                     bool deep);

}  // namespace freeplay
