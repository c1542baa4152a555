#include "io/scene/write_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <optional>
#include <sstream>
#include <string_view>
#include <variant>
#include <vector>

#include "dynamics/instruments.hpp"
#include "io/scene/toml_text.hpp"
#include "mechanism/scene.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

/// A name as a TOML key, without quotes if TOML permits.
std::string as_key(const std::string& name) {
  const bool bare = !name.empty() && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return bare ? name : toml_quoted(name);
}

std::string shown(Vec2 p) { return toml_numbers({p.x(), p.y()}); }

/// KeysWriter: the visitor that writes the canonical text of facts and options
/// (mechanism/keys.hpp). Keys without effect are omitted.
class KeysWriter {
 public:
  explicit KeysWriter(const Mechanism& mechanism) : mechanism_(mechanism) {}
  std::string take() { return std::move(out_); }

  void open(std::string_view table) {
    path_ = table;
    out_ += fmt::format("{}[{}]\n", out_.empty() ? "" : "\n", path_);
  }
  void open(std::string_view table, const std::string& name) {
    open(fmt::format("{}.{}", table, as_key(name)));
  }

  void raw(std::string_view key, std::string_view value) { out_ += fmt::format("{} = {}\n", key, value); }
  void text(std::string_view key, std::string_view value) { raw(key, toml_quoted(value)); }

  template <class X, class... Range>
  void need(const Key& key, const X& x, const Range&...) {
    put(key.name, x);
  }
  template <class X, class... Range>
  void take(const Key& key, const X& x, const Range&...) {
    put(key.name, x);
  }
  template <class E>
  void choose(const Key& key, E x) {
    const auto& row = at(choices(E{}), static_cast<int>(x), key.name);
    text(key.name, row.text);
  }
  template <class E>
  void choose(const Key& key, const std::optional<E>& x) {
    if (x) choose(key, *x);
  }
  void number_or(std::string_view word, const Key& key, const std::optional<double>& x, const Range&) {
    x ? put(key.name, *x) : text(key.name, word);
  }
  /// Written only if true, so that older scenes keep their canonical text.
  void flag(const Key& key, bool x) {
    if (x) put(key.name, x);
  }
  template <class E>
  void choose_other(const Key& key, E x) {
    if (static_cast<int>(x) != 0) choose(key, x);
  }
  template <class E>
  void choose_listed(const Key& key, E x) {
    choose(key, x);
  }
  template <class E, class Fits>
  void choose_some(const Key& key, const std::optional<E>& x, Fits) {
    if (x) choose(key, *x);
  }
  template <class G>
  const G* group(std::string_view, const std::optional<G>& x) const {
    return x ? &*x : nullptr;
  }
  bool when(bool holds) const { return holds; }
  bool when(bool holds, std::initializer_list<std::string_view>, const char*) const { return holds; }
  /// A key that no choice in force reads is omitted.
  template <class O>
  bool own(std::string_view name, const O& o) const {
    return own_key(o, name).read(o, name);
  }
  bool when_given(std::string_view) const { return true; }
  template <class... Pieces>
  void check(bool, std::string_view, const Pieces&...) const {}

  template <class Number>
  void either(const Key&, const Range&, double (*)(double), const Key& own, const Range&, const Number& x) {
    put(own.name, x);
  }
  void table(const Key&, const Key& points, const TorqueDrive::Table& table) { pairs(points, table); }
  void pairs(const Key& key, const TorqueDrive::Table& table) {
    if (table.empty()) return;
    std::string list;
    for (const auto& [x, y] : table) list += (list.empty() ? "" : ", ") + shown(Vec2{x, y});
    raw(key.name, fmt::format("[{}]", list));
  }
  void samples(const Key& points, const Key&, const Key&, const Curve::Points& list) {
    std::string all;
    for (const auto& [x, y] : list) all += (all.empty() ? "" : ", ") + shown(Vec2{x, y});
    raw(points.name, fmt::format("[{}]", all));
  }
  void places(const Key& list, const Key&, const Key&, const Key&, const Key&, const std::vector<Vec2>& at) {
    way(list, at);
  }
  void way(const Key& key, const std::vector<Vec2>& points) {
    std::string all;
    for (const auto& p : points) all += (all.empty() ? "" : ", ") + shown(p);
    if (!points.empty()) raw(key.name, fmt::format("[{}]", all));
  }
  void groups(const Key& key, const std::vector<int>& list) {
    std::string names;
    for (const int g : list)
      names += (names.empty() ? "" : ", ") + toml_quoted(at(mechanism_.groups, g, key.name).name);
    if (!list.empty()) raw(key.name, fmt::format("[{}]", names));
  }
  void maybe_surface(const Key& key, const std::optional<int>& index) {
    if (index) surface(key, *index);
  }
  void curve(const Key& key, int index, Curve::Use = Curve::Use::value) {
    text(key.name, at(mechanism_.curves, index, key.name).name);
  }
  void maybe_curve(const Key& key, int index, Curve::Use = Curve::Use::value) {
    if (index >= 0) curve(key, index);
  }
  void moving_joint(const Key& key, int index) { joint<RevoluteJoint>(key, index); }
  void maybe_joint(const Key& key, int index) {
    if (index >= 0) joint<RevoluteJoint>(key, index);
  }
  template <class J>
  void maybe_joint_of(const Key& key, int index) {
    if (index >= 0) joint<J>(key, index);
  }
  void joint_place(const Key& key, double place, int) { put(key.name, place); }
  void number_or_curve(const Key& key, const CurveOr& x, const Range& = any_number,
                       Curve::Use = Curve::Use::value) {
    x.curve < 0 ? put(key.name, x.constant) : curve(key, x.curve);
  }
  void length(const Key&, const Key& seconds, double x) { put(seconds.name, x); }
  void part_of_length(const Key& key, double x) { put(key.name, x); }

  void between(std::string_view, const std::array<int, 2>& pair) {
    raw("between", fmt::format("[{}, {}]", toml_quoted(body_name(pair[0], "between")),
                               toml_quoted(body_name(pair[1], "between"))));
  }
  void ends(std::string_view, const std::array<Vec2, 2>& points) {
    raw("at", fmt::format("[{}, {}]", shown(points[0]), shown(points[1])));
  }
  void points(const Key&, std::string_view, const std::vector<NamedPoint>&) const {
  }  // written where they are used
  void point_of(const Key& key, int, const Vec2& at) { put(key.name, at); }
  void angles(const Key& key, const std::vector<JointAngle>& list) {
    std::string names;
    for (const auto& angle : list) {
      std::string name;
      for (const int j : angle.joints)
        name += (name.empty() ? "" : "-") + name_of(at(mechanism_.joints, j, key.name));
      names += (names.empty() ? "" : ", ") + toml_quoted(name);
    }
    if (!list.empty()) raw(key.name, fmt::format("[{}]", names));
  }
  void axis(std::string_view, const Vec2& axis) { put("axis", axis); }
  void radii(const Key& key, const std::array<double, 2>& radii) { put(key.name, Vec2{radii[0], radii[1]}); }
  void body(const Key& key, int index) { text(key.name, body_name(index, key.name)); }
  const Surface* surface(const Key& key, int index) {
    if (index >= 0) text(key.name, at(mechanism_.surfaces, index, key.name).name);
    return nullptr;
  }
  void lubricant(const Key& key, int index, double, const std::optional<double>&) {
    if (index >= 0) text(key.name, at(mechanism_.lubricants, index, key.name).name);
  }
  void drive(const Key& key, const std::string& name) { text(key.name, name); }
  template <class J>
  const J* joint(const Key& key, int index) {
    text(key.name, name_of(at(mechanism_.joints, index, key.name)));
    return nullptr;
  }
  template <class... Kinds>
  const Joint* joint_of(const Key& key, int index) {
    const auto& joint = at(mechanism_.joints, index, key.name);
    text(key.name, name_of(joint));
    return &joint;
  }
  void from_bodies(const Key& key, const std::optional<double>& x) { put(key.name, x); }
  /// The joint by its index, or by its bodies if code gave only those.
  void any_joint(const Key& key, int index, const std::array<int, 2>& pair) {
    const auto& joints = mechanism_.joints;
    if (index < 0) {
      const auto found = std::ranges::find(joints, pair, [](const Joint& j) { return bodies_of(j); });
      if (found == joints.end())
        throw SceneError("", fmt::format("{}.{}", path_, key.name), "no joint connects the two bodies");
      index = static_cast<int>(found - joints.begin());
    }
    text(key.name, name_of(at(joints, index, key.name)));
  }
  void joint_angle(const Key& key, double angle, int) { put(key.name, angle); }

 private:
  void put(std::string_view key, double x) { raw(key, toml_number(x)); }
  void put(std::string_view key, const Vec2& x) { raw(key, shown(x)); }
  void put(std::string_view key, bool x) { raw(key, x ? "true" : "false"); }
  template <class Whole>
  requires std::is_integral_v<Whole>
  void put(std::string_view key, Whole x) { raw(key, fmt::format("{}", x)); }
  template <class X>
  void put(std::string_view key, const std::optional<X>& x) {
    if (x) put(key, *x);
  }
  template <class List>
  const typename List::value_type& at(const List& list, int index, std::string_view key) const {
    if (index < 0 || index >= static_cast<int>(list.size()))
      throw SceneError("", fmt::format("{}.{}", path_, key),
                       fmt::format("index {} is out of range; there are {}", index, list.size()));
    return list[static_cast<std::size_t>(index)];
  }
  std::string body_name(int index, std::string_view key) const {
    return index == ground ? "ground" : at(mechanism_.bodies, index, key).name;
  }

  const Mechanism& mechanism_;
  std::string path_, out_;
};

}  // namespace

std::string to_toml(const Scene& scene) {
  const auto& m = scene.mechanism;
  KeysWriter t(m);
  t.raw("format", fmt::format("{}", newest_format));
  t.text("title", m.title);
  t.need({"gravity", "", ""}, m.gravity);
  const auto write = [&](const char* table, const auto& x) {
    using X = std::decay_t<decltype(x)>;
    t.open(table, x.name);
    if constexpr (requires { X::type; }) t.text("type", X::type);
    X::keys(t, x);
  };
  const auto facts = [&](const char* table, const auto& list) {
    for (const auto& x : list) write(table, x);
  };
  const auto elements = [&](const char* table, const auto& list) {
    for (const auto& element : list) std::visit([&](const auto& x) { write(table, x); }, element);
  };
  const auto options = [&](const char* table, const auto& o) {
    t.open(table);
    std::decay_t<decltype(o)>::keys(t, o);
  };
  for (const auto& body : m.bodies)
    if (!body.of_group) write("bodies", body);
  facts("surfaces", m.surfaces);
  facts("lubricants", m.lubricants);
  facts("curves", m.curves);
  elements("joints", m.joints);
  elements("contacts", m.contacts);
  facts("groups", m.groups);
  elements("drives", m.drives);
  elements("loads", m.loads);
  if (m.assembly.asks()) options("assembly", m.assembly);
  options("run", scene.run);
  options("penalty", scene.penalty);
  // Omit a scheme that is the default choice: equal runs have equal texts.
  auto nonsmooth = scene.nonsmooth;
  nonsmooth.scheme = {};
  // Only the Moreau–Jean scheme reads the step.
  if (scene.nonsmooth.scheme_in_force() != Scheme::moreau_jean) nonsmooth.step = {};
  if (nonsmooth.scheme_in_force() != scene.nonsmooth.scheme_in_force())
    nonsmooth.scheme = scene.nonsmooth.scheme;
  options("nonsmooth", nonsmooth);
  for (const auto& i : scene.instruments) {
    t.open("instruments", i.name);
    t.choose({"type", "", ""}, i.kind);
    with_kind(i.kind, [&](auto kind) { kind.keys(t, i); });
  }
  return t.take();
}

bool same_facts(const Scene& a, const Scene& b) { return to_toml(a) == to_toml(b); }

std::vector<CanonicalLine> canonical_lines(const std::string& text) {
  std::vector<CanonicalLine> list;
  std::istringstream in(text);
  std::string line, table;
  while (std::getline(in, line)) {
    if (line.starts_with('[')) {
      table = line.substr(1, line.rfind(']') - 1);
      list.push_back({table, "", line});
    } else if (const auto equals = line.find(" = "); equals != line.npos) {
      const auto key = line.substr(0, equals);
      list.push_back({table.empty() ? key : fmt::format("{}.{}", table, key), line.substr(equals + 3), line});
    }
  }
  return list;
}

std::string first_difference(const std::string& a, const std::string& b) {
  const auto here = canonical_lines(a), there = canonical_lines(b);
  const auto [x, y] = std::ranges::mismatch(here, there, {}, &CanonicalLine::line, &CanonicalLine::line);
  const auto holds = [](const auto& lines, const std::string& key) {
    return std::ranges::find(lines, key, &CanonicalLine::key) != lines.end();
  };
  if (x != here.end() && !holds(there, x->key)) return x->key + " is missing there";
  if (y != there.end() && !holds(here, y->key)) return y->key + " is missing here";
  if (x == here.end() || y == there.end()) return "";
  if (x->key != y->key) return fmt::format("{} is before {} here and after it there", x->key, y->key);
  return fmt::format("{} is {} here and {} there", x->key, x->value, y->value);
}

}  // namespace freeplay
