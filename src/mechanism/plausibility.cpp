#include "mechanism/plausibility.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <variant>

#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

/// A mechanism with the lengths that its elements imply for each body.
struct Looked {
  const Mechanism& m;
  /// m, greatest distance of a point from the body's centre of mass; 0: none
  std::vector<double> arm;
  std::vector<double> disc;  ///< m, greatest radius in [contacts]; 0: none
  std::vector<double> size;  ///< m, the greatest of arm, disc, bearing and slider
  double longest = 0;        ///< m, greatest arm of all bodies

  explicit Looked(const Mechanism& mechanism)
      : m(mechanism), arm(mechanism.bodies.size()), disc(arm.size()), size(arm.size()) {
    const auto point = [&](int body, const Vec2& at) {
      if (body != ground) arm[body] = std::max(arm[body], at.norm());
    };
    const auto points = [&](const auto& list) {
      for (const auto& element : list)
        std::visit(
            [&](const auto& x) {
              if constexpr (requires { x.between, x.at; })
                for (const int end : {0, 1}) point(x.between[end], x.at[end]);
              if constexpr (requires { x.body, x.at; }) point(x.body, x.at);
            },
            element);
    };
    points(m.joints);
    points(m.contacts);
    points(m.loads);
    size = arm;
    const auto edge = [&](int body, double length) {
      if (body != ground) size[body] = std::max(size[body], length);
    };
    for (const auto& joint : m.joints) {
      if (const auto* r = std::get_if<RevoluteJoint>(&joint); r && r->clearance)
        for (const int body : r->between) edge(body, r->clearance->bearing_radius);
      if (const auto* t = std::get_if<TranslationalJoint>(&joint); t && t->clearance)
        edge(t->between[1], 0.5 * t->clearance->length);
    }
    for (const auto& contact : m.contacts) {
      const auto round = [&](int body, double radius) {
        if (body != ground) disc[body] = std::max(disc[body], radius);
        edge(body, radius);
      };
      if (const auto* p = std::get_if<PlaneContact>(&contact)) round(p->between[1], p->radius);
      if (const auto* c = std::get_if<CamContact>(&contact)) edge(c->between[0], c->base_radius + c->lift);
      if (const auto* o = std::get_if<OutlineContact>(&contact)) {
        round(o->between[1], o->radius);
        for (const auto& corner : o->points) edge(o->between[0], (o->at[0] + corner).norm());
      }
      if (const auto* d = std::get_if<DiscContact>(&contact))
        for (const int end : {0, 1}) round(d->between[end], d->radii[end]);
    }
    for (const auto& group : m.groups)
      for (int body = group.first; body < group.first + group.size(); ++body)
        size[body] = disc[body] = group.radius;
    for (const double a : arm) longest = std::max(longest, a);
  }
};

/// Findings of one rule: the text of the first, and their number.
class Found {
 public:
  void add(const std::string& what) {
    if (count_++ == 0) first_ = what;
  }
  std::optional<std::string> text() const {
    if (count_ == 0) return {};
    return count_ == 1 ? first_ : fmt::format("{} (and {} similar)", first_, count_ - 1);
  }

 private:
  std::string first_;
  int count_ = 0;
};

/// Angles beyond one turn that look like degrees: whole, or with at most two decimals. A start
/// taken from a run has all its digits; rounded multiples of π/2 are angles in rad.
void degrees(const Looked& l, Found& found) {
  const auto ask = [&](const std::string& key, double x) {
    const double cents = 100 * std::abs(x), quarters = std::abs(x) / (std::numbers::pi / 2);
    const bool whole = std::abs(x - std::round(x)) < 1e-9;
    if (!(std::abs(x) > 2 * std::numbers::pi) || std::abs(cents - std::round(cents)) > 1e-6) return;
    if (!whole && std::abs(quarters - std::round(quarters)) < 0.005) return;
    found.add(fmt::format("{} = {:.6g} rad is {:.3g} revolutions; {:.6g} degrees would be {:.6g}", key, x,
                          std::abs(x) / (2 * std::numbers::pi), x, x * std::numbers::pi / 180));
  };
  for (const auto& b : l.m.bodies) ask(fmt::format("bodies.{}.angle", b.name), b.angle.value_or(0));
  for (const auto& joint : l.m.joints)
    std::visit(
        [&](const auto& j) {
          if constexpr (requires { j.angle; }) ask(fmt::format("joints.{}.angle", j.name), j.angle);
        },
        joint);
  for (const auto& drive : l.m.drives)
    if (const auto* d = std::get_if<SpeedDrive>(&drive)) {
      const auto& [i, j] = bodies_of(l.m.joints[d->joint]);
      const auto angle = [&](int body) { return body == ground ? 0 : l.m.bodies[body].angle.value_or(0); };
      if (d->initial_angle != angle(j) - angle(i))  // else it follows from the bodies' angles
        ask(fmt::format("drives.{}.initial_angle", d->name), d->initial_angle);
    }
  for (const auto& load : l.m.loads)
    if (const auto* s = std::get_if<TorsionalSpringDamper>(&load))
      ask(fmt::format("loads.{}.free_angle", s->name), s->free_angle);
}

/// The softest silicones have about 1 MPa; diamond, the stiffest material, has 1.2 TPa.
void modulus(const Looked& l, Found& found) {
  for (const auto& s : l.m.surfaces) {
    if (!s.young || (*s.young >= 3e5 && *s.young <= 3e12)) continue;
    const double E = *s.young;
    const auto* unit = E > 3e12 ? "" : E <= 1500 ? "GPa" : "MPa";
    const double pa = E <= 1500 ? 1e9 * E : 1e6 * E;
    found.add(fmt::format("surfaces.{}.young = {:.6g} Pa is {}", s.name, E,
                          *unit ? fmt::format("softer than rubber; {:.6g} {} would be {:.4g}", E, unit, pa)
                                : std::string("stiffer than diamond; steel has 2.1e11")));
  }
}

/// The radius of gyration √(J/m) of a body is comparable to its size: a rod's is 0.58 of its half
/// length.
void gyration(const Looked& l, Found& found) {
  struct Unit {
    const char* name;
    double factor;
  };
  constexpr std::array<Unit, 4> units{
      Unit{"kg cm²", 1e-4}, {"kg mm²", 1e-6}, {"g cm²", 1e-7}, {"g mm²", 1e-9}};
  for (std::size_t i = 0; i < l.arm.size(); ++i) {
    const auto& b = l.m.bodies[i];
    if (b.point) continue;
    const double k = std::sqrt(b.inertia / b.mass);
    if (!(l.arm[i] > 0) || !(k > 30 * l.size[i])) continue;
    const auto apart = [&](const Unit& u) {
      return std::abs(std::log(k * std::sqrt(u.factor) / (0.58 * l.size[i])));
    };
    const auto& unit = *std::ranges::min_element(units, {}, apart);
    found.add(
        fmt::format("bodies.{}.inertia = {:.6g} kg m²: its radius of gyration, {:.3g} m, is {:.3g} times "
                    "its longest arm; {:.6g} {} would be {:.4g}",
                    b.name, b.inertia, k, k / l.size[i], b.inertia, unit.name, b.inertia * unit.factor));
  }
}

/// Usual clearances are thousandths of the radius; a fifth is no bearing. A bearing radius ten
/// times longer than every arm is implausible.
void bearings(const Looked& l, Found& found) {
  for (const auto& joint : l.m.joints) {
    if (const auto* r = std::get_if<RevoluteJoint>(&joint); r && r->clearance) {
      const double c = r->clearance->radial, R = r->clearance->bearing_radius;
      if (c > R / 5)
        found.add(fmt::format(
            "joints.{}.clearance = {:.6g} m is {:.3g} of the bearing's radius; {:.6g} mm would be "
            "{:.4g}",
            r->name, c, c / R, c, 1e-3 * c));
      else if (l.longest > 0 && R > 10 * l.longest)
        found.add(fmt::format(
            "joints.{}.bearing_radius = {:.6g} m is {:.3g} times the longest arm; {:.6g} mm would "
            "be {:.4g}",
            r->name, R, R / l.longest, R, 1e-3 * R));
    }
    if (const auto* t = std::get_if<TranslationalJoint>(&joint); t && t->clearance) {
      const double c = t->clearance->half_play, h = t->clearance->height;
      if (c > h / 5)
        found.add(
            fmt::format("joints.{}.clearance = {:.6g} m is {:.3g} of the slider's height; {:.6g} mm would be "
                        "{:.4g}",
                        t->name, c, c / h, c, 1e-3 * c));
    }
  }
}

/// Dry metals and plastics have wear coefficients of 1e-18 to 1e-12 m²/N.
void wear(const Looked& l, Found& found) {
  const auto ask = [&](const std::string& joint, const char* key, const std::optional<double>& k) {
    if (k && *k > 1e-9)
      found.add(
          fmt::format("joints.{}.{} = {:.6g} m²/N is a thousand times that of the softest bearings; "
                      "{:.6g} mm³/(N m) would be {:.4g}",
                      joint, key, *k, *k, 1e-9 * *k));
  };
  for (const auto& joint : l.m.joints)
    if (const auto* r = std::get_if<RevoluteJoint>(&joint); r && r->clearance) {
      ask(r->name, "bearing_wear", r->clearance->bearing_wear);
      ask(r->name, "journal_wear", r->clearance->journal_wear);
    }
}

/// Lengths in mm: an arm beyond 5 m with less than 50 g/m, beyond 20 m with less than 0.2 kg/m,
/// beyond 100 m with less than 1 kg/m. A disc of less than 10 g/m² is lighter than any paper.
void millimetres(const Looked& l, Found& found) {
  for (std::size_t i = 0; i < l.arm.size(); ++i) {
    const auto& b = l.m.bodies[i];
    const double a = l.arm[i], R = l.disc[i];
    const double least = a > 100 ? 1 : a > 20 ? 0.2 : 0.05;
    const bool light = a > 5 && b.mass < least * a;
    const bool airy = R > a && R > 0.5 && b.mass < 0.01 * std::numbers::pi * R * R;
    if (light)
      found.add(fmt::format("bodies.{}: {:.4g} kg with an arm of {:.6g} m; {:.6g} mm would be {:.4g}", b.name,
                            b.mass, a, a, 1e-3 * a));
    else if (airy)
      found.add(fmt::format("bodies.{}: {:.4g} kg with a radius of {:.6g} m; {:.6g} mm would be {:.4g}",
                            b.name, b.mass, R, R, 1e-3 * R));
  }
}

/// Gravity in mm/s², cm/s² or in/s²: no machine works in a field of 300 m/s².
void gravity(const Looked& l, Found& found) {
  const double g = l.m.gravity.norm();
  if (!(g > 300)) return;
  struct Unit {
    const char* name;
    double metres;
  };
  constexpr std::array<Unit, 3> units{Unit{"mm/s²", 1e-3}, {"cm/s²", 1e-2}, {"in/s²", 0.0254}};
  const auto& unit = *std::ranges::min_element(
      units, {}, [&](const Unit& u) { return std::abs(std::log(g * u.metres / 9.80665)); });
  found.add(fmt::format("gravity of {:.6g} m/s² is {:.3g} times the Earth's; {:.6g} {} would be {:.4g}", g,
                        g / 9.80665, g, unit.name, g * unit.metres));
}

/// No crank withstands 1000 m/s at its pin: a ring of the best steel bursts at about 500 m/s,
/// √(σ/ρ).
void speeds(const Looked& l, Found& found) {
  for (const auto& drive : l.m.drives) {
    const auto* d = std::get_if<SpeedDrive>(&drive);
    if (!d) continue;
    double arm = 0;
    for (const int body : bodies_of(l.m.joints[d->joint]))
      if (body != ground) arm = std::max(arm, l.arm[body]);
    if (std::abs(d->speed) * arm > 1000)
      found.add(fmt::format(
          "drives.{}: {:.6g} rad/s at an arm of {:.4g} m are {:.3g} m/s; {:.6g} rpm would be {:.4g} "
          "rad/s",
          d->name, d->speed, arm, std::abs(d->speed) * arm, d->speed, SpeedDrive::from_rpm(d->speed)));
  }
}

/// A forgotten guide: in a driven mechanism, a body that is connected by one pin alone and has no
/// other force on it. It is pinned at its centre of mass, so that nothing turns it, or it is the
/// last link of a chain without gravity, which moves freely.
void unguided(const Looked& l, Found& found) {
  const bool driven = std::ranges::any_of(l.m.drives, [](const Drive& d) {
    return std::holds_alternative<SpeedDrive>(d) || std::holds_alternative<MotionDrive>(d);
  });
  if (!driven) return;
  std::vector<int> held(l.arm.size(), 0), acted(l.arm.size(), 0);
  const auto count = [](std::vector<int>& list, int body) {
    if (body != ground) ++list[static_cast<std::size_t>(body)];
  };
  const auto pair = [&](const auto& bodies) {
    for (const int body : bodies) count(acted, body);
  };
  for (const auto& joint : l.m.joints)
    for (const int body : bodies_of(joint)) count(held, body);
  for (const auto& contact : l.m.contacts)
    std::visit(
        [&](const auto& x) {
          if constexpr (requires { x.between; }) pair(x.between);
          if constexpr (requires { x.joint; }) pair(bodies_of(l.m.joints[static_cast<std::size_t>(x.joint)]));
        },
        contact);
  for (const auto& group : l.m.groups)
    for (int body = group.first; body < group.first + group.size(); ++body) count(acted, body);
  for (const auto& drive : l.m.drives)
    std::visit([&](const auto& d) { pair(bodies_of(l.m.joints[static_cast<std::size_t>(d.joint)])); }, drive);
  for (const auto& load : l.m.loads)
    std::visit(
        [&](const auto& x) {
          if constexpr (requires { x.between; }) pair(x.between);
          if constexpr (requires { x.body; }) count(acted, x.body);
          if constexpr (requires { x.joint; }) pair(bodies_of(l.m.joints[static_cast<std::size_t>(x.joint)]));
        },
        load);
  for (const auto& joint : l.m.joints) {
    const auto* pin = std::get_if<RevoluteJoint>(&joint);
    if (!pin) continue;
    for (const int end : {0, 1}) {
      const int body = pin->between[end], other = pin->between[1 - end];
      if (body == ground || other == ground) continue;
      const auto i = static_cast<std::size_t>(body), o = static_cast<std::size_t>(other);
      if (held[i] != 1 || acted[i] > 0) continue;
      const bool central = pin->at[end].is_zero();
      const bool flung = l.m.gravity.is_zero() && acted[o] == 0 && held[o] == 2;
      if (central || flung)
        found.add(fmt::format(
            "bodies.{} is connected by joints.{} only, {}, and has no guide: is a joint missing, such as a "
            "translational joint to the ground",
            l.m.bodies[i].name, pin->name,
            central ? "at its centre of mass" : "at the end of unguided links"));
    }
  }
}

constexpr std::array rules{degrees,     modulus, gyration, bearings, wear,
                           millimetres, gravity, speeds,   unguided};

}  // namespace

std::vector<std::string> plausibility_checks(const Mechanism& mechanism) {
  const Looked looked(mechanism);
  std::vector<std::string> list;
  for (const auto rule : rules) {
    Found found;
    rule(looked, found);
    if (const auto text = found.text()) list.push_back(*text + "?");
  }
  return list;
}

}  // namespace freeplay
