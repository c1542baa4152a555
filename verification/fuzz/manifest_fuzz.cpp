// A fuzz target for the files beside shards. Bytes are read as a manifest (whose plan is made to
// match it, as its writer could, with the units that it names), as a seal, and as the state of a
// shard. Each is read or refused with one SceneError.
#include "mechanism/error.hpp"
#include "study/partition/record.hpp"
#include "verification/fuzz/judged.hpp"

using namespace freeplay;

namespace {

/// With the digest of its content, if it has sufficient content.
std::string fitting(std::string text) {
  auto j = nlohmann::json::parse(text, nullptr, false);
  try {
    j["plan"] = plan_digest(j.get<Manifest>());
    return j.dump();
  } catch (const std::exception&) {
    return text;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = fuzz::text_of(data, size);
  // The file of units follows a line of dashes.
  const auto cut = std::min(input.find("\n---\n"), input.size());
  const auto text = fitting(std::string(input.substr(0, cut)));
  const auto put = [](std::string_view bytes, const char* name) {
    return fuzz::file_of(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), name);
  };
  const auto folder = put(text, "shards/manifest.json").parent_path().parent_path();
  put(input.substr(std::min(cut + 5, input.size())), "shards/units.txt");
  put(text, "shards/1.json");
  put(text, "shards/1.state.json");
  state_of(folder, 1);
  const auto seal = read_seal(folder, 1);
  try {
    const auto manifest = read_manifest(folder);
    if (seal) fault_of(*seal, manifest, folder, true);
    command_for(manifest, {"--shard", "1/1"});
    // A study with more units than this is not tested with a file of a few kilobytes.
    if (manifest.units < 1000) units_of(manifest, folder, 1);
  } catch (const SceneError& e) {
    fuzz::assess(e, input);
  }
  return 0;
}
