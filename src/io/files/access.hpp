// Access to files: which ones a scene or study may name, and folders opened without following links. A file
// of unknown origin must not make this program read arbitrary files, so by default only files in its folder
// or below may be named.
#pragma once

#include <filesystem>
#include <utility>

namespace freeplay {

/// The files that may be named.
enum class Reach {
  beside,   ///< in the folder of the naming file or below; links are resolved first
  anywhere  ///< all files, for callers that trust the naming file
};

/// Whether `file` lies in `folder` or below, after resolving links of both.
bool lies_below(const std::filesystem::path& file, const std::filesystem::path& folder);

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
