// The rig of most tests: Catch2, scenes as text, methods, runs that have to finish, and their rows
// and files.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>
#include <vector>

#include "facade/simulation.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/scene.hpp"
#include "verification/support/runs.hpp"
#include "verification/support/support.hpp"
#include "verification/support/ways.hpp"

namespace freeplay::test {

/// Errors at some steps or tolerances decrease with an order between two bounds.
template <class ErrorAt>
void check_order(const std::vector<double>& steps, const ErrorAt& error_at, double least, double greatest) {
  std::vector<double> errors;
  for (const double h : steps) errors.push_back(error_at(h));
  CAPTURE(steps, errors);
  const double order = observed_order(steps, errors);
  CHECK(order > least);
  CHECK(order < greatest);
}

/// Runs the program, which has to succeed.
inline Outcome succeeded(const std::string& arguments) {
  auto outcome = freeplay(arguments);
  CAPTURE(arguments, outcome.out, outcome.err);
  REQUIRE(outcome.status == 0);
  return outcome;
}

/// Runs the program, which has to refuse its arguments with a message that matches.
template <class Matcher>
Outcome refused(const std::string& arguments, const Matcher& message) {
  auto outcome = freeplay(arguments);
  CAPTURE(arguments, outcome.out);
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.err, message);
  return outcome;
}

/// The message of each case, by a function of its text, contains the words beside it.
template <class Message>
void check_messages(const Message& message, const std::vector<std::pair<std::string, std::string>>& cases) {
  for (const auto& [text, words] : cases) {
    CAPTURE(text);
    CHECK_THAT(message(text), Catch::Matchers::Contains(words));
  }
}

// Rows of a motion at equal intervals, by the dense output that writes trajectory.csv.

/// t, and coordinates and velocities of all bodies.
struct MotionRow {
  double t;
  std::vector<double> q, v;
};

struct MotionRows {
  std::vector<MotionRow> rows;
  Result run;
  /// Greatest size of error(row).
  template <class Error>
  double worst(const Error& error) const {
    double most = 0;
    for (const auto& row : rows) most = std::max(most, std::abs(error(row)));
    return most;
  }
};

/// Of a run that has to finish, at intervals of `apart` seconds.
inline MotionRows motion_rows(const Scene& scene, Family family, double apart) {
  MotionRows out;
  Simulation simulation(scene, name_of(family));
  const auto size = simulation.state().q.size();
  Listener look;
  double next = 0;
  look.on_step = [&](const Step& step) {
    for (; next <= step.t1; next += apart) {
      out.rows.push_back({next, std::vector<double>(size), std::vector<double>(size)});
      step.state(next, out.rows.back().q, out.rows.back().v);
    }
  };
  out.run = finished(simulation, {&look});
  return out;
}

}  // namespace freeplay::test
