#!/usr/bin/env python3
"""The long version of tests/restart.rs and tests/resume, through the program alone.

    scripts/reliability/reliability.py [--only PART …] [--kills 200] [--signals 50] [--disks 20] [--damages 700] [--sphecs PROGRAM]

Parts: threads    every shipped scene with 1, 2, 3, 4 and 8 threads: one result
       restarts   every shipped scene stopped at three steps and resumed with other numbers of threads
       kills      kill −9 at a random moment, resumed until done
       signals    SIGINT, SIGTERM or SIGUSR1 at a random moment, resumed until done
       disks      a file system that is full at some moment, then has room: resumed until done (as root, who may mount)
       damages    the last checkpoint with flipped bytes, cut, empty, of another scene or version: the one before is taken
       ledger     ten flow-throughs with backflow: counts exact, mass to 1e-12
Fails at the first byte that differs. Figures of it stand in docs/RELIABILITY.md.
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
OUT_OF_SIGNAL = {signal.SIGINT: 130, signal.SIGTERM: 143}

# Scene, what is changed of it, and the time that it is run to, s: ten passages of the flow, with backflow at outlet and inlet in the first three.
LEDGER = [
    ("quickstart", ["fluid.viscosity=2.0e-6"], 20.0),
    ("constricted_r2", ["spacing=2.22e-3"], 20.0),
    ("constricted_r1", ["spacing=2.22e-3"], 20.0),
    ("kelvin_helmholtz", ["spacing=1.0e-2"], 4.0),
]


class Driver:
    def __init__(self, program, work):
        self.program, self.work = program, Path(work)
        self.chance = random.Random(SEED)

    def rhythm(self, scene, steps=1.3):
        """A frame every so many steps and rows more often, whatever the scene's time step."""
        out = self.work / "rhythm"
        ends(self.program, ["run", scene, "--smoke", "-q", "--steps", "20", "--force", "--out", out])
        reached = summary(out)["time"]
        return ["--set", f"output.every={steps / 20 * reached:.6e}", "--set", f"output.monitor_every={0.285 * steps / 20 * reached:.6e}"]

    def run(self, scene, out, *more, code=0):
        return ends(self.program, ["run", scene, "--smoke", "-q", "--force", "--out", out, *more], code, str(scene))

    def resume(self, out, *more, code=0):
        return ends(self.program, ["resume", out, *more], code, "resume")

    def threads(self, _options):
        for scene in SCENES:
            rhythm = self.rhythm(scene)
            one, many = self.work / "one", self.work / "many"
            self.run(scene, one, *rhythm, "--steps", STEPS, "--threads", 1)
            for threads in (2, 3, 4, 8):
                self.run(scene, many, *rhythm, "--steps", STEPS, "--threads", threads)
                same(one, many, f"{scene.name} with {threads} threads")
        return f"{len(SCENES)} scenes with 1, 2, 3, 4 and 8 threads, {STEPS} steps: one result each"

    def restarts(self, _options):
        tried = 0
        for scene in SCENES:
            rhythm = self.rhythm(scene)
            whole, pieces = self.work / "whole", self.work / "pieces"
            self.run(scene, whole, *rhythm, "--steps", STEPS, "--threads", 2)
            for cut in (37, 101, 163):
                self.run(scene, pieces, *rhythm, "--steps", cut, "--threads", 1)
                self.resume(pieces, "-q", "--steps", STEPS, "--threads", 3)
                same(whole, pieces, f"{scene.name} cut at step {cut}")
                tried += 1
        return f"{tried} restarts of {len(SCENES)} scenes: 0 bytes differ"

    def broken_off(self, wanted, strike):
        """Breaks off one long run after the other by `strike`, until it was done so often; runs that it took."""
        steps = ["--steps", "2000"]
        rhythm = self.rhythm(QUICK, steps=33)
        whole, broken = self.work / "whole", self.work / "broken"
        self.run(QUICK, whole, *rhythm, *steps)
        often = ["--checkpoint-every", "0.1s"]
        begin = [self.program, "run", QUICK, "--smoke", "-q", *rhythm, *steps, *often, "--out", broken]
        go_on = [self.program, "resume", broken, "-q", *often]
        strikes = runs = 0
        while strikes < wanted:
            shutil.rmtree(broken, ignore_errors=True)
            longest = 0.9
            while True:
                command = go_on if broken.exists() else begin
                process = subprocess.Popen([str(word) for word in command], cwd=ROOT, stderr=subprocess.PIPE)
                time.sleep(self.chance.uniform(0.02, longest))
                # On a busy machine what cannot be broken off, as the packing, would never be done.
                longest *= 1.1
                done = strike(process)
                strikes += 0 if done else 1
                if done:
                    break
                # What is there can be read at any moment.
                if broken.exists():
                    ends(self.program, ["info", broken], 0, "info")
            same(whole, broken, f"after {strikes} interruptions")
            runs += 1
        return f"{strikes} in {runs} runs: 0 bytes differ at their ends"

    def kills(self, options):
        def strike(process):
            process.kill()
            _, said = process.communicate()
            if process.returncode not in (0, -signal.SIGKILL):
                fail(f"kills: ended with {process.returncode}\n{said.decode()}")
            return process.returncode == 0

        return "kills: " + self.broken_off(options.kills, strike)

    def signals(self, options):
        longest = 0.0

        def strike(process):
            nonlocal longest
            which = self.chance.choice([signal.SIGINT, signal.SIGTERM, signal.SIGUSR1])
            sent = time.monotonic()
            process.send_signal(which)
            if which == signal.SIGUSR1:
                # The run goes on: end it in another way.
                time.sleep(0.05)
                which, sent = signal.SIGTERM, time.monotonic()
                process.send_signal(which)
            _, said = process.communicate()
            longest = max(longest, time.monotonic() - sent)
            # Before the handlers are set a signal ends the process as it ends any other.
            if process.returncode not in (0, OUT_OF_SIGNAL[which], -which, -signal.SIGUSR1):
                fail(f"signals: {which} ended with {process.returncode}\n{said.decode()}")
            return process.returncode == 0

        told = self.broken_off(options.signals, strike)
        return f"signals: {told}; the slowest was out after {longest:.2f} s"

    def disks(self, options):
        """A tmpfs for each size, up to three times what the whole run leaves."""
        if os.geteuid() != 0:
            fail("disks: only root may mount a file system")
        rhythm = self.rhythm(QUICK)
        steps = ["--steps", "150", "--threads", "1", "--checkpoint-every", "0.05s"]
        whole, mounted = self.work / "whole", self.work / "mounted"
        self.run(QUICK, whole, *rhythm, *steps)
        needed = 3 * sum(path.stat().st_size for path in whole.rglob("*") if path.is_file())
        full = 0
        for number in range(options.disks):
            mounted.mkdir()
            size = int(needed * (number + 1) / options.disks)
            subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", mounted], check=True)
            try:
                out = mounted / "run"
                words = ["run", QUICK, "--smoke", "-q", "--allow-oversize", "--out", out, *rhythm, *steps]
                said = ends(self.program, words, None)
                if said.returncode not in (0, 4):
                    fail(f"disk of {size} B: ended with {said.returncode}\n{said.stderr}")
                if said.returncode == 4:
                    full += 1
                    told = said.stderr.replace("\n", " ")
                    if str(mounted) not in "".join(told.split()) or not any(word in told for word in ("No space left", "are free")):
                        fail(f"disk of {size} B: not told\n{said.stderr}")
                    if out.exists():
                        ends(self.program, ["info", out], 0, "info")
                subprocess.run(["mount", "-o", f"remount,size={4 * needed}", mounted], check=True)
                taken_up = list(out.glob("checkpoints/*.checkpoint"))
                if taken_up:
                    self.resume(out, "-q")
                else:
                    self.run(QUICK, out, *rhythm, *steps)
                same(whole, out, f"disk of {size} B")
            finally:
                subprocess.run(["umount", mounted], check=True)
                mounted.rmdir()
        return f"disks: {options.disks} of {needed // options.disks} to {needed} B, {full} of them full: each told, 0 bytes differ behind"

    def damages(self, options):
        sound, hurt, foreign = self.work / "sound", self.work / "hurt", self.work / "foreign"
        rhythm = self.rhythm(QUICK)
        whole = self.work / "whole"
        self.run(QUICK, whole, *rhythm, "--steps", 60, "--threads", 1)
        self.run(QUICK, sound, *rhythm, "--steps", 30, "--threads", 1)
        self.resume(sound, "-q", "--steps", 50)
        self.run(ROOT / "scenes/taylor_green.ron", foreign, "--steps", 50)
        stranger = sorted((foreign / "checkpoints").iterdir())[-1].read_bytes()
        for number in range(options.damages):
            shutil.rmtree(hurt, ignore_errors=True)
            shutil.copytree(sound, hurt)
            last = sorted((hurt / "checkpoints").iterdir())[-1]
            content = bytearray(last.read_bytes())
            kind = ["flipped", "flipped", "flipped", "cut", "longer", "empty", "foreign"][number % 7]
            if kind == "flipped":
                for _ in range(self.chance.randint(1, 8)):
                    content[self.chance.randrange(len(content))] ^= self.chance.randint(1, 255)
            elif kind == "cut":
                del content[self.chance.randrange(len(content)) :]
            elif kind == "longer":
                content += self.chance.randbytes(self.chance.randint(1, 4096))
            elif kind == "empty":
                content.clear()
            else:
                content = stranger
            if bytes(content) == last.read_bytes():
                continue
            last.write_bytes(content)
            said = self.resume(hurt, "--steps", 60, "--threads", 1)
            told = (said.stdout + said.stderr).replace("\n", " ")
            if last.name not in told or "the one of step 30 is taken" not in told:
                fail(f"damage {number}, {kind}: not told\n{told}")
            same(whole, hurt, f"damage {number}, {kind}")
        return f"{options.damages} damaged checkpoints: all named, the one before taken, 0 bytes differ"

    def ledger(self, _options):
        told = []
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
                    fail(f"ledger: {name}: masses of a particle differ: {each}")
            if not ledger["balances"]:
                fail(f"ledger: {name}: does not balance: {ledger}")
            told.append(
                f"{name} to {facts['time']:.3g} s: {ledger['entered']} in, {ledger['entered_back']} back, "
                f"{ledger['left']} out, {ledger['left_back']} back, {len(rows)} rows"
            )
        return "ledger: counts exact, mass to 1e-12; " + "; ".join(told)


PARTS = [Driver.threads, Driver.restarts, Driver.kills, Driver.signals, Driver.disks, Driver.damages, Driver.ledger]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    names = [part.__name__ for part in PARTS]
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="PART", help="these parts")
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--signals", type=int, default=50)
    parser.add_argument("--disks", type=int, default=20)
    parser.add_argument("--damages", type=int, default=700)
    parser.add_argument("--sphecs", type=Path, default=ROOT / "target/debug/sphecs", help="the program")
    options = parser.parse_args()
    for part in PARTS:
        if part.__name__ in options.only:
            with tempfile.TemporaryDirectory() as work:
                print(part(Driver(options.sphecs.resolve(), work), options), flush=True)


if __name__ == "__main__":
    main()
