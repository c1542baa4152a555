"""How soon each verb ends on Ctrl-C, for docs/verification/performance.md.

    interrupts [SIGNALS [VERB...]]       default: 20 signals per command

Sends SIGINT at random instants of a run of each command and reports the median and worst time until
the process ends. Fails if a JSON file is incomplete.
"""
import json
import os
import random
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from measure import RIG, ROOT, Table, program

STUDIES = {"validate": "flores2011-experiment/study", "sweep": "flores2011-experiment/study",
           "calibrate": "flores2011-experiment/calibrate", "tradeoff": "tradeoff/study",
           "bifurcation": "flores2011-attractors/friction", "basin": "bistable-rotor/study"}


def pile(side):
    """Scene (TOML) of a hexagonal pile of discs with about three contacts per disc."""
    r, text, at = 0.02, ["gravity = [0.0, -9.81]"], []
    for row in range(side):
        for column in range(side - row % 2):
            at.append((r + 2 * r * column + (r if row % 2 else 0), r + row * r * 3**0.5))
    mass = 50 * 3.14159265 * r * r

    def wall(name, i, x, axis):
        text.append(f'[contacts.{name}{i}]\ntype = "plane"\nbetween = ["ground", "d{i}"]\nat = [[{x}, 0.0], [0.0, 0.0]]\n'
                    f'axis = {axis}\nradius = {r}\nsurface = "s"')

    for i, (x, y) in enumerate(at):
        text.append(f"[bodies.d{i}]\nmass = {mass}\ninertia = {mass * r * r / 2}\nposition = [{x}, {y}]")
    for i, (x, y) in enumerate(at):
        if y < 2 * r:
            wall("floor", i, 0.0, "[1.0, 0.0]")
        if x < 1.6 * r:
            wall("left", i, 0.0, "[0.0, -1.0]")
        if x > 2 * r * side - 1.6 * r:
            wall("right", i, 2 * r * side, "[0.0, 1.0]")
        for j, (a, b) in enumerate(at[:i]):
            if (a - x) ** 2 + (b - y) ** 2 < (2.2 * r) ** 2:
                text.append(f'[contacts.c{j}_{i}]\ntype = "discs"\nbetween = ["d{j}", "d{i}"]\nradii = [{r}, {r}]\nsurface = "s"')
    text.append('[surfaces.s]\nrestitution = 0.3\nfriction = 0.3\n[run]\nduration = 0.1\nstart = "given"\n')
    return "\n".join(text)


def interrupt(command, span, environment):
    """Seconds from the signal to the end of the process, and its status; None if it ended
    earlier."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=ROOT,
                               env={**os.environ, **environment})
    time.sleep(random.uniform(0.1, span))
    if process.poll() is not None:
        return None
    asked = time.monotonic()
    process.send_signal(signal.SIGINT)
    try:
        process.wait(60)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    return time.monotonic() - asked, process.returncode


def runs(freeplay, place):
    """Name, longest wait before the signal (s), command and environment of each measurement."""
    def quiet(*command):
        subprocess.run([freeplay, *map(str, command)], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)

    def out(name):
        return ["-o", place / name]
    discs, four_bar = place / "discs.toml", place / "four-bar.toml"
    discs.write_text(pile(19))
    lazy = place / "bin"  # a gnuplot that hangs
    lazy.mkdir()
    (lazy / "gnuplot").write_text("#!/bin/sh\nexec sleep 1000\n")
    (lazy / "gnuplot").chmod(0o755)
    hangs = {"PATH": f"{lazy}:{os.environ['PATH']}"}
    quiet("laws", RIG, *out("drawn"))
    quiet("new", "four-bar", "-o", four_bar)
    quiet("run", four_bar, "--formulation", "nonsmooth", "--no-figures", *out("pl"))
    long = ["--set", "run.revolutions=2000"]
    many = ["run", discs, "--formulation", "nonsmooth", "--set"]
    yield "check, 1,020 contacts", 0.4, ["check", discs], {}
    yield "run, penalty", 3, ["run", RIG, "--formulation", "penalty", *long, *out("p")], {}
    yield "run, nonsmooth", 3, ["run", RIG, "--formulation", "nonsmooth", *long, *out("n")], {}
    yield ("run, 1,020 contacts, time stepping", 4,
           [*many, "nonsmooth.scheme=moreau-jean", "--set", "nonsmooth.step=1e-4", *out("m")], {})
    yield "run, 1,020 contacts, event-driven", 4, [*many, "nonsmooth.scheme=event-driven", *out("e")], {}
    yield "compare", 4, ["compare", RIG, *out("c")], {}
    yield "figures, gnuplot hangs", 1, ["figures", place / "drawn"], hangs
    yield "laws", 0.6, ["laws", RIG, *out("l")], {}
    yield "drift", 3, ["drift", RIG, *out("d")], {}
    yield "verify", 4, ["verify", *out("v")], {}
    yield "advise", 4, ["advise", RIG], {}
    for verb, study in STUDIES.items():
        one = ["--threads", "1"] if verb == "basin" else []
        yield verb, 4, [verb, ROOT / f"cases/{study}.toml", *one, *out(verb)], {}
    yield "poincare", 3, ["poincare", RIG, "--periods", "2000", "--discard", "10", *out("po")], {}
    yield "plot", 0.3, ["plot", place / "pl", "--y", "C.gap,rocker.omega"], {}
    yield "plot, gnuplot hangs", 1, ["plot", place / "pl", "--y", "C.gap"], hangs
    yield "extremes", 4, ["extremes", *out("x")], {}


def main(count=20, *only):
    freeplay = program("freeplay")
    program("freeplay-verify")  # executed for verify and extremes
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        table = Table("verb and phase", "signals", "median, s", "worst, s")
        for name, span, command, environment in runs(freeplay, place):
            if only and command[0] not in only:
                continue
            tries = [interrupt([freeplay, *map(str, command)], span, environment) for _ in range(int(count))]
            ends = [end for end in tries if end]
            times = [seconds for seconds, _ in ends]
            table.row(name, len(ends), *(f"{f(times):.2f}" if times else "-" for f in (statistics.median, max)))
            if statuses := {status for _, status in ends} - {1}:
                print(f"{name}: exit statuses {statuses}", file=sys.stderr)
        files = list(place.rglob("*.json"))
        broken = [file for file in files if not whole(file)]
        print(f"\n{len(broken)} of {len(files)} JSON files broken {broken or ''}".rstrip())
        return bool(broken)


def whole(file):
    try:
        json.loads(file.read_text())
    except ValueError:
        return False
    return True
