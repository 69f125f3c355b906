#!/usr/bin/env bash
# Runs scenes on several MPI processes and compares every result with that of one process, byte by byte.
#
#   scripts/mpi.sh mpich [SCENE…]
#   scripts/mpi.sh openmpi [SCENE…]       # default: quickstart duct3d stirrer
#
# Installs that MPI if it is missing, and ends without a test where it cannot. Each scene runs on 2, 3 and 4 processes
# of one thread, is stopped, and resumes on another number of processes. A process that dies must end all within 10 s,
# and the run must resume.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh

case "${1:-}" in
mpich) packages=(mpich libmpich-dev) ;;
openmpi) packages=(openmpi-bin libopenmpi-dev) ;;
*) echo "usage: scripts/mpi.sh mpich|openmpi [SCENE…]" >&2; exit 2 ;;
esac
export MPICC=mpicc.$1
mpirun=mpirun.$1
shift
scenes=("$@")
[ ${#scenes[@]} -gt 0 ] || scenes=(quickstart duct3d stirrer)

if ! command -v "$MPICC" >/dev/null || ! command -v "$mpirun" >/dev/null; then
    say "installing ${packages[0]}"
    install_packages "${packages[@]}" || { say "no MPI here: ranks on several machines are not tested"; exit 0; }
fi
if ! ls /usr/lib/llvm-*/lib/libclang*.so* >/dev/null 2>&1 && [ -z "${LIBCLANG_PATH:-}" ]; then
    say "installing libclang"
    install_packages libclang-dev || { say "no libclang here: ranks on several machines are not tested"; exit 0; }
fi

say "building with the feature mpi"
# The bindings are those of one MPI.
cargo clean --quiet --locked -p mpi-sys
# As the tests are built, whose libraries it takes. The program is copied: the next build replaces it by one without MPI.
cargo test --workspace --locked --features sphecs/mpi "${FEATURES[@]}" --test cli --no-run --quiet
runs=$(realpath "$(mktemp -d)")
trap 'rm -rf "$runs"' EXIT
sphecs=$runs/sphecs
cp "${CARGO_TARGET_DIR:-target}/debug/sphecs" "$sphecs"

# Processes wait for each other without a core of their own: Open MPI yields, and both keep a time limit.
launch() {
    local count=$1
    shift
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 \
        OMPI_MCA_mpi_yield_when_idle=1 OMPI_MCA_hwloc_base_binding_policy=none \
        timeout 300 "$mpirun" -n "$count" "$@"
}
flow() {
    launch "$1" "$sphecs" "${@:2}" --threads 1 --quiet
}
if ! launch 2 true >/dev/null 2>&1; then
    say "$mpirun starts no processes here: ranks on several machines are not tested"
    exit 0
fi

# Fails unless two runs have the same bytes in every file that depends on the flow alone.
same() {
    local file name
    for file in "$1"/*.nc "$1"/*.csv; do
        [ -e "$file" ] || continue
        name=$(basename "$file")
        cmp "$file" "$2/$name"
    done
}

for scene in "${scenes[@]}"; do
    steps=150
    [ "$scene" = duct3d ] && steps=30
    run=("scenes/$scene.ron" --smoke --set output.every=0.013)
    "$sphecs" run "${run[@]}" --steps $steps --threads 2 --quiet --out "$runs/$scene"
    for count in 2 3 4; do
        say "$scene on $count processes"
        out=$runs/$scene-$count
        flow $count run "${run[@]}" --steps $((steps / 3)) --out "$out"
        flow $((5 - count)) resume "$out" --steps $((2 * steps / 3))
        flow $count resume "$out" --steps $steps
        same "$runs/$scene" "$out"
    done
done

say "a process that dies"
out=$runs/killed
flow 3 run scenes/quickstart.ron --smoke --until 1e6 --allow-oversize --checkpoint-every 1s --out "$out" \
    >/dev/null 2>&1 &
launcher=$!
for _ in $(seq 600); do
    ls "$out"/checkpoints/*.checkpoint >/dev/null 2>&1 && break
    sleep 0.2
done
# The newest of the processes with this program.
victim=$(for process in /proc/[0-9]*; do
    if [ "$(readlink "$process/exe" 2>/dev/null)" = "$sphecs" ]; then basename "$process"; fi
done | sort -n | tail -1)
kill -KILL "$victim"
started=$SECONDS
wait $launcher && { echo "the launcher reports no failure" >&2; exit 1; }
[ $((SECONDS - started)) -le 10 ] || { echo "the others ended after $((SECONDS - started)) s" >&2; exit 1; }
code=0
flow 2 resume "$out" --until 1e6 --max-walltime 2s || code=$?
[ "$code" -eq 75 ] || { echo "the killed run was not resumed: code $code" >&2; exit 1; }
say "the results on several processes are those of one"
