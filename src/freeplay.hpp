// Freeplay as a library: mechanisms whose joints have play, in two formulations of one scene.
//
//     auto scene = freeplay::read_scene("scene.toml");
//     scene.set("joints.gudgeon.clearance", "1e-3");
//     freeplay::Simulation simulation(scene, "nonsmooth");
//     freeplay::Trajectory path;
//     const auto result = simulation.run({.until = 1.0, .observers = {&path}});
//
// SI units throughout. Needs the standard library alone. Errors: ModelError for a scene that lacks or contradicts
// something (SceneError with file, line and column where it was read from a file), SnapshotError; a numerical
// failure is no exception but Result::ending.
#pragma once

#include "facade/simulation.hpp"
#include "mechanism/outside.hpp"
#include "mechanism/scene.hpp"
#include "simulation/observer.hpp"
#include "simulation/statistics.hpp"
#include "simulation/trajectory.hpp"
#include "values/identity.hpp"
#include "values/result.hpp"
#include "values/snapshot.hpp"
#include "values/stop.hpp"
