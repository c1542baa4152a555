// Serialisation of the state of a run into a flat list of bytes. Every class with state has one
// function
//
//     template <class M> void serialize(M& m) { m(t_, x_, ...); }
//
// which both the writer and the reader call, so that the two formats cannot differ. The bytes are
// in the machine's representation: a snapshot is valid only on the kind of machine that made it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace freeplay {

/// The bytes are truncated or belong to other data; what() says which.
struct MemoryError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Appends its arguments to `bytes`.
class MemoryWriter {
 public:
  /// distinguishes writer and reader in serialize()
  static constexpr bool reading = false;
  /// Appends to `bytes`, which the caller owns.
  explicit MemoryWriter(std::vector<std::byte>& bytes) : bytes_(bytes) {}
  /// Writes or reads the values in their order.
  template <class... T>
  void operator()(T&... values) {
    (put(values), ...);
  }
  /// Marks the beginning of a named part; the reader checks the name.
  void part(std::string_view name) {
    std::string text(name);
    put(text);
  }
  /// Writes or reads `size` bytes.
  void raw(void* data, std::size_t size) {
    const auto* from = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), from, from + size);
  }

 private:
  template <class T>
  void put(T& value);
  std::vector<std::byte>& bytes_;
};

/// Fills its arguments from `bytes`; throws MemoryError if they do not match.
class MemoryReader {
 public:
  /// distinguishes writer and reader in serialize()
  static constexpr bool reading = true;
  /// Reads `bytes`, which the caller owns.
  explicit MemoryReader(std::span<const std::byte> bytes) : rest_(bytes) {}
  /// Writes or reads the values in their order.
  template <class... T>
  void operator()(T&... values) {
    (put(values), ...);
  }
  /// Reads the beginning of a named part; throws MemoryError if the name differs.
  void part(std::string_view name) {
    std::string found;
    put(found);
    if (found != name)
      throw MemoryError("the snapshot has no part \"" + std::string(name) + "\" where one is expected");
  }
  /// Writes or reads `size` bytes.
  void raw(void* data, std::size_t size) {
    if (size > rest_.size()) throw MemoryError("the snapshot is incomplete");
    if (size > 0) std::memcpy(data, rest_.data(), size);
    rest_ = rest_.subspan(size);
  }
  /// Whether all bytes have been read.
  bool at_end() const { return rest_.empty(); }
  /// Number of bytes left.
  std::size_t left() const { return rest_.size(); }

 private:
  template <class T>
  void put(T& value);
  std::span<const std::byte> rest_;
};

namespace memory {

template <class T>
struct IsArray : std::false_type {};
template <class T, std::size_t N>
struct IsArray<std::array<T, N>> : std::true_type {};
template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};
template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

/// Scalars byte by byte, containers by length and elements, classes by their serialize().
template <class M, class T>
void through(M& m, T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    unsigned char byte = value;
    m(byte);
    if (byte > 1) throw MemoryError("the snapshot is damaged: a yes or no is neither");
    value = byte;
  } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    m.raw(&value, sizeof value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    std::uint64_t size = value.size();
    m(size);
    if constexpr (M::reading) {
      if (size > m.left()) throw MemoryError("the snapshot is incomplete");
      value.resize(size);
    }
    m.raw(value.data(), size);
  } else if constexpr (IsArray<T>::value) {
    for (auto& x : value) m(x);
  } else if constexpr (IsVector<T>::value) {
    std::uint64_t size = value.size();
    m(size);
    if constexpr (M::reading) {
      // every element has a byte
      if (size > m.left()) throw MemoryError("the snapshot is incomplete");
      value.resize(size);
    }
    if constexpr ((std::is_arithmetic_v<typename T::value_type> &&
                   !std::is_same_v<typename T::value_type, bool>) ||
                  std::is_same_v<typename T::value_type, std::byte>)
      m.raw(value.data(), size * sizeof(typename T::value_type));
    else
      for (auto& x : value) m(x);
  } else if constexpr (IsOptional<T>::value) {
    bool has = value.has_value();
    m(has);
    if constexpr (M::reading) {
      if (has)
        value.emplace();
      else
        value.reset();
    }
    if (has) m(*value);
  } else {
    value.serialize(m);
  }
}

}  // namespace memory

template <class T>
void MemoryWriter::put(T& value) {
  memory::through(*this, value);
}
template <class T>
void MemoryReader::put(T& value) {
  memory::through(*this, value);
}

}  // namespace freeplay
