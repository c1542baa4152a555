#include "io/scene/keys_reader.hpp"

#include <cmath>
#include <numbers>

#include "io/scene/points_file.hpp"
#include "io/scene/quantity.hpp"
#include "io/scene/toml_text.hpp"

namespace freeplay {
namespace {

Vec2 turned_by(double angle, const Vec2& s) {
  const double c = std::cos(angle), n = std::sin(angle);
  return {c * s.x() - n * s.y(), n * s.x() + c * s.y()};
}

/// A point of a body at its stated position and angle, 0 if absent.
Vec2 stated_point(const Mechanism& mechanism, int body, const Vec2& at) {
  if (body == ground) return at;
  const auto& b = mechanism.bodies[static_cast<std::size_t>(body)];
  return b.position.value_or(Vec2{}) + turned_by(b.angle.value_or(0), at);
}

}  // namespace

void KeysReader::one_of(const Key& a, const Key& b) const {
  const auto wrong = exactly_one(a, b);
  if (!s_.has(a.name) && !s_.has(b.name)) s_.lacks("", wrong);
  if (s_.has(a.name) && s_.has(b.name)) s_.fail("", wrong);
}

void KeysReader::table(const Key& constant, const Key& points, TorqueDrive::Table& table) {
  if (s_.has(constant.name)) return void(table.emplace_back(0.0, s_.number(constant, any_number)));
  pairs(points, table);
}

void KeysReader::pairs(const Key& key, TorqueDrive::Table& table) {
  if (!s_.has(key.name)) return;
  if (s_.is_text(key.name)) {
    table =
        read_points(s_.named_text(key.name), {}, [&](const std::string& wrong) { s_.fail(key.name, wrong); });
    if (table.empty()) s_.fail(key.name, "must have points below its header, has none");
    bounded(key.name, table.size());
  } else {
    for (const auto& p : s_.points(key)) table.emplace_back(p.x(), p.y());
  }
  increasing(key.name, table);
}

void KeysReader::places(const Key& list, const Key& grid, const Key& origin, const Key& spacing,
                        const Key& stagger, std::vector<Vec2>& places) {
  one_of(list, grid);
  if (s_.has(list.name)) {
    for (const auto* key : {&origin, &spacing, &stagger})
      if (s_.has(key->name)) s_.fail(key->name, fmt::format("belongs to {}", grid.name));
    if (s_.is_text(list.name)) {
      for (const auto& [x, y] : read_points(s_.named_text(list.name), {},
                                            [&](const std::string& wrong) { s_.fail(list.name, wrong); }))
        places.emplace_back(x, y);
    } else {
      places = s_.points(list);
    }
    if (places.empty()) s_.fail(list.name, "must have at least one point, has none");
    return bounded(list.name, places.size());
  }
  const Vec2 count = s_.point(grid), step = s_.point(spacing);
  Vec2 first{0, 0};
  double by = 0;
  take(origin, first);
  take(stagger, by, any_number);
  const auto fits = [](double x) { return x >= 1 && x <= 1e5 && x == std::floor(x); };
  if (!fits(count.x()) || !fits(count.y()))
    s_.fail(grid.name, fmt::format("must be two whole numbers from 1, [columns, rows], is [{:.6g}, {:.6g}]",
                                   count.x(), count.y()));
  bounded(grid.name, static_cast<std::size_t>(count.x() * count.y()));
  for (int row = 0; row < count.y(); ++row)
    for (int column = 0; column < count.x(); ++column)
      places.emplace_back(first.x() + column * step.x() + (row % 2 == 1 ? by : 0),
                          first.y() + row * step.y());
}

void KeysReader::way(const Key& key, std::vector<Vec2>& points) {
  if (!s_.has(key.name)) return;
  points = s_.points(key);
  wall(key.name, points);
}

void KeysReader::groups(const Key& key, std::vector<int>& list) {
  if (!s_.has(key.name)) return;
  for (const auto& name : s_.name_or_names(key.name)) touch(key.name, mechanism_.groups, name, list);
}

void KeysReader::samples(const Key& points, const Key& file, const Key& columns, Curve::Points& list) {
  one_of(points, file);
  const auto& given = s_.has(points.name) ? points : file;
  if (s_.has(points.name)) {
    if (s_.has(columns.name)) s_.fail(columns.name, fmt::format("names columns of a {}", file.name));
    for (const auto& p : s_.points(points.name)) list.emplace_back(p.x(), p.y());
  } else {
    const auto names = s_.has(columns.name) ? s_.names(columns.name) : std::vector<std::string>();
    if (!names.empty() && names.size() != 2)
      s_.fail(columns.name, fmt::format("must name two columns, those of x and y, names {}", names.size()));
    list = read_points(s_.named_text(file.name), names,
                       [&](const std::string& wrong) { s_.fail(file.name, wrong); });
  }
  sampled(given.name, list);
}

void KeysReader::curve(const Key& key, int& curve, Curve::Use use) {
  curve = named(key.name, "curve", mechanism_.curves, s_.text(key.name));
  usable(key.name, curve, use);
  named_.push_back({std::string(key.name), curve,
                    !key.unit.empty()          ? key.unit
                    : use == Curve::Use::place ? (slides_ ? "m" : "rad")
                                               : (slides_ ? "m/s" : "rad/s")});
}

void KeysReader::settle() const {
  for (const auto& assess : own_) assess();
  for (const auto& [key, index, y] : named_) {
    const auto& name = mechanism_.curves[static_cast<std::size_t>(index)].name;
    const auto hold = [&, &key = key](const char* which, std::initializer_list<std::string_view> wanted) {
      const auto* given = s_.given("curves." + name, fmt::format("of {}", which));
      if (!given || std::ranges::any_of(wanted, [&](auto unit) { return same_quantity(*given, unit); }))
        return;
      s_.fail(key, fmt::format("the {} of the curve {} is {}, must be {}", which, toml_quoted(name),
                               quantity_name(*given), quantity_name(*wanted.begin())));
    };
    hold("y", {y});
    if (follows_ || against_ == Argument::angle)
      hold("x", {"rad"});
    else if (against_ == Argument::position)
      hold("x", {"m"});
    else if (against_ == Argument::speed && y == "N")
      hold("x", {"m/s"});
    else if (against_ == Argument::speed && y == "N m")
      hold("x", {"rad/s"});
    else if (against_ == Argument::speed)
      hold("x", {"m/s", "rad/s"});
    else
      hold("x", {"s"});
  }
}

/// A text without a blank that is the name of a curve, or does not begin like a number, names a
/// curve; any other text is a number with its unit.
void KeysReader::number_or_curve(const Key& key, CurveOr& x, const Range& range, Curve::Use use) {
  const auto names_one = [&](const std::string& text) {
    return text.find(' ') == std::string::npos &&
           (!begins_with_number(text) || index_of(mechanism_.curves, text) >= 0);
  };
  if (!s_.has(key.name) || (s_.is_text(key.name) && names_one(s_.text(key.name))))
    return curve(key, x.curve, use);
  x.constant = s_.number(key, range);
}

/// In revolutions if the length of the run is; a number with its own unit is always a time.
void KeysReader::part_of_length(const Key& key, double& x) {
  x = 0;
  if (s_.is_text(key.name)) return take(Key{key.name, "s", key.meaning}, x, non_negative);
  take(key, x, non_negative);
  x *= unit_;
}

void KeysReader::unread(std::string_view key, bool laid_aside, std::string_view by, std::string_view chosen,
                        std::string_view belongs) const {
  const auto why = fmt::format("is not read with {} = \"{}\": it belongs to {}", by, chosen, belongs);
  if (laid_aside) return s_.idle(key, why);
  try {
    s_.fail(key, why + "; remove it");
  } catch (const SceneError& e) {
    throw UnreadKey(e);
  }
}

void KeysReader::length(const Key& turns, const Key& seconds, double& duration) {
  one_of(turns, seconds);
  if (!s_.has(turns.name)) return void(duration = s_.number(seconds, positive));
  const auto* drive = main_drive(mechanism_);
  if (!drive || drive->speed == 0)
    s_.fail(turns.name,
            fmt::format("needs a drive that turns at a prescribed speed; give {} (s) instead", seconds.name));
  unit_ = 2 * std::numbers::pi / std::abs(drive->speed);
  duration = s_.number(turns, positive) * unit_;
  s_.require_sense(turns.name, seconds.unit, duration);
}

int KeysReader::body_index(std::string_view key, const std::string& name) const {
  return name == "ground" ? ground : named(key, "body", mechanism_.bodies, name, {"ground"});
}

void KeysReader::between(std::string_view, std::array<int, 2>& pair, bool free) {
  const auto names = s_.names("between");
  if (names.size() != 2) s_.fail("between", fmt::format("must name two bodies, names {}", names.size()));
  const auto index = [&](const std::string& name) {
    return free && is_free(name) ? free_end : body_index("between", name);
  };
  pair = {index(names[0]), index(names[1])};
  differ(pair);
  pair_ = pair;
}

Vec2 KeysReader::named_point(std::string_view key, int body, const std::string& name) const {
  if (body == free_end) s_.fail(key, "must be [0, 0] at the free end, which is on no body");
  if (body == ground && fixed_.points.empty())
    s_.fail(key, fmt::format("{}: the ground has no named points; give its coordinates [x, y], or "
                             "[ground] with points = {{ {} = [x, y] }}",
                             toml_quoted(name), toml_quoted(name)));
  const auto& points =
      body == ground ? fixed_.points : mechanism_.bodies[static_cast<std::size_t>(body)].points;
  const auto where =
      body == ground ? "the ground" : "bodies." + mechanism_.bodies[static_cast<std::size_t>(body)].name;
  return points[static_cast<std::size_t>(named(key, "point of " + where, points, name))].at;
}

void KeysReader::point_of(const Key& key, int body, Vec2& at) {
  if (s_.is_text(key.name))
    at = named_point(key.name, body, s_.text(key.name));
  else
    take(key, at);
}

void KeysReader::points(const Key& key, std::string_view centre, std::vector<NamedPoint>& list) {
  if (!centre.empty()) list.push_back({std::string(centre), {0, 0}});
  if (!s_.has(key.name)) return;
  for (const auto& [name, at] : s_.named_points(key)) {
    if (!centre.empty() && name == centre)
      list.front().at = at;
    else
      list.push_back({name, at});
  }
  if (centre.empty()) return;
  const Vec2 from = list.front().at;
  for (auto& point : list) point.at = point.at - from;
}

void KeysReader::ends(std::string_view, std::array<Vec2, 2>& at) {
  if (!s_.has("at")) return;
  const auto points = s_.points(Key{"at", "m", {}}, [&](std::size_t end, const std::string& name) {
    if (end > 1) s_.fail("at", "must be two points, one in each body, are more");
    return named_point("at", pair_[end], name);
  });
  if (points.size() != 2)
    s_.fail("at", fmt::format("must be two points, one in each body, is {}", points.size()));
  at = {points[0], points[1]};
}

void KeysReader::beam_length(const Key& key, Beam& beam) {
  if (s_.has(key.name)) return need(key, beam.length, positive);
  const auto missing = [&](const std::string& why) { s_.lacks(key.name, "is missing: " + why); };
  for (const std::size_t end : {0, 1}) {
    if (beam.is_free(end)) missing("a beam with a free end needs it");
    if (beam.between[end] == ground) continue;
    const auto& body = mechanism_.bodies[static_cast<std::size_t>(beam.between[end])];
    if (!body.position || (!body.angle && !beam.at[end].is_zero()))
      missing(fmt::format("it does not follow from the ends, since bodies.{} states no {}", body.name,
                          body.position ? "angle" : "position"));
  }
  const auto place = [&](std::size_t end) {
    return stated_point(mechanism_, beam.between[end], beam.at[end]);
  };
  const double chord = (place(1) - place(0)).norm(), half = 0.5 * std::abs(beam.curvature) * chord;
  if (!(chord > 0)) missing("both ends are at the same place");
  if (half > 1)
    s_.fail("curvature",
            fmt::format("no such arc joins the ends, which are {:.6g} m apart; state length", chord));
  beam.length = half == 0 ? chord : chord * std::asin(half) / half;
  s_.require_sense(key.name, key.unit, beam.length);
}

void KeysReader::angles(const Key& key, std::vector<JointAngle>& list) {
  if (!s_.has(key.name)) return;
  for (const auto& text : s_.names(key.name)) list.push_back(angle(key.name, text));
}

void KeysReader::axis(std::string_view, Vec2& axis) {
  axis = {1, 0};
  take({"axis", "", ""}, axis);
  not_zero(axis);
  // Normalising a unit vector again may change it by a rounding. Keep the vector that to_toml()
  // writes.
  if (std::abs(axis.squared_norm() - 1) > 1e-15) axis = axis.direction();
}

void KeysReader::radii(const Key& key, std::array<double, 2>& radii) {
  const Vec2 both = s_.point(key);
  two_lengths(key.name, both.x(), both.y());
  radii = {both.x(), both.y()};
}

void KeysReader::body(const Key& key, int& body) {
  body = body_index(key.name, s_.text(key));
  moving_body(key.name, body);
}

const Surface* KeysReader::surface(const Key& key, int& surface) {
  surface = named(key.name, "surface", mechanism_.surfaces, s_.text(key));
  return &mechanism_.surfaces[static_cast<std::size_t>(surface)];
}

void KeysReader::lubricant(const Key& key, int& lubricant, double clearance,
                           const std::optional<double>& bearing_length) {
  if (!s_.has(key.name)) return;
  lubricant = named(key.name, "lubricant", mechanism_.lubricants, s_.text(key.name));
  film(key.name, lubricant, clearance, bearing_length);
}

void KeysReader::drive(const Key& key, std::string& drive) {
  drive = s_.text(key.name);
  known_drive(key.name, drive);
}

void KeysReader::gauge(const Key& beam, const Key& place, Instrument& i) {
  i.beam = s_.text(beam.name);
  const auto& found = gauged(beam.name, i.beam);
  need(place, i.place, non_negative);
  on_beam(place.name, found, i.place);
  const auto element = found.element(static_cast<int>(std::lround(i.place / found.piece())));
  i.element = element.name;
  i.axial = element.axial;
  i.bending = element.bending;
}

int KeysReader::joint_index(const Key& key) {
  return named(key.name, "joint", mechanism_.joints, s_.text(key));
}

void KeysReader::any_joint(const Key& key, int& joint, std::array<int, 2>& pair) {
  joint = joint_index(key);
  pair = bodies_of(mechanism_.joints[static_cast<std::size_t>(joint)]);
}

void KeysReader::moving_joint(const Key& key, int& joint) {
  joint = joint_index(key);
  const auto& found = mechanism_.joints[static_cast<std::size_t>(joint)];
  slides_ = std::holds_alternative<TranslationalJoint>(found);
  moving(key.name, found);
}

void KeysReader::joint_place(const Key& key, double& place, int joint) {
  const auto* slider = std::get_if<TranslationalJoint>(&mechanism_.joints[static_cast<std::size_t>(joint)]);
  // For other joints the unit is rad.
  if (!slider) return joint_angle(Key{key.name, "rad", key.meaning, key.fallback}, place, joint);
  const auto point = [&](std::size_t end) {
    return stated_point(mechanism_, slider->between[end], slider->at[end]);
  };
  const int first = slider->between[0];
  const auto axis =
      turned_by(first == ground ? 0 : mechanism_.bodies[static_cast<std::size_t>(first)].angle.value_or(0),
                slider->axis);
  place = dot(axis, point(1) - point(0));
  take(Key{key.name, "m", key.meaning, key.fallback}, place, any_number);
}

void KeysReader::joint_angle(const Key& key, double& angle, int joint) {
  angle = stated_angle(joint);
  take(key, angle, any_number);
}

double KeysReader::stated_angle(int joint) const {
  const auto& pair = bodies_of(mechanism_.joints[static_cast<std::size_t>(joint)]);
  const auto of = [&](int b) {
    return b == ground ? 0 : mechanism_.bodies[static_cast<std::size_t>(b)].angle.value_or(0);
  };
  return of(pair[1]) - of(pair[0]);
}

void KeysReader::ratio_offset(const Key& key, double& offset, int joint, int of, double ratio) {
  joint_place(key, offset, joint);
  if (!s_.has(key.name)) offset -= ratio * stated_angle(of);
}

}  // namespace freeplay
