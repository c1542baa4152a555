#include "cli/help.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

#include "cli/terminal.hpp"

namespace freeplay::cli {
namespace {

struct Page {
  std::string_view verb, text;
};
constexpr Page pages[] = {
#include "help.inc"
};

constexpr std::size_t column = 26;  ///< column of the descriptions

/// "  NAME   what" with indented continuation lines; a name that is too long is on a line of its
/// own.
std::string row(const std::string& name, const std::string& what, std::size_t at = column) {
  const auto head = "  " + name;
  const auto gap = head.size() + 2 <= at ? std::string(at - head.size(), ' ') : "\n" + std::string(at, ' ');
  return wrapped(head + gap + what + "\n", at);
}

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

/// Placeholder of an option's value; CLI11's type names are replaced.
std::string value_of(const OptionHelp& option) {
  if (option.takes == "INT") return "N";
  if (option.takes == "FLOAT") return "X";
  return option.takes;
}

std::string usage_of(const OptionHelp& option) {
  if (!option.positional)
    return fmt::format(" {} {}", option.names.substr(option.names.find("--")), value_of(option));
  const auto name = upper(option.names) + (option.many ? "..." : "");
  return option.required ? " " + name : " [" + name + "]";
}

std::string row_of(const OptionHelp& option) {
  if (option.positional) return row(upper(option.names), option.what);
  auto names = option.names;
  if (const auto comma = names.find(','); comma != names.npos) names.insert(comma + 1, " ");
  const auto value = value_of(option);
  return row(names + (value.empty() ? "" : " ") + value, option.what);
}

/// Description of a verb besides its options; "" if there is none.
std::string_view text_of(std::string_view verb) {
  const auto* page = std::ranges::find(pages, verb, &Page::verb);
  return page == std::end(pages) ? "" : page->text;
}

}  // namespace

std::string overview_page(const ProgramHelp& program) {
  auto text = wrapped(program.what + "\n", 0) + "\nusage: freeplay VERB [OPTIONS]\n\n";
  for (const auto& verb : program.verbs) text += row(verb.name, verb.what, 15);
  text += "\n" + row("--version", "print version and commit", 15);
  return text + "\n" + std::string(text_of("freeplay"));
}

std::string verb_page(const VerbHelp& verb) {
  std::string usage = "usage: freeplay " + verb.name, positionals, options;
  for (const auto& option : verb.options) {
    if (option.positional || option.required) usage += usage_of(option);
    (option.positional ? positionals : options) += row_of(option);
  }
  auto text = wrapped(fmt::format("freeplay {}: {}\n", verb.name, verb.what), 0) + "\n" +
              wrapped(usage + " [OPTIONS]\n", 9) + "\n";
  text += positionals + (positionals.empty() ? "" : "\n") + options;
  if (const auto more = text_of(verb.name); !more.empty()) text += "\n" + std::string(more);
  return text;
}

}  // namespace freeplay::cli
