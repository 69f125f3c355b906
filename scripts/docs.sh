#!/usr/bin/env bash
# Builds and checks the manual. The last line is its first page.
set -euo pipefail
cd "$(dirname "$0")/.."
if ! command -v cargo >/dev/null; then
    echo "cargo is not installed: get Rust from https://rustup.rs, then run this again" >&2
    exit 1
fi
cargo run --quiet --package sphecs-manual --locked -- target/book
