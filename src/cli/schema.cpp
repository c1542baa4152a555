// freeplay schema KIND: prints the JSON Schema of scenes, studies or styles.
#include "io/scene/schema.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "plots/drawing/style.hpp"
#include "study/settings/study.hpp"

namespace freeplay::cli {
namespace {

struct SchemaRequest : Request {
  std::string kind;
};

int print_schema(const SchemaRequest& request) {
  const auto& schema = request.kind == "scene"   ? scene_schema()
                       : request.kind == "study" ? study_schema()
                                                 : plots::style_schema();
  fmt::print("{}\n", json_schema(schema).dump(2));
  return 0;
}

}  // namespace

void schema_verb(Program& program) {
  auto [options, request] =
      program.verb("schema", "print the JSON Schema of scenes, studies or styles", print_schema);
  options.add("kind", request.kind, "kind of file").required().one_of({"scene", "study", "style"});
}

}  // namespace freeplay::cli
