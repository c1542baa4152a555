#include "study/store/scratch.hpp"

#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "io/files/output_file.hpp"

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

}  // namespace freeplay
