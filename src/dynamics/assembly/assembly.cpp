#include "dynamics/assembly/assembly.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/assembly/beam_start.hpp"
#include "dynamics/assembly/closing.hpp"
#include "dynamics/assembly/equilibrium.hpp"
#include "dynamics/assembly/four_bar.hpp"
#include "dynamics/assembly/meshing.hpp"
#include "dynamics/assembly/other_starts.hpp"
#include "dynamics/assembly/stated.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"
#include "numerics/sparse.hpp"

namespace freeplay {
namespace {

double size_of(const OpenJoint& open, double length) {
  return open.angular ? length * open.amount : open.amount;
}

/// Angle of a drive's joint (rad).
double driven_angle(const Mechanism& mechanism, const std::string& drive, const std::vector<double>& q) {
  const auto it = std::ranges::find_if(mechanism.drives, [&](const Drive& d) { return name_of(d) == drive; });
  const int joint = std::visit([](const auto& d) { return d.joint; }, *it);
  const auto pair = bodies_of(mechanism.joints[joint]);
  const auto angle = [&](int body) { return body == ground ? 0 : planar::angle(q.data(), body); };
  return angle(pair[1]) - angle(pair[0]);
}

/// Throws the error for the joints that stay open in the best pose `q`.
[[noreturn]] void refuse_open(const Mechanism& mechanism, const System& system, std::vector<double> q,
                              int others) {
  const double length = length_scale(system);
  const auto open = open_joints(system, q, length);
  if (open.empty() || !std::isfinite(worst_open_joint(system, q).amount))
    throw ModelError("",
                     "the mechanism cannot be assembled: a position or length exceeds the range of numbers");
  std::string message = "cannot be closed: in the best pose found, it " + describe(open.front());
  constexpr std::size_t shown = 4;
  for (std::size_t i = 1; i < std::min(open.size(), shown); ++i)
    message +=
        fmt::format(", \"{}\" by {:.4g} {}", open[i].name, open[i].amount, open[i].angular ? "rad" : "m");
  if (open.size() > shown) message += fmt::format(", and {} more", open.size() - shown);
  // A drive may hold the mechanism in a position where it cannot be closed.
  best_pose(system, length, false, q);
  const auto free = open_joints(system, q, length);
  std::string remedy =
      "check the lengths, or give bodies.*.position and .angle closer to the assembled "
      "pose";
  const auto has_angle = [&](const std::string& drive) {
    return std::ranges::any_of(mechanism.drives, [&](const Drive& d) {
      return name_of(d) == drive && std::holds_alternative<SpeedDrive>(d);
    });
  };
  if (!free.empty() && free.front().drive && has_angle(free.front().name) &&
      (free.size() == 1 || size_of(free[1], length) < 1e-6 * length))
    remedy = fmt::format("it closes with drives.{}.initial_angle = {:.4f}", free.front().name,
                         driven_angle(mechanism, free.front().name, q));
  for (const auto& loop : four_bars(mechanism))
    if (const auto why = too_long(mechanism, loop); !why.empty()) remedy = why;
  if (others > 0) message += fmt::format("; {} other initial guesses do not close either", others);
  throw ModelError(key_of(mechanism, open.front()), fmt::format("{}; {}", message, remedy));
}

/// The start of an assembly, and its findings.
struct AssemblyStart {
  std::vector<char> held;    ///< stated positions
  std::vector<double> from;  ///< the pose from which the search begins
  OpenJoint violated;        ///< by the stated positions
  std::string other;         ///< another initial guess that was used, if any
  bool requested = false;    ///< whether the scene requests another pose than the stated one
};

/// A mechanism that states no positions.
Mechanism without_pose(Mechanism m) {
  for (auto& b : m.bodies) b.position.reset(), b.angle.reset();
  return m;
}

/// The open joint that stated positions leave in the best pose of the others.
OpenJoint worst_of(const System& system, const std::vector<double>& q, double length) {
  const auto list = open_joints(system, q, length);
  return list.empty() ? OpenJoint{} : list.front();
}

/// Whether positions that are not held can close rows or contacts.
bool can_close(const System& system, const std::vector<char>& held) {
  const auto free = [&](int c) { return !held[static_cast<std::size_t>(c)]; };
  if (std::ranges::any_of(system.pattern().column, free)) return true;
  for (int c = 0; c < system.n(); ++c)
    if (free(c) && !system.is_angle(c)) return true;
  return false;
}

/// Closes q with the stated positions held, or changes them as little as possible (stated.hpp).
/// Returns false if neither leads to a closed pose; `best` is then the best pose found.
bool close_stated(const Mechanism& mechanism, const System& system, AssemblyStart& begun,
                  std::vector<double>& q, std::vector<double>& best, const StopToken& stop) {
  if (!std::isfinite(worst_open_joint(system, q).amount)) refuse_open(mechanism, system, q, 0);
  if (!any(begun.held)) return Closing(mechanism, system, stop, {system.mass()}).close(q, best);
  const Closing holding(mechanism, system, stop, {system.mass(), begun.held});
  best = q;
  if (can_close(system, begun.held) ? holding.close(q, best) : holding.open(q) <= holding.accepted()) {
    // To rounding, by changes of rounding size in stated values with few digits.
    const Closing all(mechanism, system, stop, light_where_absent(system, begun.held));
    if (holding.open(q) > 1e-14 * holding.length()) all.close_exactly(q);
    return true;
  }
  begun.violated = worst_of(system, best, holding.length());
  const Closing moving(mechanism, system, stop, light_where_absent(system, begun.held));
  q = best;
  if (!moving.close(q, best)) return false;
  // Absent positions that the corrected ones leave open are nearest to the first pose.
  auto rough = begun.from, settled = q;
  for (std::size_t c = 0; c < q.size(); ++c)
    if (begun.held[c]) rough[c] = q[c];
  if (holding.approach(rough, settled)) q = settled;
  return true;
}

/// Closes another start of m near a pose (other_starts.hpp) to the requested pose, in q, with the `held`
/// positions of `given` kept (empty: none). Returns its description, empty if no start leads there; adds
/// their number to `tried`.
std::string close_elsewhere(const Mechanism& m, const System& system, const std::vector<double>& near,
                            const std::vector<double>& given, const std::vector<char>& held,
                            const StopToken& stop, std::vector<double>& q, int& tried) {
  const OtherStarts others(m, near, length_scale(system));
  const Closing closing(m, system, stop, held.empty() ? Metric{system.mass()} : Metric{system.mass(), held});
  tried += others.count();
  for (int n = 0; n < others.count(); ++n) {
    if (stop()) throw Interrupted();
    auto pose = others.pose(n);
    for (std::size_t c = 0; c < held.size(); ++c)
      if (held[c]) pose[c] = given[c];
    if (!closing.close_from(pose) || !mismatch(m, pose).key.empty()) continue;
    q = pose;
    return fmt::format("assembled from initial guess {} of {}: {}", n + 1, others.count(), others.what(n));
  }
  return "";
}

/// Assembly of positions: from one start, and from others if that does not close or gives another
/// pose than the requested one. `begun` is nullptr if only the given start is to be tried, and any
/// pose and change accepted; otherwise it receives the findings.
void assemble_positions(const Mechanism& mechanism, const System& system, State& s, AssemblyStart* begun,
                        const StopToken& stop) {
  AssemblyStart first{begun ? stated_positions(mechanism) : std::vector<char>{}, s.q, {}, {}};
  if (!in_mesh(mechanism, s.q))
    first.from = pose_without_teeth(mechanism, s.q, stop);
  else if (begun && states_pose(mechanism))
    first.from = hung(mechanism, s.q);
  const auto given = s.q;
  const double length = length_scale(system);
  std::vector<double> best;
  s.q = first.from;
  for (std::size_t c = 0; c < first.held.size(); ++c)
    if (first.held[c]) s.q[c] = given[c];
  const bool closed = close_stated(mechanism, system, first, s.q, best, stop);
  const Closing any_pose(mechanism, system, stop, {system.mass()});
  if (closed) any_pose.unwind_to(given, s.q);
  if (!begun) {
    if (!closed) refuse_open(mechanism, system, best, 0);
    return;
  }
  const bool free = mechanism.assembly.approximate;
  const auto wrong = closed ? mismatch(mechanism, s.q) : Mismatch{};
  const auto changes = closed ? changed_positions(mechanism, s.q, length) : std::vector<Change>{};
  const bool kept = changes.empty() || changes.front().relative <= most_change || free;
  first.requested = !wrong.key.empty();
  *begun = first;
  if (closed && wrong.key.empty() && kept) return;
  int tried = 0;
  // Stated positions are held first. They may change if no pose keeps them and the scene allows it
  // or requests another pose.
  for (const bool holds : {true, false}) {
    if (holds ? !any(first.held) : any(first.held) && closed && !free && !first.requested) continue;
    const auto open = holds ? mechanism : without_pose(mechanism);
    const auto guess = close_elsewhere(open, system, closed ? s.q : best, given,
                                       holds ? first.held : std::vector<char>{}, stop, s.q, tried);
    if (guess.empty()) continue;
    any_pose.unwind_to(given, s.q);
    begun->other =
        fmt::format("{}; {}",
                    closed && !wrong.key.empty() ? fmt::format("from the given positions {}", wrong.what)
                    : any(first.held)            ? "the given positions do not lead to a closed pose"
                                                 : "the first positions do not lead to a closed pose",
                    guess);
    return;
  }
  if (!closed) refuse_open(mechanism, system, best, tried);
  if (!wrong.key.empty())
    throw ModelError(wrong.key, fmt::format("{}, and none of {} other initial guesses leads to the requested "
                                            "pose",
                                            wrong.what, tried));
}

}  // namespace

OpenJoint worst_open_joint(const System& system, const std::vector<double>& q, double allowed_penetration) {
  auto e = system.make_evaluation();
  system.place(0, q.data(), e);
  OpenJoint worst;
  for (int k = 0; k < system.rows(); ++k) {
    const double phi = std::abs(e.phi[k]);
    if (phi > worst.amount || !std::isfinite(phi))
      worst = {system.row_name(k), phi, system.is_angle_row(k), false,
               k >= system.rows() - system.drive_rows()};
  }
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& facts = system.contact_facts(k);
    const double inside = -system.gap(k, q.data(), e);
    if (inside > worst.amount && inside > allowed_penetration * facts.measure())
      worst = {facts.name, inside, false, true, false};
  }
  return worst;
}

std::vector<int> redundant_rows(const System& system, const std::vector<double>& q) {
  auto e = system.make_evaluation();
  system.place(0, q.data(), e);
  const auto kept = independent_rows(system.pattern(), e.G, system.mass());
  std::vector<int> rest;
  for (int k = 0; k < system.rows(); ++k)
    if (!std::ranges::binary_search(kept, k)) rest.push_back(k);
  return rest;
}

namespace {

/// Satisfies rows of a single coordinate to the last bit: compiled equations take such a coordinate as a
/// constant.
void close_single_rows(const System& system, std::vector<double>& q) {
  const double rounding = 1e-14 * length_scale(system);
  auto e = system.make_evaluation();
  system.place(0, q.data(), e);
  const auto& p = system.pattern();
  for (int k = 0; k < system.rows() - system.drive_rows(); ++k) {
    const auto first = static_cast<std::size_t>(p.begin[k]);
    if (p.begin[k + 1] - p.begin[k] == 1 && std::abs(e.phi[k]) <= rounding && std::abs(e.G[first]) == 1)
      q[static_cast<std::size_t>(p.column[first])] -= e.phi[k] / e.G[first];
  }
}

/// Whether a drive moves although no body states a velocity other than zero.
bool leaves_velocities_open(const Mechanism& m, bool zero_counts) {
  const auto rests = [&](const Body& b) {
    return zero_counts ? !b.velocity && !b.angular_velocity
                       : b.velocity.value_or(Vec2{}).is_zero() && b.angular_velocity.value_or(0) == 0;
  };
  const auto turns = [&](const Drive& d) {
    if (const auto* motion = std::get_if<MotionDrive>(&d))
      return motion->of < 0 && motion->course(m.curves).jet(0.0).slope != 0;
    const auto* speed = std::get_if<SpeedDrive>(&d);
    return speed && speed->speed != 0;
  };
  return std::ranges::all_of(m.bodies, rests) && std::ranges::any_of(m.drives, turns);
}

/// Moves s to the equilibrium that descent from s reaches, at rest.
void settle(const Mechanism& m, const System& system, const Compliances& elastic, State& s,
            std::string* assumed, const StopToken& stop) {
  for (const auto& b : m.bodies)
    if (const bool turns = b.angular_velocity.value_or(0) != 0;
        turns || !b.velocity.value_or(Vec2{}).is_zero())
      throw ModelError("bodies." + b.name + (turns ? ".angular_velocity" : ".velocity"),
                       "run.start = \"equilibrium\" begins at rest; remove this key, or use \"assembled\"");
  const auto found = find_equilibrium(m, system, s.q, elastic, stop);
  s = found.state;
  const bool turns = leaves_velocities_open(m, false);
  if (assumed)
    *assumed = fmt::format("equilibrium, {}{}{}", describe(found),
                           system.contacts() > 0 ? fmt::format("; {} of {} contacts carry a force",
                                                               found.pressed.size(), system.contacts())
                                                 : "",
                           turns ? "; computed with all drives at their initial angles" : "");
}

/// Sets the velocities of the ideal mechanism at the position nearest to s, which belongs to a
/// mechanism with clearance. Returns false if there is none.
bool move_ideally(const Mechanism& mechanism, State& s, const StopToken& stop) {
  const System ideal(idealised(mechanism));
  State nearest = s;
  try {
    assemble_positions(mechanism, ideal, nearest, nullptr, stop);
    assemble_velocities(mechanism, ideal, {}, nearest);
  } catch (const ModelError&) {
    return false;
  }
  s.v = nearest.v;
  return true;
}

/// Positions of the start "given": as stated, and closed to rounding. Absent ones may need another
/// initial guess, which `note` then names.
void take_positions(const Mechanism& mechanism, const System& system, State& s, std::string& note,
                    const StopToken& stop) {
  // A loaded contact is compressed, by up to a tenth of the clearance or of a disc's radius of
  // curvature; beyond that a run's own results would be doubtful (facade/assess.cpp).
  const double accepted = 1e-6 * length_scale(system);
  auto open = worst_open_joint(system, s.q, 0.1);
  const auto held = stated_positions(mechanism);
  if (open.amount > accepted && std::ranges::count(held, 0) > 0) {
    auto q = hung(mechanism, s.q);
    std::vector<double> best;
    int tried = 0;
    if (Closing(mechanism, system, stop, {system.mass(), held}).close(q, best)) {
      s.q = q;
      open = {};
    } else if (any(held)) {
      note = close_elsewhere(mechanism, system, best, s.q, held, stop, s.q, tried);
      if (!note.empty()) open = {};
    }
  }
  if (open.amount > accepted)
    throw ModelError("run.start", fmt::format("\"given\": {} {}; correct the positions or use \"assembled\"",
                                              key_of(mechanism, open), describe(open)));
  Closing(mechanism, system, stop, light_where_absent(system, held)).close_exactly(s.q);
  if (const auto wrong = mismatch(mechanism, s.q); !wrong.key.empty())
    throw ModelError(wrong.key, wrong.what + "; correct the positions or use run.start = \"assembled\"");
}

/// The start with rigid beams, without velocities if the stated ones do not fit; empty without beams, or if they cannot be
/// rigid, as between fixed ends.
std::optional<State> stiff_start(const Mechanism& mechanism, RunOptions::Start start, const StopToken& stop) {
  if (mechanism.beams.empty()) return {};
  using Start = RunOptions::Start;
  auto rigid = with_rigid_beams(mechanism);
  const auto found = [&]() -> std::optional<State> {
    try {
      return assemble(rigid, start == Start::equilibrium ? Start::assembled : start, nullptr, stop);
    } catch (const ModelError&) {
      return {};
    }
  };
  if (auto state = found()) return state;
  for (auto& body : rigid.bodies) body.velocity.reset(), body.angular_velocity.reset();
  auto state = found();
  if (state) state->v.clear();
  return state;
}

/// The start with full beams in place of reduced ones, whose pieces then take their shape. Stated states of pieces are
/// closed to rounding.
State reduced_start(const Mechanism& mechanism, RunOptions::Start start, std::string* assumed,
                    const StopToken& stop) {
  State s = assemble(with_full_beams(mechanism), start, assumed, stop);
  place_beams(mechanism, s);
  move_beams(mechanism, s);
  if (std::ranges::none_of(mechanism.bodies,
                           [](const Body& b) { return b.made && (b.position || b.velocity); }))
    return s;
  const System system(start == RunOptions::Start::ideal ? idealised(mechanism) : mechanism);
  Closing(mechanism, system, stop, {system.mass()}).close_exactly(s.q);
  assemble_velocities(mechanism, system, {}, s);
  return s;
}

}  // namespace

State assemble(const Mechanism& mechanism, RunOptions::Start start, std::string* assumed,
               const StopToken& stop, const Compliances& elastic) {
  using Start = RunOptions::Start;
  const bool reduced = std::ranges::any_of(mechanism.beams, &Beam::is_reduced);
  if (reduced && start != Start::equilibrium) return reduced_start(mechanism, start, assumed, stop);
  const System system(start == Start::ideal ? idealised(mechanism) : mechanism);
  const double length = length_scale(system);
  // An equilibrium is sought from approximate positions.
  const bool rests = start == Start::equilibrium, free = mechanism.assembly.approximate;
  State s = stated_state(mechanism);
  const auto stiff = reduced ? assemble(with_full_beams(mechanism), Start::assembled, nullptr, stop)
                     : start == Start::given ? std::nullopt
                                             : stiff_start(mechanism, start, stop);
  std::string note;
  AssemblyStart begun;
  if (start == Start::given) {
    take_positions(mechanism, system, s, note, stop);
  } else if (stiff) {
    s.q = stiff->q;
  } else {
    assemble_positions(mechanism, system, s, &begun, stop);
    note = begun.other;
  }
  close_single_rows(system, s.q);
  place_beams(mechanism, s);
  if (!rests)
    report_changes(mechanism, changed_positions(mechanism, s.q, length), begun.violated, "",
                   free || begun.requested ? INFINITY : most_change, note);
  // Without clearances the rows alone determine the motion.
  std::string found;
  if (rests) settle(mechanism, system, elastic, s, &found, stop);
  if ((start == Start::assembled || rests) && leaves_velocities_open(mechanism, !rests) &&
      System(idealised(mechanism)).rows() > system.rows()) {
    const bool moves = move_ideally(mechanism, s, stop);
    if (!rests)
      found = moves ? "no velocity is given: the start has the velocities of the ideal mechanism"
                    : "no velocity is given, and the ideal mechanism cannot move: bodies without a "
                      "drive start at rest";
  }
  const bool fits = stiff || (start == Start::given && stiff_start(mechanism, start, stop));
  if (!mechanism.beams.empty() && !fits && !rests)
    note += fmt::format("{}beams begin strained: the given positions do not fit their unloaded shape",
                        note.empty() ? "" : "; ");
  if (!found.empty()) note += (note.empty() ? "" : "; ") + found;
  if (stop()) throw Interrupted();
  if (stiff && !stiff->v.empty() && !rests) s.v = stiff->v;
  const auto violated =
      assemble_velocities(mechanism, system, rests ? std::vector<char>{} : stated_velocities(mechanism), s);
  if (!rests)
    report_changes(mechanism, changed_velocities(mechanism, s.v, length, speed_scale(mechanism, s.v, length)),
                   violated, "/s",
                   free || begun.requested ? INFINITY
                   : start == Start::given ? 1e-6
                                           : most_change,
                   note);
  if (!rests) move_beams(mechanism, s);
  if (!rests) s.z.assign(system.states(), 0);
  if (assumed) *assumed = note;
  return s;
}

void start_from(Mechanism& mechanism, const State& state) {
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    auto& body = mechanism.bodies[b];
    body.position = planar::position(state.q.data(), b);
    body.velocity = planar::velocity(state.v.data(), b);
    if (body.point) continue;
    body.angle = planar::angle(state.q.data(), b);
    body.angular_velocity = planar::rate(state.v.data(), b);
  }
}

}  // namespace freeplay
