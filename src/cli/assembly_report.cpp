#include "cli/assembly_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/four_bar.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "mechanism/mechanism.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay::cli {
namespace {

constexpr std::size_t most_loops = 4, most_bodies = 20;
using Lines = std::vector<std::pair<std::string, std::string>>;

struct Rank {
  int rows, rank;
};

Rank rank_of(const Mechanism& mechanism, const State& start) {
  const System system(mechanism);
  const auto redundant = redundant_rows(system, start.q);
  const int rows = system.rows() - system.points();
  return {rows, rows - static_cast<int>(redundant.size())};
}

/// Bodies that can move with all drives fixed: those with a coordinate direction whose projection
/// onto the null space of the constraint rows is not zero.
std::vector<std::string> free_bodies(const Mechanism& mechanism, const State& start) {
  auto ideal = idealised(mechanism);
  ideal.loads.clear();
  const System system(ideal);
  auto e = system.make_evaluation();
  system.place(0, start.q.data(), e);
  SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic,
                     {!redundant_rows(system, start.q).empty()});
  std::vector<std::string> names;
  if (!saddle.factor(e.G.data())) return names;
  const auto n = static_cast<std::size_t>(system.n());
  std::vector<double> force(n), moved(n), none(e.phi.size()), lambda(e.phi.size());
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    bool free = false;
    for (std::size_t c = planar::coordinates * b; c < planar::coordinates * (b + 1); ++c) {
      std::ranges::fill(force, 0.0);
      force[c] = system.mass()[c];
      saddle.solve(force.data(), none.data(), moved.data(), lambda.data());
      free |= moved[c] > 1e-9;
    }
    if (free) names.push_back(mechanism.bodies[b].name);
  }
  return names;
}

/// Describes the motions that neither joints nor drives prescribe.
void left_free(const Mechanism& mechanism, const State& start, int motions, Lines& lines) {
  std::string list;
  if (mechanism.bodies.size() <= most_bodies)
    for (const auto& name : free_bodies(mechanism, start)) list += (list.empty() ? "" : ", ") + name;
  lines.emplace_back("  undriven motion",
                     fmt::format("{} {} without a drive{}: determined by forces and inertia alone", motions,
                                 motions == 1 ? "motion" : "motions", list.empty() ? "" : ", of " + list));
}

void mobility(const Mechanism& mechanism, const State& start, Lines& lines) {
  auto ideal = idealised(mechanism);
  ideal.loads.clear();
  const auto driven = rank_of(ideal, start);
  ideal.drives.clear();
  const auto joints = rank_of(ideal, start);
  const auto bodies = static_cast<int>(mechanism.bodies.size());
  const auto points = static_cast<int>(std::ranges::count_if(mechanism.bodies, &Body::point));
  const int n = planar::first(bodies) - points;
  std::string said = fmt::format("{} = 3n{} - rank G with ideal joints: n = {}{}, {} rows of rank {}",
                                 n - joints.rank, points > 0 ? " - p" : "", bodies,
                                 points > 0 ? fmt::format(", p = {} without rotation", points) : "",
                                 joints.rows, joints.rank);
  if (driven.rows > joints.rows)
    said +=
        fmt::format("; {} with the drives' rows, {} of rank {}", n - driven.rank, driven.rows, driven.rank);
  lines.emplace_back("mobility", said);
  if (driven.rows > joints.rows && driven.rank < n) left_free(mechanism, start, n - driven.rank, lines);
}

std::string lengths(const Mechanism& mechanism, const FourBar& loop) {
  std::string list;
  for (std::size_t i = 0; i < 4; ++i)
    list += fmt::format(
        "{}{} {:.6g}", list.empty() ? "" : ", ",
        loop.bodies[i] == ground ? "ground" : mechanism.bodies[static_cast<std::size_t>(loop.bodies[i])].name,
        loop.lengths[i]);
  return list + " m";
}

void loops(const Mechanism& mechanism, const State& start, Lines& lines) {
  const auto all = four_bars(mechanism);
  for (std::size_t i = 0; i < std::min(all.size(), most_loops); ++i) {
    const auto& loop = all[i];
    const auto type = type_of(loop);
    const double outer = loop.shortest_and_longest(), inner = loop.other_two();
    lines.emplace_back("four-bar loop", lengths(mechanism, loop));
    lines.emplace_back("  Grashof", fmt::format("s + l = {:.6g} m {} p + q = {:.6g} m; {}", outer,
                                                type == Grashof::change_point ? "="
                                                : outer < inner               ? "<"
                                                                              : ">",
                                                inner, describe(mechanism, loop, type)));
    lines.emplace_back("  branch", openness(mechanism, loop, start.q) > 0 ? "open" : "crossed");
  }
  if (all.size() > most_loops)
    lines.emplace_back("", fmt::format("and {} more loops", all.size() - most_loops));
}

void angles(const Mechanism& mechanism, const State& start, Lines& lines) {
  for (const auto* list : {&mechanism.assembly.positive, &mechanism.assembly.negative})
    for (const auto& angle : *list) {
      const double a = angle_of(mechanism, angle, start.q);
      lines.emplace_back("angle " + spelt(mechanism, angle),
                         fmt::format("{:.6g} rad, {:.4g} deg", a, a * 180 / std::numbers::pi));
    }
}

void pose(const Mechanism& mechanism, const State& start, Lines& lines) {
  lines.emplace_back("assembled pose", fmt::format("{:>12} {:>12} {:>12}", "x (m)", "y (m)", "theta (deg)"));
  for (std::size_t b = 0; b < std::min(mechanism.bodies.size(), most_bodies); ++b) {
    const auto p = planar::position(start.q.data(), b);
    lines.emplace_back("  " + mechanism.bodies[b].name,
                       fmt::format("{:>12.6g} {:>12.6g} {:>12.6g}", p.x(), p.y(),
                                   std::remainder(planar::angle(start.q.data(), b), 2 * std::numbers::pi) *
                                       180 / std::numbers::pi));
  }
  if (mechanism.bodies.size() > most_bodies)
    lines.emplace_back("", fmt::format("and {} more bodies", mechanism.bodies.size() - most_bodies));
}

}  // namespace

Lines assembly_report(const Mechanism& mechanism, const State& start) {
  Lines lines;
  mobility(mechanism, start, lines);
  loops(mechanism, start, lines);
  angles(mechanism, start, lines);
  pose(mechanism, start, lines);
  return lines;
}

}  // namespace freeplay::cli
