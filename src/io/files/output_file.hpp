// Output files that appear complete or not at all. A file is written as NAME.partial in its folder
// and renamed when it is complete. A file that is not committed is removed, unless a checkpoint
// refers to it (keep()).
//
// No file is written through a symbolic link: the folder is opened component by component, none of
// which may be a link, and a link at the place of the file is replaced, not followed. The folder
// that the user names may contain links: real_folder() resolves them once before any output.
//
// Use: construct, write(), number(), then commit(). An OutputFile owns the open file and its
// buffer.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/access.hpp"

namespace freeplay {

/// A failed output; what() names the file and the reason.
struct OutputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Resolves the symbolic links in the path of a folder, which need not exist. A folder below the
/// working folder is returned relative to it.
std::filesystem::path real_folder(const std::filesystem::path& named);

/// A part of a file name for any text: of bounded length, of letters, digits, _, - and . only; different texts
/// have different names.
std::string safe_name(std::string_view of);

/// Creates a folder and its parents. Throws OutputError if that fails or a component is a symbolic
/// link.
void make_folder(const std::filesystem::path& folder);

/// Removes a file if it exists; of a symbolic link, the link itself.
void remove_file(const std::filesystem::path& path);

/// Throws OutputError unless the name is free or belongs to a regular file with a single link.
/// Required before a library that opens files by itself writes there.
void require_own(const std::filesystem::path& path);

/// Moves a complete file into another folder, where it replaces a file of that name.
void move_file(const std::filesystem::path& from, const std::filesystem::path& to, const std::string& name);

/// A file that is being written.
class OutputFile {
 public:
  /// Creates the partial file. `resumed`: go_on_at() follows, and an existing file is kept until
  /// then.
  explicit OutputFile(const std::filesystem::path& path, bool resumed = false);
  /// For a file that several processes may write at the same time, also on a network file system. Each uses a
  /// partial name of its own, which begins with a dot, and the file is on the disk before it is renamed.
  struct Shared {};
  OutputFile(const std::filesystem::path& path, Shared);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  /// Appends one number in the shortest form that reads back the same. Does not allocate. Throws
  /// OutputError for a number that is not finite; the file is then never completed.
  void number(double x);
  /// Flushes all output to the operating system; returns the size of the file, bytes.
  std::uint64_t settle();
  /// Throws OutputError unless go_on_at(size) is possible: the file of an interrupted run exists,
  /// complete or partial, with at least `size` bytes. Changes nothing.
  void require(std::uint64_t size) const;
  /// Continues such a file after its first `size` bytes.
  void go_on_at(std::uint64_t size);
  /// Keeps the partial file if it is not committed, because a checkpoint refers to it.
  void keep() { keep_ = true; }
  /// Completes the file and renames it to its final name.
  void commit();
  const std::filesystem::path& path() const { return path_; }

 private:
  void flush();
  void open_partial(int flags);
  [[noreturn]] void fail(const char* what) const;
  [[noreturn]] void refuse(double x);

  std::filesystem::path path_;
  Descriptor folder_;
  std::string name_, partial_;  // names in the folder
  std::FILE* file_ = nullptr;
  std::vector<char> buffer_;
  std::size_t used_ = 0;
  std::uint64_t written_ = 0;  // bytes written to the file
  bool keep_ = false, shared_ = false;
};

/// Writes a small file at once. `how`: nothing, or OutputFile::Shared.
template <class... How>
void write_file(const std::filesystem::path& path, std::string_view text, How... how) {
  OutputFile file(path, how...);
  file.write(text);
  file.commit();
}

}  // namespace freeplay
