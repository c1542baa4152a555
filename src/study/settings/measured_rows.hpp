// MeasuredRows: the table [rows] of a study. Each row of a CSV file is one short run: it sets keys of the
// scene, and states measured values of measures of the study. Unknowns are fitted to a part of the rows,
// and the other rows are predicted (study/calibration/row_fit.hpp).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "mechanism/keys.hpp"
#include "study/settings/study_parts.hpp"

namespace freeplay {

/// A parameter that calibration identifies.
struct Unknown {
  std::string name, key, unit;
  double low = 0, high = 0;
  bool logarithmic = false;

  static void keys(auto& k, auto& x) {
    k.need({"key", "", "scene key to be fitted"}, x.key);
    k.need({"low", unit_of(x.key), "least value"}, x.low, any_number);
    k.need({"high", unit_of(x.key), "greatest value"}, x.high, any_number);
    k.other({"scale", "", "or \"log\"", "\"linear\""}, "text", x.logarithmic, read_logarithmic);
    k.take({"unit", "", "as shown"}, x.unit);
  }
};

/// A measured quantity of each row; its name is that of a measure of the study.
struct RowTarget {
  std::string name, value;
  double weight = 1;

  static void keys(auto& k, auto& x) {
    k.need({"value", "", "measured value in SI units: an expression of the columns"}, x.value);
    k.take({"weight", "", "factor of its difference in the residual of a row"}, x.weight, positive);
  }
};

/// A classification of the rows, by a value and the limits of its classes.
struct RowClasses {
  std::string name, value, unit;
  std::vector<double> edges;

  static void keys(auto& k, auto& x) {
    k.need({"value", "", "an expression of the columns by which the residuals are also listed"}, x.value);
    k.other({"edges", "", "increasing limits of the classes; values outside have classes, too", "required"},
            "numbers", x.edges, [](auto& s, std::string_view key) { return s.numbers(key); });
    k.take({"unit", "", "of the value, as shown"}, x.unit);
    k.check(!x.edges.empty(), "edges", "must have one limit or more");
    for (std::size_t i = 1; i < x.edges.size(); ++i)
      k.check(x.edges[i] > x.edges[i - 1], "edges", "must increase, has ", x.edges[i], " after ",
              x.edges[i - 1]);
  }
};

/// Rows of a CSV file as the runs of a study.
struct MeasuredRows {
  std::filesystem::path file;
  std::string where;  ///< condition for the use of a row, an expression of the columns; empty: all
  int parts = 2;      ///< row i belongs to part i mod parts, which is predicted by a fit to the others
  int resamples = 400;
  /// KEY=VALUE; {EXPRESSION} in VALUE is replaced by its value in the row.
  std::vector<std::string> overrides;
  std::vector<Unknown> unknowns;
  std::vector<RowTarget> targets;
  std::vector<RowClasses> classes;

  static constexpr Range two_or_more{
      [](double x) { return x >= 2 && x <= 1000 && x == static_cast<double>(static_cast<int>(x)); },
      "a whole number from 2 to 1000"};
  static constexpr Range some_resamples{
      [](double x) { return x >= 100 && x <= 1e5 && x == static_cast<double>(static_cast<int>(x)); },
      "a whole number from 100 to 1e5"};

  static void keys(auto& k, auto& x) {
    k.need({"file", "", "CSV file with a header; each line is one run"}, x.file);
    k.names(
        {"set", "", "keys of the scene, KEY=VALUE, in which {EXPRESSION} of the columns stands for a number"},
        x.overrides);
    k.take({"where", "", "condition for the use of a row, an expression of the columns", "–"}, x.where);
    k.take({"hold_out", "",
            "number of parts: row i is in part i mod hold_out, and `validate` predicts each part by a fit to "
            "the others"},
           x.parts, two_or_more);
    k.take({"resamples", "", "number of random resamples of the rows for each 95 % interval"}, x.resamples,
           some_resamples);
    k.tables("unknowns", "an unknown", x.unknowns);
    k.tables("targets", "a measured quantity of the rows", x.targets);
    k.tables("classes", "classes of rows", x.classes);
    k.check(!x.targets.empty(), "targets", "must name at least one measure");
  }
};

}  // namespace freeplay
