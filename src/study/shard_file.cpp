#include "study/shard_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

#include "io/digest.hpp"
#include "io/output_file.hpp"

namespace freeplay {
namespace {

constexpr std::size_t block = 1 << 20;

[[noreturn]] void fail(const std::filesystem::path& file, const char* what) {
  throw OutputError(fmt::format("{}: cannot be {}: {}", file.string(), what, std::strerror(errno)));
}

/// A file that grows beside its place under a name of this process' own.
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
    const int closed = close(descriptor_);  // NFS tells here what it could not write
    descriptor_ = -1;
    if (closed != 0) fail(place_, "written");
    if (rename(name_.c_str(), place_.c_str()) != 0) fail(place_, "put in its place");
    done_ = true;
    // Of the folder, where that can be asked for: the name survives a loss of power.
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

class Checksum {
 public:
  void add(std::string_view bytes) { sums_ += fmt::format("{:016x}", checksum(bytes)); }
  std::string text() const { return fmt::format("{:016x}", checksum(sums_)); }

 private:
  std::string sums_;
};

template <class F>
void each_block(const std::filesystem::path& file, F&& use) {
  std::ifstream in(file, std::ios::binary);
  if (!in) fail(file, "read");
  std::vector<char> buffer(block);
  while (in) {
    in.read(buffer.data(), static_cast<std::streamsize>(block));
    if (in.gcount() > 0) use(std::string_view(buffer.data(), static_cast<std::size_t>(in.gcount())));
  }
  if (in.bad()) fail(file, "read");
}

}  // namespace

std::string file_checksum(const std::filesystem::path& file) {
  Checksum sum;
  each_block(file, [&](std::string_view bytes) { sum.add(bytes); });
  return sum.text();
}

std::string text_checksum(std::string_view text) {
  Checksum sum;
  for (; !text.empty(); text.remove_prefix(std::min(block, text.size()))) sum.add(text.substr(0, block));
  return sum.text();
}

void write_whole(const std::filesystem::path& file, std::string_view text) {
  Growing out(file);
  out.write(text);
  out.commit();
}

void copy_whole(const std::filesystem::path& from, const std::filesystem::path& to) {
  Growing out(to);
  each_block(from, [&](std::string_view bytes) { out.write(bytes); });
  out.commit();
}

void copy_database(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::filesystem::remove(to);
  sqlite3* db = nullptr;
  std::string error;
  if (sqlite3_open_v2(from.c_str(), &db, SQLITE_OPEN_READWRITE, nullptr) != SQLITE_OK)
    error = "cannot be opened";
  if (error.empty()) {
    sqlite3_busy_timeout(db, 60000);
    sqlite3_stmt* s = nullptr;
    if (sqlite3_prepare_v2(db, "VACUUM INTO ?", -1, &s, nullptr) != SQLITE_OK ||
        sqlite3_bind_text(s, 1, to.c_str(), -1, SQLITE_TRANSIENT) != SQLITE_OK ||
        sqlite3_step(s) != SQLITE_DONE)
      error = sqlite3_errmsg(db);
    sqlite3_finalize(s);
  }
  sqlite3_close(db);
  if (!error.empty())
    throw OutputError(fmt::format("{}: cannot be copied to {}: {}", from.string(), to.string(), error));
}

bool has_shards(const std::filesystem::path& folder) {
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    const auto name = entry.path().filename().string();
    if (!name.empty() && name.front() >= '1' && name.front() <= '9') return true;
  }
  return false;
}

}  // namespace freeplay
