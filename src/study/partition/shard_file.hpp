// Whole files on shared folders: written beside their place, brought to the disk, renamed. No locks: those of network file systems
// cannot be counted on, and a name that is there is whole.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace freeplay {

/// A checksum of 64 bits over blocks of a megabyte, as 16 hexadecimal digits. Throws SceneError of anything but a regular file of at
/// most most_of_a_database (io/files/input_file.hpp).
std::string file_checksum(const std::filesystem::path& file);

/// Writes a file whole: written, on the disk, renamed. Throws OutputError.
void write_whole(const std::filesystem::path& file, std::string_view text);
/// Copies a regular file of at most most_of_a_database likewise, to a place on another file system. Throws SceneError for anything
/// else, OutputError where the place has no room for it.
void copy_whole(const std::filesystem::path& from, const std::filesystem::path& to);

/// A copy of a database that somebody may be writing, in one file and as of one instant. Throws OutputError.
void copy_database(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace freeplay
