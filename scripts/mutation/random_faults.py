#!/usr/bin/env python3
"""scripts/mutations --random N --seed S: draws N random faults from all lines of code, builds
and tests each in a copy of the sources under build/, and writes their table into
docs/verification/mutations.md. Verdicts are kept in build/mutations-random, so that an interrupted run can be
resumed. Of the checkout only the page is changed.

  --draw        prints the faults and changes nothing
  --again       tests the surviving faults again with the current tests
  --within S    leaves out parts of the suite that take more than S seconds, which a fault that
                survives would wait for: the share caught is then a lower bound
  --first N     tests at most N further faults; writes the page only if all faults of --random are done
  --tree CLONE  uses this clone and its build instead of a copy under build/
"""
import argparse
import collections
import json
import math
import os
import pathlib
import re
import sys
import time

sys.dont_write_bytecode = True
from draw import order  # noqa: E402
from judge import UNITS, Copy, Suite  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
PLACE = ROOT / "build" / "mutations-random"
PAGE = ROOT / "docs/verification/mutations.md"
EQUIVALENT = ROOT / "scripts" / "mutation" / "equivalent.txt"
HEAD = "## Faults drawn at random"


def equivalents():
    """Equivalent faults, as checked by hand: key of the fault to the reason."""
    found, block = {}, []
    for line in EQUIVALENT.read_text().split("\n") + [""]:
        if line.startswith("#"):
            continue
        if line:
            block.append(line)
        elif block:
            file, old, new, why = block
            found[f"{file}\n-{old[1:].strip()}\n+{new[1:].strip()}"] = why
            block = []
    return found


class Verdicts:
    """Verdicts by fault, one line of JSON each. Written immediately, so that no fault is tested
    twice."""

    def __init__(self, again):
        self.file = PLACE / "verdicts.jsonl"
        self.of = {}
        if self.file.exists():
            for line in self.file.read_text().splitlines():
                verdict = json.loads(line)
                self.of[verdict["key"]] = verdict
        if again:
            self.of = {k: v for k, v in self.of.items() if v["how"] not in ("survives", "crash")}

    def add(self, fault, how, by, seconds):
        self.of[fault.key] = {"key": fault.key, "how": how, "by": by, "seconds": round(seconds)}
        with open(self.file, "a") as out:
            out.write(json.dumps(self.of[fault.key], ensure_ascii=False) + "\n")


def interval(caught, tried):
    """Wilson's 95 % confidence interval of a proportion."""
    z, share = 1.96, caught / tried
    middle, half = share + z * z / (2 * tried), z * math.sqrt(share * (1 - share) / tried + z * z / (4 * tried * tried))
    return (middle - half) / (1 + z * z / tried), (middle + half) / (1 + z * z / tried)


def cell(text):
    return re.sub(r"\s+", " ", text).replace("|", "\\|").strip()


def code(text):
    return "`` " + cell(text) + " ``" if "`" in text else "`" + cell(text) + "`"


def page(seed, judged, refused, within):
    """Writes the section on random faults in docs/verification/mutations.md."""
    same = equivalents()
    how = {f.key: ("equivalent" if f.key in same and v["how"] in ("survives", "crash", "same") else v["how"]) for f, v in judged}
    how = {k: "equivalent" if h == "same" else h for k, h in how.items()}
    columns = ["claims", "tests", "time", "crash", "equivalent", "survives"]
    counts = collections.Counter((f.kind, how[f.key]) for f, _ in judged)
    real = sum(h != "equivalent" for h in how.values())
    caught = sum(h in ("claims", "tests", "time") for h in how.values())
    low, high = interval(caught, real)
    seconds = sum(v["seconds"] for _, v in judged)
    lines = [HEAD, "",
             f"Written by `scripts/mutations --random {len(judged)} --seed {seed}`: {len(judged)} faults on lines drawn from all code of "
             "src/ and formulations/, each compiled",
             "and linked in a copy and judged by the tests and the sets of claims (but for [long] and [slow], and for the tests that build against the "
             "installed library), up to the first that fails."
             + (f" Parts that take more than {within:g} s are left out: the share is a lower bound." if within < math.inf else ""),
             f"**{caught} of {real} that change anything are caught: {caught / real:.0%}, with 95 % confidence {low:.0%} to {high:.0%} "
             "(Wilson's interval).**",
             f"{refused} more were drawn that the compiler refuses. A fault took {seconds / len(judged):.0f} s. *Time*: a part did not end in "
             "five times its time and a minute;",
             "*crash*: nothing but crashes detects it. *Equivalent*: the compiler makes the same code of it, or judged by hand",
             "(`scripts/mutation/equivalent.txt`).", ""]
    lines += [
             "| kind | drawn | " + " | ".join(columns) + " |", "| --- " * (len(columns) + 2) + "|"]
    for kind in sorted({f.kind for f, _ in judged}) + ["all"]:
        row = [sum(n for (k, h), n in counts.items() if kind in (k, "all") and h == c) for c in columns]
        lines.append(f"| {kind} | {sum(row)} | " + " | ".join(map(str, row)) + " |")
    lines += ["", "| where | kind | line | with the fault | detected by |", "| --- | --- | --- | --- | --- |"]
    rank = {h: i for i, h in enumerate(reversed(columns))}
    for f, v in sorted(judged, key=lambda x: (rank[how[x[0].key]], x[0].file, x[0].line)):
        h = how[f.key]
        told = {"survives": "**nothing**", "equivalent": "nothing: " + same.get(f.key, "the same code"),
                "crash": "*" + v["by"] + "*", "time": "*" + v["by"] + "*"}.get(h, v["by"])
        lines.append(f"| {f.file}:{f.line} | {f.kind} | {code(f.old)} | {code(f.new)} | {cell(told)} |")
    text = PAGE.read_text()
    end = text.find("<!-- made from")
    begin = text.find(HEAD)
    begin = begin if begin >= 0 else end if end >= 0 else len(text)
    PAGE.write_text(text[:begin] + "\n".join(lines) + "\n\n" + (text[end:] if end >= 0 else ""))
    return caught, real


def judged_fault(copy, suite, fault):
    """Plants and tests a fault; returns (how, by what) as Suite.judge()."""
    copy.plant(fault)
    units = copy.units_of(fault.file)
    if not units:
        return "same", "no unit but tests reads it"
    for some in dict.fromkeys([tuple(units[:UNITS]), tuple(units)]):
        if not copy.compile(some) or not copy.link():
            return "refused", ""
        how, by = ("same", "the same code") if copy.same(some) else suite.judge(fault.file, fault.line)
        if how in ("claims", "tests", "time"):
            break
    return how, by


def main():
    parse = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parse.add_argument("--random", type=int, required=True, metavar="N")
    parse.add_argument("--seed", type=int, default=1)
    parse.add_argument("--within", type=float, default=math.inf, metavar="S")
    parse.add_argument("--first", type=int, default=10**9)
    parse.add_argument("--tree")
    parse.add_argument("--draw", action="store_true")
    parse.add_argument("--again", action="store_true")
    asked = parse.parse_args()
    if asked.draw:
        for n, f in zip(range(asked.random), order(ROOT, asked.seed)):
            print(f"{n + 1}. {f.file}:{f.line} {f.kind}\n  -{f.old.strip()}\n  +{f.new.strip()}")
        return 0
    PLACE.mkdir(parents=True, exist_ok=True)
    copy = Copy(ROOT, PLACE, asked.tree)
    if not copy.prepare():
        sys.exit(f"without a fault the copy does not build: see {copy.log}")
    suite = Suite(copy, asked.within)
    verdicts = Verdicts(asked.again)
    judged, refused, left = [], 0, asked.first
    for n, fault in enumerate(order(ROOT, asked.seed)):
        if len(judged) == asked.random or n >= 2 * asked.random:
            break
        verdict = verdicts.of.get(fault.key)
        if verdict is None:
            if left == 0:
                break
            left -= 1
            began = time.monotonic()
            try:
                how, by = judged_fault(copy, suite, fault)
            finally:
                copy.put_back()
            verdicts.add(fault, how, by, time.monotonic() - began)
            verdict = verdicts.of[fault.key]
            print(f"{fault.file}:{fault.line} {fault.kind}: {verdict['how']} {verdict['by']} ({verdict['seconds']} s)", flush=True)
        if verdict["how"] == "refused":
            refused += 1
        else:
            judged.append((fault, verdict))
    copy.build()
    known = equivalents()
    missed = [f for f, v in judged if v["how"] in ("survives", "crash") and f.key not in known]
    for f in missed:
        print(f"\n{f.file}:{f.line}\n-{f.old.strip()}\n+{f.new.strip()}")
    if len(judged) < asked.random:
        print(f"{len(judged)} of {asked.random} judged; the same command goes on")
        return 1
    caught, real = page(asked.seed, judged, refused, asked.within)
    low, high = interval(caught, real)
    print(f"{caught} of {real} caught: {caught / real:.0%}, with 95 % confidence {low:.0%} to {high:.0%}")
    return 0 if caught >= 0.95 * real else 1


if __name__ == "__main__":
    os.chdir(ROOT)
    sys.exit(main())
