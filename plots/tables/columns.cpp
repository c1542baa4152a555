#include "plots/tables/columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "io/files/escaping.hpp"
#include "io/scene/quantity.hpp"
#include "io/scene/read_section.hpp"
#include "io/scene/schema.hpp"
#include "mechanism/piecewise.hpp"
#include "mechanism/scene.hpp"
#include "plots/tables/run_facts.hpp"
#include "plots/tables/table.hpp"
#include "simulation/section.hpp"
#include "study/settings/expression.hpp"
#include "study/settings/expression_dimension.hpp"

namespace freeplay::plots {
namespace {

constexpr std::size_t most_samples = 20'000'000;

/// Units and quantities of columns by the ends of their names. A mean has the unit of its quantity.
struct ColumnFacts {
  std::string_view end, unit;
  Word quantity, symbol;
};
constexpr ColumnFacts known_columns[] = {
    {".x", "m", "position", "x"},
    {".y", "m", "position", "y"},
    {".theta", "rad", "angle", {"θ", "$\\theta$"}},
    {".vx", "m/s", "velocity", {"v_x", "$v_x$"}},
    {".vy", "m/s", "velocity", {"v_y", "$v_y$"}},
    {".omega", "rad/s", "angular velocity", {"ω", "$\\omega$"}},
    {".ex", "m", "eccentricity", {"e_x", "$e_x$"}},
    {".ey", "m", "eccentricity", {"e_y", "$e_y$"}},
    {".gap", "m", "gap", {"g", "$g$"}},
    {".fx", "N", "force", {"F_x", "$F_x$"}},
    {".fy", "N", "force", {"F_y", "$F_y$"}},
    {".fn", "N", "normal force", {"F_N", "$F_N$"}},
    {".ft", "N", "friction force", {"F_T", "$F_T$"}},
    {".m", "N m", "moment", {"M", "$M$"}},
    {".N", "N", "normal force", {"N", "$N$"}},
    {".Q", "N", "shear force", {"Q", "$Q$"}},
    {".M", "N m", "bending moment", {"M", "$M$"}},
    {".torque", "N m", "torque", {"M", "$M$"}},
    {".power", "W", "power", {"P", "$P$"}},
    {".ax", "m/s²", "acceleration", {"a_x", "$a_x$"}},
    {".ay", "m/s²", "acceleration", {"a_y", "$a_y$"}},
    {".alpha", "rad/s²", "angular acceleration", {"α", "$\\alpha$"}},
    {".pressure", "Pa", "pressure", {"p", "$p$"}},
    {".pressure_greatest", "Pa", "greatest pressure", {"p", "$p$"}},
    {".sliding", "m", "sliding distance", {"s", "$s$"}},
    {".wear_rate", "m/s", "wear rate", ""},
    {"angle", "rad", "angle", {"φ", "$\\varphi$"}},
    {"t", "s", "time", {"t", "$t$"}},
    {"crank_angle", "rad", "crank angle", ""},
    {"v_n_minus", "m/s", "normal velocity before", {"v_N^-", "$v_N^-$"}},
    {"v_n_plus", "m/s", "normal velocity after", {"v_N^+", "$v_N^+$"}},
    {"v_t_minus", "m/s", "tangential velocity before", {"v_T^-", "$v_T^-$"}},
    {"v_t_plus", "m/s", "tangential velocity after", {"v_T^+", "$v_T^+$"}},
    {"impulse_n", "N s", "normal impulse", {"P_N", "$P_N$"}},
    {"impulse_t", "N s", "tangential impulse", {"P_T", "$P_T$"}},
    {"duration", "s", "duration", ""},
    {"t_uncertainty", "s", "uncertainty of time", ""}};

/// Further columns of sections.
constexpr ColumnFacts section_columns[] = {{".ex_c", "", "eccentricity", {"e_x/c", "$e_x/c$"}},
                                           {".ey_c", "", "eccentricity", {"e_y/c", "$e_y/c$"}},
                                           {".angle", "rad", "angle", {"θ", "$\\theta$"}},
                                           {".position", "m", "position", "s"},
                                           {".rate", "rad/s", "angular velocity", {"ω", "$\\omega$"}},
                                           {".rate", "m/s", "velocity", "v"},
                                           {"phase", "", "phase in the period", ""},
                                           {"approach", "m/s", "approach speed", {"|v_N|", "$|v_N|$"}}};

const ColumnFacts* facts_of_column(std::string_view column) {
  if (column.ends_with("_mean")) column.remove_suffix(5);
  const auto dot = column.rfind('.');
  const auto it =
      std::ranges::find(known_columns, dot == column.npos ? column : column.substr(dot), &ColumnFacts::end);
  return it == std::end(known_columns) ? nullptr : it;
}

Column column_of(const std::string& name, const std::string& file) {
  Column c{name, file, "", ""};
  if (const auto* facts = facts_of_column(name)) {
    c.unit = facts->unit;
    c.quantity = {facts->quantity, facts->symbol, name.ends_with("_mean")};
  }
  return c;
}

/// Quantity and unit of the samples of an instrument; empty for an unknown one.
struct SampleFacts {
  ColumnQuantity quantity;
  const char* unit = "";
};
SampleFacts samples_of(const Scene& scene, std::string_view name) {
  const auto it = std::ranges::find(scene.instruments, name, &Instrument::name);
  if (it == scene.instruments.end()) return {};
  switch (it->kind) {
    case Instrument::Kind::accelerometer:
      return {{"acceleration", {"a", "$a$"}}, "m/s²"};
    case Instrument::Kind::lvdt:
      return {{"displacement", ""}, "m"};
    case Instrument::Kind::encoder:
      return {{"angle", {"θ", "$\\theta$"}}, "rad"};
    case Instrument::Kind::load_cell:
      return {{"force", {"F", "$F$"}}, "N"};
    case Instrument::Kind::torque:
      return {{"torque", {"M", "$M$"}}, "N m"};
    case Instrument::Kind::strain_gauge:
      return {{"strain", {"ε", "$\\varepsilon$"}}, ""};
  }
  return {};
}

constexpr const char* angle_name = "crank_angle";
constexpr const char *signal_file = "signals.csv", *event_file = "events.csv";

}  // namespace

ColumnQuantity quantity_of_column(const std::string& column, std::string_view unit) {
  const auto dot = column.rfind('.');
  const auto end = dot == column.npos ? column : column.substr(dot);
  for (const auto& facts : section_columns)
    if (facts.end == end && (end != ".rate" || (facts.unit == "m/s") == unit.ends_with("m/s")))
      return {facts.quantity, facts.symbol};
  return column_of(column, "").quantity;
}

RunNumber number_of_run(const std::string& path) {
  constexpr std::pair<std::string_view, std::string_view> endings[] = {
      {"_rad_per_s", "rad/s"}, {"_m_per_s", "m/s"}, {"_N_s", "N s"}, {"_J", "J"}, {"_N", "N"}, {"_W", "W"},
      {"_rad", "rad"},         {"_KiB", "KiB"},     {"_Hz", "Hz"},   {"_m", "m"}, {"_s", "s"}};
  const auto dot = path.rfind('.');
  RunNumber number{dot == path.npos ? "" : path.substr(0, dot), path.substr(dot + 1), ""};
  // The unit ends the name, or that of its table.
  for (auto* text : {&number.words, &number.element})
    for (const auto& [ending, unit] : endings)
      if (number.unit.empty() && text->ends_with(ending)) {
        number.unit = unit;
        text->resize(text->size() - ending.size());
      }
  std::ranges::replace(number.words, '_', ' ');
  return number;
}

std::string_view unit_of_column(std::string_view column) {
  const auto* facts = facts_of_column(column);
  return facts ? facts->unit : "";
}

std::string Column::element() const {
  if (!channel.empty()) return name;
  const auto dot = name.rfind('.');
  return dot == name.npos ? "" : name.substr(0, dot);
}

double ColumnFormula::value(std::span<const double> values) const {
  return expression ? (*expression)(values) : values.front();
}

std::vector<std::string> columns_named(std::string_view list) {
  std::vector<std::string> names;
  int depth = 0;
  std::string name;
  const auto add = [&] {
    while (name.ends_with(' ')) name.pop_back();
    if (!name.empty()) names.push_back(std::move(name));
    name.clear();
  };
  for (const char c : list) {
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (c == ',' && depth <= 0)
      add();
    else if (c != ' ' || !name.empty())
      name += c;
  }
  add();
  return names;
}

namespace {

/// Remark for a text that names a column of forces.csv where no run has that file; else empty.
std::string without_forces(const std::string& text, const std::vector<Column>& all) {
  if (std::ranges::any_of(all, [](const Column& c) { return c.file == "forces.csv"; })) return "";
  for (const std::string_view end :
       {".torque", ".power", ".fx", ".fy", ".fn", ".ft", ".m", ".N", ".Q", ".M", ".ax", ".ay", ".alpha"})
    for (auto at = text.find(end); at != text.npos; at = text.find(end, at + 1)) {
      const auto rest = std::string_view(text).substr(at + end.size());
      if (rest.empty() || rest.starts_with("_mean") ||
          std::string_view(" +-*/^),<>=").find(rest.front()) != std::string_view::npos)
        return "; forces, torques and accelerations of bodies need a run with --forces";
    }
  return "";
}

/// Message for an unknown column: a similar name, and the list of all names.
std::string no_column(const std::string& name, const std::vector<Column>& all) {
  std::vector<std::string> names;
  for (const auto& c : all) names.push_back(c.name);
  const auto near = nearest_word(name, names);
  std::string said = fmt::format("unknown column {}", visible_brief(name, 60));
  if (const auto remark = without_forces(name, all); !remark.empty())
    said += remark;
  else if (!near.empty())
    said += fmt::format("; did you mean {}?", near);
  NamesByKind lists;
  for (const char* file : {"", "trajectory.csv", "forces.csv", signal_file, event_file}) {
    auto& list = lists.emplace_back(*file ? file : "everywhere", std::vector<std::string>()).second;
    for (const auto& c : all)
      if (c.file == file) list.push_back(c.name);
  }
  return said + listed_names(lists);
}

}  // namespace

std::string listed_names(const NamesByKind& lists) {
  std::string said;
  for (const auto& [kind, names] : lists) {
    if (names.empty()) continue;
    said += fmt::format("\n  {}:", kind);
    std::size_t width = kind.size() + 3;
    for (const auto& one : names) {
      if (width + one.size() + 1 > 78) said += "\n   ", width = 3;
      said += " " + one;
      width += one.size() + 1;
    }
  }
  return said;
}

ColumnFormula formula_of(const std::string& text, const std::vector<Column>& all) {
  if (const auto it = std::ranges::find(all, text, &Column::name); it != all.end())
    return {text, it->unit, {*it}};
  const auto is_operator = [](char c) {
    return std::string_view("()+-*/^<>=! ").find(c) != std::string_view::npos;
  };
  if (std::ranges::none_of(text, is_operator)) throw SceneError(no_column(text, all));
  std::vector<std::string> names;
  for (const auto& c : all) names.push_back(c.name);
  ColumnFormula formula{text, "", {}};
  try {
    const Expression any(text, names);
    if (any.type() != Expression::Type::number)
      throw ExpressionError(1, "is true or false; a curve needs a number");
    names.clear();
    std::vector<Dimension> dimensions;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!any.uses(i)) continue;
      formula.columns.push_back(all[i]);
      names.push_back(all[i].name);
      dimensions.push_back(dimension_of(all[i].unit).value_or(Dimension{}));
    }
    if (names.empty()) throw ExpressionError(1, "has no column");
    formula.expression = std::make_shared<const Expression>(text, names);
    formula.unit = si_unit(dimension_of(*formula.expression, dimensions));
  } catch (const ExpressionError& e) {
    throw SceneError(fmt::format("\"{}\": {}{}", visible_brief(text, 60), visible_brief(e.what(), 400),
                                 without_forces(text, all)));
  } catch (const std::invalid_argument& e) {
    throw SceneError(fmt::format("\"{}\": {}", visible_brief(text, 60), e.what()));
  }
  return formula;
}

std::string_view unit_of_instrument(const Scene& scene, std::string_view name) {
  return samples_of(scene, name).unit;
}

/// The value of `of`, or the difference of `target` and it.
struct StateFunction {
  StateColumn of;
  std::optional<Piecewise> target;  ///< against time
  /// Columns of the file, and their indices in q, then v.
  std::vector<std::pair<std::string, std::size_t>> parts;
  std::size_t size = 0;  ///< of q

  /// `state`: q, then v.
  double value(double t, std::span<const double> state) const {
    const auto q = state.first(size), v = state.subspan(size);
    const double x = of.kind == StateColumn::Kind::rate ? of.rate(q, v) : of.coordinate(q, v);
    return target ? target->value(t) - x : x;
  }
};

void add_state_functions(const Scene& scene, std::vector<Column>& all) {
  constexpr const char* file = "trajectory.csv";
  const auto& mechanism = scene.mechanism;
  std::vector<std::string> bodies;
  for (const auto& body : mechanism.bodies) bodies.push_back(body.name);
  const auto find = [&](const std::string& name) { return std::ranges::find(all, name, &Column::name); };
  const auto add = [&](const std::string& name, const std::string& unit, const ColumnQuantity& quantity,
                       const std::array<int, 2>& between, const StateColumn& of,
                       std::optional<Piecewise> target = {}) {
    if (find(name) != all.end()) return;
    StateFunction function{of, std::move(target), {}, 3 * bodies.size()};
    constexpr const char* parts[] = {".x", ".y", ".theta", ".vx", ".vy", ".omega"};
    for (const int body : between) {
      if (body == ground) continue;
      for (std::size_t k = 0; k < std::size(parts); ++k) {
        const auto b = static_cast<std::size_t>(body);
        const auto part = bodies[b] + parts[k];
        if (const auto found = find(part); found == all.end() || found->file != file) return;
        function.parts.emplace_back(part, 3 * b + k % 3 + k / 3 * function.size);
      }
    }
    all.push_back(
        {name, file, "", unit, quantity, std::make_shared<const StateFunction>(std::move(function))});
  };
  const auto coordinates = coordinate_columns(scene, bodies);
  for (const auto& joint : mechanism.joints)
    for (const char* end : {".angle", ".position", ".rate"})
      if (const auto c = std::ranges::find(coordinates, name_of(joint) + end, &NamedColumn::name);
          c != coordinates.end())
        add(c->name, c->unit, quantity_of_column(c->name, c->unit), bodies_of(joint), c->column);
  for (const auto& drive : mechanism.drives) {
    const auto add_error = [&]<class D>(const D& d) {
      if constexpr (std::is_base_of_v<ControlLaw, D>) {
        const auto& measured = mechanism.joints[static_cast<std::size_t>(d.fed_back())];
        const bool slides = std::holds_alternative<TranslationalJoint>(measured);
        const auto c = std::ranges::find(coordinates, name_of(measured) + (slides ? ".position" : ".angle"),
                                         &NamedColumn::name);
        if (c != coordinates.end())
          add(d.name + ".error", c->unit, {"control error", "e"}, bodies_of(measured), c->column,
              d.course(mechanism));
      }
    };
    std::visit(add_error, drive);
  }
}

struct RunColumns::Series {
  std::vector<double> t, v;
  std::string without_rows;  ///< the file, if it has only a header
};

RunColumns::RunColumns(const std::filesystem::path& folder) : folder_(folder), scene_(scene_of_run(folder)) {
  if (scene_)
    if (const auto* drive = main_drive(scene_->mechanism)) crank_ = {drive->initial_angle, drive->speed};
  all_.push_back(column_of("t", ""));
  if (crank_) all_.push_back(column_of(angle_name, ""));
  for (const char* file : {"trajectory.csv", "forces.csv", event_file}) {
    if (!std::filesystem::exists(folder / file)) continue;
    const Rows header(folder / file);
    for (const auto& name : header.names())
      if (name != "t" && name != angle_name && name != "joint" && name != "kind")
        all_.push_back(column_of(name, file));
  }
  if (scene_) add_state_functions(*scene_, all_);
  if (!std::filesystem::exists(folder / signal_file)) return;
  Rows rows(folder / signal_file);
  const auto channel = rows.place("channel");
  std::vector<std::string> seen;
  for (long i = 0; i < 100'000 && rows.next(); ++i) place_in(seen, rows.name(channel));
  for (const auto& name : seen) {
    const auto facts = scene_ ? samples_of(*scene_, name) : SampleFacts{};
    all_.push_back({name, signal_file, name, facts.unit, facts.quantity});
  }
}

const Column* RunColumns::find(std::string_view name) const {
  const auto it = std::ranges::find(all_, name, &Column::name);
  return it == all_.end() ? nullptr : &*it;
}

double RunColumns::crank(double t) const { return crank_->first + crank_->second * t; }

/// A column over the time of its file. A column without a file (t, crank_angle) is over the time of
/// `file`.
RunColumns::Series RunColumns::series(const Column& column, const std::string& file,
                                      const std::string& channel, double from, double to) const {
  const bool own = !column.file.empty();
  Rows rows(folder_ / (own ? column.file : file));
  const auto& wanted = own ? column.channel : channel;
  const auto t = rows.place("t");
  const auto* function = column.function.get();
  const auto v = !own || function ? t : rows.place(wanted.empty() ? column.name : "value");
  std::vector<std::pair<decltype(rows.place("t")), std::size_t>> parts;
  std::vector<double> state;
  if (function) {
    state.resize(2 * function->size);
    for (const auto& [part, index] : function->parts) parts.emplace_back(rows.place(part), index);
  }
  const auto computed = [&](double time) {
    for (const auto& [place, index] : parts) state[index] = rows.maybe_number(place);
    return function->value(time, state);
  };
  const auto name = wanted.empty() ? t : rows.place("channel");
  Series s;
  s.without_rows = (folder_ / (own ? column.file : file)).string();
  while (rows.next()) {
    s.without_rows.clear();
    if (!wanted.empty() && rows.name(name) != wanted) continue;
    if (const double time = rows.number(t); time < from || time > to) continue;
    if (s.t.size() == most_samples)
      throw SceneError(fmt::format("{}: has more than {} rows", (folder_ / file).string(), most_samples));
    s.t.push_back(rows.number(t));
    s.v.push_back(column.name == angle_name ? crank(s.t.back())
                  : function                ? computed(s.t.back())
                  : own                     ? rows.maybe_number(v)
                                            : s.t.back());
  }
  return s;
}

Points RunColumns::read(const Column& x, const Column& y, double from, double to,
                        const std::optional<Crossing>& section) const {
  return read({x.name, x.unit, {x}}, {y.name, y.unit, {y}}, from, to, section);
}

Points RunColumns::read(const ColumnFormula& x, const ColumnFormula& y, double from, double to,
                        const std::optional<Crossing>& section) const {
  std::vector<Column> columns = y.columns;
  columns.insert(columns.end(), x.columns.begin(), x.columns.end());
  const auto of_file = [](const Column& c) { return !c.file.empty(); };
  const auto found_file = std::ranges::find_if(columns, of_file);
  const Column leading = found_file == columns.end() ? Column{} : *found_file;
  const std::string file = leading.file.empty() ? "trajectory.csv" : leading.file;
  const bool of_crank = section && section->column == "crank";
  if (of_crank && !crank_) throw SceneError("--section crank: no drive of the run has a prescribed speed");
  if (section && file == event_file)
    throw SceneError("--section: does not apply to events, which are instants already");
  const std::size_t count = columns.size();
  if (section && !of_crank) {
    const auto* s = find(section->column);
    if (!s) throw SceneError("--section: " + no_column(section->column, all_));
    columns.push_back(*s);
  }
  std::vector<Series> all;
  for (const auto& c : columns) {
    all.push_back(series(c, file, leading.channel, from, to));
    if (!all.back().without_rows.empty()) return {.without_rows = all.back().without_rows};
  }
  // The rows whose t occurs in all series.
  struct JoinedRow {
    double x, y, section;
  };
  std::vector<JoinedRow> rows;
  std::vector<std::size_t> at(all.size(), 0);
  const bool events_alone = file == event_file && std::ranges::all_of(columns, [&](const Column& c) {
                              return c.file.empty() || c.file == file;
                            });
  if (file == event_file && !events_alone)
    throw SceneError(
        fmt::format("{} and {} have no rows in common: events are at separate instants", x.text, y.text));
  std::vector<double> values(columns.size());
  for (const double t : all.back().t) {
    bool found = true;
    for (std::size_t k = 0; k < all.size(); ++k) {
      while (at[k] < all[k].t.size() && all[k].t[at[k]] < t) ++at[k];
      found = found && at[k] < all[k].t.size() && all[k].t[at[k]] == t;
    }
    if (!found) continue;
    for (std::size_t k = 0; k < all.size(); ++k) values[k] = all[k].v[at[k]];
    const std::span<const double> of_y(values.data(), y.columns.size()),
        of_x(values.data() + y.columns.size(), x.columns.size());
    rows.push_back({x.value(of_x), y.value(of_y),
                    of_crank                 ? crank(t) * 180 / std::acos(-1.0)
                    : columns.size() > count ? values.back()
                                             : 0});
    if (events_alone)  // there may be several events at one instant
      for (auto& k : at) ++k;
  }
  if (rows.empty() && from == -INFINITY && to == INFINITY)
    throw SceneError(
        fmt::format("{} and {} have no rows in common: their times differ in their files", x.text, y.text));
  Points points;
  const auto add = [&](double a, double b) {
    if (std::isfinite(a) && std::isfinite(b)) points.x.push_back(a), points.y.push_back(b);
  };
  if (!section) {
    for (const auto& r : rows) add(r.x, r.y);
    return points;
  }
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    double a = rows[i].section - section->value, b = rows[i + 1].section - section->value;
    if (of_crank) {  // the angle passes the section in every turn
      const double turn = 360 * (b > a ? std::floor(b / 360) : std::ceil(b / 360));
      a -= turn, b -= turn;
    }
    const bool rises = a < 0 && b >= 0, falls = a > 0 && b <= 0;
    if (!(rises && section->sense >= 0) && !(falls && section->sense <= 0)) continue;
    const double w = a / (a - b);
    add(rows[i].x + w * (rows[i + 1].x - rows[i].x), rows[i].y + w * (rows[i + 1].y - rows[i].y));
  }
  return points;
}

}  // namespace freeplay::plots
