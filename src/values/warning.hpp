// Warnings among the notes of a run.
#pragma once

#include <string_view>

namespace freeplay {

/// A note that begins so says why a result may be wrong.
inline constexpr std::string_view warning_prefix = "warning: ";

/// Results of earlier versions mark their warnings with "DOUBTFUL: ".
inline bool is_warning(std::string_view note) {
  return note.starts_with(warning_prefix) || note.starts_with("DOUBTFUL");
}

}  // namespace freeplay
