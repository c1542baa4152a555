// The map of extreme parameters. Every cell is a scene at the limit of the permitted parameters,
// compared with a reference. A cell runs in its own process with a time limit, so a crash or a hang
// is an outcome too.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "values/table.hpp"
#include "verification/random_scenes/verdict.hpp"

namespace freeplay {
struct Scene;
}  // namespace freeplay

namespace freeplay::verification::random_scenes {

struct Cell {
  std::string axis, label;
  double value = 0;         ///< along the axis; 0 for single scenes
  std::string formulation;  ///< penalty, or nonsmooth
  std::function<Verdict()> assess;
  Verdict verdict = {};
};

/// A stability limit predicted by theory on an axis.
struct Limit {
  std::string axis, formulation;
  double value = 0;
  std::string source;
};

std::vector<Cell> rig_cells();      ///< the paper's rig along each axis, against the oracle
std::vector<Cell> special_cells();  ///< singular positions, redundancy, Painlevé, long runs
std::vector<Cell> loose_cells();    ///< two joints with clearance in one chain, a thousand revolutions with
                                    ///< clearance
/// Φ with Baumgarte stabilisation and rk4 of step h; hβ by hα over the grid, each row a separate
/// axis.
std::vector<Cell> baumgarte_cells();
inline constexpr double baumgarte_grid[] = {0, 0.3, 1, 2, 3};
/// Greatest factor by which a step of rk4 multiplies Φ at hα and hβ: above 1 it grows.
double rk4_growth(double ha, double hb);
std::vector<Limit> predicted_limits();

Scene ideal_rig();  ///< the paper's rig, without clearance or instruments

/// Assesses a cell in a child process; `seconds` is its time limit.
Verdict judge_apart(const Cell& cell, double seconds);

// Results of the map: the contents of its files, and its page.

/// The number of cells with each outcome that is no defect, in words.
std::string totals(const std::vector<Cell>& cells);
int defects(const std::vector<Cell>& cells);

/// extremes.json, without provenance: the cells and the predicted limits.
nlohmann::json to_json(const std::vector<Cell>& cells);
/// extremes.csv.
Table table_of(const std::vector<Cell>& cells);
/// limits.csv.
Table limits_table();
/// docs/verification/extremes.md.
std::string page_of(const std::vector<Cell>& cells);

}  // namespace freeplay::verification::random_scenes
