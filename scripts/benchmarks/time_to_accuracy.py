"""CPU time for an accuracy of the first eight contact times, for all schemes; some minutes.

    scripts/benchmark time-to-accuracy [FIGURE.png]

The error of a run is the greatest error of its first eight contact onsets (fewer if a scene's time has fewer),
divided by their mean interval. The reference of nonsmooth runs is event-driven with a tolerance of 1e-13, that of
penalty runs Bulirsch–Stoer with 1e-12; a second run (1e-12; dopri5) shows the accuracy of the references. A scheme's
settings become finer by factors of ten or three until the error is below 1e-8 or the next run would take more than a
second. The time is the CPU time of the run without reading the scene, assembly and compilation, the least of three rounds
in which general and compiled runs alternate. Their results are bitwise identical.

For the slider-crank two other programs make the steps of Moreau–Jean in the two coordinates of a derivation by hand:
freeplay-hand-derived (whole process) and Siconos (its time stepping; Debian's libsiconos-mechanics-dev, with g++).
"""
import csv
import json
import re
import subprocess
import tempfile
from pathlib import Path

from measure import ROOT, Table, call, in_turn, program, run, siconos

CONTACTS = 8
ERRORS = (1e-3, 1e-5, 1e-8)
LONGEST = 1.0  # s
ROUNDS = 3

EXACT = {"penalty__contact": "exact"}
RIG = "slider-crank, loose gudgeon pin"
SCENES = {
    RIG: ("cases/flores2011/scene.toml", dict(EXACT, run__discard=0), 0.1),
    "four-bar, two loose pins": ("verification/scenes/four_bar_two.toml", dict(EXACT), 0.5),
    "slider loose in its guide": ("cases/flores2010-translational/scene.toml", dict(EXACT), 0.02),
    "nine discs in a box": ("cases/discs-in-a-box/scene.toml",
                            {"groups__grains__grid": "[3, 3]", "surfaces__glass__young": 70e9,
                             "surfaces__glass__poisson": 0.2, **EXACT}, 0.03),
}
TOLERANCES = [10.0**-k for k in range(3, 13)]
STEPS = [x * 10.0**-k for k in range(4, 8) for x in (1, 0.3)]


def nonsmooth(scheme, key=None, **more):
    return "nonsmooth", dict(nonsmooth__scheme=scheme, **more), key


def penalty(integrator, key="penalty__tolerance"):
    return "penalty", dict(penalty__integrator=integrator), key


# formulation, settings, key of the fineness and its values
SCHEMES = {
    "event-driven": (*nonsmooth("event-driven", "nonsmooth__tolerance"), TOLERANCES),
    "automatic": (*nonsmooth("automatic", "nonsmooth__tolerance"), TOLERANCES),
    "moreau-jean, fixed steps": (*nonsmooth("moreau-jean", "nonsmooth__step"), STEPS),
    "moreau-jean, chosen steps": (*nonsmooth("moreau-jean", "nonsmooth__step_tolerance", nonsmooth__step="automatic"),
                                  TOLERANCES),
    "penalty, dopri5": (*penalty("dopri5"), TOLERANCES),
    "penalty, adams_bashforth_moulton": (*penalty("adams_bashforth_moulton"), TOLERANCES),
    "penalty, bulirsch_stoer": (*penalty("bulirsch_stoer"), TOLERANCES),
    "penalty, rosenbrock4": (*penalty("rosenbrock4"), TOLERANCES),
    "penalty, rk4": (*penalty("rk4", "penalty__step"), STEPS),
}
REFERENCES = {"nonsmooth": (nonsmooth("event-driven", nonsmooth__tolerance=1e-13),
                            nonsmooth("event-driven", nonsmooth__tolerance=1e-12)),
              "penalty": (penalty("bulirsch_stoer"), penalty("dopri5"))}


def onsets(folder):
    with open(Path(folder) / "events.csv") as table:
        times = [float(e["t"]) for e in csv.DictReader(table) if e.get("kind") != "separation"]
    return sorted(times)[:CONTACTS]


class Runs:
    """Runs of one scene. They end a mean interval after the last contact, so that its kind is known."""

    def __init__(self, freeplay, folder, scene):
        path, self.settings, self.horizon = SCENES[scene]
        self.freeplay, self.folder, self.path = freeplay, folder, Path(folder) / "scene.toml"
        text = (ROOT / path).read_text().split("\n[instruments.")[0] + "\n"
        self.path.write_text(re.sub(r"(?m)^revolutions *=.*$", "duration = 1.0", text))
        self.until, self.exact = {}, {}
        for formulation, (first, second) in REFERENCES.items():
            times = [self.times(f, dict(s, **{k or "penalty__tolerance": 1e-12} if f == "penalty" else s), self.horizon)
                     for f, s, k in (first, second)]
            self.exact[formulation] = times[0]
            self.until[formulation] = times[0][-1] + self.interval(formulation)
            self.doubt = self.error(formulation, times[1])
            print(f"{scene}, {formulation}: {len(times[0])} contacts up to {times[0][-1]:.6g} s; references differ by "
                  f"{self.doubt:.1e}", flush=True)

    def interval(self, formulation):
        return self.exact[formulation][-1] / len(self.exact[formulation])

    def error(self, formulation, times):
        if len(times) < len(self.exact[formulation]):
            return float("inf")
        return max(abs(a - b) for a, b in zip(times, self.exact[formulation])) / self.interval(formulation)

    def peers(self, contacts_of):
        """The ladder of another program with fixed steps: `contacts_of(duration, step)` gives times and CPU seconds."""
        for step in STEPS:
            until = self.until["nonsmooth"]
            times, seconds = contacts_of(until, step)
            error = self.error("nonsmooth", sorted(times)[:CONTACTS])
            least, _ = in_turn([lambda: (contacts_of(until, step)[1],)], ROUNDS if seconds < 0.1 else 2)[0]
            yield error, least, None
            if error < ERRORS[-1] or 3 * seconds > LONGEST:
                return

    def call(self, formulation, settings, until, compiled=False):
        """CPU seconds of the run. A run that ends early has no events after its end."""
        settings = dict(self.settings, **settings, run__duration=until, run__output_step=until)
        try:
            found = run(self.freeplay, self.path, self.folder, formulation, "--compile" if compiled else "--no-compile",
                        **settings)
        except subprocess.CalledProcessError:
            return float("inf")
        return found["cost"]["cpu_s"]

    def times(self, formulation, settings, until):
        self.call(formulation, settings, until)
        return onsets(self.folder)

    def ladder(self, scheme):
        """For each fineness: the error, CPU seconds in general and compiled."""
        formulation, settings, key, values = SCHEMES[scheme]
        for value in values:
            chosen = dict(settings, **{key: value})
            until = self.until[formulation]
            seconds = self.call(formulation, chosen, until)
            error = self.error(formulation, onsets(self.folder))
            calls = [lambda c=c: (self.call(formulation, chosen, until, c),) for c in (False, True)]
            general, compiled = (x[0] for x in in_turn(calls, ROUNDS if seconds < 0.1 else 2))
            yield error, general, compiled
            if error < ERRORS[-1] or 3 * seconds > LONGEST:
                return


def others(folder):
    """Programs with fixed steps for the slider-crank."""
    hand, peer = program("freeplay-hand-derived"), siconos(folder, "siconos_rig")

    def by_hand(duration, step):
        _, seconds = call([hand, "nonsmooth", duration, step, folder, 1])
        return onsets(folder), seconds

    def by_siconos(duration, step):
        first, *times = call([peer, duration, step, CONTACTS])[0].splitlines()
        return [float(t) for t in times], float(first.split()[1])
    return {"by hand, fixed steps": by_hand} | ({"Siconos, fixed steps": by_siconos} if peer else {})


def cell(ladder, error):
    """General and compiled CPU time in ms of the cheapest setting that reaches an error."""
    reached = [(g, c) for e, g, c in ladder if e <= error]
    if not reached:
        return "–"
    return " / ".join(f"{1e3 * min(times):.3g}" for times in zip(*reached) if None not in times)


def draw(found, figure):
    """Error over CPU time with gnuplot: lines in general, dashed compiled."""
    colours = ("#0b3c8c", "#3d9be0", "#c8500a", "#e0a030", "#1b7837", "#7b3294", "#8c510a", "#b2182b", "#777777", "#000000",
               "#d02090")
    text = [f"set terminal pngcairo size 1800,1500 font 'DejaVu Sans,15'; set output '{figure}'",
            "set multiplot layout 2,2; set logscale xy; set format '10^{%T}'; set grid lc rgb '#d4d4d4'",
            "set xlabel 'CPU time (ms)'; set ylabel 'error of contact times'; set yrange [1e-14:1]"]
    for i, (scene, ladders) in enumerate(found.items()):
        key = "bottom left font ',11' samplen 2" if i == 0 else "off"
        text.append(f"set title '{scene}'; set key {key}")
        lines, data = [], []
        for (scheme, ladder), colour in zip(ladders.items(), colours):
            for column, dash, point in ((1, 1, 7), (2, "(6,5)", 6)):
                if any(x[column] is None for x in ladder):
                    continue
                title = f"title '{scheme}' noenhanced" if column == 1 else "notitle"
                lines.append(f"'-' with linespoints lw 2 dt {dash} pt {point} ps 0.8 lc rgb '{colour}' {title}")
                data += [f"{1e3 * x[column]} {max(x[0], 2e-14)}" for x in ladder if x[0] < 1] + ["e"]
        text.append("plot " + ", ".join(lines))
        text += data
    subprocess.run(["gnuplot"], input="\n".join(text) + "\n", text=True, check=True)


def main(figure=None, kept=None):
    freeplay = program("freeplay")
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for scene in SCENES:
            runs = Runs(freeplay, folder, scene)
            found[scene] = {scheme: list(runs.ladder(scheme)) for scheme in SCHEMES}
            if scene == RIG:
                found[scene] |= {name: list(runs.peers(contacts)) for name, contacts in others(folder).items()}
            table = Table(scene, *(f"{e:.0e}" for e in ERRORS), "finest")
            for scheme, ladder in found[scene].items():
                finest = min((x[0] for x in ladder), default=float("inf"))
                table.row(scheme, *(cell(ladder, e) for e in ERRORS), f"{finest:.1e}")
            if kept:
                Path(kept).write_text(json.dumps(found))
    if figure:
        draw(found, figure)
