// Ownership of a file descriptor, and opening of folders without following symbolic links.
#pragma once

#include <filesystem>
#include <utility>

namespace freeplay {

/// Owns a file descriptor and closes it on destruction. Movable.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor();
  int number() const { return number_; }
  explicit operator bool() const { return number_ >= 0; }
  int release() { return std::exchange(number_, -1); }

 private:
  int number_ = -1;
};

/// Opens a folder component by component, from the root. No component may be a symbolic link.
/// `make`: creates missing components. Throws OutputError. The descriptor serves as the base of
/// *at() calls only.
Descriptor open_folder(const std::filesystem::path& folder, bool make = false);

}  // namespace freeplay
