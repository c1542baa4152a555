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
