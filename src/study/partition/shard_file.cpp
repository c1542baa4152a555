#include "study/partition/shard_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <vector>

#include "io/files/digest.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"
#include "study/store/database.hpp"

namespace freeplay {
namespace {

constexpr std::size_t block = 1 << 20;

[[noreturn]] void fail(const std::filesystem::path& file, const char* what) {
  throw OutputError(fmt::format("{}: cannot be {}: {}", file.string(), what, std::strerror(errno)));
}

/// A file that is written under a temporary name in its folder.
class Growing {
 public:
  explicit Growing(const std::filesystem::path& place) : place_(place) {
    name_ = place.parent_path() / fmt::format(".{}.XXXXXX", place.filename().string());
    descriptor_ = mkostemp(name_.data(), O_CLOEXEC);
    if (descriptor_ < 0) fail(place_, "made");
    fchmod(descriptor_, 0644);
  }
  ~Growing() {
    if (descriptor_ >= 0) close(descriptor_);
    if (!done_) unlink(name_.c_str());
  }
  Growing(const Growing&) = delete;
  Growing& operator=(const Growing&) = delete;
  void write(std::string_view text) {
    while (!text.empty()) {
      const auto n = ::write(descriptor_, text.data(), text.size());
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) fail(place_, "written");
      text.remove_prefix(static_cast<std::size_t>(n));
    }
  }
  void commit() {
    if (fsync(descriptor_) != 0) fail(place_, "brought to the disk");
    const int closed = close(descriptor_);  // NFS reports failed writes here
    descriptor_ = -1;
    if (closed != 0) fail(place_, "written");
    if (rename(name_.c_str(), place_.c_str()) != 0) fail(place_, "put in its place");
    done_ = true;
    // Flush the folder too, where supported, so that the name survives a power failure.
    if (const int folder = open(place_.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        folder >= 0) {
      fsync(folder);
      close(folder);
    }
  }

 private:
  std::filesystem::path place_;
  std::string name_;
  int descriptor_ = -1;
  bool done_ = false;
};

/// Reads a regular file block by block. Links, FIFOs and devices were refused, since reading could
/// block.
template <class F>
void each_block(const RegularFile& from, const std::filesystem::path& file, F&& use) {
  std::vector<char> buffer(block);
  for (std::size_t used = 0;;) {
    const auto n = read(from.descriptor.number(), buffer.data() + used, buffer.size() - used);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(file, "read");
    used += static_cast<std::size_t>(n);
    if (used == buffer.size() || (n == 0 && used > 0)) {
      use(std::string_view(buffer.data(), used));
      used = 0;
    }
    if (n == 0) return;
  }
}

RegularFile open_block_file(const std::filesystem::path& file) {
  return open_regular(file, most_of_a_database, Links::refused);
}

}  // namespace

std::string file_checksum(const std::filesystem::path& file) {
  std::string sums;
  each_block(open_block_file(file), file,
             [&](std::string_view bytes) { sums += fmt::format("{:016x}", checksum(bytes)); });
  return fmt::format("{:016x}", checksum(sums));
}

void write_whole(const std::filesystem::path& file, std::string_view text) {
  Growing out(file);
  out.write(text);
  out.commit();
}

void copy_whole(const std::filesystem::path& from, const std::filesystem::path& to) {
  const auto source = open_block_file(from);
  std::error_code none;
  const auto room = std::filesystem::space(to.parent_path(), none);
  if (!none && room.available < source.bytes)
    throw OutputError(fmt::format("{}: has {} MB of free space, but {} has {} MB", to.parent_path().string(),
                                  room.available / 1'000'000, from.string(), source.bytes / 1'000'000));
  Growing out(to);
  each_block(source, from, [&](std::string_view bytes) { out.write(bytes); });
  out.commit();
}

void copy_database(const std::filesystem::path& from, const std::filesystem::path& to) {
  Database(from, Database::Access::read).copy_to(to);
}

}  // namespace freeplay
