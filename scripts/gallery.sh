#!/usr/bin/env bash
# Runs the commands of the gallery of the manual and stores their pictures, as `gallery_NAME.png`.
# Commands are the blocks of the page that are marked `sh`; those marked `sh,no-run` take long and draw no picture here.
#
#     scripts/gallery.sh [PROGRAM]
#
# PROGRAM is `target/release/sphecs` unless another one is named.
set -euo pipefail
cd "$(dirname "$0")/.."
program=$(realpath "${1:-target/release/sphecs}")
page=$PWD/docs/book/src/gallery.md
pictures=$PWD/docs/book/src/pictures
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
ln -s "$PWD/scenes" "$scratch/scenes"
ln -s "$program" "$scratch/sphecs"
cd "$scratch"
awk '/^```/ { inside = ($0 == "```sh"); next } inside' "$page" > commands.sh
PATH="$scratch:$PATH" bash -euxo pipefail commands.sh
for picture in *.png; do
    mv "$picture" "$pictures/gallery_$picture"
done
ls -l "$pictures"/gallery_*.png
