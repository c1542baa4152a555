#include "io/scene/check_scene.hpp"

#include <set>

#include "dynamics/assembly/meshing.hpp"
#include "dynamics/point_bodies.hpp"
#include "io/files/escaping.hpp"
#include "io/scene/key_rules.hpp"
#include "io/scene/scene_visitor.hpp"
#include "io/scene/section.hpp"
#include "mechanism/magnitude.hpp"
#include "simulation/bearing_load.hpp"
#include "simulation/bearing_pressure.hpp"

namespace freeplay {
namespace {

/// KeysCheck: the visitor that checks facts and options (mechanism/keys.hpp).
class KeysCheck : public SceneVisitor<KeysCheck>, private KeyRules {
 public:
  explicit KeysCheck(const Mechanism& mechanism) : KeyRules(mechanism) {}

  bool open(std::string_view table) {
    path_ = pattern_ = table;
    return table != "run";
  }
  void open(std::string_view table, const std::string& name) {
    path_ = name.empty() ? table : fmt::format("{}.{}", table, visible(name));
    pattern_ = fmt::format("{}.*", table);
    if (const auto wrong = wrong_name(name); !wrong.empty()) fail("", wrong);
    if (!opened_.insert(path_).second) fail("", "is defined twice");
    groups_opened_ += table == "groups" ? 1 : 0;
  }
  void type(std::string_view) const {}
  void title(std::string_view text) const {
    for (std::size_t length = 0; !text.empty(); text.remove_prefix(length))
      if (length = character_length(text); length == 0) fail("title", "is not UTF-8");
  }

  template <class X>
  void need(const Key& key, const X& x, const Range& range = any_number) const {
    if constexpr (requires { x.has_value(); }) {
      if (x) need(key, *x, range);
    } else if constexpr (std::is_same_v<X, Vec2>) {
      numbers(key, {x.x(), x.y()});
    } else if constexpr (std::is_arithmetic_v<X> && !std::is_same_v<X, bool>) {
      numbers(key, {static_cast<double>(x)}, range);
    }
  }
  void number_or(std::string_view, const Key& key, const std::optional<double>& x, const Range& range) const {
    need(key, x, range);
  }
  template <class E>
  void word(const Key& key, E x) const {
    at(choices(E{}), static_cast<int>(x), key.name);
  }
  template <class E, class Fits>
  void choose_some(const Key& key, const std::optional<E>& x, Fits fits) {
    choose(key, x);
    if (x && !fits(*x)) fail(key.name, unknown_word(text_of(*x), words<E>(fits)));
  }
  void check(bool holds, std::string_view name, const auto&... pieces) const {
    if (!holds) fail(name, joined_pieces(pieces...));
  }

  void either(const Key& other, const Range&, double (*)(double), const Key& own, const Range& range,
              const auto& x) const {
    if constexpr (requires { x.has_value(); })
      if (!x) fail("", exactly_one(other, own));
    need(own, x, range);
  }
  void pairs(const Key& key, const TorqueDrive::Table& table) const {
    all(key, table);
    increasing(key.name, table);
  }
  void samples(const Key& points, const Key&, const Key&, const Curve::Points& list) const {
    all(points, list);
    sampled(points.name, list);
  }
  void places(const Key& list, const Key& grid, const Key&, const Key&, const Key&,
              const std::vector<Vec2>& places) const {
    if (places.empty()) fail("", exactly_one(list, grid));
    all(list, places);
    bounded(list.name, places.size());
  }
  void way(const Key& key, const std::vector<Vec2>& points) const {
    all(key, points);
    if (!points.empty()) wall(key.name, points);
  }
  void rows(const Key& key, const auto&, const std::vector<std::vector<double>>& rows) const {
    for (const auto& row : rows) numbers(key, row);
  }
  void groups(const Key& key, const std::vector<int>& list) const {
    std::vector<int> touched;
    for (const int g : list)
      touch(key.name, std::span(mechanism_.groups).first(groups_opened_ - 1),
            at(mechanism_.groups, g, key.name).name, touched);
  }
  void curve(const Key& key, int index, Curve::Use use = Curve::Use::value) const {
    at(mechanism_.curves, index, key.name);
    usable(key.name, index, use);
  }
  void between(std::string_view, const std::array<int, 2>& pair, bool free = false) const {
    for (const int body : pair)
      if (!free || body != free_end)
        known_body("between", body);
      else if (!is_free("free"))
        fail("between", "cannot have a free end: a body has the name \"free\"");
    differ(pair);
  }
  void ends(std::string_view, const std::array<Vec2, 2>& points) const { all({"at", "m", ""}, points); }
  void angles(const Key& key, const std::vector<JointAngle>& list) const {
    for (const auto& one : list) {
      for (const int j : one.joints) at(mechanism_.joints, j, key.name);
      angle(key.name, spelt(mechanism_, one));
    }
  }
  void axis(std::string_view, const Vec2& axis) const {
    need({"axis", "", ""}, axis);
    not_zero(axis);
  }
  void radii(const Key& key, const std::array<double, 2>& radii) const {
    numbers(key, {radii[0], radii[1]});
    two_lengths(key.name, radii[0], radii[1]);
  }
  void body(const Key& key, int index) const {
    known_body(key.name, index);
    moving_body(key.name, index);
  }
  const Surface* surface(const Key& key, int index) const {
    if (index < 0) fail(key.name, fmt::format("is missing: {}", key.meaning));
    return &at(mechanism_.surfaces, index, key.name);
  }
  void lubricant(const Key& key, int index, double clearance,
                 const std::optional<double>& bearing_length) const {
    if (index < 0) return;
    at(mechanism_.lubricants, index, key.name);
    film(key.name, index, clearance, bearing_length);
  }
  void profile(const Key& key, int index) const {
    if (index >= 0) at(mechanism_.profiles, index, key.name);
  }
  void drive(const Key& key, const std::string& name) const { known_drive(key.name, name); }
  void gauge(const Key& beam, const Key& place, const Instrument& i) const {
    need(place, i.place, non_negative);
    on_beam(place.name, gauged(beam.name, i.beam), i.place);
  }
  template <class... Kinds>
  const Joint* joint_of(const Key& key, int index) const {
    at(mechanism_.joints, index, key.name);
    return &of_kind<Kinds...>(key.name, index);
  }
  void moving_joint(const Key& key, int index) const {
    moving(key.name, at(mechanism_.joints, index, key.name));
  }
  using KeyRules::grounded;
  void any_joint(const Key& key, int index, const std::array<int, 2>& pair) const {
    joint_at(mechanism_.joints, index, pair, key.name);
  }

 private:
  void refuse(std::string_view key, const std::string& message) const override {
    const char* dot = path_.empty() || key.empty() ? "" : ".";
    throw ModelError(fmt::format("{}{}{}", path_, dot, key), message);
  }
  void numbers(const Key& key, const std::vector<double>& list, const Range& range = any_number) const {
    const auto* row =
        scene_schema().find(fmt::format("{}{}{}", pattern_, pattern_.empty() ? "" : ".", key.name));
    const auto* bounds = row ? magnitude_of(row->unit) : nullptr;
    for (const double x : list)
      if (const auto wrong = wrong_number(x, range, bounds); !wrong.empty()) fail(key.name, wrong);
  }
  /// All numbers of a list of points or pairs.
  void all(const Key& key, const auto& list) const {
    std::vector<double> flat;
    for (const auto& p : list)
      if constexpr (requires { p.first; })
        flat.insert(flat.end(), {p.first, p.second});
      else
        flat.insert(flat.end(), {p.x(), p.y()});
    numbers(key, flat);
  }
  /// The ground, a body of the scene, or a disc that a group makes.
  void known_body(std::string_view key, int index) const {
    if (index == ground) return;
    const auto& body = at(mechanism_.bodies, index, key);
    const auto makes = [&](const Group& g) {
      for (int n = 1; n <= g.size(); ++n)
        if (g.body_name(n) == body.name) return true;
      return false;
    };
    const auto divides = [&](const Beam& beam) {
      for (int n = 0; n < beam.elements; ++n)
        if (beam.piece_name(n + 1) == body.name) return true;
      return false;
    };
    if (body.made && std::ranges::none_of(mechanism_.groups, makes) &&
        std::ranges::none_of(mechanism_.beams, divides))
      fail(key, fmt::format("there is no body {}", toml_quoted(body.name)));
  }

  std::string pattern_;  // of the open table in the schema
  std::set<std::string> opened_;
  std::size_t groups_opened_ = 0;
};

/// The facts of a drive that decide whether others may act on its joint.
struct Driven {
  int joint;
  bool controlled, prescribed, counts;
};

Driven driven(const Drive& drive) {
  return std::visit(
      []<class D>(const D& d) -> Driven {
        Driven is{d.joint, std::is_base_of_v<ControlLaw, D>,
                  std::is_same_v<D, SpeedDrive> || std::is_same_v<D, MotionDrive>, false};
        if constexpr (requires { d.crank; }) is.counts = d.crank;
        return is;
      },
      drive);
}

/// A controller shares its joint with no prescribed motion and no other controller; one drive may
/// count the revolutions.
void check_drives(const Mechanism& m) {
  const Drive* crank = nullptr;
  for (std::size_t k = 0; k < m.drives.size(); ++k) {
    const auto last = driven(m.drives[k]);
    const auto path = "drives." + name_of(m.drives[k]);
    for (std::size_t i = 0; i < k; ++i) {
      const auto other = driven(m.drives[i]);
      if (other.joint == last.joint && ((last.controlled && (other.controlled || other.prescribed)) ||
                                        (other.controlled && last.prescribed)))
        throw ModelError(
            path + ".joint",
            fmt::format("\"{}\" is driven by drives.{} already; a controller shares its joint "
                        "with no prescribed motion and no other controller",
                        name_of(m.joints[static_cast<std::size_t>(last.joint)]), name_of(m.drives[i])));
    }
    if (!last.counts) continue;
    if (const auto* motion = std::get_if<MotionDrive>(&m.drives[k]); motion && motion->slides(m))
      throw ModelError(path + ".crank",
                       "needs a revolute joint, whose revolutions are counted; a translational joint has no "
                       "angle");
    if (crank)
      throw ModelError(
          path + ".crank",
          fmt::format("drives.{} already counts the revolutions; only one drive may", name_of(*crank)));
    crank = &m.drives[k];
  }
}

/// Names of columns and events are unique.
void check_names(const Mechanism& m) {
  std::set<std::string> bodies, joints;
  for (const auto& body : m.bodies)
    if (!body.made) bodies.insert(body.name);
  for (const auto& joint : m.joints) joints.insert(name_of(joint));
  for (const auto& group : m.groups)
    for (int n = 1; n <= group.size(); ++n)
      if (const auto name = group.body_name(n); bodies.contains(name))
        throw ModelError("groups." + group.name,
                         fmt::format("its disc {} has the same name as bodies.{}", n, name));
  for (const auto& contact : m.contacts)
    if (joints.contains(name_of(contact)))
      throw ModelError("contacts." + name_of(contact),
                       "a joint has the same name, so events would be ambiguous; rename one");
}

}  // namespace

void check_elements_together(const Scene& scene) {
  const auto& m = scene.mechanism;
  check_names(m);
  check_drives(m);
  for (const auto& i : scene.instruments) {
    if (i.kind != Instrument::Kind::encoder) continue;
    for (const int body : i.joint < 0 ? i.pair : bodies_of(m.joints[static_cast<std::size_t>(i.joint)]))
      if (body != ground && m.bodies[static_cast<std::size_t>(body)].point)
        throw ModelError("instruments." + i.name + ".joint",
                         "has no angle, since one of its bodies is a point body");
  }
  check_point_bodies(m);
  for (const auto& joint : m.joints)
    if (const auto* pin = std::get_if<RevoluteJoint>(&joint)) (void)out_of_round(m, *pin);
  for (const auto k : observed_bearings(scene)) (void)foundation_of(m, std::get<RevoluteJoint>(m.joints[k]));
}

void check_scene(const Scene& scene) try {
  const auto& m = scene.mechanism;
  KeysCheck check(m);
  check.title(m.title);
  each_section(check, scene);
  if (m.groups.empty() && m.beams.empty() && std::ranges::all_of(m.bodies, &Body::made))
    throw ModelError("bodies", no_bodies);
  check_elements_together(scene);
  auto meshed = m;
  set_phases(meshed);
} catch (const SceneError& e) {
  // without a position in a text that the caller did not write
  throw ModelError(e.key, e.message);
}

}  // namespace freeplay
