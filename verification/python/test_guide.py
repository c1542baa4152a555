"""Every chapter of docs/tutorials/python.md is run, as a script of its own in an empty folder
beside the cases."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import pandas as pd

ROOT = Path(__file__).resolve().parents[2]
GUIDE = (ROOT / "docs/tutorials/python.md").read_text(encoding="utf-8")


def chapters(language):
    for chapter in re.split(r"^## ", GUIDE, flags=re.MULTILINE)[1:]:
        name = chapter.partition("\n")[0]
        blocks = re.findall(rf"^```{language}\n(.*?)^```", chapter, flags=re.MULTILINE | re.DOTALL)
        if blocks:
            yield name, "".join(blocks)


class Guide(unittest.TestCase):
    def run_there(self, command, folder):
        environment = {**os.environ, "MPLBACKEND": "Agg"}
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300
        )
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_chapters(self):
        count = 0
        for name, script in chapters("python"):
            with self.subTest(chapter=name), tempfile.TemporaryDirectory() as folder:
                (Path(folder) / "cases").symlink_to(ROOT / "cases")
                self.run_there([sys.executable, "-c", script], folder)
                for figure in re.findall(r'savefig\("(.*?)"\)', script):
                    self.assertGreater((Path(folder) / figure).stat().st_size, 5000)
                count += 1
        self.assertGreaterEqual(count, 8)

    def test_octave_reads_the_same_bits(self):
        octave = shutil.which("octave-cli") or shutil.which("octave")
        if octave is None:
            self.skipTest("octave is not installed")
        (script,) = [block for _, block in chapters("octave")]
        (run,) = [block for name, block in chapters("python") if name == "Without Freeplay"]
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "cases").symlink_to(ROOT / "cases")
            self.run_there([sys.executable, "-c", run], folder)
            said = self.run_there([octave, "--norc", "--quiet", "--eval", script], folder)
            frame = pd.read_csv(Path(folder) / "out/trajectory.csv", float_precision="round_trip")
            self.assertEqual(float(said), frame["slider.x"].max())


if __name__ == "__main__":
    unittest.main()
