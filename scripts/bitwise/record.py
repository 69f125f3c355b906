#!/usr/bin/env python3
"""Runs the cases of cases.py with a build of sphecs and writes the manifest of their results.

Started by record.sh.
"""

import argparse
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cases
import digest

ROOT = Path(__file__).resolve().parents[2]
# Exit codes of the program that say something about a flow: done, refused, diverged, failed.
EXPECTED_CODES = (0, 2, 3, 4)
# Longest time of one run, s.
LONGEST = 3600


def instruction_sets() -> list[str]:
    """The values of SPHECS_LANES that this machine has, the widest last."""
    sets = ["portable"]
    flags = set()
    try:
        processor = Path("/proc/cpuinfo").read_text()
        flags = set(re.search(r"^flags\s*:(.*)$", processor, re.MULTILINE).group(1).split())
    except (OSError, AttributeError):
        print("this machine does not tell its instruction sets: portable alone is recorded", file=sys.stderr)
    # As the program looks for them; the kernel calls lzcnt `abm`.
    if {"avx2", "fma", "bmi1", "bmi2", "popcnt", "abm"} <= flags:
        sets.append("avx2")
        if {"avx512f", "avx512dq", "avx512bw", "avx512vl"} <= flags:
            sets.append("avx512")
    return sets


def copied(binary: Path, folder: Path) -> Path:
    """Copies the program without line tables.

    It reads its own file at each start, and a build may replace the original.
    """
    copy = folder / "sphecs"
    shutil.copy2(binary, copy)
    if shutil.which("strip"):
        subprocess.run(["strip", str(copy)], check=False, capture_output=True)
    return copy


class Recorder:
    """Runs one case after the other and writes the manifest."""

    def __init__(self, arguments, renames, manifest):
        self.arguments, self.renames, self.manifest = arguments, renames, manifest
        self.failures = 0

    def spelled(self, text: str) -> str:
        """A text with the names of this build."""
        for old, new in self.renames.items():
            text = re.sub(rf"(?<![\w-]){re.escape(old)}(?!\w)", new, text)
        return text

    def scene(self, case, scratch: Path) -> Path:
        if not case.scene.startswith("box:"):
            return self.arguments.root / self.spelled(case.scene)
        _, dimensions, count, terms = case.scene.split(":")
        path = scratch / "box.ron"
        path.write_text(self.spelled(cases.box_text(int(dimensions), int(count), terms)), encoding="utf-8")
        return path

    def start(self, words, lanes) -> subprocess.CompletedProcess:
        environment = os.environ | {"SPHECS_LANES": lanes, "LC_ALL": "C"}
        words = [self.spelled(word) for word in words]
        command = [str(self.arguments.binary), *words]
        root = self.arguments.root
        return subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=LONGEST, cwd=root
        )

    def run(self, case, precision, lanes, scratch: Path):
        """Runs a case; its folder and exit code."""
        folder = scratch / "run"
        shutil.rmtree(folder, ignore_errors=True)
        settings = {"precision": precision} | case.settings
        sets = [word for path, value in settings.items() for word in ("--set", f"{path}={value}")]
        threads = ["--threads", str(self.arguments.threads), "--quiet"]
        scene = str(self.scene(case, scratch))
        first = case.resumed_at or case.steps
        where = ["--smoke", "--steps", str(first), "--out", str(folder), "--allow-oversize"]
        done = self.start(["run", scene, *where, *threads, *sets], lanes)
        if case.resumed_at and done.returncode == 0:
            done = self.start(["resume", str(folder), "--steps", str(case.steps), *threads], lanes)
        return folder, done

    def record(self, case, precision, lanes, key):
        begun = time.monotonic()
        with tempfile.TemporaryDirectory(prefix="sphecs-bitwise-") as scratch:
            folder, done = self.run(case, precision, lanes, Path(scratch))
            code = done.returncode
            if code not in EXPECTED_CODES:
                self.failures += 1
                print(f"{key}: ended with {code}\n{done.stdout}{done.stderr}", file=sys.stderr)
            self.line(f"{key} exit", digest.sha256(str(code).encode()), {"code": str(code)})
            for name, sums in digest.run_folder(folder).items():
                short = {column: part[:12] for column, part in sums.items()}
                self.line(f"{key} {name}", digest.combined(sums), short)
        said = "" if code == 0 else f"  exit {code}: {' '.join((done.stderr or done.stdout).split())[:160]}"
        print(f"{time.monotonic() - begun:7.2f} s  {key}{said}", flush=True)

    def line(self, key, total, columns):
        shown = "; ".join(f"{name}={part}" for name, part in columns.items())
        self.manifest.write(f"{key}\t{total}\t{shown}\n")
        self.manifest.flush()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("binary", type=Path, help="release build of sphecs")
    parser.add_argument("manifest", type=Path, help="file to write")
    parser.add_argument("--quick", action="store_true", help="small flows through every part of the engine")
    parser.add_argument("--root", type=Path, default=ROOT, help="checkout that the scenes are taken from")
    parser.add_argument("--only", default="", help="only the runs whose key contains this text")
    parser.add_argument("--threads", type=int, default=2, help="threads of each run")
    rename = {"action": "append", "default": [], "metavar": "NAME=SPELLING"}
    parser.add_argument("--rename", **rename, help="another spelling of a name")
    arguments = parser.parse_args()
    arguments.binary, arguments.root = arguments.binary.resolve(), arguments.root.resolve()
    if not os.access(arguments.binary, os.X_OK):
        sys.exit(f"{arguments.binary}: cannot be run, must be a build of sphecs")
    renames = dict(rename.split("=", 1) for rename in arguments.rename)

    table = cases.quick(arguments.root) if arguments.quick else cases.full(arguments.root)
    sets = instruction_sets()
    runs = []
    for case in table:
        for precision in case.precisions:
            for lanes in sets if case.every_set else sets[-1:]:
                key = f"{case.name}/{precision}/{lanes}/{case.steps}"
                if arguments.only in key:
                    runs.append((case, precision, lanes, key))
    if not runs:
        sys.exit(f"no run has `{arguments.only}` in its key")
    keys = [key for *_, key in runs]
    assert len(set(keys)) == len(keys), "two cases have one key"

    begun = time.monotonic()
    partial = arguments.manifest.with_name(arguments.manifest.name + ".partial")
    temporary = tempfile.TemporaryDirectory(prefix="sphecs-bitwise-")
    with partial.open("w", encoding="utf-8") as manifest, temporary as folder:
        manifest.write(f"# {platform.machine()}, {', '.join(sets)}\n")
        arguments.binary = copied(arguments.binary, Path(folder))
        recorder = Recorder(arguments, renames, manifest)
        for case, precision, lanes, key in runs:
            recorder.record(case, precision, lanes, key)
    # Under its name only when it is whole.
    partial.replace(arguments.manifest)
    print(f"{len(runs)} runs in {time.monotonic() - begun:.0f} s: {arguments.manifest}")
    if recorder.failures:
        sys.exit(f"FAILED: {recorder.failures} runs ended with a code that the program does not give")


if __name__ == "__main__":
    main()
