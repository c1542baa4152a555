#include "study/settings/study_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "io/files/digest.hpp"
#include "io/scene/keys_list.hpp"
#include "measure/turns.hpp"
#include "study/settings/expression.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

/// Limit of drawn coordinates. Sobol's table has thousands of coordinates and a database a few
/// thousand columns.
constexpr long most_drawn = 100;

/// Columns of `runs` that are neither axes nor measures (study/store/results.cpp).
constexpr const char* fixed_columns[] = {"run", "variant", "formulation", "start", "status", "reason"};

/// SQLite does not distinguish columns that differ only in case.
std::string lower(std::string text) {
  for (auto& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// The values of [low, high, n].
std::vector<double> spread(const std::vector<double>& range, bool logarithmic, const char* key, Section& s) {
  if (range.size() != 3) s.fail(key, fmt::format("must be [low, high, n], has {} numbers", range.size()));
  const double low = range[0], high = range[1], n = range[2];
  if (!(high > low)) s.fail(key, fmt::format("high must be greater than low = {}, is {}", low, high));
  if (logarithmic && low <= 0)
    s.fail(key, fmt::format("low must be greater than 0 for equal ratios, is {}", low));
  if (!study_count.holds(n) || n < 2) s.fail(key, fmt::format("n must be a whole number from 2, is {}", n));
  std::vector<double> values;
  for (int i = 0; i < static_cast<int>(n); ++i) {
    // Interpolate from both ends, so that 0.1, …, 0.9 are exactly the doubles of these decimals.
    values.push_back(logarithmic ? low * std::pow(high / low, i / (n - 1))
                                 : ((n - 1 - i) * low + i * high) / (n - 1));
  }
  values.back() = high;
  return values;
}

std::vector<std::string_view> units_of(const Axis& a) {
  std::vector<std::string_view> units{unit_of(a.key)};
  for (const auto& other : a.others) units.push_back(unit_of(other));
  return units;
}

void read_list(Axis& a, Section& s, const std::vector<std::string_view>& units) {
  const Key key{"values", units.front(), {}};
  if (!a.others.empty() && s.is_list_of_lists("values")) {
    a.other_values.resize(a.others.size());
    for (const auto& row : s.rows("values", units)) {
      if (std::ranges::count(a.values, row[0]) > 0)
        s.fail("values",
               fmt::format("{} occurs twice for {}, which identifies the cells; put a key with distinct "
                           "values first",
                           row[0], a.key));
      a.values.push_back(row[0]);
      for (std::size_t k = 0; k < a.others.size(); ++k) a.other_values[k].push_back(row[k + 1]);
    }
    return;
  }
  a.values = s.numbers(key);
}

/// Keys that share their values must have the same unit.
void require_one_unit(const Axis& a, Section& s, const std::vector<std::string_view>& units) {
  for (std::size_t k = 0; k < a.others.size(); ++k)
    if (units[k + 1] != units[0])
      s.fail("keys", fmt::format("{} is in {} and {} in {}, so one value cannot serve both; give pairs, "
                                 "values = [[a, b], ...]",
                                 a.key, units[0].empty() ? "no unit" : units[0], a.others[k],
                                 units[k + 1].empty() ? "no unit" : units[k + 1]));
}

std::vector<std::string> keys_of(const Axis& axis) {
  auto keys = axis.others;
  keys.push_back(axis.key);
  return keys;
}

/// Refuses keys that are varied and also set.
void refuse_twice_set(Section& s, const std::vector<std::string>& overrides,
                      const std::vector<std::string>& varied, const std::string& by) {
  for (const auto& o : overrides)
    if (const auto key = o.substr(0, o.find_first_of(" =")); std::ranges::count(varied, key) > 0)
      s.fail("set", fmt::format("{} is varied by {}", key, by));
}

}  // namespace

std::vector<std::string> names_of(const Study& study, bool results) {
  std::vector<std::string> names;
  for (const auto& axis : study.axes) names.push_back(axis.name);
  if (!results) return names;
  names.insert(names.end(), TurnMetrics::names().begin(), TurnMetrics::names().end());
  for (const auto& measure : study.measures) names.push_back(measure.name);
  return names;
}

std::string read_family(Section& s, std::string_view key) {
  return families[static_cast<std::size_t>(s.choice(key, family_names()))].text;
}

std::vector<std::string> read_families(Section& s, std::string_view key) {
  auto list = s.names(key);
  for (const auto& name : list)
    if (!family_named(name))
      s.fail(key, fmt::format("\"{}\" is unknown; known are \"{}\"", name,
                              fmt::join(family_names(), "\" and \"")));
  if (list.empty()) s.fail(key, "must name at least one");
  return list;
}

void read_varied(Section& s, Axis& a) {
  if (!s.has("keys")) return void(a.key = s.text("key"));
  if (s.has("key")) s.fail("keys", "and key are given; give one of them");
  a.others = s.names("keys");
  if (a.others.empty()) s.fail("keys", "must name at least one key of the scene");
  a.key = a.others.front();
  a.others.erase(a.others.begin());
}

void read_values(Section& s, Axis& a) {
  const auto units = units_of(a);
  constexpr const char* forms[] = {"values", "range", "log_range", "low"};
  const auto given = std::ranges::count_if(forms, [&](const char* form) { return s.has(form); });
  if (given != 1)
    s.lacks(given == 0 ? "values" : "",
            given == 0 ? "is missing: give values, range, log_range, or low and high"
                       : "needs exactly one of values, range, log_range, and low with high");
  if (s.has("low")) return;
  if (s.has("values")) return read_list(a, s, units);
  const char* key = s.has("range") ? "range" : "log_range";
  a.values = spread(s.numbers(Key{key, units.front(), {}}), s.has("log_range"), key, s);
}

const Schema& study_schema() {
  static const Schema schema = [] {
    KeysList list;
    list.facts<Study>("study", "a study");
    return list.schema("study");
  }();
  return schema;
}

void StudyReader::require_free(const std::string& name, const char* what) {
  const auto own = lower(name);
  const auto taken = [&](std::string_view column) { return lower(std::string(column)) == own; };
  const bool column =
      std::ranges::any_of(TurnMetrics::names(), taken) || std::ranges::any_of(fixed_columns, taken);
  if (column)
    s_.fail("", fmt::format("\"{}\" is a column of the results; give the {} another name", name, what));
  const auto other = [&](const auto& list, const char* kind) {
    for (const auto& x : list)
      if (taken(x.name))
        s_.fail("", fmt::format("{} {} already has this name; give the {} another", kind, x.name, what));
  };
  other(study_.axes, "axis");
  other(study_.measures, "measure");
  other(study_.derived, "derived quantity");
}

/// Requires a name that expressions can contain.
void StudyReader::require_word(const std::string& name, const char* what) {
  if (!Expression::is_name(name))
    s_.fail("",
            fmt::format(
                "\"{}\": expressions cannot use this name of the {}: it must have letters, digits and _, not "
                "begin with a digit, and not be one of {}",
                name, what, fmt::join(Expression::words(), ", ")));
}

void StudyReader::finish(Axis& a) {
  require_free(a.name, "axis");
  if (a.drawn) {
    if (!study_.design.method)
      s_.fail("low", "is of an axis with random values, and sample, their design, is missing");
    const auto& d = *a.drawn;
    if (d.high <= d.low) s_.fail("high", fmt::format("must be greater than low = {}, is {}", d.low, d.high));
    if (d.logarithmic && d.low <= 0) s_.fail("low", "must be greater than 0 where spacing is \"log\"");
  }
  if (!s_.is_list_of_lists("values")) require_one_unit(a, s_, units_of(a));
  if (a.other_values.empty() && !a.drawn) a.other_values.assign(a.others.size(), a.values);
  s_.done(a.drawn ? "an axis with random values" : "an axis without random values");
  for (const auto& key : keys_of(a))
    for (const auto& other : study_.axes)
      if (std::ranges::count(keys_of(other), key) > 0)
        s_.fail(a.others.empty() ? "key" : "keys",
                fmt::format("{} is already varied by axis {}", key, other.name));
}

void StudyReader::finish(Measure& measure) {
  require_free(measure.name, "measure");
  require_word(measure.name, "measure");
}

void StudyReader::texts(const Key& key, std::vector<Derived>& list) {
  Section section = s_.child(key.name);
  StudyReader derived(section, study_);
  for (auto& [name, expression] : s_.texts(key.name)) {
    derived.require_free(name, "derived quantity");
    derived.require_word(name, "derived quantity");
    list.push_back({name, expression});
  }
}

void StudyReader::texts(const Key& key, std::vector<std::pair<std::string, std::string>>& units) {
  units = s_.texts(key.name);
  for (const auto& [name, unit] : units)
    if (std::ranges::find(study_.measures, name, &Measure::name) == study_.measures.end() &&
        std::ranges::find(study_.derived, name, &Derived::name) == study_.derived.end())
      s_.child(key.name).fail(name, "is neither a measure nor a derived quantity of the study");
}

void StudyReader::finish(Variant& v) {
  study_.length.in_periods |= s_.has("revolutions");
  if (s_.has("revolutions") && study_.length.duration)
    s_.fail("revolutions", "counts periods, but the study's duration is in seconds");
  study_.starts.given |= s_.has("starts");
  for (const auto& axis : study_.axes) refuse_twice_set(s_, v.overrides, keys_of(axis), "axis " + axis.name);
  const auto known = names_of_unknowns();
  for (const auto& name : v.unknowns)
    if (std::ranges::count(known, name) == 0)
      s_.fail("unknowns", known.empty() ? fmt::format("\"{}\": the study has no rows.unknowns", name)
                                        : unknown_word(name, known));
}

std::vector<std::string> StudyReader::names_of_unknowns() const {
  std::vector<std::string> names;
  if (study_.rows)
    for (const auto& x : study_.rows->unknowns) names.push_back(x.name);
  return names;
}

void StudyReader::finish(RowTarget& target) {
  std::vector<std::string> known;
  for (const auto& m : study_.measures) known.push_back(m.name);
  if (std::ranges::count(known, target.name) == 0)
    s_.fail("", known.empty() ? fmt::format("\"{}\": the study has no measure; add [measure.{}]", target.name,
                                            target.name)
                              : "the name must be that of a measure: " + unknown_word(target.name, known));
}

void StudyReader::finish(MeasuredRows& rows) {
  std::vector<std::string> varied;
  for (const auto& set : rows.overrides) {
    if (set.find('=') == set.npos) s_.fail("set", fmt::format("\"{}\" must be KEY=VALUE", set));
    varied.push_back(set.substr(0, set.find('=')));
  }
  for (const auto& x : rows.unknowns)
    if (std::ranges::count(varied, x.key) > 0)
      s_.fail("unknowns." + x.name + ".key", fmt::format("{} is set by each row", x.key));
  if (!study_.axes.empty()) s_.fail("", "cannot be combined with axes: each row is one run");
}

void StudyReader::finish(Study& study) {
  if ((study.claims == "points") != s_.has("points"))
    s_.fail("claims", "\"points\" and the key points go together; one of them is missing");
  if (study.claims == "rows" && !study.rows) s_.fail("claims", "\"rows\" needs the measured runs, [rows]");
  if (study.rows && study.calibration)
    s_.fail("calibrate", "cannot be combined with [rows]; calibrate them in two studies");
  study.starts.given |= s_.has("starts");
  for (const char* key : {"revolutions", "discard"}) {
    study.length.in_periods |= s_.has(key);
    if (s_.has(key) && study.length.duration)
      s_.fail(key,
              "counts periods, but duration is in seconds; give revolutions and discard, or duration and "
              "discard_time");
  }
  if (study.length.discard_time && !study.length.duration)
    s_.fail("discard_time", "needs duration, which is missing");
  const auto drawn = std::ranges::count_if(study.axes, [](const Axis& a) { return a.drawn.has_value(); });
  if (study.design.method && drawn == 0)
    s_.fail("sample", "needs an axis with random values: give one low and high");
  if (drawn > most_drawn) s_.fail("axes", fmt::format("at most {} can be drawn", most_drawn));
  if (study.variants.empty())
    study.variants.push_back({"given",
                              study.title.empty() ? "the scene without variants" : study.title,
                              study.scene,
                              {},
                              study.formulations,
                              study.starts.count,
                              study.length.revolutions,
                              0,
                              0,
                              names_of_unknowns()});
}

void require_expressions(const Study& study) {
  try {
    if (!study.design.where.empty() &&
        Expression(study.design.where, names_of(study, false)).type() != Expression::Type::truth)
      throw ExpressionError(1, "is a number; `where` needs true or false, such as a < b");
  } catch (const ExpressionError& e) {
    throw error_at(study, {"where"}, e.what());
  }
  auto names = names_of(study, true);
  for (const auto& [name, expression] : study.derived) {
    try {
      (void)Expression(expression, names);
    } catch (const ExpressionError& e) {
      throw error_at(study, {"derived", name}, e.what());
    }
    names.push_back(name);
  }
}

// What concerns several keys of [calibrate], [bifurcation], [basin], [continue] or [wear] of a study, or
// other tables.

namespace {

constexpr int most_events = 1000;  // of a fitted run

}  // namespace

std::vector<BifurcationKind> read_curve_kinds(Section& s, std::string_view key) {
  std::vector<BifurcationKind> kinds;
  for (const auto& name : s.names(key)) {
    const auto known = std::ranges::find_if(bifurcation_names, [&](const char* n) { return name == n; });
    const auto kind = static_cast<BifurcationKind>(known - bifurcation_names.begin());
    if (known == bifurcation_names.end() || kind >= BifurcationKind::sequence)
      s.fail(key, fmt::format("\"{}\" is no kind of curve; use fold, flip, torus, grazing or liftoff", name));
    kinds.push_back(kind);
  }
  return kinds;
}

void StudyReader::axis_of(const Key& key, std::size_t& axis, std::size_t otherwise) {
  const auto& axes = study_.axes;
  if (axes.empty()) s_.fail(key.name, "the study has no axes; add [axes.NAME] with key and values");
  axis = otherwise;
  if (s_.has(key.name) || axes.size() <= otherwise) {
    const auto name = s_.text(key.name);
    std::vector<std::string> names;
    for (const auto& a : axes) names.push_back(a.name);
    axis = static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
    if (axis == axes.size())
      s_.fail(key.name, fmt::format("\"{}\" is not an axis of the study; {} {}", name, fmt::join(names, ", "),
                                    names.size() > 1 ? "are" : "is"));
  }
  if (axes[axis].drawn)
    s_.fail(key.name, fmt::format("axis {} has random values; give it values or a range", axes[axis].name));
}

void StudyReader::finish(Unknown& u) {
  if (u.high <= u.low) s_.fail("high", fmt::format("must be greater than low = {}, is {}", u.low, u.high));
  if (u.logarithmic && u.low <= 0) s_.fail("low", "must be greater than 0 on a log scale");
}

/// A target such as event.1.t, which is fitted with its derivatives.
void StudyReader::finish_quantity(Target& x) {
  // A fit needs the times of all events up to this one, and their derivatives.
  constexpr std::string_view event = "event.";
  if (x.statistic.starts_with(event) &&
      std::strtod(x.statistic.c_str() + event.size(), nullptr) > most_events)
    s_.fail("statistic",
            fmt::format("\"{}\": only the first {} contact events can be targets", x.statistic, most_events));
  x.value = s_.number("value", any_number);
  if (s_.has("deviation") == s_.has("tolerance"))
    s_.fail("", "needs exactly one of deviation (SI units) and tolerance (relative)");
  if (x.deviation == 0 && x.value == 0)
    s_.fail("tolerance", "is relative to value, which is 0; give deviation instead");
}

/// A target whose samples are compared with those of a run.
void StudyReader::finish_series(Target& x) {
  if (!s_.has("data")) s_.fail("data", "is required for a series: the measured file");
  if (s_.has("columns") && x.columns.size() != 2)
    s_.fail("columns", fmt::format("must name two columns, time and value, names {}", x.columns.size()));
  if (s_.has("levels") && !s_.has("against"))
    s_.fail("levels", "needs against, the column over which flanks are compared");
  for (std::size_t i = 0; i < x.levels.size(); ++i)
    if (!(x.levels[i] > (i > 0 ? x.levels[i - 1] : 0)))
      s_.fail("levels", fmt::format("must be greater than 0 and increase, has {}", x.levels[i]));
  if (x.from && x.until && !(*x.from < *x.until))
    s_.fail("until", fmt::format("must be greater than from = {}, is {}", *x.from, *x.until));
}

void StudyReader::finish(Target& x) {
  if (x.is_quantity()) return finish_quantity(x);
  if (x.is_series()) return finish_series(x);
  if (!s_.has("tolerance")) x.tolerance = x.is_waveform() ? 0.01 : 0.1;
  if (x.is_waveform()) {
    if (!s_.has("data")) s_.fail("data", "is required for a waveform: the measured file");
    if (study_.accelerometer.empty()) s_.fail("statistic", "\"waveform\" needs the study's accelerometer");
    Measure measure{.name = x.measure(),
                    .column = study_.accelerometer,
                    .reduce = Reduce::rms,
                    .at = {},
                    .waveform = x.data,
                    .digest = digest(read_text(x.data)),
                    .tolerance = x.tolerance,
                    .overrides = x.overrides};
    finish(measure);
    study_.measures.push_back(std::move(measure));
    return;
  }
  const auto& known = TurnMetrics::names();
  const bool measure =
      std::ranges::find(study_.measures, x.statistic, &Measure::name) != study_.measures.end();
  if (!measure && std::ranges::find(known, x.statistic) == known.end())
    s_.fail("statistic",
            fmt::format(
                "\"{}\" is neither a statistic nor a measure of the study; known are {}, waveform, series",
                x.statistic, fmt::join(known, ", ")));
  if (measure && s_.has("data"))
    s_.fail("statistic", fmt::format("\"{}\" is a measure of a run, which a file of a signal cannot "
                                     "provide; give its value",
                                     x.statistic));
  const auto place = static_cast<TurnMetrics::Name>(std::ranges::find(known, x.statistic) - known.begin());
  if (!measure && TurnMetrics::kind(place) == TurnMetrics::Kind::direction)
    s_.fail("statistic",
            fmt::format("\"{}\" is an angle on the circle; the fit of logarithms needs positive quantities",
                        x.statistic));
  if (s_.has("value") == s_.has("data")) s_.fail("", "needs exactly one of value and data");
}

void StudyReader::finish(Calibration& c) {
  const auto kind = [](const Target& t) {
    return t.is_quantity() ? "a quantity of one run" : t.is_series() ? "a series of one run" : "a statistic";
  };
  const std::string_view first = kind(c.targets.front());
  const auto other = std::ranges::find_if(c.targets, [&](const Target& t) { return kind(t) != first; });
  if (other != c.targets.end())
    s_.fail("targets." + other->name + ".statistic",
            fmt::format("\"{}\" and \"{}\" are {} and {}, which are fitted by different methods; calibrate "
                        "them in two studies",
                        other->statistic, c.targets.front().statistic, kind(*other), first));
  if (std::ranges::all_of(c.targets, &Target::hold_out))
    s_.fail("targets", "must have a target without hold_out, to which the unknowns are fitted");
}

void StudyReader::refuse_varied(const AttractorPlan& p, std::initializer_list<std::size_t> axes) {
  for (const auto place : axes)
    refuse_twice_set(s_, p.overrides, keys_of(study_.axes[place]), "axis " + study_.axes[place].name);
}

void StudyReader::finish(WearPlan& p) {
  if (!p.life_clearance) p.life_clearance = p.clearance;
}

void StudyReader::finish(ContinuationPlan& p) {
  if (p.from == p.to) s_.fail("to", fmt::format("must differ from from = {}", p.from));
  const auto [low, high] = std::minmax(p.from, p.to);
  if (p.start && !(*p.start >= low && *p.start <= high))
    s_.fail("start", fmt::format("must be from {} to {}", low, high));
  refuse_twice_set(s_, p.overrides, {p.key}, "the continuation");
  if (!p.second) return;
  if (p.second->key == p.key) s_.fail("second", "must differ from key");
  if (p.second->from == p.second->to)
    s_.fail("second_to", fmt::format("must differ from second_from = {}", p.second->from));
}

}  // namespace freeplay
