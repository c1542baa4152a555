// Code of a user's from a shared object. It exports, with C linkage,
//
//     int freeplay_law_abi(void);             1
//
// and one of these or both:
//
//     double freeplay_normal_force(const char* contact, double penetration, double rate, double touch_speed);
//
//     const char* const* freeplay_loads(void);     the loads that it stands in for, NULL after the last
//     void freeplay_load_force(const char* load, double t, const double place[2], const double velocity[2], double force[2]);
//
// as mechanism/own_law.hpp and mechanism/own_force.hpp say of `force`. It is code of its author's that runs in this program: nothing but its
// user's word loads it.
#pragma once

#include <filesystem>

#include "mechanism/outside.hpp"

namespace freeplay {

/// Its name is the file's, its digest that of the file's bytes. Throws SceneError for what is no such plugin.
Outside load_plugin(const std::filesystem::path& file);

}  // namespace freeplay
