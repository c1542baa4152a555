// The data of a run for a film: shapes in the frames of their bodies; poses, positions within the
// clearance and forces at frames, with linear interpolation between them.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "io/scene/beam_line.hpp"
#include "plots/report/run_data.hpp"
#include "plots/tables/run_facts.hpp"
#include "values/vec2.hpp"

namespace freeplay::report {

/// Position of a time: after frame i, at the fraction `part` of the interval to the next frame.
struct At {
  std::size_t i = 0;
  double part = 0;
};

struct Pose {
  Vec2 at;
  double cosine = 1, sine = 0;
  Vec2 turned(const Vec2& p) const { return {cosine * p.x() - sine * p.y(), sine * p.x() + cosine * p.y()}; }
  Vec2 place(const Vec2& p) const { return at + turned(p); }
};

struct FilmShape {
  std::string kind, name;  ///< as in the table of a pose (io/scene/pose_file.hpp)
  int body, other;         ///< −1: ground
  std::vector<Vec2> points;
  Vec2 more;
  std::vector<Vec2> nominal = {};  ///< of a bearing or journal: places of the points on the nominal circle
};

using Column = std::vector<double>;

struct FilmClearance {
  std::string name, kind;  ///< journal, guide, slot
  std::vector<Column> columns;
  double clearance;  ///< m
};

struct FilmForce {
  std::string name;
  Column fx, fy;            ///< N
  std::vector<int> shapes;  ///< shapes at which it acts; empty: not drawn
};

struct FilmRun {
  std::string title;  ///< penalty, nonsmooth
  Column t;           ///< s
  std::vector<std::string> bodies;
  std::vector<Column> poses;  ///< x, y, θ of each body
  std::vector<FilmShape> shapes;
  std::vector<BeamLine> beams;  ///< with the bodies of this run
  std::vector<FilmClearance> clearance_joint;
  std::vector<FilmForce> forces;
  double usual_force = 0;  ///< N, exceeded by 1 in 50 values
  Events events;
  /// bodies whose relative angle is the crank angle; equal: none
  std::pair<int, int> crank{-1, -1};

  At at(double now) const;
  Pose pose(int body, const At& now) const;
  double crank_angle(const At& now) const;  ///< rad
  /// The line of a beam with its deflection magnified (m, world frame).
  std::vector<Vec2> line(const BeamLine& beam, const At& now, double magnify) const;
  /// The line of a bearing or journal with clearance and deviations magnified (m, world frame).
  std::vector<Vec2> line(const FilmShape& surface, const At& now, double magnify) const;
  /// Whether the run has shapes of bearings and journals.
  bool has_surfaces() const;
  /// Position within the clearance: (ex, ey)/c of a journal; position across of the ends of a guide
  /// or the pin of a slot, −1 to 1.
  std::vector<double> play(const FilmClearance& joint, const At& now) const;
  /// The shapes at which a force or an impact of this name acts; both shapes if two are round.
  /// Empty: not drawn.
  std::vector<int> shapes_of(const std::string& name) const;
  /// Point of action on these shapes (m, world frame): the nearest point of two discs, the middle
  /// of a face, else the point of the shape.
  Vec2 acts_at(const std::vector<int>& list, const At& now) const;
};

double between(const Column& column, const At& at);

/// Reads a run with about `frames` frames, and further frames beside the hardest events. Throws
/// SceneError for invalid tables.
FilmRun film_run(const plots::RunFolder& folder, long frames);

}  // namespace freeplay::report
