#!/usr/bin/env python3
"""Runs the commands of the tutorials of the manual, coarsely.

    python3 scripts/tutorials.py [--sphecs PROGRAM] [--python PYTHON] [--threads N] [PAGE ...]

Commands are the lines of blocks marked `sh` that begin with `sphecs`; runs are made at smoke spacing. Every page
has a scratch folder with the scenes, tables and programs that lie beside the pages, and the folder `scenes` of the
repository. Blocks marked `sh,no-run` are left out, as are lines of other programs.

With `--python` the blocks marked `python` run as well, with an interpreter that has the packages they import. A block
is a program of its own unless it is marked `python,continued`.

PROGRAM is `target/debug/sphecs` unless `--sphecs` or the variable SPHECS names another one. PAGE is a name such as
`cylinder`; without it all pages run. Exit code: 0, or 1 if a command fails, a page has none, or a scene does not exist.
"""

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGES = ROOT / "docs" / "book" / "src" / "tutorials"

# Words after `sphecs` that are commands; any other word is a scene, which runs.
COMMANDS = {"run", "resume", "check", "render", "info", "export", "pack", "bench", "validate", "help"}
COMMANDS |= {"schema", "explain", "new", "completions", "man", "plot", "sweep", "watch"}

FENCE = re.compile(r"^\s*```\s*(\S*)\s*$")


def blocks(text):
    """Yields the mark, the number of the first line and the lines of each block of code."""
    mark, first, lines = None, 0, []
    for number, line in enumerate(text.splitlines(), 1):
        fence = FENCE.match(line)
        if fence and mark is None:
            mark, first, lines = fence.group(1), number + 1, []
        elif fence:
            yield mark, first, lines
            mark = None
        elif mark is not None:
            lines.append(line)


def commands(lines, first):
    """Yields the number and the text of each command of `sphecs`; a line that ends in `\\` continues."""
    whole, start = "", first
    for number, line in enumerate(lines, first):
        if not whole:
            start = number
        whole += line.strip()
        if whole.endswith("\\"):
            whole = whole[:-1]
            continue
        if whole.split(maxsplit=1)[:1] == ["sphecs"]:
            yield start, whole
        whole = ""


def coarse(words, program, threads):
    """Returns the arguments of a command of `sphecs`, with those of a coarse run added."""
    arguments = [program, *words[1:]]
    command = words[1] if len(words) > 1 else "help"
    runs = command not in COMMANDS and not command.startswith("-")
    if runs or command == "run":
        arguments.append("--smoke")
    if runs or command in {"run", "resume"}:
        arguments.append("--quiet")
        if threads:
            arguments += ["--threads", str(threads)]
    return arguments


def prepare(scratch):
    """Fills a scratch folder with what a reader of the page has."""
    for file in PAGES.iterdir():
        if file.suffix in {".ron", ".csv", ".py"}:
            shutil.copy(file, scratch)
    (scratch / "scenes").symlink_to(ROOT / "scenes", target_is_directory=True)


def run(arguments, scratch, place, shown):
    """Runs a command; returns whether it succeeded."""
    begin = time.monotonic()
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    done = subprocess.run(arguments, cwd=scratch, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True)
    seconds = time.monotonic() - begin
    print(f"  {'ok    ' if done.returncode == 0 else 'FAILED'} {seconds:5.1f} s  {shown}", flush=True)
    if done.returncode != 0:
        print(f"{place}: exit code {done.returncode}:\n{done.stdout}", flush=True)
    return done.returncode == 0


def try_page(page, options):
    """Runs the commands of a page; returns the number of faults."""
    place = page.relative_to(ROOT)
    print(place, flush=True)
    faults, ran, script = 0, 0, ""
    with tempfile.TemporaryDirectory(prefix="sphecs-tutorial-") as folder:
        scratch = Path(folder)
        prepare(scratch)
        for mark, first, lines in blocks(page.read_text(encoding="utf-8")):
            if mark == "sh":
                for number, command in commands(lines, first):
                    arguments = coarse(shlex.split(command), options.sphecs, options.threads)
                    ran += 1
                    faults += not run(arguments, scratch, f"{place}:{number}", command)
            elif options.python and mark in {"python", "python,continued"}:
                script = (script if "," in mark else "") + "\n".join(lines) + "\n"
                faults += not run([options.python, "-c", script], scratch, f"{place}:{first}", f"python, line {first}")
    if ran == 0:
        print(f"{place}: no command of sphecs in a block marked `sh`", flush=True)
        faults += 1
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sphecs", default=os.environ.get("SPHECS", str(ROOT / "target" / "debug" / "sphecs")))
    parser.add_argument("--python", help="interpreter for the blocks marked `python`")
    parser.add_argument("--threads", type=int, help="threads of a run, all cores by default")
    parser.add_argument("pages", nargs="*", metavar="PAGE", help="name of a page, all by default")
    options = parser.parse_args()
    program = shutil.which(options.sphecs)
    if program is None:
        sys.exit(f"{options.sphecs}: no such program: build it by `cargo build`, or name it by --sphecs")
    options.sphecs = os.path.abspath(program)
    if options.python:
        # Not resolved: the interpreter of a virtual environment is a link.
        options.python = os.path.abspath(shutil.which(options.python) or options.python)
    pages = sorted(PAGES.glob("*.md"))
    if options.pages:
        unknown = set(options.pages) - {page.stem for page in pages}
        if unknown:
            sys.exit(f"no such page: {', '.join(sorted(unknown))}; pages: {', '.join(page.stem for page in pages)}")
        pages = [page for page in pages if page.stem in options.pages]
    begin = time.monotonic()
    faults = sum(try_page(page, options) for page in pages)
    print(f"{len(pages)} pages, {faults} faults, {time.monotonic() - begin:.0f} s")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
