#!/usr/bin/env bash
# Installs what is missing, runs the constricted channel and draws its speed.
# Options go to the run: `./scripts/demo.sh --smoke` is coarse, `./scripts/demo.sh --until 1` is short.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh

say "building"
cargo build --release --locked "${FEATURES[@]}"

# A separate folder, so that `--force` replaces no run of the user.
run=runs/demo
target/release/sphecs run scenes/constricted_r2.ron --out "$run" --force "$@"
target/release/sphecs render "$run" --field speed --output "$run/speed.png"
say "the picture is $run/speed.png"
