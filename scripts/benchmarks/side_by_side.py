"""Time and error of Freeplay, a hand-derived program and Siconos; about a minute.

All use Moreau–Jean with θ = ½ on the same scenes with the same steps. Scenes: a ball that
bounces on a table (closed form: parabolas between impacts), and the paper's rig with clearance
in its gudgeon pin (error of the time and speed of the first impact, relative to the event-driven
scheme at 1e-12). Siconos (Debian's libsiconos-mechanics-dev, with g++) computes only the ball
here; the benchmark time-discs has thousands of discs. Reported is the CPU time per step, least
and median of five rounds: for Freeplay the whole run except reading the scene, for the
hand-derived program the whole process.
"""
import csv
import math
import tempfile
from pathlib import Path

from measure import Table, call, in_turn, program, rig, run, siconos

ROUNDS = 5
G, DROP, RESTITUTION = 9.81, 0.5, 0.8  # m/s², m

BALL = f"""format = 2
gravity = [0.0, -{G}]
[bodies.ball]
mass = 0.3
inertia = 3e-4
position = [0.0, {DROP + 0.05}]
[contacts.table]
type = "plane"
between = ["ground", "ball"]
radius = 0.05
surface = "hard"
[surfaces.hard]
restitution = {RESTITUTION}
[run]
duration = 1.0
output_step = 1.0
start = "given"
[nonsmooth]
scheme = "moreau-jean"
step = 1e-4
"""


def height(t):
    """Height of the ball above the table at time t (m)."""
    fall = math.sqrt(2 * DROP / G)
    if t < fall:
        return DROP - 0.5 * G * t * t
    t, speed = t - fall, G * fall * RESTITUTION
    while t > 2 * speed / G:
        t, speed = t - 2 * speed / G, speed * RESTITUTION
    return speed * t - 0.5 * G * t * t


def rows(path):
    with open(path) as table:
        return list(csv.DictReader(table))


def ball(freeplay, hand, peer, folder, duration, step):
    steps, exact = round(duration / step), height(duration)
    scene, out = folder / "ball.toml", folder / "out"
    scene.write_text(BALL)

    def ours():
        cost = run(freeplay, scene, out, run__duration=duration, run__output_step=duration, nonsmooth__step=step)["cost"]
        y = float(rows(out / "trajectory.csv")[-1]["ball.y"]) - 0.05
        return 1e6 * cost["cpu_s"] / steps, abs(y - exact)

    def by_hand():
        text, seconds = call([hand, "ball", duration, step, RESTITUTION, DROP])
        return 1e6 * seconds / steps, abs(float(text.split()[1]) - exact)

    def peers():
        _, time, y = call([peer, duration, step, RESTITUTION, DROP])[0].split()
        return float(time), abs(float(y) - exact)
    return {"Freeplay": ours, "by hand": by_hand} | ({"Siconos": peers} if peer else {})


def loose_rig(freeplay, hand, folder, duration, step):
    steps = round(duration / step)
    scene, out = rig(folder, duration), folder / "out"
    run(freeplay, scene, out, nonsmooth__scheme="event-driven", nonsmooth__tolerance=1e-12, run__duration=0.05)
    exact = rows(out / "events.csv")[0]

    def off(t, speed):
        return max(abs(float(t) / float(exact["t"]) - 1), abs(float(speed) / float(exact["v_n_minus"]) - 1))

    def ours():
        cost = run(freeplay, scene, out, nonsmooth__step=step, run__output_step=duration)["cost"]
        first = rows(out / "events.csv")[0]
        return 1e6 * cost["cpu_s"] / steps, off(first["t"], first["v_n_minus"])

    def by_hand():
        text, seconds = call([hand, "nonsmooth", duration, step])
        return 1e6 * seconds / steps, off(*text.splitlines()[1].split())
    return {"Freeplay": ours, "by hand": by_hand}


def main():
    freeplay, hand = program("freeplay"), program("freeplay-hand-derived")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        peer = siconos(folder, "siconos_ball")
        table = Table("scene", "program", "µs a step", "median", "over by hand", "error")

        def rounds(name, programs, unit):
            found = dict(zip(programs, in_turn(programs.values(), ROUNDS)))
            for who, (least, median, error) in found.items():
                table.row(name, who, f"{least:.3g}", f"{median:.3g}", f"{least / found['by hand'][0]:.1f}", f"{error:.2g} {unit}")

        for step in (1e-4, 1e-5):
            rounds(f"ball, 2 s, {step:.0e} s", ball(freeplay, hand, peer, folder, 2.0, step), "m")
        rounds("rig, 2 s, 1e-05 s", loose_rig(freeplay, hand, folder, 2.0, 1e-5), "of the first impact")
