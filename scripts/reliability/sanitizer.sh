#!/usr/bin/env bash
# Runs the unsafe code under AddressSanitizer: unit tests of vectors, packs and passes, then a run that is stopped and
# resumed, on every instruction set. Needs a nightly toolchain. Results are in docs/RELIABILITY.md.
set -euo pipefail
cd "$(dirname "$0")/../.."
target=x86_64-unknown-linux-gnu
export RUSTFLAGS=-Zsanitizer=address
# System libraries keep allocations until the process ends.
export ASAN_OPTIONS=detect_leaks=0
export CARGO_TARGET_DIR=target/sanitizer
# Pointer checks, which the profile disables.
checked=(--config profile.dev.package.sphecs.debug-assertions=true)

cargo +nightly test "${checked[@]}" --locked --target "$target" --lib -- math:: particles:: pass:: physics::
cargo +nightly build "${checked[@]}" --locked --target "$target" --bin sphecs
program="$CARGO_TARGET_DIR/$target/debug/sphecs"
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for lanes in avx512 avx2 portable; do
    for scene in quickstart duct3d cylinder_re20; do
        export SPHECS_LANES=$lanes
        "$program" run "scenes/$scene.ron" --smoke -q --steps 10 --threads 2 --out "$out/$scene-$lanes"
        "$program" resume "$out/$scene-$lanes" -q --steps 20 --threads 3
    done
done
echo "no errors found"
