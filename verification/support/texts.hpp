// Texts in tests: their lines and fields, columns of result files, edits of them, the message with
// which a text is refused, and the form of what the program prints.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mechanism/error.hpp"

namespace freeplay {
struct Result;
}

namespace freeplay::test {

std::vector<std::string> lines_of(const std::string& text);
/// Of a line of CSV without quotes.
std::vector<std::string> fields_of(const std::string& line);
/// `text` with its first `from` replaced. Throws if it contains none.
std::string replaced(std::string text, const std::string& from, const std::string& to);
/// The blocks of a figure's data, of rows of numbers, which begin with comments.
std::vector<std::vector<std::vector<double>>> data_blocks(const std::filesystem::path& file);
/// How often a part occurs in a text.
std::size_t count(const std::string& text, const std::string& part);
nlohmann::json read_json(const std::filesystem::path& file);
/// The notes of a run, a line each.
std::string notes_of(const Result& run);

/// The message of the exception of a call; "accepted" if it throws nothing.
template <class Error = ModelError, class Call>
std::string refusal_of(const Call& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}
/// The same for reading a scene's text.
std::string refusal(const std::string& text, const std::vector<std::string>& overrides = {},
                    const std::string& file = "s.toml");

/// A result file (CSV without quotes) as its columns of numbers. A field with a word, such as the channel's name in signals.csv, is NaN as a number. Throws if a
/// line has another number of fields than the header.
class Columns {
 public:
  explicit Columns(const std::filesystem::path& file);
  const std::string& header() const { return header_; }
  std::size_t rows() const { return rows_.size(); }
  const std::vector<double>& row(std::size_t i) const { return rows_.at(i); }
  bool has(const std::string& column) const { return index_.contains(column); }
  double at(std::size_t row, const std::string& column) const { return rows_.at(row)[index_.at(column)]; }

 private:
  std::string header_;
  std::map<std::string, std::size_t> index_;
  std::vector<std::vector<double>> rows_;
};

/// Characters of UTF-8 without wide ones: columns of a terminal.
std::size_t width(const std::string& text);
/// The fault of an error message, or nothing: one line, or three for lists, and no words of libraries.
std::string fault_of(const std::string& message);

/// A change of a valid text, and words of the expected message.
struct Edit {
  std::string from, to, words;
};

}  // namespace freeplay::test
