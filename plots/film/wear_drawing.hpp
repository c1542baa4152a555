// One frame of the film of a wear study: the worn surfaces of each joint, a row for each joint and a column for each
// formulation, with the number of turns below.
//
// Bearing and journal are drawn around one centre with the same nominal circle, and the depth h outward for the bearing
// and inward for the journal. One scale of depths, such that the greatest is well visible, holds for all frames and
// cells. Between cycles the depths are interpolated linearly in the number of turns.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freeplay::report {

class WearDrawing {
 public:
  /// Reads profiles.csv of a folder. `width`: px of a frame. Throws SceneError.
  WearDrawing(const std::filesystem::path& folder, int width);

  int width() const { return width_; }
  int height() const { return height_; }   ///< px, even, as video codecs require
  double turns() const { return turns_; }  ///< of the last cycle of any formulation
  /// SVG of the frame after this number of turns.
  std::string frame(double turns) const;

 private:
  /// Depths (m) over equal angles after some turns.
  struct Snapshot {
    double turns = 0;
    std::vector<double> bearing, journal;
  };
  /// One joint by one formulation.
  struct Cell {
    std::string joint, formulation;
    std::vector<Snapshot> snapshots;
  };
  Snapshot at(const Cell& cell, double turns) const;

  std::vector<Cell> cells_;
  std::vector<std::string> joints_, formulations_;
  double turns_ = 0, greatest_ = 0;  // greatest_: m, depth
  int width_, height_;
};

}  // namespace freeplay::report
