// Binary files with a kind, a version and a checksum, for snapshots and checkpoints. A file that
// differs from what was written is refused.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace freeplay {

/// Writes a file atomically. Its first line contains `kind` and `version`.
void write_sealed(const std::filesystem::path& file, const std::string& kind, int version,
                  const std::vector<std::byte>& bytes);

/// Reads a file. Throws SnapshotError for another kind or version, or damage.
std::vector<std::byte> read_sealed(const std::filesystem::path& file, const std::string& kind, int version);

}  // namespace freeplay
