#include "analysis/play/play_loads.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "analysis/play/held_drives.hpp"
#include "dynamics/assembly/closing.hpp"
#include "dynamics/assembly/equilibrium.hpp"
#include "mechanism/error.hpp"

namespace freeplay {
namespace {

/// The places within the clearances at a pose: the eccentricity over the clearance of a journal, and 1 or −1
/// for the closer one of two opposite contacts.
std::vector<Vec2> places(const System& system, const Eigen::VectorXd& q) {
  auto e = system.make_evaluation();
  system.place(0, q.data(), e);
  std::vector<Vec2> list;
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& facts = system.contact_facts(k);
    if (facts.ring) {
      list.push_back((1 / facts.clearance) * system.eccentricity(k, q.data(), e));
    } else if (k + 1 < system.contacts()) {
      const double one = system.gap(k, q.data(), e), other = system.gap(k + 1, q.data(), e);
      list.push_back({(other - one) / std::max(one + other, 1e-300), 0});
      ++k;
    }
  }
  return list;
}

Eigen::VectorXd vector_of(const std::vector<double>& q) {
  return Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size()));
}

class LoadedPoses {
 public:
  LoadedPoses(const Mechanism& mechanism, int over, const std::vector<OutputQuantity>& quantities, Play& play,
              const StopToken& stop)
      : mechanism_(mechanism), over_(over), quantities_(quantities), play_(play), stop_(stop) {}

  /// Solves position i from the pose of the last one, moved with the ideal mechanism.
  void solve(std::size_t i, bool up) {
    auto& position = play_.positions[i];
    auto& pose = up ? position.up : position.down;
    const auto fixed =
        held(mechanism_, over_, over_ >= 0 ? std::optional(position.coordinate) : std::nullopt);
    const System system(fixed);
    const Eigen::VectorXd ideal = vector_of(position.pose);
    Eigen::VectorXd start = ideal;
    if (last_) start += last_->first;
    std::vector<double> q(start.begin(), start.end()), best;
    try {
      if (!Closing(fixed, system, stop_, {system.mass()}).close(q, best))
        throw ModelError("", "the mechanism does not close from the neighbouring position");
      const auto found = find_equilibrium(fixed, system, q, {}, stop_);
      pose.q = found.state.q;
      record(system, static_forces(system, found), pose);
    } catch (const ModelError& e) {
      pose.failure = e.message;
      last_.reset();
      return;
    }
    const auto now = places(system, vector_of(pose.q));
    if (last_)
      find_jumps(system, now, play_.positions[up ? i - 1 : i + 1].coordinate, position.coordinate, up);
    last_ = std::pair<Eigen::VectorXd, std::vector<Vec2>>{vector_of(pose.q) - ideal, now};
  }
  void restart() { last_.reset(); }

 private:
  void record(const System& system, const Forces& forces, LoadedPose& pose) {
    auto e = system.make_evaluation();
    system.place(0, pose.q.data(), e);
    for (const auto& quantity : quantities_) pose.values.push_back(value_of(quantity, pose.q.data(), e));
    const auto& elements = system.report().elements;
    if (play_.reactions.empty())
      for (const auto& joint : mechanism_.joints) play_.reactions.push_back(name_of(joint));
    for (const auto& name : play_.reactions) {
      double fx = 0, fy = 0, m = 0;
      for (std::size_t i = 0; i < elements.size(); ++i)
        if (elements[i].name == name || elements[i].name.starts_with(name + "."))
          fx += forces.elements[i].fx, fy += forces.elements[i].fy, m += forces.elements[i].m;
      pose.reactions.insert(pose.reactions.end(), {fx, fy, m});
    }
  }
  void find_jumps(const System& system, const std::vector<Vec2>& now, double from, double to, bool up) {
    // A journal that changes sides moves by more than its clearance.
    std::size_t place = 0;
    for (int k = 0; k < system.contacts(); ++k, ++place) {
      const auto& facts = system.contact_facts(k);
      if (!facts.ring) ++k;
      if (place >= now.size()) return;
      if ((now[place] - last_->second[place]).norm() > 1)
        play_.jumps.push_back({facts.name.substr(0, facts.name.find('.')), from, to, up});
    }
  }

  const Mechanism& mechanism_;
  int over_;
  const std::vector<OutputQuantity>& quantities_;
  Play& play_;
  const StopToken& stop_;
  std::optional<std::pair<Eigen::VectorXd, std::vector<Vec2>>> last_;  // distance from the ideal pose, places
};

}  // namespace

void add_loaded(const Mechanism& mechanism, int over, const std::vector<OutputQuantity>& quantities,
                Play& play, const StopToken& stop) {
  play.loaded = true;
  Mechanism joints = mechanism;
  joints.contacts.clear();
  LoadedPoses poses(joints, over, quantities, play, stop);
  for (std::size_t i = 0; i < play.positions.size(); ++i) poses.solve(i, true);
  poses.restart();
  for (std::size_t i = play.positions.size(); i-- > 0;) poses.solve(i, false);
}

double lost_motion(const Play& play, std::size_t k) {
  double most = 0;
  for (const auto& p : play.positions)
    if (p.up.failure.empty() && p.down.failure.empty())
      most = std::max(most, std::abs(p.up.values[k] - p.down.values[k]));
  return most;
}

}  // namespace freeplay
