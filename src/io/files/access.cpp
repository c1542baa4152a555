#include "io/files/access.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "io/files/output_file.hpp"

namespace freeplay {

bool lies_below(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::error_code error;
  const auto inner = std::filesystem::weakly_canonical(file, error);
  const auto outer = std::filesystem::canonical(folder.empty() ? "." : folder, error);
  if (error) return false;
  const auto whole = std::filesystem::absolute(inner);
  return std::ranges::mismatch(outer, whole).in1 == outer.end();
}

Descriptor::~Descriptor() {
  if (number_ >= 0) close(number_);
}

Descriptor open_folder(const std::filesystem::path& folder, bool make) {
  constexpr int flags = O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;
  Descriptor at(open(folder.is_absolute() ? "/" : ".", flags));
  std::filesystem::path so_far;
  const auto fail = [&] {
    const int reason = errno;
    struct stat about {};
    const bool link = reason == ENOTDIR &&
                      fstatat(at.number(), so_far.filename().c_str(), &about, AT_SYMLINK_NOFOLLOW) == 0 &&
                      S_ISLNK(about.st_mode);
    throw OutputError(
        link ? fmt::format(
                   "{}: is a symbolic link, and results are not written through links; remove it, or give "
                   "its target with -o",
                   so_far.string())
             : fmt::format("{}: {}: {}", so_far.string(),
                           make ? "cannot make this folder" : "cannot be opened",
                           reason == ENOTDIR ? "a file of that name exists" : std::strerror(reason)));
  };
  if (!at) fail();
  for (const auto& part : folder) {
    so_far /= part;
    if (part.empty() || part == "/" || part == ".") continue;
    Descriptor next(openat(at.number(), part.c_str(), flags));
    if (!next && errno == ENOENT && make) {
      // Another process may create it at the same time.
      if (mkdirat(at.number(), part.c_str(), 0777) != 0 && errno != EEXIST) fail();
      next = Descriptor(openat(at.number(), part.c_str(), flags));
    }
    if (!next) fail();
    at = std::move(next);
  }
  return at;
}

}  // namespace freeplay
