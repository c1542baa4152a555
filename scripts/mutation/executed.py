"""Which lines each part of the tests executes (all lines of the functions that it executes):
scripts/coverage records it, and the random faults choose their parts by it.

    executed.py PROGRAM FOLDER CHOSEN   runs each part of PROGRAM (a build with --coverage) that is
                                        chosen, merges the counters into the build, and writes
                                        FOLDER/executed.json: part to file to a bit mask of lines

The counters of a part are written below a folder of its own (GCOV_PREFIX), also by the programs
that it starts. Formats: gcov-io.h of GCC 12, whose lengths are bytes.
"""
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys

FUNCTION, LINES, ARC_COUNTS = 0x01000000, 0x01450000, 0x01A10000


def records(data):
    """(tag, length, offset of the content) of each record; a negative length has no content."""
    at = 16 if data[:4] == b"adcg" else 16 + 4 + struct.unpack_from("<I", data, 16)[0] - 0
    if data[:4] == b"oncg":  # working directory, and a flag for blocks that are not executed
        at += 4
    while at + 8 <= len(data):
        tag, length = struct.unpack_from("<Ii", data, at)
        if tag == 0:
            break
        yield tag, length, at + 8
        at += 8 + max(length, 0)


def text(data, at):
    """A string, and the offset behind it."""
    size = struct.unpack_from("<I", data, at)[0]
    return data[at + 4:at + 4 + size].rstrip(b"\0").decode(), at + 4 + size


class Object:
    """The functions of one object file: identity to its lines, inlined ones included, as a bit mask
    for each file."""

    def __init__(self, note, root):
        data, self.of, lines = note.read_bytes(), {}, {}
        for tag, length, at in records(data):
            if tag == FUNCTION:
                lines = self.of.setdefault(struct.unpack_from("<I", data, at)[0], {})
            elif tag == LINES:
                end, at, file = at + length, at + 4, None
                while at < end:
                    line, at = struct.unpack_from("<I", data, at)[0], at + 4
                    if line:
                        lines[file] = lines.get(file, 0) | 1 << line
                        continue
                    file, at = text(data, at)
                    file = os.path.relpath(os.path.normpath(os.path.join(root, file)), root)
        for lines in self.of.values():
            for file in [file for file in lines if file.startswith(("..", "build/", "verification/"))]:
                del lines[file]

    def executed(self, counts):
        """The lines of the functions with a counter that is not zero."""
        data, ident = counts.read_bytes(), 0
        for tag, length, at in records(data):
            if tag == FUNCTION:
                ident = struct.unpack_from("<I", data, at)[0] if length > 0 else 0
            elif tag == ARC_COUNTS and length > 0 and ident in self.of:
                if any(struct.unpack_from(f"<{length // 8}q", data, at)):
                    yield from self.of[ident].items()


def parts_of(program, chosen):
    listed = subprocess.run([program, "-#", "--list-tags", chosen], capture_output=True, text=True).stdout
    return re.findall(r"\[#(.*)\]$", listed, re.M)


def run(program, part, chosen, folder):
    prefix = folder / "parts" / part
    shutil.rmtree(prefix, ignore_errors=True)
    environment = dict(os.environ, GCOV_PREFIX=str(prefix))
    subprocess.run([program, "-#", f"[#{part}]{chosen}"], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return prefix


def main(program, folder, chosen):
    program, folder, root = pathlib.Path(program).resolve(), pathlib.Path(folder).resolve(), pathlib.Path.cwd()
    objects = {note.with_suffix(""): Object(note, root) for note in folder.rglob("*.gcno")}
    by_part = {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        parts = parts_of(program, chosen)
        for part, prefix in zip(parts, pool.map(lambda part: run(program, part, chosen, folder), parts)):
            found = {}
            for counts in prefix.rglob("*.gcda"):
                note = pathlib.Path("/") / counts.relative_to(prefix).with_suffix("")
                if note in objects:
                    for file, lines in objects[note].executed(counts):
                        found[file] = found.get(file, 0) | lines
            by_part[part] = {file: f"{lines:x}" for file, lines in sorted(found.items())}
            own = pathlib.Path(f"{prefix}{folder}")
            if own.exists():
                subprocess.run(["gcov-tool", "merge", own, folder, "-o", folder], check=True, stderr=subprocess.DEVNULL)
            shutil.rmtree(prefix, ignore_errors=True)
            print(f"{part}: {sum(lines.bit_count() for lines in found.values())} lines in {len(found)} files", flush=True)
    (folder / "executed.json").write_text(json.dumps(by_part))


if __name__ == "__main__":
    main(*sys.argv[1:])
