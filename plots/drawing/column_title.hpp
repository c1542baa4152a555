// Titles of axes for columns of result files, and for expressions of columns.
#pragma once

#include <string>
#include <vector>

#include "plots/drawing/axis.hpp"
#include "plots/tables/columns.hpp"

namespace freeplay::plots {

/// Title of an axis of formulas of one unit. One column is named by its element and quantity;
/// several by their common quantity, as the key names them, or by that of their unit. The magnitude
/// of a vector, hypot(pin.fx, pin.fy), has its symbol; another expression is shown as it is.
AxisTitle title_of(const std::vector<ColumnFormula>& formulas, const std::string& unit);

/// Title of the axis of a column of a result file or a section: its element, quantity and symbol.
AxisTitle title_of_column(const std::string& column, const std::string& unit);

/// Title of the axis of a number of run.json: its element and words, in the shown unit.
AxisTitle title_of_number(const std::string& path, const std::string& unit);

}  // namespace freeplay::plots
