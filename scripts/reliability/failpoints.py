#!/usr/bin/env python3
"""Kills a run and a resumed run at every call that changes a file, and fills the disk at many of them.

    scripts/reliability/failpoints.py [--only run|resume] [--every N] [--full N] [--sphecs PROGRAM]

Needs a C compiler on Linux. For each call of a short run with a checkpoint at every step, the process is killed before
it, after it, or in the middle of a write. `sphecs info` must read the remaining files, `sphecs resume` must give the
bytes of an uninterrupted run, and no temporary file may be left. With a full disk the exit code must be 4 and the
message must name a path; with more space the run must resume as after a kill. Ends at the first failure and prints the
number of points. Results are in docs/RELIABILITY.md.
"""

import argparse
import filecmp
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ["particles.nc", "monitor.nc", "monitor.csv", "probes.nc", "probes_points.csv"]
RESULTS += [f"probes/{name}.csv" for name in ("inlet", "gap", "axis")]
KILLED, NO_SPACE = -9, 4
# A frame every second step, a row and a checkpoint at every step.
SCENE = ["scenes/quickstart.ron", "--smoke", "--threads", "1", "--quiet"]
SCENE += ["--set", "output.every=0.004", "--set", "output.checkpoint_every=1e-9"]
STEPS = 4


class Trial:
    """A program, its working folder and the results of an uninterrupted run."""

    def __init__(self, program, work):
        self.program = str(program)
        self.work = Path(work)
        self.out = self.work / "run"
        self.shim = self.work / "shim.so"
        source = Path(__file__).with_name("shim.c")
        subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", self.shim, source, "-ldl"], check=True)
        self.begin = ["run", *SCENE, "--steps", str(STEPS), "--out", str(self.out)]
        self.resume = ["resume", str(self.out), "--quiet", "--steps", str(STEPS)]
        whole = self.work / "whole"
        self.sphecs(["run", *SCENE, "--steps", str(STEPS), "--out", str(whole)], 0)
        self.whole = whole

    def sphecs(self, arguments, code=None, at=0, how="", count=None):
        """Runs the program and returns its result. Fails unless its exit code is `code`."""
        environment = dict(os.environ)
        if at or count:
            environment |= {"LD_PRELOAD": str(self.shim), "FAIL_UNDER": f"{self.out.parent}/"}
            environment |= {"FAIL_AT": str(at), "FAIL_HOW": how}
            if count:
                environment["FAIL_COUNT"] = str(count)
        done = subprocess.run(
            [self.program, *arguments], cwd=ROOT, env=environment, capture_output=True, text=True
        )
        if code is not None and done.returncode != code:
            sys.exit(f"{how} {at}: {arguments[0]} ended with {done.returncode}, not {code}\n{done.stderr}")
        return done

    def count(self, prepare, command):
        """Returns the number of calls that a command makes."""
        prepare()
        path = self.work / "count"
        self.sphecs(command, 0, count=path)
        return int(path.read_text())

    def clear(self):
        """Removes all runs."""
        for entry in self.work.glob(".*run*"):
            shutil.rmtree(entry)
        shutil.rmtree(self.out, ignore_errors=True)

    def half(self):
        """Leaves a run that was stopped halfway."""
        self.clear()
        self.sphecs(["run", *SCENE, "--steps", str(STEPS // 2), "--out", str(self.out)], 0)

    def finish(self, what):
        """Resumes the run to its end and compares the results."""
        if self.out.exists():
            self.sphecs(["info", str(self.out)], 0)
            self.sphecs(self.resume, 0)
        else:
            self.sphecs(self.begin, 0)
        for name in RESULTS:
            if not filecmp.cmp(self.whole / name, self.out / name, shallow=False):
                sys.exit(f"{what}: {name} differs")
        wanted = {entry.name for entry in self.whole.iterdir()}
        strays = [entry.name for entry in self.out.iterdir() if entry.name not in wanted]
        strays += [entry.name for entry in self.out.rglob("*.partial")]
        strays += [entry.name for entry in self.work.glob(".run*")]
        if strays:
            sys.exit(f"{what}: left over: {strays}")

    def kill_at_each(self, name, prepare, command, every):
        calls = self.count(prepare, command)
        tried = 0
        for how in ("before", "after", "torn"):
            for at in range(1, calls + 1, every):
                prepare()
                # Only a write can be torn; torn elsewhere equals after.
                self.sphecs(command, KILLED, at=at, how=how)
                self.finish(f"{name} killed {how} call {at} of {calls}")
                tried += 1
            print(f"{name}: {calls} calls, every {every}: killed {how}: identical bytes, nothing left over", flush=True)
        return tried

    def fill_at_many(self, name, prepare, command, points):
        calls = self.count(prepare, command)
        tried = 0
        for at in range(1, calls + 1, max(1, calls // points)):
            prepare()
            what = f"{name} with a full disk from call {at} of {calls}"
            done = self.sphecs(command, at=at, how="full")
            if done.returncode == 0:
                # Every call precedes the last result, so a failure must be reported.
                sys.exit(f"{what}: exit code 0")
            if done.returncode != NO_SPACE or str(self.out.parent) not in done.stderr.replace("\n", ""):
                sys.exit(f"{what}: ended with {done.returncode}\n{done.stderr}")
            self.finish(what)
            tried += 1
        print(f"{name}: disk full at {tried} of {calls} calls: code 4, then identical bytes", flush=True)
        return tried


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--every", type=int, default=1, help="kill only at every N-th call")
    parser.add_argument("--full", type=int, default=40, help="approximate number of calls at which the disk fills up")
    parser.add_argument("--only", choices=["run", "resume"], help="only the run, or only the resumed run")
    parser.add_argument("--sphecs", type=Path, default=ROOT / "target/debug/sphecs", help="path of the program")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as work:
        trial = Trial(options.sphecs.resolve(), work)
        steps = [("run", trial.clear, trial.begin), ("resume", trial.half, trial.resume)]
        steps = [step for step in steps if options.only in (None, step[0])]
        filled = sum(trial.fill_at_many(*step, options.full) for step in steps)
        killed = sum(trial.kill_at_each(*step, options.every) for step in steps)
    print(f"killed {killed} times, disk full {filled} times: no byte differs, nothing left over")


if __name__ == "__main__":
    main()
