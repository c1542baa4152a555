#include "facade/law_plugin.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include "io/digest.hpp"
#include "io/input_file.hpp"
#include "io/visible.hpp"
#include "model/error.hpp"

namespace freeplay {
namespace {

using NormalForce = double (*)(const char*, double, double, double);
constexpr int abi = 1;

/// Kept loaded as long as a law refers to it.
struct Plugin {
  explicit Plugin(void* opened) : handle(opened) {}
  Plugin(const Plugin&) = delete;
  Plugin& operator=(const Plugin&) = delete;
  ~Plugin() { dlclose(handle); }

  void* handle;
  NormalForce force = nullptr;
};

}  // namespace

std::shared_ptr<const OwnLaw> load_law_plugin(const std::filesystem::path& file) {
  const auto name = visible_brief(file.string());
  const auto refuse = [&](const std::string& why) {
    return SceneError(fmt::format("{}: is no plugin of a normal force: {}", name, why));
  };
  const auto bytes = read_file(file, most_of_a_result);
  // With a slash in it the name is a file's, and is looked for nowhere else.
  void* handle = dlopen(std::filesystem::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) throw refuse(visible_brief(dlerror()));
  auto plugin = std::make_shared<Plugin>(handle);
  const auto find = [&](const char* symbol) {
    void* found = dlsym(handle, symbol);
    if (!found)
      throw refuse(fmt::format("it exports no {}; docs/library.md says what it must export", symbol));
    return found;
  };
  const int version = reinterpret_cast<int (*)()>(find("freeplay_law_abi"))();
  if (version != abi)
    throw refuse(fmt::format("its freeplay_law_abi() is {}, this program's {}", version, abi));
  plugin->force = reinterpret_cast<NormalForce>(find("freeplay_normal_force"));
  OwnLaw law;
  law.force = [](const void* context, const char* contact, double delta, double rate, double v0) {
    return static_cast<const Plugin*>(context)->force(contact, delta, rate, v0);
  };
  law.name = visible_brief(file.filename().string());
  law.digest = digest(bytes);
  law.context = std::move(plugin);
  return std::make_shared<const OwnLaw>(std::move(law));
}

}  // namespace freeplay
