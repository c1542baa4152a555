// Bytes in a file with a name, a version and a checksum: what is read is what was written, or refused.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace freeplay {

/// Writes the file whole or not at all; `kind` and `version` stand in its first line.
void write_sealed(const std::filesystem::path& file, const std::string& kind, int version,
                  const std::vector<std::byte>& bytes);

/// Throws SnapshotError for another kind, another version, or damage.
std::vector<std::byte> read_sealed(const std::filesystem::path& file, const std::string& kind, int version);

}  // namespace freeplay
