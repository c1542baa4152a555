#include "study/partition/shard_file.hpp"

#include <fmt/format.h>
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

/// Reads a regular file block by block. Links, FIFOs and devices were refused, since reading could
/// block.
template <class F>
void each_block(const RegularFile& from, const std::filesystem::path& file, F&& use) {
  std::vector<char> buffer(block);
  for (std::size_t used = 0;;) {
    const auto n = read(from.descriptor.number(), buffer.data() + used, buffer.size() - used);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw OutputError(fmt::format("{}: cannot be read: {}", file.string(), std::strerror(errno)));
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
  OutputFile out(file, OutputFile::Shared());
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
  OutputFile out(to, OutputFile::Shared());
  each_block(source, from, [&](std::string_view bytes) { out.write(bytes); });
  out.commit();
}

void copy_database(const std::filesystem::path& from, const std::filesystem::path& to) {
  Database(from, Database::Access::read).copy_to(to);
}

}  // namespace freeplay
