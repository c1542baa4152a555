#!/usr/bin/env python3
"""scripts/mutations --random N --seed S: draws N faults from all lines of code, builds and judges each in a copy of the
sources under build/, and writes their table into docs/mutations.md. What has been judged is kept in build/mutations-random:
a run that was interrupted goes on. The checkout is not changed but for the page.

  --draw        shows the faults and changes nothing
  --again       judges anew what survived, by the tests as they are now
  --first N     judges at most N more now, and leaves the page alone unless all N of --random are done
  --part K/N    of the order every N-th from the K-th alone, in a clone of its own; their verdicts.jsonl are joined by hand
"""
import argparse
import collections
import json
import os
import pathlib
import re
import sys

sys.dont_write_bytecode = True
from draw import order  # noqa: E402
from judge import Copy, Suite  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
PLACE = ROOT / "build" / "mutations-random"
PAGE = ROOT / "docs" / "mutations.md"
EQUIVALENT = ROOT / "scripts" / "mutation" / "equivalent.txt"
HEAD = "## Faults drawn at random"


def equivalents():
    """What was judged by hand to change nothing that anyone could see: key of the fault to the reason."""
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
    """What was judged, a line of JSON each, by the fault; written at once, so that nothing is judged twice."""

    def __init__(self, again):
        self.file = PLACE / "verdicts.jsonl"
        self.of = {}
        if self.file.exists():
            for line in self.file.read_text().splitlines():
                verdict = json.loads(line)
                self.of[verdict["key"]] = verdict
        if again:
            self.of = {k: v for k, v in self.of.items() if v["how"] not in ("survives", "crash")}

    def add(self, fault, how, by):
        self.of[fault.key] = {"key": fault.key, "how": how, "by": by}
        with open(self.file, "a") as out:
            out.write(json.dumps(self.of[fault.key], ensure_ascii=False) + "\n")


def prepare():
    """The copy, built and measured without a fault where it is not already as the checkout is."""
    PLACE.mkdir(parents=True, exist_ok=True)
    copy = Copy(ROOT, PLACE)
    suite = Suite(copy)
    ready = PLACE / "ready"
    if ready.exists():
        copy.put_back()
    if copy.take() or not ready.exists():
        ready.unlink(missing_ok=True)
        print("building and measuring the copy without a fault", flush=True)
        if not copy.build("freeplay", "freeplay-tests"):
            sys.exit(f"without a fault the copy does not build: see {copy.log}")
        copy.keep_times()
        copy.keep()
        for name in suite.measure()["failing"]:
            print(f"fails without a fault, and judges nothing: {name}", flush=True)
        copy.put_back()
        ready.touch()
    return copy, suite


def cell(text):
    return re.sub(r"\s+", " ", text).replace("|", "\\|").strip()


def code(text):
    return "`` " + cell(text) + " ``" if "`" in text else "`" + cell(text) + "`"


def page(seed, judged, refused):
    """The part of docs/mutations.md on random faults."""
    same = equivalents()
    how = {f.key: ("equivalent" if f.key in same and v["how"] in ("survives", "crash", "same") else v["how"]) for f, v in judged}
    how = {k: "equivalent" if h == "same" else h for k, h in how.items()}
    columns = ["claims", "tests", "time", "crash", "equivalent", "survives"]
    counts = collections.Counter((f.kind, how[f.key]) for f, _ in judged)
    real = sum(h != "equivalent" for h in how.values())
    caught = sum(h in ("claims", "tests", "time") for h in how.values())
    lines = [HEAD, "",
             f"Written by `scripts/mutations --random {len(judged)} --seed {seed}`: {len(judged)} faults on lines drawn from all "
             "code of src/ and formulations/, each",
             "built in a copy and judged by the tests (but for the maps of the extremes and of strangers, and those that build against",
             f"the installed library) and by `freeplay verify`, claims first, the cheapest before the others, up to the first that fails. **{caught} of {real} "
             "that change anything are",
             f"caught.** {refused} more were drawn that the compiler refuses. *Time*: the suite did not end in five times its time; "
             "*crash*: nothing",
             "but crashes tells it. *Equivalent*: the compiler makes the same code of it, or judged by hand",
             "(`scripts/mutation/equivalent.txt`).", ""]
    if failing := json.loads((PLACE / "costs.json").read_text())["failing"]:
        lines += [f"Failing without a fault, and so judging nothing: {'; '.join(failing)}.", ""]
    lines += [
             "| kind | drawn | " + " | ".join(columns) + " |", "| --- " * (len(columns) + 2) + "|"]
    for kind in sorted({f.kind for f, _ in judged}) + ["all"]:
        row = [sum(n for (k, h), n in counts.items() if kind in (k, "all") and h == c) for c in columns]
        lines.append(f"| {kind} | {sum(row)} | " + " | ".join(map(str, row)) + " |")
    lines += ["", "| where | kind | line | with the fault | told by |", "| --- | --- | --- | --- | --- |"]
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
    """(how, by what). The claims first, by the program alone: the tests take long to build where a header is at fault."""
    copy.plant(fault)
    if not copy.build("freeplay"):
        return "refused", ""
    how, by = ("survives", "") if copy.same_objects() else suite.judge("claims")
    if how in ("claims", "time"):
        return how, by
    if not copy.build("freeplay-tests"):
        return "refused", ""
    if copy.same_objects():
        return "same", "the same code"
    return suite.judge("tests", by if how == "crash" else None)


def main():
    parse = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parse.add_argument("--random", type=int, required=True, metavar="N")
    parse.add_argument("--seed", type=int, default=1)
    parse.add_argument("--first", type=int, default=10**9)
    parse.add_argument("--part", default="1/1")
    parse.add_argument("--draw", action="store_true")
    parse.add_argument("--again", action="store_true")
    asked = parse.parse_args()
    if asked.draw:
        for n, f in zip(range(asked.random), order(ROOT, asked.seed)):
            print(f"{n + 1}. {f.file}:{f.line} {f.kind}\n  -{f.old.strip()}\n  +{f.new.strip()}")
        return 0
    copy, suite = prepare()
    verdicts = Verdicts(asked.again)
    judged, refused, left = [], 0, asked.first
    part, parts = map(int, asked.part.split("/"))
    for n, fault in enumerate(order(ROOT, asked.seed)):
        if len(judged) == asked.random or n >= 2 * asked.random:
            break
        verdict = verdicts.of.get(fault.key)
        if verdict is None and n % parts != part - 1:
            continue
        if verdict is None:
            if left == 0:
                break
            left -= 1
            try:
                verdicts.add(fault, *judged_fault(copy, suite, fault))
            finally:
                copy.put_back()
            verdict = verdicts.of[fault.key]
            print(f"{fault.file}:{fault.line} {fault.kind}: {verdict['how']} {verdict['by']}", flush=True)
        if verdict["how"] == "refused":
            refused += 1
        else:
            judged.append((fault, verdict))
    known = equivalents()
    missed = [f for f, v in judged if v["how"] in ("survives", "crash") and f.key not in known]
    for f in missed:
        print(f"\n{f.file}:{f.line}\n-{f.old.strip()}\n+{f.new.strip()}")
    if len(judged) < asked.random:
        print(f"{len(judged)} of {asked.random} judged; the same command goes on")
        return 1
    caught, real = page(asked.seed, judged, refused)
    print(f"{caught} of {real} caught")
    return 0 if caught >= 0.95 * real else 1


if __name__ == "__main__":
    os.chdir(ROOT)
    sys.exit(main())
