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

#include "io/scene/scene_visitor.hpp"
#include "io/scene/section.hpp"
#include "io/scene/toml_text.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

/// A name as a TOML key, without quotes if TOML permits.
std::string as_key(const std::string& name) { return is_plain_name(name) ? name : toml_quoted(name); }

std::string shown(Vec2 p) { return toml_numbers({p.x(), p.y()}); }

/// KeysWriter: the visitor that writes the canonical text of facts and options
/// (mechanism/keys.hpp). Keys without effect are omitted.
class KeysWriter : public SceneVisitor<KeysWriter> {
 public:
  explicit KeysWriter(const Mechanism& mechanism) : mechanism_(mechanism) {}
  std::string written() { return std::move(out_); }

  bool open(std::string_view table) {
    path_ = table;
    out_ += fmt::format("{}[{}]\n", out_.empty() ? "" : "\n", path_);
    return true;
  }
  void open(std::string_view table, const std::string& name) {
    open(fmt::format("{}.{}", table, as_key(name)));
  }
  void type(std::string_view word) { text("type", word); }

  void raw(std::string_view key, std::string_view value) { out_ += fmt::format("{} = {}\n", key, value); }
  void text(std::string_view key, std::string_view value) { raw(key, toml_quoted(value)); }

  void need(const Key& key, const auto& x, const auto&...) { put(key.name, x); }
  template <class E>
  void word(const Key& key, E x) {
    text(key.name, at(choices(E{}), static_cast<int>(x), key.name).text);
  }
  void number_or(std::string_view word, const Key& key, const std::optional<double>& x, const Range&) {
    x ? put(key.name, *x) : text(key.name, word);
  }
  template <class E, class Fits>
  void choose_some(const Key& key, const std::optional<E>& x, Fits) {
    if (x) choose(key, *x);
  }
  void check(bool, std::string_view, const auto&...) const {}

  void either(const Key&, const Range&, double (*)(double), const Key& own, const Range&, const auto& x) {
    put(own.name, x);
  }
  void pairs(const Key& key, const TorqueDrive::Table& table) {
    if (!table.empty()) samples(key, {}, {}, table);
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
  void rows(const Key& key, const auto&, const std::vector<std::vector<double>>& rows) {
    std::string all;
    for (const auto& row : rows) all += (all.empty() ? "" : ", ") + toml_numbers(row);
    if (!rows.empty()) raw(key.name, fmt::format("[{}]", all));
  }
  void groups(const Key& key, const std::vector<int>& list) {
    std::string names;
    for (const int g : list)
      names += (names.empty() ? "" : ", ") + toml_quoted(at(mechanism_.groups, g, key.name).name);
    if (!list.empty()) raw(key.name, fmt::format("[{}]", names));
  }
  void curve(const Key& key, int index, Curve::Use = Curve::Use::value) {
    text(key.name, at(mechanism_.curves, index, key.name).name);
  }
  void moving_joint(const Key& key, int index) { joint_of<>(key, index); }

  void between(std::string_view, const std::array<int, 2>& pair, bool free = false) {
    const auto name = [&](int body) {
      return toml_quoted(free && body == free_end ? "free" : body_name(body, "between"));
    };
    raw("between", fmt::format("[{}, {}]", name(pair[0]), name(pair[1])));
  }
  void ends(std::string_view, const std::array<Vec2, 2>& points) {
    raw("at", fmt::format("[{}, {}]", shown(points[0]), shown(points[1])));
  }
  void angles(const Key& key, const std::vector<JointAngle>& list) {
    std::string names;
    for (const auto& angle : list) {
      for (const int j : angle.joints) at(mechanism_.joints, j, key.name);
      names += (names.empty() ? "" : ", ") + toml_quoted(spelt(mechanism_, angle));
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
  void profile(const Key& key, int index) {
    if (index >= 0) text(key.name, at(mechanism_.profiles, index, key.name).name);
  }
  void drive(const Key& key, const std::string& name) { text(key.name, name); }
  void gauge(const Key& beam, const Key& place, const Instrument& i) {
    text(beam.name, i.beam);
    put(place.name, i.place);
  }
  template <class... Kinds>
  const Joint* joint_of(const Key& key, int index) {
    const auto& joint = at(mechanism_.joints, index, key.name);
    text(key.name, name_of(joint));
    return &joint;
  }
  void any_joint(const Key& key, int index, const std::array<int, 2>& pair) {
    text(key.name, name_of(joint_at(mechanism_.joints, index, pair, key.name)));
  }

 private:
  void put(std::string_view key, double x) { raw(key, toml_number(x)); }
  void put(std::string_view key, const Vec2& x) { raw(key, shown(x)); }
  void put(std::string_view key, const std::string& x) { text(key, x); }
  void put(std::string_view key, bool x) { raw(key, x ? "true" : "false"); }
  template <class Whole>
  requires std::is_integral_v<Whole>
  void put(std::string_view key, Whole x) { raw(key, fmt::format("{}", x)); }
  template <class X>
  void put(std::string_view key, const std::optional<X>& x) {
    if (x) put(key, *x);
  }
  std::string body_name(int index, std::string_view key) const {
    return index == ground ? "ground" : at(mechanism_.bodies, index, key).name;
  }

  const Mechanism& mechanism_;
  std::string out_;
};

}  // namespace

std::string to_toml(const Scene& scene) {
  KeysWriter t(scene.mechanism);
  t.raw("format", fmt::format("{}", newest_format));
  t.text("title", scene.mechanism.title);
  each_section(t, scene);
  return t.written();
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
