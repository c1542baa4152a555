// A normal force from a shared object. It exports, with C linkage,
//
//     int freeplay_law_abi(void);             1
//     double freeplay_normal_force(const char* contact, double penetration, double rate, double touch_speed);
//
// as model/own_law.hpp says of `force`. It is code of its author's that runs in this program: nothing but its user's word loads it.
#pragma once

#include <filesystem>
#include <memory>

#include "model/own_law.hpp"

namespace freeplay {

/// Its name is the file's, its digest that of the file's bytes. Throws SceneError for what is no such plugin.
std::shared_ptr<const OwnLaw> load_law_plugin(const std::filesystem::path& file);

}  // namespace freeplay
