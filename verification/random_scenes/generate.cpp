// The kind of scene of each index, and the methods that scenes are run by.
#include <sstream>

#include "verification/random_scenes/draft.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::random_scenes {
namespace {

struct Kind {
  const char* name;
  void (*make)(Draw&, Draft&);
  int weight;  ///< frequency, relative to the sum of its suite
  Suite suite = Suite::agreement;
  const char* set = nullptr;  ///< the selection that contains it; nullptr: that of its suite
};
constexpr Kind all_kinds[] = {{"thrown", thrown, 3},
                              {"cluster", cluster, 2},
                              {"box", box, 2},
                              {"pile", pile, 2},
                              {"sliding", sliding, 2},
                              {"springs", springs, 2},
                              {"bump", bump, 3},
                              {"chain", chain, 4},
                              {"loop", loop, 4},
                              {"guide", guide, 2},
                              {"pulse", pulse, 3},
                              {"film", film, 1},
                              {"motored", motored, 2},
                              {"preloaded", preloaded, 1},
                              {"compliant", compliant, 2},
                              {"cams", cams, 2},
                              {"toothed", toothed, 3},
                              {"stopped", stopped, 2},
                              {"flying-beams", flying_beams, 1, Suite::flexible},
                              {"cantilevers", cantilevers, 1, Suite::flexible},
                              {"beam-loops", beam_loops, 1, Suite::flexible},
                              {"sectioned-beams", sectioned_beams, 1, Suite::flexible, "beams"},
                              {"reduced-beams", reduced_beams, 1, Suite::flexible, "beams"},
                              {"table", moved_table, 3, Suite::rows},
                              {"stop", moved_stop, 3, Suite::rows},
                              {"lever", moved_lever, 2, Suite::rows},
                              {"teeth", teeth, 2, Suite::rows},
                              {"journal", moved_journal, 1, Suite::rows},
                              {"follower", follower, 3, Suite::rows},
                              {"pushed", pushed, 3, Suite::rows},
                              {"barrier", barrier, 3, Suite::rows},
                              {"scales", two_scales, 2, Suite::rows},
                              {"one-way", one_way, 3, Suite::rows},
                              {"column", touching_column, 2, Suite::rows},
                              {"row", touching_row, 2, Suite::rows},
                              {"grid", touching_grid, 1, Suite::rows},
                              {"ratio-trains", ratio_trains, 1, Suite::rows, "elements"},
                              {"freewheels", freewheels, 1, Suite::rows, "elements"},
                              {"stribeck", stribeck, 1, Suite::rows, "elements"},
                              {"mesh-losses", mesh_losses, 1, Suite::rows, "elements"},
                              {"outlines", outlines, 1, Suite::rows, "elements"},
                              {"sampled", sampled_loops, 1, Suite::rows, "elements"},
                              {"yielding", yielding, 1, Suite::rows, "elements"},
                              {"profiles", profiled_journals, 1, Suite::rows, "elements"},
                              {"gripping", gripping, 1, Suite::rows, "surfaces"}};

std::vector<Kind> selected(const std::string& selection) {
  std::vector<Kind> list;
  const auto add = [&](Suite suite, const std::string& name, const char* all) {
    for (const auto& k : all_kinds)
      if (k.suite == suite && (name == (k.set ? k.set : all) || name == k.name)) list.push_back(k);
  };
  if (selection.empty()) add(Suite::agreement, "", "");
  std::istringstream in(selection);
  for (std::string name; std::getline(in, name, ',');) {
    const auto before = list.size();
    add(Suite::rows, name, "new");
    add(Suite::flexible, name, "flexible");
    if (list.size() == before)
      throw std::invalid_argument(fmt::format(
          "there is no kind of random scene \"{}\"; there are: new, elements, surfaces, {}, and flexible, beams, {}",
          name, fmt::join(kinds(Suite::rows), ", "), fmt::join(kinds(Suite::flexible), ", ")));
    if (list.back().suite != list.front().suite)
      throw std::invalid_argument("flexible kinds of random scenes are not mixed with those of known rows");
  }
  return list;
}

void event_driven(Scene& s) { s.nonsmooth.scheme = Scheme::event_driven; }
void automatic(Scene& s) { s.nonsmooth.scheme = Scheme::automatic; }
void time_stepping(Scene& s) { s.nonsmooth.scheme = Scheme::moreau_jean; }
void chosen_steps(Scene& s) { time_stepping(s), s.nonsmooth.step.reset(); }

constexpr Way agreement_ways[] = {{"penalty", Family::penalty},
                                  {"event-driven", Family::nonsmooth, event_driven},
                                  {"moreau-jean", Family::nonsmooth, time_stepping, nullptr, true, true},
                                  {"chosen steps", Family::nonsmooth, chosen_steps, nullptr, false, true},
                                  {"automatic", Family::nonsmooth, automatic}};

void implicit(Scene& s) { s.penalty.integrator = Integrator::rosenbrock4; }

constexpr Way flexible_ways[] = {agreement_ways[0], {"rosenbrock4", Family::penalty, implicit},
                                 agreement_ways[1], agreement_ways[2],
                                 agreement_ways[3], agreement_ways[4]};

template <class... More>
std::string nonsmooth(const char* scheme, const More&... more) {
  return (fmt::format("[nonsmooth]\nscheme = \"{}\"\n", scheme) + ... + more);
}
std::string penalty(const RandomScene& s, const std::string& more = "") {
  return fmt::format(
             "[penalty]\nv0_floor = {0}\nfriction_v0 = {0}\nfriction_v1 = {1}\nalpha = {2}\nbeta = {2}\n",
             text_of(1e-3 * s.speed), text_of(1e-2 * s.speed), text_of(10 / s.duration)) +
         more;
}
std::string step(double length) { return fmt::format("step = {}\n", text_of(length)); }
using Drawn = const RandomScene&;

constexpr Way rows_ways[] = {
    {"event-driven", Family::nonsmooth, nullptr, [](Drawn) { return nonsmooth("event-driven"); }},
    {"automatic", Family::nonsmooth, nullptr, [](Drawn) { return nonsmooth("automatic"); }},
    {"moreau-jean adaptive", Family::nonsmooth, nullptr, [](Drawn) { return nonsmooth("moreau-jean"); }},
    {"moreau-jean fixed", Family::nonsmooth, nullptr,
     [](Drawn s) { return nonsmooth("moreau-jean", step(s.step)); }, true},
    {"adams_bashforth_moulton", Family::penalty, nullptr, [](Drawn s) { return penalty(s); }},
    {"rosenbrock4", Family::penalty, nullptr,
     [](Drawn s) { return penalty(s, "integrator = \"rosenbrock4\"\n"); }},
    {"bulirsch_stoer", Family::penalty, nullptr,
     [](Drawn s) { return penalty(s, "integrator = \"bulirsch_stoer\"\n"); }},
    {"dopri5", Family::penalty, nullptr, [](Drawn s) { return penalty(s, "integrator = \"dopri5\"\n"); }},
    {"rk4", Family::penalty, nullptr,
     [](Drawn s) { return penalty(s, "integrator = \"rk4\"\n" + step(s.contact_step)); }, true},
};

}  // namespace

std::vector<std::string> kinds(Suite suite) {
  std::vector<std::string> names;
  for (const auto& k : all_kinds)
    if (k.suite == suite) names.emplace_back(k.name);
  return names;
}

std::span<const Way> ways(Suite suite) {
  if (suite == Suite::rows) return rows_ways;
  if (suite == Suite::flexible) return flexible_ways;
  return agreement_ways;
}

RandomScene draw(std::uint64_t seed, int index, const std::string& selection) {
  const auto list = selected(selection);
  RandomScene scene{list.front().suite, seed, index};
  const bool known = scene.suite == Suite::rows;
  Draw draw(known ? seed ^ 0x72616e646f6dULL : seed, static_cast<std::uint64_t>(index));
  int sum = 0;
  for (const auto& k : list) sum += k.weight;
  int ticket = draw.whole(0, sum - 1);
  auto kind = list.begin();
  while (ticket >= kind->weight) ticket -= (kind++)->weight;
  scene.kind = kind->name;
  Draft draft(scene);
  draft.given = !known;
  draft.approximate = known;
  kind->make(draw, draft);
  if (!known) draft.run(draw);
  // Names of the two sets, with which recorded scenes begin.
  const bool former = scene.suite == Suite::agreement;
  scene.text = fmt::format("format = {}\ntitle = \"{} {} of seed {}: {}\"\n{}", former ? 1 : 2,
                           former ? "Stranger" : "Random scene", index, seed, scene.kind, scene.text);
  return scene;
}

std::string text_for(const RandomScene& scene, const Way& way) {
  return way.options ? scene.text + way.options(scene) : scene.text;
}

Scene scene_for(const RandomScene& scene, const Way& way) {
  auto parsed = parse_scene(text_for(scene, way), fmt::format("{} {}", scene.kind, scene.index));
  if (way.choose) way.choose(parsed);
  return parsed;
}

bool has_model(const RandomScene& scene, const Way& way) {
  if (way.family == Family::nonsmooth) return true;
  if (scene.suite == Suite::rows) return scene.penalty;
  return std::ranges::all_of(scene_for(scene, way).mechanism.surfaces,
                             [](const Surface& s) { return s.restitution.value_or(1) > 0; });
}

}  // namespace freeplay::verification::random_scenes
