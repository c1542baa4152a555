// Atomic files on shared folders: written under a temporary name, flushed to the disk, then
// renamed. Locks are not used, because network file systems do not provide them reliably; an
// existing file is complete.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace freeplay {

/// 64-bit checksum over blocks of one megabyte, as 16 hexadecimal digits. Throws SceneError unless
/// the file is a regular file of at most most_of_a_database (io/files/input_file.hpp).
std::string file_checksum(const std::filesystem::path& file);

/// Writes a file atomically. Throws OutputError.
void write_whole(const std::filesystem::path& file, std::string_view text);
/// Copies a regular file of at most most_of_a_database atomically, possibly to another file system.
/// Throws SceneError for any other file, and OutputError if there is not enough space.
void copy_whole(const std::filesystem::path& from, const std::filesystem::path& to);

/// Copies a database that another process may be writing, as of one instant, into one file. Throws
/// OutputError.
void copy_database(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace freeplay
