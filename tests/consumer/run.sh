#!/bin/sh
# Installs the build into a temporary prefix, looks at man pages and completion, builds the ten-line consumer against it, runs it on the kept version 1.0 file.
# usage: run.sh BUILD_DIR SOURCE_DIR
set -eu
build=$1 source=$2
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
cmake --install "$build" --prefix "$prefix/install" >/dev/null
# What shells and man look for, made from what --help says
grep -q 'restart FILE' "$prefix/install/share/man/man1/cbr-dyn.1"
options=$(PATH="$prefix/install/bin:$PATH" bash -c '
  source "$1/share/bash-completion/completions/cbr-dyn"
  COMP_WORDS=(cbr-dyn --res) COMP_CWORD=1
  _cbr
  echo "${COMPREPLY[@]}"' - "$prefix/install")
test "$options" = --restart
# Under the sanitizers all that is linked together has them
flags=$(sed -n 's/^CMAKE_CXX_FLAGS_DEBUG:[^=]*=//p' "$build/CMakeCache.txt" | tr ' ' '\n' | grep '^-fsanitize=' | tr '\n' ' ' || true)
cmake -S "$source/tests/consumer" -B "$prefix/build" -DCMAKE_PREFIX_PATH="$prefix/install" -DCMAKE_CXX_FLAGS="$flags" >/dev/null
cmake --build "$prefix/build" >/dev/null
"$prefix/build/consumer" "$source"/tests/formats/data/superelement-1.0.cbr.h5 | grep 'modes,.*interface dofs, mass'
