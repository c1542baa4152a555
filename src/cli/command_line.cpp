// Command line by CLI11: makes options and help (help.hpp) from the declarations of the verbs.

#include "cli/command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <regex>

#include "cli/cluster/shards.hpp"
#include "cli/help.hpp"
#include "io/files/build_identity.hpp"
#include "io/files/identity.hpp"
#include "io/scene/quantity.hpp"
#include "io/scene/spelling.hpp"
#include "study/comparison/settings.hpp"

namespace freeplay::cli {

std::vector<std::string> with_accuracy(const std::string& accuracy, const std::vector<Family>& families,
                                       const std::vector<std::string>& overrides) {
  std::vector<std::string> list;
  if (!accuracy.empty()) {
    const auto level = std::ranges::find(accuracies, accuracy, [](const auto& a) {
                         return std::string_view(a.text);
                       })->value;
    for (const auto family : families) {
      const auto keys = setting_for(family, level).keys();
      // The first key selects the scheme or integrator. If the user selects another, the accuracy
      // class does not apply.
      const auto choice = keys.front().substr(0, keys.front().find('=') + 1);
      const auto chooses = [&](const std::string& option) { return option.starts_with(choice); };
      if (std::ranges::none_of(overrides, chooses)) list.insert(list.end(), keys.begin(), keys.end());
    }
  }
  list.insert(list.end(), overrides.begin(), overrides.end());
  return list;
}

namespace {

/// Validator of a number; returns an empty text if `holds`, else the error.
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

const CLI::App* chosen_verb(const CLI::App& program) {
  const auto chosen = program.get_subcommands();
  return chosen.empty() ? nullptr : chosen.front();
}

std::vector<std::string> names_of_verbs(const CLI::App& program) {
  std::vector<std::string> names;
  for (const auto* verb : program.get_subcommands(nullptr)) names.push_back(verb->get_name());
  return names;
}

/// Text "needs --data" with all options.
std::string others(const char* what, const std::set<CLI::Option*>& options) {
  std::vector<std::string> names;
  for (const auto* option : options) names.push_back(option->get_name());
  std::ranges::sort(names);
  return names.empty() ? "" : fmt::format("; {} {}", what, fmt::join(names, ", "));
}

OptionHelp described(const CLI::Option& option) {
  const bool positional = option.get_positional();
  const auto takes = option.get_expected_max() == 0 ? "" : option.get_type_name();
  OptionHelp help{option.get_name(false, true), positional ? "" : takes,
                  option.get_description(),     positional,
                  option.get_required(),        option.get_items_expected_max() > 1};
  if (const auto fallback = option.get_default_str(); !fallback.empty())
    help.what += fmt::format("; default {}", fallback);
  help.what += others("needs", option.get_needs()) + others("not with", option.get_excludes());
  if (positional && takes.find('|') != takes.npos)
    help.what += ": " + std::regex_replace(takes, std::regex("\\|"), ", ");
  return help;
}

VerbHelp described(const CLI::App& verb) {
  VerbHelp help{verb.get_name(), verb.get_description(), {}};
  for (const auto* option : verb.get_options(nullptr)) help.options.push_back(described(*option));
  return help;
}

ProgramHelp overview(const CLI::App& program) {
  ProgramHelp help{program.get_description(), {}};
  for (const auto* verb : program.get_subcommands(nullptr))
    help.verbs.push_back({verb->get_name(), verb->get_description(), {}});
  return help;
}

/// The first unknown option of the command line, else its first unknown word; "" if there is none.
std::string not_expected(const CLI::App& program) {
  const auto words = program.remaining(true);
  const auto option = std::ranges::find_if(words, [](const auto& word) { return word.starts_with('-'); });
  return option != words.end() ? *option : words.empty() ? "" : words.front();
}

/// Error about an unknown word, with a suggestion.
std::string stray(const CLI::App& program, const std::string& word) {
  const auto* verb = chosen_verb(program);
  if (!word.starts_with('-')) {
    if (verb) return fmt::format("{}: unexpected argument of {}", word, verb->get_name());
    if (std::filesystem::exists(word))
      return fmt::format("{0}: the verb comes first, as in: freeplay check {0}", word);
    return fmt::format("{}: unknown verb{}", word, meant(word, names_of_verbs(program), "there are"));
  }
  const auto name = word.substr(0, word.find('='));
  std::vector<std::string> known;
  for (const auto* option : (verb ? *verb : program).get_options(nullptr))
    for (const auto& one : option->get_lnames()) known.push_back("--" + one);
  if (verb && divides(name)) return fmt::format("{}: {}", name, why_undivided(verb->get_name()));
  return fmt::format("{}: unknown option of {}{}", name,
                     verb ? verb->get_name() : "the program (options follow the verb)",
                     meant(name, known, "there are"));
}

/// Error about an invalid command line, with a reference to the help.
std::string refusal(const CLI::App& program, const CLI::ParseError& error) {
  const auto* verb = chosen_verb(program);
  const auto word = not_expected(program);
  const bool is_stray =
      error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError) && !word.empty();
  return fmt::format("freeplay{}{}: {}\nsee `freeplay help{}{}`\n", verb ? " " : "",
                     verb ? verb->get_name() : "", is_stray ? stray(program, word) : error.what(),
                     verb ? " " : "", verb ? verb->get_name() : "");
}

/// The verb of the command line, or the verb that its `help` describes; "" if there is none.
std::string named_verb(int argc, char** argv) {
  for (int i = 1; i < argc && argv[i] != std::string("--"); ++i)
    if (const std::string word = argv[i]; !word.starts_with('-') && word != "help") return word;
  return "";
}

/// Executes the program `name` of this program's folder with the same arguments, in this process.
/// Returns only if this fails.
int execute_beside(const char* name, const std::string& verb, char** argv) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").replace_filename(name);
  execv(program.c_str(), argv);
  fmt::print(stderr, "freeplay {}: needs the program {}: {}\n", verb, program.string(), std::strerror(errno));
  return 1;
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
Option& Option::takes(const char* what) {
  option_->type_name(what);
  return *this;
}
Option& Option::one_of(const std::vector<std::string>& values) {
  option_->type_name(fmt::format("{}", fmt::join(values, "|")));
  option_->check(CLI::Validator(
      [values](std::string& word) {
        if (std::ranges::find(values, word) != values.end()) return std::string();
        return fmt::format("{} is unknown{}", word, meant(word, values, "one of", Beside::list));
      },
      ""));
  return *this;
}
Option& Option::between(int low, int high) {
  option_->check(CLI::Validator(
      [=](std::string& text) {
        const long long n = std::strtoll(text.c_str(), nullptr, 10);
        return n >= low && n <= high ? std::string() : fmt::format("must be from {} to {}", low, high);
      },
      ""));
  option_->description(fmt::format("{}; {} to {}", option_->get_description(), low, high));
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
Option& Option::quantity(const char* unit) {
  option_->transform(CLI::Validator(
      [unit](std::string& text) {
        char* end = nullptr;
        std::strtod(text.c_str(), &end);
        if (end != text.c_str() && *end == 0) return std::string();
        const auto read = read_quantity(text, unit);
        if (read.wrong.empty()) text = fmt::format("{}", read.value);
        return read.wrong;
      },
      ""));
  return *this;
}
Option& Option::shows_default() {
  option_->capture_default_str();
  return *this;
}

Option& Option::one_each() {
  option_->allow_extra_args(false);
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

Option Options::maybe(const char* names, std::optional<std::string>& value, const char* what) {
  const auto take = [&value](const CLI::results_t& words) {
    value = words.empty() ? std::string() : words.front();
    return true;
  };
  return Option(app_->add_option(names, take, what)->expected(0, 1));
}

Option Options::scene(std::string& file) { return add("scene", file, "scene file"); }
Option Options::set(std::vector<std::string>& overrides, const char* what) {
  return Option(app_->add_option("--set", overrides, what)->allow_extra_args(false)->type_name("KEY=VALUE"));
}
Option Options::output(std::string& folder, const char* what) {
  return add("-o,--output", folder, what).takes("FOLDER");
}
Option Options::formulation(std::string& name, const char* what) {
  return add("--formulation", name, what).one_of(family_names()).shows_default();
}
Option Options::accuracy(std::string& level) {
  std::vector<std::string> levels;
  for (const auto& a : accuracies) levels.emplace_back(a.text);
  return add("--accuracy", level,
             "accuracy level of docs/verification/tradeoff.md, in place of the scene's settings")
      .one_of(levels);
}
Option Options::style(std::string& preset_or_file) {
  return add("--style", preset_or_file,
             "style of the figures: a style.toml, or journal-single, journal-double, slides")
      .takes("FILE|PRESET");
}
Option Options::allow_outside(Reach& reach) {
  return Option(app_->add_flag_callback(
      "--allow-outside", [&reach] { reach = Reach::anywhere; },
      "allow files outside the folder of the scene or study"));
}
Option Options::threads(int& count) {
  return add("--threads", count, "number of parallel runs; default one per core").between(1, 1024);
}

Option Options::limit_output(double& gigabytes) {
  return add("--limit-output", gigabytes,
             "limit of the output in GB; runs estimated above it are not "
             "started")
      .number([](double x) { return x > 0; }, "must be a number of GB greater than 0")
      .takes("GB")
      .shows_default();
}

Program::Program(StopToken stop)
    : stop_(stop),
      app_(std::make_unique<CLI::App>(
          "Freeplay: dynamics of mechanisms with clearance joints in two formulations")) {
  app_->set_version_flag("--version", "freeplay " + version_text());
  app_->set_help_flag("-h,--help", "print this help");
  app_->require_subcommand(0, 1);  // so that a word that is no command is named
}

Program::~Program() = default;

Options Program::add(const char* name, const char* what, std::function<int()> act) {
  auto* verb = app_->add_subcommand(name, what);
  verb->callback([this, act = std::move(act)] { chosen_ = act; });
  return Options(verb);
}

void Program::second_program_verb(const char* name, const char* what) {
  app_->add_subcommand(name, what);
  in_second_program_.emplace_back(name);
}

void Program::add_help() {
  const auto topic = std::make_shared<std::string>();
  auto options = add("help", "describe a verb and its options, or list all verbs", [this, topic] {
    if (topic->empty()) {
      fmt::print("{}", overview_page(overview(*app_)));
      return 0;
    }
    const auto verbs = names_of_verbs(*app_);
    if (std::ranges::find(verbs, *topic) == verbs.end()) {
      fmt::print(stderr, "freeplay help: unknown verb {}{}\n", *topic, meant(*topic, verbs, "there are"));
      return 2;
    }
    fmt::print("{}", verb_page(described(*app_->get_subcommand(*topic))));
    return 0;
  });
  options.add("verb", *topic, "verb to describe; default: list all verbs");
}

int Program::run(int argc, char** argv) {
  named_ = named_verb(argc, argv);
  declare_verbs(*this);
  if (app_->get_subcommands(nullptr).empty()) {
    named_.clear();
    declare_verbs(*this);
  }
  add_help();
  if (std::ranges::find(in_second_program_, named_) != in_second_program_.end())
    return execute_beside("freeplay-verify", named_, argv);
  try {
    app_->parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    const auto* verb = chosen_verb(*app_);
    fmt::print("{}", verb ? verb_page(described(*verb)) : overview_page(overview(*app_)));
    return 0;
  } catch (const CLI::CallForVersion& e) {
    const auto is_verbose = [](std::string_view word) { return word == "--verbose"; };
    const bool verbose = std::any_of(argv + 1, argv + argc, is_verbose);
    fmt::print("{}\n{}", e.what(), verbose ? program_identity() : "");
    return 0;
  } catch (const CLI::ParseError& e) {
    fmt::print(stderr, "{}", refusal(*app_, e));
    return 2;
  }
  if (chosen_) return chosen_();
  fmt::print(stderr, "{}", overview_page(overview(*app_)));
  return 2;
}

}  // namespace freeplay::cli
