"""Discs that fall into a box: Freeplay and Siconos on the same scene with the same steps.

    time-discs [COLUMNS ROWS STEPS EVERY]     default: 40 25 600 100

Needs g++ and Debian's libsiconos-mechanics-dev. Both programs use Moreau–Jean with θ = ½ at 1e-3
s, restitution 0.2, friction 0.3, and solve contacts to 1e-8. They run alternately on one thread,
from the start to 1, 2, 3, … times EVERY steps. Columns: CPU time per step since the previous row
and overall (µs; for Freeplay with its result files), greatest penetration (m; Freeplay: so far,
Siconos: at that time), kinetic energy (J), and the residual in the measure of each program.
"""
import tempfile
from pathlib import Path

from measure import Table, call, program, run, siconos

RADIUS, STAGGER = 1.0, 0.05  # m


def scene_of(columns, rows, gap=0.02):
    """The scene, with rows `gap` apart (m). verification/timing/siconos_discs.cpp has the same
    scene."""
    across, up = 2.1, 2 * RADIUS + gap
    width = across * (columns - 1) + 2 * RADIUS + 0.1 + STAGGER
    height = up * rows + 10
    return f"""format = 2
gravity = [0.0, -9.81]
[groups.discs]
mass = 1.0
radius = {RADIUS}
grid = [{columns}, {rows}]
origin = [{RADIUS + 0.05}, {RADIUS + 0.01}]
spacing = [{across}, {up}]
stagger = {STAGGER}
walls = [[0.0, {height}], [0.0, 0.0], [{width}, 0.0], [{width}, {height}]]
surface = "s"
pairs = "near"
[surfaces.s]
restitution = 0.2
friction = 0.3
[run]
duration = 1.0
output_step = 1.0
start = "given"
[nonsmooth]
scheme = "moreau-jean"
step = 1e-3
lcp_tolerance = 1e-8
"""


def main(columns=40, rows=25, steps=600, every=100):
    columns, rows, steps, every = int(columns), int(rows), int(steps), int(every)
    freeplay = program("freeplay")
    with tempfile.TemporaryDirectory() as place:
        place = Path(place)
        scene = place / "scene.toml"
        scene.write_text(scene_of(columns, rows))
        peer = siconos(place, "siconos_discs")
        table = Table("program", "steps", "µs a step since", "µs a step", "penetration, m", "kinetic energy, J", "residual")

        def ours(n):
            result = run(freeplay, scene, place / f"run{n}", run__duration=n * 1e-3)
            deepest = max(c["greatest_penetration_m"] for c in result["contacts"].values())
            return (result["cost"]["cpu_s"], f"{deepest:.2e}", f"{result['energy_J']['kinetic']:.8g}",
                    f"{result['greatest_complementarity_residual']:.1e}")

        def peers(n):
            last = call([peer, columns, rows, n, 1e-8, n])[0].splitlines()[-1].split(",")
            return float(last[2]) * 1e-6 * n, *last[3:6]

        programs = {"Freeplay": ours} | ({"Siconos": peers} if peer else {})
        before = {}
        for n in range(every, steps + 1, every):
            for name, measure in programs.items():
                seconds, *rest = measure(n)
                last, spent = before.get(name, (0, 0.0))
                before[name] = n, seconds
                table.row(name, n, f"{(seconds - spent) / (n - last) * 1e6:.0f}", f"{seconds / n * 1e6:.0f}", *rest)
