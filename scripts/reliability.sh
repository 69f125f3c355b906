#!/usr/bin/env bash
# The long version of tests/resume.rs: every shipped scene stopped at three steps and resumed, then one run killed again and again.
# Fails at the first byte that differs from a run without a break. Figures of it stand in docs/RELIABILITY.md.
#
#   scripts/reliability.sh [KILLS]      200 kills if no number is given; SPHECS names another program than target/debug/sphecs
set -euo pipefail
cd "$(dirname "$0")/.."

kills_wanted="${1:-200}"
sphecs="${SPHECS:-target/debug/sphecs}"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

results=(particles.nc monitor.nc monitor.csv probes.nc probes.csv)

# Frames and rows every few steps, whatever the scene's time step: 200 steps to a time found by a first short run.
rhythm() {
    local time
    "$sphecs" run "$1" --smoke --quiet --steps 20 --out "$work/rhythm" --force
    time="$(sed -n 's/^  "time": \(.*\),$/\1/p' "$work/rhythm/summary.json")"
    awk -v t="$time" 'BEGIN { printf "--set output.every=%.6e --set output.monitor_every=%.6e", 1.3 * t, 0.37 * t }'
}

compare() {
    local name left
    for name in "${results[@]}"; do
        if [ -e "$1/$name" ] || [ -e "$2/$name" ]; then
            cmp "$1/$name" "$2/$name" || { echo "$3: $name differs" >&2; exit 1; }
        fi
    done
    left="$(find "$2" -name '*.partial' -o -name 'journal*')"
    [ -z "$left" ] || { echo "$3: left over: $left" >&2; exit 1; }
}

restarts=0
for scene in scenes/*.ron; do
    # shellcheck disable=SC2046
    set -- $(rhythm "$scene")
    "$sphecs" run "$scene" --smoke --quiet "$@" --steps 200 --threads 2 --out "$work/whole" --force
    for cut in 37 101 163; do
        "$sphecs" run "$scene" --smoke --quiet "$@" --steps "$cut" --threads 1 --out "$work/pieces" --force
        "$sphecs" resume "$work/pieces" --quiet --steps 200 --threads 3
        compare "$work/whole" "$work/pieces" "$scene cut at step $cut"
        restarts=$((restarts + 1))
    done
done
echo "restarts: $restarts, bytes that differ: 0"

# shellcheck disable=SC2046
set -- $(rhythm scenes/quickstart.ron)
run=("$sphecs" run scenes/quickstart.ron --smoke --quiet "$@" --steps 2000)
"${run[@]}" --out "$work/whole" --force
kills=0
ends=0
while [ "$kills" -lt "$kills_wanted" ]; do
    rm -rf "$work/killed"
    while :; do
        if [ -d "$work/killed" ]; then
            "$sphecs" resume "$work/killed" --quiet --checkpoint-every 0.1s &
        else
            "${run[@]}" --out "$work/killed" --checkpoint-every 0.1s &
        fi
        process=$!
        sleep "$(awk -v r="$RANDOM" 'BEGIN { printf "%.3f", 0.02 + 0.9 * r / 32768 }')"
        if kill -9 "$process" 2>/dev/null; then
            if wait "$process"; then break; fi
            kills=$((kills + 1))
        else
            wait "$process"
            break
        fi
        # What is there can be read at any moment.
        [ ! -d "$work/killed" ] || "$sphecs" info "$work/killed" >/dev/null
    done
    compare "$work/whole" "$work/killed" "after $kills kills"
    ends=$((ends + 1))
done
echo "kills: $kills in $ends runs, bytes that differ at their ends: 0"
