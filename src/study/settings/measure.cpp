#include "study/settings/measure.hpp"

#include <fmt/format.h>

#include "io/scene/section.hpp"
#include "io/scene/toml_value.hpp"

namespace freeplay {

Measure read_measure(const std::string& name, Section& s) {
  Measure m;
  m.name = name;
  m.column = s.text("column");
  std::vector<std::string> words;
  for (const auto& choice : reduce_names) words.emplace_back(choice.text);
  m.reduce = reduce_names[static_cast<std::size_t>(s.choice("reduce", words))].value;
  if (m.reduce == Reduce::quantile)
    m.q = s.number("q", zero_to_one);
  else if (s.has("q"))
    s.fail("q", "applies only to reduce = \"quantile\"");
  if (s.has("each")) {
    (void)s.choice("each", {"period"});
    m.each_period = true;
  }
  if (s.has("at")) m.at = s.text("at");
  if (m.each_period && !m.at.empty())
    s.fail("each", "and at both select parts of the window; give one of them");
  s.done("a measure");
  return m;
}

std::string said(const Measure& m) {
  if (!m.waveform.empty())
    return fmt::format("measure.{} = [waveform {}, {}]\n", m.name, m.digest, toml_number(m.tolerance));
  auto text = fmt::format("measure.{} = [{}, {}", m.name, toml_quoted(m.column),
                          toml_quoted(reduce_names[static_cast<std::size_t>(m.reduce)].text));
  if (m.reduce == Reduce::quantile) text += ", " + toml_number(m.q);
  if (m.each_period) text += ", \"each period\"";
  if (!m.at.empty()) text += ", at " + toml_quoted(m.at);
  return text + "]\n";
}

}  // namespace freeplay
