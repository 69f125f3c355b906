"""Comparison of sphecs with PySPH on the flow of benches/channel_cylinder.ron: python3 benches/pysph/compare.py

Creates a virtual environment in the folder of --work, installs PySPH and its requirements (requirements.txt), builds
sphecs, runs both and prints speeds, their ratio and the differences of the setups. Needs Python 3.11 or
later, a C++ compiler with OpenMP, cargo and the network; a second call reuses the installation.

Both run the same particles, written by sphecs at t = 0, for the same number of steps of the same mean size. A time is
the fastest of the repetitions, which take turns. That of sphecs is the difference of two runs, one of which ends with
the warm-up; PySPH takes its own time, after compiling and warm-up.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
SCENE = ROOT / "benches" / "channel_cylinder.ron"
REQUIREMENTS = HERE / "requirements.txt"

DIFFERENCES = """\
Differences:
- Precision: PySPH computes in f64; sphecs in f32, as the scene says, and in f64. Positions are f64 in all.
- Integrator: kick-drift-kick with one evaluation of the forces a step in both.
- Time step: sphecs recomputes it at every step, at its own cost; PySPH takes the mean of those steps.
- Walls: pressure from the kernel mean of the fluid's in both; no slip by the distances from the wall's surface in
  sphecs, by the kernel mean of the fluid's velocity, reversed, in PySPH.
- Outlet: wave equation in sphecs; outflow particles keep their velocity and pressure in PySPH.
- Inlet: a given velocity in both; particles come from a reservoir in sphecs, new ones are made in PySPH.
- Viscosity and shifting: the same formulas; sphecs divides the viscosity by the sum's factor on the lattice and limits
  the length of a shift. Tensile control is in sphecs only. Damping of noise is off in both.
- Neighbours: sphecs sorts all particles into cells at every step; PySPH has linked lists and keeps what it finds within
  a step (--cache-nnps, the fastest of its ways that were tried).
- Besides the flow, sphecs counts every particle, checks for divergence and records integral figures at every step.
- Compiler: PySPH compiles with -O3, its default; sphecs chooses its instructions at run time."""


class Failure(Exception):
    """A condition that the user has to correct."""


@dataclass
class Measurement:
    """One code on one number of threads."""

    code: str
    threads: int
    particles: int = 0
    seconds: list[float] = field(default_factory=list)
    seconds_of_warm_up: list[float] = field(default_factory=list)

    def fastest(self) -> float:
        """Seconds for the timed steps; the subtracted runs are the fastest, too."""
        return min(self.seconds) - min(self.seconds_of_warm_up, default=0.0)


def run(command: Sequence[object], log: Path, what: str, environment: dict[str, str] | None = None) -> str:
    """Returns the output of a command, which is also written to a file."""
    text = [str(part) for part in command]
    result = subprocess.run(text, capture_output=True, text=True, env={**os.environ, **(environment or {})})
    log.write_text(result.stdout + result.stderr)
    if result.returncode != 0:
        end = "\n".join(log.read_text().splitlines()[-15:])
        raise Failure(f"{what}: `{' '.join(text)}` ended with code {result.returncode}, see {log}\n{end}")
    return result.stdout


def say(text: str) -> None:
    """Prints progress at once, separately from the table."""
    print(f"== {text}", file=sys.stderr, flush=True)


def installed(work: Path) -> Path:
    """The Python of a virtual environment with PySPH, created if it does not exist."""
    folder = work / "venv"
    python = folder / "bin" / "python"
    stamp = folder / "requirements.txt"
    if stamp.exists() and stamp.read_text() == REQUIREMENTS.read_text():
        return python
    if sys.version_info < (3, 11):
        raise Failure(f"this is Python {sys.version.split()[0]}: the pinned versions need 3.11 or later")
    compiler = os.environ.get("CXX", "c++")
    if shutil.which(compiler.split()[0]) is None:
        raise Failure(f"no C++ compiler `{compiler}`: install one (Debian: g++ and python3-dev), or name it in CXX")
    say(f"installing PySPH into {folder}, some minutes")
    run([sys.executable, "-m", "venv", "--clear", folder], work / "venv.log", "no virtual environment")
    # The pins also apply to pip's build environments: older versions of pip read the first, newer the second.
    pinned = {"PIP_CONSTRAINT": str(REQUIREMENTS), "PIP_BUILD_CONSTRAINT": str(REQUIREMENTS)}
    pip = [python, "-m", "pip", "install", "--disable-pip-version-check", "-r", REQUIREMENTS]
    run(pip, work / "pip.log", "PySPH was not installed (compiler? network?)", pinned)
    shutil.copy(REQUIREMENTS, stamp)
    return python


def built(work: Path) -> Path:
    """The binary of sphecs, built from this repository."""
    if shutil.which("cargo") is None:
        raise Failure("no cargo: get Rust from https://rustup.rs, or give a binary of sphecs with --sphecs")
    say("building sphecs")
    target = ROOT / "target"
    command = ["cargo", "build", "--release", "--locked"]
    command += ["--manifest-path", str(ROOT / "Cargo.toml"), "--target-dir", str(target)]
    run(command, work / "cargo.log", "sphecs was not built (scripts/test.sh sets up what is missing)")
    return target / "release" / "sphecs"


def run_sphecs(sphecs: Path, folder: Path, precision: str, threads: int, steps: int) -> dict[str, Any]:
    """The summary of a run from the start of the scene."""
    command: list[object] = [sphecs, "run", SCENE, "--quiet", "--force", "--out", folder]
    command += ["--set", f"precision={precision}", "--threads", str(threads), "--steps", str(steps)]
    run(command, folder.with_suffix(".log"), "sphecs failed")
    summary: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    if summary["steps"] != steps:
        raise Failure(f"sphecs did {summary['steps']} steps, not {steps}: the scene ends before, take fewer --steps")
    return summary


def measure_sphecs(
    measurement: Measurement, sphecs: Path, folder: Path, precision: str, warm_up: int, steps: int
) -> dict[str, Any]:
    """One repetition: a run to the end and one to the end of the warm-up."""
    threads = measurement.threads
    start = run_sphecs(sphecs, folder.with_name(f"{folder.name}_start"), precision, threads, warm_up)
    summary = run_sphecs(sphecs, folder, precision, threads, warm_up + steps)
    measurement.seconds_of_warm_up.append(start["wall_time"])
    measurement.seconds.append(summary["wall_time"])
    ledger = summary["ledger"]
    measurement.particles = sum(ledger[zone] for zone in ("fluid", "wall", "inflow", "outflow"))
    return summary


def measure_pysph(
    measurement: Measurement, python: Path, particles: Path, time_step: float, work: Path, warm_up: int, steps: int
) -> dict[str, Any]:
    """One repetition."""
    # PySPH keeps settings and compiled code in $HOME. Busy-waiting threads would stall it while other
    # work uses a core.
    environment = {
        "HOME": str(work / "pysph_user"),
        "OMP_NUM_THREADS": str(measurement.threads),
        "OMP_WAIT_POLICY": "passive",
    }
    command: list[object] = [python, HERE / "channel_cylinder.py", particles, "--time-step", repr(time_step)]
    command += ["--warm-up", str(warm_up), "--steps", str(steps), "--out", work / "pysph", "--cache-nnps"]
    output = run(command, work / "pysph.log", "PySPH failed", environment)
    result: dict[str, Any] = json.loads(output.splitlines()[-1])
    measurement.seconds.append(result["seconds"])
    measurement.particles = result["particles"]
    return result


def compare(options: argparse.Namespace, work: Path) -> None:
    """Installs, runs in turn, prints."""
    python = installed(work)
    sphecs = options.sphecs or built(work)
    (work / "pysph_user").mkdir(exist_ok=True)
    load_before = os.getloadavg()[0]

    rows: list[Measurement] = []
    for threads in options.threads:
        single, double = Measurement("sphecs f32", threads), Measurement("sphecs f64", threads)
        pysph = Measurement("PySPH f64", threads)
        rows += [single, double, pysph]
        for repeat in range(options.repeats):
            say(f"threads: {threads}, repetition {repeat + 1} of {options.repeats}")
            measure_sphecs(single, sphecs, work / "sphecs_f32", "F32", options.warm_up, options.steps)
            folder = work / "sphecs_f64"
            summary = measure_sphecs(double, sphecs, folder, "F64", options.warm_up, options.steps)
            time_step = summary["time"] / summary["steps"]
            result = measure_pysph(
                pysph, python, folder / "particles.nc", time_step, work, options.warm_up, options.steps
            )

    total = options.warm_up + options.steps
    print(f"{total} steps of {time_step:.4g} s in the mean, the first {options.warm_up} not timed.")
    print(f"Fastest of {options.repeats}. Load average {load_before:.1f} before, {os.getloadavg()[0]:.1f} after.\n")
    print_table(rows, options.steps)
    print("\n| fluid after the last step | particles | mean u, m/s | largest speed, m/s | rms of v, m/s |")
    print("|---|---|---|---|---|")
    for code, key in (("sphecs f64", "sphecs"), ("PySPH f64", "pysph")):
        flow = result[key]
        print(
            f"| {code} | {flow['fluid']} | {flow['mean_u']:.5f} | {flow['largest_speed']:.3f} | {flow['rms_v']:.4f} |"
        )
    print(f"\n{DIFFERENCES}")


def print_table(rows: list[Measurement], steps: int) -> None:
    """Speeds, and the ratio of each to PySPH's on as many threads."""
    print("| threads | | steps | particles | s a step | million particle-steps/s | sphecs/PySPH |")
    print("|---|---|---|---|---|---|---|")
    speeds = {(row.threads, row.code): row.particles * steps / row.fastest() for row in rows}
    for row in rows:
        speed = speeds[row.threads, row.code]
        ratio = f"{speed / speeds[row.threads, 'PySPH f64']:.1f}" if row.code.startswith("sphecs") else ""
        print(
            f"| {row.threads} | {row.code} | {steps} | {row.particles} | {row.fastest() / steps:.4f} "
            f"| {speed / 1e6:.2f} | {ratio} |"
        )


def positive(text: str) -> int:
    """Parses a positive number of items."""
    number = int(text)
    if number < 1:
        raise ValueError
    return number


def numbers(text: str) -> list[int]:
    """Parses a comma-separated list of positive numbers."""
    return [positive(part) for part in text.split(",")]


def main() -> int:
    """Exit code: 0, or 1 for a failure, which is reported on standard error."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = Path(tempfile.gettempdir()) / "sphecs_beside_pysph"
    parser.add_argument("--work", type=Path, default=default, help="folder for everything that is made (%(default)s)")
    parser.add_argument("--sphecs", type=Path, help="a binary of sphecs, in place of building one")
    parser.add_argument("--threads", type=numbers, default=[1, 2], help="numbers of threads (1,2)")
    parser.add_argument("--steps", type=positive, default=150, help="steps that are timed (%(default)s)")
    parser.add_argument("--warm-up", type=positive, default=20, help="steps before them (%(default)s)")
    parser.add_argument("--repeats", type=positive, default=3, help="repetitions, the fastest counts (%(default)s)")
    options = parser.parse_args()
    try:
        if options.sphecs:
            options.sphecs = options.sphecs.resolve()
            if not os.access(options.sphecs, os.X_OK):
                raise Failure(f"{options.sphecs}: no program there, --sphecs must be a binary of sphecs")
        work = options.work.resolve()
        work.mkdir(parents=True, exist_ok=True)
        compare(options, work)
    except (Failure, OSError) as failure:
        print(f"error: {failure}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
