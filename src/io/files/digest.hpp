// Hash of texts and files by FNV-1a: h ← (h ⊕ byte)·p for each byte (Fowler, Noll and Vo;
// draft-eastlake-fnv). It detects accidental differences; it is not secure against deliberate
// collisions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace freeplay {

/// 64-bit hash, to detect damaged files.
constexpr std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

/// 128-bit hash as 32 hexadecimal digits, which identifies a text.
std::string digest(std::string_view text);

}  // namespace freeplay
