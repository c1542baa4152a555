// Reading of files. Every input file is read through these functions. They accept regular files up
// to a size that depends on the kind of file, and refuse a FIFO, device, socket or folder at once.
// Hence no read blocks or is unbounded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/access.hpp"

namespace freeplay {

/// Size limits, bytes. Tables are read line by line; only their lines are limited.
inline constexpr std::uint64_t most_of_a_text = 16u << 20;     ///< a scene or a study
inline constexpr std::uint64_t most_of_a_result = 256u << 20;  ///< JSON results, checkpoints
/// A database, and each file that SQLite keeps beside it.
inline constexpr std::uint64_t most_of_a_database = 64ull << 30;
inline constexpr std::size_t most_of_a_line = 1u << 20;  ///< of a table
inline constexpr int deepest_json = 64;                  ///< greatest nesting of brackets

/// A regular file, open for reading.
struct RegularFile {
  Descriptor descriptor;
  std::uint64_t bytes = 0;  ///< its size when it was opened
};

/// Whether the path of a file may be a symbolic link.
enum class Links { followed, refused };

/// Opens a regular file of at most `most` bytes. Throws SceneError for anything else, without
/// blocking on a FIFO.
RegularFile open_regular(const std::filesystem::path& file, std::uint64_t most,
                         Links links = Links::followed);

/// Reads a whole file of at most `most` bytes. Throws SceneError.
std::string read_file(const std::filesystem::path& file, std::uint64_t most);

/// Reads a table line by line. Lines are returned without their ends. Owns the open file.
class LineReader {
 public:
  /// Throws SceneError if the file does not exist or is not a regular file.
  explicit LineReader(const std::filesystem::path& file);
  ~LineReader();
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;
  /// Reads the next line; false at the end. Throws SceneError for a read error or a line that is
  /// too long.
  bool next(std::string& line);
  /// Number of the last line that next() returned, from 1.
  long number() const { return number_; }

 private:
  bool fill();

  std::string name_;
  Descriptor descriptor_;
  std::vector<char> buffer_;
  std::size_t from_ = 0, to_ = 0;
  long number_ = 0;
};

/// A JSON result file with typed access. A missing key or a value of another type throws SceneError
/// with the path of the key. Owns the parsed document.
class JsonFile {
 public:
  /// Throws SceneError if the file cannot be read or is not JSON.
  explicit JsonFile(const std::filesystem::path& file);
  ~JsonFile();
  JsonFile(JsonFile&&) noexcept;
  /// The value at `path`: keys, or indices of a list from 0, separated by dots. Throws SceneError.
  double number(std::string_view path) const;
  std::string text(std::string_view path) const;
  std::vector<std::string> texts(std::string_view path) const;
  /// The text at `path`, or "" if there is no text.
  std::string text_or_empty(std::string_view path) const;
  /// The value at `path`, or null if there is none.
  const nlohmann::json* find(std::string_view path) const;
  const nlohmann::json& document() const { return *document_; }
  /// Throws SceneError about `path`; `must` states what was expected.
  [[noreturn]] void fail(std::string_view path, const char* must) const;

 private:
  std::string name_;
  std::unique_ptr<nlohmann::json> document_;
};

}  // namespace freeplay
