// The commands. Each returns the exit status: 0 done, 1 a solve gave up. Bad input is thrown as SceneError.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "study/case_run.hpp"

namespace freeplay {
struct Study;
struct CalibrationResult;
}  // namespace freeplay

namespace freeplay::cli {

struct Request;
using Command = int (*)(const Request&);

struct Request {
  Command command = nullptr;
  std::string scene;  ///< scene file, or for figures the result folder
  std::vector<std::string> overrides;
  std::string formulation;
  std::string output;
  bool as_given = false;
  std::optional<double> restitution;  ///< laws
  double mass = 1, speed = 0.1;       ///< laws: kg and m/s of the impact that is drawn
  std::vector<std::string> names;     ///< verify: sets of claims; none: all
  std::string data;                   ///< validate: measured file
  int repeats = 3;                    ///< tradeoff: runs of each setting
  double error = 1;                   ///< advise: %
  bool why = false;                   ///< check: reasons of what is left out
  std::string accuracy;               ///< run, compare: fast, balanced or reference
  int threads = 0;                    ///< sweep: 0 for all cores
  std::string document;               ///< verify: folder for verification.md and its figures
  bool forces = false;                ///< run, compare: forces.csv too
  std::string resume;                 ///< run: folder of an interrupted run
  double checkpoint = 30;             ///< run: s of wall time between checkpoints
  StopToken stop;                     ///< asked by a signal
  Conduct conduct() const { return {true, stop}; }
};

int check(const Request& request);
int run(const Request& request);
int compare(const Request& request);
int drift(const Request& request);
int laws(const Request& request);
int figures(const Request& request);
int verify(const Request& request);
nlohmann::json to_json(const Study& study, const CalibrationResult& result);
int sweep(const Request& request);
int calibrate(const Request& request);
int extremes(const Request& request);
int tradeoff(const Request& request);
int advise(const Request& request);
int validate(const Request& request);
int validate_data(const Request& request);
int validate_study(const Request& request);

}  // namespace freeplay::cli
