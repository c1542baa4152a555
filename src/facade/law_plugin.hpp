// Plugin: contact laws and load forces of the user in a shared object. It exports, with C linkage,
//
//     int freeplay_law_abi(void);                  returns 1
//
// and at least one of the following:
//
//     double freeplay_normal_force(const char* contact, double penetration, double rate,
//                                  double touch_speed);
//
//     const char* const* freeplay_loads(void);     names of the loads it replaces, then NULL
//     void freeplay_load_force(const char* load, double t, const double place[2],
//                              const double velocity[2], double force[2]);
//
// mechanism/outside.hpp specifies arguments, units and conditions of the
// functions. A plugin runs with the rights of this process, so it is loaded only if the user
// requests it (`--law-plugin`).
#pragma once

#include <filesystem>

#include "mechanism/outside.hpp"

namespace freeplay {

/// Loads a plugin. Its name is the file's name, its digest that of the file's bytes. The returned
/// laws and forces keep the shared object loaded. Throws SceneError if the file is not a valid
/// plugin.
Outside load_plugin(const std::filesystem::path& file);

}  // namespace freeplay
