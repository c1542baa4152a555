"""`freeplay export` read back by other programs: HDF5 by h5py, bit for bit the tables' numbers; VTK
by Python's XML parser, and by VTK itself where it is installed. FREEPLAY=BUILD/freeplay python3 -m
unittest discover verification/python"""

import json
import os
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree as xml
from pathlib import Path

import h5py
import numpy as np
import pandas as pd

try:
    import vtk
except ImportError:
    vtk = None

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("FREEPLAY", str(ROOT / "build/release/freeplay"))
SCENE = str(ROOT / "cases/flores2011/scene.toml")
SHORT = ["--set=run.revolutions=0.5", "--set=run.discard=0.1"]
TABLES = ("trajectory", "forces", "events", "signals")


def call(*words, status=0):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True)
    if done.returncode != status:
        raise AssertionError(f"{words}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done


class Export(unittest.TestCase):
    def setUp(self):
        keeper = tempfile.TemporaryDirectory()
        self.addCleanup(keeper.cleanup)
        self.place = Path(keeper.name)

    def run_there(self, formulation="nonsmooth", *more):
        options = ["--formulation", formulation, "--forces", "--no-figures", *more]
        call("run", SCENE, *SHORT, *options, "-o", self.place / "run")
        return self.place / "run"

    def same_table(self, file, group):
        names = pd.read_csv(file, nrows=0).columns
        # A column of 0 and -0 is none of integers.
        kinds = {name: str if name in ("joint", "kind", "channel") else float for name in names}
        frame = pd.read_csv(file, float_precision="round_trip", dtype=kinds)
        self.assertEqual(list(group.attrs["columns"]), list(frame.columns))
        self.assertEqual(group.attrs["rows"], len(frame))
        for name in frame.columns:
            column = group[name]
            self.assertEqual(len(column), len(frame))
            if column.dtype.kind == "S":
                self.assertEqual(list(column.asstr()[:]), list(frame[name]))
                continue
            wanted = frame[name].to_numpy(float)
            self.assertTrue(np.array_equal(column[:].view("u8"), wanted.view("u8")), f"{file}: {name}")
            self.assertIn("units", column.attrs)
        return frame

    def mirrored(self, group, document):
        for key, value in document.items():
            if isinstance(value, dict):
                self.mirrored(group[key], value)
                continue
            found = group.attrs[key]
            if isinstance(value, list):
                found = json.loads(found) if isinstance(found, str) else list(found)
            self.assertEqual(found, value, key)
        self.assertEqual(set(group.attrs) | set(group), set(document))

    def test_every_number_of_a_run(self):
        for formulation in ("penalty", "nonsmooth"):
            with self.subTest(formulation=formulation):
                run = self.run_there(formulation)
                call("export", run, "--hdf5")
                text = (run / "run.json").read_text(encoding="utf-8")
                with h5py.File(run / "results.h5") as file:
                    for name in TABLES:
                        self.same_table(run / f"{name}.csv", file[name])
                    for column, unit in {"slider.x": "m", "crank.omega": "rad/s"}.items():
                        self.assertEqual(file["trajectory"][column].attrs["units"], unit)
                    self.assertEqual(file["forces/gudgeon.fx_mean"].attrs["units"], "N")
                    self.assertEqual(file["events/impulse_n"].attrs["units"], "N s")
                    self.assertEqual(list(file["signals"].attrs["channel_units"]), ["m/s²"])
                    self.assertEqual(file.attrs["run.json"], text)
                    self.mirrored(file["run"], json.loads(text))
                    contacts = json.loads(text)["contacts"]
                    self.assertEqual(list(file["statistics/contact"].asstr()[:]), list(contacts))
                    for at, facts in enumerate(contacts.values()):
                        for key, value in facts.items():
                            if not isinstance(value, dict):
                                self.assertEqual(file["statistics"][key][at], value)
                    self.assertEqual(file["statistics/median_impulse_N_s"].attrs["units"], "N s")

    def test_blocks_that_end_within_the_table(self):
        run = self.place / "run"
        run.mkdir()
        random = np.random.default_rng(25)
        for rows in (0, 1, 16383, 16384, 16385, 40000):
            numbers = random.integers(0, 2**63, (rows, 2), dtype=np.uint64).view(float)
            numbers[~np.isfinite(numbers)] = 0.5
            names = [["pin", "a long name", "b"][i % 3] for i in range(rows)]
            lines = [f"{a!r},{name},{b!r}" for (a, b), name in zip(numbers.tolist(), names)]
            (run / "wide.csv").write_text("\n".join(["a,joint,b"] + lines) + "\n", encoding="utf-8")
            call("export", run, "--hdf5", self.place / "a.h5")
            with h5py.File(self.place / "a.h5") as file:
                self.same_table(run / "wide.csv", file["wide"])

    def test_a_comparison(self):
        place = self.place / "both"
        call("compare", SCENE, *SHORT, "-o", place)
        call("export", place, "--hdf5", self.place / "both.h5")
        with h5py.File(self.place / "both.h5") as file:
            for run in ("penalty", "nonsmooth"):
                self.same_table(place / run / "trajectory.csv", file[run]["trajectory"])
                self.same_table(place / run / "events.csv", file[run]["events"])
            comparison = (place / "comparison.json").read_text(encoding="utf-8")
            self.assertEqual(file.attrs["comparison.json"], comparison)
        said = call("export", place, "--vtk", status=2).stderr
        self.assertIn("penalty or nonsmooth", said)

    def test_a_damaged_table_leaves_what_was_there(self):
        run = self.run_there()
        call("export", run, "--hdf5")
        before = (run / "results.h5").read_bytes()
        lines = (run / "trajectory.csv").read_text(encoding="utf-8").splitlines()
        lines[700] = lines[700].replace(",", ",x", 1)
        (run / "trajectory.csv").write_text("\n".join(lines), encoding="utf-8")
        said = call("export", run, "--hdf5", status=2).stderr
        self.assertIn("trajectory.csv:701: field 2", said)
        self.assertEqual((run / "results.h5").read_bytes(), before)
        self.assertEqual(list(run.glob("*.partial")), [])

    def test_frames(self):
        run = self.run_there()
        call("export", run, "--vtk", self.place / "frames", "--every", 50)
        frame = pd.read_csv(run / "trajectory.csv", float_precision="round_trip").iloc[::50].reset_index()
        series = xml.parse(self.place / "frames/mechanism.pvd").getroot().findall("Collection/DataSet")
        self.assertEqual([float(one.get("timestep")) for one in series], list(frame["t"]))
        self.assertEqual(len(list((self.place / "frames").glob("*.vtp"))), len(series))
        for at in (0, len(series) // 2, len(series) - 1):
            root = xml.parse(self.place / "frames" / series[at].get("file")).getroot()
            tags = ("Array", "DataArray")
            arrays = {a.get("Name"): a for a in root.iter() if a.tag in tags and a.get("Name")}
            self.assertEqual(float(arrays["TimeValue"].text), frame["t"][at])
            words = {
                key: bytes(map(int, arrays[key].text.split())).decode().split("\0")[:-1]
                for key in ("shapes", "names")
            }
            points = np.array(root.find(".//Points/DataArray").text.split(), float).reshape(-1, 3)
            verts = list(map(int, root.find(".//Verts/DataArray[@Name='connectivity']").text.split()))
            shape, name = (list(map(int, arrays[key].text.split())) for key in ("shape", "name"))
            masses = {
                words["names"][name[i]]: points[verts[i]]
                for i in range(len(verts))
                if words["shapes"][shape[i]] == "mass"
            }
            self.assertEqual(set(masses), {"crank", "rod", "slider"})
            for body, place in masses.items():
                self.assertEqual(list(place), [frame[f"{body}.x"][at], frame[f"{body}.y"][at], 0])
            if vtk:
                self.read_by_vtk(self.place / "frames" / series[at].get("file"), points, len(name))

    def read_by_vtk(self, file, points, cells):
        reader = vtk.vtkXMLPolyDataReader()
        reader.SetFileName(str(file))
        reader.Update()
        found = reader.GetOutput()
        self.assertEqual(reader.GetErrorCode(), 0)
        self.assertEqual(found.GetNumberOfCells(), cells)
        corners = [found.GetPoint(i) for i in range(found.GetNumberOfPoints())]
        self.assertEqual(corners, [tuple(p) for p in points])
        self.assertEqual(found.GetFieldData().GetAbstractArray("shapes").GetValue(0), "link")


if __name__ == "__main__":
    unittest.main()
