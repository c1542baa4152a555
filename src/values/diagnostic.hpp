// Diagnostics: the notes and warnings of a run. Each has one text, in diagnostics.def, with its
// meaning and remedy for the catalogue docs/reference/diagnostics.md. A note states a fact about
// the run; a warning states that a result may be wrong.
//
//     notes.push_back(diagnostic<Diagnostic::missed_contact>(depth));
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "values/warning.hpp"

namespace freeplay {

enum class Severity { note, warning };

enum class Diagnostic {
#define DIAGNOSTIC(name, severity, text, meaning) name,
#include "values/diagnostics.def"
#undef DIAGNOSTIC
};

struct DiagnosticFacts {
  std::string_view name;
  Severity severity;
  std::string_view text, meaning;
};

inline constexpr DiagnosticFacts diagnostics[] = {
#define DIAGNOSTIC(name, severity, text, meaning) {#name, Severity::severity, text, meaning},
#include "values/diagnostics.def"
#undef DIAGNOSTIC
};

/// The text of a diagnostic with its arguments, as a warning or as a note.
template <Diagnostic d, class... Arguments>
std::string diagnostic_as(Severity severity, const Arguments&... arguments) {
  constexpr std::string_view text = diagnostics[static_cast<int>(d)].text;
  return (severity == Severity::warning ? std::string(warning_prefix) : std::string()) +
         fmt::format(text, arguments...);
}

/// The same with its usual severity.
template <Diagnostic d, class... Arguments>
std::string diagnostic(const Arguments&... arguments) {
  return diagnostic_as<d>(diagnostics[static_cast<int>(d)].severity, arguments...);
}

}  // namespace freeplay
