// One shard of a divided study, made by one process. It works in a folder of its own on the node's disk, where SQLite may be what it
// is, and brings whole files to the shared folder (study/partition/shard_file.hpp):
//
//     while it is made    a copy every so often, from which another node goes on, and how far it is
//     when it is stopped  the same at once
//     when it is whole    its file, then its seal; what was there of it before goes
//
// Two processes that make one shard do not meet: they make the same, and the last seal counts.
#pragma once

#include "study/partition/division.hpp"

namespace freeplay {

struct ShardAsked {
  std::size_t shard = 1;          ///< 1 … N
  std::filesystem::path scratch;  ///< folder on the node's own disk
  int threads = 0;
  StopToken stop = {};
  std::function<void(std::size_t done, std::size_t total)> on_progress = {};
  std::function<void()> on_stop = {};  ///< told before what is made so far is brought to the shared folder
};

struct ShardMade {
  Seal seal;
  bool found = false;        ///< it was whole already
  bool interrupted = false;  ///< what is made so far is kept, and the same command goes on
};

/// Makes a shard of what is planned in the folder. Throws SceneError where study or program are not those of the plan, OutputError
/// where a disk refuses; why stands in the shard's state, too.
ShardMade make_shard(const Division& study, const std::filesystem::path& folder, const ShardAsked& asked);

/// How far a shard is that has no seal, as its process said last.
struct ShardState {
  std::string state = {};  ///< "running", "stopped" (goes on), "failed"; "" when nobody has begun it
  std::string reason = {}, host = {}, job = {};
  std::size_t done = 0, total = 0;
  double seconds = 0;  ///< of its making
  double when = 0;     ///< s since 1970, when it said so
};
ShardState state_of(const std::filesystem::path& folder, std::size_t shard);

}  // namespace freeplay
