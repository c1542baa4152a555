"""Builds a copy of the project with a fault and judges it: claims and tests in groups, the cheapest first."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import time
import xml.etree.ElementTree

FILES = ["CMakeLists.txt", "CMakePresets.json"]
FOLDERS = ["src", "formulations", "plots", "verification", "cases", "scripts", "docs"]
# Not run: maps that take an hour. [library] builds a program of a user against the installed library.
TESTS = "~[extremes]~[strangers]~[library]"
GROUPS = [0.5, 2, 10, 60, float("inf")]  # s: a group ends where its tests take longer, each alone


def path_matters(name):
    """Whether what is built or judged may depend on a file; pages are read by tests, but their words decide nothing."""
    return not name.endswith(".md")


class Copy:
    """A copy of the sources with a build of its own, whose objects without a fault are kept aside."""

    def __init__(self, root, place):
        self.root, self.place = pathlib.Path(root), pathlib.Path(place)
        self.tree, self.kept = self.place / "tree", self.place / "kept"
        self.built = self.tree / "build" / "release"
        self.log, self.planted = self.place / "build.log", self.place / "planted"  # the file with a fault in it

    def take(self):
        """The sources as they stand, files that are the same left alone so that little is built; true where one differs."""
        listed = subprocess.run(["git", "ls-files", "-z", *FILES, *FOLDERS], cwd=self.root, capture_output=True, check=True).stdout
        names = {n for n in listed.decode().split("\0") if n and (self.root / n).is_file() and not n.startswith("scripts/mutation")}
        changed = False
        for name in names:
            to = self.tree / name
            if not to.exists() or to.read_bytes() != (self.root / name).read_bytes():
                to.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(self.root / name, to)
                shutil.copymode(self.root / name, to)
                changed = changed or path_matters(name)
        for folder in FOLDERS:
            for path in (self.tree / folder).rglob("*"):
                if path.is_file() and str(path.relative_to(self.tree)) not in names:
                    path.unlink()
                    changed = changed or path_matters(str(path))
        return changed

    def build(self, *targets):
        with open(self.log, "w") as log:
            if not (self.built / "build.ninja").exists():
                if subprocess.run(["cmake", "--preset", "release"], cwd=self.tree, stdout=log, stderr=log).returncode:
                    return False
            return subprocess.run(["cmake", "--build", self.built, "--target", *targets], stdout=log, stderr=log).returncode == 0

    def stamps(self):
        found = {}
        for folder, _, names in os.walk(self.built):
            for name in names:
                path = os.path.join(folder, name)
                if not (os.path.relpath(path, self.built).startswith("test-") or name.endswith(".gch")):
                    state = os.stat(path)
                    found[os.path.relpath(path, self.built)] = [state.st_mtime_ns, state.st_size]
        return found

    def keep(self):
        """Keeps what is built now."""
        shutil.rmtree(self.kept, ignore_errors=True)
        before = self.stamps()
        for name in before:
            (self.kept / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(self.built / name, self.kept / name)
        (self.place / "kept.json").write_text(json.dumps(before))

    def put_back(self):
        """Sources and objects as without a fault, so that nothing is built again."""
        before = json.loads((self.place / "kept.json").read_text())
        now = self.stamps()
        for name, state in before.items():
            if now.get(name) != state:
                shutil.copy2(self.kept / name, self.built / name)
        for name in now.keys() - before.keys():
            (self.built / name).unlink(missing_ok=True)
        if self.planted.exists():  # also where an earlier run was interrupted
            name = self.planted.read_text()
            shutil.copyfile(self.root / name, self.tree / name)
            time_then = json.loads((self.place / "times.json").read_text())[name]
            os.utime(self.tree / name, ns=(time_then, time_then))
            self.planted.unlink()

    def keep_times(self):
        times = {str(p.relative_to(self.tree)): p.stat().st_mtime_ns
                 for folder in FOLDERS for p in (self.tree / folder).rglob("*") if p.is_file()}
        (self.place / "times.json").write_text(json.dumps(times))

    def plant(self, fault):
        self.planted.write_text(fault.file)
        path = self.tree / fault.file
        lines = path.read_text().split("\n")
        assert lines[fault.line - 1] == fault.old, f"{fault.file}:{fault.line} is another line now"
        lines[fault.line - 1] = fault.new
        path.write_text("\n".join(lines))

    def same_objects(self):
        """Whether the compiler made of it what it made without the fault (but for the hash of the sources)."""
        before = json.loads((self.place / "kept.json").read_text())
        return not any(name.endswith(".o") and "identity" not in name and before.get(name) != state and
                       (self.built / name).read_bytes() != (self.kept / name).read_bytes()
                       for name, state in self.stamps().items())


def run(command, cwd, limit, log):
    """Exit status (None: not ended within the limit, negative: a signal) and seconds."""
    began = time.monotonic()
    with open(log, "w") as out:
        child = subprocess.Popen(command, cwd=cwd, stdout=out, stderr=out, stdin=subprocess.DEVNULL, start_new_session=True)
        try:
            status = child.wait(limit)
        except subprocess.TimeoutExpired:
            os.killpg(child.pid, 9)  # what it started, too
            child.wait()
            status = None
    return status, time.monotonic() - began


class Suite:
    """The claims' sets and the tests, in groups by what they cost without a fault."""

    def __init__(self, copy):
        self.copy, self.file, self.log = copy, copy.place / "costs.json", copy.place / "judged.log"

    def tests(self):
        listed = subprocess.run([self.copy.built / "freeplay-tests", "--list-test-names-only", TESTS], capture_output=True,
                                text=True).stdout
        return [line.strip() for line in listed.split("\n") if line.strip()]

    def sets(self):
        said = subprocess.run([self.copy.built / "freeplay", "verify", "?"], capture_output=True, text=True).stderr
        return said[said.index("there is: ") + len("there is: "):].replace(",", " ").split()

    def measure(self):
        """Every set and test without a fault; what fails then can judge nothing, and is named."""
        costs = {"sets": {}, "tests": {}, "failing": []}
        for name in self.sets():
            status, seconds = run([self.copy.built / "freeplay", "verify", name, "-o", self.copy.place / "out"], self.copy.tree,
                                  None, self.log)
            costs["sets" if status == 0 else "failing"] |= {name: seconds} if status == 0 else []
            if status != 0:
                costs["failing"].append(f"verify {name}")
        report = self.copy.place / "tests.xml"
        run([self.copy.built / "freeplay-tests", TESTS, "-d", "yes", "-r", "xml", "-o", report], self.copy.tree, None, self.log)
        for case in xml.etree.ElementTree.parse(report).iter("TestCase"):
            result = case.find("OverallResult")
            if result.get("success") == "true":
                costs["tests"][case.get("name")] = float(result.get("durationInSeconds"))
            else:
                costs["failing"].append(case.get("name"))
        self.file.write_text(json.dumps(costs, indent=1, ensure_ascii=False))
        return costs

    def groups(self):
        """(what, command, seconds without a fault, how many judge: a set has some ten claims), the cheapest judges first."""
        costs = json.loads(self.file.read_text())
        found, low = [], 0
        for n, high in enumerate(GROUPS):
            names = [t for t, s in costs["tests"].items() if low <= s < high]
            if names:
                listed = self.copy.place / f"tests-{n}.txt"
                listed.write_text("".join(re.sub(r'([,\[\]\\"])', r"\\\1", t) + "\n" for t in names))
                found.append(("tests", ["freeplay-tests", "--abort", "-f", listed], sum(costs["tests"][t] for t in names), len(names)))
            low = high
        found += [("claims", ["freeplay", "verify", s, "-o", self.copy.place / "out"], seconds, 10)
                  for s, seconds in costs["sets"].items()]
        return sorted(found, key=lambda g: g[2] / g[3])

    def judge(self, kind, crash=None):
        """(how, by what) by the claims or the tests: how is claims, tests, time, crash (nothing but crashes, `crash` one before) or
        survives."""
        for what, command, seconds, _ in self.groups():
            if what != kind:
                continue
            status, _ = run([self.copy.built / command[0], *command[1:]], self.copy.tree, 60 + 5 * seconds, self.log)
            text = self.log.read_text(errors="replace")
            if status is None:
                return "time", f"{command[2] if what == 'claims' else 'tests'} after {60 + 5 * seconds:.0f} s"
            if status == 0:
                continue
            if status < 0 or "fatal error condition" in text:
                crash = crash or f"{what}: signal {-status if status < 0 else 'in a test'}"
                continue  # whether something judges it, too
            if what == "claims":
                first = re.search(r"^  FAILS (.*)", text, re.M)
                return "claims", f"{command[2]}: {first[1].strip() if first else text.strip().splitlines()[-1]}"
            first = re.search(r"^-{20,}\n(.*?)(?:\n|$)", text, re.M)
            return "tests", first[1].strip() if first else text.strip().splitlines()[-1]
        return ("crash", crash) if crash else ("survives", "")
