#include "verification/claims/report_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "values/table.hpp"

namespace freeplay::verification {

NameParts parts_of(const Claim& c) {
  NameParts p{"", c.quantity, ""};
  if (const auto colon = p.quantity.find(": "); colon != std::string::npos) {
    p.subject = p.quantity.substr(0, colon);
    p.quantity.erase(0, colon + 2);
  }
  const auto bracket = p.quantity.rfind(" [");
  if (bracket != std::string::npos && p.quantity.ends_with(']')) {
    p.scheme = p.quantity.substr(bracket + 2, p.quantity.size() - bracket - 3);
    p.quantity.erase(bracket);
  }
  return p;
}

namespace {

std::string escaped(std::string text) {
  for (std::size_t i = 0; (i = text.find('|', i)) != std::string::npos; i += 2) text.replace(i, 1, "\\|");
  return text;
}

/// Deviation and bound of a claim. "rel.": both are divided by the expected value.
std::string deviation(const Claim& c) {
  using enum Claim::Assessed;
  if (c.assessed == between) {
    if (!c.holds())
      return fmt::format("**FAILS: {:.4g}, not {:.4g} to {:.4g}**", c.measured, c.expected, c.bound);
    return fmt::format("{:.4g} ≤ {:.4g} ≤ {:.4g}", c.expected, c.measured, c.bound);
  }
  const double scale = c.assessed == relative ? std::abs(c.expected) : 1;
  auto text = c.assessed == at_most ? fmt::format("{:.4g}", c.measured)
                                    : fmt::format("{:.2g}", std::abs(c.measured - c.expected) / scale);
  if (c.assessed == relative) text.insert(0, "rel. ");
  return c.holds() ? fmt::format("{} ≤ {:.2g}", text, c.bound)
                   : fmt::format("**FAILS: {}, bound {:.2g}**", text, c.bound);
}

/// The claims of one subject as a table: a row for each quantity with its expected value and
/// source, and a column for each scheme. With more than `most_columns` schemes each claim has a
/// row, in the order of quantities.
class SubjectTable {
 public:
  explicit SubjectTable(std::vector<const Claim*> claims) {
    std::vector<std::string> quantities;
    for (const auto* c : claims) {
      note(schemes_, parts_of(*c).scheme);
      note(quantities, parts_of(*c).quantity);
      if (!c->reason.empty()) note(reasons_, c->reason);
    }
    if (schemes_.size() > most_columns) {
      schemes_ = {""};
      std::ranges::stable_sort(claims, {},
                               [&](const auto* c) { return note(quantities, parts_of(*c).quantity); });
    }
    for (const auto* c : claims) add(*c);
  }

  std::string markdown() const {
    Table table("quantity,expected,source");
    for (const auto& scheme : schemes_) table.column(scheme.empty() ? "deviation ≤ bound" : escaped(scheme));
    for (const auto& row : rows_) {
      std::vector<Table::Cell> cells{
          row.quantity, row.claim->compared() ? fmt::format("{:.{}g}", row.claim->expected, row.digits) : "",
          escaped(row.claim->source)};
      cells.insert(cells.end(), row.cells.begin(), row.cells.end());
      table.row(std::move(cells));
    }
    auto out = table.markdown();
    if (reasons_.size() == 1) out += fmt::format("\nReason of the bounds: {}.\n", reasons_[0]);
    if (reasons_.size() > 1) out += "\nReasons of the bounds:\n\n";
    for (std::size_t i = 0; reasons_.size() > 1 && i < reasons_.size(); ++i)
      out += fmt::format("- [{}] {}\n", i + 1, reasons_[i]);
    return out;
  }

 private:
  static constexpr std::size_t most_columns = 6;

  struct Row {
    std::string quantity;  ///< with the unit
    const Claim* claim = nullptr;
    int digits = 0;
    std::vector<std::string> cells;
  };

  /// Index of `text` in the list, to which it is appended if absent.
  static std::size_t note(std::vector<std::string>& list, const std::string& text) {
    const auto at = std::ranges::find(list, text);
    if (at != list.end()) return static_cast<std::size_t>(at - list.begin());
    list.push_back(text);
    return list.size() - 1;
  }

  void add(const Claim& c) {
    const auto name = parts_of(c);
    const bool by_scheme = schemes_.size() > 1 || schemes_[0] == name.scheme;
    const std::size_t column = by_scheme ? note(schemes_, name.scheme) : 0;
    auto quantity = escaped(by_scheme ? name.quantity : name.quantity + " [" + name.scheme + "]");
    if (!c.unit.empty()) quantity += ", " + c.unit;
    auto row = std::ranges::find_if(rows_, [&](const Row& r) {
      const auto& other = *r.claim;
      return r.quantity == quantity && r.cells[column].empty() && other.source == c.source &&
             other.compared() == c.compared() && (!c.compared() || other.expected == c.expected);
    });
    if (row == rows_.end())
      row = rows_.insert(rows_.end(), {quantity, &c, 0, std::vector<std::string>(schemes_.size())});
    row->digits = std::max(row->digits, c.digits());
    row->cells[column] = deviation(c);
    if (reasons_.size() > 1 && !c.reason.empty())
      row->cells[column] += fmt::format(" [{}]", note(reasons_, c.reason) + 1);
  }

  std::vector<std::string> schemes_, reasons_;
  std::vector<Row> rows_;
};

}  // namespace

std::string tables_by_subject(const std::vector<Claim>& claims) {
  std::vector<std::pair<std::string, std::vector<const Claim*>>> subjects;
  for (const auto& c : claims) {
    const auto subject = parts_of(c).subject;
    auto found = std::ranges::find(subjects, subject, [](const auto& s) { return s.first; });
    if (found == subjects.end()) found = subjects.insert(subjects.end(), {subject, {}});
    found->second.push_back(&c);
  }
  std::string out;
  for (const auto& [subject, list] : subjects)
    out += fmt::format("\n### {}\n\n{}", subject, SubjectTable(list).markdown());
  return out;
}

}  // namespace freeplay::verification
