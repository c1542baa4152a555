// Cost of a step against the number of loose joints (target freeplay-scaling): a row of four-bars, one loose
// joint each, stepped for 0.05 s at 1e-4 s. Writes scaling.csv and draws it, in the folder given.
#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "io/run_json.hpp"
#include "model/scene.hpp"
#include "plots/figure.hpp"
#include "verification/support.hpp"

using namespace freeplay;

int main(int count, char** arguments) {
  const std::filesystem::path folder = count > 1 ? arguments[1] : "scaling";
  std::filesystem::create_directories(folder);
  std::ofstream csv(folder / "scaling.csv");
  csv << "solver,joints,us_per_step,solves_per_step,pivots_per_solve,lasting\n";
  const std::pair<LcpSolver, const char*> solvers[] = {{LcpSolver::gauss_seidel, "gauss-seidel"},
                                                       {LcpSolver::lemke, "lemke"},
                                                       {LcpSolver::automatic, "automatic"}};
  std::vector<plots::Block> blocks;
  for (const auto& solver : solvers)
    blocks.emplace_back(fmt::format("{}: loose joints, microseconds per step", solver.second));
  for (int joints = count > 3 ? std::atoi(arguments[3]) : 1;
       joints <= (count > 2 ? std::atoi(arguments[2]) : 64); joints *= 2)
    for (int s = 0; s < 3; ++s) {
      if (joints > 64 && s < 2) continue;
      auto scene = test::row_of_four_bars(joints, 1e-3);
      scene.run.duration = 0.05;
      scene.nonsmooth.solver = solvers[s].first;
      double best = INFINITY;
      Result run;
      for (int i = 0; i < 3; ++i) {
        run = test::simulate(scene, Family::nonsmooth);
        best = std::min(best, run.cpu_seconds);
      }
      double lasting = 0;
      for (const auto& c : run.contacts) lasting += c.lasting_fraction / joints;
      const double us = 1e6 * best / static_cast<double>(run.work.steps);
      const auto line =
          fmt::format("{},{},{:.2f},{:.2f},{:.1f},{:.2f}", solvers[s].second, joints, us,
                      double(run.work.lcp_solves) / double(run.work.steps),
                      double(run.work.pivots) / double(std::max(1L, run.work.lcp_solves)), lasting);
      csv << line << "\n";
      fmt::print("{}  {}\n", line, run.ending.reason);
      blocks[s].row({static_cast<double>(joints), us});
    }
  csv.close();
  auto origin = provenance(test::row_of_four_bars(1, 1e-3));
  origin["scene_file"] = "row of four-bars (A02)";
  std::ofstream(folder / "scaling.json") << nlohmann::json{{"provenance", origin}};
  plots::Figure f{.name = "scaling", .blocks = blocks, .source = "scaling.json"};
  f.script.add(
      "set logscale xy\nset xlabel 'Loose joints'\nset ylabel 'CPU time per step (µs)'\nset key top left\n"
      "plot DATA index 0 using 1:2 with linespoints ls 1 title 'Gauss-Seidel', '' index 1 using 1:2 with "
      "linespoints ls 2 title 'Lemke', '' index 2 using 1:2 with linespoints ls 3 title 'automatic', "
      "[1:64] 4*x with lines ls 4 title 'linear'\n");
  fmt::print("{}\n", plots::draw(f, folder).string());
}
