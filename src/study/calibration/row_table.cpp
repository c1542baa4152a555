#include "study/calibration/row_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "io/files/escaping.hpp"
#include "io/scene/points_file.hpp"
#include "io/scene/section.hpp"
#include "study/settings/expression.hpp"

namespace freeplay {
namespace {

/// An expression of the columns at a key of [rows].
class ColumnExpression {
 public:
  ColumnExpression(const Study& study, std::vector<std::string> path, const std::string& text,
                   const std::vector<std::string>& columns, Expression::Type type = Expression::Type::number)
      : text_(text), compiled_(compile(study, path, text, columns, type)) {}
  /// The value in a row; `fail` throws if there is none.
  double operator()(const std::vector<double>& row, const auto& fail) const {
    const double x = compiled_(row);
    if (!std::isfinite(x)) fail(fmt::format("\"{}\" has no value", text_));
    return x;
  }
  bool holds(const std::vector<double>& row) const { return compiled_.holds(row); }

 private:
  static Expression compile(const Study& study, const std::vector<std::string>& path, const std::string& text,
                            const std::vector<std::string>& columns, Expression::Type type) {
    try {
      Expression made(text, columns);
      if (made.type() != type)
        throw ExpressionError(1, type == Expression::Type::truth
                                     ? "is a number; `where` needs true or false, such as a < b"
                                     : "is true or false; a number is needed");
      return made;
    } catch (const ExpressionError& e) {
      throw error_at(study, path, fmt::format("\"{}\": {}", text, e.what()));
    }
  }

  std::string text_;
  Expression compiled_;
};

/// KEY=VALUE with expressions in braces.
class RowSetting {
 public:
  RowSetting(const Study& study, const std::string& text, const std::vector<std::string>& columns) {
    std::size_t from = 0;
    for (auto open = text.find('{'); open != text.npos; open = text.find('{', from)) {
      const auto close = text.find('}', open);
      if (close == text.npos)
        throw error_at(study, {"rows", "set"}, fmt::format("\"{}\": }} is missing after {{", text));
      texts_.push_back(text.substr(from, open - from));
      values_.emplace_back(study, std::vector<std::string>{"rows", "set"},
                           text.substr(open + 1, close - open - 1), columns);
      from = close + 1;
    }
    texts_.push_back(text.substr(from));
  }
  std::string in(const std::vector<double>& row, const auto& fail) const {
    std::string all = texts_.front();
    for (std::size_t i = 0; i < values_.size(); ++i)
      all += fmt::format("{}{}", values_[i](row, fail), texts_[i + 1]);
    return all;
  }

 private:
  std::vector<std::string> texts_;  // one more than values
  std::vector<ColumnExpression> values_;
};

}  // namespace

int class_of(const RowClasses& classes, double value) {
  return static_cast<int>(std::ranges::count_if(classes.edges, [&](double edge) { return value >= edge; }));
}

std::string class_name(const RowClasses& classes, int number) {
  const auto edge = [&](int i) { return classes.edges[static_cast<std::size_t>(i)]; };
  const auto last = static_cast<int>(classes.edges.size());
  const auto range = number == 0      ? fmt::format("below {:.4g}", edge(0))
                     : number == last ? fmt::format("from {:.4g}", edge(last - 1))
                                      : fmt::format("{:.4g} to {:.4g}", edge(number - 1), edge(number));
  return fmt::format("{} {}{}{}", classes.name, range, classes.unit.empty() ? "" : " ", classes.unit);
}

RowTable read_rows(const Study& study) {
  const auto& r = *study.rows;
  const auto file = r.file.string();
  const auto fail = [&](const std::string& what) { throw SceneError(fmt::format("{}: {}", file, what)); };
  TextRows text(read_text(r.file));
  if (!text.next()) fail("has no header with the names of its columns");
  const auto columns = text.fields();
  if (columns.size() == 1)
    if (const auto what = wrong_separator(columns.front()); !what.empty()) fail(what);

  for (auto name = columns.begin(); name != columns.end(); ++name)
    if (std::find(columns.begin(), name, *name) != name)
      fail(fmt::format("has two columns \"{}\"", visible(*name)));

  std::vector<RowSetting> settings;
  for (const auto& set : r.overrides) settings.emplace_back(study, set, columns);
  std::vector<ColumnExpression> targets, classes, where;
  for (const auto& t : r.targets)
    targets.emplace_back(study, std::vector<std::string>{"rows", "targets", t.name, "value"}, t.value,
                         columns);
  for (const auto& c : r.classes)
    classes.emplace_back(study, std::vector<std::string>{"rows", "classes", c.name, "value"}, c.value,
                         columns);
  if (!r.where.empty())
    where.emplace_back(study, std::vector<std::string>{"rows", "where"}, r.where, columns,
                       Expression::Type::truth);

  RowTable table;
  table.values.resize(classes.size());
  std::vector<double> measured, row(columns.size());
  while (text.next()) {
    const auto at_line = [&](const std::string& what) {
      fail(fmt::format("line {}: {}", text.number(), what));
    };
    const auto& fields = text.fields();
    if (fields.size() != columns.size()) at_line(wrong_count(fields.size(), columns.size()));
    for (std::size_t k = 0; k < fields.size(); ++k) {
      const auto x = number_in(fields[k]);
      if (!x || !std::isfinite(*x)) at_line(fmt::format("{} must be a number", columns[k]));
      row[k] = *x;
    }
    if (!where.empty() && !where.front().holds(row)) {
      ++table.excluded;
      continue;
    }
    auto& own = table.settings.emplace_back();
    for (const auto& set : settings) own.push_back(set.in(row, at_line));
    for (const auto& target : targets) measured.push_back(target(row, at_line));
    for (std::size_t k = 0; k < classes.size(); ++k) table.values[k].push_back(classes[k](row, at_line));
    table.part.push_back(static_cast<int>(table.lines.size()) % r.parts);
    table.lines.push_back(text.number());
  }
  if (table.size() == 0) fail("has no row that is used");
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  table.measured = Eigen::Map<const RowMajor>(measured.data(), static_cast<Eigen::Index>(table.size()),
                                              static_cast<Eigen::Index>(targets.size()));
  return table;
}

}  // namespace freeplay
