#include "numerics/responses.hpp"

#include <algorithm>

namespace freeplay {

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
  x.part.fill(-1);
  int parts = 0;
  for (int i = 0; i < x.size; ++i) {
    const int p = saddle_->part_of(x.column[i]);
    if (p < 0 || std::find(x.part.begin(), x.part.begin() + parts, p) != x.part.begin() + parts) continue;
    auto& a = x.a[parts];
    x.part[parts++] = p;
    a.resize(static_cast<std::size_t>(saddle_->part_size(p)));
    const auto size = static_cast<std::size_t>(x.size);
    saddle_->respond_in(p, {x.column.data(), size}, {x.load.data(), size}, a.data());
  }
}

double Responses::along(const SparseRow& row, int r) const {
  const auto& x = of_[r];
  double sum = 0;
  for (int i = 0; i < row.size; ++i) {
    const int c = row.column[i], p = saddle_->part_of(c);
    if (p >= 0) {
      for (std::size_t k = 0; k < x.part.size() && x.part[k] >= 0; ++k)
        if (x.part[k] == p) {
          sum += row.value[i] * x.a[k][saddle_->place_of(c)];
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
  for (std::size_t k = 0; k < x.part.size() && x.part[k] >= 0; ++k) {
    const auto& columns = saddle_->columns_of(x.part[k]);
    for (std::size_t i = 0; i < columns.size(); ++i) a[columns[i]] += by * x.a[k][i];
  }
  for (int k = 0; k < x.size; ++k)
    if (saddle_->part_of(x.column[k]) < 0)
      a[x.column[k]] += by * (x.load[k] * saddle_->free_mobility(x.column[k]));
}

}  // namespace freeplay
