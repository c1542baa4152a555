// JSON Schema (draft 4) of a kind of document, for editors and validators. The rows of kinds that
// share a table are merged, so a document that it accepts may still have keys that its choices do
// not read, or lack required ones: `freeplay check` tells.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "io/scene/schema.hpp"

namespace freeplay {

nlohmann::ordered_json json_schema(const Schema& schema);

}  // namespace freeplay
