// Which kind an index is, and what each way adds to a scene.
#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "verification/random_scenes/builder.hpp"

namespace freeplay::verification::random_scenes {
namespace {

struct Kind {
  const char* name;
  void (*make)(Builder&);
  int weight;  ///< how often, of the sum
};
constexpr Kind all_kinds[] = {
    {"table", moved_table, 3}, {"stop", moved_stop, 3},        {"lever", moved_lever, 2},
    {"teeth", teeth, 2},       {"journal", moved_journal, 1},  {"follower", follower, 3},
    {"pushed", pushed, 3},     {"barrier", barrier, 3},        {"scales", two_scales, 2},
    {"one-way", one_way, 3},   {"column", touching_column, 2}, {"row", touching_row, 2},
    {"grid", touching_grid, 1}};

std::vector<Kind> selected(const std::string& selection) {
  std::vector<Kind> list;
  std::istringstream in(selection);
  for (std::string name; std::getline(in, name, ',');) {
    const auto before = list.size();
    for (const auto& k : all_kinds)
      if (name == "new" || name == k.name) list.push_back(k);
    if (list.size() == before) {
      std::string known = "new";
      for (const auto& k : all_kinds) known += std::string(", ") + k.name;
      throw std::invalid_argument(
          fmt::format("there is no kind of random scene \"{}\"; there are: {}", name, known));
    }
  }
  return list;
}

std::string nonsmooth(const std::string& lines) { return "[nonsmooth]\n" + lines; }
std::string penalty(const RandomScene& s, const char* integrator) {
  auto text = fmt::format(
      "[penalty]\nv0_floor = {0}\nfriction_v0 = {0}\nfriction_v1 = {1}\nalpha = {2}\nbeta = {2}\n",
      text_of(1e-3 * s.speed), text_of(1e-2 * s.speed), text_of(10 / s.duration));
  return text + (integrator ? fmt::format("integrator = \"{}\"\n", integrator) : "");
}

constexpr Way all_ways[] = {
    {"event-driven", Family::nonsmooth,
     [](const RandomScene&) { return nonsmooth("scheme = \"event-driven\"\n"); }},
    {"automatic", Family::nonsmooth,
     [](const RandomScene&) { return nonsmooth("scheme = \"automatic\"\n"); }},
    {"moreau-jean adaptive", Family::nonsmooth,
     [](const RandomScene&) { return nonsmooth("scheme = \"moreau-jean\"\n"); }},
    {"moreau-jean fixed", Family::nonsmooth,
     [](const RandomScene& s) {
       return nonsmooth(fmt::format("scheme = \"moreau-jean\"\nstep = {}\n", text_of(s.step)));
     },
     true},
    {"adams_bashforth_moulton", Family::penalty, [](const RandomScene& s) { return penalty(s, nullptr); }},
    {"rosenbrock4", Family::penalty, [](const RandomScene& s) { return penalty(s, "rosenbrock4"); }},
    {"bulirsch_stoer", Family::penalty, [](const RandomScene& s) { return penalty(s, "bulirsch_stoer"); }},
    {"dopri5", Family::penalty, [](const RandomScene& s) { return penalty(s, "dopri5"); }},
    {"rk4", Family::penalty,
     [](const RandomScene& s) {
       return penalty(s, "rk4") + fmt::format("step = {}\n", text_of(s.contact_step));
     },
     true},
};

}  // namespace

std::vector<std::string> kinds() {
  std::vector<std::string> names;
  for (const auto& k : all_kinds) names.emplace_back(k.name);
  return names;
}

std::span<const Way> ways() { return all_ways; }

RandomScene draw(std::uint64_t seed, int index, const std::string& selection) {
  const auto list = selected(selection);
  Draw draw(seed ^ 0x72616e646f6dULL, static_cast<std::uint64_t>(index));
  int sum = 0;
  for (const auto& k : list) sum += k.weight;
  int ticket = draw.whole(0, sum - 1);
  auto kind = list.begin();
  while (ticket >= kind->weight) ticket -= (kind++)->weight;
  RandomScene scene;
  scene.seed = seed;
  scene.index = index;
  scene.kind = kind->name;
  Builder b(draw, scene);
  kind->make(b);
  scene.text = fmt::format("format = 2\ntitle = \"Random scene {} of seed {}: {}\"\n{}", index, seed,
                           scene.kind, scene.text);
  return scene;
}

std::string text_for(const RandomScene& scene, const Way& way) { return scene.text + way.options(scene); }

}  // namespace freeplay::verification::random_scenes
