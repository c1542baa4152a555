#include "plots/report/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <list>
#include <nlohmann/json.hpp>

#include "io/files/escaping.hpp"
#include "mechanism/scene.hpp"
#include "plots/report/facts.hpp"
#include "plots/report/motions.hpp"
#include "plots/report/page.hpp"
#include "plots/report/run_data.hpp"
#include "plots/report/study_page.hpp"
#include "plots/tables/run_facts.hpp"

namespace freeplay::report {
namespace {

using nlohmann::json;

// Limit of the numbers on a page, of about seven bytes each. Half of them are for the motion.
constexpr long numbers_of_a_page = 620'000;
constexpr long fewest_frames = 300, most_frames = 6000;
constexpr std::size_t most_events = 20'000;

json run_part(const plots::RunFolder& run, long numbers) {
  const auto scene = plots::scene_of_run(run.folder);
  const auto events = read_events(run.folder, most_events / 2);
  const long frames =
      std::clamp(numbers / 2 / numbers_of_frame(run.folder, scene.get()), fewest_frames, most_frames);
  const auto beside = hardest(events, static_cast<std::size_t>(frames / 6));
  json part = {{"name", run.title}, {"events", to_json(events)}};
  part["motion"] = motion(run.folder, scene.get(), frames - 2 * static_cast<long>(beside.size()), beside);
  part["curves"] = curves(run.folder, numbers / 2);
  const auto turn = plots::turn_of(scene.get());
  if (turn) part["turn"] = *turn;
  part["transient"] = start_transient(scene ? scene->run.discard : 0, turn, scene ? scene->run.duration : 0);
  return part;
}

/// Commands that repeat a run, to be called in the folder of the page.
std::vector<std::string> commands(const JsonFile& file, const std::string& formulation, bool forces_asked) {
  const auto scene = file.text_or_empty("provenance.scene_file");
  if (scene.empty()) return {"freeplay run --from run.json"};
  const auto set = overrides_of(file);
  const bool twice = forces_asked && set.find("run.forces=true") == set.npos;
  const std::string forces = twice ? " --forces" : "";
  if (formulation.empty()) return {"freeplay compare " + shell_words({scene}) + set + forces};
  return {"freeplay run --from run.json", "freeplay run " + shell_words({scene}) + " --formulation " +
                                              shell_words({formulation}) + set + forces};
}

/// The parts of comparison.md without the verdict, which the page shows on top.
json without_verdict(json parts, const std::string& verdict) {
  for (const auto& text : {verdict, std::string("Verdict")})
    if (!parts.empty() && parts.back().contains("text") && parts.back()["text"] == text)
      parts.erase(parts.size() - 1);
  return parts;
}

json runs_document(const std::filesystem::path& folder, const std::vector<plots::RunFolder>& runs) {
  const bool comparison = std::filesystem::exists(folder / "comparison.json");
  const bool periodic = runs.front().folder != folder && !comparison;
  std::list<JsonFile> files;
  std::vector<RunFacts> facts;
  for (const auto& run : runs) facts.push_back({run.title, &files.emplace_back(run.folder / "run.json")});
  const auto& first = files.front();
  json document = {{"kind", comparison ? "comparison" : periodic ? "orbit" : "run"}};
  document["title"] = first.text_or_empty("provenance.title");
  document["notes"] = notes(facts);
  document["tables"] = json::array();
  if (comparison) {
    const JsonFile both(folder / "comparison.json");
    if (const auto* open = both.find("not_matched"); open && open->is_object() && !open->empty())
      for (const auto& [contact, why] : open->items())
        document["notes"].push_back(
            {{"doubtful", false}, {"text", "not matched in " + contact + ": " + why.dump()}});
    if (const auto verdict = both.text_or_empty("verdict"); !verdict.empty()) document["verdict"] = verdict;
    if (std::filesystem::exists(folder / "comparison.md"))
      document["comparison"] =
          without_verdict(markdown_tables(folder / "comparison.md"), both.text_or_empty("verdict"));
    if (const auto* pairs = both.find("pairing.horizon_s"); pairs && pairs->is_number())
      document["horizon"] = pairs->get<double>();
  }
  document["tables"] = tables(facts);
  document["provenance"] = provenance_table(facts);
  document["scene"] = first.text_or_empty("provenance.scene");
  const bool forces = std::filesystem::exists(runs.front().folder / "forces.csv");
  document["commands"] = json::array();  // those of a periodic motion are in orbit.json
  if (!periodic)
    document["commands"] = commands(first, comparison ? "" : first.text_or_empty("formulation"), forces);
  document["runs"] = json::array();
  const long numbers = numbers_of_a_page / static_cast<long>(runs.size());
  for (const auto& run : runs) document["runs"].push_back(run_part(run, numbers));
  return document;
}

/// Makes control and bidirectional characters in all texts visible, as in a terminal.
void make_visible(json& value) {
  if (value.is_string())
    value = visible(value.get_ref<const std::string&>(), "\n\t");
  else if (value.is_structured())
    for (auto& part : value)
      if (part.is_structured() || part.is_string()) make_visible(part);
}

}  // namespace

double start_transient(double discard, const std::optional<double>& turn, double duration) {
  if (discard > 0) return discard;
  return turn ? std::min(0.25 * *turn, 0.1 * duration) : 0;
}

json document_of(const std::filesystem::path& folder) {
  json document;
  if (const auto runs = plots::runs_in(folder); !runs.empty())
    document = runs_document(folder, runs);
  else if (holds_study(folder))
    document = study_document(folder);
  else if (holds_motions(folder))
    document = motions_document(folder);
  else
    throw SceneError(
        folder.string() +
        ": contains no results to show; give a folder made by freeplay run, compare, orbit, lyapunov, "
        "continue, sweep, bifurcation or basin");
  add_motions(folder, document);
  document["folder"] = folder.filename().string();
  make_visible(document);
  return document;
}

std::string report_page(const std::filesystem::path& folder) {
  const auto document = document_of(folder);
  const auto title = document["title"].get<std::string>();
  return page(title.empty() ? document["folder"].get<std::string>() : title, document);
}

}  // namespace freeplay::report
