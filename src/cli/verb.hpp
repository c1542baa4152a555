// A verb of the program: its options, its help and what it does stand in a file of its own, src/cli/NAME.cpp,
// and its name on one line of verbs.def. The file defines `void NAME_verb(Program&)`, which declares the options
// and where they go; main runs the function of the verb that the command line names.
//
// Only command_line.cpp includes CLI11: it takes seconds to compile.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/scene/named_file.hpp"
#include "study/runs/case_run.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace freeplay::cli {

/// What every verb is asked with; its own options follow in a struct of its own.
struct Request {
  StopToken stop;  ///< asked by a signal
  Conduct conduct() const { return {true, stop}; }
};

/// An option that has been declared, to be restricted.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option& required();
  /// What the help shows in the place of its value: FOLDER, FILE, SECONDS.
  Option& takes(const char* what);
  Option& needs(const Option& other);
  Option& excludes(const Option& other);
  Option& one_of(const std::vector<std::string>& values);
  Option& between(int low, int high);
  /// A number for which `holds`; else the error says what it `must` be.
  Option& number(bool (*holds)(double), const char* must);
  /// The same of a percentage, with or without its sign.
  Option& percentage(bool (*holds)(double), const char* must);
  Option& shows_default();
  /// One value each time it is given; what follows may be something else.
  Option& one_each();

 private:
  CLI::Option* option_;
};

/// Declares a verb's options: their names, where they go, what they mean.
class Options {
 public:
  explicit Options(CLI::App* app) : app_(app) {}
  Option add(const char* names, std::string& value, const char* what);
  Option add(const char* names, int& value, const char* what);
  Option add(const char* names, double& value, const char* what);
  Option add(const char* names, std::optional<double>& value, const char* what);
  Option add(const char* names, std::vector<std::string>& value, const char* what);
  Option flag(const char* names, bool& value, const char* what);
  /// An option whose value may be left out, as in --hdf5 and --hdf5 FILE: empty then.
  Option maybe(const char* names, std::optional<std::string>& value, const char* what);

  /// Options that several verbs have.
  Option scene(std::string& file);
  Option set(std::vector<std::string>& overrides,
             const char* what = "override a key, KEY=VALUE; may be repeated");
  Option output(std::string& folder, const char* what);
  Option accuracy(std::string& level);
  /// Of verbs that read a study.
  Option allow_outside(Reach& reach);
  Option threads(int& count);
  /// What may be written.
  Option limit_output(double& gigabytes);

 private:
  CLI::App* app_;
};

/// The program's command line.
class Program {
 public:
  explicit Program(StopToken stop);
  ~Program();

  /// Adds the verb `name`, which does `what` by `act`, and returns where its options are declared with the request
  /// that they fill. Exit status of `act`: 0 done, 1 a solve gave up; bad input is thrown as SceneError.
  template <class Asked>
  std::pair<Options, Asked&> verb(const char* name, const char* what, int (*act)(const Asked&)) {
    auto request = std::make_shared<Asked>();
    request->stop = stop_;
    return {add(name, what, [request, act] { return act(*request); }), *request};
  }

  /// Does what the command line asks; the exit status.
  int run(int argc, char** argv);

 private:
  Options add(const char* name, const char* what, std::function<int()> act);
  void add_help();

  StopToken stop_;
  std::unique_ptr<CLI::App> app_;
  std::function<int()> chosen_;
};

#define VERB(name) void name##_verb(Program&);
#include "cli/verbs.def"
#undef VERB

}  // namespace freeplay::cli
