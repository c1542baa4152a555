#include "plots/tables/clearance_joints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mechanism/scene.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

constexpr long path_points = 20'000;  ///< of a path; of more rows every n-th point is plotted
constexpr long judged_rows = 5000;

/// Suffixes of the contact names of guides and slots, in pairs of lower and upper wall.
constexpr std::array guide_pairs{std::pair{".rear_lower", ".rear_upper"},
                                 std::pair{".front_lower", ".front_upper"}};
constexpr std::array slot_pairs{std::pair{".right", ".left"}};

std::vector<std::pair<std::string, std::string>> pairs_of(const ClearanceJoint& joint) {
  std::vector<std::pair<std::string, std::string>> list;
  if (joint.kind == ClearanceJoint::Kind::guide)
    for (const auto& [low, high] : guide_pairs) list.emplace_back(joint.name + low, joint.name + high);
  if (joint.kind == ClearanceJoint::Kind::slot)
    for (const auto& [low, high] : slot_pairs) list.emplace_back(joint.name + low, joint.name + high);
  return list;
}

/// Whether a contact is that of a journal if no scene is available: gap + eccentricity is then
/// constant in all rows.
bool runs_round(const std::filesystem::path& file, const std::string& name) {
  Rows rows(file);
  const auto x = rows.place(name + ".ex"), y = rows.place(name + ".ey"), gap = rows.place(name + ".gap");
  double least = INFINITY, most = -INFINITY;
  long seen = 0;
  for (; seen < judged_rows && rows.next(); ++seen) {
    const double sum = rows.number(gap) + std::hypot(rows.number(x), rows.number(y));
    least = std::min(least, sum);
    most = std::max(most, sum);
  }
  return seen > 1 && most - least <= 1e-9 * most;
}

const Joint* find(const Scene* scene, const std::string& name) {
  if (!scene) return nullptr;
  const auto& list = scene->mechanism.joints;
  const auto it = std::ranges::find(list, name, [](const Joint& j) { return name_of(j); });
  return it == list.end() ? nullptr : &*it;
}

/// Sets the frame of a guide or a slot, if the scene is available.
void take_frame(ClearanceJoint& joint, const Scene* scene) {
  const auto* known = find(scene, joint.name);
  if (!known) return;
  std::visit(
      [&](const auto& j) {
        if constexpr (requires { j.axis; }) {
          joint.frame = j.between[0];
          joint.axis[0] = j.axis.x();
          joint.axis[1] = j.axis.y();
          joint.frame_name = joint.frame == ground ? "the ground" : scene->mechanism.bodies[joint.frame].name;
        }
      },
      *known);
}

/// Columns of one joint, and the position within its clearance computed from a row.
class Places {
 public:
  Places(const Rows& rows, const ClearanceJoint& joint, const Scene* scene) : joint_(joint) {
    const auto contact = [&](const std::string& name) {
      return Contact{rows.place(name + ".ex"), rows.place(name + ".ey"), rows.place(name + ".gap")};
    };
    if (joint.kind == ClearanceJoint::Kind::journal) contacts_.push_back(contact(joint.name));
    for (const auto& [low, high] : pairs_of(joint)) {
      contacts_.push_back(contact(low));
      contacts_.push_back(contact(high));
    }
    t_ = rows.place("t");
    if (joint.frame >= 0 && scene) {
      angle_ = rows.place(joint.frame_name + ".theta");
      turns_ = true;
    }
  }

  /// Adds a row to the blocks of the path, and updates clearance and range.
  void take(const Rows& rows, PlayPath& path, long& seen) const {
    if (joint_.kind == ClearanceJoint::Kind::journal) {
      const auto& p = contacts_.front();
      const double x = rows.number(p.x), y = rows.number(p.y), c = rows.number(p.gap) + std::hypot(x, y);
      add(path, 0, x / c, y / c, x / c, y / c);
      path.clearance += (c - path.clearance) / static_cast<double>(++seen);
      return;
    }
    const double s = along(rows);
    if (seen == 0) path.low = path.high = s;
    path.low = std::min(path.low, s);
    path.high = std::max(path.high, s);
    ++seen;
    for (std::size_t k = 0; k < path.blocks.size(); ++k) {
      const double low = rows.number(contacts_[2 * k].gap), high = rows.number(contacts_[2 * k + 1].gap);
      const double c = 0.5 * (low + high);
      add(path, k, s, 0.5 * (low - high) / c, 1e-3 * s / c, 0.5 * (low - high) / c);
      if (k == 0) path.clearance += (c - path.clearance) / static_cast<double>(seen);
    }
  }

 private:
  struct Contact {
    std::size_t x, y, gap;
  };

  /// Adds a point of part k. Its position in clearances (u, v) decides whether the path is a point.
  void add(PlayPath& path, std::size_t k, double x, double y, double u, double v) const {
    if (path.blocks[k].empty()) path.first[k] = {u, v};
    if (std::hypot(u - path.first[k][0], v - path.first[k][1]) > 1e-3) path.fixed[k] = false;
    path.blocks[k].row({x, y});
  }

  /// Position along the walls of the middle of the slider or of the pin (mm); without a frame the
  /// time (ms).
  double along(const Rows& rows) const {
    if (joint_.axis[0] == 0 && joint_.axis[1] == 0) return 1e3 * rows.number(t_);
    double ex = 0, ey = 0;
    for (const auto& c : contacts_) ex += rows.number(c.x), ey += rows.number(c.y);
    const double angle = turns_ ? rows.number(angle_) : 0;
    const double x = std::cos(angle) * joint_.axis[0] - std::sin(angle) * joint_.axis[1],
                 y = std::sin(angle) * joint_.axis[0] + std::cos(angle) * joint_.axis[1];
    return 1e3 * (ex * x + ey * y) / static_cast<double>(contacts_.size());
  }

  const ClearanceJoint& joint_;
  std::vector<Contact> contacts_;
  std::size_t t_ = 0, angle_ = 0;
  bool turns_ = false;
};

}  // namespace

std::vector<ClearanceJoint> clearance_joints(const std::filesystem::path& run, const Scene* scene) {
  const auto file = run / "trajectory.csv";
  const Rows rows(file);
  std::vector<ClearanceJoint> list;
  const auto has_all = [&](const ClearanceJoint& joint) {
    return std::ranges::all_of(pairs_of(joint), [&](const auto& pair) {
      return rows.has(pair.first + ".gap") && rows.has(pair.second + ".gap");
    });
  };
  for (const auto& column : rows.names()) {
    if (!column.ends_with(".gap")) continue;
    const auto name = column.substr(0, column.size() - 4);
    const auto base = name.substr(0, name.rfind('.'));
    ClearanceJoint joint{ClearanceJoint::Kind::journal, name, -1, {}, {}};
    if (base != name && std::ranges::none_of(list, [&](const auto& j) { return j.name == base; })) {
      for (const auto kind : {ClearanceJoint::Kind::guide, ClearanceJoint::Kind::slot})
        if (ClearanceJoint walls{kind, base, -1, {}, {}}; has_all(walls) && name == pairs_of(walls)[0].first)
          joint = walls;
    }
    if (joint.kind == ClearanceJoint::Kind::journal) {
      const auto* known = find(scene, name);
      if (scene ? !known || !std::holds_alternative<RevoluteJoint>(*known) : !runs_round(file, name))
        continue;
    } else {
      take_frame(joint, scene);
    }
    list.push_back(joint);
  }
  return list;
}

std::vector<std::vector<PlayPath>> play_paths(const std::filesystem::path& run,
                                              const std::vector<ClearanceJoint>& joints,
                                              const std::vector<Span>& spans) {
  const auto file = run / "trajectory.csv";
  const auto scene = scene_of_run(run);
  std::vector<long> rows_of(spans.size(), 0);
  const auto each = [&](const auto& f) {
    Rows rows(file);
    const auto t = rows.place("t");
    while (rows.next())
      for (std::size_t k = 0; k < spans.size(); ++k)
        if (spans[k].holds(rows.number(t))) f(rows, k);
  };
  each([&](const Rows&, std::size_t k) { ++rows_of[k]; });
  std::vector<std::vector<PlayPath>> paths(joints.size(), std::vector<PlayPath>(spans.size()));
  std::vector<Places> places;
  const Rows header(file);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    places.emplace_back(header, joints[j], scene.get());
    const bool guide = joints[j].kind == ClearanceJoint::Kind::guide;
    for (std::size_t k = 0; k < spans.size(); ++k)
      for (const char* part : guide ? std::vector{": rear end", ": front end"} : std::vector{""})
        paths[j][k].blocks.emplace_back(fmt::format(
            "{}{}, {}: {}", joints[j].name, part, spans[k].name,
            joints[j].kind == ClearanceJoint::Kind::journal ? "e_x/c, e_y/c" : "along (mm), across/c"));
    for (auto& path : paths[j]) {
      path.fixed.assign(path.blocks.size(), true);
      path.first.resize(path.blocks.size());
    }
  }
  std::vector<std::vector<long>> seen(joints.size(), std::vector<long>(spans.size(), 0));
  std::vector<long> count(spans.size(), 0);
  each([&](const Rows& rows, std::size_t k) {
    if (count[k]++ % (1 + rows_of[k] / path_points) != 0) return;
    for (std::size_t j = 0; j < joints.size(); ++j) places[j].take(rows, paths[j][k], seen[j][k]);
  });
  return paths;
}

}  // namespace freeplay::plots
