#!/bin/sh
# The pipeline gives the same results, every dataset byte for byte, as the three separate calls.
# usage: pipeline_test.sh BIN_DIR SOURCE_DIR
set -eu
bin=$1 source=$2
python=${PYTHON:-/usr/bin/python3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for way in calls pipe; do
  mkdir "$work/$way"
  gmsh -3 -v 1 "$source/meshes/block.geo" -setnumber nx 10 -setnumber ny 5 -setnumber nz 8 -o "$work/$way/block.msh"
  sed -e 's/modes: 80/modes: 20/' "$source/tests/cases/block-impact/impact.yaml" > "$work/$way/impact.yaml"
  echo 'skin: {surfaces: [contact], youngs_modulus: 0, poissons_ratio: 0.3, density: 0, thickness: 2.5e-4, mesh: skinned.msh}' >> "$work/$way/impact.yaml"
done

cd "$work/calls"
"$bin/cbr-reduce" -q impact.yaml > /dev/null
"$bin/cbr-skin" -q impact.yaml > /dev/null
"$bin/cbr-dyn" -q impact.yaml -o results.h5
cd "$work/pipe"
"$bin/cbr-reduce" -q impact.yaml | "$bin/cbr-skin" -q - | "$bin/cbr-dyn" -q - -o results.h5

cmp "$work/calls/block.cbr.h5" "$work/pipe/block.cbr.h5"
cmp "$work/calls/skinned.msh" "$work/pipe/skinned.msh"
"$python" "$source/tests/cases/results.py" "$work/calls/results.h5" "$work/pipe/results.h5"
