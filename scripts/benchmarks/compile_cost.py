"""Compile time and code size of compiled mechanisms against the number of bodies; some minutes.

    scripts/benchmark compile-cost [BODIES ...]

The mechanism is a chain of bars that falls from an angle of 30 degrees; its last pin has clearance. For each number of
bodies: CPU time of the whole compilation (trace, cc, check) and of the same with the object in the cache, which are
differences to a run that does not compile; bytes of machine code in the object; CPU time of a step of Moreau–Jean,
general and compiled, without assembly and compilation. The least of three.
"""
import json
import os
import subprocess
import tempfile
from pathlib import Path

from measure import ENVIRONMENT, Table, call, in_turn, program

STEP = 1e-4  # s


def chain(folder, bodies):
    """Writes the scene of a chain of bars of 0.1 m and 0.1 kg."""
    text = ["format = 2", "gravity = [0.0, -9.81]"]
    for k in range(bodies):
        x, y = 0.1 * 3**0.5 / 2, 0.1 * 0.5  # of a bar
        text += [f"[bodies.b{k}]", "mass = 0.1", "inertia = 1e-4", "angle = '30 deg'",
                 f"position = [{(k + 0.5) * x!r}, {(k + 0.5) * y!r}]"]
    for k in range(bodies):
        loose = "clearance = 1e-4\nbearing_radius = 1e-2\nsurface = 's'" if k == bodies - 1 and k > 0 else ""
        before, at = ("ground", "[0, 0]") if k == 0 else (f"b{k - 1}", "[0.05, 0]")
        text += [f"[joints.j{k}]", "type = 'revolute'", f"between = ['{before}', 'b{k}']", f"at = [{at}, [-0.05, 0]]",
                 loose]
    text += ["[surfaces.s]", "restitution = 0.5", "friction = 0.1",
             "[run]", "duration = 0.1", "output_step = 0.1", "start = 'given'", "[nonsmooth]", "scheme = 'moreau-jean'", f"step = {STEP}"]
    scene = Path(folder) / "chain.toml"
    scene.write_text("\n".join(text) + "\n")
    return scene


def code_bytes(folder):
    """Machine code in the objects of the cache."""
    total = 0
    for file in (Path(folder) / "freeplay").iterdir():
        total += int(subprocess.run(["size", file], capture_output=True, text=True, check=True).stdout.split()[6])
    return total


def main(*sizes):
    freeplay = program("freeplay")
    table = Table("bodies", "compilation (s)", "from the cache (s)", "code (kB)", "general step (µs)",
                  "compiled step (µs)", "general parts")
    for bodies in map(int, sizes or (1, 2, 3, 5, 10, 14, 20, 31, 50, 100)):
        with tempfile.TemporaryDirectory() as folder:
            scene, cache = chain(folder, bodies), Path(folder) / "cache"
            ENVIRONMENT["XDG_CACHE_HOME"] = str(cache)
            out = Path(folder) / "out"

            def one(*options, fresh=False):
                if fresh and cache.exists():
                    for file in (cache / "freeplay").iterdir():
                        os.remove(file)
                command = [freeplay, "run", scene, "--formulation", "nonsmooth", "--no-figures", "-o", out, *options]
                return call(command)[1], json.loads((out / "run.json").read_text())

            cold, warm, none = in_turn([lambda: one("--compile", fresh=True), lambda: one("--compile"),
                                        lambda: one("--no-compile")], 3)
            steps = [min(x["cost"]["cpu_s"] for x in (one(option)[1] for _ in range(2))) / (0.1 / STEP)
                     for option in ("--no-compile", "--compile")]
            made = warm[2]["cost"]["compiled"]
            table.row(bodies, f"{cold[0] - none[0]:.2f}", f"{warm[0] - none[0]:.3f}", f"{code_bytes(cache) / 1e3:.0f}",
                      *(f"{1e6 * s:.2f}" for s in steps),
                      "; ".join(made.get("general_parts", [])) or made.get("reason", "–"))
