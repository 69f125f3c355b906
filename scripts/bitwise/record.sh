#!/usr/bin/env bash
# Records what a build of sphecs computes, as a manifest of SHA-256 sums, so that two builds can be
# compared bit by bit.
#
# What it is for
#   A change that moves code, renames things or makes the program faster must not change a result.
#   Record a manifest with the program from before the change and one with the program from after
#   it, both on the same machine, and compare them:
#
#       scripts/bitwise/record.sh path/to/old/sphecs before.tsv
#       scripts/bitwise/record.sh target/release/sphecs after.tsv
#       python3 scripts/bitwise/compare.py before.tsv after.tsv
#
#   compare.py names every result that differs and ends with code 1 if there is one.
#
# What is run
#   Without --quick: every scene of scenes/ and the cases of `sphecs bench` at the smoke spacing
#   for 300 steps (boxes with fewer particles; the ducts in 3D and the 3D boxes for 60 to 150
#   steps: see cases.py), with both schemes, in F32 and F64, with every instruction set of the
#   machine, on two threads; and all small flows of --quick in both precisions with every set.
#   --quick: 373 runs of few steps that reach every part of the engine: schemes, kernels,
#   viscosities, noise damping, shiftings, integrators, wall models and slip conditions, inlets,
#   outlet conditions, reservoir, bodies, probes, 2D and 3D, F32 and F64, every scene, a flow that
#   diverges, and runs that are resumed. About 2.5 minutes of one core.
#
# How to run it
#   scripts/bitwise/record.sh BINARY MANIFEST [--quick] [--root DIR] [--only TEXT]
#                             [--threads N] [--rename NAME=SPELLING]
#     BINARY     a release build of sphecs
#     MANIFEST   file to write
#     --root     checkout that the scenes are taken from, default the one that this script lies in
#     --only     only the runs whose key contains the text
#     --threads  threads of each run, default 2; the results must not depend on it
#     --rename   NAME=SPELLING: an option, a field or a value of a scene in cases.py that this
#                build spells in another way; repeatable. Renames that stay are made in cases.py.
#
# What is compared
#   Data, not names. Of a checkpoint: the bytes of each particle column, and the numbers of each
#   stored resource in their order. Of each NetCDF file: type, shape and bytes of each numeric
#   variable. Of each CSV file: the rows below the header. Of summary.json: the numbers. The sums
#   of the columns of a file are sorted before they are added up, so that a renamed column changes
#   nothing. Wall-clock times, versions, paths and texts are left out. A run that the program
#   refuses is recorded by its exit code.
#
# Needs python3 with venv; numpy and netCDF4 are installed into .venv of the repository. Set PYTHON
# to use an interpreter that has both.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)

python=${PYTHON:-$root/.venv/bin/python}
if ! "$python" -c 'import netCDF4, numpy' 2>/dev/null; then
    [ -x "$root/.venv/bin/pip" ] || python3 -m venv "$root/.venv" || {
        echo "no python3 with venv: install python3-venv, or set PYTHON to one with numpy and netCDF4" >&2
        exit 1
    }
    # The versions of python/requirements.txt.
    grep -E '^(netCDF4|numpy)' "$root/python/requirements.txt" |
        "$root/.venv/bin/pip" install --quiet --disable-pip-version-check -r /dev/stdin
    python=$root/.venv/bin/python
fi
exec "$python" "$here/record.py" "$@"
