#include "io/output_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <system_error>

namespace freeplay {

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    throw OutputError(fmt::format("{}: cannot make this folder: {}", folder.string(),
                                  error ? error.message() : "a file of that name is in the way"));
}

OutputFile::OutputFile(const std::filesystem::path& path, bool resumed)
    : path_(path), partial_(path.string() + ".partial"), buffer_(1 << 16) {
  if (resumed) return;
  file_ = std::fopen(partial_.c_str(), "wb");
  if (!file_) fail("cannot be written");
  std::setvbuf(file_, nullptr, _IONBF, 0);  // the buffer is ours
}

OutputFile::~OutputFile() {
  if (!file_) return;
  std::fclose(file_);
  std::error_code ignored;
  if (!keep_) std::filesystem::remove(partial_, ignored);
}

void OutputFile::fail(const char* what) const {
  throw OutputError(fmt::format("{}: {}: {}", path_.string(), what, std::strerror(errno)));
}

/// What went wrong is the program's, so that it says where it was.
void OutputFile::refuse(double x) {
  std::string_view row(buffer_.data(), used_);
  row.remove_prefix(row.rfind('\n') + 1);  // npos + 1 = 0
  throw OutputError(
      fmt::format("{}: refuses to hold {}: in the row that begins with \"{}\", behind {} numbers",
                  path_.string(), x, row.substr(0, row.find(',')), std::ranges::count(row, ',')));
}

void OutputFile::flush() {
  if (used_ == 0) return;
  if (std::fwrite(buffer_.data(), 1, used_, file_) != used_) fail("cannot be written");
  written_ += used_;
  used_ = 0;
}

std::uint64_t OutputFile::settle() {
  flush();
  return written_;
}

void OutputFile::require(std::uint64_t size) const {
  std::error_code error;
  const auto found =
      std::filesystem::file_size(std::filesystem::exists(partial_, error) ? partial_ : path_, error);
  if (error || found < size)
    throw OutputError(fmt::format("{}: cannot be gone on with: {} of its first {} bytes are there",
                                  path_.string(), error ? 0 : found, size));
}

void OutputFile::go_on_at(std::uint64_t size) {
  require(size);
  keep();
  // An interrupted run has put its files in their places; a killed one has left them beside.
  std::error_code error;
  if (!std::filesystem::exists(partial_, error)) std::filesystem::rename(path_, partial_, error);
  if (!error) std::filesystem::resize_file(partial_, size, error);
  if (error) errno = error.value();
  file_ = error ? nullptr : std::fopen(partial_.c_str(), "ab");
  if (!file_) fail("cannot be gone on with");
  std::setvbuf(file_, nullptr, _IONBF, 0);
  written_ = size;
}

void OutputFile::write(std::string_view text) {
  if (text.size() > buffer_.size() - used_) flush();
  if (text.size() > buffer_.size()) {
    if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail("cannot be written");
    written_ += text.size();
    return;
  }
  std::memcpy(buffer_.data() + used_, text.data(), text.size());
  used_ += text.size();
}

void OutputFile::number(double x) {
  if (!std::isfinite(x)) refuse(x);
  if (buffer_.size() - used_ < 32) flush();
  const auto end = fmt::format_to(buffer_.data() + used_, "{}", x);
  used_ = static_cast<std::size_t>(end - buffer_.data());
}

void OutputFile::commit() {
  flush();
  std::FILE* file = file_;
  file_ = nullptr;
  const bool closed = std::fclose(file) == 0;
  std::error_code error;
  if (closed) std::filesystem::rename(partial_, path_, error);
  if (!closed || error) {
    const int reason = closed ? error.value() : errno;
    std::error_code ignored;
    if (!keep_) std::filesystem::remove(partial_, ignored);
    errno = reason;
    fail("cannot be completed");
  }
}

void write_file(const std::filesystem::path& path, std::string_view text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace freeplay
