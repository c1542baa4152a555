#include "io/write_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <sstream>
#include <string_view>
#include <variant>
#include <vector>

#include "io/toml_value.hpp"

namespace freeplay {
namespace {

/// A name as a key: bare where TOML lets it.
std::string as_key(const std::string& name) {
  const bool bare = !name.empty() && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return bare ? name : toml_quoted(name);
}

std::string shown(Vec2 p) { return toml_numbers({p.x(), p.y()}); }

class SceneText {
 public:
  explicit SceneText(const Mechanism& mechanism) : mechanism_(mechanism) {}
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
  void number(std::string_view key, double value) { raw(key, toml_number(value)); }
  void number(std::string_view key, const std::optional<double>& value) {
    if (value) number(key, *value);
  }
  void whole(std::string_view key, long long value) { raw(key, fmt::format("{}", value)); }
  void flag(std::string_view key, bool value) { raw(key, value ? "true" : "false"); }
  void point(std::string_view key, Vec2 value) { raw(key, shown(value)); }
  template <class Choice>
  void choice(std::string_view key, Choice value, const std::vector<std::string>& names) {
    text(key, at(names, static_cast<int>(value), key));
  }

  void between(const std::array<int, 2>& pair) {
    raw("between", fmt::format("[{}, {}]", toml_quoted(body_name(pair[0], "between")),
                               toml_quoted(body_name(pair[1], "between"))));
  }
  void ends(const std::array<Vec2, 2>& points) {
    raw("at", fmt::format("[{}, {}]", shown(points[0]), shown(points[1])));
  }
  void body(int index) { text("body", body_name(index, "body")); }
  void joint(int index) { text("joint", name_of(at(mechanism_.joints, index, "joint"))); }
  void joint_between(const std::array<int, 2>& pair) {
    const auto found =
        std::ranges::find(mechanism_.joints, pair, [](const Joint& j) { return bodies_of(j); });
    if (found == mechanism_.joints.end())
      throw SceneError(fmt::format("{}.joint: no joint connects the two bodies", path_));
    text("joint", name_of(*found));
  }
  void surface(int index) {
    if (index >= 0) text("surface", at(mechanism_.surfaces, index, "surface").name);
  }
  void lubricant(int index) {
    if (index >= 0) text("lubricant", at(mechanism_.lubricants, index, "lubricant").name);
  }

 private:
  template <class Item>
  const Item& at(const std::vector<Item>& list, int index, std::string_view key) const {
    if (index < 0 || index >= static_cast<int>(list.size()))
      throw SceneError(
          fmt::format("{}.{}: index {} names nothing; there are {}", path_, key, index, list.size()));
    return list[static_cast<std::size_t>(index)];
  }
  std::string body_name(int index, std::string_view key) const {
    return index == ground ? "ground" : at(mechanism_.bodies, index, key).name;
  }

  const Mechanism& mechanism_;
  std::string path_, out_;
};

void write(SceneText& t, const Body& b) {
  t.open("bodies", b.name);
  t.number("mass", b.mass);
  t.number("inertia", b.inertia);
  t.point("position", b.position);
  t.number("angle", b.angle);
  t.point("velocity", b.velocity);
  t.number("angular_velocity", b.angular_velocity);
}

void write(SceneText& t, const Surface& s) {
  t.open("surfaces", s.name);
  t.number("young", s.young);
  t.number("poisson", s.poisson);
  t.number("restitution", s.restitution);
  t.number("friction", s.friction);
  t.number("tangential_restitution", s.tangential_restitution);
}

void write(SceneText& t, const Lubricant& l) {
  t.open("lubricants", l.name);
  t.number("viscosity", l.viscosity);
  t.choice("film", l.film, {"short", "long"});
  t.text("cavitation", l.cavitation ? "half-sommerfeld" : "none");
  t.number("hand_over", l.hand_over);
}

void write(SceneText& t, const RevoluteJoint& j) {
  t.open("joints", j.name);
  t.text("type", "revolute");
  t.between(j.between);
  t.ends(j.at);
  if (!j.clearance) return;
  t.number("clearance", j.clearance->radial);
  t.number("bearing_radius", j.clearance->bearing_radius);
  t.number("bearing_length", j.clearance->bearing_length);
  t.lubricant(j.clearance->lubricant);
  t.surface(j.clearance->surface);
}

void write(SceneText& t, const TranslationalJoint& j) {
  t.open("joints", j.name);
  t.text("type", "translational");
  t.between(j.between);
  t.ends(j.at);
  t.point("axis", j.axis);
  t.number("angle", j.angle);
  if (!j.clearance) return;
  t.number("clearance", j.clearance->half_play);
  t.number("slider_length", j.clearance->length);
  t.number("slider_height", j.clearance->height);
  t.number("corner_radius", j.clearance->corner_radius);
  t.surface(j.clearance->surface);
}

void write(SceneText& t, const RigidJoint& j) {
  t.open("joints", j.name);
  t.text("type", "rigid");
  t.between(j.between);
  t.ends(j.at);
  t.number("angle", j.angle);
}

void write(SceneText& t, const PlaneContact& c) {
  t.open("contacts", c.name);
  t.text("type", "plane");
  t.between(c.between);
  t.ends(c.at);
  t.point("axis", c.axis);
  t.number("radius", c.radius);
  t.surface(c.surface);
}

void write(SceneText& t, const DiscContact& c) {
  t.open("contacts", c.name);
  t.text("type", "discs");
  t.between(c.between);
  t.ends(c.at);
  t.point("radii", {c.radii[0], c.radii[1]});
  t.surface(c.surface);
}

void write(SceneText& t, const SpeedDrive& d) {
  t.open("drives", d.name);
  t.joint(d.joint);
  t.number("speed", d.speed);
  t.number("initial_angle", d.initial_angle);
}

void write(SceneText& t, const TorqueDrive& d) {
  t.open("drives", d.name);
  t.joint(d.joint);
  std::string points;
  for (const auto& [at, torque] : d.table) points += (points.empty() ? "" : ", ") + shown(Vec2{at, torque});
  t.raw("torque_table", fmt::format("[{}]", points));
  t.choice("against", d.against, {"time", "angle"});
  t.number("lag", d.lag);
}

void write(SceneText& t, const ForceLoad& l) {
  t.open("loads", l.name);
  t.text("type", "force");
  t.body(l.body);
  t.point("at", l.at);
  t.point("force", l.force);
}

void write(SceneText& t, const TorqueLoad& l) {
  t.open("loads", l.name);
  t.text("type", "torque");
  t.body(l.body);
  t.number("torque", l.torque);
}

void write(SceneText& t, const SpringDamper& l) {
  t.open("loads", l.name);
  t.text("type", "spring-damper");
  t.between(l.between);
  t.ends(l.at);
  t.number("stiffness", l.stiffness);
  t.number("damping", l.damping);
  t.number("free_length", l.free_length);
}

void write(SceneText& t, const TorsionalSpringDamper& l) {
  t.open("loads", l.name);
  t.text("type", "torsional-spring-damper");
  t.between(l.between);
  t.number("stiffness", l.stiffness);
  t.number("damping", l.damping);
  t.number("free_angle", l.free_angle);
}

void write(SceneText& t, const JointFriction& l) {
  t.open("loads", l.name);
  t.text("type", "joint-friction");
  t.joint(l.joint);
  t.number("force", l.force);
  t.number("regularisation", l.regularisation);
}

void write(SceneText& t, const RunOptions& o) {
  t.open("run");
  t.number("duration", o.duration);
  t.number("discard", o.discard);
  t.choice("start", o.start, {"assembled", "ideal", "given"});
  t.flag("eliminate", o.eliminate);
  t.flag("forces", o.forces);
  t.number("output_step", o.output_step);
}

void write(SceneText& t, const PenaltyOptions& o) {
  t.open("penalty");
  t.choice("contact", o.contact, contact_law_names);
  if (o.contact >= ContactLaw::johnson && o.damping) t.choice("damping", *o.damping, contact_law_names);
  t.number("kelvin_stiffness", o.kelvin_stiffness);
  t.number("kelvin_damping", o.kelvin_damping);
  t.choice("friction", o.friction, friction_law_names);
  t.number("friction_v0", o.friction_v0);
  t.number("friction_v1", o.friction_v1);
  t.number("friction_static", o.friction_static);
  t.number("friction_decay", o.friction_decay);
  t.number("friction_viscous", o.friction_viscous);
  t.number("bristle_stiffness", o.bristle_stiffness);
  t.number("bristle_damping", o.bristle_damping);
  t.choice("stabilisation", o.stabilisation, {"none", "baumgarte", "projection"});
  if (o.stabilisation == Stabilisation::baumgarte) {
    t.number("alpha", o.alpha);
    t.number("beta", o.beta);
  }
  t.choice("integrator", o.integrator,
           {"rk4", "dopri5", "fehlberg78", "bulirsch_stoer", "adams_bashforth_moulton", "rosenbrock4"});
  t.number("tolerance", o.tolerance);
  t.number("step", o.step);
  t.number("v0_floor", o.v0_floor);
}

void write(SceneText& t, const NonsmoothOptions& o) {
  t.open("nonsmooth");
  t.choice("scheme", o.scheme, {"moreau-jean", "event-driven"});
  t.number("step", o.step);
  t.number("tolerance", o.tolerance);
  t.choice("solver", o.solver, {"automatic", "enumeration", "lemke", "gauss-seidel", "newton"});
  t.number("lcp_tolerance", o.lcp_tolerance);
  t.choice("impact_law", o.impact_law, {"newton", "poisson", "energetic"});
}

void write(SceneText& t, const Instrument& i) {
  using Kind = Instrument::Kind;
  t.open("instruments", i.name);
  t.choice("type", i.kind, {"accelerometer", "lvdt", "encoder", "load-cell", "torque"});
  if (i.kind == Kind::encoder) t.joint_between(i.pair);
  if (i.kind == Kind::load_cell) t.joint(i.joint);
  if (i.kind == Kind::torque) t.text("drive", i.drive);
  if (i.kind == Kind::accelerometer || i.kind == Kind::lvdt) t.body(i.body);
  if (i.kind != Kind::encoder && i.kind != Kind::torque) t.point("axis", i.axis);
  if (i.kind != Kind::encoder && i.kind != Kind::lvdt) {
    t.number("bandwidth", i.bandwidth);
    t.whole("order", i.order);
  }
  t.number("sampling", i.sampling);
  t.number("noise", i.noise);
  if (i.noise) t.whole("seed", i.seed);
  t.number("range", i.range);
  t.number("resolution", i.resolution);
}

}  // namespace

std::string to_toml(const Scene& scene) {
  const auto& m = scene.mechanism;
  SceneText t(m);
  t.whole("format", newest_format);
  t.text("title", m.title);
  t.point("gravity", m.gravity);
  const auto write_all = [&](const auto& list) {
    for (const auto& item : list) write(t, item);
  };
  const auto write_kinds = [&](const auto& list) {
    for (const auto& item : list) std::visit([&](const auto& kind) { write(t, kind); }, item);
  };
  write_all(m.bodies);
  write_all(m.surfaces);
  write_all(m.lubricants);
  write_kinds(m.joints);
  write_kinds(m.contacts);
  write_kinds(m.drives);
  write_kinds(m.loads);
  write(t, scene.run);
  write(t, scene.penalty);
  write(t, scene.nonsmooth);
  write_all(scene.instruments);
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
  if (x->key != y->key) return fmt::format("{} stands before {} here and after it there", x->key, y->key);
  return fmt::format("{} is {} here and {} there", x->key, x->value, y->value);
}

}  // namespace freeplay
