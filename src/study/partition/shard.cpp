#include "study/partition/shard.hpp"

#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <thread>

#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"
#include "study/partition/record.hpp"
#include "study/store/database.hpp"

namespace freeplay {
namespace {

constexpr double least_room = 16e6;  // bytes

void remove_if_left(const std::filesystem::path& folder) {
  try {
    { const FolderLock free(folder, "shard"); }
    std::filesystem::remove_all(folder);
  } catch (const std::exception&) {
    // Another shard uses the folder.
  }
}

}  // namespace

Scratch::Scratch(const std::filesystem::path& where, const std::string& plan) {
  const auto mine = fmt::format("freeplay-{}-", plan.substr(0, 12));
  std::error_code none;
  std::filesystem::create_directories(where, none);
  for (const auto& entry : std::filesystem::directory_iterator(where, none))
    if (entry.path().filename().string().starts_with(mine)) remove_if_left(entry.path());
  struct statvfs disk {};
  if (statvfs(where.c_str(), &disk) != 0 ||
      static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize) < least_room)
    throw OutputError(
        fmt::format("scratch {}: is not a folder or is full; give another with --scratch", where.string()));
  auto name = (real_folder(where) / (mine + "XXXXXX")).string();
  if (!mkdtemp(name.data())) throw OutputError(fmt::format("scratch {}: cannot be written", where.string()));
  folder_ = name;
  lock_ = std::make_unique<FolderLock>(folder_, "shard");
}

Scratch::~Scratch() {
  lock_.reset();
  std::error_code none;
  std::filesystem::remove_all(folder_, none);
}

namespace {

constexpr double say_seconds = 5;    // s, between two reports of the progress
constexpr double copy_seconds = 60;  // s, least time between two copies
constexpr double copy_share = 0.02;  // greatest share of the time for copies

double now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::string host() {
  if (auto node = environment("SLURMD_NODENAME"); !node.empty()) return node;
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "?";
}

std::filesystem::path state_file(const std::filesystem::path& folder, std::size_t shard) {
  return shards_folder(folder) / fmt::format("{}.state.json", shard);
}

void write_state(const std::filesystem::path& folder, std::size_t shard, ShardState s) {
  s.host = host();
  s.job = environment("SLURM_JOB_ID");
  s.when = now();
  write_file(state_file(folder, shard), record_text(s), OutputFile::Shared());
}

class Making {
 public:
  Making(const Division& study, const Manifest& manifest, const std::filesystem::path& folder,
         const ShardRequest& requested)
      : study_(study),
        manifest_(manifest),
        folder_(folder),
        place_(shards_folder(folder)),
        requested_(requested),
        earlier_(state_of(folder, requested.shard).seconds),
        scratch_(requested.scratch, manifest.plan),
        file_(scratch_.folder() / (study.verb + ".db")) {
    go_on_from_copy();
  }

  ShardMade make() {
    const auto units = units_of(manifest_, folder_, requested_.shard);
    total_ = units.size();
    say("running");
    MadeUnits made;
    {
      const std::jthread watch([this](const std::stop_token& end) { keep_copies(end); });
      made = study_.make(
          scratch_.lock(), units,
          {.threads = requested_.threads, .stop = requested_.stop, .on_progress = [this](std::size_t done) {
             done_ = done;
             if (requested_.on_progress) requested_.on_progress(done, total_);
           }});
    }
    if (made.interrupted) {
      if (requested_.on_stop) requested_.on_stop();
      bring_copy();
      say("stopped");
      return {.seal = {}, .interrupted = true};
    }
    return {.seal = seal(made, units.size())};
  }

 private:
  using Clock = std::chrono::steady_clock;
  double seconds() const { return std::chrono::duration<double>(Clock::now() - began_).count(); }
  std::filesystem::path part() const { return place_ / fmt::format("{}.part.db", requested_.shard); }

  void go_on_from_copy() {
    if (std::error_code none; !std::filesystem::exists(std::filesystem::symlink_status(part(), none))) return;
    try {
      const Database sound(part(), Database::Access::sealed);
    } catch (const DamagedDatabase&) {
      return;  // its runs are computed again
    }
    copy_whole(part(), file_);
  }

  void say(const char* state) const {
    write_state(folder_, requested_.shard,
                {.state = state, .done = done_, .total = total_, .seconds = earlier_ + seconds()});
  }

  void bring_copy() {
    if (!std::filesystem::exists(file_)) return;
    const auto copy = scratch_.folder() / "copy.db";
    copy_database(file_, copy);
    copy_whole(copy, part());
    std::filesystem::remove(copy);
  }

  /// Background thread: reports the progress and makes copies.
  void keep_copies(const std::stop_token& end) {
    std::mutex mutex;
    std::condition_variable_any wake;
    std::unique_lock lock(mutex);
    double next = copy_seconds;
    while (!wake.wait_for(lock, end, std::chrono::duration<double>(say_seconds),
                          [&] { return end.stop_requested(); })) {
      if (end.stop_requested()) return;
      try {
        if (seconds() >= next) {
          const double began = seconds();
          bring_copy();
          next = seconds() + std::max(copy_seconds, (seconds() - began) / copy_share);
        }
        say("running");
      } catch (const std::exception&) {
        // If the shared folder is temporarily unavailable, try again later. Only the seal is
        // essential.
      }
    }
  }

  Seal seal(const MadeUnits& made, std::size_t units) {
    const auto whole = scratch_.folder() / "whole.db";
    copy_database(file_, whole);
    Seal s{.plan = manifest_.plan,
           .file = {},
           .checksum = file_checksum(whole),
           .bytes = std::filesystem::file_size(whole),
           .units = units,
           .failed = made.failed,
           .reasons = made.reasons,
           .seconds = earlier_ + seconds(),
           .host = host()};
    s.file = fmt::format("{}-{}.db", requested_.shard, s.checksum);
    copy_whole(whole, place_ / s.file);
    write_file(place_ / fmt::format("{}.json", requested_.shard), record_text(s), OutputFile::Shared());
    remove_what_is_left(s.file);
    return s;
  }

  /// Removes copies and progress reports of this shard, and files that no seal names any more.
  void remove_what_is_left(const std::string& sealed) const {
    std::error_code none;
    std::filesystem::remove(part(), none);
    std::filesystem::remove(state_file(folder_, requested_.shard), none);
    for (const auto& entry : std::filesystem::directory_iterator(place_, none)) {
      const auto name = entry.path().filename().string();
      if (name.starts_with(fmt::format("{}-", requested_.shard)) && name != sealed)
        std::filesystem::remove(entry.path(), none);
    }
  }

  const Division& study_;
  const Manifest& manifest_;
  std::filesystem::path folder_, place_;
  const ShardRequest& requested_;
  double earlier_;
  Scratch scratch_;
  std::filesystem::path file_;
  std::size_t total_ = 0;
  std::atomic<std::size_t> done_{0};
  Clock::time_point began_ = Clock::now();
};

void note_failure(const std::filesystem::path& folder, const ShardRequest& requested,
                  const std::string& why) {
  auto s = state_of(folder, requested.shard);
  s.state = "failed";
  s.reason = why;
  try {
    write_state(folder, requested.shard, s);
  } catch (const OutputError&) {
    // The shared folder itself fails; the caller reports the reason.
  }
}

}  // namespace

ShardMade make_shard(const Division& study, const std::filesystem::path& folder,
                     const ShardRequest& requested) {
  const auto manifest = read_manifest(folder);
  require_same(manifest, study, folder);
  if (requested.shard < 1 || requested.shard > manifest.shards)
    throw SceneError(fmt::format("--shard {}: must be from 1 to {}", requested.shard, manifest.shards));
  if (const auto there = read_seal(folder, requested.shard);
      there && fault_of(*there, manifest, folder, true).empty())
    return {.seal = *there, .found = true};
  try {
    return Making(study, manifest, folder, requested).make();
  } catch (const Interrupted&) {
    return {.seal = {}, .interrupted = true};
  } catch (const std::exception& e) {
    note_failure(folder, requested, e.what());
    throw;
  }
}

ShardState state_of(const std::filesystem::path& folder, std::size_t shard) {
  const auto file = state_file(folder, shard);
  if (!std::filesystem::exists(file)) return {};
  try {
    return record_of<ShardState>(JsonFile(file).document());
  } catch (const std::exception&) {
    return {};  // another node may be writing it
  }
}

}  // namespace freeplay
