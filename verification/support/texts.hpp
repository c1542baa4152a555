// Texts in tests: their lines and fields, edits of them, and the message with which a text is
// refused.
#pragma once

#include <filesystem>
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

/// A change of a valid text, and words of the expected message.
struct Edit {
  std::string from, to, words;
};

}  // namespace freeplay::test
