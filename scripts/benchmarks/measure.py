"""Shared functions of the benchmarks: programs, interleaved runs, instruction counts, tables."""
import json
import os
import re
import resource
import statistics
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RIG = ROOT / "cases/flores2011/scene.toml"
ENVIRONMENT = dict(os.environ, LC_ALL="C", OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")
LENGTH = object()  # placeholder for the length of the run in a command of instructions_each
built = ROOT / "build/release"  # scripts/benchmark --built FOLDER sets another


def program(name):
    """The path of a program of this build. The default build is updated first."""
    if built == ROOT / "build/release":
        subprocess.run([ROOT / "scripts/build", "release", name], check=True, stdout=subprocess.DEVNULL)
    return str(built / name)


def call(command):
    """Output of a command, and its CPU time (s)."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([str(x) for x in command], check=True, capture_output=True, text=True, env=ENVIRONMENT)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def run(freeplay, scene, folder, formulation="nonsmooth", *options, **settings):
    """Calls `freeplay run` with options, settings such as run__duration=1 and results in `folder`;
    returns run.json."""
    sets = [x for key, value in settings.items() for x in ("--set", f"{key.replace('__', '.')}={value}")]
    call([freeplay, "run", scene, "--formulation", formulation, "--no-figures", "-o", folder, *options, *sets])
    return json.loads((Path(folder) / "run.json").read_text())


def rig(folder, duration):
    """Writes a scene of the paper's rig with a duration in s and without discarded time to
    `folder`."""
    text = RIG.read_text().replace("revolutions = 12 ", f"duration = {duration} ", 1)
    scene = Path(folder) / "rig.toml"
    scene.write_text(text.replace("discard = 2 ", "discard = 0 ", 1))
    return scene


def in_turn(measures, rounds):
    """Runs all measurements once per round, one after the other. Returns for each the least and the
    median of its first value, and the other values of its last round."""
    found = [[measure() for measure in measures] for _ in range(rounds)]
    return [(min(x[0] for x in one), statistics.median(x[0] for x in one), *one[-1][1:]) for one in zip(*found)]


def instructions(command):
    """Instructions of a command, counted by callgrind, and its output. Needs Debian's package
    valgrind."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out", *map(str, command)],
                              check=True, capture_output=True, text=True, env=ENVIRONMENT)
    return int(re.search(r"Collected : (\d+)", done.stderr)[1]), done.stdout


def instructions_each(command, short, long, column=0):
    """Instructions per unit, from the difference of two runs, which excludes the set-up. The
    programs print the number of units."""
    (i, a), (j, b) = (instructions([length if x is LENGTH else x for x in command]) for length in (short, long))
    return (j - i) / (int(b.split()[column]) - int(a.split()[column]))


def siconos(folder, name):
    """Compiles verification/timing/NAME.cpp with Debian's libsiconos-mechanics-dev; None if that is
    not installed."""
    headers = [f"-I{p}" for p in Path("/usr/include/siconos").glob("**/") if p.is_dir()]
    if not headers:
        print("Siconos is not installed: left out")
        return None
    peer = Path(folder) / name
    call(["g++", "-O2", "-std=c++17", "-w", f"-I{ROOT}", *headers, ROOT / f"verification/timing/{name}.cpp", "-o", peer,
          "-lsiconos_mechanics", "-lsiconos_kernel", "-lsiconos_numerics", "-lsiconos_externals"])
    return peer


class Table:
    """A Markdown table. Each row is printed immediately."""

    def __init__(self, *columns):
        self.row(*columns)
        self.row(*["---"] * len(columns))

    def row(self, *values):
        print("| " + " | ".join(str(v) for v in values) + " |", flush=True)
