#!/usr/bin/env bash
# Runs every fuzzer (tests/fuzz/README.md) under the address sanitizer, for a fixed number of executions from its seeds.
#
#   tests/run_fuzzers.sh [EXECUTIONS]     of each, 20000 unless given
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
executions=${1:-20000}

cmake --preset asan -DDADRL_FUZZ=ON
cmake --build --preset asan --target dadrl_fuzzers
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for fuzzer in build/asan/bin/fuzz_*; do
  name=$(basename "$fuzzer")
  mkdir "$work/$name"
  echo "== $name: $executions executions"
  "$fuzzer" -runs="$executions" -seed=1 -timeout=20 -artifact_prefix="$PWD/build/asan/$name-" "$work/$name" \
    >"$work/log" 2>&1 || {
    tail -60 "$work/log" >&2
    exit 1
  }
  tail -1 "$work/log"
done
