#include "study/settings/study_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "io/scene/schema.hpp"
#include "io/scene/section.hpp"
#include "measure/turns.hpp"
#include "study/settings/expression.hpp"

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

/// Refuses the name of an axis, measure or derived column that is already a column of the results.
void require_free(const Study& study, const std::string& name, Section& s, const char* what) {
  const auto own = lower(name);
  const auto taken = [&](std::string_view column) { return lower(std::string(column)) == own; };
  const bool column =
      std::ranges::any_of(TurnMetrics::names(), taken) || std::ranges::any_of(fixed_columns, taken);
  if (column)
    s.fail("", fmt::format("\"{}\" is a column of the results; give the {} another name", name, what));
  const auto other = [&](const auto& list, const char* kind) {
    for (const auto& x : list)
      if (taken(x.name))
        s.fail("", fmt::format("{} {} already has this name; give the {} another", kind, x.name, what));
  };
  other(study.axes, "axis");
  other(study.measures, "measure");
  other(study.derived, "derived quantity");
}

/// Requires a name that expressions can contain.
void require_word(const std::string& name, Section& s, const char* what) {
  if (!Expression::is_name(name))
    s.fail("",
           fmt::format(
               "\"{}\": expressions cannot use this name of the {}: it must have letters, digits and _, not "
               "begin with a digit, and not be one of {}",
               name, what, fmt::join(Expression::words(), ", ")));
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

Axis read_axis(const std::string& name, Section& s, const Study& study) {
  Axis a;
  a.name = name;
  if (s.has("keys")) {
    if (s.has("key")) s.fail("keys", "and key are given; give one of them");
    a.others = s.names("keys");
    if (a.others.empty()) s.fail("keys", "must name at least one key of the scene");
    a.key = a.others.front();
    a.others.erase(a.others.begin());
  } else {
    a.key = s.text("key");
  }
  std::vector<std::string_view> units{unit_of(a.key)};
  for (const auto& other : a.others) units.push_back(unit_of(other));
  const bool of_lists = s.is_list_of_lists("values");
  constexpr const char* forms[] = {"values", "range", "log_range", "low"};
  const auto given = std::ranges::count_if(forms, [&](const char* form) { return s.has(form); });
  if (given != 1)
    s.lacks(given == 0 ? "values" : "",
            given == 0 ? "is missing: give values, range, log_range, or low and high"
                       : "needs exactly one of values, range, log_range, and low with high");
  if (s.has("low")) {
    if (!study.sampling)
      s.fail("low", "is of an axis with random values, and sample, their design, is missing");
    Axis::Drawn d;
    const auto bound = [&](const char* end) { return s.number(Key{end, units.front(), {}}, any_number); };
    d.low = bound("low");
    d.high = bound("high");
    if (d.high <= d.low) s.fail("high", fmt::format("must be greater than low = {}, is {}", d.low, d.high));
    d.logarithmic = s.choice("spacing", {"linear", "log"}, 0) == 1;
    if (d.logarithmic && d.low <= 0) s.fail("low", "must be greater than 0 where spacing is \"log\"");
    a.drawn = d;
  } else if (s.has("values")) {
    read_list(a, s, units);
  } else {
    const char* key = s.has("range") ? "range" : "log_range";
    a.values = spread(s.numbers(Key{key, units.front(), {}}), s.has("log_range"), key, s);
  }
  if (!of_lists) require_one_unit(a, s, units);
  if (a.other_values.empty() && !a.drawn) a.other_values.assign(a.others.size(), a.values);
  a.unit = s.text("unit", "");
  a.scale = s.number("scale", positive, 1);
  s.done(a.drawn ? "an axis with random values" : "an axis without random values");
  return a;
}

std::vector<std::string> keys_of(const Axis& axis) {
  auto keys = axis.others;
  keys.push_back(axis.key);
  return keys;
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

void read_windows(Section& root, Study& study) {
  study.period = root.maybe_number("period", positive);
  study.duration = root.maybe_number("duration", positive);
  study.discard_time = root.maybe_number("discard_time", non_negative);
  study.in_periods = root.has("revolutions") || root.has("discard");
  for (const char* key : {"revolutions", "discard"})
    if (root.has(key) && study.duration)
      root.fail(key,
                "counts periods, but duration is in seconds; give revolutions and discard, or duration and "
                "discard_time");
  if (study.discard_time && !study.duration) root.fail("discard_time", "needs duration, which is missing");
}

void read_axes(Section& root, Study& study) {
  if (root.has("sample")) {
    std::vector<std::string> words;
    for (const auto& choice : draw_names) words.emplace_back(choice.text);
    study.sampling = draw_names[static_cast<std::size_t>(root.choice("sample", words))].value;
    study.samples = static_cast<int>(root.number("samples", study_count));
  } else if (root.has("samples")) {
    root.fail("samples", "needs sample, the design of the random values");
  }
  for (auto& [name, s] : root.children("axes")) {
    require_free(study, name, s, "axis");
    auto axis = read_axis(name, s, study);
    for (const auto& key : keys_of(axis))
      for (const auto& other : study.axes)
        if (std::ranges::count(keys_of(other), key) > 0)
          s.fail(axis.others.empty() ? "key" : "keys",
                 fmt::format("{} is already varied by axis {}", key, other.name));
    study.axes.push_back(std::move(axis));
  }
  if (study.sampling && std::ranges::none_of(study.axes, [](const Axis& a) { return a.drawn.has_value(); }))
    root.fail("sample", "needs an axis with random values: give one low and high");
  if (std::ranges::count_if(study.axes, [](const Axis& a) { return a.drawn.has_value(); }) > most_drawn)
    root.fail("axes", fmt::format("at most {} can be drawn", most_drawn));
  study.where = root.text("where", "");
}

void add_measure(Study& study, Measure measure, Section& s) {
  require_free(study, measure.name, s, "measure");
  require_word(measure.name, s, "measure");
  study.measures.push_back(std::move(measure));
}

void read_measures(Section& root, Study& study) {
  for (auto& [name, s] : root.children("measure")) add_measure(study, read_measure(name, s), s);
  for (auto& [name, expression] : root.texts("derived")) {
    Section s = root.child("derived");
    require_free(study, name, s, "derived quantity");
    require_word(name, s, "derived quantity");
    study.derived.push_back({name, expression});
  }
  study.units = root.texts("units");
  for (const auto& [name, unit] : study.units)
    if (std::ranges::find(study.measures, name, &Measure::name) == study.measures.end() &&
        std::ranges::find(study.derived, name, &Derived::name) == study.derived.end())
      root.child("units").fail(name, "is neither a measure nor a derived quantity of the study");
}

void require_expressions(const Study& study) {
  try {
    if (!study.where.empty() &&
        Expression(study.where, names_of(study, false)).type() != Expression::Type::truth)
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

}  // namespace freeplay
