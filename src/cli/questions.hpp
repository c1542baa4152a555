// What a scene's numbers make one ask, on stderr: a run goes on, and its exit status stays as it is.
#pragma once

#include <fmt/format.h>

#include <cstdio>

#include "cli/wrapped.hpp"
#include "model/mechanism.hpp"
#include "model/sense.hpp"

namespace freeplay::cli {

inline void ask(const Mechanism& mechanism) {
  for (const auto& q : questions(mechanism)) fmt::print(stderr, "{}", wrapped("question: " + q + "\n", 10));
}

}  // namespace freeplay::cli
