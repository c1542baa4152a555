// The command line, by CLI11: what a verb declares becomes its options and its help.
#include <CLI/CLI.hpp>

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <sstream>

#include "cli/verb.hpp"
#include "study/settings.hpp"
#include "version.hpp"

namespace freeplay::cli {
namespace {

/// Empty for a number of which `holds`, else what is wrong.
CLI::Validator number_that(bool (*holds)(double), const char* must, bool percent) {
  return CLI::Validator(
      [=](std::string& text) {
        if (percent && !text.empty() && text.back() == '%') text.pop_back();
        char* end = nullptr;
        const double x = std::strtod(text.c_str(), &end);
        return end != text.c_str() && *end == 0 && std::isfinite(x) && holds(x) ? std::string()
                                                                                : std::string(must);
      },
      "");
}

}  // namespace

Option& Option::required() {
  option_->required();
  return *this;
}
Option& Option::needs(const Option& other) {
  option_->needs(other.option_);
  return *this;
}
Option& Option::excludes(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}
Option& Option::one_of(const std::vector<std::string>& values) {
  option_->check(CLI::IsMember(values));
  return *this;
}
Option& Option::between(int low, int high) {
  option_->check(CLI::Range(low, high));
  return *this;
}
Option& Option::number(bool (*holds)(double), const char* must) {
  option_->check(number_that(holds, must, false));
  return *this;
}
Option& Option::percentage(bool (*holds)(double), const char* must) {
  option_->transform(number_that(holds, must, true));
  return *this;
}
Option& Option::shows_default() {
  option_->capture_default_str();
  return *this;
}

Option Options::add(const char* names, std::string& value, const char* what) {
  return Option(app_->add_option(names, value, what));
}
Option Options::add(const char* names, int& value, const char* what) {
  return Option(app_->add_option(names, value, what));
}
Option Options::add(const char* names, double& value, const char* what) {
  return Option(app_->add_option(names, value, what));
}
Option Options::add(const char* names, std::optional<double>& value, const char* what) {
  return Option(app_->add_option(names, value, what));
}
Option Options::add(const char* names, std::vector<std::string>& value, const char* what) {
  return Option(app_->add_option(names, value, what));
}
Option Options::flag(const char* names, bool& value, const char* what) {
  return Option(app_->add_flag(names, value, what));
}

Option Options::scene(std::string& file) { return add("scene", file, "scene file"); }
Option Options::set(std::vector<std::string>& overrides, const char* what) {
  return Option(app_->add_option("--set", overrides, what)->allow_extra_args(false));
}
Option Options::output(std::string& folder, const char* what) { return add("-o,--output", folder, what); }
Option Options::accuracy(std::string& level) {
  std::vector<std::string> levels;
  for (const auto& a : accuracies) levels.emplace_back(a.text);
  return add("--accuracy", level, "settings by docs/tradeoff.md instead of the scene's").one_of(levels);
}
Option Options::allow_outside(Reach& reach) {
  return Option(app_->add_flag_callback(
      "--allow-outside", [&reach] { reach = Reach::anywhere; },
      "let the scene or study name files that do not lie beside it or below"));
}
Option Options::threads(int& count) {
  return add("--threads", count, "how many runs at a time; default one for each core").between(1, 1024);
}

Option Options::limit_output(double& gigabytes) {
  return add("--limit-output", gigabytes, "GB that may be written; what is estimated to be more is not begun")
      .number([](double x) { return x > 0; }, "must be a number of GB greater than 0")
      .shows_default();
}

Program::Program(StopToken stop)
    : stop_(stop),
      app_(std::make_unique<CLI::App>(
          "Freeplay: dynamics of mechanisms with clearance joints in two formulations")) {
  app_->set_version_flag("--version", fmt::format("freeplay {} ({})", version, commit));
  app_->require_subcommand(0, 1);  // so that a word that is no command is named
#define VERB(name) name##_verb(*this);
#include "cli/verbs.def"
#undef VERB
}

Program::~Program() = default;

Options Program::add(const char* name, const char* what, std::function<int()> act) {
  auto* verb = app_->add_subcommand(name, what);
  verb->callback([this, act = std::move(act)] { chosen_ = act; });
  return Options(verb);
}

int Program::run(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    std::ostringstream out, err;
    const int status = app_->exit(e, out, err) == 0 ? 0 : 2;
    fmt::print("{}", out.str());
    fmt::print(stderr, "{}", err.str());
    return status;
  }
  if (chosen_) return chosen_();
  fmt::print(stderr, "{}", app_->help());
  return 2;
}

}  // namespace freeplay::cli
