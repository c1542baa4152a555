// All that the future of a run depends on, as a value: taken from a simulation between two steps, given to another
// of the same scene, formulation and program, which goes on from it bit for bit.
#pragma once

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace freeplay {

/// A snapshot that cannot be read, or that belongs to something else; what() says to what.
struct SnapshotError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Snapshot {
 public:
  double t = 0;  ///< s
  /// @name Parts of the identity of the simulation that it was taken from; see identity.hpp
  ///@{
  std::string program;
  std::string formulation;
  std::string scene;
  ///@}
  std::vector<std::byte> memory;

  /// Throws SnapshotError when another program made it, which could not go on bit for bit: other sources, another
  /// compiler, other flags or another kind of processor. The commit does not count.
  void require_program() const;
  /// Identity::program of this one.
  static std::string this_program();

  /// Writes it whole or not at all, with its version and a checksum. Throws SnapshotError.
  void write(const std::filesystem::path& file) const;
  /// Throws SnapshotError for what is no snapshot, is damaged, or has another version.
  static Snapshot read(const std::filesystem::path& file);
};

}  // namespace freeplay
