#!/usr/bin/env bash
# Builds and checks the manual. The last line is its first page.
set -euo pipefail
cd "$(dirname "$0")/.."
if ! command -v cargo >/dev/null; then
    echo "cargo is not installed: get Rust from https://rustup.rs, then run this again" >&2
    exit 1
fi
# With the features of the whole workspace, so that the dependencies which the tests share are compiled once.
cargo build --quiet --workspace --bin sphecs-manual --locked
"${CARGO_TARGET_DIR:-target}/debug/sphecs-manual" target/book
