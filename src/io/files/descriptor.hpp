// A descriptor of the operating system that is closed with the object, and folders opened so that no symbolic link is
// followed.
#pragma once

#include <filesystem>
#include <utility>

namespace freeplay {

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

/// Opens a folder from its first component to its last, none of which may be a symbolic link; `make`: those that are
/// missing are made. Throws OutputError. The descriptor is good for *at() calls only.
Descriptor open_folder(const std::filesystem::path& folder, bool make = false);

}  // namespace freeplay
