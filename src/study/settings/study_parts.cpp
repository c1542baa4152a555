#include "study/settings/study_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/motion_documents.hpp"
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

nlohmann::json to_json(const ContinuationPlan& plan, const Branches& found, std::vector<BranchEnd> ends,
                       nlohmann::json bifurcations) {
  nlohmann::json document = {{"key", plan.key},     {"from", plan.from}, {"to", plan.to},
                             {"scale", plan.scale}, {"unit", plan.unit}, {"periods", plan.periods}};
  std::erase_if(ends, [&](const BranchEnd& e) {
    return std::ranges::find(found.ends, e.branch, &BranchEnd::branch) != found.ends.end();
  });
  ends.insert(ends.end(), found.ends.begin(), found.ends.end());
  for (auto& b : to_json(found.bifurcations)) bifurcations.push_back(std::move(b));
  if (plan.second) {
    const auto& second = *plan.second;
    document["second"] = {{"key", second.key},        {"from", second.from},
                          {"to", second.to},          {"scale", plan.second_scale},
                          {"unit", plan.second_unit}, {"curves", to_json(found.curves)}};
  }
  document["branches"] = to_json(ends);
  document["bifurcations"] = bifurcations;
  return {{"continue", document}};
}

}  // namespace freeplay
