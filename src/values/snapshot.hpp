// Snapshot of a simulation: the complete state that its further run depends on, as a value. It is
// taken between two steps. Another simulation of the same scene, formulation and program can
// restore it and continues bit for bit.
#pragma once

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace freeplay {

/// A snapshot that cannot be read or that belongs to another scene, formulation or program; what()
/// says to which.
struct SnapshotError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Complete state of a simulation between two steps.
class Snapshot {
 public:
  double t = 0;  ///< s
  /// @name Parts of the identity of its simulation; see identity.hpp
  ///@{
  std::string program;      ///< version, sources, compiler, flags and processor
  std::string formulation;  ///< its name and matched restitutions
  std::string scene;        ///< canonical text
  ///@}
  std::vector<std::byte> memory;  ///< the state

  /// Throws SnapshotError if the snapshot is from a program that would not continue bit for bit:
  /// with other sources, compiler, flags or kind of processor. The commit does not count.
  void require_program() const;
  /// Identity::program of this program.
  static std::string this_program();

  /// Writes the file completely or not at all, with version and checksum. Throws SnapshotError.
  void write(const std::filesystem::path& file) const;
  /// Throws SnapshotError if the file is no snapshot, is damaged or has another version.
  static Snapshot read(const std::filesystem::path& file);
};

}  // namespace freeplay
