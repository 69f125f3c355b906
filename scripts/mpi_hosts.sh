#!/usr/bin/env bash
# Runs a scene on two processes of one machine over shared memory, and on two that are joined by a network only, and
# compares the results byte by byte. The hosts are network namespaces.
#
#   sudo scripts/mpi_hosts.sh [SCENE [STEPS]]       # default: benches/periodic_box.ron 25
#
# Needs iproute2 and a program with the feature `mpi` of MPICH in $SPHECS (default: target/release/sphecs).
set -euo pipefail
cd "$(dirname "$0")/.."
scene=${1:-benches/periodic_box.ron}
steps=${2:-25}
sphecs=$(realpath "${SPHECS:-target/release/sphecs}")
runs=$(mktemp -d)
hosts=(sphecs1 sphecs2)
clean() {
    for host in "${hosts[@]}"; do ip netns del "$host" 2>/dev/null || true; done
    rm -rf "$runs"
}
trap clean EXIT

for host in "${hosts[@]}"; do ip netns add "$host"; done
ip link add wire1 netns sphecs1 type veth peer name wire2 netns sphecs2
for number in 1 2; do
    ip -n "sphecs$number" addr add "10.99.0.$number/24" dev "wire$number"
    ip -n "sphecs$number" link set "wire$number" up
    ip -n "sphecs$number" link set lo up
done

# In place of ssh: starts a command in the namespace of an address.
cat >"$runs/start" <<'START'
#!/bin/sh
while [ "${1#-}" != "$1" ]; do shift; done
number=${1##*.}
shift
exec ip netns exec "sphecs$number" sh -c "$*"
START
chmod +x "$runs/start"

flow=(run "$scene" --steps "$steps" --threads 1)
# UCX would find the shared memory of the two hosts.
network=(-launcher ssh -launcher-exec "$runs/start" -hosts 10.99.0.1,10.99.0.2
    -genv MPIR_CVAR_NOLOCAL 1 -genv UCX_TLS tcp,self)
echo "over shared memory"
mpirun.mpich -n 2 "$sphecs" "${flow[@]}" --out "$runs/memory" | grep '^ *ranks'
echo "over the network"
ip netns exec sphecs1 mpirun.mpich "${network[@]}" -n 2 "$sphecs" "${flow[@]}" --out "$runs/network" | grep '^ *ranks'
sent=$(ip -n sphecs1 -s -j link show wire1 | grep -o '"tx":{"bytes":[0-9]*' | grep -o '[0-9]*$')
echo "$sent bytes left the first host"
for file in "$runs"/memory/*.nc "$runs"/memory/*.csv; do cmp "$file" "$runs/network/$(basename "$file")"; done
echo "the results have the same bytes"
