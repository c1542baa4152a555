// freeplay continue: branches of periodic motions over one key of a scene, and their bifurcations.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/default_folder.hpp"
#include "cli/ending.hpp"
#include "cli/progress.hpp"
#include "cli/run_figures.hpp"
#include "cli/verb.hpp"
#include "cli/wrapped.hpp"
#include "dynamics/system.hpp"
#include "facade/continuation.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/located.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "plots/tables/table.hpp"
#include "study/settings/continuation_plan.hpp"
#include "study/settings/expression.hpp"
#include "study/settings/provenance.hpp"
#include "study/settings/study.hpp"
#include "values/branch.hpp"

namespace freeplay::cli {
namespace {

struct ContinueVerb : Request {
  std::string study, from;
  Reach reach = Reach::beside;
  std::string output;  ///< result folder
};

double greatest_modulus(const Orbit& o) {
  return o.multipliers.empty() ? 0 : std::abs(o.multipliers.front());
}
std::complex<double> first_multiplier(const Orbit& o) {
  return o.multipliers.empty() ? std::complex<double>(0) : o.multipliers.front();
}

/// Phase of an impact in the period of the drive.
double phase_in(double t, double period) {
  const double phase = t / period - std::floor(t / period);
  return phase < 1 ? phase : 0;
}

std::string kind_name(const Bifurcation& b) { return bifurcation_names[static_cast<std::size_t>(b.kind)]; }

/// Tables of a continuation, row by row.
struct BranchTables {
  std::string branch, impacts,
      bifurcations =
          "kind,parameter,period_s,branch,point,periods,multiplier_re,multiplier_im,joint,follows,new_branch,"
          "residual\n";

  std::vector<std::string> columns{"branch",
                                   "point",
                                   "parameter",
                                   "period_s",
                                   "stable",
                                   "greatest_modulus",
                                   "multiplier_re",
                                   "multiplier_im",
                                   "periods",
                                   "impacts",
                                   "least_speed",
                                   "least_force",
                                   "t"};

  /// `states`: number of first-order states.
  BranchTables(const Scene& scene, int states) {
    for (const char* part : {"x", "y", "theta", "vx", "vy", "omega"})
      for (const auto& body : scene.mechanism.bodies)
        columns.push_back(fmt::format("{}.{}", body.name, part));
    for (int k = 1; k <= states; ++k) columns.push_back(fmt::format("z{}", k));
    branch = fmt::format("{}\n", fmt::join(columns, ","));
    impacts = "branch,point,parameter,stable,t,phase,joint,approach\n";
  }
  /// The values of the columns.
  static std::vector<double> values(const BranchPoint& p) {
    const auto& o = p.orbit;
    double slowest = NAN, weakest = NAN;
    for (const auto& i : o.impacts) slowest = std::isnan(slowest) ? i.speed : std::min(slowest, i.speed);
    for (const auto& c : o.lasting)
      weakest = std::isnan(weakest) ? c.least_force : std::min(weakest, c.least_force);
    const auto first = first_multiplier(o);
    std::vector<double> list{static_cast<double>(p.branch),
                             static_cast<double>(p.number),
                             p.parameter,
                             o.period,
                             o.stable ? 1.0 : 0.0,
                             greatest_modulus(o),
                             first.real(),
                             first.imag(),
                             static_cast<double>(o.periods),
                             static_cast<double>(o.impacts.size()),
                             slowest,
                             weakest,
                             o.state.t};
    for (const auto* part_of : {&o.state.q, &o.state.v})
      for (std::size_t part = 0; part < 3; ++part)
        for (std::size_t i = part; i < part_of->size(); i += 3) list.push_back((*part_of)[i]);
    list.insert(list.end(), o.state.z.begin(), o.state.z.end());
    return list;
  }
  static std::string row(const BranchPoint& p) { return fmt::format("{}\n", fmt::join(values(p), ",")); }
  static std::string impact_rows(const BranchPoint& p) {
    std::string text;
    for (const auto& i : p.orbit.impacts)
      text += fmt::format("{},{},{},{},{},{},{},{}\n", p.branch, p.number, p.parameter,
                          p.orbit.stable ? 1 : 0, i.t, phase_in(i.t, p.orbit.period), i.joint, i.speed);
    return text;
  }
  static std::string row(const Bifurcation& b) {
    const auto first = first_multiplier(b.at.orbit);
    return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", kind_name(b), b.at.parameter,
                       b.at.orbit.period, b.at.branch, b.at.number, b.at.orbit.periods, first.real(),
                       first.imag(), b.joint, b.follows, b.new_branch, b.residual);
  }
};

constexpr const char* curve_head =
    "curve,kind,parameter,second,period_s,periods,stable,greatest_modulus,multiplier_re,multiplier_im,joint,"
    "residual\n";
std::string curve_row(const CurvePoint& c) {
  const auto first = first_multiplier(c.orbit);
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", c.curve,
                     bifurcation_names[static_cast<std::size_t>(c.kind)], c.parameter, c.second,
                     c.orbit.period, c.orbit.periods, c.orbit.stable ? 1 : 0, greatest_modulus(c.orbit),
                     first.real(), first.imag(), c.joint, c.residual);
}

nlohmann::json finite(double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(); }

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

/// Reads the result folder of a continuation. Branches go on that ended with the range of the key or with their
/// number of motions; of an interrupted one, the last branch.
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

nlohmann::json continuation_json(const ContinuationPlan& plan, const Branches& found,
                                 const EarlierBranches& earlier) {
  nlohmann::json document = {{"key", plan.key},     {"from", plan.from}, {"to", plan.to},
                             {"scale", plan.scale}, {"unit", plan.unit}, {"periods", plan.periods}};
  auto branches = nlohmann::json::array(), bifurcations = earlier.bifurcations;
  for (const auto& e : earlier.ends)
    if (std::ranges::find(found.ends, e.branch, &BranchEnd::branch) == found.ends.end())
      branches.push_back(
          {{"branch", e.branch}, {"points", e.points}, {"begins", e.begins}, {"ends", e.reason}});
  for (const auto& e : found.ends)
    branches.push_back(
        {{"branch", e.branch}, {"points", e.points}, {"begins", e.begins}, {"ends", e.reason}});
  for (const auto& b : found.bifurcations) {
    auto multipliers = nlohmann::json::array();
    for (const auto& m : b.at.orbit.multipliers) multipliers.push_back({m.real(), m.imag()});
    bifurcations.push_back({{"kind", kind_name(b)},
                            {"parameter", b.at.parameter},
                            {"period_s", b.at.orbit.period},
                            {"branch", b.at.branch},
                            {"joint", b.joint},
                            {"follows", b.follows},
                            {"new_branch", b.new_branch},
                            {"residual", finite(b.residual)},
                            {"multipliers", multipliers},
                            {"t", b.at.orbit.state.t},
                            {"q", b.at.orbit.state.q},
                            {"v", b.at.orbit.state.v}});
  }
  if (plan.second) {
    const auto& second = *plan.second;
    auto curves = nlohmann::json::array();
    for (const auto& c : found.curves)
      curves.push_back({{"curve", c.curve},
                        {"kind", bifurcation_names[static_cast<std::size_t>(c.kind)]},
                        {"points", c.points},
                        {"parameter", c.parameter},
                        {"ends", {c.reasons[0], c.reasons[1]}}});
    document["second"] = {{"key", second.key},     {"from", second.from}, {"to", second.to},
                          {"scale", second.scale}, {"unit", second.unit}, {"curves", curves}};
  }
  document["branches"] = branches;
  document["bifurcations"] = bifurcations;
  return document;
}

/// The expressions of the study as functions of motions.
std::vector<BranchQuantity> events_of(const Study& study, const ContinuationPlan& plan,
                                      const std::vector<std::string>& columns) {
  std::vector<BranchQuantity> list;
  for (const auto& text : plan.events) try {
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
    fmt::print("{:<9}{:>7} {:>20.12g} {:>14.9g}  {}{}\n", kind_name(b), b.at.branch, b.at.parameter,
               b.at.orbit.period, b.follows,
               b.new_branch > 0 ? fmt::format(" (branch {})", b.new_branch) : std::string());
  for (const auto& c : found.curves)
    fmt::print("{}", wrapped(fmt::format("curve {}, {} from {:.9g}: {} points; ends: {}; {}\n", c.curve,
                                         bifurcation_names[static_cast<std::size_t>(c.kind)], c.parameter,
                                         c.points, c.reasons[0], c.reasons[1])));
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
  nlohmann::json document;
  document["provenance"] = provenance(study);
  document["provenance"]["scene_file"] = study.scene.lexically_normal().string();
  ResultSet set(folder, "continue");
  BranchTables tables(scene, System(scene.mechanism).states());
  EarlierBranches earlier;
  if (!request.from.empty()) {
    earlier = read_earlier(request.from, plan.key, tables.columns, document["provenance"]);
    tables.branch += earlier.rows;
    tables.impacts += earlier.impacts;
    tables.bifurcations += earlier.marks;
    if (earlier.restarts.empty())
      throw SceneError(
          fmt::format("{}: none of its branches can go on: each ended at a bifurcation", request.from));
  }
  // Rows so far, which remain if the process is killed.
  const auto rows = folder / "branch.csv", marks = folder / "bifurcations.csv",
             curves = folder / "curves.csv", touches = folder / "branch_impacts.csv";
  Branches found;
  {
    std::optional<OutputFile> live, live_marks, live_curves, live_impacts;
    const auto append = [](std::optional<OutputFile>& file, const std::filesystem::path& path,
                           const std::string& head, const std::string& row) {
      if (!file) {
        file.emplace(path);
        file->keep();
        file->write(head);
      }
      file->write(row);
      file->settle();
    };
    Progress progress;
    ContinuationRequest what{.formulation = plan.formulation,
                             .key = plan.key,
                             .from = plan.from,
                             .to = plan.to,
                             .start = plan.start,
                             .step = plan.step,
                             .periods = plan.periods,
                             .settle = plan.settle,
                             .period = plan.period,
                             .follow_doubled = plan.follow_doubled,
                             .most_points = plan.most_points,
                             .second = {},
                             .events = events_of(study, plan, tables.columns),
                             .restarts = earlier.restarts,
                             .branches = earlier.branches,
                             .stop = request.stop};
    if (plan.second)
      what.second = SecondKey{plan.second->key, plan.second->from, plan.second->to, plan.second->step,
                              plan.second->kinds};
    what.on_point = [&](const BranchPoint& p) {
      const auto row = BranchTables::row(p);
      append(live, rows, tables.branch, row);
      tables.branch += row;
      const auto impacts = BranchTables::impact_rows(p);
      append(live_impacts, touches, tables.impacts, impacts);
      tables.impacts += impacts;
      progress.show(fmt::format("branch {}, motion {}", p.branch, p.number),
                    std::abs((p.parameter - plan.from) / (plan.to - plan.from)));
    };
    what.on_bifurcation = [&](const Bifurcation& b) {
      const auto row = BranchTables::row(b);
      append(live_marks, marks, tables.bifurcations, row);
      tables.bifurcations += row;
    };
    what.on_curve_point = [&](const CurvePoint& c) {
      append(live_curves, curves, curve_head, curve_row(c));
      progress.show(fmt::format("curve {}", c.curve),
                    std::abs((c.second - plan.second->from) / (plan.second->to - plan.second->from)));
    };
    try {
      found = located_in(scene, [&] { return continue_orbit(scene, what); });
    } catch (const Interrupted&) {
      progress.clear();
      if (!live) throw;
      fmt::print(
          stderr, "{}",
          wrapped(fmt::format("interrupted; the rows so far are in {}.partial; the same command starts "
                              "again\n",
                              rows.string())));
      return 1;
    }
    progress.clear();
  }
  const auto partial = [](std::filesystem::path path) { return path += ".partial"; };
  if (!found.failure.empty()) {
    for (const auto& path : {rows, marks, touches}) remove_file(partial(path));
    fmt::print(stderr, "{}", wrapped("no periodic motion found at the start: " + found.failure + "\n"));
    return 1;
  }
  document["continue"] = continuation_json(plan, found, earlier);
  write_json(set.place() / "continue.json", document);
  write_file(set.place() / "branch.csv", tables.branch);
  write_file(set.place() / "branch_impacts.csv", tables.impacts);
  write_file(set.place() / "bifurcations.csv", tables.bifurcations);
  if (plan.second) {
    std::string text = curve_head;
    for (const auto& c : found.curve_points) text += curve_row(c);
    write_file(set.place() / "curves.csv", text);
  }
  set.commit();
  for (const auto& path : {rows, marks, curves, touches}) remove_file(partial(path));
  print(plan, found);
  fmt::print("results in {}\n", folder.string());
  draw_results(folder);
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
