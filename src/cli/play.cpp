// freeplay play: how far outputs can be from their ideal values because of clearances.
#include "analysis/play/play.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "analysis/play/play_allocation.hpp"
#include "analysis/play/play_documents.hpp"
#include "analysis/play/play_loads.hpp"
#include "cli/command_line.hpp"
#include "cli/figures.hpp"
#include "cli/scene_report.hpp"
#include "cli/terminal.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/points_file.hpp"
#include "io/scene/pose_file.hpp"
#include "io/scene/quantity.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/scene.hpp"
#include "plots/drawing/style.hpp"

namespace freeplay::cli {
namespace {

struct PlayCommand : Request {
  std::string scene, over, from, to;
  std::vector<std::string> quantities, overrides;
  int points = 73;
  bool loads = false;
  int samples = 0;
  std::string place = "within";
  Reach reach = Reach::beside;   ///< permitted files of the scene
  std::optional<double> target;  ///< width of the output that clearances are allocated for
  std::string costs;             ///< file of their costs
  std::string output;            ///< result folder; empty: no files
  std::string style;             ///< of the figures, preset or file
};

/// An end of the positions in the unit of the joint.
double place(const std::string& option, const std::string& text, bool slides) {
  const char* unit = slides ? "m" : "rad";
  if (text.empty())
    throw ModelError(option, fmt::format("is needed with --over: a number in {}, or with a unit", unit));
  if (const auto plain = number_in(text)) return *plain;
  const auto read = read_quantity(text, unit);
  if (!read.wrong.empty()) throw ModelError(option, read.wrong);
  return read.value;
}

PlayOptions options_of(const PlayCommand& request, const Scene& scene) {
  PlayOptions options;
  options.quantities = request.quantities;
  options.over = request.over;
  options.points = request.points;
  options.loads = request.loads;
  options.sampling = {request.samples, request.place == "rim" ? PlayPlace::rim : PlayPlace::within};
  options.stop = request.stop;
  if (request.over.empty()) {
    if (!request.from.empty() || !request.to.empty())
      throw ModelError("--over",
                       "is needed with --from and --to: the driven joint whose coordinate they state");
    return options;
  }
  const auto joint = std::ranges::find_if(scene.mechanism.joints,
                                          [&](const Joint& j) { return name_of(j) == request.over; });
  const bool slides =
      joint != scene.mechanism.joints.end() && std::holds_alternative<TranslationalJoint>(*joint);
  options.from = place("--from", request.from, slides);
  options.to = place("--to", request.to, slides);
  return options;
}

/// The range of 95 % at the position where it is widest.
void print_quantiles(const Play& play) {
  for (std::size_t k = 0; k < play.quantities.size(); ++k) {
    const PlayRange* most = nullptr;
    const auto width = [](const PlayRange& r) { return r.quantiles->value[3] - r.quantiles->value[1]; };
    for (const auto& p : play.positions)
      if (p.refusal.empty() && (!most || width(p.ranges[k]) > width(*most))) most = &p.ranges[k];
    if (!most) continue;
    const auto& x = *most->quantiles;
    const auto& quantity = play.quantities[k];
    fmt::print(
        "{}",
        wrapped(fmt::format("95 % of random places have {} from {:.4g} to {:+.4g} {} beside its ideal value "
                            "(standard error {:.2g}); least and greatest are {:.4g} and {:+.4g}\n",
                            quantity.name, x.value[1] - most->ideal, x.value[3] - most->ideal,
                            quantity.unit(), std::max(x.error[1], x.error[3]), most->least - most->ideal,
                            most->greatest - most->ideal),
                2));
    if (play.tolerances.empty()) continue;
    auto shares = by_joint(play, most->variance);
    std::ranges::stable_sort(shares, std::ranges::greater{}, &std::pair<std::string, double>::second);
    std::string text;
    for (const auto& [name, share] : shares)
      text += fmt::format("{}{:.0f} % by {}", text.empty() ? "" : ", ", 100 * share, name);
    fmt::print("{}", wrapped(fmt::format("shares in its variance to first order: {}\n", text), 2));
  }
}

/// The poses under the loads in sentences.
void print_loaded(const Play& play, const char* unit) {
  for (std::size_t k = 0; k < play.quantities.size(); ++k) {
    double least = INFINITY, greatest = -INFINITY;
    for (const auto& p : play.positions)
      for (const auto* pose : {&p.up, &p.down})
        if (pose->failure.empty() && p.refusal.empty()) {
          least = std::min(least, pose->values[k] - p.ranges[k].ideal);
          greatest = std::max(greatest, pose->values[k] - p.ranges[k].ideal);
        }
    const auto& quantity = play.quantities[k];
    if (least <= greatest)
      fmt::print("{}",
                 wrapped(fmt::format("under the loads {} is from {:.4g} to {:.4g} {} beside its ideal value; "
                                     "lost motion {:.3g} {}\n",
                                     quantity.name, least, greatest, quantity.unit(), lost_motion(play, k),
                                     quantity.unit()),
                         2));
  }
  constexpr std::size_t shown = 6;
  std::size_t printed = 0;
  for (const auto& jump : play.jumps)
    if (jump.up && printed++ < shown)
      fmt::print("{}", wrapped(fmt::format("{} changes sides between {:.5g} and {:.5g} {}\n", jump.joint,
                                           jump.from, jump.to, unit),
                               2));
  if (printed > shown) fmt::print("  {} more changes of sides in play.json\n", printed - shown);
  const auto failed =
      std::ranges::find_if(play.positions, [](const auto& p) { return !p.up.failure.empty(); });
  if (failed != play.positions.end())
    fmt::print("{}", wrapped(fmt::format("no equilibrium at {:.5g} {}: {}\n", failed->coordinate, unit,
                                         failed->up.failure),
                             2));
}

void print(const Scene& scene, const Play& play) {
  fmt::print("{}\n\n", scene.mechanism.title.empty() ? scene.file.string() : scene.mechanism.title);
  const char* unit = play.slides ? "m" : "rad";
  for (std::size_t k = 0; k < play.quantities.size(); ++k) {
    const auto& quantity = play.quantities[k];
    fmt::print("{}, {}\n", quantity.name, quantity.unit());
    Table table({(play.joint.empty() ? "t" : play.joint) + ", " + unit, "ideal", "least -", "greatest +",
                 "linear +-", "gap"});
    constexpr std::size_t most = 25;  // rows on a terminal
    const std::size_t every = (play.positions.size() + most - 1) / most;
    for (std::size_t i = 0; i < play.positions.size(); i += every) {
      const auto& p = play.positions[i];
      if (!p.refusal.empty()) {
        table.row(fmt::format("{:.6g}", p.coordinate), "refused", "", "", "", "");
        continue;
      }
      const auto& r = p.ranges[k];
      table.row(fmt::format("{:.6g}", p.coordinate), fmt::format("{:.8g}", r.ideal),
                fmt::format("{:.6g}", r.ideal - r.least), fmt::format("{:.6g}", r.greatest - r.ideal),
                fmt::format("{:.6g}", r.linear), fmt::format("{:.0e}", r.gap()));
    }
    fmt::print("{}\n", table.terminal({14, 14, 13, 13, 13, 7}));
  }
  for (const auto& sentence : verdicts(play)) fmt::print("{}", wrapped(sentence + "\n", 2));
  std::size_t refused = 0;
  for (const auto& p : play.positions) refused += !p.refusal.empty();
  if (refused > 0) {
    const auto it = std::ranges::find_if(play.positions, [](const auto& p) { return !p.refusal.empty(); });
    fmt::print("{}", wrapped(fmt::format("no range at {} of {} positions, first at {:.6g} {}: {}\n", refused,
                                         play.positions.size(), it->coordinate, unit, it->refusal),
                             2));
  }
  if (play.sampled) print_quantiles(play);
  if (play.loaded) print_loaded(play, unit);
  for (const auto& note : play.notes) fmt::print("{}", wrapped("note: " + note + "\n", 2));
}

/// joint,cost,exponent,least,greatest
std::vector<ClearanceCost> read_costs(const std::string& file) {
  const auto fail = [&](long line, const std::string& what) {
    throw SceneError(fmt::format("{}:{}: {}", file, line, what));
  };
  std::ifstream in(file);
  if (!in) throw SceneError(fmt::format("{}: cannot be read", file));
  TextRows rows(std::string(std::istreambuf_iterator<char>(in), {}));
  const std::vector<std::string> header{"joint", "cost", "exponent", "least", "greatest"};
  if (!rows.next() || rows.fields() != header)
    fail(1, "the header must be joint,cost,exponent,least,greatest");
  std::vector<ClearanceCost> costs;
  while (rows.next()) {
    const auto& x = rows.fields();
    if (x.size() != header.size()) fail(rows.number(), "a row has five fields");
    std::array<double, 4> numbers{};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto number = number_in(x[i + 1]);
      if (!number || !(*number > 0) || !std::isfinite(*number))
        fail(rows.number(), header[i + 1] + " must be a positive number");
      numbers[i] = *number;
    }
    if (numbers[2] > numbers[3]) fail(rows.number(), "least must not exceed greatest (m)");
    costs.push_back({x[0], numbers[0], numbers[1], numbers[2], numbers[3]});
  }
  if (costs.empty()) fail(1, "at least one joint is needed");
  return costs;
}

Table allocation_table(const Allocation& found) {
  using Limit = AllocatedClearance::Limit;
  Table table({"joint", "before", "after", "cost", "limit"});
  for (const auto& c : found.clearances)
    table.row(c.joint, c.before, c.after, c.cost,
              c.limit == Limit::least      ? "least"
              : c.limit == Limit::greatest ? "greatest"
                                           : "active");
  return table;
}

void print(const Allocation& found, double target, const char* unit) {
  fmt::print("clearances of least cost for a width of {:.6g} {}\n\n", target, unit);
  Table table({"joint", "before, m", "after, m", "cost", "limit"});
  const auto all = allocation_table(found);
  for (const auto& row : all.rows())
    table.row(std::get<std::string>(row[0]), fmt::format("{:.6g}", std::get<double>(row[1])),
              fmt::format("{:.6g}", std::get<double>(row[2])),
              fmt::format("{:.4g}", std::get<double>(row[3])), std::get<std::string>(row[4]));
  fmt::print("{}\ncost {:.6g}, with the clearances of the scene {:.6g}\n\n",
             table.terminal({20, 12, 12, 10, 10}), found.cost, found.cost_before);
}

/// The shapes of the ideal mechanism at the positions that have a region (pose_file.hpp).
Table region_poses(const Scene& scene, const Play& play) {
  Table table("at,shape,name,x,y,a,b");
  std::set<std::size_t> positions;
  for (const auto& region : play.regions) positions.insert(region.position);
  for (const auto i : positions) {
    const auto& p = play.positions[i];
    for (const auto& s : pose_shapes(scene, p.pose))
      table.row(p.coordinate, s.kind, s.name, s.at.x(), s.at.y(), s.more.x(), s.more.y());
  }
  return table;
}

int play(const PlayCommand& request) {
  const Scene scene = read_scene(request.scene, request.overrides, request.reach == Reach::anywhere);
  ask(scene);
  if (!request.style.empty()) plots::choose_style(request.style);
  // Reports an invalid style before the analysis.
  if (!request.output.empty()) plots::style_of(request.output, request.scene);
  std::optional<Allocation> allocation;
  if (request.target) {
    const auto costs = read_costs(request.costs);
    allocation = located_in(scene, [&] {
      return allocate_clearances(scene, options_of(request, scene), *request.target, costs);
    });
    print(*allocation, *request.target, allocation->play.quantities.front().unit());
  }
  const auto found = allocation
                         ? allocation->play
                         : located_in(scene, [&] { return find_play(scene, options_of(request, scene)); });
  print(scene, found);
  if (!request.output.empty()) {
    const auto folder = real_folder(request.output);
    ResultSet set(folder, "play");
    write_file(set.place() / "play.csv", play_table(found).csv());
    write_file(set.place() / "play_parts.csv", play_parts_table(found).csv());
    if (allocation) write_file(set.place() / "allocation.csv", allocation_table(*allocation).csv());
    if (found.loaded) write_file(set.place() / "play_loads.csv", play_loads_table(found).csv());
    if (!found.regions.empty()) {
      write_file(set.place() / "play_region.csv", play_region_table(found).csv());
      write_file(set.place() / "play_pose.csv", region_poses(scene, found).csv());
    }
    write_json(set.place() / "play.json", to_json(found), provenance(scene));
    set.commit();
    fmt::print("\n");
    draw_results(folder, Undrawn::is_reported, request.stop);
  }
  return 0;
}

}  // namespace

void play_verb(Program& program) {
  auto [options, request] =
      program.verb("play", "compute how far outputs can be from ideal because of clearances", play);
  options.scene(request.scene).required();
  options
      .add(
          "--of", request.quantities,
          "output: BODY.x, BODY.y, BODY.theta, POINT.x, POINT.y, a joint, or distance(POINT, POINT); may be repeated")
      .takes("QUANTITY")
      .one_each()
      .required();
  auto over =
      options
          .add("--over", request.over, "positions of this joint with prescribed motion; default: the start")
          .takes("JOINT");
  options.add("--from", request.from, "its first position, in rad or m, or with a unit (\"30 deg\")")
      .takes("A")
      .needs(over);
  options.add("--to", request.to, "its last position").takes("B").needs(over);
  options.add("--points", request.points, "number of positions")
      .between(1, 100000)
      .needs(over)
      .shows_default();
  options.add("--samples", request.samples, "number of random states of the joints for quantiles")
      .between(100, 10000000);
  options.add("--place", request.place, "random places: within the clearances, or at their rim")
      .one_of({"within", "rim"})
      .shows_default();
  options.flag("--loads", request.loads,
               "also the equilibrium under the loads at each position, without friction");
  auto costs = options
                   .add("--cost", request.costs,
                        "CSV file joint,cost,exponent,least,greatest: the cost of a joint is "
                        "cost (scene's clearance/clearance)^exponent, limits in m")
                   .takes("FILE");
  auto target = options
                    .add("--target", request.target,
                         "width of the output for which the clearances of least cost are "
                         "computed, in m or rad")
                    .takes("WIDTH")
                    .number([](double x) { return x > 0; }, "be positive")
                    .needs(costs);
  costs.needs(target);
  options.set(request.overrides);
  options.allow_outside(request.reach);
  auto output = options.output(request.output, "result folder; default: no files");
  options.style(request.style).needs(output);
}

}  // namespace freeplay::cli
