// Framework of the verbs of the programs freeplay and freeplay-verify. src/cli/NAME.cpp contains the
// options, the help and the implementation of the verb NAME, and verbs.def lists it. The file
// defines `void NAME_verb(Program&)`, which declares the options and the variables that receive
// them. main() executes the verb of the command line.
//
// Only command_line.cpp includes CLI11, because it takes seconds to compile.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/files/access.hpp"
#include "study/runs/case_run.hpp"
#include "values/family.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace freeplay::cli {

/// Base of the options of each verb.
struct Request {
  StopToken stop;  ///< requested by a signal
  Conduct conduct() const { return {true, stop}; }
};

/// A declared option, for further restrictions.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option& required();
  /// Placeholder of the value in the help: FOLDER, FILE, SECONDS.
  Option& takes(const char* what);
  Option& needs(const Option& other);
  Option& excludes(const Option& other);
  Option& one_of(const std::vector<std::string>& values);
  Option& between(int low, int high);
  /// Restricts a number to those for which `holds` is true. `must` completes the error message.
  Option& number(bool (*holds)(double), const char* must);
  /// Likewise for a percentage, with or without "%".
  Option& percentage(bool (*holds)(double), const char* must);
  /// Accepts a number in `unit`, or a text with a unit of its dimension, as keys of scenes do.
  Option& quantity(const char* unit);
  Option& shows_default();
  /// The option takes one value each time, and does not consume the following words.
  Option& one_each();

 private:
  CLI::Option* option_;
};

/// Declares the options of a verb: names, variables and meanings.
class Options {
 public:
  explicit Options(CLI::App* app) : app_(app) {}
  Option add(const char* names, std::string& value, const char* what);
  Option add(const char* names, int& value, const char* what);
  Option add(const char* names, double& value, const char* what);
  Option add(const char* names, std::optional<double>& value, const char* what);
  Option add(const char* names, std::vector<std::string>& value, const char* what);
  Option flag(const char* names, bool& value, const char* what);
  /// An option with an optional value, as in --hdf5 and --hdf5 FILE; without one it is empty.
  Option maybe(const char* names, std::optional<std::string>& value, const char* what);

  /// Options that several verbs have.
  Option scene(std::string& file);
  Option set(std::vector<std::string>& overrides,
             const char* what = "override a key, KEY=VALUE; may be repeated");
  Option output(std::string& folder, const char* what);
  Option formulation(std::string& name, const char* what = "penalty or nonsmooth");
  Option accuracy(std::string& level);
  /// Style of the figures, for plots::choose_style().
  Option style(std::string& preset_or_file);
  /// For verbs that read a study.
  Option allow_outside(Reach& reach);
  Option threads(int& count);
  /// Limit of the output.
  Option limit_output(double& gigabytes);

 private:
  CLI::App* app_;
};

/// The command line of a program. Owns the requests of all verbs.
class Program {
 public:
  explicit Program(StopToken stop);
  ~Program();

  /// Adds the verb `name` with the description `what`. Returns the object to declare its options,
  /// and the request that they fill. `act` executes the verb; its exit status is 0 when done and 1
  /// if a solve failed. Invalid input is thrown as SceneError.
  template <class Requested>
  std::pair<Options, Requested&> verb(const char* name, const char* what, int (*act)(const Requested&)) {
    auto request = std::make_shared<Requested>();
    request->stop = stop_;
    return {add(name, what, [request, act] { return act(*request); }), *request};
  }

  /// Adds a verb for which run() executes the second program, freeplay-verify, instead.
  void second_program_verb(const char* name, const char* what);

  /// Whether the command line may need the verb: it names this one, or none of the program's.
  bool declares(std::string_view name) const { return named_.empty() || named_ == name; }

  /// Executes the command line; returns the exit status.
  int run(int argc, char** argv);

 private:
  Options add(const char* name, const char* what, std::function<int()> act);
  void add_help();

  StopToken stop_;
  std::string named_;  // the verb of the command line; empty: all are declared
  std::unique_ptr<CLI::App> app_;
  std::function<int()> chosen_;
  std::vector<std::string> in_second_program_;
};

/// Adds the verbs of the program that it declares; each program defines it.
void declare_verbs(Program& program);

#define VERB(name) void name##_verb(Program&);
#define VERIFICATION_VERB(name, what)              \
  inline constexpr const char* name##_what = what; \
  VERB(name)
#include "cli/verbs.def"

// The option --accuracy, translated to overrides of a scene.

/// The overrides preceded by those of `accuracy` (fast, balanced, reference; empty: none), so that
/// --set has precedence.
std::vector<std::string> with_accuracy(const std::string& accuracy, const std::vector<Family>& families,
                                       const std::vector<std::string>& overrides);

}  // namespace freeplay::cli
