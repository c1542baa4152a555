#include "io/scene/located.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "io/scene/section.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {

SceneError located(const Scene& scene, const ModelError& error) {
  const auto file = scene.file.string();
  const auto plain = [&] {
    return SceneError(file.empty() ? std::string(error.what()) : fmt::format("{}: {}", file, error.what()));
  };
  if (scene.text.empty() || error.key.empty()) return plain();
  try {
    SceneSource source{.name = file};
    const auto document = parse_toml(scene.text, file);
    for (const auto& given : scene.overrides) {
      source.order.push_back(given.substr(0, given.find_first_of("[=")));
      source.overridden[source.order.back()] = given;
    }
    // The key itself, or the innermost table around it that the file contains.
    const toml::node* node = nullptr;
    const toml::table* table = &document;
    for (std::size_t from = 0; table && from < error.key.size();) {
      const auto dot = std::min(error.key.find('.', from), error.key.size());
      const auto* next = table->get(error.key.substr(from, dot - from));
      if (!next) break;
      node = next;
      table = next->as_table();
      from = dot + 1;
    }
    source.fail(node, error.key, error.message);
  } catch (const SceneError& e) {
    return e;
  }
}

}  // namespace freeplay
