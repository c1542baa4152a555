#include "numerics/saddle_point.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace freeplay {

/// Finds the rows with one entry. None is used if another row would become empty or a coordinate
/// would be fixed twice.
void SaddlePoint::find_fixed(std::span<const double> mass, const CsrPattern& G) {
  std::vector<int> of_column(G.columns, -1);
  for (int k = 0; k < G.rows; ++k) {
    if (G.begin[k + 1] - G.begin[k] != 1) continue;
    const int e = G.begin[k], c = G.column[e];
    if (of_column[c] >= 0) {
      fixed_.clear();
      return;
    }
    of_column[c] = static_cast<int>(fixed_.size());
    fixed_.push_back({k, c, e, mass[c]});
  }
  for (int k = 0; k < G.rows; ++k) {
    if (G.begin[k + 1] - G.begin[k] == 1) continue;
    int left = 0;
    for (int e = G.begin[k]; e < G.begin[k + 1]; ++e) {
      if (of_column[G.column[e]] >= 0)
        couplings_.push_back({k, of_column[G.column[e]], e});
      else
        ++left;
    }
    if (left == 0) {
      fixed_.clear();
      couplings_.clear();
      return;
    }
  }
  for (const auto& x : fixed_) fixed_columns_.push_back(x.column);
  fixed_value_.resize(fixed_.size());
  coupling_value_.resize(couplings_.size());
  reduced_r_.resize(G.rows);
}

SaddlePoint::SaddlePoint(std::span<const double> mass, const CsrPattern& G, SolvePath path, RowFacts facts,
                         const CsrPattern* B)
    : part_of_column_(G.columns, -1),
      place_of_column_(G.columns, 0),
      free_mobility_(G.columns, 0.0),
      whole_(G.columns, 0.0),
      facts_(facts),
      rows_(static_cast<std::size_t>(G.rows)),
      elastic_(B != nullptr),
      G_values_(G.column.size()) {
  if (!B) {
    make_parts(mass, G, path);
    return;
  }
  facts_.eliminate = false;
  CsrPattern all = G;
  for (int k = 0; k < B->rows; ++k) {
    all.column.insert(all.column.end(), B->column.begin() + B->begin[k], B->column.begin() + B->begin[k + 1]);
    all.end_row();
  }
  elastic_r_.resize(static_cast<std::size_t>(all.rows));
  elastic_lambda_.resize(static_cast<std::size_t>(all.rows));
  make_parts(mass, all, path);
  for (auto& part : parts_)
    if (const auto rows = std::ranges::count_if(part.at.rows, [&](int k) { return k >= G.rows; }); rows > 0)
      part.block.make_elastic(static_cast<int>(rows));
}

void SaddlePoint::make_parts(std::span<const double> mass, const CsrPattern& G, SolvePath path) {
  const auto& facts = facts_;
  if (facts.eliminate && !facts.redundant) find_fixed(mass, G);
  std::vector<bool> gone_row(G.rows, false), gone(G.columns, false);
  for (const auto& x : fixed_) gone_row[x.row] = gone[x.column] = true;
  for (const double m : mass) inverse_mass_.push_back(1 / m);
  // Columns that share a row belong to one part: union-find by the least column.
  std::vector<int> root(G.columns);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int c) {
    while (root[c] != c) c = root[c] = root[root[c]];
    return c;
  };
  std::map<int, std::vector<int>> rows_of;
  std::vector<int> first(G.rows, -1);  // first column of each remaining row
  for (int k = 0; k < G.rows; ++k)
    for (int e = G.begin[k]; e < G.begin[k + 1]; ++e) {
      if (gone_row[k] || gone[G.column[e]]) continue;
      if (first[k] < 0) first[k] = G.column[e];
      const int a = find(first[k]), b = find(G.column[e]);
      root[std::max(a, b)] = std::min(a, b);
    }
  for (int k = 0; k < G.rows; ++k)
    if (!gone_row[k]) rows_of[find(first[k])].push_back(k);
  std::size_t most_columns = 0, most_rows = 0;
  std::map<int, std::vector<int>> columns_of_root;
  for (int c = 0; c < G.columns; ++c)
    if (!gone[c]) columns_of_root[find(c)].push_back(c);
  std::vector<int> place(G.columns, -1);
  for (const auto& [origin, rows] : rows_of) {
    const int index = static_cast<int>(parts_.size());
    std::vector<int> entries;
    const auto& columns = columns_of_root[origin];
    for (std::size_t i = 0; i < columns.size(); ++i) {
      place[columns[i]] = place_of_column_[columns[i]] = static_cast<int>(i);
      part_of_column_[columns[i]] = index;
    }
    CsrPattern pattern;
    pattern.columns = static_cast<int>(columns.size());
    SaddleBlock::Places at{columns, rows, {}, inverse_mass_};
    for (const int k : rows) {
      for (int e = G.begin[k]; e < G.begin[k + 1]; ++e) {
        if (gone[G.column[e]]) continue;
        pattern.column.push_back(place[G.column[e]]);
        entries.push_back(e);
        at.column.push_back(G.column[e]);
      }
      pattern.end_row();
    }
    std::vector<double> m;
    for (const int c : columns) m.push_back(mass[c]);
    most_columns = std::max(most_columns, columns.size());
    most_rows = std::max(most_rows, rows.size());
    parts_.push_back({at, entries, SaddleBlock(m, pattern, path, facts.redundant)});
  }
  for (int c = 0; c < G.columns; ++c)
    if (part_of_column_[c] < 0 && !gone[c]) {
      free_columns_.push_back(c);
      free_mobility_[c] = inverse_mass_[c];
    }
  largest_ = static_cast<int>(most_rows);
  for (auto* x : {&f_, &a_}) x->resize(most_columns);
  for (auto* x : {&r_, &lambda_}) x->resize(most_rows);
}

void SaddlePoint::set_elastic(std::span<const double> values, std::span<const double> compliance) {
  for (auto& part : parts_) {
    elastic_values_.clear();
    elastic_r_.clear();
    for (const int k : part.at.rows)
      if (k >= static_cast<int>(rows_)) elastic_r_.push_back(compliance[static_cast<std::size_t>(k) - rows_]);
    if (elastic_r_.empty()) continue;
    for (const int e : part.entries)
      if (e >= static_cast<int>(G_values_.size()))
        elastic_values_.push_back(values[static_cast<std::size_t>(e) - G_values_.size()]);
    part.block.set_elastic(elastic_values_, elastic_r_);
  }
  elastic_r_.assign(elastic_lambda_.size(), 0);
}

bool SaddlePoint::factor(const double* G_values) {
  compiled_ = functions_ && functions_->factor && factor_compiled(G_values);
  return compiled_ || factor_blocks(G_values);
}

SaddlePoint::CompiledRoom SaddlePoint::compiled_room() {
  const auto& f = *functions_;
  if (facts_.redundant || facts_.eliminate != f.eliminate) return {};
  if (factors_.size() != static_cast<std::size_t>(f.factors)) {
    factors_.resize(static_cast<std::size_t>(f.factors));
    ratios_.resize(static_cast<std::size_t>(std::accumulate(f.ratios.begin(), f.ratios.end(), 0)));
  }
  return {true, G_values_.data(), factors_.data(), ratios_.data(), ratios_.size()};
}

void SaddlePoint::take_compiled() {
  compiled_ = true;
  const double* ratio = ratios_.data();
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    double least = 1;
    for (int i = 0; i < functions_->ratios[p]; ++i) least = std::min(least, *ratio++);
    parts_[p].block.factored_elsewhere(least);
  }
}

void SaddlePoint::take_compiled(const double* least) {
  compiled_ = true;
  factored_elsewhere(least);
}

bool SaddlePoint::factor_compiled(const double* G_values) {
  const auto room = compiled_room();
  if (!room.usable) return false;
  const double* in[] = {G_values};
  double* out[] = {room.factors, room.ratios};
  if (functions_->factor(functions_->constants, in, out) != 0) return false;
  std::copy_n(G_values, G_values_.size(), room.G);
  take_compiled();
  return true;
}

void SaddlePoint::use_blocks() {
  if (!compiled_) return;
  compiled_ = false;
  if (!factor_blocks(G_values_.data())) converged_ = false;
}

bool SaddlePoint::factor_blocks(const double* G_values) {
  for (std::size_t i = 0; i < fixed_.size(); ++i) {
    fixed_value_[i] = G_values[fixed_[i].entry];
    if (!(std::abs(fixed_value_[i]) > 0) || !std::isfinite(fixed_value_[i])) return false;
  }
  for (std::size_t i = 0; i < couplings_.size(); ++i) {
    coupling_value_[i] = G_values[couplings_[i].entry];
    if (!std::isfinite(coupling_value_[i])) return false;
  }
  for (auto& part : parts_) {
    if (!part.block.factor_at(G_values, part.entries.data())) return false;
  }
  return true;
}

void SaddlePoint::solve_part(Part& part, const double* f, const double* r, double* a, double* lambda) {
  if (part.block.direct()) {
    part.block.solve_at(part.at, f, r, a, lambda);
    return;
  }
  const auto &columns = part.at.columns, &rows = part.at.rows;
  if (f)
    for (std::size_t i = 0; i < columns.size(); ++i) f_[i] = f[columns[i]];
  if (r)
    for (std::size_t i = 0; i < rows.size(); ++i) r_[i] = r[rows[i]];
  part.block.solve(f ? f_.data() : nullptr, r ? r_.data() : nullptr, a_.data(), lambda_.data());
  converged_ = converged_ && part.block.converged();
  for (std::size_t i = 0; i < columns.size(); ++i) a[columns[i]] = a_[i];
  for (std::size_t i = 0; i < rows.size(); ++i) lambda[rows[i]] = lambda_[i];
}

/// Sets the fixed entries of a. Returns the right-hand side of the remaining rows.
const double* SaddlePoint::know(const double* r, double* a) {
  if (!r) {
    for (const auto& x : fixed_) a[x.column] = 0;
    return nullptr;
  }
  const double* value = fixed_value_.data();
  for (const auto& x : fixed_) a[x.column] = r[x.row] / *value++;
  if (couplings_.empty()) return r;
  double* reduced = reduced_r_.data();
  std::copy_n(r, reduced_r_.size(), reduced);
  value = coupling_value_.data();
  for (const auto& x : couplings_) reduced[x.row] -= *value++ * a[fixed_[x.fixed].column];
  return reduced;
}

void SaddlePoint::finish(const double* f, const double* a, double* lambda) const {
  if (f)
    for (const auto& x : fixed_) lambda[x.row] = f[x.column] - x.mass * a[x.column];
  else
    for (const auto& x : fixed_) lambda[x.row] = 0 - x.mass * a[x.column];
  if (compiled_) {
    for (const auto& x : couplings_) lambda[fixed_[x.fixed].row] -= G_values_[x.entry] * lambda[x.row];
    for (const auto& x : fixed_) lambda[x.row] /= G_values_[x.entry];
    return;
  }
  const double* value = coupling_value_.data();
  for (const auto& x : couplings_) lambda[fixed_[x.fixed].row] -= *value++ * lambda[x.row];
  value = fixed_value_.data();
  for (const auto& x : fixed_) lambda[x.row] /= *value++;
}

void SaddlePoint::finish(const SparseRow& row, const double* a, double* lambda) {
  row.add_to(whole_.data(), 1);
  finish(whole_.data(), a, lambda);
  for (int i = 0; i < row.size; ++i) whole_[row.column[i]] = 0;
}

void SaddlePoint::solve(const double* f, const double* r, double* a, double* lambda, Multipliers which) {
  converged_ = true;
  if (compiled_) {
    const double* in[] = {factors_.data(), G_values_.data(), f ? f : whole_.data(), r};
    double* out[] = {a, lambda};
    (r ? functions_->solve : functions_->respond)(functions_->constants, in, out);
    return;
  }
  if (elastic_) return solve_elastic(f, r, a, lambda);
  r = know(r, a);
  for (const int c : free_columns_) a[c] = f ? f[c] * inverse_mass_[c] : 0;
  for (auto& part : parts_) solve_part(part, f, r, a, lambda);
  if (which == Multipliers::all) finish(f, a, lambda);
}

void SaddlePoint::solve_elastic(const double* f, const double* r, double* a, double* lambda) {
  if (r) std::copy_n(r, rows_, elastic_r_.begin());
  for (const int c : free_columns_) a[c] = f ? f[c] * inverse_mass_[c] : 0;
  for (auto& part : parts_) solve_part(part, f, r ? elastic_r_.data() : nullptr, a, elastic_lambda_.data());
  std::copy_n(elastic_lambda_.begin(), rows_, lambda);
}

void SaddlePoint::respond(const SparseRow& row, const SparseRow* beside, double factor, double* a,
                          double* lambda, Multipliers which) {
  converged_ = true;
  double* whole = whole_.data();
  const auto clear = [&] {
    for (int i = 0; i < row.size; ++i) whole[row.column[i]] = 0;
    if (beside)
      for (int i = 0; i < beside->size; ++i) whole[beside->column[i]] = 0;
  };
  if (compiled_) {
    row.add_to(whole, 1);
    if (beside) beside->add_to(whole, factor);
    const double* in[] = {factors_.data(), G_values_.data(), whole};
    double* out[] = {a, lambda};
    functions_->respond(functions_->constants, in, out);
    return clear();
  }
  row.add_to(whole, 1);
  if (beside) beside->add_to(whole, factor);
  if (elastic_) {
    solve_elastic(whole, nullptr, a, lambda);
    return clear();
  }
  std::fill_n(a, part_of_column_.size(), 0.0);
  int done[2 * SparseRow::max_size];
  int number = 0;
  const auto is_done = [&](int p) { return std::find(done, done + number, p) != done + number; };
  const auto touch = [&](const SparseRow& x) {
    for (int i = 0; i < x.size; ++i) {
      const int c = x.column[i], p = part_of_column_[c];
      if (p < 0) {
        a[c] = whole[c] * inverse_mass_[c];  // a fixed coordinate is corrected below
      } else if (!is_done(p)) {
        done[number++] = p;
        solve_part(parts_[p], whole, nullptr, a, lambda);
      }
    }
  };
  touch(row);
  if (beside) touch(*beside);
  for (int p = 0; p < static_cast<int>(parts_.size()); ++p)
    if (!is_done(p))
      for (const int k : parts_[p].at.rows) lambda[k] = 0;
  for (const auto& x : fixed_) a[x.column] = 0;
  if (which == Multipliers::all) finish(whole, a, lambda);
  clear();
}

void SaddlePoint::respond_in(int part, std::span<const int> columns, std::span<const double> load,
                             double* a) {
  use_blocks();
  auto& p = parts_[part];
  std::fill_n(f_.begin(), p.at.columns.size(), 0.0);
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (part_of_column_[columns[i]] == part) f_[place_of_column_[columns[i]]] += load[i];
  p.block.solve(f_.data(), nullptr, a, lambda_.data());
  converged_ = converged_ && p.block.converged();
}

bool SaddlePoint::dense() const {
  return std::ranges::all_of(parts_, [](const Part& p) { return p.block.dense(); });
}
double SaddlePoint::nearest_singular() const {
  double least = 1;
  for (const auto& part : parts_) least = std::min(least, part.block.nearest_singular());
  return least;
}
bool SaddlePoint::singular() const {
  return std::ranges::any_of(parts_, [](const Part& p) { return p.block.singular(); });
}

void Responses::take(int r, const SparseRow& row, const SparseRow* beside, double factor) {
  auto& x = of_[r];
  x.size = 0;
  const auto load = [&](const SparseRow& from, double by) {
    for (int i = 0; i < from.size; ++i) {
      int at = 0;
      while (at < x.size && x.column[at] != from.column[i]) ++at;
      if (at == x.size) {
        x.column[x.size] = from.column[i];
        x.load[x.size++] = 0;
      }
      x.load[at] += by * from.value[i];
    }
  };
  load(row, 1);
  if (beside) load(*beside, factor);
  x.parts = 0;
  int entries = 0;
  for (int i = 0; i < x.size; ++i) {
    const int p = saddle_->part_of(x.column[i]);
    if (p < 0 || std::find(x.part.begin(), x.part.begin() + x.parts, p) != x.part.begin() + x.parts) continue;
    x.begin[x.parts] = entries;
    x.part[x.parts++] = p;
    entries += saddle_->part_size(p);
  }
  x.a.resize(static_cast<std::size_t>(entries));
  const auto size = static_cast<std::size_t>(x.size);
  for (int k = 0; k < x.parts; ++k)
    saddle_->respond_in(x.part[k], {x.column.data(), size}, {x.load.data(), size}, x.a.data() + x.begin[k]);
}

double Responses::along(const SparseRow& row, int r) const {
  const auto& x = of_[r];
  double sum = 0;
  for (int i = 0; i < row.size; ++i) {
    const int c = row.column[i], p = saddle_->part_of(c);
    if (p >= 0) {
      for (int k = 0; k < x.parts; ++k)
        if (x.part[k] == p) {
          sum += row.value[i] * x.a[x.begin[k] + saddle_->place_of(c)];
          break;
        }
    } else {
      for (int k = 0; k < x.size; ++k)
        if (x.column[k] == c) {
          sum += row.value[i] * (x.load[k] * saddle_->free_mobility(c));
          break;
        }
    }
  }
  return sum;
}

void Responses::add(int r, double by, double* a) const {
  const auto& x = of_[r];
  for (int k = 0; k < x.parts; ++k) {
    const auto& columns = saddle_->columns_of(x.part[k]);
    for (std::size_t i = 0; i < columns.size(); ++i)
      a[columns[i]] += by * x.a[x.begin[k] + static_cast<int>(i)];
  }
  for (int k = 0; k < x.size; ++k)
    if (saddle_->part_of(x.column[k]) < 0)
      a[x.column[k]] += by * (x.load[k] * saddle_->free_mobility(x.column[k]));
}

}  // namespace freeplay
