// `freeplay check` of thousands of bodies: memory and time grow in proportion to them.
#include <sys/wait.h>
#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>

#include "dynamics/assembly/four_bar.hpp"
#include "mechanism/mechanism.hpp"
#include "numerics/sparse.hpp"
#include "verification/support/rig.hpp"
#include "verification/timing/scaling.hpp"

using namespace freeplay;

namespace {

/// Pendulums side by side, or each attached to the one before; their pins with clearance or
/// without.
std::string pendulums(int count, bool chain, bool clearance_joint) {
  auto text = test::surface("steel", 0.5, "young = 2e11\npoisson = 0.3\n") + test::run_for(0.01);
  const auto keys = clearance_joint ? test::loose(1e-3, 0.02, "steel") : "";
  for (int i = 0; i < count; ++i) {
    const auto self = fmt::format("b{}", i), before = fmt::format("b{}", i - 1);
    const bool on_ground = !chain || i == 0;
    text += test::body(self, 1, 0.1, fmt::format("position = [{}, 0]\n", i + 0.5)) +
            test::pin(fmt::format("j{}", i), on_ground ? "ground" : before, self,
                      {on_ground ? double(i) : 0.5, 0}, {-0.5, 0}, keys);
  }
  return text;
}

/// Rows of a planar chain of links: two for each joint, with the previous link and the link itself.
struct Rows {
  CsrPattern pattern;
  std::vector<double> values, mass;
};
Rows chain(int links) {
  Rows x;
  x.pattern.columns = 3 * links;
  x.mass.assign(static_cast<std::size_t>(x.pattern.columns), 1.0);
  const auto put = [&](int column, double value) {
    x.pattern.column.push_back(column);
    x.values.push_back(value);
  };
  for (int k = 0; k < links; ++k)
    for (const int axis : {0, 1}) {
      if (k > 0) {
        put(3 * (k - 1) + axis, -1);
        put(3 * (k - 1) + 2, axis == 0 ? -0.3 : 0.4);
      }
      put(3 * k + axis, 1);
      put(3 * k + 2, axis == 0 ? 0.3 : -0.4);
      x.pattern.end_row();
    }
  return x;
}

}  // namespace

// 2.4 GB and minutes when memory grew with the square of the bodies; in proportion, a kilobyte or
// two for each, in addition to the program with its libraries (about 0.3 GB of addresses). Bounds:
// 1 GB of addresses, 20 s of processor time.
TEST_CASE("check of 4096 bodies takes memory and time in proportion", "[check][large]") {
  const test::TemporaryFolder folder;
  for (const auto& [shape, text] : {std::pair{"loose pins side by side", pendulums(4096, false, true)},
                                    {"pins side by side", pendulums(4096, false, false)},
                                    {"a chain", pendulums(4096, true, false)}}) {
    INFO(shape);
    const auto file = folder.path() / "scene.toml";
    std::ofstream(file) << text;
    const auto command = fmt::format("ulimit -v 1000000; ulimit -t 20; {}/freeplay check {} >{}",
                                     FREEPLAY_BINARY_DIR, file.string(), (folder.path() / "out").string());
    const int status = std::system(command.c_str());
    CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
  }
}

TEST_CASE("independent rows of a chain, and of one with two redundant end constraints", "[check][large]") {
  for (const int links : {3, 40, 4000}) {
    auto x = chain(links);
    CHECK(independent_rows(x.pattern, x.values, x.mass).size() == static_cast<std::size_t>(2 * links));
    // A row that is the sum of two others, and a multiple of the first.
    const auto copy = [&](int row, double scale) {
      for (int e = x.pattern.begin[row]; e < x.pattern.begin[row + 1]; ++e) {
        x.pattern.column.push_back(x.pattern.column[e]);
        x.values.push_back(scale * x.values[e]);
      }
    };
    copy(0, 3);
    x.pattern.end_row();
    copy(2, 1);
    x.pattern.end_row();
    CHECK(independent_rows(x.pattern, x.values, x.mass).size() == static_cast<std::size_t>(2 * links));
  }
}

TEST_CASE("the triangular factor finds the rank of a dense factorisation", "[check][large]") {
  std::mt19937 engine(7);
  for (int trial = 0; trial < 200; ++trial) {
    Rows x;
    const int n = 3 * (2 + static_cast<int>(engine() % 10)),
              m = 1 + static_cast<int>(engine() % static_cast<unsigned>(n));
    x.pattern.columns = n;
    x.mass.assign(static_cast<std::size_t>(n), 1.0);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(m, n);
    for (int k = 0; k < m; ++k) {
      const int first = 3 * static_cast<int>(engine() % static_cast<unsigned>(n / 3));
      for (int c = 0; c < 6; ++c) {
        const int column = (first + c) % n;
        // often dependent
        const double value = c == 0 ? 1.0 : static_cast<double>(engine() % 3) - 1;
        if (value == 0) continue;
        x.pattern.column.push_back(column);
        x.values.push_back(value);
        dense(k, column) += value;
      }
      x.pattern.end_row();
    }
    const auto kept = independent_rows(x.pattern, x.values, x.mass);
    const auto rank = Eigen::FullPivLU<Eigen::MatrixXd>(dense).rank();
    CHECK(static_cast<Eigen::Index>(kept.size()) == rank);
    CHECK(Eigen::FullPivLU<Eigen::MatrixXd>(dense(kept, Eigen::all)).rank() == rank);
  }
}

// The cost of large mechanisms, in counts. A contact problem close to that of the step before is
// solved in one or two steps of Newton's method, for any number of contacts. `freeplay scaling`
// measures the times.

TEST_CASE("a problem of many contacts takes no more pivots than one of few", "[islands][scaling]") {
  const auto growths = verification::growths();
  for (const char* name : {"row", "chain"}) {
    const auto& growth = *std::ranges::find(growths, name, &verification::Growth::name);
    for (const int count : {32, 256}) {
      const auto cost = verification::measure(growth, count, 1);
      CAPTURE(name, count);
      CHECK(cost.ending.empty());
      CHECK(cost.units >= 500);
      CHECK(cost.solves <= 1.1);  // per step
      CHECK(cost.pivots <= 4);    // one to confirm an unchanged solution, another after a change
    }
  }
}
