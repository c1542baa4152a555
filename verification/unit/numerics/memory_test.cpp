// Serialization of data that persists from step to step, bit for bit. A factorisation is serialized and
// restored in a new one, and both continue with the same calls: every component must be equal, not only
// close. Integrators are restored with whole runs, in property/comparison/snapshot_test.cpp.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "formulations/integrators/rosenbrock.hpp"
#include "numerics/saddle_point.hpp"
#include "values/memory.hpp"
#include "values/table.hpp"

using namespace freeplay;

namespace {

template <class T>
std::vector<std::byte> memory_of(T& x) {
  std::vector<std::byte> bytes;
  MemoryWriter writer(bytes);
  writer(x);
  return bytes;
}
template <class T>
void recall(T& x, const std::vector<std::byte>& bytes) {
  MemoryReader reader(bytes);
  reader(x);
  REQUIRE(reader.at_end());
}

/// A chain of rows of six entries, as in saddle_point_test.cpp, and the last row with one entry.
struct Chain {
  std::vector<double> mass, values;
  CsrPattern G;
  Chain(std::mt19937& engine, int columns, int rows, int copies) {
    std::uniform_real_distribution<double> u(-1, 1);
    G.columns = columns;
    for (int i = 0; i < columns; ++i) mass.push_back(std::exp(3 * u(engine)));
    for (int k = 0; k < rows + copies; ++k) {
      const int original = k < rows ? k : k - rows,
                first = std::min(columns - 6, original * (columns - 6) / rows);
      for (int c = first; c < first + 6; ++c) {
        G.column.push_back(c);
        values.push_back(k < rows ? u(engine)
                                  : 2 * values[6 * static_cast<std::size_t>(original) + c - first]);
      }
      G.end_row();
    }
    G.column.push_back(columns - 1);
    values.push_back(1);
    G.end_row();
  }
};

struct Solution {
  std::vector<double> a, lambda;
  bool converged, singular;
  double nearest;
  bool operator==(const Solution&) const = default;
};

Solution solve(SaddlePoint& solver, const Chain& chain, bool respond) {
  Solution s{std::vector<double>(chain.mass.size()), std::vector<double>(chain.G.rows), true, true, 0};
  if (respond) {
    SparseRow row;
    for (const int c : {1, 2, 3, chain.G.columns - 2}) row.push(c, 0.3 * c);
    solver.respond(row, nullptr, 0, s.a.data(), s.lambda.data());
  } else {
    std::vector<double> f(chain.mass.size()), r(chain.G.rows);
    for (std::size_t i = 0; i < f.size(); ++i) f[i] = std::sin(1.0 + static_cast<double>(i));
    solver.solve(f.data(), r.data(), s.a.data(), s.lambda.data());
  }
  s.converged = solver.converged();
  s.singular = solver.singular();
  s.nearest = solver.nearest_singular();
  return s;
}

}  // namespace

TEST_CASE("serialized state of one integrator is refused by another", "[memory]") {
  const auto still = [](const Vector&, Vector& dxdt, double) { std::ranges::fill(dxdt, 0); };
  const ErrorNorm norm{{1}, {1}, 1e-8};
  Dopri5 dopri(norm, 1e-3);
  dopri.start(still, 0, Vector{1.0});
  const auto bytes = memory_of(dopri);
  Rosenbrock rosenbrock(norm, 1e-3);
  MemoryReader reader(bytes);
  CHECK_THROWS_AS(reader(rosenbrock), MemoryError);
}

TEST_CASE("a factorisation restored from its serialized state continues bit for bit", "[memory][saddle]") {
  struct Kind {
    int rows, copies;
    SolvePath path;
    RowFacts facts;
  };
  for (const Kind& kind :
       {Kind{41, 0, SolvePath::automatic, {}}, Kind{41, 0, SolvePath::automatic, {false, false}},
        Kind{20, 0, SolvePath::automatic, {}}, Kind{41, 2, SolvePath::sparse, {}},
        Kind{41, 2, SolvePath::sparse, {true, false}}, Kind{20, 2, SolvePath::dense, {}}}) {
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> u(-1, 1);
    Chain chain(engine, 80, kind.rows, kind.copies);
    const auto make = [&] { return SaddlePoint(chain.mass, chain.G, kind.path, kind.facts); };
    SaddlePoint solver = make(), never = make();
    {
      SaddlePoint other = make();
      recall(other, memory_of(never));  // before the first factorisation
    }
    // Copies of rows remain copies. KLU changes pivots only for entries a thousand times as great,
    // so entries vary over many magnitudes, and change their sign.
    const auto drift = [&] {
      const std::size_t originals = 6 * static_cast<std::size_t>(kind.rows);
      for (std::size_t e = 0; e < originals; ++e)
        chain.values[e] = std::copysign(std::pow(std::abs(chain.values[e]), 0.9), u(engine) + 0.8) *
                          std::exp(3 * u(engine));
      for (std::size_t e = 0; e < 6 * static_cast<std::size_t>(kind.copies); ++e)
        chain.values[originals + e] = 2 * chain.values[e];
    };
    int pivots_matter = 0;
    for (int moment = 0; moment < 20; ++moment) {
      for (auto steps = 1 + engine() % 10; steps > 0; --steps) {
        drift();
        REQUIRE(solver.factor(chain.values.data()));
      }
      if (moment % 4 == 3) {  // refused values in between
        auto bad = chain.values;
        bad[bad.size() / 2] = NAN;
        REQUIRE_FALSE(solver.factor(bad.data()));
        REQUIRE(solver.factor(chain.values.data()));
      }
      SaddlePoint restored = make(), fresh = make();
      recall(restored, memory_of(solver));
      CHECK(memory_of(restored) == memory_of(solver));
      REQUIRE(fresh.factor(chain.values.data()));
      const auto now = solve(solver, chain, false);
      pivots_matter += now.a != solve(fresh, chain, false).a;
      REQUIRE(solve(restored, chain, false) == now);
      REQUIRE(solve(restored, chain, true) == solve(solver, chain, true));
      for (int i = 0; i < 10; ++i) {
        drift();
        REQUIRE(solver.factor(chain.values.data()));
        REQUIRE(restored.factor(chain.values.data()));
        REQUIRE(solve(restored, chain, i % 3 == 0) == solve(solver, chain, i % 3 == 0));
      }
    }
    // The test is effective: where pivots are kept, a new factorisation gives other digits. For
    // dependent rows pivots are chosen anew every time.
    const bool kept = !solver.dense() && (kind.copies == 0 || kind.facts.redundant);
    CHECK((pivots_matter > 10) == kept);

    auto bytes = memory_of(solver);
    for (const std::size_t size : {bytes.size() - 1, bytes.size() / 2, std::size_t{3}}) {
      SaddlePoint cut = make();
      MemoryReader reader{std::span(bytes).first(size)};
      CHECK_THROWS_AS(reader(cut), MemoryError);
    }
    std::vector<std::byte> other;
    MemoryWriter writer(other);
    writer.part("something else");
    SaddlePoint wrong = make();
    MemoryReader reader(other);
    CHECK_THROWS_AS(reader(wrong), MemoryError);
  }
}

TEST_CASE("containers and parts are serialized and restored", "[memory]") {
  std::vector<std::byte> bytes;
  MemoryWriter writer(bytes);
  std::vector<std::vector<double>> table{{1, -0.0}, {}, {NAN}};
  std::optional<int> some = 3, none;
  std::string text = "gap";
  writer.part("one");
  writer(table, some, none, text);
  decltype(table) table_read;
  std::optional<int> some_read, none_read = 4;
  std::string text_read;
  MemoryReader reader(bytes);
  reader.part("one");
  reader(table_read, some_read, none_read, text_read);
  CHECK(reader.at_end());
  REQUIRE(table_read.size() == 3);
  CHECK(table_read[0] == table[0]);
  CHECK(std::signbit(table_read[0][1]));
  CHECK(std::isnan(table_read[2][0]));
  CHECK(some_read == some);
  CHECK_FALSE(none_read);
  CHECK(text_read == text);
  MemoryReader again(bytes);
  CHECK_THROWS_AS(again.part("two"), MemoryError);
}

// Tables of results: their writers, against texts written by hand.

TEST_CASE("a table is written as CSV, as Markdown and for a terminal", "[table]") {
  Table t("setting,events,CPU ms");
  t.row("fast", "-", 1.5);
  t.row("a long name", 12, 0.1);
  t.row(std::vector<Table::Cell>{"ä", "x", std::int64_t{1}});
  CHECK(t.csv() == "setting,events,CPU ms\nfast,-,1.5\na long name,12,0.1\nä,x,1\n");
  CHECK(t.csv_rows(2) == "ä,x,1\n");
  CHECK(t.markdown() ==
        "| setting | events | CPU ms |\n| --- | --- | --- |\n| fast | - | 1.5 |\n"
        "| a long name | 12 | 0.1 |\n| ä | x | 1 |\n");
  CHECK(t.terminal({8, 8, 7}, true) ==
        "setting   events CPU ms\n-------- ------- ------\nfast           -    1.5\n"
        "a long name\n              12    0.1\nä              x      1\n");
  Table n({"n", "µs"});
  n.row(3, "4");
  CHECK(n.terminal({-4, 5}) == "   n   µs\n   3    4\n");
}
