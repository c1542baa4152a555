// The one way in which a file is read: a regular file, of a size that its kind can have. A FIFO, a device, a socket or a
// folder is refused at once: nothing waits for a writer, nothing reads without end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/descriptor.hpp"

namespace freeplay {

/// Greatest sizes (bytes). Tables are read line by line and have none but that of a line.
inline constexpr std::uint64_t most_of_a_text = 16u << 20;  ///< a scene or a study
inline constexpr std::uint64_t most_of_a_result = 256u
                                                  << 20;  ///< run.json and its like, a snapshot, a checkpoint
inline constexpr std::uint64_t most_of_a_database = 64ull << 30;  ///< and of each of SQLite's files beside it
inline constexpr std::size_t most_of_a_line = 1u << 20;           ///< of a table
inline constexpr int deepest_json = 64;                           ///< brackets within brackets

/// A regular file, open for reading.
struct RegularFile {
  Descriptor descriptor;
  std::uint64_t bytes = 0;  ///< its size when it was opened
};

/// Whether the name of a file may be a symbolic link.
enum class Links { followed, refused };

/// Opens a regular file of at most `most` bytes. Throws SceneError for anything else, without waiting for a writer.
RegularFile open_regular(const std::filesystem::path& file, std::uint64_t most,
                         Links links = Links::followed);

/// The whole of a file of at most `most` bytes. Throws SceneError.
std::string read_file(const std::filesystem::path& file, std::uint64_t most);

/// The lines of a table, one at a time, without their ends.
class LineReader {
 public:
  /// Throws SceneError when there is no such file or it is none to read.
  explicit LineReader(const std::filesystem::path& file);
  ~LineReader();
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;
  /// False at the end. Throws SceneError when it cannot be read or a line is too long.
  bool next(std::string& line);
  /// Of the line that next() gave last, from 1.
  long number() const { return number_; }

 private:
  bool fill();

  std::string name_;
  Descriptor descriptor_;
  std::vector<char> buffer_;
  std::size_t from_ = 0, to_ = 0;
  long number_ = 0;
};

/// A result file in JSON, with typed access: a key that is missing or of another kind is an error that names it.
class JsonFile {
 public:
  /// Throws SceneError for what cannot be read or is no JSON.
  explicit JsonFile(const std::filesystem::path& file);
  ~JsonFile();
  JsonFile(JsonFile&&) noexcept;
  /// The value at `path`: keys, or places in a list from 0, with dots between. Throws SceneError.
  double number(std::string_view path) const;
  std::string text(std::string_view path) const;
  std::vector<std::string> texts(std::string_view path) const;
  /// "" where there is no text at `path`.
  std::string text_or_empty(std::string_view path) const;
  /// Null where there is none.
  const nlohmann::json* find(std::string_view path) const;
  const nlohmann::json& document() const { return *document_; }
  /// What is wrong with the file, to be thrown.
  [[noreturn]] void fail(std::string_view path, const char* must) const;

 private:
  std::string name_;
  std::unique_ptr<nlohmann::json> document_;
};

}  // namespace freeplay
