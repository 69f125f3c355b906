#!/usr/bin/env bash
# Sets up what is missing, runs the constricted channel to its end and draws its speed.
# Options go to the run: `./scripts/demo.sh --smoke` is a quick look, `./scripts/demo.sh --until 1` a short one.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh

say "building"
cargo build --release --locked "${FEATURES[@]}"

# A folder of the demonstration's own, so that `--force` replaces no run of the user's.
run=runs/demo
target/release/sphecs run scenes/constricted_r2.ron --out "$run" --force "$@"
target/release/sphecs render "$run" --field speed --output "$run/speed.png"
say "the picture is $run/speed.png"
