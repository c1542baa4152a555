#include "cli/scene_report.hpp"

#include <algorithm>
#include <type_traits>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/closing.hpp"
#include "dynamics/assembly/four_bar.hpp"
#include "dynamics/assembly/meshing.hpp"
#include "dynamics/assembly/mobility.hpp"
#include "dynamics/assembly/stated.hpp"
#include "dynamics/assembly/turn_survey.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay::cli {
namespace {

constexpr std::size_t most_loops = 4, most_bodies = 20, most_named = 8;
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

std::string listed(const std::vector<std::string>& names) {
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), most_named); ++i)
    list += (list.empty() ? "" : ", ") + names[i];
  return names.size() > most_named ? fmt::format("{} and {} more", list, names.size() - most_named) : list;
}

/// Describes the motions that no drive prescribes.
void left_free(const Mechanism& mechanism, const State& start, int motions, Lines& lines) {
  std::string which, coordinates;
  if (mechanism.bodies.size() <= most_bodies) {
    const auto free = undriven_motions(mechanism, start.q);
    std::vector<std::string> names;
    for (const int b : free.bodies) names.push_back(mechanism.bodies[static_cast<std::size_t>(b)].name);
    which = names.empty() ? "" : ", of " + listed(names);
    coordinates = listed(free.coordinates);
  }
  const bool efforts = std::ranges::any_of(mechanism.drives, [](const Drive& d) {
    return !std::holds_alternative<SpeedDrive>(d) && !std::holds_alternative<MotionDrive>(d);
  });
  lines.emplace_back("  undriven motion",
                     fmt::format("{} {} {}{}: determined by forces and inertia alone", motions,
                                 motions == 1 ? "motion" : "motions",
                                 efforts ? "that no drive prescribes" : "without a drive", which));
  if (!coordinates.empty()) lines.emplace_back("  undriven coordinates", coordinates);
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
  if (driven.rank < n) left_free(mechanism, start, n - driven.rank, lines);
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

/// An angle of the drive (rad) in degrees, with a resolution of 0.01 degrees; of a full turn, from 0
/// to 360.
std::string degrees(double angle, bool full) {
  double d = std::round(angle * 180 / std::numbers::pi * 100) / 100;
  if (full) d -= 360 * std::floor(d / 360);
  return fmt::format("{:.6g}", d + 0.0);
}

void whole_turn(const Mechanism& mechanism, const State& start, Lines& lines) {
  const auto survey = survey_turn(mechanism, start.q);
  if (!survey) return;
  const auto at = [&](double angle) { return degrees(angle, survey->full); };
  if (survey->full) {
    lines.emplace_back("turn of the drive", survey->joint + " closes over a full turn");
  } else {
    std::string opens;
    for (const auto* end : {&survey->below, &survey->above})
      if (*end && opens.find((*end)->name) == opens.npos)
        opens += (opens.empty() ? "" : ", ") + key_of(mechanism, **end);
    lines.emplace_back("turn of the drive",
                       fmt::format("{} closes from {} to {} deg; beyond, {} opens", survey->joint,
                                   at(survey->lower), at(survey->upper), opens));
  }
  for (const auto& output : survey->outputs) {
    const double travel = output.slides ? output.travel : output.travel * 180 / std::numbers::pi;
    std::string said;
    auto centres = output.dead_centres;
    if (survey->full)
      std::ranges::sort(centres, {}, [&](const TurnExtreme& d) { return std::stod(at(d.angle)); });
    for (const auto& d : centres) said += (said.empty() ? "dead centres at " : ", ") + at(d.angle);
    if (said.empty())
      said = "no dead centre";
    else
      said += " deg";
    if (survey->full && std::abs(output.turns) > 1e-6)
      said += fmt::format("; {:.6g} turns per turn of the drive", output.turns);
    if (!output.dead_centres.empty() || !survey->full)
      said += fmt::format("; travel {:.6g} {}", travel, output.slides ? "m" : "deg");
    lines.emplace_back("  motion", output.joint + ": " + said);
  }
  for (const auto& drive : mechanism.drives)
    if (const auto* servo = std::get_if<AngleController>(&drive))
      for (const auto& output : survey->outputs)
        if (survey->full && output.turns < 0 && name_of(mechanism.joints[servo->joint]) == survey->joint &&
            name_of(mechanism.joints[servo->fed_back()]) == output.joint)
          lines.emplace_back("  positive feedback",
                             fmt::format("drives.{} measures {}, which turns against {}: the error grows; "
                                         "exchange the bodies of {} or measure another joint",
                                         servo->name, output.joint, survey->joint, output.joint));
  for (const auto& mu : survey->transmission)
    lines.emplace_back("  transmission angle",
                       fmt::format("{}: least {} deg at {} deg, greatest {} deg at {} deg", mu.joint,
                                   degrees(mu.least.value, false), at(mu.least.angle),
                                   degrees(mu.greatest.value, false), at(mu.greatest.angle)));
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

/// Prints how far each joint with clearance moves from one side to the other.
void plays(const Mechanism& mechanism, Lines& lines) {
  const auto line = [&](const std::string& name, const char* what, double half, const char* where) {
    lines.emplace_back("play of " + name,
                       fmt::format("{} {:.4g} mm: {:.4g} mm {}", what, 1e3 * half, 2e3 * half, where));
  };
  for (const auto& joint : mechanism.joints) {
    if (const auto* pin = std::get_if<RevoluteJoint>(&joint); pin && pin->clearance)
      line(pin->name, "radial clearance", pin->clearance->radial, "in every direction");
    if (const auto* guide = std::get_if<TranslationalJoint>(&joint); guide && guide->clearance)
      line(guide->name, "clearance on either side", guide->clearance->half_play, "across the guide");
    if (const auto* slot = std::get_if<SlotJoint>(&joint); slot && slot->clearance)
      line(slot->name, "clearance on either side", slot->clearance->half_play, "across the slot");
    if (const auto* ratio = std::get_if<RatioJoint>(&joint); ratio && ratio->clearance)
      lines.emplace_back(
          "play of " + ratio->name,
          ratio->slider(mechanism)
              ? fmt::format("backlash {:.4g} mm", 1e3 * ratio->clearance->play)
              : fmt::format("backlash {:.4g} degrees", ratio->clearance->play * 180 / std::numbers::pi));
  }
}

void teeth(const Mechanism& mechanism, const State& start, Lines& lines) {
  for (const auto& t : teeth_at(mechanism, start.q)) {
    std::string said = fmt::format(
        "{} {:.6g} m apart, standard {:.6g} m; play along the line of action {:.4g} mm",
        t.rack ? "centre and pitch line" : "centres", t.distance, t.standard, t.ideal ? 0 : 1e3 * t.play);
    if (t.contact_ratio) said += fmt::format("; contact ratio {:.3g}", *t.contact_ratio);
    if (t.apart >= 0)
      said += "; the tips of standard teeth do not reach each other, which the model ignores";
    else if (t.contact_ratio && *t.contact_ratio < 1)
      said += ", below 1: a pair of teeth parts before the next one meets, which the model ignores";
    lines.emplace_back((t.rack ? "rack " : "gears ") + t.name, said);
  }
}

/// A name in the list of bodies, or "the ground".
std::string body_named(const Mechanism& mechanism, int body) {
  return body == ground ? "the ground" : mechanism.bodies[static_cast<std::size_t>(body)].name;
}

/// The efficiencies of teeth in both directions of the power.
void mesh_losses(const Mechanism& mechanism, Lines& lines) {
  const auto losses = [&](const auto& joint) {
    if constexpr (requires { joint.loss.shares(); }) {
      if (!joint.loss.any()) return;
      const auto [driving, driven] = joint.loss.shares();
      const auto first = body_named(mechanism, joint.between[0]),
                 second = body_named(mechanism, joint.between[1]);
      const double back = 1 - driven;
      lines.emplace_back(
          "efficiency of " + joint.name,
          fmt::format("{:.4g} where {} drives; {:.4g} where {} drives{}", 1 / (1 + driving), first, back,
                      second,
                      back <= 0 ? fmt::format(": self-locking, {} cannot drive {}", second, first) : ""));
    }
  };
  for (const auto& joint : mechanism.joints) std::visit(losses, joint);
}

/// Sampling, dead time, resolution and limit of controllers.
void controllers(const Mechanism& mechanism, Lines& lines) {
  const auto report = [&]<class D>(const D& d) {
    if constexpr (std::is_base_of_v<ControlLaw, D>) {
      const bool turns = std::is_same_v<D, AngleController>;
      auto said = !d.sampling_time
                      ? std::string("continuous")
                      : fmt::format("sampled every {:.4g} ms, dead time {:.4g} ms, {}",
                                    1e3 * *d.sampling_time, 1e3 * d.dead_time,
                                    d.resolution ? fmt::format("resolution {:.4g} {}", *d.resolution,
                                                               turns ? "rad" : "m")
                                                 : "exact measurement");
      if (d.limit) said += fmt::format(", at most {:.4g} {}", *d.limit, turns ? "N m" : "N");
      lines.emplace_back(
          "controller " + d.name,
          said + ", measures " + name_of(mechanism.joints[static_cast<std::size_t>(d.fed_back())]));
    }
  };
  for (const auto& drive : mechanism.drives) std::visit(report, drive);
}

/// Direction and capacity of freewheels.
void freewheels(const Mechanism& mechanism, Lines& lines) {
  for (const auto& load : mechanism.loads)
    if (const auto* wheel = std::get_if<Freewheel>(&load)) {
      const bool forward = wheel->direction == Freewheel::Free::forward;
      lines.emplace_back(
          "freewheel " + wheel->name,
          fmt::format("{} turns freely against {} {}; {} it is held up to {:.4g} N m",
                      body_named(mechanism, wheel->between[1]), body_named(mechanism, wheel->between[0]),
                      forward ? "counter-clockwise" : "clockwise",
                      forward ? "clockwise" : "counter-clockwise", wheel->torque_limit));
    }
}

/// The stated initial values that the start changed beyond rounding, with the amounts, where they are
/// more than its note names. An equilibrium changes all of them.
void corrections(const Scene& scene, const State& start, Lines& lines) {
  if (scene.run.start == RunOptions::Start::equilibrium) return;
  const auto& m = scene.mechanism;
  const double length = length_scale(System(m));
  for (const auto& changes : {changed_positions(m, start.q, length),
                              changed_velocities(m, start.v, length, speed_scale(m, start.v, length))}) {
    if (changes.size() <= listed_changes) continue;
    for (std::size_t i = 0; i < std::min(changes.size(), most_bodies); ++i)
      lines.emplace_back(i == 0 ? "corrected initial values" : "",
                         fmt::format("{} by {:.4g} {}", changes[i].key, changes[i].amount, changes[i].unit));
    if (changes.size() > most_bodies)
      lines.emplace_back("", fmt::format("and {} more values", changes.size() - most_bodies));
  }
}

}  // namespace

Lines assembly_report(const Scene& scene, const State& start) {
  const auto& mechanism = scene.mechanism;
  Lines lines;
  corrections(scene, start, lines);
  mobility(mechanism, start, lines);
  loops(mechanism, start, lines);
  whole_turn(mechanism, start, lines);
  angles(mechanism, start, lines);
  plays(mechanism, lines);
  teeth(mechanism, start, lines);
  mesh_losses(mechanism, lines);
  controllers(mechanism, lines);
  freewheels(mechanism, lines);
  pose(mechanism, start, lines);
  return lines;
}

}  // namespace freeplay::cli
