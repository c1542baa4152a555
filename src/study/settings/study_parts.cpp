#include "study/settings/study_parts.hpp"

#include <fmt/format.h>

#include "io/scene/toml_text.hpp"

namespace freeplay {

std::string said(const Measure& m) {
  if (!m.waveform.empty())
    return fmt::format("measure.{} = [waveform {}, {}]\n", m.name, m.digest, toml_number(m.tolerance));
  auto text =
      fmt::format("measure.{} = [{}, {}", m.name, toml_quoted(m.column), toml_quoted(text_of(m.reduce)));
  if (m.reduce == Reduce::quantile) text += ", " + toml_number(m.q);
  if (m.each_period) text += ", \"each period\"";
  if (!m.at.empty()) text += ", at " + toml_quoted(m.at);
  return text + "]\n";
}

}  // namespace freeplay
