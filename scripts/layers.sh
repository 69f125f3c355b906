#!/usr/bin/env bash
# Checks that the layers stay free of what they must not depend on, by `cargo tree`.
#
#     ./scripts/layers.sh
set -euo pipefail
cd "$(dirname "$0")/.."

# The crates that PACKAGE depends on, without dependencies of tests and of build scripts.
dependencies() {
    cargo tree --locked --edges normal --prefix none --format '{p}' "$@" | sed 's/ .*//' | sort -u
}

failed=0
# must_not NAME FORBIDDEN… -- CARGO_TREE_OPTIONS…
must_not() {
    local name=$1 forbidden=()
    shift
    while [ "$1" != -- ]; do forbidden+=("$1"); shift; done
    shift
    local found
    found=$(dependencies "$@" | grep -Fx "$(printf '%s\n' "${forbidden[@]}")" || true)
    if [ -n "$found" ]; then
        echo "$name depends on $(echo $found): it must not" >&2
        failed=1
    else
        echo "$name is free of ${forbidden[*]}"
    fi
}

must_not sphecs-core bevy_ecs netcdf clap serde_json miette -- -p sphecs-core
must_not sphecs-scene bevy_ecs netcdf clap -- -p sphecs-scene
must_not sphecs-engine netcdf clap indicatif -- -p sphecs-engine
must_not "the library" clap indicatif -- -p sphecs --no-default-features --features output
must_not "the library without output" netcdf clap indicatif image tiny-skia -- -p sphecs --no-default-features
exit "$failed"
