#!/bin/sh
# Installs the build into a temporary prefix and looks at man pages and completion. Builds the C++ consumer against it; the installed
# programs and the Python package read the superelement that it wrote.
# usage: run.sh BUILD_DIR SOURCE_DIR
set -eu
build=$1 source=$2
python=${PYTHON:-/usr/bin/python3}
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
formats=$(PATH="$prefix/install/bin:$PATH" bash -c '
  source "$1/share/bash-completion/completions/cbr-reduce"
  COMP_WORDS=(cbr-reduce --import ma) COMP_CWORD=2
  _cbr
  echo "${COMPREPLY[@]}"' - "$prefix/install")
test "$formats" = "matrix-market matrix-storage"
# CMake may find the package through a link to lib, as /lib is one to /usr/lib
mkdir "$prefix/merged"
ln -s ../install/lib "$prefix/merged/lib"
# Under the sanitizers all that is linked together has them
flags=$(sed -n 's/^CMAKE_CXX_FLAGS_DEBUG:[^=]*=//p' "$build/CMakeCache.txt" | tr ' ' '\n' | grep '^-fsanitize=' | tr '\n' ' ' || true)
cmake -S "$source/tests/consumer" -B "$prefix/build" -DCMAKE_PREFIX_PATH="$prefix/merged" -DCMAKE_CXX_FLAGS="$flags" >/dev/null
cmake --build "$prefix/build" >/dev/null
rod=$prefix/rod.cbr.h5
"$prefix/build/consumer" "$source"/tests/formats/data/superelement-1.0.cbr.h5 "$rod" >"$prefix/printed"
grep '^[1-9][0-9]* modes,.*interface dofs, mass' "$prefix/printed"
grep '^0 modes, 2 interface dofs, mass 4$' "$prefix/printed"
"$prefix/install/bin/cbr-reduce" --info "$rod" >/dev/null

# The Python package as installed, without pip: two masses of 2 kg and a spring of 1e6 N/m have frequencies 0 and 1000 rad/s
cd "$prefix"
PYTHONPATH=$(echo "$prefix"/install/lib/python3.*/dist-packages) "$python" -B -c '
import math, pathlib, sys
import cbr
assert pathlib.Path(cbr.__file__).is_relative_to(sys.argv[1]), cbr.__file__
low, high = cbr.superelement(sys.argv[2]).frequencies() * 2 * math.pi
assert abs(low) < 1e-3 and abs(high - 1000) < 1e-6, (low, high)' "$prefix/install" "$rod"
env -u PYTHONPATH "$prefix/install/bin/cbr-report" --help | grep -q '^usage: cbr-report'
