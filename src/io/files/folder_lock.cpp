#include "io/files/folder_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <thread>

#include "io/files/output_file.hpp"

namespace freeplay {
namespace {

constexpr int most_slots = 1024;
constexpr int record_size = 128;

/// Locks belong to the open file, not to the process, so two locks of one process exclude each
/// other too.
struct flock range(int type, int byte) {
  struct flock lock {};
  lock.l_type = static_cast<short>(type);
  lock.l_whence = SEEK_SET;
  lock.l_start = byte;
  lock.l_len = 1;
  return lock;
}

bool try_lock(int descriptor, int type, int byte) {
  auto lock = range(type, byte);
  return fcntl(descriptor, F_OFD_SETLK, &lock) == 0;
}

bool locked_by_another(int descriptor, int byte) {
  auto lock = range(F_WRLCK, byte);
  return fcntl(descriptor, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

std::string record(std::string_view verb) {
  std::array<char, 64> host{};
  gethostname(host.data(), host.size() - 1);
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::array<char, 32> since{};
  std::strftime(since.data(), since.size(), "%Y-%m-%d %H:%M:%S", &local);
  auto text =
      fmt::format("freeplay {}, process {} on {}, since {}", verb, getpid(), host.data(), since.data());
  text.resize(record_size - 1, ' ');
  return text + '\n';
}

/// The description in a slot. It comes from a file, so characters that are not printable are
/// dropped.
std::string read_record(int descriptor, int slot) {
  std::array<char, record_size> bytes{};
  const auto n = pread(descriptor, bytes.data(), bytes.size(), static_cast<off_t>(slot) * record_size);
  std::string text;
  for (ssize_t i = 0; i < n && bytes[static_cast<std::size_t>(i)] != '\n'; ++i) {
    const char c = bytes[static_cast<std::size_t>(i)];
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  text.resize(text.find_last_not_of(' ') + 1);  // npos + 1 = 0
  return text.starts_with("freeplay ") ? text : "a process that has just started";
}

std::string holders(int descriptor, int but) {
  std::string list;
  for (int slot = 1; slot <= most_slots; ++slot)
    if (slot != but && locked_by_another(descriptor, slot))
      list += (list.empty() ? "" : "; ") + read_record(descriptor, slot);
  return list;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder, std::string_view verb, Use use)
    : folder_(folder), file_(folder / ".freeplay.lock"), use_(use) {
  // A process that ends locks the file exclusively for a moment, to remove it. Retry before
  // refusing.
  for (int tries = 0; !acquire(); ++tries) {
    const bool last = tries >= 20;
    auto who = last ? holders(descriptor_, 0) : std::string();
    close(descriptor_);
    descriptor_ = -1;
    if (last)
      throw OutputError(fmt::format(
          "{}: another freeplay process writes to this folder ({}); wait for it, or give another folder "
          "with -o",
          folder.string(), who.empty() ? "a process that has just started" : who));
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  while (!try_lock(descriptor_, F_WRLCK, ++slot_))
    if (slot_ == most_slots)
      refuse(fmt::format("{} processes write to this folder, the maximum", most_slots));
  const auto text = record(verb);  // missing on a full disk; refusals then say less
  (void)!pwrite(descriptor_, text.data(), text.size(), static_cast<off_t>(slot_) * record_size);
}

bool FolderLock::acquire() {
  for (;;) {
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
      refuse(errno == ELOOP ? "is a link; links are not followed"
                            : fmt::format("cannot be written: {}", std::strerror(errno)));
    struct stat found {};
    if (fstat(descriptor_, &found) != 0 || !S_ISREG(found.st_mode) || found.st_nlink > 1)
      refuse("must be a regular file");
    if (!try_lock(descriptor_, use_ == Use::alone ? F_WRLCK : F_RDLCK, 0)) {
      if (errno != EAGAIN && errno != EACCES)
        refuse(fmt::format("cannot be locked: {}", std::strerror(errno)));
      return false;
    }
    // A process that ended may have removed the file between open and lock; such a lock has no
    // effect.
    if (fstat(descriptor_, &found) == 0 && found.st_nlink == 1) return true;
    close(descriptor_);
  }
}

void FolderLock::refuse(const std::string& why) const {
  if (descriptor_ >= 0) close(descriptor_);
  throw OutputError(fmt::format("{}: {}", file_.string(), why));
}

FolderLock::~FolderLock() {
  // The last process removes the file.
  if (try_lock(descriptor_, F_WRLCK, 0)) unlink(file_.c_str());
  close(descriptor_);
}

bool FolderLock::taken(int slot) const { return slot == slot_ || locked_by_another(descriptor_, slot); }

std::string FolderLock::others() const { return holders(descriptor_, slot_); }

}  // namespace freeplay
