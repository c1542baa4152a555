// freeplay continue: branches of periodic motions over one key of a scene, and their bifurcations.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/continuation.hpp"
#include "analysis/motion_documents.hpp"
#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/figures.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "plots/tables/table.hpp"
#include "study/settings/expression.hpp"
#include "study/settings/study.hpp"
#include "study/settings/study_parts.hpp"
#include "values/branch.hpp"

namespace freeplay::cli {
namespace {

struct ContinueVerb : Request {
  std::string study, from;
  Reach reach = Reach::beside;
  std::string output;  ///< result folder
};

/// A table of the results, which grows as NAME.partial, too; that file remains if the process is killed.
class LiveTable {
 public:
  LiveTable(const Table& table, const std::filesystem::path& folder, const char* name)
      : table_(table), path_(folder / name) {}
  std::string earlier;  ///< rows of an earlier result
  void write_new_rows() {
    if (file_ && written_ == table_.rows().size()) return;
    if (!file_) {
      file_.emplace(path_);
      file_->keep();
      file_->write(table_.csv_header() + earlier);
    }
    file_->write(table_.csv_rows(std::exchange(written_, table_.rows().size())));
    file_->settle();
  }
  bool begun() const { return file_.has_value(); }
  const std::filesystem::path& path() const { return path_; }
  void remove_partial() {
    file_.reset();
    remove_file(path_.string() + ".partial");
  }
  void write_into(const std::filesystem::path& folder) const {
    write_file(folder / path_.filename(), table_.csv_header() + earlier + table_.csv_rows());
  }

 private:
  const Table& table_;
  std::filesystem::path path_;
  std::optional<OutputFile> file_;
  std::size_t written_ = 0;  // rows
};

/// An earlier result, with the branches that can go on.
struct EarlierBranches {
  std::vector<BranchRestart> restarts;
  int branches = 0;  ///< greatest number
  std::vector<BranchEnd> ends;
  nlohmann::json bifurcations = nlohmann::json::array();
  std::string rows, impacts, marks;  ///< of the tables, without their headers
};

/// The rows of a table, without its header.
std::string rows_of(const std::filesystem::path& file) {
  const auto text = read_file(file, most_of_a_result);
  return text.substr(std::min(text.find('\n') + 1, text.size()));
}

/// Reads the result folder of a continuation. Branches go on that ended with the range of the key or with
/// their number of motions; of an interrupted one, the last branch.
EarlierBranches read_earlier(const std::filesystem::path& folder, const std::string& key,
                             const std::vector<std::string>& columns, const nlohmann::json& provenance) {
  EarlierBranches all;
  const auto file = [&](const char* name) {
    const auto whole = folder / name;
    return exists(whole) ? whole : folder / fmt::format("{}.partial", name);
  };
  const auto json = folder / "continue.json";
  const bool complete = exists(json);
  if (complete) {
    const auto differs = [&](const char* what) {
      return SceneError(fmt::format("{}: is a continuation of another {}; --from continues the same one",
                                    folder.string(), what));
    };
    const JsonFile earlier(json);
    if (earlier.text("continue.key") != key) throw differs("key");
    if (earlier.texts("provenance.identity.scene") !=
        provenance.at("identity").at("scene").get<std::vector<std::string>>())
      throw differs("scene");
    for (int i = 0; earlier.find(fmt::format("continue.branches.{}", i)); ++i) {
      const auto at = fmt::format("continue.branches.{}.", i);
      all.ends.push_back({static_cast<int>(earlier.number(at + "branch")),
                          static_cast<int>(earlier.number(at + "points")), earlier.text(at + "begins"),
                          earlier.text(at + "ends")});
    }
    if (const auto* list = earlier.find("continue.bifurcations")) all.bifurcations = *list;
  }
  if (exists(file("branch_impacts.csv"))) all.impacts = rows_of(file("branch_impacts.csv"));
  plots::Rows rows(file("branch.csv"));
  if (rows.names() != columns)
    throw SceneError(
        fmt::format("{}: has other columns than this continuation", file("branch.csv").string()));
  const auto n = static_cast<std::size_t>(
      std::ranges::count_if(columns, [](const auto& c) { return c.ends_with(".x"); }));
  std::map<int, std::pair<BranchPoint, double>> last;  // with the value of the key before
  while (rows.next()) {
    const auto number = [&](const char* column) { return rows.number(rows.place(column)); };
    BranchPoint p{
        static_cast<int>(number("branch")), static_cast<int>(number("point")), number("parameter"), {}};
    p.orbit.period = number("period_s");
    p.orbit.periods = static_cast<int>(number("periods"));
    p.orbit.state.t = number("t");
    const auto first = rows.place("t") + 1;
    for (std::size_t i = 0; i < 3 * n; ++i) {
      const auto column = first + i % 3 * n + i / 3;
      p.orbit.state.q.push_back(rows.number(column));
      p.orbit.state.v.push_back(rows.number(column + 3 * n));
    }
    for (auto i = first + 6 * n; i < columns.size(); ++i) p.orbit.state.z.push_back(rows.number(i));
    const auto before = last.find(p.branch);
    const double value = before == last.end() ? NAN : before->second.first.parameter;
    last[p.branch] = {std::move(p), value};
    all.branches = std::max(all.branches, last.rbegin()->first);
  }
  for (auto& [branch, motion] : last) {
    auto& [p, before] = motion;
    const auto end = std::ranges::find(all.ends, branch, &BranchEnd::branch);
    const bool open = complete
                          ? end != all.ends.end() && (end->reason == branch_range_ends ||
                                                      end->reason == fmt::format("{} motions", end->points))
                          : branch == all.branches;
    if (open && !std::isnan(before))
      all.restarts.push_back({p, p.parameter > before, complete ? end->begins : std::string("start")});
  }
  all.rows = rows_of(file("branch.csv"));
  if (exists(file("bifurcations.csv"))) all.marks = rows_of(file("bifurcations.csv"));
  return all;
}

/// The expressions of the study as functions of motions.
std::vector<BranchQuantity> events_of(const Study& study, const ContinuationPlan& plan,
                                      const std::vector<std::string>& columns) {
  std::vector<BranchQuantity> list;
  for (const auto& text : plan.expressions) try {
      const Expression e(text, columns);
      if (e.type() != Expression::Type::number)
        throw ExpressionError(1, "must be a number, not true or false");
      list.push_back({text, [e](const BranchPoint& p) { return e(BranchTables::values(p)); }});
    } catch (const ExpressionError& e) {
      throw error_at(study, {"continue", "events"}, fmt::format("\"{}\": {}", text, e.what()));
    }
  return list;
}

void print(const ContinuationPlan& plan, const Branches& found) {
  for (const auto& e : found.ends)
    fmt::print("{}", wrapped(fmt::format("branch {}, from {}: {} motions; ends: {}\n", e.branch, e.begins,
                                         e.points, e.reason)));
  if (!found.bifurcations.empty())
    fmt::print("{:<9}{:>7} {:>20} {:>14}  {}\n", "kind", "branch", plan.key.substr(plan.key.rfind('.') + 1),
               "period, s", "follows");
  for (const auto& b : found.bifurcations)
    fmt::print("{:<9}{:>7} {:>20.12g} {:>14.9g}  {}{}\n", name_of(b.kind), b.at.branch, b.at.parameter,
               b.at.orbit.period, b.follows,
               b.new_branch > 0 ? fmt::format(" (branch {})", b.new_branch) : std::string());
  for (const auto& c : found.curves)
    fmt::print("{}",
               wrapped(fmt::format("curve {}, {} from {:.9g}: {} points; ends: {}; {}\n", c.curve,
                                   name_of(c.kind), c.parameter, c.points, c.reasons[0], c.reasons[1])));
}

int continue_branches(const ContinueVerb& request) try {
  const auto study = read_study(request.study, request.reach);
  if (!study.continuation)
    throw SceneError(
        fmt::format("{}: has no table [continue]; see docs/theory/continuation.md", request.study));
  const auto& plan = *study.continuation;
  const auto scene = [&] {
    try {
      return read_scene(study.scene, plan.overrides, study.reach == Reach::anywhere);
    } catch (const SceneError& e) {
      throw in_study(study, e);
    }
  }();
  const auto folder = result_folder(request.output, default_folder(study.file, "-continue"));
  auto origin = provenance(study);
  origin["scene_file"] = study.scene.lexically_normal().string();
  ResultSet set(folder, "continue");
  BranchTables tables(scene);
  LiveTable branch(tables.branch, folder, "branch.csv"),
      impacts(tables.impacts, folder, "branch_impacts.csv"),
      bifurcations(tables.bifurcations, folder, "bifurcations.csv"),
      curves(tables.curves, folder, "curves.csv");
  EarlierBranches earlier;
  if (!request.from.empty()) {
    earlier = read_earlier(request.from, plan.key, tables.branch.columns(), origin);
    branch.earlier = earlier.rows;
    impacts.earlier = earlier.impacts;
    bifurcations.earlier = earlier.marks;
    if (earlier.restarts.empty())
      throw SceneError(
          fmt::format("{}: none of its branches can go on: each ended at a bifurcation", request.from));
  }
  ContinuationRequest what = plan;
  what.events = events_of(study, plan, tables.branch.columns());
  what.restarts = earlier.restarts;
  what.branches = earlier.branches;
  what.stop = request.stop;
  Continuation branches(scene, what);
  const auto& found = branches.found();
  Progress progress;
  const auto write_new = [&] {
    tables.add(found);
    if (!found.bifurcations.empty()) bifurcations.write_new_rows();
    if (!found.curve_points.empty()) {
      const auto& c = found.curve_points.back();
      curves.write_new_rows();
      progress.show(fmt::format("curve {}", c.curve),
                    std::abs((c.second - plan.second->from) / (plan.second->to - plan.second->from)));
    } else if (!found.points.empty()) {
      const auto& p = found.points.back();
      branch.write_new_rows();
      impacts.write_new_rows();
      progress.show(fmt::format("branch {}, motion {}", p.branch, p.number),
                    std::abs((p.parameter - plan.from) / (plan.to - plan.from)));
    }
  };
  try {
    while (located_in(scene, [&] { return branches.advance(); })) write_new();
  } catch (const Interrupted&) {
    write_new();
    progress.clear();
    if (!branch.begun()) throw;
    fmt::print(stderr, "{}",
               wrapped(fmt::format("interrupted; the rows so far are in {}.partial; the same command starts "
                                   "again\n",
                                   branch.path().string())));
    return 1;
  }
  progress.clear();
  if (!found.failure.empty()) {
    for (auto* table : {&branch, &impacts, &bifurcations}) table->remove_partial();
    fmt::print(stderr, "{}", wrapped("no periodic motion found at the start: " + found.failure + "\n"));
    return 1;
  }
  write_json(set.place() / "continue.json", to_json(plan, found, earlier.ends, earlier.bifurcations), origin);
  for (const auto* table : {&branch, &impacts, &bifurcations}) table->write_into(set.place());
  if (plan.second) curves.write_into(set.place());
  set.commit();
  for (auto* table : {&branch, &impacts, &bifurcations, &curves}) table->remove_partial();
  print(plan, found);
  draw_results(folder, Undrawn::is_reported);
  return 0;
} catch (const Interrupted&) {
  return interrupted(Kept::nothing);
}

}  // namespace

void continue_verb(Program& program) {
  auto [options, request] = program.verb(
      "continue", "follow a periodic motion over one key, to its bifurcations", continue_branches);
  options.add("study", request.study, "study file with a table [continue]").required();
  options
      .add("--from", request.from,
           "result folder of an earlier continuation, whose branches go on from their last motions")
      .takes("FOLDER");
  options.output(request.output, "result folder; default out/NAME-continue");
  options.allow_outside(request.reach);
}

}  // namespace freeplay::cli
