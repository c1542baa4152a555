#include "io/files/output_file.hpp"

#include <fcntl.h>
#include <fmt/compile.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <random>
#include <system_error>

#include "io/files/digest.hpp"

namespace freeplay {
namespace {

/// Size of a regular file with a single link; a file with more links may belong to another folder.
/// −1 if there is none.
std::int64_t own_size(int folder, const std::string& name) {
  struct stat about {};
  if (fstatat(folder, name.c_str(), &about, AT_SYMLINK_NOFOLLOW) != 0) return -1;
  return S_ISREG(about.st_mode) && about.st_nlink == 1 ? about.st_size : -1;
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

}  // namespace

std::string safe_name(std::string_view of) {
  constexpr std::size_t longest = 60;
  std::string name(of.substr(0, longest));
  for (char& c : name)
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
          c == '-' || c == '.'))
      c = '_';
  if (name != of) name += fmt::format("_{:016x}", checksum(of));
  return name;
}

std::filesystem::path real_folder(const std::filesystem::path& named) {
  std::error_code error;
  const auto real = std::filesystem::weakly_canonical(named, error);
  if (error) throw OutputError(fmt::format("{}: cannot be reached: {}", named.string(), error.message()));
  if (named.is_absolute()) return real;
  const auto from_here = std::filesystem::proximate(real, error);
  return error || *from_here.begin() == ".." ? real : from_here;
}

void make_folder(const std::filesystem::path& folder) { open_folder(folder, true); }

void remove_file(const std::filesystem::path& path) {
  const auto folder = open_folder(folder_of(path));
  if (unlinkat(folder.number(), path.filename().c_str(), 0) != 0 && errno != ENOENT)
    throw OutputError(fmt::format("{}: cannot be removed: {}", path.string(), std::strerror(errno)));
}

void require_own(const std::filesystem::path& path) {
  const auto folder = open_folder(folder_of(path));
  struct stat about {};
  if (fstatat(folder.number(), path.filename().c_str(), &about, AT_SYMLINK_NOFOLLOW) != 0) return;
  if (!S_ISREG(about.st_mode) || about.st_nlink != 1)
    throw OutputError(fmt::format("{}: is {}; remove it, or give another folder with -o", path.string(),
                                  S_ISREG(about.st_mode)   ? "a file with a hard link elsewhere"
                                  : S_ISLNK(about.st_mode) ? "a symbolic link"
                                                           : "no file"));
}

void move_file(const std::filesystem::path& from, const std::filesystem::path& to, const std::string& name) {
  const auto old_place = open_folder(from), place = open_folder(to);
  if (renameat(old_place.number(), name.c_str(), place.number(), name.c_str()) != 0)
    throw OutputError(fmt::format("{}: cannot be completed: {}", (to / name).string(), std::strerror(errno)));
}

OutputFile::OutputFile(const std::filesystem::path& path, bool resumed)
    : path_(path),
      folder_(open_folder(folder_of(path))),
      name_(path.filename().string()),
      partial_(name_ + ".partial"),
      buffer_(1 << 16) {
  if (resumed) return;
  // Remove a leftover of any type; the new file must not be an existing one.
  if (unlinkat(folder_.number(), partial_.c_str(), 0) != 0 && errno != ENOENT) fail("cannot be written");
  open_partial(O_CREAT | O_EXCL);
}

OutputFile::OutputFile(const std::filesystem::path& path, Shared) : OutputFile(path, true) {
  shared_ = true;
  partial_ = fmt::format(".{}.{:08x}", name_, std::random_device()());
  open_partial(O_CREAT | O_EXCL);
}

void OutputFile::open_partial(int flags) {
  Descriptor file(openat(folder_.number(), partial_.c_str(),
                         O_WRONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK | flags, 0666));
  file_ = file ? fdopen(file.number(), flags & O_APPEND ? "ab" : "wb") : nullptr;
  if (!file_) fail(flags & O_APPEND ? "cannot be continued" : "cannot be written");
  file.release();
  std::setvbuf(file_, nullptr, _IONBF, 0);  // this class has its own buffer
}

OutputFile::~OutputFile() {
  if (!file_) return;
  std::fclose(file_);
  if (!keep_) unlinkat(folder_.number(), partial_.c_str(), 0);
}

void OutputFile::fail(const char* what) const {
  throw OutputError(fmt::format("{}: {}: {}", path_.string(), what, std::strerror(errno)));
}

/// A number that is not finite is an error of the program, so the message gives its position.
void OutputFile::refuse(double x) {
  std::string_view row(buffer_.data(), used_);
  row.remove_prefix(row.rfind('\n') + 1);  // npos + 1 = 0
  throw OutputError(fmt::format("{}: cannot store {}: in the row that begins with \"{}\", after {} numbers",
                                path_.string(), x, row.substr(0, row.find(',')),
                                std::ranges::count(row, ',')));
}

void OutputFile::flush() {
  if (used_ == 0) return;
  if (std::fwrite(buffer_.data(), 1, used_, file_) != used_) fail("cannot be written");
  written_ += used_;
  used_ = 0;
}

std::uint64_t OutputFile::settle() {
  flush();
  return written_;
}

void OutputFile::require(std::uint64_t size) const {
  auto found = own_size(folder_.number(), partial_);
  if (found < 0) found = own_size(folder_.number(), name_);
  if (found < 0 || static_cast<std::uint64_t>(found) < size)
    throw OutputError(fmt::format("{}: cannot be continued: it has {} of its first {} bytes", path_.string(),
                                  std::max<std::int64_t>(found, 0), size));
}

void OutputFile::go_on_at(std::uint64_t size) {
  require(size);
  keep();
  // An interrupted run has renamed its files to their final names; a killed run has left partial
  // files.
  const int at = folder_.number();
  if (own_size(at, partial_) < 0 && renameat(at, name_.c_str(), at, partial_.c_str()) != 0)
    fail("cannot be continued");
  open_partial(O_APPEND);
  if (ftruncate(fileno(file_), static_cast<off_t>(size)) != 0) fail("cannot be continued");
  written_ = size;
}

void OutputFile::write(std::string_view text) {
  if (text.size() > buffer_.size() - used_) flush();
  if (text.size() > buffer_.size()) {
    if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail("cannot be written");
    written_ += text.size();
    return;
  }
  // std::ranges::copy, because memcpy does not allow the null pointer of an empty text.
  std::ranges::copy(text, buffer_.begin() + static_cast<std::ptrdiff_t>(used_));
  used_ += text.size();
}

void OutputFile::number(double x) {
  if (!std::isfinite(x)) refuse(x);
  if (buffer_.size() - used_ < 32) flush();
  const auto end = fmt::format_to(buffer_.data() + used_, FMT_COMPILE("{}"), x + 0.0);  // −0 as 0
  used_ = static_cast<std::size_t>(end - buffer_.data());
}

void OutputFile::commit() {
  flush();
  std::FILE* file = file_;
  file_ = nullptr;
  const int at = folder_.number();
  const bool stored = !shared_ || fsync(fileno(file)) == 0;
  // A network file system may report failed writes when the file is closed.
  if (std::fclose(file) == 0 && stored && renameat(at, partial_.c_str(), at, name_.c_str()) == 0) {
    // Where it is supported, this stores the name of the file.
    if (const Descriptor folder(shared_ ? openat(at, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1); folder)
      fsync(folder.number());
    return;
  }
  const int reason = errno;
  if (!keep_) unlinkat(at, partial_.c_str(), 0);
  errno = reason;
  fail("cannot be completed");
}

}  // namespace freeplay
