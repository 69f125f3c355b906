#!/usr/bin/env python3
"""Kills a run, and one gone on with, at every call that changes a file, and fills its disk at many of them.

    scripts/reliability/failpoints.py [--only run|resume] [--every N] [--full N] [--sphecs PROGRAM]

Needs a C compiler on Linux. For each call of a short run with a checkpoint at every step: the process is killed before it, behind it, or in
the middle of a write; `sphecs info` must read what is left, `sphecs resume` must go on to the same bytes as a run without a break, and
nothing may be left over. With a full disk the exit code must be 4, the message must name a path, and the same must hold once there is
room. Ends at the first point that fails, and prints how many were tried. Figures of it stand in docs/RELIABILITY.md.
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
RESULTS = ["particles.nc", "monitor.nc", "monitor.csv", "probes.nc", "probes.csv"]
KILLED, NO_ROOM = -9, 4
# A frame every second step, a row and a checkpoint at every step.
SCENE = ["scenes/quickstart.ron", "--smoke", "--threads", "1", "--quiet"]
SCENE += ["--set", "output.every=0.004", "--set", "output.checkpoint_every=1e-9"]
STEPS = 4


class Trial:
    """One program, one folder to work in, and what a run without a break gives."""

    def __init__(self, program, work):
        self.program = str(program)
        self.work = Path(work)
        self.out = self.work / "run"
        self.shim = self.work / "shim.so"
        source = Path(__file__).with_name("shim.c")
        subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", self.shim, source, "-ldl"], check=True)
        self.begin = ["run", *SCENE, "--steps", str(STEPS), "--out", str(self.out)]
        self.go_on = ["resume", str(self.out), "--quiet", "--steps", str(STEPS)]
        whole = self.work / "whole"
        self.sphecs(["run", *SCENE, "--steps", str(STEPS), "--out", str(whole)], 0)
        self.whole = whole

    def sphecs(self, arguments, code=None, at=0, how="", count=None):
        """Runs the program; its result. Fails if it ends with another code than `code`."""
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
        """Calls that a command makes."""
        prepare()
        path = self.work / "count"
        self.sphecs(command, 0, count=path)
        return int(path.read_text())

    def nothing(self):
        for entry in self.work.glob(".*run*"):
            shutil.rmtree(entry)
        shutil.rmtree(self.out, ignore_errors=True)

    def half(self):
        """A run that was stopped half way."""
        self.nothing()
        self.sphecs(["run", *SCENE, "--steps", str(STEPS // 2), "--out", str(self.out)], 0)

    def finish(self, what):
        """Goes on to the end, and compares."""
        if self.out.exists():
            self.sphecs(["info", str(self.out)], 0)
            self.sphecs(self.go_on, 0)
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
                # A write is torn, any other call is as if it were killed behind it: once is enough.
                self.sphecs(command, KILLED, at=at, how=how)
                self.finish(f"{name} killed {how} call {at} of {calls}")
                tried += 1
            print(f"{name}: {calls} calls, every {every}: killed {how}: same bytes, nothing left over", flush=True)
        return tried

    def fill_at_many(self, name, prepare, command, points):
        calls = self.count(prepare, command)
        tried = 0
        for at in range(1, calls + 1, max(1, calls // points)):
            prepare()
            what = f"{name} with a full disk from call {at} of {calls}"
            done = self.sphecs(command, at=at, how="full")
            if done.returncode == 0:
                # Only what comes behind the last result may fail without a word: there is none.
                sys.exit(f"{what}: nobody was told")
            if done.returncode != NO_ROOM or str(self.out.parent) not in done.stderr.replace("\n", ""):
                sys.exit(f"{what}: ended with {done.returncode}\n{done.stderr}")
            self.finish(what)
            tried += 1
        print(f"{name}: disk full at {tried} of {calls} calls: code 4, then the same bytes", flush=True)
        return tried


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--every", type=int, default=1, help="kill at every N-th call only")
    parser.add_argument("--full", type=int, default=40, help="calls from which the disk is full, about")
    parser.add_argument("--only", choices=["run", "resume"], help="only the run, or only the one gone on with")
    parser.add_argument("--sphecs", type=Path, default=ROOT / "target/debug/sphecs", help="the program")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as work:
        trial = Trial(options.sphecs.resolve(), work)
        steps = [("run", trial.nothing, trial.begin), ("resume", trial.half, trial.go_on)]
        steps = [step for step in steps if options.only in (None, step[0])]
        filled = sum(trial.fill_at_many(*step, options.full) for step in steps)
        killed = sum(trial.kill_at_each(*step, options.every) for step in steps)
    print(f"killed {killed} times, disk full {filled} times: no byte differs, nothing left over")


if __name__ == "__main__":
    main()
