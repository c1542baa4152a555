// FNV-1a: h ← (h ⊕ byte)·p for each byte (Fowler, Noll, Vo; draft-eastlake-fnv). It tells texts and files
// apart that differ by accident; it is no defence against one who wants two to be equal.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace freeplay {

/// 64 bits, for the damage of a file.
constexpr std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

/// 128 bits as 32 hexadecimal digits, for a name that stands for a text.
std::string digest(std::string_view text);

}  // namespace freeplay
