#!/usr/bin/env bash
# Sets up what is missing and passes the tests: Rust's, then those of the files as Python reads them.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh

say "cargo test"
cargo test --locked "${FEATURES[@]}"

say "pytest"
make_venv || { echo "no python3 with venv: install python3-venv" >&2; exit 1; }
.venv/bin/pip install --quiet --disable-pip-version-check -r python/requirements.txt
# The program that the tests above were built with.
export SPHECS="${CARGO_TARGET_DIR:-target}/debug/sphecs"
.venv/bin/python -m pytest -q python/tests
