"""Periodic motions, their branches, Lyapunov exponents and output play, against closed forms."""

import tomllib
import unittest
from pathlib import Path

import numpy as np

import freeplay as fp

ROOT = Path(__file__).resolve().parents[2]
OSCILLATOR = {
    "gravity": [0.0, 0.0],
    "bodies": {"mass": {"mass": 1.0, "inertia": 0.01, "position": [0.0, 0.0]}},
    "joints": {
        "rail": {
            "type": "translational",
            "between": ["ground", "mass"],
            "at": [[0.0, 0.0], [0.0, 0.0]],
            "axis": [1.0, 0.0],
        }
    },
    "loads": {
        "spring": {
            "type": "spring-damper",
            "between": ["ground", "mass"],
            "at": [[-1.0, 0.0], [0.0, 0.0]],
            "stiffness": 100.0,
            "free_length": 1.0,
            "damping": 4.0,
        }
    },
    "contacts": {"stop": {"type": "travel-stop", "joint": "rail", "upper": 10.0, "surface": "hard"}},
    "surfaces": {"hard": {"restitution": 0.5}},
    "curves": {"force": {"shape": "harmonic", "amplitude": 5.0, "period": 1.0}},
    "drives": {"shaker": {"joint": "rail", "force": "force", "against": "time"}},
    "run": {"duration": 1.0, "start": "given"},
    "nonsmooth": {"scheme": "event-driven"},
}


class Motions(unittest.TestCase):
    def test_orbit(self):
        found = fp.orbit(OSCILLATOR, settle=2)
        self.assertEqual(found.failure, "")
        self.assertTrue(found.stable)
        self.assertEqual(len(found.impacts), 0)
        # exp(lambda T) with lambda^2 + 4 lambda + 100 = 0 and T = 1 s
        self.assertAlmostEqual(abs(found.multipliers[0]), np.exp(-2), delta=1e-7)
        angle = abs(np.angle(np.exp(96**0.5 * 1j)))
        self.assertAlmostEqual(abs(np.angle(found.multipliers[0])), angle, delta=1e-6)
        stepped = fp.orbit(OSCILLATOR, settle=2, set={"nonsmooth.scheme": "moreau-jean"})
        self.assertGreater(stepped.step_error, 0)
        self.assertAlmostEqual(abs(stepped.multipliers[0]), np.exp(-2), delta=1e-4)
        with self.assertRaises(fp.SceneError):
            fp.orbit(OSCILLATOR, shift=["x"])
        twice = fp.orbit(OSCILLATOR, settle=2, periods=2)
        self.assertAlmostEqual(abs(twice.multipliers[0]), np.exp(-4), delta=1e-7)
        with self.assertRaisesRegex(fp.SceneError, "contradicts"):
            fp.orbit(OSCILLATOR, settle=2, period=2.0)
        # Without force and damper the period is 2 pi/10 s at any amplitude.
        free = {name: part for name, part in OSCILLATOR.items() if name not in ("curves", "drives")}
        free["bodies"] = {"mass": {"mass": 1.0, "inertia": 0.01, "position": [0.05, 0.0]}}
        swing = fp.orbit(free, settle=0, period=0.6, set={"loads.spring.damping": 0.0})
        self.assertEqual(swing.failure, "")
        self.assertAlmostEqual(swing.period, 2 * np.pi / 10, delta=1e-8)
        # Without a contact the penalty formulation has the same motion.
        smooth = {name: part for name, part in OSCILLATOR.items() if name not in ("contacts", "surfaces")}
        stiff = fp.orbit(smooth, "penalty", settle=2)
        self.assertAlmostEqual(abs(stiff.multipliers[0]), np.exp(-2), delta=1e-5)

    def test_continue_orbit(self):
        found = fp.continue_orbit(OSCILLATOR, "curves.force.amplitude", 5.0, 6.0, settle=2)
        self.assertEqual(found.failure, "")
        self.assertGreater(len(found.points), 5)
        # The multipliers of a linear oscillator do not depend on the force, and its motion is
        # proportional to it.
        self.assertLess(np.ptp(found.points["greatest_modulus"]), 1e-6)
        first, last = found.orbits[0], found.orbits[-1]
        ratio = found.points["parameter"].iloc[-1] / found.points["parameter"].iloc[0]
        self.assertAlmostEqual(last.q[0], ratio * first.q[0], delta=1e-7)
        self.assertEqual(len(found.bifurcations), 0)
        self.assertEqual((len(found.curves), len(found.curve_ends)), (0, 0))

    def test_continue_orbit_over_two_keys(self):
        # A body on a table that moves as A sin(w t + 2) lifts off at A w^2 = g.
        g, period = 9.81, 0.1

        def at(T):
            return g * (T / (2 * np.pi)) ** 2

        near, w = 0.9 * at(period), 2 * np.pi / period
        rail = {"type": "translational", "axis": [0.0, 1.0]}
        carried = {
            "gravity": [0.0, -g],
            "bodies": {
                "table": {"mass": 1.0, "inertia": 0.01},
                "load": {
                    "mass": 0.3,
                    "inertia": 0.01,
                    "position": [0.0, 0.05 + near * np.sin(2)],
                    "velocity": [0.0, near * w * np.cos(2)],
                },
            },
            "joints": {
                "guide": {"between": ["ground", "table"], **rail},
                "rail": {"between": ["ground", "load"], **rail},
            },
            "contacts": {
                "pair": {"type": "plane", "between": ["table", "load"], "radius": 0.05, "surface": "hard"}
            },
            "surfaces": {"hard": {"restitution": 0.5}},
            "curves": {"shake": {"shape": "harmonic", "amplitude": near, "period": period, "phase": 2.0}},
            "drives": {"shaker": {"joint": "guide", "position": "shake"}},
            "run": {"duration": 1.0, "start": "assembled"},
            "nonsmooth": {"scheme": "event-driven", "tolerance": 1e-10},
        }
        found = fp.continue_orbit(
            carried,
            "curves.shake.amplitude",
            0.8 * at(period),
            1.6 * at(period),
            start=near,
            step=0.2 * at(period),
            settle=0,
            second="curves.shake.period",
            second_from=period,
            second_to=1.02 * period,
            second_step=0.01 * period,
            curves=["liftoff"],
        )
        self.assertEqual(found.failure, "")
        # The branch begins at the start and is followed to both sides.
        self.assertAlmostEqual(found.points["parameter"].iloc[0], near, delta=1e-12)
        self.assertAlmostEqual(found.points["parameter"].min(), 0.8 * at(period), delta=1e-9)
        self.assertEqual(list(found.bifurcations["kind"]), ["liftoff"])
        self.assertAlmostEqual(found.bifurcations["parameter"].iloc[0] / at(period), 1, delta=1e-8)
        self.assertEqual(list(found.curve_ends["kind"]), ["liftoff"])
        self.assertEqual(found.curve_ends["points"].sum(), len(found.curves))
        self.assertGreater(len(found.curves), 3)
        self.assertEqual(set(found.curves["joint"]), {"pair"})
        # Eight digits, as the claims of curves over two keys have them.
        error = found.curves["parameter"] / at(found.curves["second"]) - 1
        self.assertLess(abs(error).max(), 1e-8)
        with self.assertRaises(TypeError):
            fp.continue_orbit(OSCILLATOR, "curves.force.amplitude", 5.0, 6.0, second="contacts.stop.upper")
        with self.assertRaises(TypeError):
            fp.continue_orbit(OSCILLATOR, "curves.force.amplitude", 5.0, 6.0, curves=["fold"])
        with self.assertRaisesRegex(fp.SceneError, "no kind of curve"):
            fp.continue_orbit(
                OSCILLATOR,
                "curves.force.amplitude",
                5.0,
                6.0,
                second="contacts.stop.upper",
                second_from=5.0,
                second_to=15.0,
                curves=["sequence"],
            )

    def test_lyapunov(self):
        found = fp.lyapunov(OSCILLATOR, set={"run.duration": 40.0})
        self.assertEqual(found.failure, "")
        # x'' + 4 x' + 100 x = f(t): both exponents are -2/s, up to the phase at the ends of 36 s.
        self.assertEqual(len(found.exponents), 2)
        for value in found.exponents["value"]:
            self.assertAlmostEqual(value, -2, delta=0.1)
        self.assertAlmostEqual(found.sum, -4, delta=1e-6)
        self.assertAlmostEqual(found.sum_predicted, -4, delta=1e-6)

    def test_play(self):
        scene = ROOT / "verification/scenes/play/four_bar.toml"
        found = fp.play(scene, ["rocker.theta", "coupler.x"], "A", 0.0, np.pi, points=7)
        self.assertEqual((found.joint, found.unit), ("A", "rad"))
        np.testing.assert_allclose(found.positions, np.linspace(0, np.pi, 7), rtol=1e-15)
        self.assertEqual(found.refusals, [""] * 7)
        self.assertEqual(list(found.clearances["joint"]), ["B", "C"])
        np.testing.assert_allclose(found.clearances["clearance"], 1e-4)
        rocker = found.ranges["rocker.theta"]
        self.assertEqual(rocker.unit, "rad")
        self.assertEqual(found.ranges["coupler.x"].unit, "m")
        # The coupler acts as one of the length 0.3 m -+ 0.2 mm: published digits, at 0, 60, 90 and 180 degrees.
        width = [2.000000224e-3, 1.719778598e-3, 1.614414836e-3, 1.697056820e-3]
        np.testing.assert_allclose(rocker.width[[0, 2, 3, 6]], width, rtol=0, atol=5.01e-13)
        self.assertAlmostEqual(rocker.ideal[2], 1.75468985659707918, delta=1e-12)
        self.assertTrue((rocker.bound_least <= rocker.least).all())
        self.assertTrue((rocker.bound_greatest >= rocker.greatest).all())
        np.testing.assert_allclose(2 * rocker.linear, rocker.width, rtol=1e-5)
        np.testing.assert_allclose(rocker.parts.sum(axis=1), rocker.width, rtol=1e-12)
        np.testing.assert_allclose(rocker.variance, 0.5, rtol=1e-9)
        # theta of the third body
        np.testing.assert_allclose(found.poses[:, 8], rocker.ideal, rtol=1e-14)
        np.testing.assert_allclose(rocker.at_greatest[:, 8], rocker.greatest, rtol=1e-14)
        self.assertTrue(rocker.settled.all())
        self.assertIsNone(rocker.quantiles)
        self.assertIsNone(rocker.loaded_up)
        self.assertIsNone(found.up)
        self.assertIsNone(found.allocation)
        self.assertIn("50 % by B", rocker.verdict)
        self.assertEqual(found.verdicts[0], rocker.verdict)

    def test_play_at_the_start(self):
        scene = ROOT / "verification/scenes/play/four_bar.toml"
        found = fp.play(scene, ["rocker.theta"], samples=1000, loads=True, set={"gravity": [0.0, -9.81]})
        rocker = found.ranges["rocker.theta"]
        self.assertEqual(len(found.positions), 1)
        self.assertAlmostEqual(rocker.width[0], 1.719778598e-3, delta=5.01e-13)
        self.assertEqual(list(rocker.quantiles.columns), [0.00135, 0.025, 0.5, 0.975, 0.99865])
        quantiles = rocker.quantiles.to_numpy()[0]
        self.assertTrue((np.diff(quantiles) > 0).all())
        self.assertTrue(rocker.least[0] <= quantiles[0] and quantiles[-1] <= rocker.greatest[0])
        self.assertAlmostEqual(quantiles[2], rocker.ideal[0], delta=0.1 * rocker.width[0])
        self.assertEqual(found.up.failures, [""])
        self.assertTrue(rocker.bound_least[0] <= rocker.loaded_up[0] <= rocker.bound_greatest[0])
        self.assertEqual(found.up.poses[0, 8], rocker.loaded_up[0])
        self.assertEqual(list(found.up.reactions.columns[:3]), ["A.fx", "A.fy", "A.m"])
        self.assertEqual(len(found.jumps), 0)

    def test_play_allocates_clearances(self):
        scene = ROOT / "verification/scenes/play/four_bar.toml"
        # The width follows from the sum of both clearances. Costs 4/c_B + 1/c_C are least with c_B = 2 c_C.
        costs = [
            {"joint": "B", "cost": 4, "exponent": 1, "least": 1e-6, "greatest": 1e-3},
            {"joint": "C", "cost": 1, "exponent": 1, "least": 1e-6, "greatest": 1e-3},
        ]
        found = fp.play(scene, ["rocker.theta"], target=1.719778598e-3, costs=costs)
        np.testing.assert_allclose(found.allocation["before"], 1e-4)
        np.testing.assert_allclose(found.allocation["after"], [0.4e-3 / 3, 0.2e-3 / 3], rtol=1e-7)
        self.assertEqual(list(found.allocation["limit"]), ["", ""])
        np.testing.assert_allclose(found.clearances["clearance"], found.allocation["after"])
        with self.assertRaisesRegex(fp.SceneError, "cannot be met"):
            fp.play(scene, ["rocker.theta"], target=1e-4, costs=costs[:1])

    def test_play_with_a_tolerance_and_a_region(self):
        document = tomllib.loads((ROOT / "verification/scenes/play/four_bar.toml").read_text())
        document["joints"]["C"]["at"] = [[0.15, 0.0], [0.125, 0.0]]
        document["tolerances"] = {"length": {"key": "joints.C.at[0][0]", "upper": 1e-4}}
        scene = fp.Scene(document)
        found = fp.play(scene, ["coupler.x", "coupler.y", "rocker.theta"], samples=1000)
        shares = found.ranges["rocker.theta"].variance.iloc[0]
        # Both pins on discs of 0.1 mm and the length within 0.1 mm move the rocker alike: 1/4, 1/4 and 1/3.
        np.testing.assert_allclose(shares[["B", "C", "joints.C.at[0][0]"]], [0.3, 0.3, 0.4], rtol=1e-4)
        self.assertEqual(set(found.regions["point"]), {"coupler"})
        along = np.cos(found.regions["phi"]) * (found.regions["x"] - found.regions["ideal_x"]) + np.sin(
            found.regions["phi"]
        ) * (found.regions["y"] - found.regions["ideal_y"])
        self.assertTrue((along <= found.regions["bound"]).all())
        east = found.regions[found.regions["phi"] == 0]
        np.testing.assert_allclose(east["x"], found.ranges["coupler.x"].greatest, rtol=1e-12)

    def test_play_refuses(self):
        scene = ROOT / "verification/scenes/play/four_bar.toml"
        with self.assertRaisesRegex(fp.SceneError, "no quantity"):
            fp.play(scene, ["rocker.tip"])
        with self.assertRaisesRegex(fp.SceneError, "no drive prescribes"):
            fp.play(scene, ["rocker.theta"], "B", 0.0, 1.0)
        with self.assertRaisesRegex(fp.SceneError, "dead centre"):
            fp.play(scene, ["rocker.theta"], set={"joints.B.clearance": 0.04, "joints.B.bearing_radius": 0.5})
        with self.assertRaisesRegex(fp.SceneError, "points"):
            fp.play(scene, ["rocker.theta"], "A", 0.0, 1.0, points=0)
        with self.assertRaisesRegex(fp.SceneError, "samples"):
            fp.play(scene, ["rocker.theta"], samples=10)
        with self.assertRaises(TypeError):
            fp.play(scene, ["rocker.theta"], "A")
        with self.assertRaises(TypeError):
            fp.play(scene, ["rocker.theta"], target=1e-3)
        with self.assertRaises(ValueError):
            fp.play(scene, ["rocker.theta"], place="outside")
        stop = fp.Stop()
        stop.set()
        with self.assertRaises(fp.Interrupted):
            fp.play(scene, ["rocker.theta"], stop=stop)


if __name__ == "__main__":
    unittest.main()
