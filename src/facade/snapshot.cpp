#include "values/snapshot.hpp"

#include <fmt/format.h>

#include "io/files/identity.hpp"
#include "io/files/output_file.hpp"
#include "io/files/sealed.hpp"
#include "values/memory.hpp"

namespace freeplay {
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
