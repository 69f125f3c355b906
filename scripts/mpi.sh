#!/usr/bin/env bash
# Runs scenes on several MPI processes and compares every result with that of one process, byte by byte.
#
#   scripts/mpi.sh                          # the MPI of `mpicc` and `mpirun`; installs MPICH if there is none
#   MPICC=mpicc.openmpi MPIRUN=mpirun.openmpi scripts/mpi.sh
#
# Each scene runs on 2, 3 and 4 processes of one thread, is stopped, and resumes on another number of processes.
# A process that dies must end all within 10 s, and the run must resume.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh

export MPICC=${MPICC:-mpicc} MPIRUN=${MPIRUN:-mpirun}
if ! command -v "$MPICC" >/dev/null; then
    say "installing MPICH"
    install_packages mpich libmpich-dev || { say "no MPI here: ranks on several machines are not tested"; exit 0; }
fi
if ! ls /usr/lib/llvm-*/lib/libclang*.so* >/dev/null 2>&1 && [ -z "${LIBCLANG_PATH:-}" ]; then
    say "installing libclang"
    install_packages libclang-dev || { say "no libclang here: ranks on several machines are not tested"; exit 0; }
fi

say "building with the feature mpi"
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
        timeout 300 "$MPIRUN" -n "$count" "$sphecs" "$@" --threads 1 --quiet
}

# Fails unless two runs have the same bytes in every file that depends on the flow alone.
same() {
    local file name
    for file in "$1"/*.nc "$1"/*.csv; do
        [ -e "$file" ] || continue
        name=$(basename "$file")
        cmp "$file" "$2/$name"
    done
}

for scene in quickstart duct3d stirrer; do
    steps=150
    [ "$scene" = duct3d ] && steps=30
    run=("scenes/$scene.ron" --smoke --set output.every=0.013)
    "$sphecs" run "${run[@]}" --steps $steps --threads 2 --quiet --out "$runs/$scene"
    for count in 2 3 4; do
        say "$scene on $count processes"
        out=$runs/$scene-$count
        launch $count run "${run[@]}" --steps $((steps / 3)) --out "$out"
        launch $((5 - count)) resume "$out" --steps $((2 * steps / 3))
        launch $count resume "$out" --steps $steps
        same "$runs/$scene" "$out"
    done
done

say "a process that dies"
out=$runs/killed
launch 3 run scenes/quickstart.ron --smoke --until 1e6 --allow-oversize --checkpoint-every 1s --out "$out" \
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
launch 2 resume "$out" --until 1e6 --max-walltime 2s || code=$?
[ "$code" -eq 75 ] || { echo "the killed run was not resumed: code $code" >&2; exit 1; }
say "the results on several processes are those of one"
