#!/bin/sh
# run.sh NUMBER: one scene of the sweep, from its parameters to its results. The results appear whole or not at all.
set -eu
cd "$(dirname "$0")"
BIN=${BIN:-../../../build/bin} OUT=${OUT:-out}
./scene.py "$1" > "$OUT/drop-$1.yaml"
"$BIN/cbr-dyn" -q --threads 1 "$OUT/drop-$1.yaml" -o "$OUT/drop-$1.h5"
