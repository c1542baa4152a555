"""Instructions a step and a penalty right-hand side on each rung of the ladder; some minutes.

By callgrind. Fails when a rung costs a quarter more than docs/development/decisions/007 records, or when a right-hand side of the loose rig,
eliminated, takes more than eight times the oracle's.
"""
import re

from measure import LENGTH, Table, call, instructions_each, program

# Instructions a step and a right-hand side as recorded, by rung; compilers move them by some per cent.
RECORDED = ((3503, 4848), (8273, 9049), (10889, 11107), (9274, 8344), (11093, 8754), (15006, 10429), (11376, 11836),
            (13819, 11830))


def main():
    ladder = program("freeplay-ladder")
    wrong = []
    table = Table("rung", "step", "right-hand side")
    for rung, recorded in enumerate(RECORDED):
        name = call([ladder, rung, "nonsmooth", 0.001])[0].split(maxsplit=2)[2].strip()
        counts = [instructions_each([ladder, rung, formulation, LENGTH], 0.02, 0.06, column)
                  for column, formulation in enumerate(("nonsmooth", "penalty"))]
        table.row(name, *(f"{c:,.0f}" for c in counts))
        wrong += [f"{name}, {what}: {count:.0f} instructions, recorded {old}, allowed a quarter more"
                  for what, count, old in zip(("a step", "a right-hand side"), counts, recorded) if 4 * count > 5 * old]
    text = call([ladder])[0]
    print(text)
    # The oracle's contact is closed: only the loose rungs compare like with like.
    wrong += [f"{line}: more than eight oracles" for line in text.splitlines()
              if re.match("rig, loose|with ", line) and float(line.split()[-1]) > 8]
    for line in wrong:
        print(f"ladder: {line}")
    return bool(wrong)
