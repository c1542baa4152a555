"""How the package behaves: mistakes, Ctrl-C, observers, threads, forks, studies."""

import multiprocessing
import os
import signal
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
import unittest
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import freeplay as fp
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
FLORES = ROOT / "cases/flores2011/scene.toml"

PENDULUM = {
    "gravity": [0.0, -9.81],
    "bodies": {"arm": {"mass": 1.2, "inertia": 0.03, "position": [0.25, 0.0]}},
    "joints": {
        "pivot": {
            "type": "revolute",
            "between": ["ground", "arm"],
            "at": [[0.0, 0.0], [-0.25, 0.0]],
            "clearance": np.float64(0.5e-3),
            "bearing_radius": "10 mm",
            "surface": "steel",
        }
    },
    "surfaces": {"steel": {"young": 207e9, "poisson": 0.3, "restitution": 0.8, "friction": 0.05}},
    "run": {"duration": 0.1},
}


def short(turns=0.5):
    return fp.read_scene(FLORES, {"run.revolutions": turns, "run.discard": 0.1})


class Mistakes(unittest.TestCase):
    def refused(self, error, act, *parts):
        with self.assertRaises(error) as caught:
            act()
        for part in parts:
            self.assertIn(part, str(caught.exception))
        return caught.exception

    def test_an_unknown_key_has_its_place(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "scene.toml"
            file.write_text(FLORES.read_text().replace("bearing_radius", "bearing_radios"))
            error = self.refused(fp.SceneError, lambda: fp.read_scene(file), "bearing_radios")
        self.assertEqual(error.file, str(file))
        self.assertEqual(error.line, 1 + FLORES.read_text().split("bearing_radius")[0].count("\n"))
        self.assertTrue(error.key.startswith("joints."), error.key)

    def test_a_negative_mass(self):
        scene = short()
        before = scene.canonical()
        error = self.refused(fp.SceneError, lambda: scene.set({"bodies.rod.mass": -1}), "bodies.rod.mass")
        self.assertIn("bodies.rod.mass", error.key or str(error))
        self.assertEqual(scene.canonical(), before)  # as it was

    def test_a_wrong_type(self):
        self.refused(fp.SceneError, lambda: short().set({"bodies.rod.mass": [1, 2]}), "bodies.rod.mass")

    def test_what_toml_cannot_hold(self):
        self.refused(TypeError, lambda: short().set({"bodies.rod.mass": object()}), "object")

    def test_a_key_that_is_misspelt_when_set(self):
        self.refused(fp.SceneError, lambda: short().set({"joints.gudgeon.clearence": 1e-3}), "clearence")

    def test_a_key_that_is_misspelt_when_read(self):
        self.refused(
            KeyError, lambda: short()["joints.gudgeon.clearence"], "did you mean joints.gudgeon.clearance"
        )

    def test_a_formulation_that_there_is_not(self):
        self.refused(ValueError, lambda: fp.run(short(), "penality"), "'penalty' or 'nonsmooth'")

    def test_a_file_that_is_not_there(self):
        self.refused(fp.SceneError, lambda: fp.read_scene("nowhere.toml"), "nowhere.toml")

    def test_a_mapping_without_a_body(self):
        pivot = {**PENDULUM["joints"]["pivot"], "between": ["ground", "leg"]}
        wrong = {**PENDULUM, "joints": {"pivot": pivot}}
        error = self.refused(fp.SceneError, lambda: fp.Scene(wrong), "leg")
        self.assertEqual(error.key, "joints.pivot.between")
        self.assertIsNone(error.line)  # of a text that nobody wrote

    def test_what_a_formulation_needs(self):
        scene = fp.Scene(PENDULUM)
        del scene["surfaces.steel.restitution"]
        self.refused(fp.SceneError, lambda: fp.run(scene, "nonsmooth"), "surfaces.steel.restitution")

    def test_a_folder_without_a_run(self):
        self.refused(FileNotFoundError, lambda: fp.read_run(ROOT), "run.json")

    def test_a_signal_that_there_is_not(self):
        run = fp.run(short(), "nonsmooth")
        self.refused(KeyError, lambda: run.signal("accelerometre"), "there are")


class Scenes(unittest.TestCase):
    def test_mappings_go_both_ways(self):
        scene = fp.Scene(PENDULUM)
        self.assertEqual(scene["joints.pivot.clearance"], 0.5e-3)
        self.assertEqual(scene["joints"]["pivot"]["clearance"], 0.5e-3)
        scene["joints"]["pivot"]["clearance"] = 1e-3
        self.assertEqual(scene["joints.pivot.clearance"], 1e-3)
        self.assertEqual(list(scene["bodies"]), ["arm"])
        self.assertIn("integrator", fp.Scene(PENDULUM).canonical())
        self.assertIsInstance(scene["penalty.integrator"], str)  # in force, not stated
        self.assertEqual(fp.Scene(scene.to_dict()).canonical(), scene.canonical())
        scene["surfaces.steel"] = {"young": 70e9, "poisson": 0.3, "restitution": 0.5}
        self.assertNotIn("friction", scene["surfaces.steel"])

    def test_check(self):
        found = fp.check(PENDULUM)
        self.assertEqual((found["bodies"], found["contacts"], found["degrees_of_freedom"]), (1, 1, 3))


class Running(unittest.TestCase):
    def test_no_copies(self):
        run = fp.run(short(), "nonsmooth")
        frame = run.trajectory.to_numpy()
        self.assertTrue(np.shares_memory(frame, run._record.trajectory()[1]))

    def test_observers(self):
        events, rows = [], []
        run = fp.run(short(), "nonsmooth", on_event=events.append, on_row=rows.append)
        self.assertEqual([e["t"] for e in events], list(run.events["t"]))
        self.assertEqual([list(r.values()) for r in rows], run.trajectory.to_numpy().tolist())

    def test_an_observer_ends_a_run(self):
        run = fp.run(short(), "nonsmooth", on_row=lambda row: row["t"] > 0.01)
        self.assertEqual(run.status, "interrupted")
        self.assertLess(run.info["ending"]["t_s"], 0.02)

    def test_what_an_observer_raises_comes_out(self):
        def raises(event):
            raise ZeroDivisionError(event["joint"])

        with self.assertRaisesRegex(ZeroDivisionError, "gudgeon"):
            fp.run(short(), "nonsmooth", on_event=raises)

    def test_a_law_of_pythons(self):
        def soft(contact, penetration, rate, touch_speed):
            assert contact == "gudgeon" and penetration > 0 and touch_speed > 0
            return 1e7 * penetration * (1 + 0.4 * rate / touch_speed)

        keys = {"run.revolutions": 0.1, "run.discard": 0}
        built_in = fp.run(FLORES, "penalty", set=keys)
        run = fp.run(FLORES, "penalty", set=keys, law=soft)
        self.assertEqual(run.status, "finished")
        self.assertIn("soft", run.info["notes"][0])
        depth = [r.info["contacts"]["gudgeon"]["greatest_penetration_m"] for r in (built_in, run)]
        self.assertGreater(depth[1], 3 * depth[0])  # of Hertz's 7 µm, 5 mJ: √(2E/k) is 31 µm
        again = fp.run(FLORES, "penalty", set=keys, law=soft)
        self.assertTrue(run.trajectory.equals(again.trajectory))

        def broken(contact, penetration, rate, touch_speed):
            raise ZeroDivisionError(contact)

        with self.assertRaisesRegex(ZeroDivisionError, "gudgeon"):
            fp.run(FLORES, "penalty", set=keys, law=broken)
        with self.assertRaisesRegex(ValueError, "no normal force"):
            fp.run(FLORES, "nonsmooth", set=keys, law=soft)

    def test_a_force_of_pythons(self):
        scene = fp.Scene(
            {
                "bodies": {"block": {"mass": 2.0, "inertia": 0.1}},
                "loads": {"hand": {"type": "force", "body": "block", "force": [0.0, 0.0]}},
                "run": {"duration": 1.5, "start": "given"},
            }
        )

        def spring(t, place, velocity):
            return np.array([3 - 40 * place[0] - 1.5 * velocity[0], 0])

        decay, w = 1.5 / 4, np.sqrt(20 - (1.5 / 4) ** 2)
        expected = 3 / 40 * (1 - np.exp(-decay * 1.5) * (np.cos(w * 1.5) + decay / w * np.sin(w * 1.5)))
        for formulation in ("penalty", "nonsmooth"):
            run = fp.run(scene, formulation, loads={"hand": spring})
            self.assertAlmostEqual(run.trajectory["block.x"].iloc[-1], expected, delta=1e-5)
            self.assertIn("hand", run.info["notes"][-1])
        with self.assertRaisesRegex(fp.SceneError, "such loads are hand"):
            fp.run(scene, "penalty", loads={"foot": spring})
        with self.assertRaisesRegex(TypeError, "two numbers"):
            fp.run(scene, "penalty", loads={"hand": lambda t, place, velocity: 1.0})

    def test_ctrl_c(self):
        program = textwrap.dedent(f"""
            import freeplay as fp
            scene = fp.read_scene({str(FLORES)!r}, {{"run.revolutions": 4000}})
            print("begun", flush=True)
            try:
                fp.run(scene, "nonsmooth")
            except fp.Interrupted as stopped:
                run = stopped.result
                assert run.status == "interrupted" and len(run.trajectory) > 1 and run.info["energy_J"]
                print("whole to", run.info["ending"]["t_s"], flush=True)
            try:
                import time; time.sleep(60)
            except KeyboardInterrupt:
                print("python's own again")
            """)
        child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
        self.assertEqual(child.stdout.readline(), "begun\n")
        time.sleep(2)
        child.send_signal(signal.SIGINT)
        asked = time.monotonic()
        line = child.stdout.readline()
        taken = time.monotonic() - asked
        self.assertIn("whole to", line)
        time.sleep(0.5)
        child.send_signal(signal.SIGINT)
        self.assertIn("python's own again", child.communicate(timeout=60)[0])
        print(f"\nCtrl-C answered after {taken:.3f} s")
        self.assertLess(taken, 5)

    def test_threads_run_beside_each_other_and_give_the_same_bits(self):
        scene = short()
        alone = fp.run(scene, "nonsmooth")
        with ThreadPoolExecutor(4) as pool:
            together = list(pool.map(lambda _: fp.run(scene, "nonsmooth"), range(4)))
        for run in together:
            self.assertTrue(alone.trajectory.equals(run.trajectory))

    def test_the_lock_is_released(self):
        counted, done = 0, threading.Event()
        thread = threading.Thread(target=lambda: (fp.run(short(4), "nonsmooth"), done.set()))
        thread.start()
        while not done.is_set():
            counted += 1
            time.sleep(0.001)
        thread.join()
        self.assertGreater(counted, 5)

    def test_a_stop_from_another_thread(self):
        stop = fp.Stop()
        threading.Timer(1.0, stop.set).start()
        run = fp.run(fp.read_scene(FLORES, {"run.revolutions": 4000}), "nonsmooth", stop=stop)
        self.assertEqual(run.status, "interrupted")

    def test_a_fork_with_runs_under_way_is_refused(self):
        stop = fp.Stop()
        started = threading.Event()
        scene = fp.read_scene(FLORES, {"run.revolutions": 4000})
        thread = threading.Thread(
            target=lambda: fp.run(scene, "nonsmooth", stop=stop, on_row=lambda row: started.set())
        )
        thread.start()
        started.wait()
        queue = multiprocessing.get_context("fork").SimpleQueue()

        def child():
            try:
                fp.run(PENDULUM, "penalty")
                queue.put("ran")
            except RuntimeError as error:
                queue.put(str(error))

        process = multiprocessing.get_context("fork").Process(target=child)
        process.start()
        said = queue.get()
        process.join()
        stop.set()
        thread.join()
        self.assertIn("spawn", said)

    def test_snapshots(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "here.snapshot"
            simulation = fp.Simulation(PENDULUM, "nonsmooth")
            simulation.run(0.05)
            simulation.snapshot(file)
            simulation.run()
            first = simulation.q
            simulation.restore(file)
            simulation.run()
            np.testing.assert_array_equal(first, simulation.q)
            with self.assertRaises(fp.SnapshotError):
                fp.Simulation(PENDULUM, "penalty").restore(file)

    def test_overhead(self):
        """Of a call, over the command's own wall_s, for a run that takes next to no steps."""
        scene = fp.Scene({**PENDULUM, "run": {"duration": 1e-3, "output_step": 1e-4}})
        least = np.inf
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for _ in range(50):
                begin = time.perf_counter()
                run = fp.run(scene, "penalty")
                taken = time.perf_counter() - begin
                least = min(least, taken - run.info["cost"]["wall_s"])
        print(f"\noverhead of a run {1e3 * least:.3f} ms, compiling the scene included")
        self.assertLess(least, 1e-3)


class Studies(unittest.TestCase):
    def test_sensitivity(self):
        ball = {
            "gravity": [0.0, -9.81],
            "bodies": {"ball": {"mass": 0.3, "inertia": 3e-4, "position": [0.0, 0.55]}},
            "contacts": {
                "table": {"type": "plane", "between": ["ground", "ball"], "radius": 0.05, "surface": "hard"}
            },
            "surfaces": {"hard": {"restitution": 0.5}},
            "run": {"duration": 0.4, "start": "given"},
            "nonsmooth": {"scheme": "event-driven"},
        }
        keys = ["initial.ball.y", "surfaces.hard.restitution"]
        found = fp.sensitivity(ball, ["event.1.t", "event.1.v_n_minus"], keys)
        # t = sqrt(2 h/g), u = -sqrt(2 g h)
        g, h = 9.81, 0.5
        t, u = (2 * h / g) ** 0.5, -((2 * g * h) ** 0.5)
        self.assertAlmostEqual(found.values["event.1.t"], t, delta=1e-9)
        self.assertAlmostEqual(found.jacobian.loc["event.1.t", "initial.ball.y"], 1 / (g * t), delta=1e-8)
        self.assertAlmostEqual(found.jacobian.loc["event.1.v_n_minus", "initial.ball.y"], g / u, delta=1e-8)
        self.assertEqual(found.jacobian.loc["event.1.t", "surfaces.hard.restitution"], 0)
        self.assertAlmostEqual(found.influence.loc["event.1.t", "initial.ball.y"], 0.55 / (2 * h), delta=1e-8)
        with self.assertRaises(fp.SceneError):
            fp.sensitivity(ball, ["event.0.t"], ["bodies.ball.mass"])

    def test_compare(self):
        with tempfile.TemporaryDirectory() as folder:
            kept = fp.compare(short(), output=folder)
            self.assertTrue((Path(folder) / "comparison.json").exists())
        found = fp.compare(short())
        self.assertEqual(found.penalty.info["formulation"], "penalty")
        self.assertIn("|", found.table)
        self.assertGreater(len(found.nonsmooth.trajectory), 10)
        del kept

    def test_sweep_in_processes_goes_on(self):
        with tempfile.TemporaryDirectory() as folder:
            study = Path(folder) / "study.toml"
            (Path(folder) / "scene.toml").write_text(fp.Scene(PENDULUM).to_toml())
            study.write_text(
                'scene = "scene.toml"\nduration = 0.05\nstarts = 1\n'
                '[variants.all]\nformulations = ["nonsmooth"]\n'
                '[axes.clearance]\nkey = "joints.pivot.clearance"\nvalues = [2e-4, 5e-4, 1e-3]\n'
            )
            found = fp.sweep(study, output=Path(folder) / "out", processes=2)
            self.assertEqual(len(found.runs), 3)
            self.assertEqual(sorted(found.runs["clearance"]), [2e-4, 5e-4, 1e-3])
            again = fp.sweep(study, output=Path(folder) / "out", processes=2)
            self.assertEqual((again.info["found"], again.info["ran"]), (3, 0))


if __name__ == "__main__":
    unittest.main()
