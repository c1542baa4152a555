#include "facade/law_plugin.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <link.h>

#include <array>
#include <memory>

#include "compile/compiled_object.hpp"
#include "io/files/digest.hpp"
#include "io/files/escaping.hpp"
#include "io/files/input_file.hpp"
#include "mechanism/error.hpp"

namespace freeplay {
namespace {

using NormalForce = double (*)(const char*, double, double, double);
using Loads = const char* const* (*)();
using LoadForce = void (*)(const char*, double, const double*, const double*, double*);
constexpr int abi = 1;

/// An open shared object. Each law or force that uses it shares its ownership.
struct Plugin {
  explicit Plugin(void* opened) : handle(opened) {}
  Plugin(const Plugin&) = delete;
  Plugin& operator=(const Plugin&) = delete;
  ~Plugin() { dlclose(handle); }

  void* handle;
  NormalForce normal = nullptr;
  LoadForce load = nullptr;
};

double normal_force(const void* context, const char* contact, double delta, double rate, double v0) {
  return static_cast<const Plugin*>(context)->normal(contact, delta, rate, v0);
}

Vec2 load_force(const void* context, const char* load, double t, const Vec2& place, const Vec2& velocity) {
  const std::array r{place.x(), place.y()}, v{velocity.x(), velocity.y()};
  std::array<double, 2> f{};
  static_cast<const Plugin*>(context)->load(load, t, r.data(), v.data(), f.data());
  return {f[0], f[1]};
}

}  // namespace

Outside load_plugin(const std::filesystem::path& file) {
  const auto name = visible_brief(file.string());
  const auto refuse = [&](const std::string& why) {
    return SceneError(fmt::format("{}: is not a plugin of contact forces: {}", name, why));
  };
  const auto bytes = read_file(file, most_of_a_result);
  if (bytes.starts_with(ELFMAG) && !is_whole_object(bytes))
    throw refuse("it is incomplete; build or copy it again");
  // With a slash in it the name is a file's, and is looked for nowhere else.
  void* handle = dlopen(std::filesystem::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) throw refuse(visible_brief(dlerror()));
  auto plugin = std::make_shared<Plugin>(handle);
  const auto need = [&](const char* symbol) {
    void* found = dlsym(handle, symbol);
    if (!found)
      throw refuse(fmt::format(
          "it does not export {}; docs/reference/library.md lists the required functions", symbol));
    return found;
  };
  const int version = reinterpret_cast<int (*)()>(need("freeplay_law_abi"))();
  if (version != abi)
    throw refuse(fmt::format("its freeplay_law_abi() is {}, this program's {}", version, abi));
  const auto short_name = visible_brief(file.filename().string()), content = digest(bytes);
  Outside outside;
  void* loads = dlsym(handle, "freeplay_loads");
  if (!loads || dlsym(handle, "freeplay_normal_force")) {
    plugin->normal = reinterpret_cast<NormalForce>(need("freeplay_normal_force"));
    outside.law = std::make_shared<const OwnLaw>(OwnLaw{normal_force, plugin, short_name, content});
  }
  if (loads) {
    plugin->load = reinterpret_cast<LoadForce>(need("freeplay_load_force"));
    const auto force = std::make_shared<const OwnForce>(OwnForce{load_force, plugin, short_name, content});
    for (const auto* load = reinterpret_cast<Loads>(loads)(); load && *load; ++load)
      outside.forces[*load] = force;
  }
  return outside;
}

}  // namespace freeplay
