// Requirements of every target on exceptions of a reader: each has a message in this program's
// words, not a library's.
#pragma once

#include <unistd.h>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "io/files/escaping.hpp"

namespace freeplay::fuzz {

/// Ends the target on an unsuitable message. It may quote the input. Control characters are escaped
/// where messages are printed.
inline void assess(const std::exception& e, std::string_view input) {
  const std::string what = e.what();
  bool foreign = what.empty();
  for (const char* word : {"std::", "json.exception", "basic_string", "vector::", "_M_", "toml::"})
    foreign = foreign || (what.find(word) != what.npos && input.find(word) == input.npos &&
                          visible(input).find(word) == input.npos);
  if (!foreign) return;
  std::fprintf(stderr, "a message that is none: %s\n", what.c_str());
  std::abort();
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// A file of these bytes, for readers that take a path; in memory if possible.
inline std::filesystem::path file_of(const std::uint8_t* data, std::size_t size, const char* name) {
  static const auto folder = [] {
    const std::filesystem::path memory = "/dev/shm";
    const auto at = (std::filesystem::exists(memory) ? memory : std::filesystem::temp_directory_path()) /
                    ("freeplay-fuzz-" + std::to_string(::getpid()));
    std::filesystem::create_directories(at);
    std::atexit([] {
      std::error_code ignored;
      for (const auto* base : {"/dev/shm", "/tmp"})
        std::filesystem::remove_all(
            std::filesystem::path(base) / ("freeplay-fuzz-" + std::to_string(::getpid())), ignored);
    });
    return at;
  }();
  const auto file = folder / name;
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return file;
}

}  // namespace freeplay::fuzz
