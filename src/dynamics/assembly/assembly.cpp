#include "dynamics/assembly/assembly.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "dynamics/assembly/assembly_ipopt.hpp"
#include "dynamics/assembly/equilibrium.hpp"
#include "dynamics/assembly/four_bar.hpp"
#include "dynamics/assembly/meshing.hpp"
#include "dynamics/assembly/other_starts.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"
#include "numerics/rank.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay {
namespace {

State given_state(const Mechanism& m) {
  State s;
  for (const auto& b : m.bodies) {
    s.q.insert(s.q.end(), {b.position.x(), b.position.y(), b.angle});
    s.v.insert(s.v.end(), {b.velocity.x(), b.velocity.y(), b.angular_velocity});
  }
  return s;
}

/// Newton steps of least mass-weighted length onto Φ = 0, to rounding accuracy.
void close_exactly(const System& system, std::vector<double>& q, bool redundant) {
  auto e = system.make_evaluation();
  SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic, {redundant});
  std::vector<double> dq(q.size()), lambda(e.phi.size()), r(e.phi.size());
  for (int i = 0; i < 5; ++i) {
    system.place(0, q.data(), e);
    if (!saddle.factor(e.G.data())) return;
    std::ranges::transform(e.phi, r.begin(), std::negate{});
    saddle.solve(nullptr, r.data(), dq.data(), lambda.data());
    for (std::size_t c = 0; c < q.size(); ++c) q[c] += dq[c];
  }
}

/// Newton's method for the pose nearest to `rough`: dq = M⁻¹(−Gᵀλ) + (rough − q) onto Φ + G dq = 0.
/// Its limit has M(q − rough) + Gᵀλ = 0 and Φ = 0. The neglected term, the curvature of Φ times λ,
/// is small near closure. Each step must be at most half the previous one, and the first shorter
/// than a tenth of `length` and of a radian. Otherwise it stops and leaves q unchanged, because
/// farther away another branch may be nearer. Returns true with a pose that is closed to
/// `accepted`.
bool step_to_nearest(const System& system, const std::vector<double>& rough, double length, double accepted,
                     std::vector<double>& q) {
  constexpr int most = 30;
  auto e = system.make_evaluation();
  SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic, {});
  const auto n = q.size();
  std::vector<double> pose = q, dq(n), lambda(e.phi.size()), r(e.phi.size()), f(n);
  double last = INFINITY;
  for (int i = 0; i < most; ++i) {
    system.place(0, pose.data(), e);
    if (!saddle.factor(e.G.data()) || saddle.singular()) return false;
    std::ranges::transform(e.phi, r.begin(), std::negate{});
    for (std::size_t c = 0; c < n; ++c) f[c] = system.mass()[c] * (rough[c] - pose[c]);
    saddle.solve(f.data(), r.data(), dq.data(), lambda.data());
    double moved = 0, size = 0;
    for (std::size_t c = 0; c < n; ++c) {
      pose[c] += dq[c];
      const bool turns = static_cast<int>(c) % planar::coordinates == 2;
      if (i == 0 && !(std::abs(dq[c]) < (turns ? 0.1 : 0.1 * length))) return false;
      moved += system.mass()[c] * dq[c] * dq[c];
      size += system.mass()[c] * pose[c] * pose[c];
    }
    if (!(moved < 0.25 * last)) {
      // Converged to rounding, or not converging.
      if (!(last <= 1e-28 * size)) return false;
      break;
    }
    last = moved;
    if (moved == 0) break;
  }
  if (!(worst_open_joint(system, pose).amount <= accepted)) return false;
  q = pose;
  return true;
}

/// Length scale of a mechanism, to which errors of positions are related.
double length_scale(const System& system) {
  double scale = system.longest_arm();
  for (int k = 0; k < system.contacts(); ++k)
    scale = std::max(scale, system.contact_facts(k).ring ? system.contact_facts(k).radius_bearing : 0);
  return scale > 0 ? scale : 1;
}

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

/// Assembly of positions: from one start, and from others if that does not close or gives another
/// pose than the requested one.
class Closing {
 public:
  Closing(const Mechanism& mechanism, const System& system, const StopToken& stop)
      : mechanism_(mechanism),
        system_(system),
        stop_(stop),
        length_(length_scale(system)),
        accepted_(1e-9 * length_) {}

  /// Finds the pose nearest to q. Returns false if none was found; `best` is then the best pose
  /// that is not closed.
  bool close(std::vector<double>& q, std::vector<double>& best) const {
    if (open(q) <= 1e-14 * length_) return true;
    if (!std::isfinite(open(q))) refuse_open(mechanism_, system_, q, 0);
    const auto rough = q;
    if (move(rough, q)) return true;
    // Start from the better of two best poses: near the rough positions and near the last iterate.
    // If it is closed, try once more.
    best = rough;
    best_pose(system_, length_, true, best);
    best_pose(system_, length_, true, q);
    if (worst(q) <= worst(best)) best = q;
    q = best;
    return worst(best) < 1e-6 * length_ && move(rough, q);
  }
  /// Closes q from an arbitrary start, for which a nearest pose has no meaning.
  bool close_from(std::vector<double>& q) const {
    best_pose(system_, length_, true, q);
    if (!(worst(q) < 1e-6 * length_)) return false;
    const auto start = q;
    return open(q) <= 1e-14 * length_ || move(start, q);
  }
  double length() const { return length_; }
  /// Removes whole turns that a search added.
  void unwind_to(const std::vector<double>& given, std::vector<double>& q) const {
    const auto before = q;
    unwind(mechanism_, given, q);
    if (q != before) close_exactly(system_, q, !redundant_rows(system_, q).empty());
  }

 private:
  double open(const std::vector<double>& q) const { return worst_open_joint(system_, q).amount; }
  double worst(const std::vector<double>& q) const {
    const auto list = open_joints(system_, q, length_);
    return list.empty() ? 0 : size_of(list.front(), length_);
  }
  /// Rows that are dependent at the rough positions may be independent at the assembled ones: they
  /// are selected again once.
  bool move(const std::vector<double>& rough, std::vector<double>& q) const {
    if (step_to_nearest(system_, rough, length_, accepted_, q)) return true;
    for (int attempt = 0; attempt < 2 && !(open(q) <= accepted_); ++attempt) {
      least_movement(system_, rough, redundant_rows(system_, q), q, stop_);
      // An interior-point method keeps a distance from inactive contacts, and light bodies have
      // little weight in its tolerance.
      if (step_to_nearest(system_, rough, length_, accepted_, q)) return true;
      if (open(q) < 1e-3 * length_) close_exactly(system_, q, !redundant_rows(system_, q).empty());
    }
    return open(q) <= accepted_;
  }

  const Mechanism& mechanism_;
  const System& system_;
  const StopToken& stop_;
  double length_, accepted_;
};

/// `from` receives the start used if it is not the given one. nullptr: only the given start is
/// tried, and any pose is accepted.
void assemble_positions(const Mechanism& mechanism, const System& system, State& s, std::string* from,
                        const StopToken& stop) {
  const Closing closing(mechanism, system, stop);
  std::vector<double> best;
  const auto given = s.q;
  if (!in_mesh(mechanism, s.q))
    s.q = pose_without_teeth(mechanism, s.q, stop);
  else if (states_no_place(mechanism))
    s.q = hung(mechanism, s.q);
  const bool closed = closing.close(s.q, best);
  if (closed) closing.unwind_to(given, s.q);
  if (!from) {
    if (!closed) refuse_open(mechanism, system, best, 0);
    return;
  }
  const auto wrong = closed ? mismatch(mechanism, s.q) : Mismatch{};
  if (closed && wrong.key.empty()) return;
  const OtherStarts others(mechanism, closed ? s.q : best, closing.length());
  for (int n = 0; n < others.count(); ++n) {
    if (stop()) throw Interrupted();
    auto q = others.pose(n);
    if (!closing.close_from(q) || !mismatch(mechanism, q).key.empty()) continue;
    s.q = q;
    closing.unwind_to(given, s.q);
    *from = fmt::format("{}; assembled from initial guess {} of {}: {}",
                        closed ? fmt::format("from the given positions {}", wrong.what)
                               : "the given positions do not lead to a closed pose",
                        n + 1, others.count(), others.what(n));
    return;
  }
  if (!closed) refuse_open(mechanism, system, best, others.count());
  throw ModelError(wrong.key, fmt::format("{}, and none of {} other initial guesses leads to the requested "
                                          "pose",
                                          wrong.what, others.count()));
}

/// Key of the joint or drive of a row.
std::string key_of_row(const Mechanism& mechanism, const System& system, int row) {
  return key_of(mechanism,
                {.name = system.row_name(row), .drive = row >= system.rows() - system.drive_rows()});
}

void assemble_velocities(const Mechanism& mechanism, const System& system, State& s) {
  auto e = system.make_evaluation();
  system.place(0, s.q.data(), e);
  SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic,
                     {!redundant_rows(system, s.q).empty()});
  std::vector<double> dv(s.v.size()), lambda(e.phi.size()), r(e.phi.size());
  const auto residual = [&] {
    double worst = 0;
    int row = -1;
    for (int k = 0; k < system.rows(); ++k) {
      const auto i = k;
      r[i] = -e.phi_t[i] - row_dot(system.pattern(), e.G.data(), k, s.v.data());
      if (std::abs(r[i]) > worst) {
        worst = std::abs(r[i]);
        row = k;
      }
    }
    return std::pair{worst, row};
  };
  const double before = residual().first;
  // Scale of rounding: the size of the terms of the constraint rates.
  double terms = before;
  for (int k = 0; k < system.rows(); ++k) {
    double sum = std::abs(e.phi_t[k]);
    for (int i = system.pattern().begin[k]; i < system.pattern().begin[k + 1]; ++i)
      sum += std::abs(e.G[i] * s.v[system.pattern().column[i]]);
    terms = std::max(terms, sum);
  }
  if (!saddle.factor(e.G.data()))
    throw ModelError(
        "", "the velocities cannot be made consistent: a mass, length or speed exceeds the range of numbers");
  for (int i = 0; i < 2; ++i) {  // the second pass removes the rounding of the first
    residual();
    saddle.solve(nullptr, r.data(), dv.data(), lambda.data());
    for (std::size_t c = 0; c < s.v.size(); ++c) s.v[c] += dv[c];
  }
  const auto [worst, row] = residual();
  if (worst > 1e-9 * terms)
    throw ModelError(
        key_of_row(mechanism, system, row),
        fmt::format("no velocities satisfy all constraints; this one is violated by {:.3g} {}: the drives "
                    "contradict each other, or the start is a locked position",
                    worst, system.is_angle_row(row) ? "rad/s" : "m/s"));
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

/// Whether a drive moves although all velocities of bodies are zero, which is also their default.
bool leaves_velocities_open(const Mechanism& m) {
  const auto rests = [](const Body& b) { return b.velocity.is_zero() && b.angular_velocity == 0; };
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
    if (!b.velocity.is_zero() || b.angular_velocity != 0)
      throw ModelError("bodies." + b.name + (b.velocity.is_zero() ? ".angular_velocity" : ".velocity"),
                       "run.start = \"equilibrium\" begins at rest; remove this key, or use \"assembled\"");
  const auto found = find_equilibrium(m, system, s.q, elastic, stop);
  s = found.state;
  const bool turns = leaves_velocities_open(m);
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
    assemble_velocities(mechanism, ideal, nearest);
  } catch (const ModelError&) {
    return false;
  }
  s.v = nearest.v;
  return true;
}

}  // namespace

State assemble(const Mechanism& mechanism, RunOptions::Start start, std::string* assumed,
               const StopToken& stop) {
  return assemble(mechanism, start, assumed, stop, {});
}

State assemble(const Mechanism& mechanism, RunOptions::Start start, std::string* assumed,
               const StopToken& stop, const Compliances& elastic) {
  if (assumed) assumed->clear();
  const System system(start == RunOptions::Start::ideal ? idealised(mechanism) : mechanism);
  State s = given_state(mechanism);
  std::string from;
  if (start == RunOptions::Start::given) {
    // A loaded contact is compressed, by up to a tenth of the clearance or of a disc's radius of
    // curvature; beyond that a run's own results would be doubtful (facade/assess.cpp).
    const auto open = worst_open_joint(system, s.q, 0.1);
    if (open.amount > 1e-6 * length_scale(system))
      throw ModelError("run.start",
                       fmt::format("\"given\": {} {}; correct the positions or use \"assembled\"",
                                   key_of(mechanism, open), describe(open)));
    auto e = system.make_evaluation();
    system.place(0, s.q.data(), e);
    double speed = 0;
    for (double v : s.v) speed = std::max(speed, std::abs(v));
    for (int k = 0; k < system.rows(); ++k) {
      const double r = row_dot(system.pattern(), e.G.data(), k, s.v.data()) + e.phi_t[k];
      if (std::abs(r) > 1e-6 * std::max(speed, std::abs(e.phi_t[k])))
        throw ModelError("run.start",
                         fmt::format("\"given\": the velocities violate {} by {:.4g} {}; correct them or "
                                     "use \"assembled\"",
                                     key_of_row(mechanism, system, k), std::abs(r),
                                     system.is_angle_row(k) ? "rad/s" : "m/s"));
    }
    close_exactly(system, s.q, !redundant_rows(system, s.q).empty());
    if (const auto wrong = mismatch(mechanism, s.q); !wrong.key.empty())
      throw ModelError(wrong.key, wrong.what + "; correct the positions or use run.start = \"assembled\"");
  } else {
    assemble_positions(mechanism, system, s, &from, stop);
  }
  // Without clearances the rows alone determine the motion.
  const bool rests = start == RunOptions::Start::equilibrium;
  if (rests) settle(mechanism, system, elastic, s, assumed, stop);
  if ((start == RunOptions::Start::assembled || rests) && leaves_velocities_open(mechanism) &&
      System(idealised(mechanism)).rows() > system.rows()) {
    const bool moves = move_ideally(mechanism, s, stop);
    if (assumed && !rests)
      *assumed = moves ? "no velocity is given: the start has the velocities of the ideal mechanism"
                       : "no velocity is given, and the ideal mechanism cannot move: bodies without a "
                         "drive start at rest";
  }
  if (assumed && !from.empty()) *assumed = assumed->empty() ? from : from + "; " + *assumed;
  if (stop()) throw Interrupted();
  assemble_velocities(mechanism, system, s);
  if (!rests) s.z.assign(system.states(), 0);
  return s;
}

void start_from(Mechanism& mechanism, const State& state) {
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    auto& body = mechanism.bodies[b];
    body.position = planar::position(state.q.data(), b);
    body.angle = planar::angle(state.q.data(), b);
    body.velocity = planar::velocity(state.v.data(), b);
    body.angular_velocity = planar::rate(state.v.data(), b);
  }
}

}  // namespace freeplay
