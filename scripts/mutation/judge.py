"""A copy of the project with its own build, in which a fault is compiled, linked and tested.

Only the translation units that include the faulty file are compiled, without tests: one unit for
a source; for a header the UNITS nearest ones, and all of them if these do not detect the fault.
The linked programs are tested by the parts of scripts/check (files of tests and sets of claims),
one per core: those that execute the faulty line (scripts/coverage records which), else all. Parts
whose sources include the header of the file come first, then the others, the shortest first. Thus
most faults are detected early, and a surviving fault has passed every part that executes it except
the [long] and [slow] ones and those that take longer than asked.
"""
import concurrent.futures
import json
import math
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import threading

FILES = ["CMakeLists.txt", "CMakePresets.json", "LICENSE"]
FOLDERS = ["src", "formulations", "plots", "verification", "cases", "scripts", "docs", ".ci", "README.md"]
UNITS = 16
EXECUTED = "build/coverage/executed.json"  # written by scripts/coverage
# [library] builds user programs against the installed library, which is too expensive here.
CHOSEN = "~[long]~[slow]~[library]~[.]"


class Copy:
    def __init__(self, root, place, tree):
        self.root, self.place = pathlib.Path(root), pathlib.Path(place)
        self.tree = pathlib.Path(tree) if tree else self.place / "tree"
        self.built = self.tree / "build" / "release"
        self.aside, self.log = self.place / "aside", self.place / "build.log"  # aside: original files

    def command(self, *words, cwd=None):
        """Runs a command; its output goes to the log. Returns whether it succeeds."""
        with open(self.log, "a") as log:
            return subprocess.run(words, cwd=cwd or self.tree, stdout=log, stderr=log, stdin=subprocess.DEVNULL).returncode == 0

    def build(self):
        return self.command("scripts/build", "release", "freeplay", "freeplay-tests")

    def prepare(self):
        """Copies, builds and tests the sources without a fault. Unchanged files keep their
        times, so that little is rebuilt."""
        self.put_back()
        self.log.write_text("")
        listed = subprocess.run(["git", "ls-files", "-z", *FILES, *FOLDERS], cwd=self.root, capture_output=True, check=True).stdout
        names = {n for n in listed.decode().split("\0") if n and (self.root / n).is_file()}
        for name in names:
            to = self.tree / name
            if not to.exists() or to.read_bytes() != (self.root / name).read_bytes():
                to.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(self.root / name, to)
                os.utime(to)
        for folder in FOLDERS:
            for path in (self.tree / folder).rglob("*"):
                if path.is_file() and str(path.relative_to(self.tree)) not in names:
                    path.unlink()
        if not self.build():
            return False
        if not (self.built / "test-seconds").exists():
            self.command("scripts/check", "release", CHOSEN)  # measures the duration of each part
        read = lambda *words: subprocess.run(["ninja", "-C", self.built, "-t", *words], capture_output=True, text=True,
                                             check=True).stdout
        self.units, unit = {}, None
        for line in read("deps").split("\n"):
            if line and line[0] != " ":
                unit = line.split(":")[0]
            elif line and unit.endswith(".o") and "freeplay-tests" not in unit:
                self.units.setdefault(os.path.relpath(os.path.join(self.built, line.strip()), self.tree), []).append(unit)
        self.links = [line for line in read("commands", "freeplay", "freeplay-tests").split("\n") if line.startswith(": &&")]
        return True

    def units_of(self, file):
        """The translation units that include a file, the nearest in the tree first."""
        near = lambda unit: -len(os.path.commonprefix([unit.split(".dir/")[1], file]))
        return sorted(self.units.get(file, []), key=near)

    def plant(self, fault):
        self.keep(fault.file)
        path = self.tree / fault.file
        lines = path.read_text().split("\n")
        assert lines[fault.line - 1] == fault.old, f"{fault.file}:{fault.line} is another line now"
        lines[fault.line - 1] = fault.new
        path.write_text("\n".join(lines))

    def keep(self, name):
        to = self.aside / name
        if not to.exists():
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(self.tree / name, to.with_name(to.name + ".half"))
            os.rename(to.with_name(to.name + ".half"), to)

    def compile(self, units):
        """Compiles units; False if the compiler reports an error."""
        for unit in units:
            self.keep(f"build/release/{unit}")
        return self.command("ninja", "-C", str(self.built), *units)

    def same(self, units):
        """Whether the fault does not change the object files."""
        return all((self.built / u).read_bytes() == (self.aside / "build/release" / u).read_bytes() for u in units)

    def link(self):
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            run = lambda links: all(pool.map(lambda link: self.command("bash", "-c", link, cwd=self.built), links))
            archive = lambda link: " ar " in link or "/ar " in link
            return run([x for x in self.links if archive(x)]) and run([x for x in self.links if not archive(x)])

    def put_back(self):
        """Restores sources and objects without the fault, with their times, so that they are not
        rebuilt; removes linked files."""
        if not self.aside.exists():
            return
        for path in self.aside.rglob("*"):
            if path.is_file() and path.suffix != ".half":
                shutil.copy2(path, self.tree / path.relative_to(self.aside))
        for path in [*self.built.glob("lib*.a"), self.built / "freeplay", self.built / "freeplay-tests"]:
            path.unlink(missing_ok=True)
        shutil.rmtree(self.aside)


class Suite:
    """The parts of scripts/check."""

    def __init__(self, copy, within):
        self.copy, self.program = copy, copy.built / "freeplay-tests"
        listed = subprocess.run([self.program, "-#", "--list-tags", CHOSEN], capture_output=True, text=True).stdout
        took = dict(reversed(line.split()) for line in (copy.built / "test-seconds").read_text().splitlines())
        self.seconds = {part: float(took.get(part, 60)) for part in re.findall(r"\[#(.*)\]$", listed, re.M)}
        self.seconds = {part: took for part, took in self.seconds.items() if took <= within}
        self.sources = {path.stem: path.read_text() for path in (copy.root / "verification").rglob("*_test.cpp")}
        recorded = copy.root / EXECUTED
        self.executed = json.loads(recorded.read_text()) if recorded.exists() else {}

    def order(self, file, line):
        """The parts that execute the line; without a record of it, or if no part executes it (as a
        constant), all parts. Those whose sources include the header of the file come first."""
        runs = lambda part: part not in self.executed or int(self.executed[part].get(file, "0"), 16) >> line & 1
        parts = [part for part in self.seconds if runs(part)] if self.executed else []
        header = re.sub(r"^src/", "", str(pathlib.Path(file).with_suffix(".hpp")))
        near = lambda part: f'"{header}"' in self.sources.get(part, "")
        return sorted(parts or self.seconds, key=lambda part: (not near(part), self.seconds[part]))

    def judge(self, file, line):
        """(how, by what) for the first part that fails. how: claims, tests, time, crash (only
        crashes) or survives."""
        done, running, lock, verdicts = threading.Event(), {}, threading.Lock(), []

        def run(part):
            limit = math.ceil(60 + 5 * self.seconds[part])  # s of CPU time: other work beside it is no fault
            limited = lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
            with lock:
                if done.is_set():
                    return
                log = self.copy.place / f"judged-{part}.log"
                with open(log, "w") as out:
                    child = subprocess.Popen([self.program, "-#", "--abort", f"[#{part}]{CHOSEN}"], cwd=self.copy.tree, stdout=out,
                                             stderr=out, stdin=subprocess.DEVNULL, start_new_session=True, preexec_fn=limited)
                running[part] = child
            try:
                status = child.wait(10 * limit)  # for one that waits without computing
            except subprocess.TimeoutExpired:
                os.killpg(child.pid, signal.SIGKILL)  # and its child processes
                child.wait()
                status = None
            with lock:
                del running[part]
                text = log.read_text(errors="replace")
                log.unlink()
                if done.is_set() or status == 0:
                    return
                first = re.search(r"^-{20,}\n(.*?)(?:\n|$)", text, re.M)
                by = f"{part}: {first[1].strip() if first else (text.strip().splitlines() or ['nothing is printed'])[-1]}"
                if status in (None, -signal.SIGXCPU):
                    verdicts.append(("time", f"{part} after {limit} s"))
                elif status < 0 or "fatal error condition" in text:
                    verdicts.append(("crash", by))
                    return  # continues: another part may detect it without a crash
                else:
                    verdicts.append(("claims" if part.startswith("claims-") else "tests", by))
                done.set()
                for other in running.values():
                    os.killpg(other.pid, signal.SIGKILL)

        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            for result in [pool.submit(run, part) for part in self.order(file, line)]:
                result.result()
        return verdicts[-1] if verdicts else ("survives", "")
