#!/usr/bin/env bash
# Installs what is missing and runs the tests: those in Rust, those of the result files and of the package in Python, and
# the commands of the tutorials.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh

say "cargo test"
cargo test --workspace --locked "${FEATURES[@]}"

say "pytest"
make_venv || { echo "no python3 with venv: install python3-venv" >&2; exit 1; }
.venv/bin/pip install --quiet --disable-pip-version-check -r python/requirements.txt
# For the test of the page that `sphecs watch --serve` shows; it is skipped where there is no browser.
command -v chromium-headless-shell >/dev/null || command -v chromium >/dev/null || install_packages chromium-headless-shell ||
    say "no headless browser: the page of \`sphecs watch\` is not tested"
# The Python package, with the library that the tests above built.
site=$(.venv/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
rm -rf "$site/sphecs"
cp -r python/src/sphecs "$site/"
ln -sf "$(realpath "${CARGO_TARGET_DIR:-target}")/debug/deps/libsphecs_python.so" "$site/sphecs/_sphecs.abi3.so"
# The program that the tests above built.
export SPHECS="${CARGO_TARGET_DIR:-target}/debug/sphecs"
.venv/bin/python -m pytest -q python/tests

say "tutorials"
python3 scripts/tutorials.py --python .venv/bin/python
