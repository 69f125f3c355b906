#!/usr/bin/env python3
"""Long version of the restart and resume tests, through the program only.

    scripts/reliability/reliability.py [--only PART …] [--kills 200] [--signals 50] [--disks 20] [--damages 700] [--sphecs PROGRAM]

Parts: threads    every shipped scene with 1, 2, 3, 4 and 8 threads: identical results
       restarts   every shipped scene stopped at three steps and resumed with other numbers of threads
       kills      kill −9 at a random moment, resumed until done
       signals    SIGINT, SIGTERM or SIGUSR1 at a random moment, resumed until done
       disks      a file system that fills up, then gets more space: resumed until done (as root, which may mount)
       damages    the last checkpoint with flipped bytes, cut, empty, of another scene or version: the previous one is used
       ledger     ten flow-throughs with backflow: counts exact, mass to 1e-12
Fails at the first byte that differs. Results are in docs/RELIABILITY.md.
"""

import argparse
import csv
import os
import random
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

from trials import QUICK, ROOT, SCENES, ends, fail, same, summary

STEPS = 200
SEED = 20
EXIT_CODE_OF_SIGNAL = {signal.SIGINT: 130, signal.SIGTERM: 143}

# Scene, replaced values and end time, s: ten passages of the flow, with backflow at outlet and inlet in the first three.
LEDGER = [
    ("quickstart", ["fluid.viscosity=2.0e-6"], 20.0),
    ("constricted_r2", ["spacing=2.22e-3"], 20.0),
    ("constricted_r1", ["spacing=2.22e-3"], 20.0),
    ("kelvin_helmholtz", ["spacing=1.0e-2"], 4.0),
]


class Driver:
    def __init__(self, program, work):
        self.program, self.work = program, Path(work)
        self.random = random.Random(SEED)

    def output_intervals(self, scene, steps=1.3):
        """Returns options for a frame every `steps` steps and more frequent rows, for any time step of the scene."""
        out = self.work / "output_intervals"
        ends(self.program, ["run", scene, "--smoke", "-q", "--steps", "20", "--force", "--out", out])
        reached = summary(out)["time"]
        return ["--set", f"output.every={steps / 20 * reached:.6e}", "--set", f"output.monitor_every={0.285 * steps / 20 * reached:.6e}"]

    def run(self, scene, out, *more, code=0):
        return ends(self.program, ["run", scene, "--smoke", "-q", "--force", "--out", out, *more], code, str(scene))

    def resume(self, out, *more, code=0):
        return ends(self.program, ["resume", out, *more], code, "resume")

    def threads(self, _options):
        for scene in SCENES:
            output_intervals = self.output_intervals(scene)
            one, many = self.work / "one", self.work / "many"
            self.run(scene, one, *output_intervals, "--steps", STEPS, "--threads", 1)
            for threads in (2, 3, 4, 8):
                self.run(scene, many, *output_intervals, "--steps", STEPS, "--threads", threads)
                same(one, many, f"{scene.name} with {threads} threads")
        return f"{len(SCENES)} scenes with 1, 2, 3, 4 and 8 threads, {STEPS} steps: one result each"

    def restarts(self, _options):
        tried = 0
        for scene in SCENES:
            output_intervals = self.output_intervals(scene)
            whole, pieces = self.work / "whole", self.work / "pieces"
            self.run(scene, whole, *output_intervals, "--steps", STEPS, "--threads", 2)
            for cut in (37, 101, 163):
                self.run(scene, pieces, *output_intervals, "--steps", cut, "--threads", 1)
                self.resume(pieces, "-q", "--steps", STEPS, "--threads", 3)
                same(whole, pieces, f"{scene.name} cut at step {cut}")
                tried += 1
        return f"{tried} restarts of {len(SCENES)} scenes: 0 bytes differ"

    def interrupt(self, wanted, strike):
        """Interrupts long runs by `strike`, `wanted` times in all; returns the number of strikes and runs."""
        steps = ["--steps", "2000"]
        output_intervals = self.output_intervals(QUICK, steps=33)
        whole, broken = self.work / "whole", self.work / "broken"
        self.run(QUICK, whole, *output_intervals, *steps)
        often = ["--checkpoint-every", "0.1s"]
        begin = [self.program, "run", QUICK, "--smoke", "-q", *output_intervals, *steps, *often, "--out", broken]
        resume = [self.program, "resume", broken, "-q", *often]
        strikes = runs = 0
        while strikes < wanted:
            shutil.rmtree(broken, ignore_errors=True)
            longest = 0.9
            while True:
                command = resume if broken.exists() else begin
                process = subprocess.Popen([str(word) for word in command], cwd=ROOT, stderr=subprocess.PIPE)
                time.sleep(self.random.uniform(0.02, longest))
                # On a busy machine work that is lost when interrupted, such as packing, would never finish.
                longest *= 1.1
                done = strike(process)
                strikes += 0 if done else 1
                if done:
                    break
                # The folder must be readable at any moment.
                if broken.exists():
                    ends(self.program, ["info", broken], 0, "info")
            same(whole, broken, f"after {strikes} interruptions")
            runs += 1
        return f"{strikes} in {runs} runs: 0 bytes differ at their ends"

    def kills(self, options):
        def strike(process):
            process.kill()
            _, errors = process.communicate()
            if process.returncode not in (0, -signal.SIGKILL):
                fail(f"kills: ended with {process.returncode}\n{errors.decode()}")
            return process.returncode == 0

        return "kills: " + self.interrupt(options.kills, strike)

    def signals(self, options):
        longest = 0.0

        def strike(process):
            nonlocal longest
            which = self.random.choice([signal.SIGINT, signal.SIGTERM, signal.SIGUSR1])
            sent = time.monotonic()
            process.send_signal(which)
            if which == signal.SIGUSR1:
                # SIGUSR1 does not stop the run: end it with SIGTERM.
                time.sleep(0.05)
                which, sent = signal.SIGTERM, time.monotonic()
                process.send_signal(which)
            _, errors = process.communicate()
            longest = max(longest, time.monotonic() - sent)
            # A signal before the handlers are installed ends the process by default.
            if process.returncode not in (0, EXIT_CODE_OF_SIGNAL[which], -which, -signal.SIGUSR1):
                fail(f"signals: {which} ended with {process.returncode}\n{errors.decode()}")
            return process.returncode == 0

        result = self.interrupt(options.signals, strike)
        return f"signals: {result}; the slowest exit took {longest:.2f} s"

    def disks(self, options):
        """Runs on a tmpfs of each size, up to three times the size of the finished run."""
        if os.geteuid() != 0:
            fail("disks: only root may mount a file system")
        output_intervals = self.output_intervals(QUICK)
        steps = ["--steps", "150", "--threads", "1", "--checkpoint-every", "0.05s"]
        whole, mounted = self.work / "whole", self.work / "mounted"
        self.run(QUICK, whole, *output_intervals, *steps)
        needed = 3 * sum(path.stat().st_size for path in whole.rglob("*") if path.is_file())
        full = 0
        for number in range(options.disks):
            mounted.mkdir()
            size = int(needed * (number + 1) / options.disks)
            subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", mounted], check=True)
            try:
                out = mounted / "run"
                words = ["run", QUICK, "--smoke", "-q", "--allow-oversize", "--out", out, *output_intervals, *steps]
                said = ends(self.program, words, None)
                if said.returncode not in (0, 4):
                    fail(f"disk of {size} B: ended with {said.returncode}\n{said.stderr}")
                if said.returncode == 4:
                    full += 1
                    message = said.stderr.replace("\n", " ")
                    if str(mounted) not in "".join(message.split()) or not any(word in message for word in ("No space left", "are free")):
                        fail(f"disk of {size} B: the message does not name it\n{said.stderr}")
                    if out.exists():
                        ends(self.program, ["info", out], 0, "info")
                subprocess.run(["mount", "-o", f"remount,size={4 * needed}", mounted], check=True)
                checkpoints = list(out.glob("checkpoints/*.checkpoint"))
                if checkpoints:
                    self.resume(out, "-q")
                else:
                    self.run(QUICK, out, *output_intervals, *steps)
                same(whole, out, f"disk of {size} B")
            finally:
                subprocess.run(["umount", mounted], check=True)
                mounted.rmdir()
        return f"disks: {options.disks} of {needed // options.disks} to {needed} B, {full} of them full: each reported, 0 bytes differ afterwards"

    def damages(self, options):
        intact, damaged, foreign = self.work / "intact", self.work / "damaged", self.work / "foreign"
        output_intervals = self.output_intervals(QUICK)
        whole = self.work / "whole"
        self.run(QUICK, whole, *output_intervals, "--steps", 60, "--threads", 1)
        self.run(QUICK, intact, *output_intervals, "--steps", 30, "--threads", 1)
        self.resume(intact, "-q", "--steps", 50)
        self.run(ROOT / "scenes/taylor_green.ron", foreign, "--steps", 50)
        foreign_checkpoint = sorted((foreign / "checkpoints").iterdir())[-1].read_bytes()
        for number in range(options.damages):
            shutil.rmtree(damaged, ignore_errors=True)
            shutil.copytree(intact, damaged)
            last = sorted((damaged / "checkpoints").iterdir())[-1]
            content = bytearray(last.read_bytes())
            kind = ["flipped", "flipped", "flipped", "cut", "longer", "empty", "foreign"][number % 7]
            if kind == "flipped":
                for _ in range(self.random.randint(1, 8)):
                    content[self.random.randrange(len(content))] ^= self.random.randint(1, 255)
            elif kind == "cut":
                del content[self.random.randrange(len(content)) :]
            elif kind == "longer":
                content += self.random.randbytes(self.random.randint(1, 4096))
            elif kind == "empty":
                content.clear()
            else:
                content = foreign_checkpoint
            if bytes(content) == last.read_bytes():
                continue
            last.write_bytes(content)
            said = self.resume(damaged, "--steps", 60, "--threads", 1)
            output = (said.stdout + said.stderr).replace("\n", " ")
            # The message names the damaged checkpoint and the step of the one that is used instead.
            if last.name not in output or "step 30" not in output:
                fail(f"damage {number}, {kind}: the message does not name it\n{output}")
            same(whole, damaged, f"damage {number}, {kind}")
        return f"{options.damages} damaged checkpoints: all named, the previous one used, 0 bytes differ"

    def ledger(self, _options):
        lines = []
        for name, sets, until in LEDGER:
            out = self.work / "ledger"
            words = [word for set_ in sets for word in ("--set", set_)]
            ends(self.program, ["run", ROOT / f"scenes/{name}.ron", "-q", "--force", "--out", out, "--until", until, *words])
            facts = summary(out)
            ledger = facts["ledger"]
            with open(out / "monitor.csv", newline="") as table:
                rows = list(csv.DictReader(table))
            zones = ["fluid", "wall", "inflow", "outflow", "reservoir"]
            for row in rows:
                counts = [int(row[f"count_{zone} [1]"]) for zone in zones]
                if sum(counts) - ledger["initial"] not in range(ledger["grown"] + ledger["created"] + 1):
                    fail(f"ledger: {name}: {sum(counts)} particles at t = {row['time [s]']} s")
                masses = [float(row[next(key for key in row if key.startswith(f"mass_{zone} "))]) for zone in zones]
                each = [mass / count for mass, count in zip(masses, counts) if count]
                if max(each) / min(each) - 1 > 1e-12:
                    fail(f"ledger: {name}: particle masses differ: {each}")
            if not ledger["balances"]:
                fail(f"ledger: {name}: does not balance: {ledger}")
            lines.append(
                f"{name} to {facts['time']:.3g} s: {ledger['entered']} in, {ledger['entered_back']} back, "
                f"{ledger['left']} out, {ledger['left_back']} back, {len(rows)} rows"
            )
        return "ledger: counts exact, mass to 1e-12; " + "; ".join(lines)


PARTS = [Driver.threads, Driver.restarts, Driver.kills, Driver.signals, Driver.disks, Driver.damages, Driver.ledger]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    names = [part.__name__ for part in PARTS]
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="PART", help="run these parts")
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--signals", type=int, default=50)
    parser.add_argument("--disks", type=int, default=20)
    parser.add_argument("--damages", type=int, default=700)
    parser.add_argument("--sphecs", type=Path, default=ROOT / "target/debug/sphecs", help="path of the program")
    options = parser.parse_args()
    for part in PARTS:
        if part.__name__ in options.only:
            with tempfile.TemporaryDirectory() as work:
                print(part(Driver(options.sphecs.resolve(), work), options), flush=True)


if __name__ == "__main__":
    main()
