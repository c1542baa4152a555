#include "numerics/saddle_point.hpp"

#include <algorithm>
#include <map>
#include <numeric>

namespace freeplay {

SaddlePoint::SaddlePoint(std::span<const double> mass, const CsrPattern& G, SolvePath path, bool redundant)
    : part_of_column_(G.columns, -1), whole_(G.columns, 0.0) {
  for (const double m : mass) inverse_mass_.push_back(1 / m);
  // Columns that share a row belong together: union by the least column.
  std::vector<int> root(G.columns);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int c) {
    while (root[c] != c) c = root[c] = root[root[c]];
    return c;
  };
  for (int k = 0; k < G.rows; ++k)
    for (int e = G.begin[k] + 1; e < G.begin[k + 1]; ++e) {
      const int a = find(G.column[G.begin[k]]), b = find(G.column[e]);
      root[std::max(a, b)] = std::min(a, b);
    }
  std::map<int, std::vector<int>> rows_of;
  for (int k = 0; k < G.rows; ++k) rows_of[find(G.column[G.begin[k]])].push_back(k);
  std::size_t most_columns = 0, most_rows = 0, most_entries = 0;
  for (const auto& [origin, rows] : rows_of) {
    const int index = static_cast<int>(parts_.size());
    std::vector<int> columns, entries, place(G.columns, -1);
    for (int c = 0; c < G.columns; ++c)
      if (find(c) == origin) {
        place[c] = static_cast<int>(columns.size());
        part_of_column_[c] = index;
        columns.push_back(c);
      }
    CsrPattern pattern;
    pattern.columns = static_cast<int>(columns.size());
    for (const int k : rows) {
      for (int e = G.begin[k]; e < G.begin[k + 1]; ++e) {
        pattern.column.push_back(place[G.column[e]]);
        entries.push_back(e);
      }
      pattern.end_row();
    }
    std::vector<double> m;
    for (const int c : columns) m.push_back(mass[c]);
    most_columns = std::max(most_columns, columns.size());
    most_rows = std::max(most_rows, rows.size());
    most_entries = std::max(most_entries, entries.size());
    parts_.push_back({columns, rows, entries, SaddleBlock(m, pattern, path, redundant)});
  }
  for (int c = 0; c < G.columns; ++c)
    if (part_of_column_[c] < 0) free_columns_.push_back(c);
  largest_ = static_cast<int>(most_rows);
  values_.resize(most_entries);
  for (auto* x : {&f_, &a_}) x->resize(most_columns);
  for (auto* x : {&r_, &lambda_}) x->resize(most_rows);
}

bool SaddlePoint::factor(const double* G_values) {
  for (auto& part : parts_) {
    for (std::size_t i = 0; i < part.entries.size(); ++i) values_[i] = G_values[part.entries[i]];
    if (!part.block.factor(values_.data())) return false;
  }
  return true;
}

void SaddlePoint::solve_part(Part& part, const double* f, const double* r, double* a, double* lambda) {
  if (f)
    for (std::size_t i = 0; i < part.columns.size(); ++i) f_[i] = f[part.columns[i]];
  if (r)
    for (std::size_t i = 0; i < part.rows.size(); ++i) r_[i] = r[part.rows[i]];
  part.block.solve(f ? f_.data() : nullptr, r ? r_.data() : nullptr, a_.data(), lambda_.data());
  converged_ = converged_ && part.block.converged();
  for (std::size_t i = 0; i < part.columns.size(); ++i) a[part.columns[i]] = a_[i];
  for (std::size_t i = 0; i < part.rows.size(); ++i) lambda[part.rows[i]] = lambda_[i];
}

void SaddlePoint::solve(const double* f, const double* r, double* a, double* lambda) {
  converged_ = true;
  for (const int c : free_columns_) a[c] = f ? f[c] * inverse_mass_[c] : 0;
  for (auto& part : parts_) solve_part(part, f, r, a, lambda);
}

void SaddlePoint::respond(const SparseRow& row, const SparseRow* beside, double factor, double* a,
                          double* lambda) {
  converged_ = true;
  std::fill_n(a, part_of_column_.size(), 0.0);
  for (const auto& part : parts_)
    for (const int k : part.rows) lambda[k] = 0;
  row.add_to(whole_.data(), 1);
  if (beside) beside->add_to(whole_.data(), factor);
  // Two bodies at most: two parts at most.
  int done[2] = {-1, -1};
  const auto touch = [&](const SparseRow& x) {
    for (int i = 0; i < x.size; ++i) {
      const int c = x.column[i], p = part_of_column_[c];
      if (p < 0) {
        a[c] = whole_[c] * inverse_mass_[c];
      } else if (p != done[0] && p != done[1]) {
        done[done[0] < 0 ? 0 : 1] = p;
        solve_part(parts_[p], whole_.data(), nullptr, a, lambda);
      }
    }
  };
  touch(row);
  if (beside) touch(*beside);
  for (int i = 0; i < row.size; ++i) whole_[row.column[i]] = 0;
  if (beside)
    for (int i = 0; i < beside->size; ++i) whole_[beside->column[i]] = 0;
}

bool SaddlePoint::dense() const {
  return std::ranges::all_of(parts_, [](const Part& p) { return p.block.dense(); });
}
bool SaddlePoint::singular() const {
  return std::ranges::any_of(parts_, [](const Part& p) { return p.block.singular(); });
}

}  // namespace freeplay
