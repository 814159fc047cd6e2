#!/bin/sh
# Installs the build into a temporary prefix, builds the ten-line consumer against it, runs it on the kept version 1.0 file.
# usage: run.sh BUILD_DIR SOURCE_DIR
set -eu
build=$1 source=$2
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
cmake --install "$build" --prefix "$prefix/install" >/dev/null
cmake -S "$source/tests/consumer" -B "$prefix/build" -DCMAKE_PREFIX_PATH="$prefix/install" >/dev/null
cmake --build "$prefix/build" >/dev/null
"$prefix/build/consumer" "$source"/tests/formats/data/superelement-1.0.cbr.h5 | grep 'modes,.*interface dofs, mass'
