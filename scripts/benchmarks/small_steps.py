"""Cost of Freeplay relative to a hand-derived program for the same steps; about a minute.

Compares the paper's rig with clearance in its gudgeon pin with
verification/timing/hand_derived.cpp (docs/verification/performance.md, Small mechanisms): CPU time of whole
processes with their output and of stepping only, the least of seven; instructions by callgrind.
"""
import tempfile

from measure import LENGTH, Table, call, in_turn, instructions_each, program, rig

STEP = 1e-5  # s
RUNG = 4  # of the ladder: the rig with clearance and friction


def main():
    freeplay, ladder, hand = program("freeplay"), program("freeplay-ladder"), program("freeplay-hand-derived")
    table = Table("the rig, loose, with friction", "Freeplay", "by hand", "ratio")

    def line(what, ours, theirs, form):
        table.row(what, f"{ours:{form}}", f"{theirs:{form}}", f"{ours / theirs:.1f}")

    def least(*commands):
        return [found[0] for found in in_turn([lambda c=c: call(c)[1:] for c in commands], 7)]

    with tempfile.TemporaryDirectory() as folder:
        out = f"{folder}/freeplay"
        command = [freeplay, "run", rig(folder, 2.0), "--formulation", "nonsmooth", "--no-figures", "-o", out]
        call(command)
        with open(f"{out}/trajectory.csv") as trajectory:
            rows = sum(1 for _ in trajectory) - 1  # the hand-derived program writes the same number
        line(f"whole process, 200,000 steps, {rows:,} rows (s)",
             *least(command, [hand, "nonsmooth", 2.0, STEP, folder, rows]), ".3f")
    # Difference of a longer and a shorter run, without output. The hand-derived program runs ten
    # times as long.
    a, b, c, d = least([ladder, RUNG, "nonsmooth", 3.0], [ladder, RUNG, "nonsmooth", 0.1],
                       [hand, "nonsmooth", 30.0, STEP], [hand, "nonsmooth", 0.1, STEP])
    line("a step of Moreau–Jean alone (µs)", 1e6 * (a - b) * STEP / 2.9, 1e6 * (c - d) * STEP / 29.9, ".3f")
    line("a step of Moreau–Jean (instructions)", instructions_each([ladder, RUNG, "nonsmooth", LENGTH], 0.1, 0.5),
         instructions_each([hand, "nonsmooth", LENGTH, STEP], 0.1, 0.5), ",.0f")
    line("a penalty run over its right-hand sides (instructions)",
         instructions_each([ladder, RUNG, "penalty", LENGTH], 0.1, 0.5, column=1),
         instructions_each([hand, "penalty", LENGTH], 1000, 50000), ",.0f")
