#include "io/files/sealed.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <cstring>
#include <string_view>

#include "io/files/digest.hpp"
#include "io/files/identity.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"
#include "values/memory.hpp"
#include "values/snapshot.hpp"

namespace freeplay {
namespace {

std::string first_line(const std::string& kind, int version, std::string_view bytes) {
  return fmt::format("freeplay {} {} {} {:016x}\n", kind, version, bytes.size(), checksum(bytes));
}

}  // namespace

void write_sealed(const std::filesystem::path& file, const std::string& kind, int version,
                  const std::vector<std::byte>& bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  OutputFile out(file);
  out.write(first_line(kind, version, text));
  out.write(text);
  out.commit();
}

std::vector<std::byte> read_sealed(const std::filesystem::path& file, const std::string& kind, int version) {
  const auto refuse = [&](const std::string& why) {
    throw SnapshotError(fmt::format("{}: {}", file.string(), why));
  };
  std::string all;
  try {
    all = read_file(file, most_of_a_result);
  } catch (const SceneError& e) {
    throw SnapshotError(e.what());
  }
  const auto end = all.find('\n');
  const auto head = fmt::format("freeplay {} ", kind);
  if (end == all.npos || !all.starts_with(head)) refuse(fmt::format("is not a {} of freeplay", kind));
  if (const int found = std::atoi(all.c_str() + head.size()); found != version)
    refuse(fmt::format("is a {} of version {}; this program reads version {}", kind, found, version));
  const std::string_view bytes = std::string_view(all).substr(end + 1);
  if (all.substr(0, end + 1) != first_line(kind, version, bytes)) refuse("is damaged: its checksum is wrong");
  std::vector<std::byte> result(bytes.size());
  if (!bytes.empty()) std::memcpy(result.data(), bytes.data(), bytes.size());
  return result;
}

namespace {

constexpr int format_version = 2;

template <class M, class S>
void fields(M& m, S& s) {
  m(s.t, s.program, s.formulation, s.scene, s.memory);
}

}  // namespace

std::string Snapshot::this_program() { return program_identity(); }

void Snapshot::require_program() const {
  if (const auto own = this_program(); program != own)
    throw SnapshotError(
        fmt::format("the snapshot was taken by freeplay {}, this is {}: bit-for-bit continuation is "
                    "impossible",
                    program_name(program), program_name(own)));
}

void Snapshot::write(const std::filesystem::path& file) const {
  std::vector<std::byte> bytes;
  MemoryWriter m(bytes);
  auto copy = *this;
  fields(m, copy);
  try {
    write_sealed(real_folder(std::filesystem::absolute(file).parent_path()) / file.filename(), "snapshot",
                 format_version, bytes);
  } catch (const OutputError& e) {
    throw SnapshotError(e.what());
  }
}

Snapshot Snapshot::read(const std::filesystem::path& file) {
  const auto bytes = read_sealed(file, "snapshot", format_version);
  MemoryReader m(bytes);
  Snapshot s;
  try {
    fields(m, s);
  } catch (const MemoryError& e) {
    throw SnapshotError(file.string() + ": " + e.what());
  }
  return s;
}

}  // namespace freeplay
