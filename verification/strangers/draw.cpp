// Which kind of stranger an index is.
#include "verification/strangers/draft.hpp"
#include "verification/strangers/strangers.hpp"

namespace freeplay::verification::strangers {
namespace {

struct Kind {
  const char* name;
  void (*make)(Draw&, Draft&);
  int weight;  ///< how often, of the sum
};
constexpr Kind all_kinds[] = {
    {"thrown", thrown, 3},   {"cluster", cluster, 2},     {"box", box, 2},
    {"pile", pile, 2},       {"sliding", sliding, 2},     {"springs", springs, 2},
    {"bump", bump, 3},       {"chain", chain, 4},         {"loop", loop, 4},
    {"guide", guide, 2},     {"pulse", pulse, 3},         {"film", film, 1},
    {"motored", motored, 2}, {"preloaded", preloaded, 1}, {"compliant", compliant, 2},
    {"cams", cams, 2},       {"toothed", toothed, 3},     {"stopped", stopped, 2}};

}  // namespace

std::vector<std::string> kinds() {
  std::vector<std::string> names;
  for (const auto& k : all_kinds) names.emplace_back(k.name);
  return names;
}

Stranger draw(std::uint64_t seed, int index) {
  Draw draw(seed, static_cast<std::uint64_t>(index));
  int sum = 0;
  for (const auto& k : all_kinds) sum += k.weight;
  int ticket = draw.whole(0, sum - 1);
  const Kind* kind = all_kinds;
  while (ticket >= kind->weight) ticket -= (kind++)->weight;
  Draft draft;
  kind->make(draw, draft);
  draft.run(draw);
  return {seed, index, kind->name,
          fmt::format("format = 1\ntitle = \"Stranger {} of seed {}: {}\"\n{}", index, seed, kind->name,
                      draft.text)};
}

}  // namespace freeplay::verification::strangers
