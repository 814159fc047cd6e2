#!/bin/sh
# Installs the build into a temporary prefix, builds the ten-line consumer against it, runs it on the kept version 1.0 file.
# usage: run.sh BUILD_DIR SOURCE_DIR
set -eu
build=$1 source=$2
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
cmake --install "$build" --prefix "$prefix/install" >/dev/null
# Under the sanitizers all that is linked together has them
flags=$(sed -n 's/^CMAKE_CXX_FLAGS_DEBUG:[^=]*=//p' "$build/CMakeCache.txt" | tr ' ' '\n' | grep '^-fsanitize=' | tr '\n' ' ' || true)
cmake -S "$source/tests/consumer" -B "$prefix/build" -DCMAKE_PREFIX_PATH="$prefix/install" -DCMAKE_CXX_FLAGS="$flags" >/dev/null
cmake --build "$prefix/build" >/dev/null
"$prefix/build/consumer" "$source"/tests/formats/data/superelement-1.0.cbr.h5 | grep 'modes,.*interface dofs, mass'
