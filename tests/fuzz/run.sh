#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# run.sh BUILD MINUTES [TARGET...]: each fuzzer of the build folder for so long, from the corpus of this folder. What it learns is
# kept in BUILD/corpus/TARGET, what it finds in BUILD/findings: replay with BUILD/tests/fuzz/fuzz_replay TARGET FILE. Exit 1 with findings.
set -u
here=$(cd "$(dirname "$0")" && pwd)
build=$1 minutes=$2
shift 2
[ $# -gt 0 ] || set -- scene gmsh exodus med superelement edits program checkpoint
mkdir -p "$build/findings"
# On processors that it does not know OpenBLAS takes kernels that read beyond vectors, which the address sanitizer reports
if grep -qs avx2 /proc/cpuinfo; then export OPENBLAS_CORETYPE="${OPENBLAS_CORETYPE:-Haswell}"; fi
failed=0
for target in "$@"; do
  learnt=$build/corpus/$target
  mkdir -p "$learnt"
  dictionary=
  [ ! -f "$here/$target.dict" ] || dictionary=-dict=$here/$target.dict
  # Leaks are the test suite's matter (tests/lsan.supp): at the end of a fuzzer's life the libraries' own are counted too
  ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 "$build/tests/fuzz/fuzz_$target" -max_total_time=$((minutes * 60)) \
    -timeout=20 -rss_limit_mb=2048 -max_len=32768 $dictionary -artifact_prefix="$build/findings/$target-" \
    -print_final_stats=1 "$learnt" "$here/corpus/$target" > "$build/findings/$target.log" 2>&1
  status=$?
  sed -n "s/^stat::number_of_executed_units: */$target: executions /p" "$build/findings/$target.log"
  if [ $status -ne 0 ]; then
    failed=1
    echo "$target: a finding (exit $status): $build/findings/$target.log"
    grep -m 3 -E "ERROR|SUMMARY|fuzz:|artifact_prefix" "$build/findings/$target.log"
  fi
done
exit $failed
