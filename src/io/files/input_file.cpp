#include "io/files/input_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "mechanism/error.hpp"

namespace freeplay {
namespace {

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a FIFO";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

[[noreturn]] void refuse(const std::string& file, const std::string& why) {
  throw SceneError(fmt::format("{}: {}", file, why));
}

/// Reads up to `size` bytes; returns their number, 0 at the end.
std::size_t read_some(int descriptor, const std::string& name, char* to, std::size_t size) {
  for (;;) {
    const auto count = read(descriptor, to, size);
    if (count >= 0) return static_cast<std::size_t>(count);
    if (errno != EINTR) refuse(name, fmt::format("cannot be read: {}", std::strerror(errno)));
  }
}

/// Whether the nesting of brackets is at most that of result files: the memory of the parser grows
/// with it.
bool is_shallow(std::string_view json) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (quoted && c == '\\') ++i;
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if ((c == '[' || c == '{') && ++depth > deepest_json) return false;
    if (c == ']' || c == '}') --depth;
  }
  return true;
}

}  // namespace

RegularFile open_regular(const std::filesystem::path& file, std::uint64_t most, Links links) {
  const auto name = file.string();
  // Do not block: opening a FIFO would wait for a writer.
  const int flags = O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC | (links == Links::refused ? O_NOFOLLOW : 0);
  Descriptor descriptor(open(file.c_str(), flags));
  if (!descriptor) {
    if (errno == ENOENT || errno == ENOTDIR) refuse(name, "no such file");
    if (errno == ELOOP && links == Links::refused) refuse(name, "is a symbolic link, not a file");
    if (errno == ENXIO) refuse(name, "is a socket, not a file");
    refuse(name, fmt::format("cannot be read: {}", std::strerror(errno)));
  }
  struct stat about {};
  if (fstat(descriptor.number(), &about) != 0 || !S_ISREG(about.st_mode))
    refuse(name, fmt::format("is {}, not a file", kind_of(about.st_mode)));
  const auto bytes = static_cast<std::uint64_t>(about.st_size);
  if (bytes > most) refuse(name, fmt::format("exceeds {} MiB, the limit for such files", most >> 20));
  return {std::move(descriptor), bytes};
}

std::string read_file(const std::filesystem::path& file, std::uint64_t most) {
  const auto name = file.string();
  const auto from = open_regular(file, most);
  std::string text;
  std::vector<char> buffer(1 << 16);
  // Read to the end regardless of the size: files of /proc report 0, and others may grow.
  while (const auto count = read_some(from.descriptor.number(), name, buffer.data(), buffer.size())) {
    text.append(buffer.data(), count);
    if (text.size() > most) refuse(name, fmt::format("exceeds {} MiB, the limit for such files", most >> 20));
  }
  return text;
}

LineReader::LineReader(const std::filesystem::path& file)
    : name_(file.string()),
      descriptor_(open_regular(file, std::numeric_limits<std::uint64_t>::max()).descriptor),
      buffer_(1 << 16) {}

LineReader::~LineReader() = default;

bool LineReader::fill() {
  from_ = 0;
  to_ = read_some(descriptor_.number(), name_, buffer_.data(), buffer_.size());
  return to_ > 0;
}

bool LineReader::next(std::string& line) {
  line.clear();
  ++number_;
  while (from_ < to_ || fill()) {
    const char *begin = buffer_.data() + from_, *end = buffer_.data() + to_;
    const char* found = std::find(begin, end, '\n');
    if (line.size() + static_cast<std::size_t>(found - begin) > most_of_a_line)
      throw SceneError(
          fmt::format("{}:{}: exceeds {} MiB, the limit for a line", name_, number_, most_of_a_line >> 20));
    line.append(begin, found);
    from_ += static_cast<std::size_t>(found - begin) + 1;
    if (found == end) continue;
    if (line.ends_with('\r')) line.pop_back();
    return true;
  }
  return !line.empty();
}

JsonFile::JsonFile(const std::filesystem::path& file) : name_(file.string()) {
  const auto text = read_file(file, most_of_a_result);
  if (!is_shallow(text)) refuse(name_, "is damaged: its brackets are nested too deeply");
  document_ = std::make_unique<nlohmann::json>(nlohmann::json::parse(text, nullptr, false));
  if (document_->is_discarded()) refuse(name_, "is damaged: it is not JSON");
}

JsonFile::~JsonFile() = default;
JsonFile::JsonFile(JsonFile&&) noexcept = default;

void JsonFile::fail(std::string_view path, const char* must) const {
  refuse(name_, fmt::format("is damaged: {} must be {}", path, must));
}

const nlohmann::json* JsonFile::find(std::string_view path) const {
  const auto* node = document_.get();
  while (node && !path.empty()) {
    const auto dot = std::min(path.find('.'), path.size());
    const std::string key(path.substr(0, dot));
    if (node->is_array()) {
      std::size_t place = node->size();
      std::from_chars(key.data(), key.data() + key.size(), place);
      node = place < node->size() ? &(*node)[place] : nullptr;
    } else {
      const auto it = node->find(key);
      node = it == node->end() ? nullptr : &*it;
    }
    path.remove_prefix(std::min(dot + 1, path.size()));
  }
  return node;
}

double JsonFile::number(std::string_view path) const {
  const auto* node = find(path);
  if (!node || !node->is_number()) fail(path, "a number");
  return node->get<double>();
}

std::string JsonFile::text(std::string_view path) const {
  const auto* node = find(path);
  if (!node || !node->is_string()) fail(path, "a text");
  return node->get<std::string>();
}

std::string JsonFile::text_or_empty(std::string_view path) const {
  const auto* value = find(path);
  return value && value->is_string() ? value->get<std::string>() : "";
}

std::vector<std::string> JsonFile::texts(std::string_view path) const {
  const auto* node = find(path);
  if (!node || !node->is_array()) fail(path, "a list of texts");
  std::vector<std::string> list;
  for (const auto& item : *node) {
    if (!item.is_string()) fail(path, "a list of texts");
    list.push_back(item.get<std::string>());
  }
  return list;
}

}  // namespace freeplay
