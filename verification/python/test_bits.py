"""Python and the command give the same bits: 20 scenes, both formulations.

PYTHONPATH=BUILD/python FREEPLAY=BUILD/freeplay
python3 -m unittest discover verification/python"""

import json
import os
import subprocess
import tempfile
import unittest
import warnings
from pathlib import Path

import freeplay as fp
import pandas as pd

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("FREEPLAY", str(ROOT / "build/release/freeplay"))

#: Scene, and the keys that make it short.
SCENES = [
    ("cases/flores2011", {"run.revolutions": 0.5, "run.discard": 0.1}),
    ("cases/four-bar", {}),
    ("cases/bouncing-ball", {}),
    ("cases/pendulum", {}),
    ("cases/double-pendulum", {}),
    ("cases/ball-on-table", {}),
    ("cases/block-on-slope", {}),
    ("cases/bistable-rotor", {}),
    ("cases/cam-follower", {}),
    ("cases/drag-link", {}),
    ("cases/flores2010-translational", {}),
    ("cases/four-bar-friction", {}),
    ("cases/gear-rattle", {}),
    ("cases/lubricated-pin", {}),
    ("cases/motor-startup", {}),
    ("cases/newtons-cradle", {}),
    ("cases/press", {}),
    ("cases/scotch-yoke", {}),
    ("cases/seven-body", {}),
    ("cases/six-bar", {}),
]
DURATION = 0.02  # s, of those without keys of their own


class Bits(unittest.TestCase):
    maxDiff = 2000

    def test_same_bits(self):
        compared = 0
        for name, keys in SCENES:
            file = ROOT / name / "scene.toml"
            for formulation in ("penalty", "nonsmooth"):
                test = self.subTest(scene=name, formulation=formulation)
                with test, tempfile.TemporaryDirectory() as folder:
                    wanted = self.keys(file, keys)
                    said = subprocess.run(
                        [PROGRAM, "run", str(file), "--formulation", formulation, "-o", folder]
                        + [f"--set={k}={str(v).lower()}" for k, v in wanted.items()],
                        capture_output=True,
                        text=True,
                    )
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")
                        try:
                            here = fp.run(fp.read_scene(file, wanted), formulation)
                        except fp.SceneError as error:
                            # both refuse, in the same words
                            self.assertEqual(said.returncode, 2, said.stderr)
                            self.assertEqual(said.stderr.strip(), str(error))
                            continue
                    self.assertEqual(here.status == "finished", said.returncode == 0, said.stderr)
                    there = fp.read_run(folder)
                    for table in ("trajectory", "events", "forces", "signals"):
                        a, b = getattr(here, table), getattr(there, table)
                        if b is None:
                            self.assertIsNone(a)
                        else:
                            pd.testing.assert_frame_equal(
                                a, b, check_exact=True, check_dtype=False, check_index_type=False
                            )
                    for info in (one := json.loads(json.dumps(here.info)), two := there.info):
                        del info["cost"]  # times and memory
                        del info["provenance"]["commit"]  # for people: the identity has the sources
                    self.assertEqual(one, two)
                    compared += 1
        print(f"\n{compared} runs compared, bit for bit")
        self.assertGreaterEqual(compared, 35)

    def keys(self, file, keys):
        if keys:
            return {**keys, "run.forces": True}
        scene = fp.read_scene(file)
        run = scene.to_dict().get("run", {})
        if "revolutions" not in run:
            return {"run.duration": DURATION, "run.discard": 0, "run.forces": True}
        share = DURATION / fp.check(scene)["duration_s"]
        return {"run.revolutions": run["revolutions"] * min(1.0, share), "run.discard": 0, "run.forces": True}


if __name__ == "__main__":
    unittest.main()
