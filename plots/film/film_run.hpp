// A run as a film shows it: shapes in the frames of their bodies, poses, play and forces at frames of its own, between which it is
// straight.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "plots/report/events.hpp"
#include "plots/tables/run_facts.hpp"
#include "values/vec2.hpp"

namespace freeplay::report {

/// Where a time lies: behind frame i, a part of the way to the next.
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
  std::string kind, name;  ///< of the table of a pose (io/scene/pose_file.hpp)
  int body, other;         ///< −1 the ground
  std::vector<Vec2> points;
  Vec2 more;
};

using Column = std::vector<double>;

struct FilmLoose {
  std::string name, kind;  ///< journal, guide, slot
  std::vector<Column> columns;
  double clearance;  ///< m
};

struct FilmForce {
  std::string name;
  Column fx, fy;            ///< N
  std::vector<int> shapes;  ///< where it acts; none: nowhere that is drawn
};

struct FilmRun {
  std::string title;  ///< penalty, nonsmooth
  Column t;           ///< s
  std::vector<std::string> bodies;
  std::vector<Column> poses;  ///< x, y, θ of each body
  std::vector<FilmShape> shapes;
  std::vector<FilmLoose> loose;
  std::vector<FilmForce> forces;
  double usual_force = 0;  ///< N, that 1 in 50 values exceed
  Events events;
  std::pair<int, int> crank{-1, -1};  ///< bodies whose angle to one another is the crank's; equal: none

  At at(double now) const;
  Pose pose(int body, const At& now) const;
  double crank_angle(const At& now) const;  ///< rad
  /// Of a journal (ex, ey)/c; of a guide its ends', of a slot its pin's place across, −1 to 1.
  std::vector<double> play(const FilmLoose& joint, const At& now) const;
  /// The shapes that a force or an impact of this name acts at: of two round ones both. Empty: none is drawn.
  std::vector<int> shapes_of(const std::string& name) const;
  /// Where it acts, of those shapes: where two discs are nearest, in the middle of a face, else at the shape's point (m, in the world).
  Vec2 acts_at(const std::vector<int>& list, const At& now) const;
};

double between(const Column& column, const At& at);

/// With about `frames` frames and those beside the hardest events. Throws SceneError for tables that are wrong.
FilmRun film_run(const plots::RunFolder& folder, long frames);

}  // namespace freeplay::report
