// What a scene's numbers make one ask, on stderr: a run goes on, and its exit status stays as it is.
#pragma once

#include <fmt/format.h>

#include <cstdio>

#include "cli/wrapped.hpp"
#include "model/scene.hpp"
#include "model/sense.hpp"

namespace freeplay::cli {

inline void ask(const Scene& scene) {
  for (const auto& q : questions(scene.mechanism))
    fmt::print(stderr, "{}", wrapped("question: " + q + "\n", 10));
  for (const auto& key : scene.idle) fmt::print(stderr, "{}", wrapped("note: " + key + "\n", 6));
}

}  // namespace freeplay::cli
