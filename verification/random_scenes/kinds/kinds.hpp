// The kinds of random scenes: each draws one scene.
#pragma once

#include "verification/random_scenes/draft.hpp"

namespace freeplay::verification::random_scenes {

/// @name Without a reference: free bodies (free.cpp)
///@{
/// Bodies past or against discs and walls, grazing among them.
void thrown(Draw& draw, Draft& out);
/// Free discs against each other, nothing else in the world.
void cluster(Draw& draw, Draft& out);
/// Discs between four walls.
void box(Draw& draw, Draft& out);
/// Discs that fall into a box.
void pile(Draw& draw, Draft& out);
/// Starts in contact: rolling, sliding, resting on feet.
void sliding(Draw& draw, Draft& out);
/// Masses on springs and dampers between stops.
void springs(Draw& draw, Draft& out);
///@}
/// @name Without a reference: jointed bodies (jointed.cpp)
///@{
/// Contacts of a spinning rotor's bump with pegs, levers and free discs.
void bump(Draw& draw, Draft& out);
/// One to six links, pinned or floating, joints with clearance.
void chain(Draw& draw, Draft& out);
/// Closed chains, driven, clearance in one to three joints.
void loop(Draw& draw, Draft& out);
/// Sliders with clearance in guides.
void guide(Draw& draw, Draft& out);
/// Rotors under pulses and tables, with a link attached by a joint with clearance.
void pulse(Draw& draw, Draft& out);
/// Rotors with motors, governors and prescribed starts, with a link attached by a joint with
/// clearance.
void motored(Draw& draw, Draft& out);
/// Lubricated journals.
void film(Draw& draw, Draft& out);
/// Sliders with friction of fixed bound that reach stops.
void preloaded(Draw& draw, Draft& out);
///@}
/// @name Without a reference: teeth and end stops (toothed.cpp)
///@{
/// External and internal gears and racks, sometimes on bearings with clearance.
void toothed(Draw& draw, Draft& out);
/// Levers, sliders and pins in slots between end stops.
void stopped(Draw& draw, Draft& out);
///@}
/// @name Without a reference: springs and cams (compliant.cpp)
///@{
/// Masses on nonlinear springs, and on bushings.
void compliant(Draw& draw, Draft& out);
/// Cams, driven or free, under faces and rollers.
void cams(Draw& draw, Draft& out);
///@}
/// @name With a reference for every row: bodies on curves (moved.cpp)
///@{
/// Balls on a table on a curve.
void moved_table(Draw& draw, Draft& out);
/// A slider on a spring between stops of a slide on a curve.
void moved_stop(Draw& draw, Draft& out);
/// An arm between angle stops of a rotor on a curve.
void moved_lever(Draw& draw, Draft& out);
/// A wheel between the flanks of one on a curve.
void teeth(Draw& draw, Draft& out);
/// A journal in a bearing on a curve.
void moved_journal(Draw& draw, Draft& out);
/// A position prescribed over the angle of a rotor, free or driven.
void follower(Draw& draw, Draft& out);
/// A slow drive beside a fast oscillator on a stop.
void two_scales(Draw& draw, Draft& out);
///@}
/// @name With a reference for every row: forces (pushed.cpp)
///@{
/// Sliders and rotors under forces against time, position, angle and speed.
void pushed(Draw& draw, Draft& out);
/// Forces over position without net work.
void barrier(Draw& draw, Draft& out);
/// One-sided springs and bump stops.
void one_way(Draw& draw, Draft& out);
///@}
/// @name With a reference for every row: touching bodies (touching.cpp)
///@{
/// Discs on each other, falling on a floor.
void touching_column(Draw& draw, Draft& out);
/// Discs or blocks in a row, hit by one.
void touching_row(Draw& draw, Draft& out);
/// Discs in a grid, hit by one.
void touching_grid(Draw& draw, Draft& out);
///@}

}  // namespace freeplay::verification::random_scenes
