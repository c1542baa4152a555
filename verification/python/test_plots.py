"""Figures by matplotlib show the numbers that the commands' tables hold."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import freeplay as fp
import matplotlib
import numpy as np
import pandas as pd
from freeplay import plots

matplotlib.use("Agg")
ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("FREEPLAY", str(ROOT / "build/release/freeplay"))
FLORES = ROOT / "cases/flores2011/scene.toml"
SHORT = {"run.revolutions": 0.5, "run.discard": 0.1}


class Plots(unittest.TestCase):
    def made(self, *words):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        place = Path(folder.name) / "out"
        command = [PROGRAM, *map(str, words), "-o", str(place)]
        done = subprocess.run(command, cwd=folder.name, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return place

    def test_forces(self):
        run = fp.run(FLORES, "nonsmooth", set=SHORT, forces=True)
        axes = plots.forces(run, "main")
        size = np.hypot(run.forces["main.fx"], run.forces["main.fy"])
        self.assertTrue(np.array_equal(axes.lines[0].get_ydata(), size))
        axes = plots.load_diagram(run, "main")
        self.assertTrue(np.array_equal(axes.lines[0].get_xdata(), run.forces["main.fx"]))
        with self.assertRaisesRegex(KeyError, "there are: .*main"):
            plots.forces(run, "mane")
        with self.assertRaisesRegex(ValueError, "forces=True"):
            plots.forces(fp.run(FLORES, "nonsmooth", set=SHORT), "main")

    def test_impacts(self):
        found = fp.compare(FLORES, set=SHORT)
        axes = plots.impacts(found)
        first = found.nonsmooth.events[found.nonsmooth.events["kind"] == "impact"].iloc[0]
        self.assertAlmostEqual(axes.lines[1].get_xdata()[0], first["t"], delta=1e-12)
        self.assertAlmostEqual(axes.lines[1].get_ydata()[0], -first["v_n_minus"], delta=1e-9)

    def test_poincare(self):
        columns = ["--x", "gudgeon.ex", "--y", "gudgeon.ey"]
        place = self.made("poincare", FLORES, *columns, "--periods", 5, "--discard", 1)
        axes = plots.poincare(place)
        points = pd.read_csv(place / "section.csv")
        self.assertEqual(len(points), len(axes.lines[0].get_xdata()))
        self.assertTrue(np.array_equal(axes.lines[0].get_ydata(), points["gudgeon.ey"]))
        self.assertEqual(axes.get_xlabel(), "gudgeon.ex, m")
        with self.assertRaisesRegex(FileNotFoundError, "section.json.*poincare"):
            plots.poincare(place / "no")

    def study(self, changes):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        study = Path(folder.name) / "study.toml"
        (Path(folder.name) / "scene.toml").write_text((ROOT / "cases/bistable-rotor/scene.toml").read_text())
        study.write_text((ROOT / "cases/bistable-rotor/study.toml").read_text())
        for old, new in changes.items():
            self.assertIn(old, study.read_text())
            study.write_text(study.read_text().replace(old, new))
        return study

    def test_basin(self):
        place = self.made("basin", self.study({", 39]": ", 3]", ", 40]": ", 4]"}))
        axes = plots.basin(place)
        cells = pd.read_csv(place / "basin.csv")
        shown = axes.collections[0].get_array()
        self.assertEqual(shown.count(), (cells["attractor"] >= 0).sum())
        self.assertEqual(int(shown.sum()), cells.loc[cells["attractor"] >= 0, "attractor"].sum())

    def test_bifurcation(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        study = Path(folder.name) / "study.toml"
        (Path(folder.name) / "scene.toml").write_text(FLORES.read_text())
        study.write_text(
            'scene = "scene.toml"\n'
            '[axes.clearance]\nkey = "joints.gudgeon.clearance"\nvalues = [2e-4, 4e-4]\n'
            '[bifurcation]\ndirection = "both"\nset = ["nonsmooth.step=1e-4"]\ndiscard = 2\nkeep = 3\n'
        )
        place = self.made("bifurcation", study)
        axes = plots.bifurcation(place)
        points = pd.read_csv(place / "bifurcation.csv")
        self.assertEqual(sum(len(line.get_xdata()) for line in axes.lines), len(points))
        entries = [text.get_text() for text in axes.get_legend().get_texts()]
        self.assertEqual(entries, ["swept downwards", "swept upwards"])

    def test_ensemble(self):
        short = ["--set", "run.revolutions=0.2", "--set", "run.discard=0"]
        place = self.made("ensemble", FLORES, "--starts", 4, *short)
        bands = pd.read_csv(place / "bands.csv")
        column = bands["column"].iloc[0]
        axes = plots.ensemble(place, column)
        median = bands.loc[bands["column"] == column, "q50"]
        self.assertTrue(np.array_equal(axes.lines[0].get_ydata(), median))
        with self.assertRaisesRegex(KeyError, "there are: " + column):
            plots.ensemble(place, "nothing")

    def test_a_study(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        (Path(folder.name) / "scene.toml").write_text(FLORES.read_text())
        study = Path(folder.name) / "study.toml"
        study.write_text(
            'scene = "scene.toml"\nrevolutions = 1\ndiscard = 0\nstarts = 2\n'
            '[variants.all]\nformulations = ["nonsmooth"]\n'
            '[axes.clearance]\nkey = "joints.gudgeon.clearance"\nvalues = [2e-4, 4e-4]\n'
            '[measure.last]\ncolumn = "slider.vx"\nreduce = "last"\n'
        )
        found = fp.sweep(study, output=Path(folder.name) / "out", processes=1)
        axes = plots.over(found, "last", "clearance")
        mean = found.runs.groupby("clearance")["last"].mean()
        self.assertTrue(np.array_equal(axes.lines[0].get_ydata(), mean))
        with self.assertRaisesRegex(KeyError, "lost"):
            plots.over(found, "lost", "clearance")


if __name__ == "__main__":
    unittest.main()
