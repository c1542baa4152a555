/// @file
/// Public interface of the Freeplay library: simulation of planar mechanisms whose joints have
/// clearance. A program includes this header alone.
///
/// One scene can be integrated in two formulations, selected by name:
///
/// - `"penalty"`: continuous contact forces, F_N = max(0, K δⁿ (1 + χ δ̇/v₀)), in an index-1 DAE
///   with Baumgarte's stabilisation. See docs/theory/penalty.md for the contact laws and
///   their sources.
/// - `"nonsmooth"`: unilateral constraints with Newton's restitution and Coulomb's set-valued
///   friction, integrated from event to event or by the time stepping of Moreau and Jean. See
///   docs/theory/nonsmooth.md.
///
/// Usage:
///
///     auto scene = freeplay::read_scene("scene.toml");
///     scene.set("joints.gudgeon.clearance", "1e-3");  // a key of docs/reference/scene.md, in SI
///     freeplay::Simulation simulation(scene, "nonsmooth");
///     freeplay::Trajectory path;  // an observer that records rows of the state
///     const auto result = simulation.run({.until = 1.0, .observers = {&path}});
///     for (std::size_t k = 0; k < path.size(); ++k) use(path.t(k), path.q(k), path.v(k));
///
/// Main types:
///
/// - Scene (mechanism/scene.hpp): the mechanism and the options of a run. read_scene() and
///   parse_scene() read it from TOML; a program can also fill its members.
/// - Simulation (facade/simulation.hpp): a copy of the scene, one formulation and the current
///   state. It runs, and it takes and restores snapshots.
/// - Observer (simulation/observer.hpp): base class of objects that receive the accepted steps, the
///   contact events and the samples of the instruments. Trajectory, Energies, EventList and
///   ContactStatistics are observers.
/// - Result (values/result.hpp): final state, energy ledger, counters, events and notes of a run.
/// - Snapshot (values/snapshot.hpp): the complete state of a run, from which it continues bit for
///   bit.
/// - sensitivities() (analysis/sensitivity.hpp): derivatives of results with respect to scene keys and
///   initial values.
/// - orbit() (analysis/orbit.hpp): periodic motions and their Floquet multipliers.
/// - lyapunov() (analysis/lyapunov.hpp): Lyapunov exponents of a motion with impacts.
/// - continue_orbit() (analysis/continuation.hpp): branches of periodic motions and their bifurcations.
/// - find_play() (analysis/play/play.hpp): ranges of outputs within the clearances, with proved bounds;
///   allocate_clearances() (analysis/play/play_allocation.hpp): clearances of least cost for a range.
/// - Outside (mechanism/outside.hpp): contact laws and load forces that the caller implements.
///
/// Units: SI and radians throughout. No member takes another unit, except the text that
/// Scene::set() parses, which may state one.
///
/// Shapes: for a mechanism of n bodies, `q` has 3n entries, x and y (m) of the centre of mass and
/// the angle θ (rad) of each body, in the order of Mechanism::bodies. `v` has 3n entries, their
/// rates. `z` has one entry for each first-order state (a motor's current, for example), in the
/// order of the elements.
///
/// Errors:
///
/// - ModelError: the scene is incomplete or contradictory; it names the key.
/// - SceneError, derived from ModelError: as above, with file, line and column, or with the
///   KEY=VALUE setting.
/// - SnapshotError: a snapshot cannot be read, or belongs to another scene, formulation or program.
/// - Interrupted: the caller requested a stop while the start was assembled.
/// - std::logic_error: the caller broke a precondition, such as running a simulation from its own
///   observer.
///
/// A numerical failure throws no exception: Result::ending has the status `failed` and the reason.
/// The caller must check it, and should show Result::notes to the user.
///
/// Threads: simulations are independent of each other. One thread at a time may use a simulation.
///
/// The public headers need the C++20 standard library only. With CMake, find_package(freeplay) and
/// link freeplay::freeplay. docs/reference/library.md has complete examples.
#pragma once

#include "analysis/continuation.hpp"
#include "analysis/lyapunov.hpp"
#include "analysis/orbit.hpp"
#include "analysis/play/play.hpp"
#include "analysis/play/play_allocation.hpp"
#include "analysis/sensitivity.hpp"
#include "compile/compiled_structures.hpp"
#include "facade/simulation.hpp"
#include "mechanism/outside.hpp"
#include "mechanism/scene.hpp"
#include "simulation/observer.hpp"
#include "simulation/statistics.hpp"
#include "simulation/trajectory.hpp"
#include "values/branch.hpp"
#include "values/identity.hpp"
#include "values/lyapunov.hpp"
#include "values/orbit.hpp"
#include "values/play.hpp"
#include "values/result.hpp"
#include "values/sensitivity.hpp"
#include "values/snapshot.hpp"
#include "values/stop.hpp"
