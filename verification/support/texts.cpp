#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "mechanism/scene.hpp"
#include "verification/support/support.hpp"
#include "verification/support/texts.hpp"

namespace freeplay::test {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
  return fields;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == text.npos) throw std::runtime_error(fmt::format("\"{}\" does not stand in the text", from));
  return text.replace(at, from.size(), to);
}

std::vector<std::vector<std::vector<double>>> data_blocks(const std::filesystem::path& file) {
  std::vector<std::vector<std::vector<double>>> blocks;
  for (const auto& line : lines_of(file_text(file))) {
    if (line.starts_with("#")) blocks.emplace_back();
    if (line.empty() || line.starts_with("#")) continue;
    std::istringstream numbers(line);
    auto& row = blocks.back().emplace_back();
    for (std::string number; numbers >> number;) row.push_back(std::stod(number));
  }
  return blocks;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != text.npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

nlohmann::json read_json(const std::filesystem::path& file) { return nlohmann::json::parse(file_text(file)); }

std::string notes_of(const Result& run) {
  std::string all;
  for (const auto& note : run.notes) all += note + "\n";
  return all;
}

std::string refusal(const std::string& text, const std::vector<std::string>& overrides,
                    const std::string& file) {
  return refusal_of<SceneError>([&] { parse_scene(text, file, overrides); });
}

Columns::Columns(const std::filesystem::path& file) {
  for (const auto& line : lines_of(file_text(file))) {
    const auto fields = fields_of(line);
    if (header_.empty()) {
      header_ = line;
      for (const auto& name : fields) index_.emplace(name, index_.size());
      continue;
    }
    if (fields.size() != index_.size()) throw std::runtime_error(file.string() + ": a line is too short");
    auto& row = rows_.emplace_back();
    for (const auto& field : fields) {
      char* end = nullptr;
      const double number = std::strtod(field.c_str(), &end);
      row.push_back(*end == '\0' && end != field.c_str() ? number : NAN);
    }
  }
}

std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string fault_of(const std::string& message) {
  const auto lines = std::ranges::count(message, '\n');
  if (message.empty() || message.back() != '\n') return "does not end with its line";
  if (lines > 3) return "is of many lines";
  if (lines > 1 && message.find("\n  ") == message.npos && message.find("`freeplay help") == message.npos)
    return "goes on without a list";
  for (const char* foreign :
       {"std::", "SQL", "sql", "toml::", "toml++", "json.exception", "nlohmann", "PRAGMA", "boost", "Boost",
        "Ipopt", "KLU", "filesystem error", "what()", "terminate", "parse error", "Error while"})
    if (message.find(foreign) != message.npos) return fmt::format("says \"{}\"", foreign);
  if (std::ranges::any_of(message, [](char c) { return (c >= 0 && c < 0x20 && c != '\n') || c == 0x7F; }))
    return "has control characters";
  return "";
}

}  // namespace freeplay::test
