// A file that is written whole or not at all: it grows beside its place as NAME.partial and is renamed when
// it is complete. A file that is never committed leaves nothing behind.
//
// Nothing is written through a symbolic link, whoever planted it: the folder of a file is opened from its first
// component on and none of them may be a link; a link in the place of the file itself is replaced, not followed. The
// folder that the user names may be reached by links: real_folder() follows them, once, before anything is written.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/descriptor.hpp"

namespace freeplay {

/// The disk refused: what() names the file and the reason.
struct OutputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Where a folder that the user names really is, links on the way to it followed; it need not exist. Below the working
/// folder it is told from there.
std::filesystem::path real_folder(const std::filesystem::path& named);

/// Makes a folder and its parents, none of which may be a symbolic link, or throws OutputError.
void make_folder(const std::filesystem::path& folder);

/// Removes a file (a link, not what it points at), where there is one.
void remove_file(const std::filesystem::path& path);

/// Throws OutputError unless there is nothing of that name, or a regular file that has no other name: what a library that
/// opens files by itself may write.
void require_own(const std::filesystem::path& path);

/// Moves a finished file into another folder, in the place of one of that name.
void move_file(const std::filesystem::path& from, const std::filesystem::path& to, const std::string& name);

class OutputFile {
 public:
  /// A new file; `resumed`: go_on_at() follows, and what stands there is left alone until then.
  explicit OutputFile(const std::filesystem::path& path, bool resumed = false);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  /// Appends one number in the shortest form that reads back the same. No allocation. What is not finite is no number:
  /// OutputError, and the file is not completed.
  void number(double x);
  /// Hands all that was written to the operating system; returns how much that is.
  std::uint64_t settle();
  /// Whether go_on_at() can be: throws OutputError when there is no file of an interrupted run, finished or
  /// not, of at least `size` bytes. Touches nothing.
  void require(std::uint64_t size) const;
  /// Goes on with such a file at its first `size` bytes.
  void go_on_at(std::uint64_t size);
  /// From now on, what is not committed stays beside its place: somebody knows how to go on with it.
  void keep() { keep_ = true; }
  /// Completes the file and puts it in its place.
  void commit();
  const std::filesystem::path& path() const { return path_; }

 private:
  void flush();
  void open_partial(int flags);
  [[noreturn]] void fail(const char* what) const;
  [[noreturn]] void refuse(double x);

  std::filesystem::path path_;
  Descriptor folder_;
  std::string name_, partial_;  // in the folder
  std::FILE* file_ = nullptr;
  std::vector<char> buffer_;
  std::size_t used_ = 0;
  std::uint64_t written_ = 0;  // to the file
  bool keep_ = false;
};

/// Writes a small file in one go.
void write_file(const std::filesystem::path& path, std::string_view text);

}  // namespace freeplay
